"""How noisy a picture is: of which pixels, and how two independent halves of its samples tell it."""

from __future__ import annotations

import numpy as np

__all__ = ["relative_error"]


def relative_error(a: np.ndarray, b: np.ndarray, samples: tuple[int, int]) -> float:
    """Return the root mean square error of the mean of two halves, by its mean over the pixels.

    The halves differ by their errors alone, which have variances as 1 / samples: with the shares w of the
    samples, the mean of w_a w_b (a - b)^2 is the variance of w_a a + w_b b.

    So its square is right on average, however the errors are distributed. How far that of one picture is off
    depends on the pixels that have most of the error, and no picture can tell of light that it has not found.
    Of 16 x 16 pixels and 32 samples it scatters by a twentieth under a sky; in the set-up `studio`, where two
    pixels of 88 have 60 % of the mean square, being a small light's glint in one sample of ten, by half,
    from 0.2 to 1.2 for an error of 0.6. Of 64 x 64 pixels of that it scatters by a quarter.

    Parameters
    ----------
    a, b : (n,) array_like
        Means of the samples of each half, of the same pixels.
    samples : (int, int)
        Samples a pixel of each.

    Returns
    -------
    float
        0 where all is black, or there are no pixels; infinite where a value is not finite.
    """
    w_a, w_b = (n / sum(samples) for n in samples)
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        return float("inf")
    if not (a.any() or b.any()):
        return 0.0
    mean = float(np.mean(w_a * a + w_b * b))
    return float(np.sqrt(w_a * w_b * np.mean((a - b) ** 2))) / mean if mean > 0 else float("inf")

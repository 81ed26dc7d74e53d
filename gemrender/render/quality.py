"""How good a picture is to be, in a word: where rendering ends."""

from __future__ import annotations

from enum import StrEnum
from typing import TypedDict

__all__ = ["BEST_NOISE", "BEST_SAMPLES", "DRAFT_SAMPLES", "GOOD_SAMPLES", "Ends", "Quality", "ends_of"]

#: To see how a stone lies and where light falls: a sixteenth of the time of a good picture, four times its
#: noise, which is coarse on a stone and fair on the ground.
DRAFT_SAMPLES = 16
#: The default: in the studio, at a noise of about 3 %, which a glance does not see.
GOOD_SAMPLES = 256
#: For print and for enlarging: at 1 % of the mean, noise is below a step of 8 bits on all but the darkest
#: facets. Studio light is there after some ten times the samples of a good picture.
BEST_NOISE = 0.01
#: Where small lights in the dark, as in the set-up velvet, would go on for days: the end in any case, 16
#: times the time of a good picture, about a third of its noise (7 % instead of 19 %).
BEST_SAMPLES = 4096


class Quality(StrEnum):
    """How good a picture is to be."""

    DRAFT = "draft"
    GOOD = "good"
    BEST = "best"


class Ends(TypedDict):
    """Where rendering ends, whichever comes first; as `render` takes it.

    Samples a pixel, noise as a share of the mean luminance, and time [s]; None for no end.
    """

    spp: int | None
    noise: float | None
    time_limit: float | None


_PRESETS: dict[Quality, tuple[int, float | None]] = {
    Quality.DRAFT: (DRAFT_SAMPLES, None),
    Quality.GOOD: (GOOD_SAMPLES, None),
    Quality.BEST: (BEST_SAMPLES, BEST_NOISE),
}


def ends_of(
    quality: Quality | None = None,
    *,
    spp: int | None = None,
    noise: float | None = None,
    time_limit: float | None = None,
) -> Ends:
    """Return where rendering ends, by a word and by numbers.

    Samples or a noise given in numbers stand in place of the word's. A time stands beside the word's; without
    a word it is the only end. With nothing given it is a good picture.

    Parameters
    ----------
    quality : Quality, optional
        The word; None where none is given.
    spp : int, optional
        Samples a pixel.
    noise : float, optional
        Noise, as a share of the mean luminance.
    time_limit : float, optional
        Time [s].
    """
    given: Ends = {"spp": spp, "noise": noise, "time_limit": time_limit}
    if spp is not None or noise is not None or (quality is None and time_limit is not None):
        return given
    samples, to_noise = _PRESETS[quality or Quality.GOOD]
    return {"spp": samples, "noise": to_noise, "time_limit": time_limit}

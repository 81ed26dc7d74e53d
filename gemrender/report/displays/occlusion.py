"""What hides what in a view of a stone that is not convex: of a convex one no face hides another."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

__all__ = ["is_hidden", "split_by_sight"]

#: Straight pieces that a line between two vertices is cut into, each seen or hidden.
_PIECES = 16
#: What lies behind by less is not hidden: it is the surface itself [stone's unit].
_BEHIND = 1e-6
#: Points tested at a time.
_CHUNK = 512


def is_hidden(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Tell which points lie behind one of the faces.

    Parameters
    ----------
    points : (m, 3) float64
        Right and up on the page, and towards the eye.
    faces : (t, 3, 3) float64
        Corners of triangles that are turned to the eye, likewise.

    Returns
    -------
    (m,) bool
    """
    a, u, w = faces[:, 0], faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]
    area = u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]
    hidden = np.zeros(len(points), dtype=bool)
    for begin in range(0, len(points), _CHUNK):
        some = points[begin : begin + _CHUNK]
        x, y = (some[:, None, k] - a[:, k] for k in range(2))
        s = (x * w[:, 1] - y * w[:, 0]) / area
        t = (u[:, 0] * y - u[:, 1] * x) / area
        depth = a[:, 2] + s * u[:, 2] + t * w[:, 2]
        within = (s > 0) & (t > 0) & (s + t < 1)
        hidden[begin : begin + _CHUNK] = (within & (depth > some[:, 2:] + _BEHIND)).any(axis=1)
    return hidden


def split_by_sight(line: np.ndarray, faces: np.ndarray) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Cut a line (n, 3) where it goes behind one of the faces; return what is seen and what is hidden.

    Parameters and coordinates as for `is_hidden`; the pieces are (k, 2), on the page.
    """
    share = np.arange(_PIECES)[:, None] / _PIECES
    fine = np.concatenate([*(a + share * (b - a) for a, b in pairwise(line)), line[-1:]])
    hidden = is_hidden(0.5 * (fine[:-1] + fine[1:]), faces)
    starts = [0, *(np.flatnonzero(np.diff(hidden)) + 1).tolist(), len(hidden)]
    parts: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
    for start, end in pairwise(starts):
        parts[int(hidden[start])].append(fine[start : end + 1, :2])
    return parts

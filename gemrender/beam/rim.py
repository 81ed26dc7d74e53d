"""The rim of the view, compiled: what no polygon covers, found along lines."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gemrender.beam.compiled import jit, jit_inner

__all__ = ["line_points", "rim_points"]


def rim_points(
    covered: np.ndarray, covered_ends: np.ndarray, wedge: np.ndarray, reach: float, azimuth: float,
    across: np.ndarray, along: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Put a point into each gap that parallel lines have between polygons.

    Parameters
    ----------
    covered : (c, 2) float64
        Corners of convex polygons that do not overlap, one after the other [girdle radius].
    covered_ends : (p,) int64
        Where the corners of each end; some may have none.
    wedge : (k, 3) float64
        Only where a u + b v + c <= 0 for every row (a, b, c).
    reach : float
        Only so far from the middle of the view [girdle radius].
    azimuth : float
        Direction of the lines [rad].
    across, along : (n,) float64
        Distance of each line from the middle, to its left [girdle radius], and the share of its gaps at which
        the points lie.

    Returns
    -------
    points : (m, 2) float64
        Places in the view [girdle radius].
    lengths : (m,) float64
        Length of the gap of each [girdle radius].
    lines : (m,) int64
        The line that each lies on.
    """
    gaps, spans = np.empty((len(covered_ends) + 1, 2)), np.empty((len(covered_ends), 2))
    found = np.empty((4 * len(across) + len(gaps), 4))
    done = n = 0
    while done < len(across):
        n, done = line_points(
            covered, covered_ends, wedge, reach, np.cos(azimuth), np.sin(azimuth), across, along, done, n,
            gaps, spans, found,
        )  # fmt: skip
        if done < len(across):
            found = np.concatenate([found, np.empty_like(found)])
    return found[:n, :2], found[:n, 2], found[:n, 3].astype(np.int64)


@jit
def line_points(
    covered: Any, covered_ends: Any, wedge: Any, reach: float, cos: float, sin: float, across: Any,
    along: Any, done: int, n: int, gaps: Any, spans: Any, found: Any,
) -> Any:  # fmt: skip
    """Go on with `rim_points` after so many lines and points, as far as there is room.

    `found`, (m, 4), is points, lengths and lines; `gaps` and `spans` are room to work in.

    Returns
    -------
    n, done : int
        Points found and lines done.
    """
    for line in range(done, len(across)):
        if n + len(gaps) > len(found):
            return n, line
        n_gaps = _gaps(covered, covered_ends, wedge, reach, cos, sin, across[line], gaps, spans)
        for k in range(n_gaps):
            s = gaps[k, 0] + along[line] * (gaps[k, 1] - gaps[k, 0])
            found[n, 0], found[n, 1] = s * cos - across[line] * sin, s * sin + across[line] * cos
            found[n, 2], found[n, 3] = gaps[k, 1] - gaps[k, 0], line
            n += 1
    return n, len(across)


@jit_inner
def _gaps(
    covered: Any,
    covered_ends: Any,
    wedge: Any,
    reach: float,
    cos: float,
    sin: float,
    across: float,
    gaps: Any,
    spans: Any,
) -> int:
    """Find the parts of a line that no polygon holds, in order; return their number."""
    half = math.sqrt(max(reach * reach - across * across, 0.0))
    first, last = -half, half
    for w in range(len(wedge)):
        slope = wedge[w, 0] * cos + wedge[w, 1] * sin
        value = across * (wedge[w, 1] * cos - wedge[w, 0] * sin) + wedge[w, 2]
        if slope > 0.0:
            last = min(last, -value / slope)
        elif slope < 0.0:
            first = max(first, -value / slope)
        elif value > 0.0:
            last = first
    if last <= first:
        return 0
    n, begin = 0, 0
    for i in range(len(covered_ends)):
        if covered_ends[i] == begin:
            continue
        a, b = _chord(covered, begin, covered_ends[i], cos, sin, across)
        begin = covered_ends[i]
        if b <= a:
            continue
        k = n  # in order
        while k > 0 and spans[k - 1, 0] > a:
            spans[k, 0], spans[k, 1] = spans[k - 1, 0], spans[k - 1, 1]
            k -= 1
        spans[k, 0], spans[k, 1] = a, b
        n += 1
    n_gaps, at = 0, first
    for k in range(n):
        if spans[k, 0] > at + 1e-12:
            gaps[n_gaps, 0], gaps[n_gaps, 1] = at, min(spans[k, 0], last)
            n_gaps += 1
        at = max(at, spans[k, 1])
    if last > at + 1e-12:
        gaps[n_gaps, 0], gaps[n_gaps, 1] = at, last
        n_gaps += 1
    return n_gaps


@jit_inner
def _chord(corners: Any, first: int, end: int, cos: float, sin: float, across: float) -> Any:
    """Return where a line enters and leaves a convex polygon in a list; where it passes by, 1 and -1."""
    enters, leaves, found = 1.0, -1.0, False
    before = end - 1
    for k in range(first, end):
        here = cos * corners[before, 1] - sin * corners[before, 0] - across
        there = cos * corners[k, 1] - sin * corners[k, 0] - across
        if (here <= 0.0) != (there <= 0.0):
            share = here / (here - there)
            s = cos * corners[before, 0] + sin * corners[before, 1]
            s += share * (cos * corners[k, 0] + sin * corners[k, 1] - s)
            enters, leaves = (min(enters, s), max(leaves, s)) if found else (s, s)
            found = True
        before = k
    return enters, leaves

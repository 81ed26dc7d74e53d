"""The rim of the view, compiled: what no polygon covers, found along lines."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.beam.compiled import grown, jit, jit_inner

__all__ = ["rim_points"]


@jit
def rim_points(
    covered: Any, covered_ends: Any, wedge: Any, reach: float, azimuth: float, across: Any, along: Any
) -> Any:
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
    gaps = np.empty((len(covered_ends) + 1, 2))
    points, lengths, n = np.empty((4 * len(across), 2)), np.empty(4 * len(across)), 0
    lines = np.empty(len(lengths), np.int64)
    cos, sin = np.cos(azimuth), np.sin(azimuth)
    for line in range(len(across)):
        n_gaps = _gaps(covered, covered_ends, wedge, reach, cos, sin, across[line], gaps)
        while n + n_gaps > len(lengths):
            points, lengths, lines = grown(points), grown(lengths), grown(lines)
        for k in range(n_gaps):
            s = gaps[k, 0] + along[line] * (gaps[k, 1] - gaps[k, 0])
            points[n, 0], points[n, 1] = s * cos - across[line] * sin, s * sin + across[line] * cos
            lengths[n], lines[n] = gaps[k, 1] - gaps[k, 0], line
            n += 1
    return points[:n], lengths[:n], lines[:n]


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
) -> int:
    """Find the parts of a line that no polygon holds, in order; return their number."""
    half = np.sqrt(max(reach * reach - across * across, 0.0))
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
    spans = np.empty((len(covered_ends), 2))
    n, begin = 0, 0
    for i in range(len(covered_ends)):
        if covered_ends[i] == begin:
            continue
        a, b = _chord(covered[begin : covered_ends[i]], cos, sin, across)
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
def _chord(polygon: Any, cos: float, sin: float, across: float) -> Any:
    """Return where a line enters and leaves a convex polygon; where it passes by, 1 and -1."""
    start, end, found = 1.0, -1.0, False
    n = len(polygon)
    for k in range(n):
        a, b = polygon[k - 1 if k else n - 1], polygon[k]
        here = cos * a[1] - sin * a[0] - across
        there = cos * b[1] - sin * b[0] - across
        if (here <= 0.0) == (there <= 0.0):
            continue
        share = here / (here - there)
        s = cos * (a[0] + share * (b[0] - a[0])) + sin * (a[1] + share * (b[1] - a[1]))
        start, end = (min(start, s), max(end, s)) if found else (s, s)
        found = True
    return start, end

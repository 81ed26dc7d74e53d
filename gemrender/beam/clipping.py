"""Convex polygons, compiled: their area, and what is left of them on one side of a line.

A polygon that is cut lies in one of the first two parts of a `table`, (k, m, 3): of each corner u and v, and
how far it lies beyond the line. What a line leaves of it is written into the other part, and it stays.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.beam.compiled import jit, jit_inner, real

_NOTHING = np.int64(0)

__all__ = ["area", "copy_out", "keep_below"]


@jit
def area(corners: Any, n: int) -> Any:
    """Return the area of a polygon's first n corners, anticlockwise positive (Gauss's formula)."""
    total = corners[0, 0] * 0.0
    for k in range(1, n - 1):
        ax, ay = corners[k, 0] - corners[0, 0], corners[k, 1] - corners[0, 1]
        bx, by = corners[k + 1, 0] - corners[0, 0], corners[k + 1, 1] - corners[0, 1]
        total += ax * by - ay * bx
    return 0.5 * total


@jit_inner
def copy_out(table: Any, half: int, n: int, corners: Any, first: int) -> None:
    """Copy n corners of half a table into a list."""
    for k in range(n):
        corners[first + k, 0], corners[first + k, 1] = table[half, k, 0], table[half, k, 1]


@jit
def keep_below(table: Any, half: int, n: int, a: Any, b: Any, c: Any) -> Any:
    """Keep the part of a convex polygon of n corners where a + b u + c v <= 0.

    Returns
    -------
    half, n : int
        Where in the table it lies, and its number of corners: 0 where nothing is left, one more at the most.
    """
    corners, n_out = table[half], 0
    for k in range(n):
        corners[k, 2] = a + b * corners[k, 0] + c * corners[k, 1]
        if not real(corners[k, 2]) <= 0.0:
            n_out += 1
    if n_out == 0:
        return half, n
    if n_out == n:
        return half, _NOTHING
    kept, m = table[1 - half], 0
    before = n - 1
    for k in range(n):
        here, there = corners[before, 2], corners[k, 2]
        if (real(here) <= 0.0) != (real(there) <= 0.0):
            share = here / (here - there)
            kept[m, 0] = corners[before, 0] + share * (corners[k, 0] - corners[before, 0])
            kept[m, 1] = corners[before, 1] + share * (corners[k, 1] - corners[before, 1])
            m += 1
        if real(there) <= 0.0:
            kept[m, 0], kept[m, 1] = corners[k, 0], corners[k, 1]
            m += 1
        before = k
    return 1 - half, m if m > 2 else _NOTHING

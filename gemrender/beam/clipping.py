"""Convex polygons, compiled: their area, and what is left of them on one side of a line.

A polygon that is cut lies in one of the first two parts of a `table`, (k, m, 3): of each corner u and v, and
how far it lies beyond the line. What a line leaves of it is written into the other part, and it stays.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.core import types
from numba.extending import overload

from gemrender.beam.compiled import STEP, is_dual, jit, jit_inner, real

__all__ = ["SHORT", "area", "copy_out", "far_apart", "keep_below", "opens"]

_NOTHING = np.int64(0)
#: Edges no longer than this may be rounding's [girdle radius]; rounding itself, after some reflections.
SHORT, _ROUNDING = 1e-7, 1e-15
#: Lines that cut at a smaller angle than this are one line, which no corner can be found on.
_LEAST_SLOPE = 1e-6
#: What is as near to a line is on it but for rounding [girdle radius]; and how fast it must leave it to count
#: [girdle radius per unit of the parameter].
_ON_LINE, _MOVES = 1e-12, 1e-5


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
def far_apart(corners: Any, i: int, k: int) -> float:
    """Return how far two corners lie from each other, along u and v together."""
    return float(abs(real(corners[i, 0] - corners[k, 0])) + abs(real(corners[i, 1] - corners[k, 1])))


@jit_inner
def _cut(corners: Any, n: int, before: int, k: int, steep: float, found: Any) -> None:
    """Write the corner where a line cuts an edge, and how it moves.

    In values and derivatives, not as a quotient of complex numbers: where both ends are on the line but for
    rounding, the line's real distance may be less than its imaginary one.

    Where more than two lines run through a point, edges of no length lie between them: rounding decides
    which, and they point anywhere; a corner found on one would move anywhere with the line that cuts it.
    Areas change by the motion of the edges that have a length, the sum of length times normal velocity (what
    opens at the point is of second order). So the corner is to move on the last such edge that is kept, which
    keeps it to that edge's line and to the one that cuts. It is off by the short edge's length then, and else
    by rounding over this length: the smaller of the two is chosen.

    Parameters
    ----------
    corners : (m, 3) complex128
        The polygon's n corners, and how far they lie beyond the line.
    n, before, k : int
        Number of corners; between which of them the line cuts.
    steep : float
        How fast the distance beyond the line grows.
    found : (3,) complex128
        The corner: place in the view with its derivatives.

    Notes
    -----
    Where the edge has a length and lies on the line, the corner moves with the edge: `opens` tells if the
    line does not.
    """
    inside, goes = (before, n - 1) if real(corners[before, 2]) <= 0.0 else (k, 1)
    here, there = corners[before, 2], corners[k, 2]
    value, length = here.real / (here.real - there.real), far_apart(corners, before, k)
    last, ahead = before, k
    if length <= SHORT:
        last, ahead = inside, (inside + goes) % n
        while ahead != before and ahead != k and far_apart(corners, ahead, last) <= SHORT:
            last, ahead = ahead, (ahead + goes) % n
        along, falls = far_apart(corners, ahead, last), abs(corners[ahead, 2].real - corners[last, 2].real)
        is_whole = ahead == before or ahead == k  # all edges are short
        crosses = falls >= _LEAST_SLOPE * steep * along
        is_worse = length * along * abs(here.real - there.real) > _ROUNDING * falls
        if is_whole or is_worse or not crosses:
            last, ahead = before, k
    start, end = corners[last, 2], corners[ahead, 2]
    fall = start.real - end.real
    share = start.real / fall
    moves = 0.0
    if abs(fall) > _ON_LINE * steep * far_apart(corners, last, ahead):
        moves = (start.imag - share * (start.imag - end.imag)) / fall
    for e in range(2):
        p, q = corners[before, e].real, corners[k, e].real
        a, b = corners[last, e], corners[ahead, e]
        by = a.imag + share * (b.imag - a.imag) + moves * (b.real - a.real)
        found[e] = complex(p + value * (q - p), by)


def cut(corners: Any, n: int, before: int, k: int, steep: float, found: Any) -> None:
    """Write the corner where a line cuts an edge; as `_cut` where there are derivatives."""


@overload(cut)
def _cut_of(corners: Any, n: Any, before: Any, k: Any, steep: Any, found: Any) -> Any:
    def dual(corners: Any, n: Any, before: Any, k: Any, steep: Any, found: Any) -> None:
        _cut(corners, n, before, k, steep, found)

    def plain(corners: Any, n: Any, before: Any, k: Any, steep: Any, found: Any) -> None:
        share = corners[before, 2] / (corners[before, 2] - corners[k, 2])
        found[0] = corners[before, 0] + share * (corners[k, 0] - corners[before, 0])
        found[1] = corners[before, 1] + share * (corners[k, 1] - corners[before, 1])

    return dual if isinstance(corners.dtype, types.Complex) else plain


@jit
def opens(corners: Any, n: int, b: Any, c: Any) -> bool:
    """Return whether a line lies on an edge of a polygon of n corners, and moves away from it.

    Then a polygon of no width opens to one side or the other: areas have two derivatives there. Asked after
    `keep_below` has written distances from the line, which grow by b and c; without derivatives there is
    nothing to tell.
    """
    if not is_dual(corners):
        return False
    before, near = n - 1, _ON_LINE * (abs(real(b)) + abs(real(c)))
    for k in range(n):
        here, there = corners[before, 2], corners[k, 2]
        if abs(real(here)) <= near and abs(real(there)) <= near:
            moves = max(abs(here.imag), abs(there.imag)) * _ON_LINE > _MOVES * STEP * near
            if moves and far_apart(corners, before, k) > SHORT:
                return True
        before = k
    return False


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
            cut(corners, n, before, k, abs(real(b)) + abs(real(c)), kept[m])
            m += 1
        if real(there) <= 0.0:
            kept[m, 0], kept[m, 1] = corners[k, 0], corners[k, 1]
            m += 1
        before = k
    return 1 - half, m if m > 2 else _NOTHING

"""Single rays through a convex stone, compiled: what light near a round girdle does.

The same rays as the reference's (`gemrender.reference`), for solids that half-spaces make: the surface that a
ray meets next is the nearest one that it goes out through, or the girdle before that. Rays are followed
side by side, plane after plane, so that each vector instruction serves several of them; a ray that has left
makes room for the next one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from gemrender.beam.compiled import jit_fast, jit_inner, jit_with_arrays
from gemrender.beam.crossing import PARALLEL, into_air, reflected_share
from gemrender.beam.random_numbers import next_random
from gemrender.observation import PATH_CODE_FACTOR, PATH_CODE_MASK, RayStatus
from gemrender.optics.fresnel import LEAST_TOTAL
from gemrender.paths import Paths
from gemrender.stone import Stone

__all__ = [
    "INSIDE",
    "STATUS",
    "Rays",
    "chosen_rays",
    "empty_rays",
    "enter_rays",
    "follow_rays",
    "joined_rays",
    "ray_paths",
]


class Rays(NamedTuple):
    """Rays, in columns of n; where all light is followed, of 2 n: those after n are of later exits.

    There may be some more columns, of nothing.

    numbers : (m, n) float64
        Rows: position [girdle radius] and direction (of a ray that has left, where and in which it did),
        cosines of the angles in air where the ray enters and leaves; where all light is followed, also its
        weight (`Paths`), a factor (1 over the probability of having been chosen), the normal where it enters,
        and the matrix that unfolds its reflections, row by row (of a ray that has left, first
        the normal there, unfolded).
    facts : (6, n) int64
        Rows: `RayStatus`, or `INSIDE` while the ray is followed; reflections, and partial ones; facet of
        entry, and surface of exit (-1 for none); code of the path.
    random : (n,) uint64
        State of each ray's random numbers, never 0; (0,) where only principal light is followed.
    """

    numbers: Any
    facts: Any
    random: Any


#: Status of a ray that is still followed.
INSIDE = -1
#: Rows of `Rays`.
POINT, DIRECTION, COS_ENTRY, COS_EXIT, WEIGHT, FACTOR, NORMAL, UNFOLD = 0, 3, 6, 7, 8, 9, 10, 13
_NUMBERS, _NUMBERS_OF_ALL = 8, 22
STATUS, REFLECTIONS, PARTIAL, ENTRY, EXIT, CODE = range(6)
_FACTS = 6
#: Numbers in a line of the processor's cache.
_LINE = 8

#: Rays side by side, and how many of them one vector instruction takes at the most.
_LANES, _VECTOR = 32, 8
#: The rows of a block of rays inside the stone: position, direction, weight, factor, and the matrix that
#: unfolds; then of the nearest plane so far the gap along its normal and the cosine (their ratio is the
#: distance), and its number; then the surface that they have met (-1 for none), whether it has let them out,
#: with 1 for yes, and its normal.
_X, _Y, _Z, _DX, _DY, _DZ = (row * _LANES for row in range(6))
_WEIGHT, _FACTOR, _UNFOLD = (row * _LANES for row in range(6, 9))
_GAP, _SLOPE, _PLANE, _MET, _OUT, _NX, _NY, _NZ = (row * _LANES for row in range(17, 25))
_ROWS, _STATE, _STATE_OF_ALL = 25, 6, 17
#: The rows of a block of rays that arrive: first, as above, position and direction inside; then place in the
#: view, distances at which the half-spaces begin and end (from the plane through the origin across the view),
#: the surface that they enter through (-1 for those that miss), the cosine of the angle in air, and the
#: normal.
_U, _V, _T_IN, _T_OUT, _ENTRY, _COS, _IN_X, _IN_Y, _IN_Z = (row * _LANES for row in range(6, 15))
_ARRIVING_ROWS = 15

_MISSED, _EXITED = int(RayStatus.MISSED), int(RayStatus.EXITED)
_TRAPPED, _LOST = int(RayStatus.TRAPPED), int(RayStatus.LOST)


def empty_rays(n: int, random: np.ndarray | None = None) -> Rays:
    """Return n rays that have met nothing; for all light, if states of random numbers (n,) are given."""
    if random is None or len(random) < n:
        return _room(_NUMBERS, n, np.empty(0, np.uint64))
    return _room(_NUMBERS_OF_ALL, 2 * n, random)


def _room(rows: int, columns: int, random: np.ndarray) -> Rays:
    """Return empty rays, in rows whose places do not fall on one another in the processor's cache.

    A ray is a column: were rows a power of two apart, those of one ray would drive each other out.
    """
    width = _LINE * (-(-columns // _LINE) | 1)
    return Rays(np.zeros((rows, width)), np.zeros((_FACTS, width), np.int64), random)


def chosen_rays(rays: Rays, columns: np.ndarray) -> Rays:
    """Return copies of some rays that principal light is followed of."""
    out, n = empty_rays(len(columns)), len(columns)
    out.numbers[:, :n], out.facts[:, :n] = rays.numbers[:, columns], rays.facts[:, columns]
    return out


def joined_rays(parts: Sequence[tuple[Rays, int]]) -> Rays:
    """Return rays that have not been followed yet, so many of each part, one part after the other."""
    if len(parts) == 1:
        return parts[0][0]
    out = empty_rays(sum(n for _, n in parts), np.concatenate([rays.random for rays, _ in parts]))
    first = 0
    for rays, n in parts:
        out.numbers[:, first : first + n], out.facts[:, first : first + n] = (
            rays.numbers[:, :n],
            rays.facts[:, :n],
        )
        first += n
    return out


@jit_fast
def _nearest_planes(planes: Any, block: Any, n: int) -> None:
    """Find the plane that each ray of a block meets next.

    Distances are compared as fractions, without a division; four planes at a time, which share the loads.
    """
    for k in range(n):
        block[_GAP + k], block[_SLOPE + k], block[_PLANE + k] = math.inf, 1.0, -1.0
    last = planes.shape[0] - 1
    for a in range(0, planes.shape[0], 4):
        b, c, d = min(a + 1, last), min(a + 2, last), min(a + 3, last)
        ax, ay, az, a_offset, a_number = planes[a, 0], planes[a, 1], planes[a, 2], planes[a, 3], float(a)
        bx, by, bz, b_offset, b_number = planes[b, 0], planes[b, 1], planes[b, 2], planes[b, 3], float(b)
        cx, cy, cz, c_offset, c_number = planes[c, 0], planes[c, 1], planes[c, 2], planes[c, 3], float(c)
        ex, ey, ez, e_offset, e_number = planes[d, 0], planes[d, 1], planes[d, 2], planes[d, 3], float(d)
        for k in range(n):
            x, y, z = block[_X + k], block[_Y + k], block[_Z + k]
            dx, dy, dz = block[_DX + k], block[_DY + k], block[_DZ + k]
            gap, slope, plane = block[_GAP + k], block[_SLOPE + k], block[_PLANE + k]
            a_slope, a_gap = ax * dx + ay * dy + az * dz, a_offset - ax * x - ay * y - az * z
            b_slope, b_gap = bx * dx + by * dy + bz * dz, b_offset - bx * x - by * y - bz * z
            c_slope, c_gap = cx * dx + cy * dy + cz * dz, c_offset - cx * x - cy * y - cz * z
            e_slope, e_gap = ex * dx + ey * dy + ez * dz, e_offset - ex * x - ey * y - ez * z
            closer = (a_slope > PARALLEL) & (a_gap * slope < gap * a_slope)
            gap, slope = a_gap if closer else gap, a_slope if closer else slope
            plane = a_number if closer else plane
            closer = (b_slope > PARALLEL) & (b_gap * slope < gap * b_slope)
            gap, slope = b_gap if closer else gap, b_slope if closer else slope
            plane = b_number if closer else plane
            closer = (c_slope > PARALLEL) & (c_gap * slope < gap * c_slope)
            gap, slope = c_gap if closer else gap, c_slope if closer else slope
            plane = c_number if closer else plane
            closer = (e_slope > PARALLEL) & (e_gap * slope < gap * e_slope)
            block[_GAP + k], block[_SLOPE + k] = e_gap if closer else gap, e_slope if closer else slope
            block[_PLANE + k] = e_number if closer else plane


@jit_fast
def _entries(planes: Any, basis: Any, points: Any, first: int, n: int, arriving: Any) -> None:
    """Find for n rays of a view, from a first one on, where they enter the half-spaces, and where they leave.

    All have one direction, so that the distance to a plane is an affine function of the place in the view.
    """
    dx, dy, dz = -basis[2, 0], -basis[2, 1], -basis[2, 2]
    for k in range(n):
        arriving[_U + k], arriving[_V + k] = points[first + k, 0], points[first + k, 1]
        arriving[_T_IN + k], arriving[_T_OUT + k], arriving[_ENTRY + k] = -math.inf, math.inf, -1.0
    for i in range(planes.shape[0]):
        nx, ny, nz, offset, number = planes[i, 0], planes[i, 1], planes[i, 2], planes[i, 3], float(i)
        by_u = nx * basis[0, 0] + ny * basis[0, 1] + nz * basis[0, 2]
        by_v = nx * basis[1, 0] + ny * basis[1, 1] + nz * basis[1, 2]
        slope = nx * dx + ny * dy + nz * dz
        if slope == 0.0:
            for k in range(n):
                gap = offset - by_u * arriving[_U + k] - by_v * arriving[_V + k]
                arriving[_T_OUT + k] = -math.inf if gap < 0.0 else arriving[_T_OUT + k]
            continue
        t0, tu, tv = offset / slope, by_u / slope, by_v / slope
        if slope > 0.0:
            for k in range(n):
                t = t0 - tu * arriving[_U + k] - tv * arriving[_V + k]
                arriving[_T_OUT + k] = min(arriving[_T_OUT + k], t)
        else:
            for k in range(n):
                t = t0 - tu * arriving[_U + k] - tv * arriving[_V + k]
                later = t > arriving[_T_IN + k]
                arriving[_T_IN + k] = t if later else arriving[_T_IN + k]
                arriving[_ENTRY + k] = number if later else arriving[_ENTRY + k]


@jit_fast
def _enter(planes: Any, is_round: bool, basis: Any, index: float, n: int, arriving: Any) -> None:
    """Refract arriving rays into the stone."""
    dx, dy, dz = -basis[2, 0], -basis[2, 1], -basis[2, 2]
    a = dx * dx + dy * dy
    for k in range(n):
        u, v, t, t_out = arriving[_U + k], arriving[_V + k], arriving[_T_IN + k], arriving[_T_OUT + k]
        entry = int(arriving[_ENTRY + k])
        misses = (t >= t_out) | (entry < 0)
        entry = max(entry, 0)
        nx, ny, nz = planes[entry, 0], planes[entry, 1], planes[entry, 2]
        x = u * basis[0, 0] + v * basis[1, 0]
        y = u * basis[0, 1] + v * basis[1, 1]
        z = u * basis[0, 2] + v * basis[1, 2]
        if is_round:
            outside = (x + t * dx) ** 2 + (y + t * dy) ** 2 > 1.0
            b = x * dx + y * dy
            inner = b * b - a * (x * x + y * y - 1.0)
            t_circle = (-b - math.sqrt(max(inner, 0.0))) / a if a > 0.0 else math.inf
            misses |= outside & ((inner < 0.0) | (t_circle < t) | (t_circle > t_out))
            t = t_circle if outside else t
            nx, ny = (x + t * dx, y + t * dy) if outside else (nx, ny)
            nz = 0.0 if outside else nz
            entry = planes.shape[0] if outside else entry
        x, y, z = x + t * dx, y + t * dy, z + t * dz
        cos_air = -(dx * nx + dy * ny + dz * nz)
        tx, ty, tz = (dx + cos_air * nx) / index, (dy + cos_air * ny) / index, (dz + cos_air * nz) / index
        cos_stone = math.sqrt(1.0 - tx * tx - ty * ty - tz * tz)
        arriving[_X + k], arriving[_Y + k], arriving[_Z + k] = x, y, z
        arriving[_DX + k], arriving[_DY + k] = tx - cos_stone * nx, ty - cos_stone * ny
        arriving[_DZ + k], arriving[_COS + k] = tz - cos_stone * nz, cos_air
        arriving[_IN_X + k], arriving[_IN_Y + k], arriving[_IN_Z + k] = nx, ny, nz
        arriving[_ENTRY + k] = -1.0 if misses else float(entry)


@jit_fast
def _meet(planes: Any, is_round: bool, index: float, n: int, block: Any) -> None:
    """Move rays to the next surface, and turn those that it reflects."""
    for k in range(n):
        x, y, z = block[_X + k], block[_Y + k], block[_Z + k]
        dx, dy, dz = block[_DX + k], block[_DY + k], block[_DZ + k]
        i = int(block[_PLANE + k])
        found = i >= 0
        i = max(i, 0)
        nx, ny, nz, offset = planes[i, 0], planes[i, 1], planes[i, 2], planes[i, 3]
        t = (offset - nx * x - ny * y - nz * z) / (nx * dx + ny * dy + nz * dz)
        surface = float(i)
        if is_round:
            a, b = dx * dx + dy * dy, x * dx + y * dy
            t_circle = (-b + math.sqrt(max(b * b - a * (x * x + y * y - 1.0), 0.0))) / a
            nearer = (a > 0.0) & ((t_circle < t) | (not found))
            t = t_circle if nearer else t
            cx, cy = x + t * dx, y + t * dy
            r = math.sqrt(cx * cx + cy * cy)
            nx, ny, nz = cx / r if nearer else nx, cy / r if nearer else ny, 0.0 if nearer else nz
            surface = float(planes.shape[0]) if nearer else surface
            found |= nearer
        block[_X + k], block[_Y + k], block[_Z + k] = x + t * dx, y + t * dy, z + t * dz
        cos = dx * nx + dy * ny + dz * nz
        reflected = index * index * (1.0 - cos * cos) >= LEAST_TOTAL
        twice = 2.0 * cos if reflected else 0.0
        block[_DX + k], block[_DY + k], block[_DZ + k] = dx - twice * nx, dy - twice * ny, dz - twice * nz
        block[_MET + k] = surface if found else -1.0
        block[_OUT + k] = 0.0 if reflected else 1.0
        block[_NX + k], block[_NY + k], block[_NZ + k] = nx, ny, nz


@jit_fast
def _unfold(n: int, block: Any) -> None:
    """Add the mirror of the surface that each ray has met to the matrix that unfolds its reflections."""
    for row in range(_UNFOLD, _UNFOLD + 9 * _LANES, 3 * _LANES):
        for k in range(n):
            nx, ny, nz = block[_NX + k], block[_NY + k], block[_NZ + k]
            a, b, c = block[row + k], block[row + _LANES + k], block[row + 2 * _LANES + k]
            twice = 2.0 * (a * nx + b * ny + c * nz)
            block[row + k], block[row + _LANES + k] = a - twice * nx, b - twice * ny
            block[row + 2 * _LANES + k] = c - twice * nz


@jit_inner
def _next_code(code: int, facet: int) -> int:
    return (code * PATH_CODE_FACTOR + facet + 1) & PATH_CODE_MASK


@jit_inner
def _leave(index: float, block: Any, k: int, rays: Any, column: int, is_of_all: bool) -> None:
    """Write a ray that leaves the stone through the surface that it has come to into a column."""
    numbers, facts = rays.numbers, rays.facts
    nx, ny, nz = block[_NX + k], block[_NY + k], block[_NZ + k]
    dx, dy, dz, cos_air, _ = into_air(block[_DX + k], block[_DY + k], block[_DZ + k], nx, ny, nz, index)
    for j in range(3):
        numbers[POINT + j, column] = block[_X + j * _LANES + k]
    numbers[DIRECTION, column], numbers[DIRECTION + 1, column], numbers[DIRECTION + 2, column] = dx, dy, dz
    numbers[COS_EXIT, column] = cos_air
    facts[EXIT, column], facts[STATUS, column] = int(block[_MET + k]), _EXITED
    if is_of_all:
        for j in range(3):
            row = _UNFOLD + 3 * j * _LANES + k
            unfolded = block[row] * nx + block[row + _LANES] * ny + block[row + 2 * _LANES] * nz
            numbers[UNFOLD + j, column] = unfolded


@jit_inner
def _divide(index: float, block: Any, k: int, rays: Any, column: int) -> int:
    """Divide a ray where all light is followed; return the column of what goes on, or that where it ends."""
    numbers, facts, later = rays.numbers, rays.facts, len(rays.random)
    dx, dy, dz = block[_DX + k], block[_DY + k], block[_DZ + k]
    nx, ny, nz = block[_NX + k], block[_NY + k], block[_NZ + k]
    cos_stone = dx * nx + dy * ny + dz * nz
    cos_air = math.sqrt(max(1.0 - index * index * (1.0 - cos_stone * cos_stone), 0.0))
    reflected, on = reflected_share(cos_air, cos_stone, index), column
    if facts[PARTIAL, column] > 0:
        leaves = next_random(rays.random, column % later) >= reflected
        block[_FACTOR + k] /= 1.0 - reflected if leaves else reflected
        if leaves:
            _leave(index, block, k, rays, column, True)
            return column
    else:  # principal light leaves; later light has a column of its own
        _leave(index, block, k, rays, column, True)
        numbers[WEIGHT, column], numbers[FACTOR, column] = block[_WEIGHT + k], block[_FACTOR + k]
        on = column + later
        facts[STATUS, on], facts[EXIT, on] = INSIDE, -1
        facts[REFLECTIONS, on], facts[ENTRY, on] = facts[REFLECTIONS, column], facts[ENTRY, column]
        facts[CODE, on], numbers[COS_ENTRY, on] = facts[CODE, column], numbers[COS_ENTRY, column]
        for row in range(NORMAL, UNFOLD):
            numbers[row, on] = numbers[row, column]
    facts[PARTIAL, on] += 1
    block[_WEIGHT + k] *= reflected
    twice = 2.0 * cos_stone
    block[_DX + k], block[_DY + k], block[_DZ + k] = dx - twice * nx, dy - twice * ny, dz - twice * nz
    return on


@jit_with_arrays
def enter_rays(points: Any, basis: Any, solid: Any, facet: Any, index: float, rays: Any) -> None:
    """Send rays from the eye into a stone.

    Parameters
    ----------
    points : (n, 2) float64
        Places in the view [girdle radius].
    basis : (3, 3) float64
        The view's right, its up, and the direction to the eye.
    solid : Solid
        The stone.
    facet : (p + 1,) int64
        The facet that each surface belongs to.
    index : float
        Refractive index.
    rays : Rays
        n empty rays, which are written: `INSIDE`, or missed.
    """
    planes, arriving = solid.values, np.zeros(_ARRIVING_ROWS * _LANES)
    numbers, facts = rays.numbers, rays.facts
    for first in range(0, len(points), _LANES):
        n = min(_LANES, len(points) - first)
        _entries(planes, basis, points, first, n, arriving)
        _enter(planes, solid.is_round, basis, index, n, arriving)
        for k in range(n):
            ray, entry = first + k, int(arriving[_ENTRY + k])
            facts[EXIT, ray] = -1
            if entry < 0:
                facts[STATUS, ray], facts[ENTRY, ray] = _MISSED, -1
                continue
            facts[STATUS, ray], facts[ENTRY, ray] = INSIDE, facet[entry]
            facts[CODE, ray] = _next_code(0, facet[entry])
            numbers[COS_ENTRY, ray] = arriving[_COS + k]
            for j in range(6):
                numbers[POINT + j, ray] = arriving[_X + j * _LANES + k]
            if len(rays.random):
                numbers[WEIGHT, ray] = numbers[FACTOR, ray] = 1.0
                for j in range(3):
                    numbers[NORMAL + j, ray] = arriving[_IN_X + j * _LANES + k]
                    numbers[UNFOLD + 4 * j, ray] = 1.0


@jit_with_arrays
def follow_rays(solid: Any, facet: Any, index: float, max_reflections: int, rays: Any) -> int:
    """Follow rays that are inside a stone until they leave.

    Where all light is followed, what is reflected at the first exit (of principal light) goes on, and at each
    surface below the critical angle leaves with the probability T = 1 - R, or else goes on; where it leaves
    is written into the column of later exits.

    Parameters
    ----------
    solid, facet, index
        As for `enter_rays`.
    max_reflections : int
        Total reflections after which a ray is trapped.
    rays : Rays
        The rays, which are changed; those that are not `INSIDE` are left as they are.

    Returns
    -------
    int
        Surfaces that they have met, all together.
    """
    planes, is_round, numbers, facts = solid.values, solid.is_round, rays.numbers, rays.facts
    later = len(rays.random)
    total, state = (later, _STATE_OF_ALL) if later else (facts.shape[1], _STATE)
    block = np.zeros(_ROWS * _LANES)
    of = np.empty(_LANES, np.int64)  # the column of the ray at each place of the block
    ahead, n, met = 0, 0, 0
    while True:
        while n < _LANES and ahead < total:
            if facts[STATUS, ahead] == INSIDE:
                for row in range(6):
                    block[row * _LANES + n] = numbers[POINT + row, ahead]
                for row in range(6, state):
                    block[row * _LANES + n] = numbers[(WEIGHT - 6 if row < 8 else UNFOLD - 8) + row, ahead]
                of[n] = ahead
                n += 1
            ahead += 1
        if n == 0:
            return met
        whole = min(_LANES, (n + _VECTOR - 1) // _VECTOR * _VECTOR)
        _nearest_planes(planes, block, whole)
        _meet(planes, is_round, index, whole, block)
        met += n
        for k in range(n):
            column, surface = of[k], int(block[_MET + k])
            if surface < 0:
                facts[STATUS, column] = _LOST
            else:
                facts[CODE, column] = _next_code(facts[CODE, column], facet[surface])
                if block[_OUT + k] == 1.0:
                    if later:
                        column = _divide(index, block, k, rays, column)
                    else:
                        _leave(index, block, k, rays, column, False)
            if facts[STATUS, column] == INSIDE:
                if facts[REFLECTIONS, column] < max_reflections:
                    facts[REFLECTIONS, column] += 1
                    of[k] = column
                    continue
                facts[STATUS, column] = _TRAPPED
            if later:
                numbers[WEIGHT, column], numbers[FACTOR, column] = block[_WEIGHT + k], block[_FACTOR + k]
            of[k] = -1
        if later:
            _unfold(whole, block)
        for k in range(n - 1, -1, -1):
            if of[k] < 0:
                n -= 1  # the last ray takes its place
                of[k] = of[n]
                for row in range(state):
                    block[row * _LANES + k] = block[row * _LANES + n]


def ray_paths(
    rays: Rays, facet: np.ndarray, area: np.ndarray, stone: Stone, set_number: np.ndarray | None = None
) -> Paths:
    """Return rays that have been followed as paths.

    Parameters
    ----------
    rays : Rays
        The rays.
    facet : (p + 1,) int64
        The facet that each surface belongs to.
    area : (n,) float64
        Area that each stands for; where all light was followed, later exits (n more) the same.
    stone : Stone
        What was traced.
    set_number : (n,) int64, optional
        The set that each belongs to, and its later exit too.
    """
    has_all = len(rays.random) > 0
    n = 2 * len(area) if has_all else len(area)
    numbers, facts = rays.numbers[:, :n], rays.facts[:, :n]
    exits = facts[STATUS] == _EXITED
    if has_all:
        area = np.concatenate([area, area]) * numbers[FACTOR]
        set_number = None if set_number is None else np.concatenate([set_number, set_number])
    return Paths(
        area=area,
        weight=numbers[WEIGHT] if has_all else np.ones(len(area)),
        status=facts[STATUS],
        reflections=facts[REFLECTIONS],
        partial_reflections=facts[PARTIAL],
        entry_facet=facts[ENTRY],
        exit_facet=np.where(exits, facet[facts[EXIT]], -1),
        cos_entry=numbers[COS_ENTRY],
        cos_exit=numbers[COS_EXIT],
        exit_point=numbers[POINT:DIRECTION].T,
        exit_direction=numbers[DIRECTION:COS_ENTRY].T,
        entry_normal=numbers[NORMAL:UNFOLD].T if has_all else None,
        unfolded_exit_normal=numbers[UNFOLD : UNFOLD + 3].T if has_all else None,
        set_number=set_number,
        stone=stone,
    )

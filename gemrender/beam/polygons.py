"""Parallel beams through a convex stone, compiled: the view cut into polygons of one path each.

The beam that a plane facet refracts stays parallel. Along it a point is an affine function of the place
(u, v) in the view, so the distance to each facet's plane is affine too, and the facet that is met next is the
lower envelope of affine functions (`ahead`): the polygon falls into one convex cell for each facet that it
meets. Total reflection sends the cell on, below the critical angle it is done.

A round girdle is curved. Before it stand upright planes inside the stone, its `walls`: a cell that meets one
is given out as a girdle cell, for single rays (`rays`) to follow, and no other polygon ever comes near the
girdle. Where a stone makes more polygons than time and memory allow (`budget`), those that wait are given out
likewise. Where all light is followed, what is reflected below the critical angle goes on, until so little of
it is left that it is given out too.

Geometry only: what is made of the paths is others' business (`gemrender.measures`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gemrender.beam.ahead import box_around, planes_ahead
from gemrender.beam.beams import (
    BEAM,
    beam_at,
    beyond,
    is_cut_by_ground,
    is_within,
    moved,
    seen_at,
    turned,
    write_beam,
    write_distance,
)
from gemrender.beam.clipping import area, keep_below, opens
from gemrender.beam.compiled import jit, jit_inner, real
from gemrender.beam.crossing import into_air, into_stone, is_total, reflected_share
from gemrender.beam.lists import (
    CORNER_BYTES,
    NO_MEMORY,
    NO_TIME,
    NODE_BYTES,
    OPENS,
    POLYGON_BYTES,
    UNACCOUNTED,
    Path,
    Work,
    add,
    empty_work,
    has_room,
    with_room,
)
from gemrender.beam.rules import Rules, Solid

__all__ = [
    "EXITED",
    "GIRDLE_CELL",
    "TRAPPED",
    "Traced",
    "follow_polygons",
    "see_facets",
    "seen_outlines",
    "trace_polygons",
]

# Whole numbers of numpy's: for a plain one that is passed on numba compiles a function of its own.
#: What became of a polygon.
EXITED, TRAPPED, GIRDLE_CELL = (np.int64(k) for k in range(3))
#: No plane; and the parts of a table (`clipping`).
_NONE, _FIRST, _WHOLE = np.int64(-1), np.int64(0), np.int64(2)
_SQUARE = np.int64(4)
#: Status of a polygon that waits.
_WAITS = np.int64(-1)

#: A beam of a smaller area is trapped [girdle radius^2].
_LEAST_AREA = 1e-14
#: Polygons thinner than rounding have no inside: an area below this [girdle radius^2] is passed over.
_NO_AREA = 1e-17
#: Facets whose normals have a smaller cosine with the direction to the eye are not seen.
_LEAST_FACING = 1e-9


class Traced(NamedTuple):
    """What a trace has found.

    corners : (c, 2) float64 or complex128
        Corners of all polygons, one after the other.
    ends : (m,) int64
        Where the corners of each end.
    facts : (m, 6) int64
        Status (EXITED ...), node, reflections, the planes that it enters and leaves by (-1 for none), and
        partial reflections.
    areas, weights : (m,) like `corners`
        Area of each, and the product of the reflectances at its partial reflections.
    beams : (m, BEAM) like `corners`
        The `Beam` of each, where it left or was last reflected.
    nodes : (k, 2) int64
        The tree of paths: a node's parent, -1 at the crown, and the plane that it met.
    outlines : (c', 2), outline_ends : (p,) int64
        Outline of each plane in the view, as far as the rim, and where its corners end.
    unaccounted : float
        Area that no polygon holds: slivers thinner than rounding [girdle radius^2].
    no_time, no_memory : float
        Area of girdle cells that the limits have made [girdle radius^2].
    opens : bool
        Whether polygons of no width open where the planes move, so that derivatives have two sides.
    """

    corners: np.ndarray
    ends: np.ndarray
    facts: np.ndarray
    areas: np.ndarray
    weights: np.ndarray
    beams: np.ndarray
    nodes: np.ndarray
    outlines: np.ndarray
    outline_ends: np.ndarray
    unaccounted: float
    no_time: float
    no_memory: float
    opens: bool


# ---- The facets that the eye sees ----------------------------------------------------------------------


@jit
def see_facets(solid: Any, basis: Any, wedge: Any, index: float, work: Any) -> None:
    """Let the facets that the eye sees wait: what of the view lies within all planes, the rim and the wedge.

    Parameters
    ----------
    solid, basis, wedge
        As for `trace_polygons`.
    index : float
        Refractive index.
    work : Work
        The lists, which are changed. They have room for p polygons of as many corners as the table.
    """
    planes, rim, side, zero = solid.planes, solid.rim, 2.0 * solid.reach, solid.planes[0, 0] * 0.0
    table, used = work.table, work.used
    ex, ey, ez = basis[2, 0], basis[2, 1], basis[2, 2]
    for i in range(planes.shape[0]):
        plane = planes[i]
        facing = plane[0] * ex + plane[1] * ey + plane[2] * ez
        if real(facing) <= _LEAST_FACING:
            continue
        beam = seen_at(plane, facing, basis)
        for k in range(4):
            table[0, k, 0] = zero + (side if k in (1, 2) else -side)
            table[0, k, 1] = zero + (side if k > 1 else -side)
        part, n = _FIRST, _SQUARE
        for j in range(planes.shape[0] + wedge.shape[0] + rim.shape[0]):
            w, r = j - planes.shape[0], j - planes.shape[0] - wedge.shape[0]
            if n == 0 or j == i:
                continue
            if w < 0:
                other = planes[j]
                a, b, c = beyond(other[0], other[1], other[2], other[3], beam)
            elif r < 0:
                a, b, c = zero + wedge[w, 2], zero + wedge[w, 0], zero + wedge[w, 1]
            else:
                a, b, c = beyond(zero + rim[r, 0], zero + rim[r, 1], zero, zero + rim[r, 2], beam)
            whole, m = part, n
            part, n = keep_below(table, part, n, a, b, c)
            if opens(table[whole], m, b, c):
                work.sums[OPENS] += 1
        size = area(table[part], n)
        if n == 0 or real(size) < _NO_AREA:
            continue
        dx, dy, dz, _, _ = into_stone(zero - ex, zero - ey, zero - ez, plane[0], plane[1], plane[2], index)
        here = used[0]
        work.nodes[here, 0], work.nodes[here, 1] = -1, i
        used[0] = here + 1
        path, beam = Path(here, _FIRST, i, _FIRST, zero + 1.0), turned(beam, dx, dy, dz)
        add(work.waiting, _WAITS, path, _NONE, beam, table, part, n, size)


# ---- From facet to facet -------------------------------------------------------------------------------


@jit_inner
def _cell(
    which: int, count: int, n: int, candidates: Any, distances: Any, table: Any, sums: Any
) -> Any:  # fmt: skip
    """Cut the part out of a polygon at which one of the candidates is the nearest plane."""
    for k in range(n):
        table[0, k, 0], table[0, k, 1] = table[2, k, 0], table[2, k, 1]
    part, here = _FIRST, distances[candidates[which]]
    for k in range(count):
        if k != which and n:
            there, whole, m = distances[candidates[k]], part, n
            a, b, c = here[0] - there[0], here[1] - there[1], here[2] - there[2]
            part, n = keep_below(table, part, n, a, b, c)
            if opens(table[whole], m, b, c):
                sums[OPENS] += 1
    return part, n


@jit_inner
def _at_walls(
    walls: Any, moves: bool, table: Any, part: int, n: int, met: Any, before: Any, path: Any, done: Any
) -> Any:  # fmt: skip
    """Give out what of a cell lies beyond the walls; return what is left, and the area given out."""
    given, zero = 0.0, met.x * 0.0
    for w in range(walls.shape[0]):
        if n == 0:
            break
        a, b, c = beyond(zero + walls[w, 0], zero + walls[w, 1], zero, zero + walls[w, 2], met)
        if not moves:
            a, b, c = zero + real(a), zero + real(b), zero + real(c)
        other, m = keep_below(table, part, n, -a, -b, -c)
        if m == 0:
            continue
        size = area(table[other], m)
        if real(size) >= _NO_AREA:
            given += real(size)
            add(done, GIRDLE_CELL, path, _NONE, before, table, other, m, size)
        part, n = keep_below(table, part, n, a, b, c)
    return part, n, given


@jit_inner
def _leave(
    path: Any, leaves: int, beam: Any, table: Any, part: int, n: int, size: Any, rules: Any, done: Any
) -> Any:  # fmt: skip
    """Write a polygon that leaves into the list, cut at the ground if that is asked for; return its area."""
    cuts = rules.cut_at_ground and path.partial == 0
    if not (cuts and is_cut_by_ground(table[part], n, beam, rules.ground)):
        add(done, EXITED, path, leaves, beam, table, part, n, size)
        return real(size)
    written = 0.0
    for sign in (1.0, -1.0):
        other, m = keep_below(table, part, n, sign * (beam.z - rules.ground), sign * beam.zu, sign * beam.zv)
        size = area(table[other], m)
        if m and real(size) >= _NO_AREA:
            written += real(size)
            add(done, EXITED, path, leaves, beam, table, other, m, size)
    return written


@jit_inner
def _go_on_whole(
    solid: Any, rules: Any, inner: float, work: Any, beam: Any, path: Any, n: int, size: float
) -> Any:  # fmt: skip
    """Follow a polygon as long as all of it is totally reflected by one plane.

    Returns
    -------
    beam, path : Beam, Path
        After that.
    count : int
        How many planes it may meet next (`planes_ahead`).
    """
    planes, nodes, used = solid.planes, work.nodes, work.used
    corners, candidates = work.table[2], work.ahead.planes[1]
    box, goes_on = box_around(corners, n), size >= _LEAST_AREA
    while True:
        count = planes_ahead(solid.columns, beam, box, corners, n, work.ahead)
        i, here = candidates[0], used[0]
        nx, ny, nz = planes[i, 0], planes[i, 1], planes[i, 2]
        cos = nx * beam.dx + ny * beam.dy + nz * beam.dz
        goes_on &= count == 1 and is_total(cos, rules.refractive_index)
        if not goes_on or path.reflections >= rules.max_reflections or here == nodes.shape[0]:
            return beam, path, count
        write_distance(planes[i], beam, work.distances[i])
        met = moved(beam, work.distances[i])
        if not is_within(corners, n, met, inner):
            return beam, path, count
        nodes[here, 0], nodes[here, 1] = path.node, i
        used[0] = here + 1
        dx, dy, dz = beam.dx - 2.0 * cos * nx, beam.dy - 2.0 * cos * ny, beam.dz - 2.0 * cos * nz
        beam = turned(met, dx, dy, dz)
        path = Path(here, path.reflections + 1, path.entry, path.partial, path.weight)


@jit
def follow_polygons(solid: Any, rules: Any, seen: float, limits: Any, work: Any) -> bool:
    """Follow the polygons that wait until they leave the stone.

    Parameters
    ----------
    solid, rules, limits
        As for `trace_polygons`.
    seen : float
        Area of all that is traced [girdle radius^2].
    work : Work
        The lists, which are changed.

    Returns
    -------
    bool
        Whether all is done; if not, there is too little room (`Work.room`).
    """
    planes, walls, index = solid.planes, solid.walls, rules.refractive_index
    done, waiting, nodes, used = work.done, work.waiting, work.nodes, work.used
    table, distances, candidates = work.table, work.distances, work.ahead.planes[1]
    inner = np.inf
    for w in range(walls.shape[0]):
        inner = min(inner, walls[w, 2])
    while waiting.used[1] > 0:
        top = waiting.used[1] - 1
        first = waiting.facts[top - 1, 0] if top > 0 else 0
        n, facts, size = waiting.facts[top, 0] - first, waiting.facts[top], waiting.numbers[top, BEAM]
        if n > table.shape[1]:
            work.room[1, 5] = n
            return False
        for k in range(n):
            table[2, k, 0], table[2, k, 1] = waiting.corners[first + k, 0], waiting.corners[first + k, 1]
        beam = beam_at(waiting.numbers, top)
        path = Path(facts[2], facts[3], facts[4], facts[6], waiting.numbers[top, BEAM + 1])
        left = real(size)

        held = NODE_BYTES * used[0] + CORNER_BYTES * done.used[0] + POLYGON_BYTES * done.used[1]
        too_many = held > limits[1] or (held > 0.5 * limits[1] and left < limits[2] * seen)
        if left < limits[0] * seen or too_many:
            if not has_room(n, 1, 0, done.used, waiting.used, used, work.room):
                return False
            waiting.used[0], waiting.used[1] = first, top
            if path.partial == 0:
                work.sums[NO_MEMORY if too_many else NO_TIME] += left
            add(done, GIRDLE_CELL, path, _NONE, beam, table, _WHOLE, n, size)
            continue

        beam, path, count = _go_on_whole(solid, rules, inner, work, beam, path, n, left)
        if not has_room(n, count, walls.shape[0], done.used, waiting.used, used, work.room):
            write_beam(beam, waiting.numbers, top)
            facts[2], facts[3] = path.node, path.reflections
            return False
        waiting.used[0], waiting.used[1] = first, top
        for c in range(count):
            write_distance(planes[candidates[c]], beam, distances[candidates[c]])
        for c in range(count):
            i = candidates[c]
            part, m = _cell(c, count, n, candidates, distances, table, work.sums)
            if m == 0:
                continue
            met = moved(beam, distances[i])
            if walls.shape[0] and not is_within(table[part], m, met, inner):
                moves = rules.walls_move or path.partial == 0
                part, m, given = _at_walls(walls, moves, table, part, m, met, beam, path, done)
                left -= given
                if m == 0:
                    continue
            size = area(table[part], m)
            if real(size) < _NO_AREA:
                continue
            here, nx, ny, nz = used[0], planes[i, 0], planes[i, 1], planes[i, 2]
            nodes[here, 0], nodes[here, 1] = path.node, i
            used[0] = here + 1
            cos = nx * beam.dx + ny * beam.dy + nz * beam.dz
            partial, weight = path.partial, path.weight
            if not is_total(cos, index):
                dx, dy, dz, cos_air, _ = into_air(beam.dx, beam.dy, beam.dz, nx, ny, nz, index)
                ends = Path(here, path.reflections, path.entry, partial, weight)
                left -= _leave(ends, i, turned(met, dx, dy, dz), table, part, m, size, rules, done)
                if not rules.follows_all:
                    continue
                partial, weight = partial + 1, weight * reflected_share(cos_air, cos, index)
            else:
                left -= real(size)
            goes_on = Path(here, path.reflections, path.entry, partial, weight)
            # Too small, or too long on its way.
            if real(size) < _LEAST_AREA or path.reflections >= rules.max_reflections:
                add(done, TRAPPED, goes_on, _NONE, met, table, part, m, size)
                continue
            dx, dy, dz = beam.dx - 2.0 * cos * nx, beam.dy - 2.0 * cos * ny, beam.dz - 2.0 * cos * nz
            goes_on = Path(here, path.reflections + 1, path.entry, partial, weight)
            if partial > 0 and real(size) * real(weight) < rules.least * seen:
                add(done, GIRDLE_CELL, goes_on, _NONE, turned(met, dx, dy, dz), table, part, m, size)
            else:
                add(waiting, _WAITS, goes_on, _NONE, turned(met, dx, dy, dz), table, part, m, size)
        if path.partial == 0:
            work.sums[UNACCOUNTED] += max(left, 0.0)
    return True


# ---- Both ----------------------------------------------------------------------------------------------


def seen_outlines(
    solid: Solid, basis: np.ndarray, wedge: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the outlines of a stone's facets in a view.

    Parameters
    ----------
    solid, basis, wedge
        As for `trace_polygons`; by default all of the view.

    Returns
    -------
    outlines, outline_ends
        As in `Traced`.
    """
    # The index does not matter
    work = _start(solid, basis, np.empty((0, 3)) if wedge is None else wedge, 2.0)
    return _outlines(work, len(solid.planes))


def _start(solid: Solid, basis: np.ndarray, wedge: np.ndarray, index: float) -> Work:
    """Return lists in which the facets that the eye sees wait."""
    work = empty_work(len(solid.planes), len(solid.rim) + len(wedge) + 8, solid.planes.dtype)
    see_facets(solid, basis, wedge, index, work)
    return work


def _outlines(work: Work, p: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the outlines of the facets that wait, and where the corners of each of p planes end."""
    waiting, seen, numbers = work.waiting, int(work.used[0]), np.zeros(p, np.int64)
    numbers[work.nodes[:seen, 1]] = np.diff(waiting.facts[:seen, 0], prepend=0)
    return waiting.corners[: waiting.used[0]].copy(), np.cumsum(numbers)


def trace_polygons(
    solid: Solid, basis: np.ndarray, wedge: np.ndarray, rules: Rules, limits: np.ndarray
) -> Traced:
    """Cut the view into polygons, and follow each until it leaves the stone.

    Parameters
    ----------
    solid : Solid
        The stone.
    basis : (3, 3) float64
        The view's right, its up, and the direction to the eye.
    wedge : (k, 3) float64
        Only where a u + b v + c <= 0 for every row (a, b, c).
    rules : Rules
        The model.
    limits : (3,) float64
        Polygons smaller than the first [share of what is traced] are not followed on, but given out as girdle
        cells; once the lists hold half of the second [bytes] those smaller than the third, and once they hold
        all of it all. May change while this runs.
    """
    work = _start(solid, basis, wedge, rules.refractive_index)
    outlines, outline_ends = _outlines(work, len(solid.planes))
    whole = float(work.waiting.numbers[: work.used[0], BEAM].real.sum())
    while not follow_polygons(solid, rules, whole, limits, work):
        work = with_room(work)
    corners, n = work.done.used
    facts, states = work.done.facts[:n], work.done.numbers[:n]
    unaccounted, no_time, no_memory, opening = work.sums.tolist()
    return Traced(
        corners=work.done.corners[:corners],
        ends=facts[:, 0],
        facts=facts[:, 1:],
        areas=states[:, BEAM],
        weights=states[:, BEAM + 1],
        beams=states[:, :BEAM],
        nodes=work.nodes[: work.used[0]],
        outlines=outlines,
        outline_ends=outline_ends,
        unaccounted=unaccounted,
        no_time=no_time,
        no_memory=no_memory,
        opens=opening > 0.0,
    )

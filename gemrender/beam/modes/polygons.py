"""Parallel beams in a birefringent convex stone, compiled: polygons of one path and one history of modes.

As in `gemrender.beam.polygons`; but the beam that a facet refracts splits in two, one in each mode, and so
does each that is reflected. A mode's light stays parallel: it has one wave vector and one ray, along which
its energy goes, and geometry is the ray's. So the view is covered many times over, by polygons whose shares
make 1 at each place.

Shares are of the light inside: of what enters unpolarised each mode has its part, each reflection shares it
out among the modes that go on, and where all of a mode is totally reflected nothing is lost. Where some of it
may leave it is done. What has become so little that its area times its share is below a limit is given out,
for single rays to follow.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.beam.ahead import box_around, planes_ahead
from gemrender.beam.beams import (
    beam_at,
    beyond,
    is_cut_by_ground,
    is_within,
    moved,
    seen_at,
    turned,
    write_distance,
)
from gemrender.beam.clipping import area, keep_below
from gemrender.beam.compiled import jit, jit_inner
from gemrender.beam.modes.lists import (
    AREA,
    BYTES,
    ENTERING,
    SECTION,
    SHARE,
    WEIGHT,
    ModePath,
    ModeWork,
    add,
    add_node,
    empty_mode_work,
    has_room,
    with_room,
)
from gemrender.beam.modes.shares import into_air, meet, ray_of, wave_vector_of, write_entering
from gemrender.beam.modes.waves import BACK
from gemrender.beam.polygons import EXITED, GIRDLE_CELL, TRAPPED, seen_outlines
from gemrender.beam.rules import Rules, Solid

__all__ = ["trace_modes"]

_NONE, _FIRST, _WHOLE, _WAITS = np.int64(-1), np.int64(0), np.int64(2), np.int64(-1)
#: Polygons thinner than rounding have no inside: an area below this [girdle radius^2] is passed over.
_NO_AREA = 1e-17
#: A share of the light that is nothing but rounding: of modes that do not go on at all.
_NO_SHARE = 1e-15


@jit
def enter_beams(solid: Any, crystal: Any, basis: Any, outlines: Any, ends: Any, work: Any) -> None:
    """Let the facets that the eye sees wait, in both modes, from their outlines in the view."""
    planes, table, facet = solid.planes, work.table, work.facet
    ex, ey, ez = basis[2, 0], basis[2, 1], basis[2, 2]
    begin = 0
    for i in range(planes.shape[0]):
        n = ends[i] - begin
        if n == 0:
            continue
        for k in range(n):
            table[0, k, 0], table[0, k, 1] = outlines[begin + k, 0], outlines[begin + k, 1]
        begin = ends[i]
        nx, ny, nz = planes[i, 0], planes[i, 1], planes[i, 2]
        facing = nx * ex + ny * ey + nz * ez
        beam, size = seen_at(planes[i], facing, basis), area(table[0], n)
        write_entering(crystal, nx, ny, nz, -ex, -ey, -ez, facet)
        entering = facet.entering[0] + facet.entering[1]
        for mode in range(2):
            share = facet.entering[mode] / entering
            if share < _NO_SHARE:
                continue
            kx, ky, kz = wave_vector_of(BACK + mode, -ex, -ey, -ez, facet)
            dx, dy, dz = ray_of(BACK + mode, facet)
            section = -(dx * nx + dy * ny + dz * nz) / facing
            node = add_node(work, -1, i, mode, kx, ky, kz, section, entering)
            path = ModePath(node, _FIRST, i, _FIRST, share, 1.0)
            add(work.waiting, _WAITS, path, _NONE, turned(beam, dx, dy, dz), table, _FIRST, n, size, 0.0)


@jit_inner
def _cell(which: int, count: int, n: int, candidates: Any, distances: Any, table: Any) -> Any:
    """Cut the part out of a polygon at which one of the candidates is the nearest plane."""
    for k in range(n):
        table[0, k, 0], table[0, k, 1] = table[2, k, 0], table[2, k, 1]
    part, here = _FIRST, distances[candidates[which]]
    for k in range(count):
        if k != which and n:
            there = distances[candidates[k]]
            part, n = keep_below(table, part, n, here[0] - there[0], here[1] - there[1], here[2] - there[2])
    return part, n


@jit_inner
def _at_walls(walls: Any, table: Any, part: int, n: int, met: Any, before: Any, path: Any, done: Any) -> Any:
    """Give out what of a cell lies beyond the walls; return what is left, and the area given out."""
    given = 0.0
    for w in range(walls.shape[0]):
        if n == 0:
            break
        a, b, c = beyond(walls[w, 0], walls[w, 1], 0.0, walls[w, 2], met)
        other, m = keep_below(table, part, n, -a, -b, -c)
        if m == 0:
            continue
        size = area(table[other], m)
        if size >= _NO_AREA:
            given += size
            add(done, GIRDLE_CELL, path, _NONE, before, table, other, m, size, 0.0)
        part, n = keep_below(table, part, n, a, b, c)
    return part, n, given


@jit_inner
def _leave(
    path: Any, plane: int, beam: Any, table: Any, part: int, n: int, size: float, passed: float, rules: Any,
    done: Any,
) -> None:  # fmt: skip
    """Write a polygon that leaves into the list, cut at the ground if that is asked for."""
    cuts = rules.cut_at_ground and path.partial == 0
    if not (cuts and is_cut_by_ground(table[part], n, beam, rules.ground)):
        add(done, EXITED, path, plane, beam, table, part, n, size, passed)
        return
    for sign in (1.0, -1.0):
        other, m = keep_below(table, part, n, sign * (beam.z - rules.ground), sign * beam.zu, sign * beam.zv)
        size = area(table[other], m)
        if m and size >= _NO_AREA:
            add(done, EXITED, path, plane, beam, table, other, m, size, passed)


@jit_inner
def _meet(
    solid: Any, crystal: Any, rules: Any, work: Any, beam: Any, met: Any, path: Any, i: int, part: int,
    m: int, size: float,
) -> None:  # fmt: skip
    """Let a cell meet a plane: it leaves, or waits to go on in both modes."""
    planes, facet, table = solid.planes, work.facet, work.table
    nx, ny, nz = planes[i, 0], planes[i, 1], planes[i, 2]
    wave, mode = work.waves[path.node], work.nodes[path.node, 2]
    kx, ky, kz, section, entering = wave[0], wave[1], wave[2], wave[SECTION], wave[ENTERING]
    along = beam.dx * nx + beam.dy * ny + beam.dz * nz
    passed = meet(crystal, nx, ny, nz, kx, ky, kz, mode, facet)
    partial = path.partial
    if passed > 0.0:
        dx, dy, dz, cos = into_air(nx, ny, nz, kx, ky, kz)
        node = add_node(work, path.node, i, -1, dx, dy, dz, section * cos / along, entering)
        ends = ModePath(node, path.reflections, path.entry, partial, path.share, path.weight)
        _leave(ends, i, turned(met, dx, dy, dz), table, part, m, size, passed, rules, work.done)
        if not rules.follows_all:
            return
        partial += 1
    for other in range(2):
        by = facet.reflected[other]
        if by < _NO_SHARE or facet.waves.flux[BACK + other] == 0.0:
            continue
        qx, qy, qz = wave_vector_of(BACK + other, kx, ky, kz, facet)
        dx, dy, dz = ray_of(BACK + other, facet)
        wide = -(dx * nx + dy * ny + dz * nz)
        node = add_node(work, path.node, i, other, qx, qy, qz, section * wide / along, entering)
        share, weight = (path.share * by, path.weight) if partial == 0 else (path.share, path.weight * by)
        goes_on = ModePath(node, path.reflections + 1, path.entry, partial, share, weight)
        add(work.waiting, _WAITS, goes_on, _NONE, turned(met, dx, dy, dz), table, part, m, size, 0.0)


@jit
def follow_modes(solid: Any, crystal: Any, rules: Any, seen: float, limits: Any, work: Any) -> bool:
    """Follow the polygons that wait until they leave the stone, or are too little to be followed.

    Parameters
    ----------
    solid, crystal, rules, limits
        As for `trace_modes`.
    seen : float
        Area of all that is traced [girdle radius^2].
    work : ModeWork
        The lists, which are changed.

    Returns
    -------
    bool
        Whether all is done; if not, there is too little room (`ModeWork.room`).
    """
    planes, walls = solid.planes, solid.walls
    done, waiting, table, distances = work.done, work.waiting, work.table, work.distances
    candidates, inner = work.ahead.planes[1], np.inf
    for w in range(walls.shape[0]):
        inner = min(inner, walls[w, 2])
    while waiting.used[1] > 0:
        top = waiting.used[1] - 1
        first = waiting.facts[top - 1, 0] if top > 0 else 0
        facts, numbers = waiting.facts[top], waiting.numbers
        n, size = facts[0] - first, numbers[top, AREA]
        if n > table.shape[1]:
            work.room[5] = n
            return False
        for k in range(n):
            table[2, k, 0], table[2, k, 1] = waiting.corners[first + k, 0], waiting.corners[first + k, 1]
        beam = beam_at(numbers, top)
        path = ModePath(facts[2], facts[3], facts[4], facts[6], numbers[top, SHARE], numbers[top, WEIGHT])
        held = BYTES[0] * work.used[0] + BYTES[1] * done.used[0] + BYTES[2] * done.used[1]
        light = size * path.share * path.weight
        is_little = light < max(rules.least, limits[0]) * seen or held > limits[1]
        is_long = path.reflections >= rules.max_reflections
        if is_little or is_long:
            if not has_room(n, 1, 0, work):
                return False
            waiting.used[0], waiting.used[1] = first, top
            add(done, TRAPPED if is_long else GIRDLE_CELL, path, _NONE, beam, table, _WHOLE, n, size, 0.0)
            continue
        count = planes_ahead(solid.columns, beam, box_around(table[2], n), table[2], n, work.ahead)
        if not has_room(n, count, walls.shape[0], work):
            return False
        waiting.used[0], waiting.used[1] = first, top
        left = size
        for c in range(count):
            write_distance(planes[candidates[c]], beam, distances[candidates[c]])
        for c in range(count):
            i = candidates[c]
            part, m = _cell(c, count, n, candidates, distances, table)
            if m == 0:
                continue
            met = moved(beam, distances[i])
            if walls.shape[0] and not is_within(table[part], m, met, inner):
                part, m, given = _at_walls(walls, table, part, m, met, beam, path, done)
                left -= given
                if m == 0:
                    continue
            size = area(table[part], m)
            if size < _NO_AREA:
                continue
            left -= size
            _meet(solid, crystal, rules, work, beam, met, path, i, part, m, size)
        if path.partial == 0:
            work.sums[0] += max(left, 0.0) * path.share
    return True


def trace_modes(
    solid: Solid, crystal: Any, basis: np.ndarray, wedge: np.ndarray, rules: Rules, limits: np.ndarray
) -> tuple[ModeWork, np.ndarray, np.ndarray]:
    """Cut the view into polygons of one history of modes, and follow each until it leaves the stone.

    Parameters
    ----------
    solid : Solid
        The stone.
    crystal : Uniaxial or Biaxial
        What it is made of.
    basis : (3, 3) float64
        The view's right, its up, and the direction to the eye.
    wedge : (k, 3) float64
        Only where a u + b v + c <= 0 for every row (a, b, c).
    rules : Rules
        The model; its index makes no difference. Polygons whose area times share is below `least` [share of
        what is traced] are given out as girdle cells.
    limits : (3,) float64
        The same, which may change while this runs; and what the lists may hold [bytes].

    Returns
    -------
    work : ModeWork
        Its polygons that are done, and its tree of paths.
    outlines, outline_ends
        Outline of each plane in the view, and where its corners end.
    """
    outlines, ends = seen_outlines(solid, basis, wedge)
    work = empty_mode_work(len(solid.planes), int(np.diff(ends, prepend=0).max(initial=0)) + 64)
    enter_beams(solid, crystal, basis, outlines, ends, work)
    numbers = work.waiting.numbers[: work.waiting.used[1]]
    whole = float(numbers[:, AREA] @ numbers[:, SHARE])
    while not follow_modes(solid, crystal, rules, whole, limits, work):
        work = with_room(work)
    return work, outlines, ends

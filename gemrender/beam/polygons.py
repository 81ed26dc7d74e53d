"""Parallel beams through a convex stone, compiled: the top view cut into polygons of one path each.

The beam that a plane facet refracts stays parallel. Along it a point is an affine function of the place
(u, v) in the view, so the distance to each facet's plane is affine too, and the facet that is met next is the
lower envelope of affine functions: the polygon falls into one convex cell for each facet that it meets. Total
reflection sends the cell on, below the critical angle it is done, cut once more along z = 0.

The girdle is curved. Before it stand upright planes inside the stone, its `walls`: a cell that meets one is
given out as a girdle cell, for single rays (`rays`) to follow, and no other polygon ever comes near the
girdle. Where a stone makes more polygons than time and memory allow (`budget`), those that wait are given out
likewise.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gemrender.beam.compiled import grown, jit, jit_inner, real
from gemrender.beam.crossing import crossing_factor, into_air, into_stone, is_total
from gemrender.beam.rules import REAR_FACET, REAR_POSITION
from gemrender.stone.facets import LEVEL

__all__ = ["EXITED", "GIRDLE_CELL", "N_STATE", "TRAPPED", "area", "trace_polygons"]

#: What became of a polygon.
EXITED, TRAPPED, GIRDLE_CELL = 0, 1, 2

#: Numbers that a beam is: its point on the last surface at (u, v), origin + u by_u + v by_v (9 numbers), its
#: direction (3), and T S of its crossing towards the eye.
N_STATE = 13
#: Most corners of a polygon; what one more would hold is told as unaccounted for.
_MOST_CORNERS = 64
#: Half the side of the square that the view's polygons are cut from [girdle radius].
_SQUARE = 8.0
#: Polygons thinner than rounding have no inside: an area below this [girdle radius^2] is passed over.
_NO_AREA = 1e-17
#: What the lists hold of each [bytes]: of a node, of a corner, and of a polygon besides.
_NODE_BYTES, _CORNER_BYTES, _POLYGON_BYTES = 16, 16, 8 * (1 + 4 + 5 + N_STATE)


@jit
def area(polygon: Any, n: int) -> Any:
    """Return the area of a polygon's first n corners, anticlockwise positive (Gauss's formula)."""
    total = polygon[0, 0] * 0.0
    for k in range(1, n - 1):
        ax, ay = polygon[k, 0] - polygon[0, 0], polygon[k, 1] - polygon[0, 1]
        bx, by = polygon[k + 1, 0] - polygon[0, 0], polygon[k + 1, 1] - polygon[0, 1]
        total += ax * by - ay * bx
    return 0.5 * total


@jit
def clip(polygon: Any, n: int, a: Any, b: Any, c: Any, out: Any) -> int:
    """Keep the part of a convex polygon where a + b u + c v <= 0; return its number of corners."""
    m = 0
    here = a + b * polygon[n - 1, 0] + c * polygon[n - 1, 1]
    for k in range(n):
        before = k - 1 if k > 0 else n - 1
        there = a + b * polygon[k, 0] + c * polygon[k, 1]
        if (real(here) <= 0.0) != (real(there) <= 0.0):
            share = here / (here - there)
            if m < _MOST_CORNERS:
                out[m, 0] = polygon[before, 0] + share * (polygon[k, 0] - polygon[before, 0])
                out[m, 1] = polygon[before, 1] + share * (polygon[k, 1] - polygon[before, 1])
                m += 1
        if real(there) <= 0.0 and m < _MOST_CORNERS:
            out[m, 0], out[m, 1] = polygon[k, 0], polygon[k, 1]
            m += 1
        here = there
    return m if m > 2 else 0


class _Found(NamedTuple):
    """The polygons that are done; see `trace_polygons`."""

    corners: Any
    ends: Any
    what: Any
    values: Any
    states: Any
    counts: Any  # (2,) of corners, and of polygons


class _Waiting(NamedTuple):
    """Polygons that wait to be followed on, the last one first."""

    corners: Any  # (k, _MOST_CORNERS, 2)
    beams: Any  # (k, N_STATE)
    facts: Any  # (k, 3): number of corners, node, reflections
    count: Any  # (1,)


class _Ahead(NamedTuple):
    """The planes ahead of a beam."""

    distances: Any  # (p, 3): distance along the beam at (u, v) is d0 + u d1 + v d2
    slopes: Any  # (p,) cosine between beam and normal; planes with 0 and less lie behind
    at_corners: Any  # (p, _MOST_CORNERS) distances at the polygon's corners
    nearest: Any  # (_MOST_CORNERS,) the plane that is nearest at each corner
    candidates: Any  # (p,) the planes that may be nearest somewhere


@jit_inner
def _copy(polygon: Any, n: int, out: Any) -> None:
    """Copy the first n corners; by a plain loop, which compiles much sooner than slices."""
    for k in range(n):
        out[k, 0], out[k, 1] = polygon[k, 0], polygon[k, 1]


@jit_inner
def _store(
    found: Any, polygon: Any, n: int, size: Any, status: int, node: int, reflections: int, rear: bool,
    intensity: Any, direction: Any, state: Any,
) -> Any:  # fmt: skip
    """Add a polygon to those that are done; return them, in larger arrays where there was no room."""
    n_corners, m = found.counts[0], found.counts[1]
    while n_corners + n > found.corners.shape[0]:
        found = _Found(
            grown(found.corners), found.ends, found.what, found.values, found.states, found.counts
        )  # fmt: skip
    if m == found.ends.shape[0]:
        found = _Found(
            found.corners, grown(found.ends), grown(found.what), grown(found.values),
            grown(found.states), found.counts,
        )  # fmt: skip
    _copy(polygon, n, found.corners[n_corners:])
    found.ends[m] = n_corners + n
    what = found.what[m]
    what[0], what[1], what[2], what[3] = status, node, reflections, 1 if rear else 0
    found.values[m, 0], found.values[m, 1] = size, intensity
    for k in range(3):
        found.values[m, 2 + k] = direction[k]
    for k in range(N_STATE):
        found.states[m, k] = state[k]
    found.counts[0], found.counts[1] = n_corners + n, m + 1
    return found


@jit_inner
def _push(waiting: Any, polygon: Any, n: int, node: int, reflections: int, beam: Any) -> Any:
    """Let a polygon wait; return those that wait, in larger arrays where there was no room."""
    k = waiting.count[0]
    if k == waiting.facts.shape[0]:
        waiting = _Waiting(grown(waiting.corners), grown(waiting.beams), grown(waiting.facts), waiting.count)
    _copy(polygon, n, waiting.corners[k])
    for e in range(N_STATE):
        waiting.beams[k, e] = beam[e]
    waiting.facts[k, 0], waiting.facts[k, 1], waiting.facts[k, 2] = n, node, reflections
    waiting.count[0] = k + 1
    return waiting


@jit_inner
def _point_on(i: int, facing: Any, planes: Any, basis: Any, state: Any) -> None:
    """Fill in where the eye's ray at (u, v) meets plane i: u right + v up + h eye, h affine in u and v."""
    nx, ny, nz = planes[i, 0], planes[i, 1], planes[i, 2]
    h0 = planes[i, 3] / facing
    hu = -(nx * basis[0, 0] + ny * basis[0, 1] + nz * basis[0, 2]) / facing
    hv = -(nx * basis[1, 0] + ny * basis[1, 1] + nz * basis[1, 2]) / facing
    for k in range(3):
        state[k] = h0 * basis[2, k]
        state[3 + k] = basis[0, k] + hu * basis[2, k]
        state[6 + k] = basis[1, k] + hv * basis[2, k]


@jit_inner
def _outline(i: int, state: Any, solid: Any, wedge: Any, out: Any, spare: Any) -> int:
    """Cut a plane's facet out of the view: what lies within all other planes, the rim and the wedge."""
    planes, rim = solid.planes, solid.rim
    zero = planes[0, 0] * 0.0
    for k in range(4):
        out[k, 0] = zero + (_SQUARE if k in (1, 2) else -_SQUARE)
        out[k, 1] = zero + (_SQUARE if k > 1 else -_SQUARE)
    n = 4
    for w in range(wedge.shape[0]):
        n = clip(out, n, zero, zero + wedge[w, 0], zero + wedge[w, 1], spare) if n else 0
        _copy(spare, n, out)
    for j in range(planes.shape[0]):
        if j != i and n:
            n = clip(
                out, n,
                planes[j, 0] * state[0] + planes[j, 1] * state[1] + planes[j, 2] * state[2] - planes[j, 3],
                planes[j, 0] * state[3] + planes[j, 1] * state[4] + planes[j, 2] * state[5],
                planes[j, 0] * state[6] + planes[j, 1] * state[7] + planes[j, 2] * state[8],
                spare,
            )  # fmt: skip
            _copy(spare, n, out)
    for w in range(rim.shape[0]):
        if n:
            a, b, c = _beyond_wall(rim, w, state)
            n = clip(out, n, a, b, c, spare)
            _copy(spare, n, out)
    return n


@jit_inner
def _beyond_wall(walls: Any, w: int, state: Any) -> Any:
    """Return how far a beam's points lie beyond a wall: a + b u + c v."""
    return (
        walls[w, 0] * state[0] + walls[w, 1] * state[1] - walls[w, 2],
        walls[w, 0] * state[3] + walls[w, 1] * state[4],
        walls[w, 0] * state[6] + walls[w, 1] * state[7],
    )


@jit_inner
def _look_ahead(planes: Any, beam: Any, polygon: Any, n: int, ahead: Any) -> int:
    """Find the planes that a beam may meet next; return how many."""
    for k in range(n):
        ahead.nearest[k] = -1
    for j in range(planes.shape[0]):
        nx, ny, nz = planes[j, 0], planes[j, 1], planes[j, 2]
        slope = nx * beam[9] + ny * beam[10] + nz * beam[11]
        ahead.slopes[j] = slope
        if real(slope) <= 0.0:
            continue
        d0 = (planes[j, 3] - (nx * beam[0] + ny * beam[1] + nz * beam[2])) / slope
        du = -(nx * beam[3] + ny * beam[4] + nz * beam[5]) / slope
        dv = -(nx * beam[6] + ny * beam[7] + nz * beam[8]) / slope
        ahead.distances[j, 0], ahead.distances[j, 1], ahead.distances[j, 2] = d0, du, dv
        for k in range(n):
            t = real(d0 + du * polygon[k, 0] + dv * polygon[k, 1])
            ahead.at_corners[j, k] = t
            if ahead.nearest[k] < 0 or t < ahead.at_corners[ahead.nearest[k], k]:
                ahead.nearest[k] = j

    count = 0
    for k in range(n):
        new = True
        for c in range(count):
            new = new and ahead.candidates[c] != ahead.nearest[k]
        if new:
            ahead.candidates[count] = ahead.nearest[k]
            count += 1
    if count == 1:  # nearest at all corners, and so everywhere: the lower envelope is concave
        return 1
    # A plane that is further than one of these at every corner is so everywhere.
    n_nearest = count
    for j in range(planes.shape[0]):
        if real(ahead.slopes[j]) <= 0.0:
            continue
        possible = True
        for c in range(n_nearest):
            closer = False
            for k in range(n):
                closer = closer or ahead.at_corners[j, k] < ahead.at_corners[ahead.candidates[c], k]
            possible = possible and closer
        if possible:
            ahead.candidates[count] = j
            count += 1
    return count


@jit_inner
def _cell(which: int, count: int, ahead: Any, polygon: Any, n: int, out: Any, spare: Any) -> int:
    """Cut the part out of a polygon at which one of the candidates is the nearest plane."""
    _copy(polygon, n, out)
    i = ahead.candidates[which]
    for c in range(count):
        if c == which or n == 0:
            continue
        j = ahead.candidates[c]
        n = clip(
            out, n,
            ahead.distances[i, 0] - ahead.distances[j, 0],
            ahead.distances[i, 1] - ahead.distances[j, 1],
            ahead.distances[i, 2] - ahead.distances[j, 2],
            spare,
        )  # fmt: skip
        _copy(spare, n, out)
    return n


@jit_inner
def _is_within(polygon: Any, n: int, state: Any, radius: float) -> bool:
    """Whether all of a polygon's points on a plane lie within this radius of the axis: so do its corners."""
    for k in range(n):
        x = real(state[0] + state[3] * polygon[k, 0] + state[6] * polygon[k, 1])
        y = real(state[1] + state[4] * polygon[k, 0] + state[7] * polygon[k, 1])
        if x * x + y * y > radius * radius:
            return False
    return True


@jit_inner
def _part_at_ground(polygon: Any, n: int, state: Any, below: bool, out: Any) -> int:
    """Return the part of a polygon whose points on a plane lie at z <= 0, or that above."""
    low = high = real(state[2] + state[5] * polygon[0, 0] + state[8] * polygon[0, 1])
    for k in range(1, n):
        z = real(state[2] + state[5] * polygon[k, 0] + state[8] * polygon[k, 1])
        low, high = min(low, z), max(high, z)
    if low > 0.0 or high <= 0.0:  # all on one side
        _copy(polygon, n, out)
        return n if (high <= 0.0) == below else 0
    sign = 1.0 if below else -1.0
    return int(clip(polygon, n, sign * state[2], sign * state[5], sign * state[8], out))


@jit
def trace_polygons(solid: Any, basis: Any, wedge: Any, rules: Any, least_area: float, limits: Any) -> Any:
    """Cut the view into polygons, and follow each until it leaves the stone.

    Parameters
    ----------
    solid : Solid
        The stone.
    basis : (3, 3) float64
        The view's right, its up, and the direction to the eye.
    wedge : (k, 2) float64
        Only where wedge . (u, v) <= 0 for every row.
    rules : Rules
        The model.
    least_area : float
        A beam of a smaller area is trapped [girdle radius^2].
    limits : (3,) float64
        Polygons smaller than the first [share of what is traced] are not followed on, but given out as girdle
        cells; once the lists hold half of the second [bytes] those smaller than the third, and once they hold
        all of it all. May change while this runs.

    Returns
    -------
    corners : (c, 2) array like `planes`
        Corners of all polygons, one after the other.
    ends : (m,) int64
        Where each polygon's corners end.
    what : (m, 4) int64
        What became of it (EXITED ...), its node, its reflections, and 1 for rear light.
    values : (m, 2 + 3) array like `planes`
        Area, intensity (0 to 1; that of rear light is 0) and direction in which it leaves.
    states : (m, N_STATE) array like `planes`
        Its beam; where it left or was trapped, with its points on that surface.
    nodes : (k, 2) int64
        The tree of paths: a node's parent (-1 at the crown) and the plane that it met.
    covered : (c', 2) array like `planes`, covered_ends : (p,) int64
        Outline of each plane in the view, as far as the rim, and where its corners end.
    unaccounted : float
        Area that no polygon holds: slivers thinner than rounding [girdle radius^2].
    left_over : (2,) float64
        Area of girdle cells that the limits have made, by the first and by the second one [girdle radius^2].
    """
    planes, walls, index = solid.planes, solid.walls, rules.refractive_index
    p, kind = planes.shape[0], planes.dtype
    found = _Found(
        np.empty((1024, 2), kind), np.empty(256, np.int64), np.empty((256, 4), np.int64),
        np.empty((256, 5), kind), np.empty((256, N_STATE), kind), np.zeros(2, np.int64),
    )  # fmt: skip
    waiting = _Waiting(
        np.empty((64, _MOST_CORNERS, 2), kind), np.empty((64, N_STATE), kind), np.empty((64, 3), np.int64),
        np.zeros(1, np.int64),
    )  # fmt: skip
    ahead = _Ahead(
        np.empty((p, 3), kind), np.empty(p, kind), np.empty((p, _MOST_CORNERS)),
        np.empty(_MOST_CORNERS, np.int64), np.empty(p, np.int64),
    )  # fmt: skip
    nodes, n_nodes = np.empty((256, 2), np.int64), 0
    covered, n_covered = np.empty((1024, 2), kind), 0
    covered_ends = np.zeros(p, np.int64)
    cell, part = np.empty((_MOST_CORNERS, 2), kind), np.empty((_MOST_CORNERS, 2), kind)
    polygon, beam = np.empty((_MOST_CORNERS, 2), kind), np.empty(N_STATE, kind)
    state, direction = np.empty(N_STATE, kind), np.empty(3, kind)
    zero = planes[0, 0] * 0.0
    seen, unaccounted, left_over = 0.0, 0.0, np.zeros(2)
    inner = np.inf
    for w in range(walls.shape[0]):
        inner = min(inner, walls[w, 2])

    # ---- The facets that the eye sees ----
    ex, ey, ez = basis[2, 0], basis[2, 1], basis[2, 2]
    for i in range(p):
        nx, ny, nz = planes[i, 0], planes[i, 1], planes[i, 2]
        facing = nx * ex + ny * ey + nz * ez
        covered_ends[i] = n_covered
        if real(facing) <= 1e-9:
            continue
        _point_on(i, facing, planes, basis, state)
        n = _outline(i, state, solid, wedge, cell, part)
        if n == 0 or real(area(cell, n)) < _NO_AREA:
            continue
        seen += real(area(cell, n))
        while n_covered + n > covered.shape[0]:
            covered = grown(covered)
        _copy(cell, n, covered[n_covered:])
        n_covered += n
        covered_ends[i] = n_covered
        dx, dy, dz, cos_air, cos_stone = into_stone(zero - ex, zero - ey, zero - ez, nx, ny, nz, index)
        state[9], state[10], state[11] = dx, dy, dz
        state[12] = crossing_factor(cos_air, cos_stone, index, rules.law, rules.radiance, True)
        if n_nodes == nodes.shape[0]:
            nodes = grown(nodes)
        nodes[n_nodes, 0], nodes[n_nodes, 1] = -1, i
        waiting = _push(waiting, cell, n, n_nodes, 0, state)
        n_nodes += 1

    # ---- From facet to facet ----
    while waiting.count[0] > 0:
        waiting.count[0] -= 1
        top = waiting.count[0]
        n, node, reflections = waiting.facts[top, 0], waiting.facts[top, 1], waiting.facts[top, 2]
        _copy(waiting.corners[top], n, polygon)
        for k in range(N_STATE):
            beam[k] = waiting.beams[top, k]
        dx, dy, dz = beam[9], beam[10], beam[11]
        left = real(area(polygon, n))
        held = _NODE_BYTES * n_nodes + _CORNER_BYTES * found.counts[0] + _POLYGON_BYTES * found.counts[1]
        too_many = held > limits[1] or (held > 0.5 * limits[1] and left < limits[2] * seen)
        if left < limits[0] * seen or too_many:
            left_over[1 if too_many else 0] += left
            direction[0] = direction[1] = direction[2] = zero
            found = _store(
                found,
                polygon,
                n,
                area(polygon, n),
                GIRDLE_CELL,
                node,
                reflections,
                False,
                zero,
                direction,
                beam,
            )
            continue
        count = _look_ahead(planes, beam, polygon, n, ahead)
        for c in range(count):
            i = ahead.candidates[c]
            n_cell = _cell(c, count, ahead, polygon, n, cell, part)
            if n_cell == 0:
                continue
            # Where the cell meets the plane.
            for k in range(3):
                for row in range(3):
                    state[3 * row + k] = beam[3 * row + k] + ahead.distances[i, row] * beam[9 + k]
                state[9 + k] = beam[9 + k]
            state[12] = beam[12]

            if not _is_within(cell, n_cell, state, inner):
                for w in range(walls.shape[0]):
                    a, b, cc = _beyond_wall(walls, w, state)
                    n_part = clip(cell, n_cell, -a, -b, -cc, part)
                    if n_part == 0:
                        continue
                    size = area(part, n_part)
                    if real(size) >= _NO_AREA:
                        left -= real(size)
                        direction[0] = direction[1] = direction[2] = zero
                        found = _store(
                            found, part, n_part, size, GIRDLE_CELL, node, reflections, False, zero, direction,
                            beam,
                        )  # fmt: skip
                    n_cell = clip(cell, n_cell, a, b, cc, part)
                    _copy(part, n_cell, cell)
                    if n_cell == 0:
                        break
                if n_cell == 0:
                    continue
            size = area(cell, n_cell)
            if real(size) < _NO_AREA:
                continue

            if n_nodes == nodes.shape[0]:
                nodes = grown(nodes)
            nodes[n_nodes, 0], nodes[n_nodes, 1] = node, i
            met = n_nodes
            n_nodes += 1
            nx, ny, nz, cos = planes[i, 0], planes[i, 1], planes[i, 2], ahead.slopes[i]
            if is_total(cos, index):
                # Total reflection: the cell goes on, unless it is too small or has been on its way too long.
                left -= real(size)
                if real(size) < least_area or reflections >= rules.max_reflections:
                    direction[0], direction[1], direction[2] = dx, dy, dz
                    found = _store(
                        found, cell, n_cell, size, TRAPPED, met, reflections, False, zero, direction, state
                    )
                    continue
                state[9], state[10] = dx - 2.0 * cos * nx, dy - 2.0 * cos * ny
                state[11] = dz - 2.0 * cos * nz
                waiting = _push(waiting, cell, n_cell, met, reflections + 1, state)
                continue
            out_x, out_y, out_z, cos_air, cos_stone = into_air(dx, dy, dz, nx, ny, nz, index)
            direction[0], direction[1], direction[2] = out_x, out_y, out_z
            intensity = beam[12] * crossing_factor(
                cos_air, cos_stone, index, rules.law, rules.radiance, False
            )
            for below in (False, True):  # at z <= 0 the light is rear light; or all of it is, or none
                if rules.rear == REAR_POSITION:
                    n_part = _part_at_ground(cell, n_cell, state, below, part)
                else:
                    is_rear = real(nz) < -LEVEL if rules.rear == REAR_FACET else real(out_z) <= 0.0
                    n_part = n_cell if is_rear == below else 0
                    _copy(cell, n_part, part)
                size = area(part, n_part)
                if n_part == 0 or real(size) < _NO_AREA:
                    continue
                left -= real(size)
                found = _store(
                    found, part, n_part, size, EXITED, met, reflections, below, zero if below else intensity,
                    direction, state,
                )  # fmt: skip
        unaccounted += max(left, 0.0)

    corners, m = found.counts[0], found.counts[1]
    return (
        found.corners[:corners], found.ends[:m], found.what[:m], found.values[:m], found.states[:m],
        nodes[:n_nodes], covered[:n_covered], covered_ends, unaccounted, left_over,
    )  # fmt: skip

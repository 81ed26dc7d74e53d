"""Parallel beams through a convex stone, compiled: the top view cut into polygons of one path each.

The beam that a plane facet refracts stays parallel. Along it a point is an affine function of the place
(u, v) in the view, so the distance to each facet's plane is affine too, and the facet that is met next is the
lower envelope of affine functions: the polygon falls into one convex cell for each facet that it meets. Total
reflection sends the cell on, below the critical angle it is done, cut once more along z = 0.

The girdle is curved. Before it stand upright planes inside the stone, its `walls`: a cell that meets one is
given out as a girdle cell, for `lines` to follow, and all other polygons never come near the girdle.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.beam.compiled import jit, real
from gemrender.beam.crossing import crossing_factor, into_air, into_stone

__all__ = ["EXITED", "GIRDLE_CELL", "N_STATE", "TRAPPED", "area", "trace_polygons"]

#: What became of a polygon.
EXITED, TRAPPED, GIRDLE_CELL = 0, 1, 2

#: Numbers that a beam is: its point on the last surface at (u, v), origin + u by_u + v by_v (9 numbers), its
#: direction (3), and T S of its crossing towards the eye.
N_STATE = 13
#: Most corners of a polygon. One more is cut off with its area counted as trapped.
_MOST_CORNERS = 64
#: Half the side of the square that the view's polygons are cut from [girdle radius].
_SQUARE = 8.0
#: Polygons thinner than rounding have no inside: an area below this [girdle radius^2] is passed over.
_NO_AREA = 1e-17


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


@jit
def _grown(array: Any) -> Any:
    """Return the array with twice as many rows."""
    out = np.empty((2 * array.shape[0], *array.shape[1:]), array.dtype)
    out[: array.shape[0]] = array
    return out


@jit
def trace_polygons(solid: Any, basis: Any, wedge: Any, rules: Any, least_area: float) -> Any:
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
        Outline of each plane in the view, as far as the walls, and where its corners end.
    """
    planes, walls, index = solid.planes, solid.walls, rules.refractive_index
    p = planes.shape[0]
    kind = planes.dtype
    corners, n_corners = np.empty((1024, 2), kind), 0
    ends, what = np.empty(256, np.int64), np.empty((256, 4), np.int64)
    values, states, m = np.empty((256, 5), kind), np.zeros((256, N_STATE), kind), 0
    nodes, n_nodes = np.empty((256, 2), np.int64), 0
    covered, n_covered = np.empty((1024, 2), kind), 0
    covered_ends = np.zeros(p, np.int64)

    stack = np.empty((64, _MOST_CORNERS, 2), kind)
    beams = np.empty((64, N_STATE), kind)
    facts = np.empty((64, 3), np.int64)  # corners, node, reflections
    height = 0

    one, other = np.empty((_MOST_CORNERS + 2, 2), kind), np.empty((_MOST_CORNERS + 2, 2), kind)
    outside = np.empty((_MOST_CORNERS + 2, 2), kind)
    distances = np.empty((p, 3), kind)
    at_corner = np.empty((p, _MOST_CORNERS), np.float64)
    slopes = np.empty(p, kind)
    nearest = np.empty(_MOST_CORNERS, np.int64)
    candidates = np.empty(p, np.int64)
    state = np.empty(N_STATE, kind)
    inner = walls[0, 2]
    for k in range(walls.shape[0]):
        inner = min(inner, walls[k, 2])

    # ---- The facets that the eye sees ----
    ex, ey, ez = basis[2, 0], basis[2, 1], basis[2, 2]
    for i in range(p):
        nx, ny, nz, offset = planes[i, 0], planes[i, 1], planes[i, 2], planes[i, 3]
        facing = nx * ex + ny * ey + nz * ez
        covered_ends[i] = n_covered
        if real(facing) <= 1e-9:
            continue
        # The point of the plane at (u, v) lies u right + v up + h eye from the origin.
        h0 = offset / facing
        hu = -(nx * basis[0, 0] + ny * basis[0, 1] + nz * basis[0, 2]) / facing
        hv = -(nx * basis[1, 0] + ny * basis[1, 1] + nz * basis[1, 2]) / facing
        for k in range(3):
            state[k] = h0 * basis[2, k]
            state[3 + k] = basis[0, k] + hu * basis[2, k]
            state[6 + k] = basis[1, k] + hv * basis[2, k]
        n = 4
        for k in range(4):
            one[k, 0] = planes[0, 0] * 0.0 + (_SQUARE if k in (1, 2) else -_SQUARE)
            one[k, 1] = planes[0, 0] * 0.0 + (_SQUARE if k > 1 else -_SQUARE)
        for j in range(wedge.shape[0] + p + solid.rim.shape[0]):
            if n == 0:
                break
            a, b, c = facing * 0.0, facing * 0.0, facing * 0.0
            if j < wedge.shape[0]:
                b, c = b + wedge[j, 0], c + wedge[j, 1]
            elif j < wedge.shape[0] + p:
                w = j - wedge.shape[0]
                if w == i:
                    continue
                a = planes[w, 0] * state[0] + planes[w, 1] * state[1] + planes[w, 2] * state[2] - planes[w, 3]
                b = planes[w, 0] * state[3] + planes[w, 1] * state[4] + planes[w, 2] * state[5]
                c = planes[w, 0] * state[6] + planes[w, 1] * state[7] + planes[w, 2] * state[8]
            else:
                w = j - wedge.shape[0] - p
                a = solid.rim[w, 0] * state[0] + solid.rim[w, 1] * state[1] - solid.rim[w, 2]
                b = solid.rim[w, 0] * state[3] + solid.rim[w, 1] * state[4]
                c = solid.rim[w, 0] * state[6] + solid.rim[w, 1] * state[7]
            n = clip(one, n, a, b, c, other)
            one, other = other, one
        if n == 0 or real(area(one, n)) < _NO_AREA:
            continue
        while n_covered + n > covered.shape[0]:
            covered = _grown(covered)
        covered[n_covered : n_covered + n] = one[:n]
        n_covered += n
        covered_ends[i] = n_covered

        zero = facing * 0.0
        dx, dy, dz, cos_air, cos_stone = into_stone(zero - ex, zero - ey, zero - ez, nx, ny, nz, index)
        state[9], state[10], state[11] = dx, dy, dz
        state[12] = crossing_factor(cos_air, cos_stone, index, rules.law, rules.radiance, True)
        if n_nodes == nodes.shape[0]:
            nodes = _grown(nodes)
        nodes[n_nodes, 0], nodes[n_nodes, 1] = -1, i
        if height == stack.shape[0]:
            stack, beams, facts = _grown(stack), _grown(beams), _grown(facts)
        stack[height, :n], beams[height] = one[:n], state
        facts[height, 0], facts[height, 1], facts[height, 2] = n, n_nodes, 0
        n_nodes += 1
        height += 1

    # ---- From facet to facet ----
    while height > 0:
        height -= 1
        n, node, reflections = facts[height, 0], facts[height, 1], facts[height, 2]
        polygon, beam = stack[height, :n].copy(), beams[height].copy()
        dx, dy, dz = beam[9], beam[10], beam[11]

        for k in range(n):
            nearest[k] = -1
        for j in range(p):
            slope = planes[j, 0] * dx + planes[j, 1] * dy + planes[j, 2] * dz
            slopes[j] = slope
            if real(slope) <= 0.0:
                continue
            t0 = planes[j, 3] - (planes[j, 0] * beam[0] + planes[j, 1] * beam[1] + planes[j, 2] * beam[2])
            tu = -(planes[j, 0] * beam[3] + planes[j, 1] * beam[4] + planes[j, 2] * beam[5])
            tv = -(planes[j, 0] * beam[6] + planes[j, 1] * beam[7] + planes[j, 2] * beam[8])
            distances[j, 0], distances[j, 1], distances[j, 2] = t0 / slope, tu / slope, tv / slope
            for k in range(n):
                t = real(distances[j, 0] + distances[j, 1] * polygon[k, 0] + distances[j, 2] * polygon[k, 1])
                at_corner[j, k] = t
                if nearest[k] < 0 or t < at_corner[nearest[k], k]:
                    nearest[k] = j

        # A plane that is further than one of the nearest ones at every corner is so everywhere.
        n_candidates = 0
        for k in range(n):
            new = True
            for c in range(n_candidates):
                new = new and candidates[c] != nearest[k]
            if new:
                candidates[n_candidates] = nearest[k]
                n_candidates += 1
        n_nearest = n_candidates
        if n_nearest > 1:
            for j in range(p):
                if real(slopes[j]) <= 0.0:
                    continue
                possible = True
                for c in range(n_nearest):
                    closer = False
                    for k in range(n):
                        closer = closer or at_corner[j, k] < at_corner[candidates[c], k]
                    possible = possible and closer
                if possible:
                    candidates[n_candidates] = j
                    n_candidates += 1

        left = area(polygon, n)
        for c in range(n_candidates):
            i = candidates[c]
            one[:n] = polygon
            n_cell = n
            for e in range(n_candidates):
                if e == c or n_cell == 0:
                    continue
                j = candidates[e]
                n_cell = clip(
                    one, n_cell,
                    distances[i, 0] - distances[j, 0],
                    distances[i, 1] - distances[j, 1],
                    distances[i, 2] - distances[j, 2],
                    other,
                )  # fmt: skip
                one, other = other, one
            if n_cell == 0:
                continue
            cell_area = area(one, n_cell)
            if real(cell_area) < _NO_AREA:
                continue
            left -= cell_area

            # Where the cell meets the plane.
            for k in range(3):
                d = beam[9 + k]
                for part in range(3):
                    state[3 * part + k] = beam[3 * part + k] + distances[i, part] * d
            farthest = 0.0
            for k in range(n_cell):
                x = real(state[0] + state[3] * one[k, 0] + state[6] * one[k, 1])
                y = real(state[1] + state[4] * one[k, 0] + state[7] * one[k, 1])
                farthest = max(farthest, x * x + y * y)
            if farthest > inner * inner:
                for w in range(walls.shape[0]):
                    a = walls[w, 0] * state[0] + walls[w, 1] * state[1] - walls[w, 2]
                    b = walls[w, 0] * state[3] + walls[w, 1] * state[4]
                    cc = walls[w, 0] * state[6] + walls[w, 1] * state[7]
                    beyond = False
                    for k in range(n_cell):
                        beyond = beyond or real(a + b * one[k, 0] + cc * one[k, 1]) > 0.0
                    if not beyond:
                        continue
                    n_out = clip(one, n_cell, -a, -b, -cc, outside)
                    n_cell = clip(one, n_cell, a, b, cc, other)
                    one, other = other, one
                    if n_out > 0:
                        out_area = area(outside, n_out)
                        if real(out_area) >= _NO_AREA:
                            while n_corners + n_out > corners.shape[0]:
                                corners = _grown(corners)
                            if m == ends.shape[0]:
                                ends, what, values, states = (
                                    _grown(ends), _grown(what), _grown(values), _grown(states)
                                )  # fmt: skip
                            corners[n_corners : n_corners + n_out] = outside[:n_out]
                            n_corners += n_out
                            ends[m] = n_corners
                            what[m, 0], what[m, 1], what[m, 2], what[m, 3] = GIRDLE_CELL, node, reflections, 0
                            values[m] = 0.0
                            values[m, 0] = out_area
                            states[m] = beam
                            m += 1
                    if n_cell == 0:
                        break
                if n_cell == 0:
                    continue
                cell_area = area(one, n_cell)
                if real(cell_area) < _NO_AREA:
                    continue

            if n_nodes == nodes.shape[0]:
                nodes = _grown(nodes)
            nodes[n_nodes, 0], nodes[n_nodes, 1] = node, i
            met = n_nodes
            n_nodes += 1
            nx, ny, nz = planes[i, 0], planes[i, 1], planes[i, 2]
            cos_in = slopes[i]
            if index * index * (1.0 - real(cos_in) ** 2) >= 1.0:
                # Total reflection: the cell goes on, unless it is too small or has been on its way too long.
                if real(cell_area) >= least_area and reflections < rules.max_reflections:
                    if height == stack.shape[0]:
                        stack, beams, facts = _grown(stack), _grown(beams), _grown(facts)
                    stack[height, :n_cell] = one[:n_cell]
                    for k in range(9):
                        beams[height, k] = state[k]
                    beams[height, 9] = dx - 2.0 * cos_in * nx
                    beams[height, 10] = dy - 2.0 * cos_in * ny
                    beams[height, 11] = dz - 2.0 * cos_in * nz
                    beams[height, 12] = beam[12]
                    facts[height, 0], facts[height, 1] = n_cell, met
                    facts[height, 2] = reflections + 1
                    height += 1
                    continue
                parts, became = 1, TRAPPED
                out_x, out_y, out_z, intensity = dx, dy, dz, dx * 0.0
            else:
                parts, became = 2, EXITED
                out_x, out_y, out_z, cos_air, cos_stone = into_air(dx, dy, dz, nx, ny, nz, index)
                intensity = beam[12] * crossing_factor(
                    cos_air, cos_stone, index, rules.law, rules.radiance, False
                )
            for part in range(parts):
                # Below z = 0 the light is rear light, and above it is not.
                rear = False
                if became == TRAPPED:
                    other[:n_cell] = one[:n_cell]
                    n_part = n_cell
                elif rules.rear_by_position:
                    rear = part == 1
                    sign = 1.0 if rear else -1.0
                    low = high = real(state[2] + state[5] * one[0, 0] + state[8] * one[0, 1])
                    for k in range(1, n_cell):
                        z = real(state[2] + state[5] * one[k, 0] + state[8] * one[k, 1])
                        low, high = min(low, z), max(high, z)
                    if low > 0.0 or high <= 0.0:  # all on one side
                        other[:n_cell] = one[:n_cell]
                        n_part = n_cell if (high <= 0.0) == rear else 0
                    else:
                        n_part = clip(one, n_cell, sign * state[2], sign * state[5], sign * state[8], other)
                else:
                    rear = real(out_z) <= 0.0
                    other[:n_cell] = one[:n_cell]
                    n_part = n_cell if part == 0 else 0
                if n_part == 0:
                    continue
                part_area = area(other, n_part)
                if real(part_area) < _NO_AREA:
                    continue
                while n_corners + n_part > corners.shape[0]:
                    corners = _grown(corners)
                if m == ends.shape[0]:
                    ends, what, values, states = _grown(ends), _grown(what), _grown(values), _grown(states)
                corners[n_corners : n_corners + n_part] = other[:n_part]
                n_corners += n_part
                ends[m] = n_corners
                what[m, 0], what[m, 1], what[m, 2], what[m, 3] = became, met, reflections, 1 if rear else 0
                values[m, 0], values[m, 1] = part_area, dx * 0.0 if rear else intensity
                values[m, 2], values[m, 3], values[m, 4] = out_x, out_y, out_z
                states[m] = state
                m += 1

    return (
        corners[:n_corners], ends[:m], what[:m], values[:m], states[:m], nodes[:n_nodes],
        covered[:n_covered], covered_ends,
    )  # fmt: skip

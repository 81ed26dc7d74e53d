"""Which planes a parallel beam may meet next, compiled.

Along the beam the distance to a plane is an affine function of the place (u, v) in the view; the plane that
is met next has the smallest, at each place of the beam's polygon another one perhaps. Most planes lie behind
the beam, or further at all of its places than another one: a box around the polygon tells most of these, by
vector instructions over the planes, and the polygon's corners the rest. All of it is about real parts only.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from gemrender.beam.compiled import jit_fast, jit_inner, real
from gemrender.beam.crossing import PARALLEL

__all__ = ["Ahead", "planes_ahead"]


class Ahead(NamedTuple):
    """Room to find the planes ahead of a beam in.

    distances : (2, p) float64
        Smallest and largest distance to each plane from places in the polygon's box [girdle radius].
    planes : (2, p) int64
        Planes that are left after the box, and after the corners.
    at_corners : (p, m) float64
        Distances from the polygon's corners to the close planes.
    """

    distances: Any
    planes: Any
    at_corners: Any


@jit_fast
def _least_distances(
    columns: Any, x: float, y: float, z: float, u0: float, u1: float, u2: float, v0: float, v1: float,
    v2: float, dx: float, dy: float, dz: float, distances: Any,
) -> float:  # fmt: skip
    """Find the smallest distance to each plane within a box, and the smallest of their largest ones.

    Parameters
    ----------
    columns : (4, p) float64
        Normals and offsets.
    x, y, z : float
        The beam's point at the middle of the box.
    u0, u1, u2, v0, v1, v2 : float
        By how much that changes from there to the box's sides.
    dx, dy, dz : float
        The beam's direction.
    """
    for j in range(distances.shape[1]):
        nx, ny, nz = columns[0, j], columns[1, j], columns[2, j]
        slope = nx * dx + ny * dy + nz * dz
        gap = columns[3, j] - nx * x - ny * y - nz * z
        spread = abs(nx * u0 + ny * u1 + nz * u2) + abs(nx * v0 + ny * v1 + nz * v2)
        inverse = 1.0 / slope
        ahead = slope > PARALLEL
        distances[0, j] = (gap - spread) * inverse if ahead else math.inf
        distances[1, j] = (gap + spread) * inverse if ahead else math.inf
    smallest = math.inf
    for j in range(distances.shape[1]):
        smallest = min(smallest, distances[1, j])
    return smallest


@jit_inner
def planes_ahead(columns: Any, beam: Any, corners: Any, n: int, room: Any) -> int:
    """Find the planes that a beam may meet next; return how many, in `room.planes[1]`.

    Parameters
    ----------
    columns : (4, p) float64
        Normals and offsets of the planes.
    beam : Beam
        The beam.
    corners : (m, 2 or more) array
        The polygon's corners, of which the first n count.
    room : Ahead
        Room to work in.
    """
    left = right = real(corners[0, 0])
    low = high = real(corners[0, 1])
    for k in range(1, n):
        left, right = min(left, real(corners[k, 0])), max(right, real(corners[k, 0]))
        low, high = min(low, real(corners[k, 1])), max(high, real(corners[k, 1]))
    u, v, du, dv = 0.5 * (left + right), 0.5 * (low + high), 0.5 * (right - left), 0.5 * (high - low)
    x0, y0, z0 = real(beam.x), real(beam.y), real(beam.z)
    xu, yu, zu = real(beam.xu), real(beam.yu), real(beam.zu)
    xv, yv, zv = real(beam.xv), real(beam.yv), real(beam.zv)
    dx, dy, dz = real(beam.dx), real(beam.dy), real(beam.dz)
    smallest = _least_distances(
        columns, x0 + xu * u + xv * v, y0 + yu * u + yv * v, z0 + zu * u + zv * v,
        xu * du, yu * du, zu * du, xv * dv, yv * dv, zv * dv, dx, dy, dz, room.distances,
    )  # fmt: skip
    smallest += 1e-12 * (1.0 + abs(smallest))  # rounding, here and at the corners
    close, n_close = room.planes[0], 0
    for j in range(columns.shape[1]):
        if room.distances[0, j] <= smallest:
            close[n_close] = j
            n_close += 1
    if n_close == 1:
        room.planes[1, 0] = close[0]
        return 1

    # The distances at the corners; which plane is nearest at each of them.
    table, candidates = room.at_corners, room.planes[1]
    for c in range(n_close):
        j = close[c]
        nx, ny, nz = columns[0, j], columns[1, j], columns[2, j]
        inverse = 1.0 / (nx * dx + ny * dy + nz * dz)
        d0 = (columns[3, j] - (nx * x0 + ny * y0 + nz * z0)) * inverse
        du, dv = -(nx * xu + ny * yu + nz * zu) * inverse, -(nx * xv + ny * yv + nz * zv) * inverse
        for k in range(n):
            table[c, k] = d0 + du * real(corners[k, 0]) + dv * real(corners[k, 1])
    count = 0
    for k in range(n):
        nearest = 0
        for c in range(1, n_close):
            if table[c, k] < table[nearest, k]:
                nearest = c
        new = True
        for c in range(count):
            new = new and candidates[c] != nearest
        if new:
            candidates[count] = nearest
            count += 1
    if count > 1:  # else nearest at all corners, and so everywhere: the lower envelope is concave
        # A plane that is further than one of these at every corner is so everywhere.
        n_nearest = count
        for j in range(n_close):
            possible = True
            for c in range(n_nearest):
                closer = False
                for k in range(n):
                    closer = closer or table[j, k] < table[candidates[c], k]
                possible = possible and closer
            if possible:
                candidates[count] = j
                count += 1
    for c in range(count):
        candidates[c] = close[candidates[c]]
    return count

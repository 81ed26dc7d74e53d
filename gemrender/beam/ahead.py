"""Which planes a parallel beam may meet next, compiled.

Along the beam the distance to a plane is an affine function of the place (u, v) in the view; the plane that
is met next has the smallest, at each place of the beam's polygon another one perhaps. The stone is convex: if
all of a polygon lies within it when it has moved to the plane that its middle meets next, it meets no other.
A box around the polygon tells most of these, by vector instructions over the planes, and the polygon's
corners the rest. All of it is about real parts only.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from gemrender.beam.clipping import SHORT, far_apart
from gemrender.beam.compiled import bits, is_dual, jit_fast, jit_inner, real
from gemrender.beam.crossing import PARALLEL

__all__ = ["Ahead", "Box", "box_around", "planes_ahead"]

#: What juts out of a plane by less does so by rounding, perhaps [girdle radius].
_ROUNDING = 1e-11
#: Distances that differ by less are the same but for rounding [girdle radius].
_AS_NEAR = 1e-12
#: The last bits of a key, a plane's number; a key that is larger than all.
_NUMBER, _NO_KEY = np.int64((1 << 20) - 1), np.int64((1 << 63) - 1)


class Ahead(NamedTuple):
    """Room to find the planes ahead of a beam in.

    out : (p,) float64
        How far the polygon's box, moved to the plane that is nearest at its middle, juts out of each plane
        ahead [girdle radius].
    planes : (2, p) int64
        Planes that are left after the box, and after the corners.
    at_corners : (p, m) float64
        Distances from the polygon's corners to the close planes.
    """

    out: Any
    planes: Any
    at_corners: Any


class Box(NamedTuple):
    """A box around a polygon in the view: its middle (u, v), and half of its sides."""

    u: float
    v: float
    du: float
    dv: float


@jit_inner
def box_around(corners: Any, n: int) -> Any:
    """Return the box around the first n corners of a polygon."""
    left = right = real(corners[0, 0])
    low = high = real(corners[0, 1])
    for k in range(1, n):
        left, right = min(left, real(corners[k, 0])), max(right, real(corners[k, 0]))
        low, high = min(low, real(corners[k, 1])), max(high, real(corners[k, 1]))
    return Box(0.5 * (left + right), 0.5 * (low + high), 0.5 * (right - left), 0.5 * (high - low))


@jit_fast
def _nearest(columns: Any, x: float, y: float, z: float, dx: float, dy: float, dz: float) -> int:
    """Return the plane that a ray from a point meets next, or one not further but for rounding; 0 for none.

    Positive numbers are in the order of their bits, the last of which make room for the planes' numbers: so
    vector instructions find the smallest one and its place together.
    """
    best = _NO_KEY
    for j in range(columns.shape[1]):
        nx, ny, nz = columns[0, j], columns[1, j], columns[2, j]
        slope = nx * dx + ny * dy + nz * dz
        gap = columns[3, j] - nx * x - ny * y - nz * z
        distance = gap / slope
        key = (bits(distance if slope > PARALLEL else math.inf) & ~_NUMBER) | j
        best = key if key < best else best
    return int(best & _NUMBER)


@jit_fast
def _jutting(
    columns: Any, x: float, y: float, z: float, xa: float, ya: float, za: float, xb: float, yb: float,
    zb: float, dx: float, dy: float, dz: float, out: Any,
) -> int:  # fmt: skip
    """Write how far a box juts out of each plane; return how many of those ahead it juts out of.

    Parameters
    ----------
    columns : (4, p) float64
        Normals and offsets.
    x, y, z : float
        The middle of the box.
    xa, ya, za, xb, yb, zb : float
        From there to the middles of two sides.
    dx, dy, dz : float
        The beam's direction.
    out : (p,) float64
        Is written.
    """
    count = 0
    for j in range(columns.shape[1]):
        nx, ny, nz = columns[0, j], columns[1, j], columns[2, j]
        far = nx * x + ny * y + nz * z - columns[3, j]
        far += abs(nx * xa + ny * ya + nz * za) + abs(nx * xb + ny * yb + nz * zb)
        slope = nx * dx + ny * dy + nz * dz
        far = far if slope > PARALLEL else -math.inf
        out[j] = far
        count += far > -_ROUNDING
    return count


@jit_inner
def planes_ahead(columns: Any, beam: Any, box: Any, corners: Any, n: int, room: Any) -> int:
    """Find the planes that a beam may meet next; return how many, in `room.planes[1]`.

    Parameters
    ----------
    columns : (4, p) float64
        Normals and offsets of the planes.
    beam : Beam
        The beam.
    box : Box
        The box around its polygon.
    corners : (m, 2 or more) array
        The polygon's corners, of which the first n count.
    room : Ahead
        Room to work in.
    """
    x0, y0, z0 = real(beam.x), real(beam.y), real(beam.z)
    xu, yu, zu = real(beam.xu), real(beam.yu), real(beam.zu)
    xv, yv, zv = real(beam.xv), real(beam.yv), real(beam.zv)
    dx, dy, dz = real(beam.dx), real(beam.dy), real(beam.dz)
    x, y, z = x0 + xu * box.u + xv * box.v, y0 + yu * box.u + yv * box.v, z0 + zu * box.u + zv * box.v
    i = room.planes[1, 0] = _nearest(columns, x, y, z, dx, dy, dz)
    # The box moved along the beam to that plane.
    nx, ny, nz = columns[0, i], columns[1, i], columns[2, i]
    slope = nx * dx + ny * dy + nz * dz
    if slope <= PARALLEL:  # the beam meets no plane
        return 1
    inverse = 1.0 / slope
    t = (columns[3, i] - nx * x - ny * y - nz * z) * inverse
    du, dv = -(nx * xu + ny * yu + nz * zu) * inverse, -(nx * xv + ny * yv + nz * zv) * inverse
    n_close = _jutting(
        columns, x + t * dx, y + t * dy, z + t * dz,
        (xu + du * dx) * box.du, (yu + du * dy) * box.du, (zu + du * dz) * box.du,
        (xv + dv * dx) * box.dv, (yv + dv * dy) * box.dv, (zv + dv * dz) * box.dv, dx, dy, dz, room.out,
    )  # fmt: skip
    if n_close <= 1:
        return 1
    close, n_close = room.planes[0], 0
    for j in range(columns.shape[1]):
        if room.out[j] > -_ROUNDING:
            close[n_close] = j
            n_close += 1

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
    # With derivatives a plane counts that is as near along an edge, but for rounding: it may open there.
    near = _AS_NEAR if is_dual(corners) else 0.0
    if count > 1 or near > 0.0:  # else nearest at all corners, and so everywhere: the envelope is concave
        # A plane that is further than one of these at every corner is so everywhere.
        n_nearest = count
        for j in range(n_close):
            possible = True
            for c in range(n_nearest):
                closer, as_near, first = False, 0, -1
                for k in range(n):
                    closer = closer or table[j, k] < table[candidates[c], k]
                    if near > 0.0 and j != candidates[c] and table[j, k] < table[candidates[c], k] + near:
                        first = k if first < 0 else first
                        as_near += first == k or far_apart(corners, first, k) > SHORT
                possible = possible and (closer or as_near > 1)
            if possible:
                candidates[count] = j
                count += 1
    for c in range(count):
        candidates[c] = close[candidates[c]]
    return count

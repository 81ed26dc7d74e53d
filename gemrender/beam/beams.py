"""A parallel beam inside a stone, compiled: a small typed record."""

from __future__ import annotations

from typing import Any, NamedTuple

from gemrender.beam.compiled import jit_inner, real

__all__ = [
    "BEAM",
    "Beam",
    "beam_at",
    "beyond",
    "is_cut_by_ground",
    "is_within",
    "moved",
    "seen_at",
    "turned",
    "write_beam",
    "write_distance",
]


class Beam(NamedTuple):
    """Where a beam's ray at the place (u, v) of the view was last, and its direction.

    The point is (x, y, z) + u (xu, yu, zu) + v (xv, yv, zv) [girdle radius].
    """

    x: Any
    y: Any
    z: Any
    xu: Any
    yu: Any
    zu: Any
    xv: Any
    yv: Any
    zv: Any
    dx: Any
    dy: Any
    dz: Any


#: Numbers that a beam is.
BEAM = len(Beam._fields)


@jit_inner
def write_beam(beam: Any, beams: Any, k: int) -> None:
    """Write a beam into row k of a list (n, BEAM)."""
    row = beams[k]
    for e, value in enumerate(beam):
        row[e] = value


@jit_inner
def beam_at(beams: Any, k: int) -> Any:
    """Return the beam in row k of a list."""
    row = beams[k]
    return Beam(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10], row[11]
    )  # fmt: skip


@jit_inner
def seen_at(plane: Any, facing: Any, basis: Any) -> Any:
    """Return the beam that is seen on a plane, without its direction."""
    nx, ny, nz = plane[0], plane[1], plane[2]
    t0 = plane[3] / facing
    tu = -(nx * basis[0, 0] + ny * basis[0, 1] + nz * basis[0, 2]) / facing
    tv = -(nx * basis[1, 0] + ny * basis[1, 1] + nz * basis[1, 2]) / facing
    ex, ey, ez = basis[2, 0], basis[2, 1], basis[2, 2]
    return Beam(
        t0 * ex, t0 * ey, t0 * ez, basis[0, 0] + tu * ex, basis[0, 1] + tu * ey, basis[0, 2] + tu * ez,
        basis[1, 0] + tv * ex, basis[1, 1] + tv * ey, basis[1, 2] + tv * ez, t0, t0, t0,
    )  # fmt: skip


@jit_inner
def beyond(nx: Any, ny: Any, nz: Any, offset: Any, beam: Any) -> Any:
    """Return how far a beam's points lie beyond a plane: a + b u + c v."""
    return (
        nx * beam.x + ny * beam.y + nz * beam.z - offset,
        nx * beam.xu + ny * beam.yu + nz * beam.zu,
        nx * beam.xv + ny * beam.yv + nz * beam.zv,
    )


@jit_inner
def turned(beam: Any, dx: Any, dy: Any, dz: Any) -> Any:
    """Return a beam with another direction."""
    return Beam(
        beam.x, beam.y, beam.z, beam.xu, beam.yu, beam.zu, beam.xv, beam.yv, beam.zv, dx, dy, dz
    )  # fmt: skip


@jit_inner
def write_distance(plane: Any, beam: Any, distance: Any) -> None:
    """Write the distance along a beam to a plane, d0 + u d1 + v d2."""
    slope = plane[0] * beam.dx + plane[1] * beam.dy + plane[2] * beam.dz
    a, b, c = beyond(plane[0], plane[1], plane[2], plane[3], beam)
    distance[0], distance[1], distance[2] = -a / slope, -b / slope, -c / slope


@jit_inner
def moved(beam: Any, distance: Any) -> Any:
    """Return a beam with its points so much further along."""
    d0, du, dv, dx, dy, dz = distance[0], distance[1], distance[2], beam.dx, beam.dy, beam.dz
    return Beam(
        beam.x + d0 * dx, beam.y + d0 * dy, beam.z + d0 * dz, beam.xu + du * dx, beam.yu + du * dy,
        beam.zu + du * dz, beam.xv + dv * dx, beam.yv + dv * dy, beam.zv + dv * dz, dx, dy, dz,
    )  # fmt: skip


@jit_inner
def is_within(corners: Any, n: int, beam: Any, radius: float) -> bool:
    """Whether all of a polygon's points lie within this radius of the axis: so do its corners."""
    for k in range(n):
        x = real(beam.x + beam.xu * corners[k, 0] + beam.xv * corners[k, 1])
        y = real(beam.y + beam.yu * corners[k, 0] + beam.yv * corners[k, 1])
        if x * x + y * y > radius * radius:
            return False
    return True


@jit_inner
def is_cut_by_ground(corners: Any, n: int, beam: Any, ground: float) -> bool:
    """Whether a polygon's points lie on both sides of z = ground."""
    above = 0
    for k in range(n):
        if real(beam.z + beam.zu * corners[k, 0] + beam.zv * corners[k, 1]) > ground:
            above += 1
    return 0 < above < n

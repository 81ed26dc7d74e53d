"""The wall of a girdle that is not round, compiled; its shape is `gemrender.stone.girdle`'s."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from gemrender.beam.compiled import jit, jit_inner
from gemrender.stone import Girdle

__all__ = ["Wall", "is_outside", "wall_crossing", "wall_normal", "wall_of"]

#: Least height that the wall is interpolated over [girdle radius].
_KNIFE_EDGE = 1e-9
#: Crossings are searched for in so many steps, then by halving to rounding (as the reference does).
_STEPS, _HALVINGS = 16, 46


class Wall(NamedTuple):
    """A girdle as the kernels take it.

    is_round : bool
        Whether it is the cylinder of radius 1; the rest then does not count.
    upper, lower : (16, 5) float64
        Its edges' vertices by azimuth: azimuth [rad], radius and height [girdle radius], and the slopes of
        both to the next vertex [1/rad].
    smallest, largest : float
        Radii of cylinders inside and around it.
    low, high : float
        Heights between which it lies.
    """

    is_round: bool
    upper: Any
    lower: Any
    smallest: float
    largest: float
    low: float
    high: float


def wall_of(girdle: Girdle) -> Wall:
    """Return a girdle as the kernels take it."""
    return Wall(
        is_round=girdle.is_round,
        upper=_edge(girdle.upper),
        lower=_edge(girdle.lower),
        smallest=girdle.smallest_radius,
        largest=girdle.largest_radius,
        low=float(girdle.lower[:, 2].min()),
        high=float(girdle.upper[:, 2].max()),
    )


def _edge(ring: np.ndarray) -> np.ndarray:
    azimuth = np.arctan2(ring[:, 1], ring[:, 0])
    order = np.argsort(azimuth)
    azimuth = azimuth[order]
    values = np.column_stack([np.hypot(ring[:, 0], ring[:, 1]), ring[:, 2]])[order]
    steps = np.diff(azimuth, append=azimuth[0] + 2 * np.pi)
    slopes = (np.roll(values, -1, axis=0) - values) / steps[:, None]
    return np.column_stack([azimuth, values, slopes])


@jit_inner
def _on_edge(edge: Any, azimuth: float) -> Any:
    """Radius and height of an edge at an azimuth, and their slopes."""
    k = len(edge) - 1
    for i in range(len(edge) - 1):
        if edge[i, 0] <= azimuth < edge[i + 1, 0]:
            k = i
            break
    beyond = (azimuth - edge[k, 0]) % (2 * math.pi)
    return edge[k, 1] + beyond * edge[k, 3], edge[k, 2] + beyond * edge[k, 4], edge[k, 3], edge[k, 4]


@jit_inner
def _radius(wall: Any, azimuth: float, z: float) -> Any:
    """Radius of the wall, and its derivatives by azimuth and height."""
    r_upper, z_upper, dr_upper, dz_upper = _on_edge(wall.upper, azimuth)
    r_lower, z_lower, dr_lower, dz_lower = _on_edge(wall.lower, azimuth)
    thickness = max(z_upper - z_lower, _KNIFE_EDGE)
    share = min(max((z - z_lower) / thickness, -1.0), 2.0)
    by_share = r_upper - r_lower
    share_by_azimuth = -(dz_lower + share * (dz_upper - dz_lower)) / thickness
    by_azimuth = (1 - share) * dr_lower + share * dr_upper + by_share * share_by_azimuth
    return (1 - share) * r_lower + share * r_upper, by_azimuth, by_share / thickness


@jit
def wall_normal(wall: Any, x: float, y: float, z: float) -> Any:
    """Return the outward unit normal at a point of the wall."""
    r = math.sqrt(x * x + y * y)
    if wall.is_round:
        return x / r, y / r, 0.0
    radius, by_azimuth, by_height = _radius(wall, math.atan2(y, x), z)
    # The gradient of r - radius(azimuth, z).
    nx, ny, nz = x / r + by_azimuth / radius * y / r, y / r - by_azimuth / radius * x / r, -by_height
    length = math.sqrt(nx * nx + ny * ny + nz * nz)
    return nx / length, ny / length, nz / length


@jit_inner
def _cylinder(ox: float, oy: float, dx: float, dy: float, radius: float) -> Any:
    """Distances at which a ray enters and leaves an upright cylinder; infinite ones where it misses it."""
    a, b, c = dx * dx + dy * dy, ox * dx + oy * dy, ox * ox + oy * oy - radius * radius
    if a == 0.0:
        return (-math.inf, math.inf) if c <= 0.0 else (math.inf, -math.inf)
    inner = b * b - a * c
    if inner < 0.0:
        return math.inf, -math.inf
    half = math.sqrt(inner)
    return (-b - half) / a, (-b + half) / a


@jit
def wall_crossing(
    wall: Any, ox: float, oy: float, oz: float, dx: float, dy: float, dz: float, first: float, last: float,
    outwards: bool,
) -> float:  # fmt: skip
    """Return the first distance from `first` to `last` at which a ray crosses the wall, else infinity.

    Outwards for a ray inside the stone, inwards for one outside. The start counts as not crossed.
    """
    near, far = _cylinder(ox, oy, dx, dy, 1.0 if wall.is_round else wall.largest)
    if wall.is_round:
        t = far if outwards else near
        return t if math.isfinite(t) and t <= last and (outwards or t >= first) else math.inf
    near_inner, far_inner = _cylinder(ox, oy, dx, dy, wall.smallest)
    first, last = max(first, near), min(last, far)
    if dz != 0.0:
        a, b = (wall.low - oz) / dz, (wall.high - oz) / dz
        first, last = max(first, min(a, b)), min(last, max(a, b))
    elif not wall.low <= oz <= wall.high:
        return math.inf
    if outwards:
        first = max(first, far_inner) if math.isfinite(far_inner) else first
    elif math.isfinite(near_inner) and near_inner > first:
        last = min(last, near_inner)
    low, high = first, math.inf
    for k in range(1, _STEPS + 1):
        t = first + (last - first) * (k / _STEPS)
        if t > low and is_outside(wall, ox + t * dx, oy + t * dy, oz + t * dz) == outwards:
            high = t
            break
        low = t
    if not math.isfinite(high):
        return math.inf
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if is_outside(wall, ox + middle * dx, oy + middle * dy, oz + middle * dz) == outwards:
            high = middle
        else:
            low = middle
    t = 0.5 * (low + high)
    nx, ny, nz = wall_normal(wall, ox + t * dx, oy + t * dy, oz + t * dz)
    facing = dx * nx + dy * ny + dz * nz
    return t if (facing > 0.0) == outwards else math.inf


@jit
def is_outside(wall: Any, x: float, y: float, z: float) -> bool:
    """Return whether a point lies outside the wall."""
    r = math.sqrt(x * x + y * y)
    return r > (1.0 if wall.is_round else _radius(wall, math.atan2(y, x), z)[0])

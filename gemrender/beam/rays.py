"""Single rays through a convex stone, compiled: what light near a round girdle does.

The same rays as the reference's (`gemrender.reference`), for solids that half-spaces make: the surface that a
ray meets next is the nearest one that it goes out through, or the girdle before that. Rays are followed
side by side, plane after plane, so that each vector instruction serves several of them; a ray that has left
makes room for the next one.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gemrender.beam.compiled import jit, jit_fast, jit_inner
from gemrender.beam.crossing import PARALLEL, into_air
from gemrender.observation import PATH_CODE_FACTOR, PATH_CODE_MASK, RayStatus
from gemrender.optics.fresnel import LEAST_TOTAL
from gemrender.paths import Paths
from gemrender.stone import Stone

__all__ = ["INSIDE", "RAY", "enter_rays", "follow_rays", "ray_paths"]

#: A ray: `RayStatus`, or `INSIDE` while it is followed; total reflections so far; facet through which it
#: enters (on the eye's side), and surface through which it leaves, -1 for none; code of its path; cosines of
#: the angles in air at both; where it leaves, point [girdle radius] and unit direction, and while it is
#: inside where it is.
RAY = np.dtype(
    [
        ("status", np.int64), ("reflections", np.int64), ("entry", np.int64), ("exit", np.int64),
        ("path_code", np.int64), ("cos_entry", np.float64), ("cos_exit", np.float64),
        ("point", np.float64, (3,)), ("direction", np.float64, (3,)),
    ]
)  # fmt: skip
#: Status of a ray that is still followed.
INSIDE = -1

#: Rays side by side, and how many of them one vector instruction takes at the most.
_LANES, _VECTOR = 32, 8
#: The rows of a block of rays inside the stone: position, direction, then of the nearest plane so far the gap
#: along its normal and the cosine (their ratio is the distance), and its number; then the surface that they
#: have met (-1 for none), and whether it has let them out, with 1 for yes.
_X, _Y, _Z, _DX, _DY, _DZ, _GAP, _SLOPE, _PLANE, _MET, _OUT = (row * _LANES for row in range(11))
_ROWS, _STATE = 11, 6
#: The rows of a block of rays that arrive: first, as above, position and direction inside; then place in the
#: view, distances at which the half-spaces begin and end (from the plane through the origin across the view),
#: the surface that they enter through (-1 for those that miss), and the cosine of the angle in air.
_U, _V, _T_IN, _T_OUT, _ENTRY, _COS = (row * _LANES for row in range(_STATE, _STATE + 6))
_ARRIVING_ROWS = _STATE + 6

_MISSED, _EXITED = int(RayStatus.MISSED), int(RayStatus.EXITED)
_TRAPPED, _LOST = int(RayStatus.TRAPPED), int(RayStatus.LOST)


@jit_fast
def _nearest_planes(planes: Any, block: Any, n: int) -> None:
    """Find the plane that each ray of a block meets next.

    Distances are compared as fractions, without a division; two planes at a time, which share the loads.
    """
    for k in range(n):
        block[_GAP + k], block[_SLOPE + k], block[_PLANE + k] = math.inf, 1.0, -1.0
    for i in range(0, planes.shape[0], 2):
        j = min(i + 1, planes.shape[0] - 1)
        ax, ay, az, a_offset, a_number = planes[i, 0], planes[i, 1], planes[i, 2], planes[i, 3], float(i)
        bx, by, bz, b_offset, b_number = planes[j, 0], planes[j, 1], planes[j, 2], planes[j, 3], float(j)
        for k in range(n):
            x, y, z = block[_X + k], block[_Y + k], block[_Z + k]
            dx, dy, dz = block[_DX + k], block[_DY + k], block[_DZ + k]
            gap, slope, plane = block[_GAP + k], block[_SLOPE + k], block[_PLANE + k]
            a_slope, a_gap = ax * dx + ay * dy + az * dz, a_offset - ax * x - ay * y - az * z
            b_slope, b_gap = bx * dx + by * dy + bz * dz, b_offset - bx * x - by * y - bz * z
            closer = (a_slope > PARALLEL) & (a_gap * slope < gap * a_slope)
            gap, slope = a_gap if closer else gap, a_slope if closer else slope
            plane = a_number if closer else plane
            closer = (b_slope > PARALLEL) & (b_gap * slope < gap * b_slope)
            block[_GAP + k], block[_SLOPE + k] = b_gap if closer else gap, b_slope if closer else slope
            block[_PLANE + k] = b_number if closer else plane


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


@jit_inner
def _next_code(code: int, facet: int) -> int:
    return (code * PATH_CODE_FACTOR + facet + 1) & PATH_CODE_MASK


@jit_inner
def _leave(planes: Any, index: float, block: Any, k: int, surface: int, ray: Any) -> None:
    """Refract a ray out of the stone through the surface that it has come to."""
    x, y, z = block[_X + k], block[_Y + k], block[_Z + k]
    if surface < planes.shape[0]:
        nx, ny, nz = planes[surface, 0], planes[surface, 1], planes[surface, 2]
    else:
        r = math.sqrt(x * x + y * y)
        nx, ny, nz = x / r, y / r, 0.0
    dx, dy, dz, cos_air, _ = into_air(
        block[_DX + k], block[_DY + k], block[_DZ + k], nx, ny, nz, index
    )  # fmt: skip
    ray.exit, ray.cos_exit = surface, cos_air
    ray.point[0], ray.point[1], ray.point[2] = x, y, z
    ray.direction[0], ray.direction[1], ray.direction[2] = dx, dy, dz


@jit_inner
def _move(block: Any, k: int, to: int) -> None:
    """Copy position and direction of a ray to another place of its block."""
    for row in range(_STATE):
        block[row * _LANES + to] = block[row * _LANES + k]


@jit
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
    rays : (n,) array of `RAY`
        The rays are written here: `INSIDE`, or missed.
    """
    planes, arriving = solid.values, np.zeros(_ARRIVING_ROWS * _LANES)
    for first in range(0, len(points), _LANES):
        n = min(_LANES, len(points) - first)
        _entries(planes, basis, points, first, n, arriving)
        _enter(planes, solid.is_round, basis, index, n, arriving)
        for k in range(n):
            ray, entry = rays[first + k], int(arriving[_ENTRY + k])
            ray.status = INSIDE if entry >= 0 else _MISSED
            ray.reflections, ray.entry, ray.exit = 0, facet[entry] if entry >= 0 else -1, -1
            ray.path_code = _next_code(0, facet[entry]) if entry >= 0 else 0
            ray.cos_entry, ray.cos_exit = arriving[_COS + k] if entry >= 0 else 0.0, 0.0
            for j in range(3):
                ray.point[j] = arriving[_X + j * _LANES + k] if entry >= 0 else 0.0
                ray.direction[j] = arriving[_DX + j * _LANES + k] if entry >= 0 else 0.0


@jit
def follow_rays(solid: Any, facet: Any, index: float, max_reflections: int, rays: Any) -> int:
    """Follow rays that are inside a stone until they leave.

    Parameters
    ----------
    solid, facet, index
        As for `enter_rays`.
    max_reflections : int
        Total reflections after which a ray is trapped.
    rays : (n,) array of `RAY`
        The rays, which are changed; those that are not `INSIDE` are left as they are.

    Returns
    -------
    int
        Surfaces that they have met, all together.
    """
    planes, is_round = solid.values, solid.is_round
    block = np.zeros(_ROWS * _LANES)
    of = np.empty(_LANES, np.int64)  # the ray at each place of the block
    ahead, n, met = 0, 0, 0
    while True:
        while n < _LANES and ahead < len(rays):
            ray = rays[ahead]
            if ray.status == INSIDE:
                for j in range(3):
                    block[_X + j * _LANES + n] = ray.point[j]
                    block[_DX + j * _LANES + n] = ray.direction[j]
                of[n] = ahead
                n += 1
            ahead += 1
        if n == 0:
            return met
        whole = min(_LANES, (n + _VECTOR - 1) // _VECTOR * _VECTOR)
        _nearest_planes(planes, block, whole)
        _meet(planes, is_round, index, whole, block)
        met += n
        for k in range(n - 1, -1, -1):
            ray, surface, out = rays[of[k]], int(block[_MET + k]), block[_OUT + k] == 1.0
            if surface >= 0:
                ray.path_code = _next_code(ray.path_code, facet[surface])
                if not out and ray.reflections < max_reflections:
                    ray.reflections += 1
                    continue
            if surface < 0:
                ray.status = _LOST
            elif out:
                ray.status = _EXITED
                _leave(planes, index, block, k, surface, ray)
            else:
                ray.status = _TRAPPED
            n -= 1  # the last ray takes its place
            of[k] = of[n]
            _move(block, n, k)


def ray_paths(rays: np.ndarray, facet: np.ndarray, area: np.ndarray, stone: Stone) -> Paths:
    """Return rays (n,) that have been followed as paths, each of which stands for an area (n,)."""
    exits = rays["status"] == RayStatus.EXITED
    return Paths(
        area=area,
        weight=np.ones(len(rays)),
        status=rays["status"],
        reflections=rays["reflections"],
        partial_reflections=np.zeros(len(rays), dtype=np.int64),
        entry_facet=rays["entry"],
        exit_facet=np.where(exits, facet[rays["exit"]], -1),
        cos_entry=rays["cos_entry"],
        cos_exit=rays["cos_exit"],
        exit_point=rays["point"],
        exit_direction=rays["direction"],
        stone=stone,
    )

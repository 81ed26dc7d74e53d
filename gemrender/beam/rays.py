"""Single rays through a stone, compiled: what light near the girdle is scored by.

The same rays as the reference's (`gemrender.reference`), for stones whose facets make a convex solid: the
surface that a ray meets next is the nearest one that it goes out through, or the girdle before that.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gemrender.beam.compiled import jit, jit_fast, jit_inner
from gemrender.beam.crossing import crossing_factor, into_air, into_stone, is_total
from gemrender.beam.rules import REAR_FACET, REAR_POSITION
from gemrender.observation import PATH_CODE_FACTOR, PATH_CODE_MASK, RayStatus
from gemrender.stone.facets import LEVEL

__all__ = [
    "BANDS",
    "BAND_EDGES",
    "INTENSITY",
    "LOST",
    "MET",
    "N_SUMS",
    "REAR",
    "TRAPPED",
    "sum_rays",
    "trace_rays",
]

#: What is summed up over rays: intensity, rear light, trapped, lost, light in the six bands, brightest first,
#: and all that met the stone.
INTENSITY, REAR, TRAPPED, LOST, BANDS, MET, N_SUMS = 0, 1, 2, 3, 4, 10, 11

#: Lower edges of the bands of intensity but the last, brightest first, as shares of the light.
BAND_EDGES = (0.75, 0.60, 0.45, 0.30, 0.15)

#: Distance to a plane that lies behind [girdle radius]: further than anything.
_NOTHING = 1e30
#: Rays start so far from the origin, outside every stone [girdle radius].
_START_DISTANCE = 10.0

_MISSED, _EXITED = int(RayStatus.MISSED), int(RayStatus.EXITED)
_TRAPPED, _LOST = int(RayStatus.TRAPPED), int(RayStatus.LOST)


@jit_inner
def _entry(ox: float, oy: float, oz: float, dx: float, dy: float, dz: float, solid: Any) -> Any:
    """Find the surface through which a ray from outside enters, and its distance; -1 if it misses."""
    planes = solid.values
    t_in, first, t_out = 0.0, -1, math.inf
    for i in range(planes.shape[0]):
        slope = planes[i, 0] * dx + planes[i, 1] * dy + planes[i, 2] * dz
        gap = planes[i, 3] - planes[i, 0] * ox - planes[i, 1] * oy - planes[i, 2] * oz
        if slope < 0.0 and gap / slope > t_in:
            t_in, first = gap / slope, i
        elif slope > 0.0:
            t_out = min(t_out, gap / slope)
        elif slope == 0.0 and gap < 0.0:
            return -1, 0.0
    if t_in >= t_out:
        return -1, 0.0
    if solid.is_round:
        x, y = ox + t_in * dx, oy + t_in * dy
        if x * x + y * y > 1.0:
            t_in, first = _into_circle(ox, oy, dx, dy, t_in, t_out), planes.shape[0]
    return (first, t_in) if math.isfinite(t_in) else (-1, 0.0)


@jit_fast
def _nearest_plane(
    ox: float, oy: float, oz: float, dx: float, dy: float, dz: float, columns: Any, distances: Any
) -> Any:
    """Find the plane that a ray inside the stone meets next, and its distance; -1 if there is none.

    All distances first, by vector instructions, then the smallest: twice as fast as one after the other.
    """
    n = distances.shape[0]
    best, surface = _NOTHING, -1
    for i in range(n):
        slope = columns[0, i] * dx + columns[1, i] * dy + columns[2, i] * dz
        gap = columns[3, i] - columns[0, i] * ox - columns[1, i] * oy - columns[2, i] * oz
        distances[i] = gap / slope if slope > 0.0 else _NOTHING
    for i in range(n):
        best = min(best, distances[i])
    if best < _NOTHING:
        for i in range(n):
            if distances[i] == best:
                surface = i
                break
    return surface, best


@jit_inner
def _into_circle(ox: float, oy: float, dx: float, dy: float, first: float, last: float) -> float:
    """Return the distance at which a ray enters the upright cylinder of radius 1, or infinity."""
    a, b, c = dx * dx + dy * dy, ox * dx + oy * dy, ox * ox + oy * oy - 1.0
    left = b * b - a * c
    if a == 0.0 or left < 0.0:
        return math.inf
    t = (-b - math.sqrt(left)) / a
    return t if first <= t <= last else math.inf


@jit_inner
def _out_of_circle(ox: float, oy: float, dx: float, dy: float) -> float:
    """Return the distance at which a ray leaves the upright cylinder of radius 1."""
    a, b = dx * dx + dy * dy, ox * dx + oy * dy
    if a == 0.0:
        return math.inf
    return (-b + math.sqrt(max(b * b - a * (ox * ox + oy * oy - 1.0), 0.0))) / a


@jit_inner
def _radial(x: float, y: float) -> Any:
    """Return the unit vector away from the axis."""
    r = math.sqrt(x * x + y * y)
    return x / r, y / r, 0.0


@jit_inner
def _follow(u: float, v: float, basis: Any, solid: Any, facet: Any, rules: Any, distances: Any) -> Any:
    """Follow the ray through (u, v) of the view from the eye until it leaves.

    Returns
    -------
    tuple
        Status, intensity (0 to 1; 0 for rear light), whether it is rear light, reflections, entry and exit
        surface, code of the path, exit point (3) and direction (3).
    """
    ox = u * basis[0, 0] + v * basis[1, 0] + _START_DISTANCE * basis[2, 0]
    oy = u * basis[0, 1] + v * basis[1, 1] + _START_DISTANCE * basis[2, 1]
    oz = u * basis[0, 2] + v * basis[1, 2] + _START_DISTANCE * basis[2, 2]
    dx, dy, dz = -basis[2, 0], -basis[2, 1], -basis[2, 2]
    first, t = _entry(ox, oy, oz, dx, dy, dz, solid)
    if first < 0:
        return _MISSED, 0.0, False, 0, -1, -1, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    planes, girdle = solid.values, solid.values.shape[0]
    code = facet[first] + 1
    ox, oy, oz = ox + t * dx, oy + t * dy, oz + t * dz
    if first == girdle:
        nx, ny, nz = _radial(ox, oy)
    else:
        nx, ny, nz = planes[first, 0], planes[first, 1], planes[first, 2]
    dx, dy, dz, cos_air, cos_stone = into_stone(dx, dy, dz, nx, ny, nz, rules.refractive_index)
    leaving = crossing_factor(cos_air, cos_stone, rules.refractive_index, rules.law, rules.radiance, True)
    for reflections in range(rules.max_reflections + 1):
        i, t = _nearest_plane(ox, oy, oz, dx, dy, dz, solid.columns, distances)
        if solid.is_round:
            t_girdle = _out_of_circle(ox, oy, dx, dy)
            if t_girdle < t:
                i, t = girdle, t_girdle
        if i < 0:
            return _LOST, 0.0, False, reflections, first, -1, code, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        code = (code * PATH_CODE_FACTOR + facet[i] + 1) & PATH_CODE_MASK
        ox, oy, oz = ox + t * dx, oy + t * dy, oz + t * dz
        if i < girdle:
            nx, ny, nz = planes[i, 0], planes[i, 1], planes[i, 2]
        else:
            nx, ny, nz = _radial(ox, oy)
        cos = dx * nx + dy * ny + dz * nz
        if not is_total(cos, rules.refractive_index):
            dx, dy, dz, cos_air, cos_stone = into_air(dx, dy, dz, nx, ny, nz, rules.refractive_index)
            if rules.rear == REAR_FACET:
                rear = i < girdle and planes[i, 2] < -LEVEL
            else:
                rear = (oz if rules.rear == REAR_POSITION else dz) <= 0.0
            intensity = 0.0
            if not rear:
                intensity = leaving * crossing_factor(
                    cos_air, cos_stone, rules.refractive_index, rules.law, rules.radiance, False
                )
            return _EXITED, intensity, rear, reflections, first, i, code, ox, oy, oz, dx, dy, dz
        dx, dy, dz = dx - 2.0 * cos * nx, dy - 2.0 * cos * ny, dz - 2.0 * cos * nz
    return _TRAPPED, 0.0, False, rules.max_reflections, first, -1, code, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


@jit
def sum_rays(
    points: Any, weights: Any, sets: Any, n_sets: int, basis: Any, solid: Any, facet: Any, rules: Any
) -> Any:
    """Follow rays and sum up what became of them, each set of rays by itself.

    Parameters
    ----------
    points : (n, 2) float64
        Places in the view [girdle radius].
    weights : (n,) float64
        What each ray counts.
    sets, n_sets : (n,) int64, int
        The set that each ray belongs to, and how many there are.
    basis : (3, 3) float64
        The view's right, its up, and the direction to the eye.
    solid, rules : Solid, Rules
        The stone and the model.
    facet : (p + 1,) int64
        The facet that each surface belongs to.

    Returns
    -------
    (n_sets, N_SUMS) float64
        Sums of the weights by what became of the rays, INTENSITY of weight times intensity (0 to 1).
    """
    all_sums, distances = np.zeros((n_sets, N_SUMS)), np.empty(solid.columns.shape[1])
    for k in range(len(points)):
        ray = _follow(points[k, 0], points[k, 1], basis, solid, facet, rules, distances)
        status, intensity, rear, weight, sums = ray[0], ray[1], ray[2], weights[k], all_sums[sets[k]]
        if status == _MISSED:
            continue
        sums[MET] += weight
        sums[INTENSITY] += weight * intensity
        if status == _TRAPPED:
            sums[TRAPPED] += weight
        elif status == _LOST:
            sums[LOST] += weight
        elif rear:
            sums[REAR] += weight
        else:
            band = 0
            while band < len(BAND_EDGES) and intensity < BAND_EDGES[band]:
                band += 1
            sums[BANDS + band] += weight
    return all_sums


@jit
def trace_rays(points: Any, basis: Any, solid: Any, facet: Any, rules: Any) -> Any:
    """Follow rays and keep what became of each.

    Parameters
    ----------
    points, basis, solid, facet, rules
        As for `sum_rays`.

    Returns
    -------
    values : (n, 8) float64
        Intensity (0 to 1), 1 for rear light, exit point (3), exit direction (3).
    numbers : (n, 5) int64
        `RayStatus`, reflections, entry and exit surface, code of the path.
    """
    values, numbers = np.empty((len(points), 8)), np.empty((len(points), 5), np.int64)
    distances = np.empty(solid.columns.shape[1])
    for k in range(len(points)):
        (
            numbers[k, 0], values[k, 0], rear, numbers[k, 1], numbers[k, 2], numbers[k, 3], numbers[k, 4],
            values[k, 2], values[k, 3], values[k, 4], values[k, 5], values[k, 6], values[k, 7],
        ) = _follow(points[k, 0], points[k, 1], basis, solid, facet, rules, distances)  # fmt: skip
        values[k, 1] = 1.0 if rear else 0.0
    return values, numbers

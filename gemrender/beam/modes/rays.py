"""Single rays through a birefringent convex stone, compiled: in one mode at a time, drawn by its share.

They tell what polygons with modes leave: light near a round girdle, the rim of the view, and what has been
split into too little. A ray meets each facet as polygons do (`shares`); among the modes that go on one is
drawn, so that sums over rays are unbiased.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from gemrender.beam.compiled import jit, jit_inner
from gemrender.beam.crossing import PARALLEL
from gemrender.beam.modes.images import angle_of_images, reflect_images, write_first_images
from gemrender.beam.modes.lists import AREA, ENTERING, SECTION, WEIGHT
from gemrender.beam.modes.shares import into_air, meet, ray_of, wave_vector_of, write_entering
from gemrender.beam.modes.waves import BACK
from gemrender.beam.random_numbers import next_random
from gemrender.observation import RayStatus

__all__ = ["ModeRays", "empty_mode_rays", "enter_mode_rays", "follow_mode_rays", "start_mode_rays"]

_INSIDE = -1
_MISSED, _EXITED = int(RayStatus.MISSED), int(RayStatus.EXITED)
_TRAPPED, _LOST = int(RayStatus.TRAPPED), int(RayStatus.LOST)

#: Columns of numbers: where a ray is, its direction and wave vector (of a ray that has left, only its
#: direction counts), the beam's cross-section, what has entered the stone, the cosine where it entered, what
#: has become of it by partial reflections, 1 over the probability of its having been drawn among later exits,
#: and the share that leaves and its cosine, and the angle between the two images [deg].
X, D, K, SECTION_, ENTERED, COS_ENTRY, WEIGHT_, FACTOR = 0, 3, 6, 9, 10, 11, 12, 13
LEAVES, COS_EXIT, ANGLE, _NUMBERS = 14, 15, 16, 17
#: Columns of facts: status, mode, reflections, partial ones, and the planes of entry and exit (-1 for none).
STATUS, MODE, REFLECTIONS, PARTIAL, ENTRY, EXIT, _FACTS = range(7)


class ModeRays(NamedTuple):
    """Rays, a row each; where all light is followed, those after the first n are of later exits.

    numbers : (m, 17) float64
        See the names of its columns.
    facts : (m, 6) int64
        The same.
    images : (n, 2, 3) float64
        Wave vectors of both images (`images`), NaN where there are none, or nobody asks for them; (0, 2, 3)
        if nobody does.
    random : (n,) uint64
        State of each ray's random numbers, never 0.
    """

    numbers: Any
    facts: Any
    images: Any
    random: Any


def empty_mode_rays(
    n: int, random: np.random.Generator, *, follows_all: bool = False, needs_images: bool = False
) -> ModeRays:
    """Return n rays that have met nothing."""
    rows = 2 * n if follows_all else n
    return ModeRays(
        np.zeros((rows, _NUMBERS)),
        np.zeros((rows, _FACTS), np.int64),
        np.full((n if needs_images else 0, 2, 3), np.nan),
        random.integers(1, 1 << 63, n, dtype=np.uint64),
    )


@jit
def start_mode_rays(
    polygons: Any, nodes: Any, waves: Any, cells: Any, basis: Any, planes: Any, rays: Any
) -> None:
    """Let each ray start in a cell, at a place drawn evenly.

    Parameters
    ----------
    polygons : ModePolygons
        What the cells are among.
    nodes, waves
        Of the tree of paths.
    cells : (n,) int64
        The cell of each ray.
    basis, planes
        Of the view (3, 3) and the stone (p, 4).
    rays : ModeRays
        Is written.
    """
    for r in range(cells.shape[0]):
        i = cells[r]
        first = polygons.facts[i - 1, 0] if i > 0 else 0
        n, corners, beam = polygons.facts[i, 0] - first, polygons.corners, polygons.numbers[i]
        # A triangle of the fan, by its area, and a place in it
        wanted, total, k = next_random(rays.random, r) * 2.0 * beam[AREA], 0.0, 1
        while True:
            ax, ay = corners[first + k, 0] - corners[first, 0], corners[first + k, 1] - corners[first, 1]
            bx, by = (
                corners[first + k + 1, 0] - corners[first, 0],
                corners[first + k + 1, 1] - corners[first, 1],
            )
            total += ax * by - ay * bx
            if total >= wanted or k == n - 2:
                break
            k += 1
        s, t = next_random(rays.random, r), next_random(rays.random, r)
        if s + t > 1.0:
            s, t = 1.0 - s, 1.0 - t
        u, v = corners[first, 0] + s * ax + t * bx, corners[first, 1] + s * ay + t * by
        numbers, facts, node, entry = (
            rays.numbers[r],
            rays.facts[r],
            polygons.facts[i, 2],
            polygons.facts[i, 4],
        )
        for a in range(3):
            numbers[X + a] = beam[a] + u * beam[3 + a] + v * beam[6 + a]
            numbers[D + a], numbers[K + a] = beam[9 + a], waves[node, a]
        numbers[SECTION_], numbers[ENTERED] = waves[node, SECTION], waves[node, ENTERING]
        numbers[COS_ENTRY] = (
            planes[entry, 0] * basis[2, 0] + planes[entry, 1] * basis[2, 1] + planes[entry, 2] * basis[2, 2]
        )
        numbers[WEIGHT_], numbers[FACTOR] = beam[WEIGHT], 1.0
        facts[STATUS], facts[MODE], facts[REFLECTIONS] = _INSIDE, nodes[node, 2], polygons.facts[i, 3]
        facts[PARTIAL], facts[ENTRY], facts[EXIT] = polygons.facts[i, 6], entry, -1


@jit
def enter_mode_rays(solid: Any, crystal: Any, basis: Any, points: Any, facet: Any, rays: Any) -> None:
    """Let a ray enter at each place (n, 2) of the view, in a mode drawn by its share, or pass by."""
    planes = solid.planes
    dx, dy, dz = -basis[2, 0], -basis[2, 1], -basis[2, 2]
    for r in range(points.shape[0]):
        u, v, numbers, facts = points[r, 0], points[r, 1], rays.numbers[r], rays.facts[r]
        x, y = u * basis[0, 0] + v * basis[1, 0], u * basis[0, 1] + v * basis[1, 1]
        z = u * basis[0, 2] + v * basis[1, 2]
        t, t_out, entry = -math.inf, math.inf, -1
        for i in range(planes.shape[0]):
            slope = planes[i, 0] * dx + planes[i, 1] * dy + planes[i, 2] * dz
            gap = planes[i, 3] - planes[i, 0] * x - planes[i, 1] * y - planes[i, 2] * z
            if slope == 0.0:
                t_out = -math.inf if gap < 0.0 else t_out
            elif slope > 0.0:
                t_out = min(t_out, gap / slope)
            elif gap / slope > t:
                t, entry = gap / slope, i
        facts[STATUS], facts[ENTRY], facts[EXIT] = _MISSED, -1, -1
        if entry < 0 or t >= t_out:
            continue
        nx, ny, nz = planes[entry, 0], planes[entry, 1], planes[entry, 2]
        if solid.is_round and (x + t * dx) ** 2 + (y + t * dy) ** 2 > 1.0:
            a, b = dx * dx + dy * dy, x * dx + y * dy
            inner = b * b - a * (x * x + y * y - 1.0)
            if a == 0.0 or inner < 0.0:
                continue
            at = (-b - math.sqrt(inner)) / a
            if at < t or at > t_out:
                continue
            t, entry, nx, ny, nz = at, planes.shape[0], x + at * dx, y + at * dy, 0.0
        write_entering(crystal, nx, ny, nz, dx, dy, dz, facet)
        entering = facet.entering[0] + facet.entering[1]
        mode = 0 if next_random(rays.random, r) * entering < facet.entering[0] else 1
        cos = -(dx * nx + dy * ny + dz * nz)
        numbers[X], numbers[X + 1], numbers[X + 2] = x + t * dx, y + t * dy, z + t * dz
        _go_on(mode, cos, 1.0, dx, dy, dz, numbers, facet)
        if rays.images.shape[0]:
            write_first_images(dx, dy, dz, facet, rays.images[r])
        numbers[ENTERED], numbers[COS_ENTRY], numbers[WEIGHT_], numbers[FACTOR] = entering, cos, 1.0, 1.0
        facts[STATUS], facts[MODE], facts[REFLECTIONS], facts[PARTIAL] = _INSIDE, mode, 0, 0
        facts[ENTRY] = entry


@jit_inner
def _go_on(
    mode: int, along: float, section: float, kx: float, ky: float, kz: float, numbers: Any, facet: Any
) -> None:  # fmt: skip
    """Write the direction and wave vector in which a ray goes back from a facet that it met with a cosine."""
    axes = facet.waves.axes
    qx, qy, qz = wave_vector_of(BACK + mode, kx, ky, kz, facet)
    ex, ey, ez = ray_of(BACK + mode, facet)
    numbers[K], numbers[K + 1], numbers[K + 2] = qx, qy, qz
    numbers[D], numbers[D + 1], numbers[D + 2] = ex, ey, ez
    numbers[SECTION_] = -section * (ex * axes[2, 0] + ey * axes[2, 1] + ez * axes[2, 2]) / along


@jit_inner
def _next(solid: Any, numbers: Any) -> Any:
    """Move a ray to the next surface; return that, -1 for none, and its normal."""
    planes, gap, slope, found = solid.planes, math.inf, 1.0, -1
    x, y, z = numbers[X], numbers[X + 1], numbers[X + 2]
    dx, dy, dz = numbers[D], numbers[D + 1], numbers[D + 2]
    for i in range(planes.shape[0]):
        nx, ny, nz = planes[i, 0], planes[i, 1], planes[i, 2]
        along, far = nx * dx + ny * dy + nz * dz, planes[i, 3] - nx * x - ny * y - nz * z
        if along > PARALLEL and far * slope < gap * along:
            gap, slope, found = far, along, i
    t, nx, ny, nz = gap / slope, 0.0, 0.0, 0.0
    if found >= 0:
        nx, ny, nz = planes[found, 0], planes[found, 1], planes[found, 2]
    if solid.is_round:
        a, b = dx * dx + dy * dy, x * dx + y * dy
        if a > 0.0:
            at = (-b + math.sqrt(max(b * b - a * (x * x + y * y - 1.0), 0.0))) / a
            if at < t or found < 0:
                t, found = at, planes.shape[0]
                nx, ny, nz = x + t * dx, y + t * dy, 0.0
                by = 1.0 / math.sqrt(nx * nx + ny * ny)
                nx, ny = nx * by, ny * by
    if found >= 0:
        numbers[X], numbers[X + 1], numbers[X + 2] = x + t * dx, y + t * dy, z + t * dz
    return found, nx, ny, nz


@jit_inner
def _write_exit(
    numbers: Any, facts: Any, surface: int, nx: float, ny: float, nz: float, along: float, passed: float,
    rays: Any, row: int,
) -> None:  # fmt: skip
    """Write a ray that leaves into a row."""
    out = rays.numbers[row]
    for a in range(_NUMBERS):
        out[a] = numbers[a]
    for a in range(_FACTS):
        rays.facts[row, a] = facts[a]
    dx, dy, dz, cos = into_air(nx, ny, nz, numbers[K], numbers[K + 1], numbers[K + 2])
    out[D], out[D + 1], out[D + 2], out[COS_EXIT], out[LEAVES] = dx, dy, dz, cos, passed
    out[SECTION_], out[ANGLE] = numbers[SECTION_] * cos / along, math.nan
    rays.facts[row, STATUS], rays.facts[row, EXIT] = _EXITED, surface


@jit
def follow_mode_rays(solid: Any, crystal: Any, rules: Any, facet: Any, now: Any, rays: Any) -> None:
    """Follow rays until they leave the stone; where all light is followed, each to a later exit too.

    That one is drawn by the share that leaves there; its row has the weight of all that it has been reflected
    by, and the factor by which its area stands for more.

    Parameters
    ----------
    solid, crystal, rules
        As for `trace_modes`.
    facet : Facet
        Room for the waves at a facet.
    now : (2, 16) float64
        Room for the numbers and facts of a ray.
    rays : ModeRays
        Is changed.
    """
    n, numbers, facts = rays.random.shape[0], now.numbers, now.facts
    for r in range(n):
        if rays.facts[r, STATUS] != _INSIDE:
            continue
        for a in range(_NUMBERS):
            numbers[a] = rays.numbers[r, a]
        for a in range(_FACTS):
            facts[a] = rays.facts[r, a]
        # A ray that starts after a partial reflection has no exit of principal light
        row = r if facts[PARTIAL] == 0 else n + r
        if row != r:
            rays.facts[r, STATUS] = _MISSED
        while True:
            surface, nx, ny, nz = _next(solid, numbers)
            if surface < 0 or facts[REFLECTIONS] >= rules.max_reflections:
                for a in range(_NUMBERS):
                    rays.numbers[row, a] = numbers[a]
                for a in range(_FACTS):
                    rays.facts[row, a] = facts[a]
                rays.facts[row, STATUS] = _LOST if surface < 0 else _TRAPPED
                break
            kx, ky, kz = numbers[K], numbers[K + 1], numbers[K + 2]
            along = numbers[D] * nx + numbers[D + 1] * ny + numbers[D + 2] * nz
            passed = meet(crystal, nx, ny, nz, kx, ky, kz, facts[MODE], facet)
            first, second = facet.reflected[0], facet.reflected[1]
            if facet.waves.flux[BACK] == 0.0:
                first = 0.0
            if facet.waves.flux[BACK + 1] == 0.0:
                second = 0.0
            back = first + second
            if passed > 0.0 and facts[PARTIAL] == 0:
                _write_exit(numbers, facts, surface, nx, ny, nz, along, passed, rays, r)
                if rays.images.shape[0]:
                    rays.numbers[r, ANGLE] = angle_of_images(nx, ny, nz, rays.images[r])
                if not rules.follows_all:
                    break
                row = n + r
            elif passed > 0.0 and next_random(rays.random, r) * (passed + back) < passed:
                numbers[FACTOR] *= (passed + back) / passed
                _write_exit(numbers, facts, surface, nx, ny, nz, along, passed, rays, row)
                break
            if passed > 0.0:
                if facts[PARTIAL] > 0:
                    numbers[FACTOR] *= (passed + back) / back
                numbers[WEIGHT_] *= back
                facts[PARTIAL] += 1
            if back == 0.0:  # nothing goes on
                break
            mode = 0 if next_random(rays.random, r) * back < first else 1
            _go_on(mode, along, numbers[SECTION_], kx, ky, kz, numbers, facet)
            if rays.images.shape[0] and facts[PARTIAL] == 0:
                reflect_images(crystal, nx, ny, nz, facet, rays.images[r])
            facts[MODE], facts[REFLECTIONS] = mode, facts[REFLECTIONS] + 1

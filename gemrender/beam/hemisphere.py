"""Measures over all views from above: single rays that enter a stone's crown from all directions.

Places and directions are an additive recurrence in four dimensions (Roberts' R4 sequence, as
`near_girdle` has R2's), in independent sets: each gives an unbiased value, and their scatter the error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.compiled import jit_with_arrays
from gemrender.beam.crossing import into_stone
from gemrender.beam.near_girdle import by_sets, more_rays, next_points
from gemrender.beam.rays import (
    COS_ENTRY,
    DIRECTION,
    ENTRY,
    EXIT,
    FACTOR,
    INSIDE,
    NORMAL,
    POINT,
    STATUS,
    UNFOLD,
    WEIGHT,
    Rays,
    empty_rays,
    follow_rays,
    ray_paths,
)
from gemrender.beam.solid import BeamStone
from gemrender.errors import InputError
from gemrender.measures.measure import Measure
from gemrender.measures.tally import SETS, Tally, bounds_of_sets
from gemrender.observation import MeasureValues, Model, View
from gemrender.stone.facets import CROWN
from gemrender.stone.mesh import tessellate

__all__ = ["HEMISPHERE_STEPS", "Crown", "measure_hemisphere", "sector_of"]

#: The positive root of x^5 = x + 1; Roberts' R4 sequence is multiples of its reciprocals.
_ROOT = 1.1673039782614187
HEMISPHERE_STEPS = _ROOT ** -np.arange(1.0, 5.0)
#: Level facets that a round girdle is cut into: enough for the crown's area to 1e-5.
_PIECES = 256
#: Rays of a set at first, at a time, and at the most.
_FIRST, _BLOCK, _MOST = 256, 1 << 12, 1 << 20


def measure_hemisphere(
    convex: BeamStone,
    model: Model,
    measures: Sequence[Measure],
    *,
    bound: float,
    seed: int,
    progress: Callable[[float], None] | None = None,
    budget: Budget | None = None,
) -> tuple[MeasureValues, ...]:
    """Measure a stone from all directions above its girdle at once.

    Parameters
    ----------
    convex : BeamStone
        The stone.
    model : Model
        The optical model.
    measures : sequence of Measure
        Measures whose `views` are the hemisphere; their values are shares, 0 to 1.
    bound : float
        Wanted error bound of their values [%].
    seed : int
        Seed of the sets' shifts, and of the rays' random numbers.
    progress : callable, optional
        Called with the share done, 0 to 1.
    budget : Budget, optional
        Time to keep to.

    Raises
    ------
    InputError
        The stone has no crown.
    """
    crown = Crown.of(convex)
    tally = Tally(View(resolution=1), model, measures)
    random = np.random.default_rng(seed)
    shifts = random.random((SETS, 4))
    total, done, wanted = np.zeros((SETS, tally.n_sums)), 0, _FIRST
    while True:
        last = min(done + _BLOCK, wanted)
        unit = next_points(shifts, HEMISPHERE_STEPS, done, last)
        states = random.integers(1, 1 << 63, unit.shape[:2], dtype=np.uint64)

        def some_sets(part: slice, unit: np.ndarray = unit, states: np.ndarray = states) -> np.ndarray:
            sets, n = states[part].shape
            rays, areas = crown.rays(unit[part].reshape(-1, 4), states[part].reshape(-1), model.index)
            follow_rays(convex.solid, convex.facet, model.index, model.max_reflections, rays)
            of = np.repeat(np.arange(sets), n)
            return tally.sum_up(ray_paths(rays, convex.facet, areas, convex.stone, of), sets)

        total += by_sets(some_sets, SETS)
        done = last
        errors = [bounds_of_sets(values) for values in tally.values(total / done)]
        largest = 100.0 * float(max(error.max() for error in errors))
        is_late = budget is not None and budget.left <= 0.0
        if done == wanted:
            if largest <= bound or is_late or wanted >= _MOST:
                break
            wanted = more_rays(wanted, largest, bound)
        elif is_late:
            break
        if progress is not None:
            progress(min(done / wanted, 1.0))
    found = tally.values((total / done).mean(axis=0))
    return tuple(
        MeasureValues(
            name=measure.name,
            version=measure.version,
            values=dict(zip(measure.keys, map(float, values), strict=True)),
            bound=float(error.max()),
        )
        for measure, values, error in zip(measures, found, errors, strict=True)
    )


class Crown:
    """The crown's facets, each cut into triangles, and rays that fall on them.

    Parameters
    ----------
    corners : (t, 3, 3) float64
        Corners of the triangles, those of each plane one after the other.
    ends : (p,) int64
        Where the triangles of each plane end.
    normals : (p, 3) float64
        Outward unit normals of the planes.
    facet : (p,) int64
        The facet that each belongs to.
    sector : (float, float)
        First azimuth and width of the directions that tell all of the hemisphere [rad].
    """

    def __init__(
        self,
        corners: np.ndarray,
        ends: np.ndarray,
        normals: np.ndarray,
        facet: np.ndarray,
        sector: tuple[float, float],
    ) -> None:
        self._corners, self._ends, self._normals, self._facet = corners, ends, normals, facet
        a, b = (corners[:, k] - corners[:, 0] for k in (1, 2))
        self._areas = 0.5 * np.linalg.norm(np.cross(a, b), axis=1)
        upto = np.append(0.0, np.cumsum(self._areas))[np.append(0, ends)]
        self._plane_areas = np.diff(upto)
        self._sector = sector

    @staticmethod
    def of(convex: BeamStone) -> Crown:
        """Return the crown of a stone.

        Raises
        ------
        InputError
            It has none.
        """
        mesh = tessellate(convex.stone, _PIECES)
        is_crown = np.array([side == CROWN for side in convex.stone.facet_sides])[mesh.face_facet]
        faces = np.flatnonzero(is_crown)
        faces = faces[np.argsort(mesh.face_patch[faces], kind="stable")]
        if not len(faces):
            raise InputError("has no crown, which light could fall on", source=convex.stone.name)
        _, first = np.unique(mesh.face_patch[faces], return_index=True)
        return Crown(
            mesh.vertices[mesh.faces[faces]],
            np.append(first[1:], len(faces)),
            mesh.face_normals[faces[first]],
            mesh.face_facet[faces[first]],
            sector_of(convex),
        )

    def rays(self, unit: np.ndarray, random: np.ndarray, index: float) -> tuple[Rays, np.ndarray]:
        """Let rays in: directions even over the hemisphere, or a sector that tells all of it.

        Places are even over the crown, as seen from there.

        Parameters
        ----------
        unit : (n, 4) float64
            Points of the unit cube.
        random : (n,) uint64
            States of random numbers.
        index : float
            Refractive index.

        Returns
        -------
        rays : Rays
            n rays inside the stone.
        areas : (n,) float64
            Projected area times solid angle that each stands for, if there were but one [girdle radius^2 sr].
        """
        rays, areas = empty_rays(len(unit), random), np.empty(len(unit))
        _fall(
            unit, self._corners, self._areas, self._ends, self._plane_areas, self._normals, self._facet,
            *self._sector, index, rays, areas,
        )  # fmt: skip
        return rays, areas


def sector_of(convex: BeamStone) -> tuple[float, float]:
    """Return first azimuth and width of the directions that tell all of the hemisphere [rad]."""
    symmetry = convex.stone.symmetry
    if len(symmetry.mirrors):
        return float(symmetry.mirrors[0]), np.pi / symmetry.fold
    return 0.0, 2 * np.pi / symmetry.fold


@jit_with_arrays
def _fall(
    unit: Any, corners: Any, triangle_areas: Any, ends: Any, plane_areas: Any, normals: Any, facet: Any,
    first: float, width: float, index: float, rays: Any, areas: Any,
) -> None:  # fmt: skip
    """Refract rays into the crown (`Crown.rays`)."""
    numbers, facts, seen = rays.numbers, rays.facts, np.empty(len(normals))
    for i in range(len(unit)):
        z, azimuth = 1.0 - unit[i, 0], first + width * unit[i, 1]
        level = math.sqrt(1.0 - z * z)
        x, y = level * math.cos(azimuth), level * math.sin(azimuth)
        whole = 0.0
        for p in range(len(normals)):
            cos = normals[p, 0] * x + normals[p, 1] * y + normals[p, 2] * z
            whole += max(cos, 0.0) * plane_areas[p]
            seen[p] = whole
        areas[i] = 2.0 * math.pi * whole
        if whole == 0.0:
            continue
        rest, p = unit[i, 2] * whole, 0
        while p + 1 < len(seen) and seen[p] <= rest:
            p += 1
        below = seen[p - 1] if p > 0 else 0.0
        k, rest = ends[p - 1] if p > 0 else 0, (rest - below) / max(seen[p] - below, 1e-300) * plane_areas[p]
        while k + 1 < ends[p] and triangle_areas[k] <= rest:
            rest -= triangle_areas[k]
            k += 1
        across = math.sqrt(min(max(rest / triangle_areas[k], 0.0), 1.0))
        along = unit[i, 3]
        nx, ny, nz = normals[p, 0], normals[p, 1], normals[p, 2]
        for j in range(3):
            a, b, c = corners[k, 0, j], corners[k, 1, j], corners[k, 2, j]
            numbers[POINT + j, i] = (1.0 - across) * a + across * ((1.0 - along) * b + along * c)
        dx, dy, dz, cos_air, _ = into_stone(-x, -y, -z, nx, ny, nz, index)
        numbers[DIRECTION, i], numbers[DIRECTION + 1, i], numbers[DIRECTION + 2, i] = dx, dy, dz
        numbers[NORMAL, i], numbers[NORMAL + 1, i], numbers[NORMAL + 2, i] = nx, ny, nz
        numbers[COS_ENTRY, i], numbers[WEIGHT, i], numbers[FACTOR, i] = cos_air, 1.0, 1.0
        for j in range(3):
            numbers[UNFOLD + 4 * j, i] = 1.0  # no reflection yet
        facts[STATUS, i], facts[ENTRY, i], facts[EXIT, i] = INSIDE, facet[p], -1

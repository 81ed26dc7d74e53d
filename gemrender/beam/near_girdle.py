"""Light near the girdle: rays spread evenly over what of the view no polygon tells, in independent sets.

Their places are an additive recurrence (Roberts' R2 sequence: multiples of the reciprocals of the plastic
number and of its square), which can be gone on with, each set shifted at random (Cranley & Patterson 1976).
So each set gives an unbiased score, and their scatter the error.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.facets import FacetStatus, VirtualFacets, kernel_rules
from gemrender.beam.rays import INSIDE, RAY, enter_rays, follow_rays, ray_paths
from gemrender.beam.rim import rim_points
from gemrender.beam.solid import BeamStone
from gemrender.beam.view_area import view_area
from gemrender.measures import inoue
from gemrender.measures.inoue import MET, N_SUMS

__all__ = ["CELLS", "RIM", "SETS", "STUDENT_T", "NearGirdle"]

#: Independent sets of rays; Student's t for their mean with 15 degrees of freedom, two-sided, 99.9 %. More
#: sets have a smaller t, and fewer rays each: for the same rays 16 give the smallest bound.
SETS, STUDENT_T = 16, 4.073
#: The two regions that rays are spread over.
CELLS, RIM = 0, 1

_PLASTIC = 1.3247179572447460
_STEPS = np.array([1 / _PLASTIC, 1 / _PLASTIC**2])
#: A share of the view that is small, and the fewest rays of a set.
_SMALL, _FEWEST = 2e-3, 8
#: Rays of a set that are traced at a time, between two reports of progress.
_BLOCK = 1 << 14
#: Fewer rays than this are not worth a thread.
_THREAD_RAYS = 20_000


class NearGirdle:
    """What rays find of the light that no polygon tells.

    Parameters
    ----------
    convex : BeamStone
        The stone.
    facets : VirtualFacets
        Its polygons.
    seed : int
        Seed of the shifts of the sets.

    Attributes
    ----------
    sums : (SETS, 2, N_SUMS) float64
        What each set has found in the girdle cells and on the rim; areas [girdle radius^2].
    rays : int
        Rays followed so far.
    stopped : bool
        Whether there was no time for the rays that were asked for.
    view_area : float
        Area of the traced part of the view [girdle radius^2].
    cell_area : float
        Area of the girdle cells [girdle radius^2].
    rim_area : float
        Area of the rim [girdle radius^2].
    """

    def __init__(self, convex: BeamStone, facets: VirtualFacets, seed: int) -> None:
        self._convex, self._model, self._rules = convex, facets.model, kernel_rules(facets.model)
        self._shifts = np.random.default_rng(seed).random((SETS, 2, 2))
        self.stopped = False
        self.sums, self.rays, self._done = np.zeros((SETS, 2, N_SUMS)), 0, [0, 0]
        self._seconds = [0.0, 0.0]
        cells = _Cells(facets)
        self._regions: tuple[_Region, _Region] = (cells, _Rim(convex, facets))
        self.cell_area = cells.area
        seen = float(facets.area.sum())
        is_round = facets.stone.is_round  # else polygons tell all of the view
        self.view_area = view_area(convex, facets.view) / facets.parts if is_round else seen
        self.rim_area = max(self.view_area - seen, 0.0)

    def numbers(self, rays: int) -> tuple[int, int]:
        """Share out a set's rays between the girdle cells and the rim, by their areas.

        Where both together are but a small part of the view, less than all of them are enough.
        """
        whole = self.cell_area + self.rim_area + _SMALL * self.view_area
        cells, rim = (
            max(_FEWEST, round(rays * area / whole)) if area > 0 else 0
            for area in (self.cell_area, self.rim_area)
        )
        return cells, rim

    def go_on(
        self,
        numbers: tuple[int, int],
        progress: Callable[[float], None] | None = None,
        budget: Budget | None = None,
    ) -> None:
        """Go on until each set has so many rays in the girdle cells and on the rim, or time is up."""
        for k, region in enumerate(self._regions):
            done = self._done[k]
            if (self.cell_area, self.rim_area)[k] == 0 or done >= numbers[
                k
            ]:  # nowhere to put them, or enough
                continue
            total = self.sums[:, k] * done
            while done < numbers[k]:
                last = min(done + _BLOCK, numbers[k])
                if budget is not None and done:
                    last = min(last, done + self._affordable(k, done, budget))
                    if last == done:
                        self.stopped = True
                        break
                start = time.perf_counter()
                steps = np.arange(done + 1, last + 1)[:, None] * _STEPS
                total += (last - done) * self._trace(region, (self._shifts[:, k, None] + steps) % 1.0)
                self._seconds[k] += time.perf_counter() - start
                done = last
                if progress is not None:
                    progress(done / numbers[k])
            self.sums[:, k] = total / max(done, 1)
            self._done[k] = done

    def _affordable(self, k: int, done: int, budget: Budget) -> int:
        """Return how many more rays of each set there is time for; 0 if too few to be worth it."""
        more = int(done * max(budget.left, 0.0) / self._seconds[k])
        return more if more >= _FEWEST else 0

    def _trace(self, region: _Region, unit: np.ndarray) -> np.ndarray:
        """Follow the rays of all sets through points of the unit square (SETS, n, 2); (SETS, N_SUMS)."""
        solid, facet, rules = self._convex.solid, self._convex.facet, self._rules

        def some_sets(part: np.ndarray) -> np.ndarray:
            n = part.shape[1]
            rays, weights, of = region.rays(part.reshape(-1, 2))
            follow_rays(solid, facet, rules.refractive_index, rules.max_reflections, rays)
            paths = ray_paths(rays, facet, weights / n, self._convex.stone)
            rear = inoue.rear_mask(paths, self._model)
            intensity = inoue.primary_intensity(paths, self._model, rear)
            return inoue.sum_up(paths, rear, intensity, of // n, len(part))

        self.rays += unit.shape[0] * unit.shape[1]
        if unit.shape[0] * unit.shape[1] < _THREAD_RAYS:
            return some_sets(unit)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return np.concatenate(list(pool.map(some_sets, np.array_split(unit, 2 * (os.cpu_count() or 1)))))

    def found(self) -> np.ndarray:
        """Return what each set has found in both regions together, (SETS, N_SUMS) [girdle radius^2].

        What the rays have found on the rim is made to cover just its area.
        """
        rim = self.sums[:, RIM]
        met = rim[:, MET:]
        return np.asarray(self.sums[:, CELLS] + rim * (self.rim_area / np.where(met > 0, met, 1.0)))


class _Region(Protocol):
    """A part of the view that rays can be spread over."""

    def rays(self, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Spread rays over it by points of the unit square (n, 2).

        Returns
        -------
        rays : (m,) array of `rays.RAY`
            Rays inside the stone.
        weights : (m,) float64
            What each counts, if there were but one point in the unit square.
        of : (m,) int64
            The point of the unit square that each was made from.
        """
        ...


class _Cells:
    """The girdle cells, as triangles one after the other; their rays go on where the polygons end."""

    def __init__(self, facets: VirtualFacets) -> None:
        self._facets = facets
        cells = np.flatnonzero(facets.status == FacetStatus.GIRDLE)
        first, number = facets.starts[cells], (facets.ends - facets.starts)[cells] - 2
        self._cell = np.repeat(cells, number)
        # Of each cell a fan of triangles about its first corner.
        apex = np.repeat(first, number)
        second = apex + 1 + np.arange(len(apex)) - np.repeat(np.cumsum(number) - number, number)
        self._triangles = facets.corners[np.stack([apex, second, second + 1], axis=1)]
        a, b = (self._triangles[:, k] - self._triangles[:, 0] for k in (1, 2))
        self._upto = np.cumsum(0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))
        self.area = float(self._upto[-1]) if len(self._upto) else 0.0

    def rays(self, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x = unit[:, 0] * self.area
        k = np.minimum(np.searchsorted(self._upto, x, side="right"), len(self._upto) - 1)
        below = np.where(k > 0, self._upto[k - 1], 0.0)
        across = np.sqrt(np.clip((x - below) / (self._upto[k] - below), 0.0, 1.0))[:, None]
        along = unit[:, 1:]
        a, b, c = self._triangles[k].transpose(1, 0, 2)
        places = (1 - across) * a + across * ((1 - along) * b + along * c)
        cell, paths = self._cell[k], self._facets.paths
        by_place = self._facets.exit_map[cell]
        rays = np.zeros(len(x), RAY)
        rays["status"], rays["exit"] = INSIDE, -1
        rays["reflections"], rays["entry"] = paths.reflections[cell], paths.entry_facet[cell]
        rays["cos_entry"], rays["direction"] = paths.cos_entry[cell], paths.exit_direction[cell]
        rays["point"] = by_place[:, 0] + places[:, :1] * by_place[:, 1] + places[:, 1:] * by_place[:, 2]
        return rays, np.full(len(x), self.area), np.arange(len(x))


class _Rim:
    """What of the view no polygon covers: a narrow rim, and the girdle where it is seen from the side."""

    def __init__(self, convex: BeamStone, facets: VirtualFacets) -> None:
        self._convex, self._facets = convex, facets
        self._reach = facets.stone.reach if facets.view.tilt_deg else 1.0
        # Lines that lie along no edge of a symmetric stone; in a wedge they cross the rim steeply.
        self._azimuth, self._low, self._high = 0.1234, -self._reach, self._reach
        if len(facets.wedge) > 1:
            first, last = facets.stone.symmetry.mirrors[:2]
            self._azimuth = 0.5 * (first + last) + 0.05
            self._low, self._high = np.sin(first - self._azimuth), np.sin(last - self._azimuth)

    def rays(self, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        facets, across = self._facets, self._low + (self._high - self._low) * unit[:, 0]
        places, lengths, lines = rim_points(
            facets.covered, facets.covered_ends, facets.wedge, self._reach, self._azimuth, across, unit[:, 1]
        )
        rays = np.zeros(len(places), RAY)
        enter_rays(
            places, facets.view.basis(), self._convex.solid, self._convex.facet, facets.model.index, rays
        )  # fmt: skip
        return rays, lengths * (self._high - self._low), lines

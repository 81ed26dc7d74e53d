"""Light near the girdle: rays spread evenly over what of the view no polygon tells, in independent sets.

Their places are an additive recurrence (Roberts' R2 sequence: multiples of the reciprocals of the plastic
number and of its square), which can be gone on with, each set shifted at random (Cranley & Patterson 1976).
So each set gives an unbiased score, and their scatter the error.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Protocol

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.cells import Cells
from gemrender.beam.facets import VirtualFacets
from gemrender.beam.rays import Rays, empty_rays, enter_rays, follow_rays, joined_rays, ray_paths
from gemrender.beam.rim import rim_points
from gemrender.beam.solid import BeamStone
from gemrender.beam.view_area import view_area
from gemrender.measures.inoue import MET
from gemrender.measures.tally import SETS, Tally
from gemrender.observation import Model, RayStatus, View
from gemrender.paths import Paths
from gemrender.processors import usable_processors
from gemrender.stone import Stone

__all__ = ["CELLS", "RIM", "STEPS", "UNSEEN", "NearGirdle", "Rim", "by_sets", "more_rays", "next_points"]

#: The regions that rays are spread over: girdle cells of principal light, the rim, and, where all light is
#: followed, cells of what has been reflected in part.
CELLS, RIM, LATER = 0, 1, 2

_PLASTIC = 1.3247179572447460
#: Roberts' R2 sequence: multiples of these.
STEPS = np.array([1 / _PLASTIC, 1 / _PLASTIC**2])
#: The golden ratio as a fraction of 2^64: multiples of it are far apart.
_ODD = np.uint64(0x9E3779B97F4A7C15)
#: What of one ray's share light can be that no ray has met, with the probability 1 - 0.999 (two-sided): of n
#: rays none meets a share p with (1 - p)^n, so p is below -ln(0.0005)/n.
UNSEEN = 7.6
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
        Seed of the shifts of the sets, and of the rays' random numbers.
    tally : Tally, optional
        What is summed up over paths; by default what the paper's score takes.
    later : bool
        Whether what has been reflected in part counts, where polygons have followed it.

    Attributes
    ----------
    sums : (SETS, 2 or 3, n_sums) float64
        What each set has found in each region; areas [girdle radius^2].
    rays : int
        Rays followed so far.
    stopped : bool
        Whether there was no time for the rays that were asked for.
    view_area : float
        Area of the traced part of the view [girdle radius^2].
    areas : tuple of float
        Area of each region; of later light (`Cells.area`), times its share of the light [girdle radius^2].
    """

    def __init__(
        self,
        convex: BeamStone,
        facets: VirtualFacets,
        seed: int,
        tally: Tally | None = None,
        later: bool = True,
    ) -> None:
        self._convex, self._model = convex, facets.model
        self._tally = tally or Tally(facets.view, facets.model)
        self._follows_all = facets.unfolding is not None
        self._seed, self._shifts = seed, _shifts_of(seed)
        cells = Cells(facets, of_principal=True)
        self._regions: list[_Region] = [cells, Rim(convex, facets)]
        seen = float(facets.area @ (facets.paths.partial_reflections == 0))
        is_round = facets.stone.is_round  # else polygons tell all of the view
        self.view_area = view_area(convex, facets.view) / facets.parts if is_round else seen
        self.areas: tuple[float, ...] = (cells.area, max(self.view_area - seen, 0.0))
        if self._follows_all and later:
            reflected = Cells(facets, of_principal=False)
            self._regions.append(reflected)
            self.areas += (reflected.area,)
        n = len(self._regions)
        self.sums, self.rays, self.stopped = np.zeros((SETS, n, self._tally.n_sums)), 0, False
        self._done, self._seconds = [0] * n, [0.0] * n

    @cached_property
    def _random(self) -> np.random.Generator:
        return _drawn(self._seed)[0]

    def numbers(self, rays: int) -> tuple[int, ...]:
        """Share out a set's rays between the regions, by their areas.

        Where all together are but a small part of the view, less than all of them are enough.
        """
        whole = sum(self.areas) + _SMALL * self.view_area
        return tuple(max(_FEWEST, round(rays * area / whole)) if area > 0 else 0 for area in self.areas)

    @property
    def unseen(self) -> tuple[float, float]:
        """Areas of the view, of principal and of all light, that all rays may have missed [girdle radius^2].

        What so few rays meet that all sets may agree by chance, their scatter does not tell.
        """
        each = [
            min(UNSEEN * of.largest / (SETS * done), area) if done else 0.0
            for of, done, area in zip(self._regions, self._done, self.areas, strict=True)
        ]
        return max(each[:LATER]), max(each)

    def go_on(
        self,
        numbers: tuple[int, ...],
        progress: Callable[[float], None] | None = None,
        budget: Budget | None = None,
    ) -> None:
        """Go on until each set has so many rays in each region, or time is up."""
        if not any(self._done) and SETS * sum(numbers) < _THREAD_RAYS:
            self._begin(numbers)
            if progress is not None:
                progress(1.0)
            return
        for k, region in enumerate(self._regions):
            done = self._done[k]
            if self.areas[k] == 0 or done >= numbers[k]:  # nowhere to put them, or enough
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
                total += (last - done) * self._trace(region, self._unit(k, done, last))
                self._seconds[k] += time.perf_counter() - start
                done = last
                if progress is not None:
                    progress(done / numbers[k])
            self.sums[:, k] = total / max(done, 1)
            self._done[k] = done

    def _begin(self, numbers: tuple[int, ...]) -> None:
        """Trace the first rays of all regions together: so few take as long as half of them."""
        start = time.perf_counter()
        there = [k for k, number in enumerate(numbers) if number > 0 and self.areas[k] > 0]
        if not there:
            return
        spread = [
            (self._regions[k], self._unit(k, 0, numbers[k]), self._states(SETS, numbers[k])) for k in there
        ]
        sums = self._tally.sum_up(self._paths(spread), SETS * len(there)).reshape(len(there), SETS, -1)
        rays = sum(numbers[k] for k in there)
        each = (time.perf_counter() - start) / rays
        for k, found in zip(there, sums, strict=True):
            self.sums[:, k], self._done[k], self._seconds[k] = found, numbers[k], each * numbers[k]
        self.rays += SETS * rays

    def _affordable(self, k: int, done: int, budget: Budget) -> int:
        """Return how many more rays of each set there is time for; 0 if too few to be worth it."""
        more = int(done * max(budget.left, 0.0) / self._seconds[k])
        return more if more >= _FEWEST else 0

    def _trace(self, region: _Region, unit: np.ndarray) -> np.ndarray:
        """Follow the rays of all sets through points of the unit square (SETS, n, 2); (SETS, n_sums)."""
        sets, n, _ = unit.shape
        random = self._states(sets, n)

        def some_sets(part: slice) -> np.ndarray:
            paths = self._paths([(region, unit[part], random[part])])
            return self._tally.sum_up(paths, len(unit[part]))

        self.rays += sets * n
        if sets * n < _THREAD_RAYS:
            return some_sets(slice(None))
        return by_sets(some_sets, sets)

    def _unit(self, k: int, done: int, last: int) -> np.ndarray:
        """Return the next points of the unit square for a region, (SETS, last - done, 2)."""
        return next_points(self._shifts[:, k], STEPS, done, last)

    def _states(self, sets: int, n: int) -> np.ndarray:
        """Return states of random numbers, (sets, n) uint64; (sets, 0) for principal light."""
        if not self._follows_all:
            return np.empty((sets, 0), np.uint64)
        return self._random.integers(1, 1 << 63, (sets, n), dtype=np.uint64)

    def _paths(self, spread: Sequence[tuple[_Region, np.ndarray, np.ndarray]]) -> Paths:
        """Follow rays through points of the unit square (sets, n, 2), with random numbers' states (sets, n).

        The sets of a region come after those of the regions before it.
        """
        convex, parts, areas, of_set, before = self._convex, [], [], [], 0
        for region, unit, random in spread:
            sets, n, _ = unit.shape
            rays, each, of = region.rays(unit.reshape(-1, 2), random.reshape(-1))
            parts.append((rays, len(of)))
            areas.append(each / n)
            of_set.append(of // n + before)
            before += sets
        rays = joined_rays(parts)
        follow_rays(convex.solid, convex.facet, self._model.index, self._model.max_reflections, rays)
        return ray_paths(rays, convex.facet, np.concatenate(areas), convex.stone, np.concatenate(of_set))

    def paths(self) -> list[Paths]:
        """Return paths of as many rays as have been followed: areas of all sets together make the regions."""
        out = []
        for k, region in enumerate(self._regions):
            n = self._done[k]
            if n == 0:
                continue
            paths, share = self._paths([(region, self._unit(k, 0, n), self._states(SETS, n))]), 1.0 / SETS
            if k == RIM:  # as `found` has it
                met = (paths.status != RayStatus.MISSED) & (paths.partial_reflections == 0)
                share = self.areas[RIM] / max(float(paths.area @ met), 1e-300)
            out.append(replace(paths, area=paths.area * share))
        return out

    def found(self) -> np.ndarray:
        """Return what each set has found in all regions together, (SETS, n_sums) [girdle radius^2].

        All sets together are made to cover just the rim's area, which is known. (Each set by itself would
        be biased by that, as its rays are few.) What a set differs by is that of a ratio (Cochran, Sampling
        Techniques, 3rd ed., section 6.4).
        """
        rim = self.sums[:, RIM]
        mean = rim.mean(axis=0)
        scale = self.areas[RIM] / mean[MET] if mean[MET] > 0 else 1.0
        differs = rim - rim[:, [MET]] * (mean / mean[MET] if mean[MET] > 0 else 0.0)
        others = sum(self.sums[:, k] for k in range(len(self._regions)) if k != RIM)
        return np.asarray(others + scale * (mean + differs))


@lru_cache(maxsize=4)
def _shifts_of(seed: int) -> np.ndarray:
    """Return the shifts of the sets in each region, (SETS, 3, 2)."""
    return _drawn(seed)[1]


def _drawn(seed: int) -> tuple[np.random.Generator, np.ndarray]:
    """Return a source of random numbers that the shifts have been drawn from, and these."""
    random = np.random.default_rng(seed)
    shifts = [random.random((SETS, n, 2)) for n in (2, 1)]  # the first two whatever is followed
    return random, np.concatenate(shifts, axis=1)


def next_points(shifts: np.ndarray, steps: np.ndarray, done: int, last: int) -> np.ndarray:
    """Return points of the unit cube that go on an additive recurrence, (SETS, last - done, d).

    Parameters
    ----------
    shifts : (SETS, d) float64
        Where each set begins.
    steps : (d,) float64
        From a point to the next one.
    done, last : int
        Points before, and after these.
    """
    unit = shifts[:, None] + np.arange(done + 1, last + 1)[:, None] * steps
    return np.asarray(unit - np.floor(unit))


def more_rays(rays: int, error: float, wanted: float) -> int:
    """Return how many rays should have a wanted error, if so many have another one.

    The error falls as the 3/4th power of the number of rays, and where they run about the girdle for long, so
    that any two of them part, as its root: something between.
    """
    return int(rays * min(max(1.2 * (error / wanted) ** 1.6, 1.5), 8.0))


def by_sets(work: Callable[[slice], np.ndarray], sets: int) -> np.ndarray:
    """Let threads do what is to be done for each set, some sets at a time; join what they return."""
    bounds = np.linspace(0, sets, min(2 * usable_processors(), sets) + 1).astype(int)
    with ThreadPoolExecutor(usable_processors()) as pool:
        return np.concatenate(list(pool.map(work, map(slice, bounds[:-1], bounds[1:]))))


class _Region(Protocol):
    """A part of the view that rays can be spread over.

    Attributes
    ----------
    largest : float
        Were there but one point in the unit square: the largest area that it has stood for; of later light,
        times its share of the light at the eye [girdle radius^2].
    """

    @property
    def largest(self) -> float: ...

    def rays(self, unit: np.ndarray, random: np.ndarray) -> tuple[Rays, np.ndarray, np.ndarray]:
        """Spread rays over it (`Cells.rays`)."""
        ...


class Outlined(Protocol):
    """What is known of a view's outlines (`VirtualFacets`)."""

    @property
    def covered(self) -> np.ndarray: ...
    @property
    def covered_ends(self) -> np.ndarray: ...
    @property
    def wedge(self) -> np.ndarray: ...
    @property
    def stone(self) -> Stone: ...
    @property
    def view(self) -> View: ...
    @property
    def model(self) -> Model: ...


class Rim:
    """What of the view no polygon covers: a narrow rim, and the girdle where it is seen from the side.

    Parameters
    ----------
    convex : BeamStone
        The stone.
    facets : VirtualFacets or ModeFacets
        Its polygons.
    """

    def __init__(self, convex: BeamStone, facets: Outlined) -> None:
        self._convex, self._facets = convex, facets
        self._reach = facets.stone.reach if facets.view.tilt_deg else 1.0
        # Lines that lie along no edge of a symmetric stone, and cross the girdle where it is seen from the
        # side: along it few of them would meet much. In a wedge they cross the rim steeply.
        towards = facets.view.basis()[:2, 2]
        self._azimuth = float(np.arctan2(towards[1], towards[0])) + 0.1234
        self._low, self._high = -self._reach, self._reach
        if len(facets.wedge) > 1:
            first, last = facets.stone.symmetry.mirrors[:2]
            self._azimuth = 0.5 * (first + last) + 0.05
            self._low, self._high = np.sin(first - self._azimuth), np.sin(last - self._azimuth)
        self._told: list[float] = []

    @property
    def largest(self) -> float:
        """The largest area that a line has stood for."""
        return max(self._told, default=0.0)

    def rays(self, unit: np.ndarray, random: np.ndarray) -> tuple[Rays, np.ndarray, np.ndarray]:
        """Spread rays over it: one into each gap of a line for each point of the unit square."""
        facets = self._facets
        places, areas, lines = self.places(unit)
        if len(random):  # the gaps of a line are alike but for their number
            nth = np.arange(len(lines)) - np.searchsorted(lines, lines)
            random = (random[lines] + nth.astype(np.uint64) * _ODD) | np.uint64(1)
        rays = empty_rays(len(places), random)
        enter_rays(
            places, facets.view.basis(), self._convex.solid, self._convex.facet, facets.model.index, rays
        )  # fmt: skip
        return rays, areas, lines

    def places(self, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return places (m, 2), one in each gap of a line for each point of the unit square (n, 2).

        With the area that each stands for, were there but one line (m,), and its line (m,).
        """
        facets, across = self._facets, self._low + (self._high - self._low) * unit[:, 0]
        places, lengths, lines = rim_points(
            facets.covered, facets.covered_ends, facets.wedge, self._reach, self._azimuth, across, unit[:, 1]
        )
        areas = lengths * (self._high - self._low)
        self._told.append(float(np.bincount(lines, areas, 1).max()))
        return places, areas, lines

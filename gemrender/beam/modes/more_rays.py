"""What single rays find of a birefringent stone's light that polygons leave, in independent sets."""

from __future__ import annotations

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.modes.crystal import Biaxial, Uniaxial
from gemrender.beam.modes.facets import ModeFacets, mode_rules
from gemrender.beam.modes.rays import (
    ANGLE,
    COS_ENTRY,
    COS_EXIT,
    ENTERED,
    ENTRY,
    EXIT,
    FACTOR,
    LEAVES,
    PARTIAL,
    REFLECTIONS,
    SECTION_,
    STATUS,
    WEIGHT_,
    D,
    ModeRays,
    X,
    empty_mode_rays,
    enter_mode_rays,
    follow_mode_rays,
    start_mode_rays,
)
from gemrender.beam.modes.shares import empty_facet
from gemrender.beam.near_girdle import UNSEEN, Rim
from gemrender.beam.polygons import GIRDLE_CELL
from gemrender.beam.solid import BeamStone
from gemrender.beam.view_area import view_area
from gemrender.measures.inoue import MET
from gemrender.measures.tally import SETS, Tally
from gemrender.observation import RayStatus
from gemrender.paths import Paths

__all__ = ["LeftToRays"]

#: Rays that are followed at a time.
_BLOCK = 1 << 16


class LeftToRays:
    """What rays find of the light that polygons with modes leave.

    Each of `SETS` sets is unbiased by itself: it draws cells by their area times share of the light, and
    places in them, evenly spread over the list of cells; and lines across the rim of the view.

    Parameters
    ----------
    convex, crystal : BeamStone, Uniaxial or Biaxial
        What is traced.
    facets : ModeFacets
        Its polygons.
    seed : int
        Seed of all that is drawn.
    tally : Tally
        What is summed up over paths.

    Attributes
    ----------
    rays : int
        Rays followed so far.
    light : float
        Share of the view's light that is left to rays.
    stopped : bool
        Whether there was no time for the rays that were asked for.
    """

    def __init__(
        self, convex: BeamStone, crystal: Uniaxial | Biaxial, facets: ModeFacets, seed: int, tally: Tally
    ) -> None:
        self._convex, self._crystal, self._facets, self._tally = convex, crystal, facets, tally
        self._random = np.random.default_rng(seed)
        self._rules = mode_rules(facets.model, 0.0, follows_all=tally.follows_all)
        self._cells = np.flatnonzero(facets.status == GIRDLE_CELL)
        self._weights = facets.paths.weight[self._cells]
        self._upto = np.cumsum(facets.paths.area[self._cells] * self._weights)
        self._cells_area = float(self._upto[-1]) if len(self._cells) else 0.0
        covered = _covered(facets)
        whole = view_area(convex, facets.view) / facets.parts if convex.stone.is_round else covered
        self._rim_area, self._rim = max(whole - covered, 0.0), Rim(convex, facets)
        self._sums = np.zeros((2, SETS, tally.n_sums))
        self._done, self.rays, self.stopped = 0, 0, False
        self.light = (self._cells_area + self._rim_area) / whole

    @property
    def unseen(self) -> float:
        """Area of the view, times share, that all rays may have missed [girdle radius^2]."""
        if not self._done:
            return self._cells_area + self._rim_area
        cells = UNSEEN * self._cells_area / (SETS * self._done)
        return max(cells, UNSEEN * self._rim.largest / (SETS * self._done) if self._rim_area else 0.0)

    def go_on(self, number: int, budget: Budget | None = None) -> None:
        """Go on until each set has so many rays in the cells, and so many lines across the rim."""
        if not self.light:
            return
        at_a_time = max(_BLOCK // SETS, 1)
        while self._done < number:
            n = min(number - self._done, at_a_time, max(self._done, 256))
            if budget is not None and self._done and budget.left <= 0.0:
                self.stopped = True
                return
            if self._cells_area:
                self._sums[0] += n * self._tally.sum_up(self._of_cells(n), SETS)
            if self._rim_area:
                self._sums[1] += n * self._tally.sum_up(self._of_rim(n), SETS)
            self._done += n

    def found(self) -> np.ndarray:
        """Return what each set has found, (SETS, n_sums) [girdle radius^2]; as `NearGirdle.found`."""
        cells, rim = self._sums / max(self._done, 1)
        mean = rim.mean(axis=0)
        scale = self._rim_area / mean[MET] if mean[MET] > 0 else 1.0
        differs = rim - rim[:, [MET]] * (mean / mean[MET] if mean[MET] > 0 else 0.0)
        return np.asarray(cells + scale * (mean + differs))

    def _of_cells(self, n: int) -> Paths:
        """Follow n rays of each set from the cells."""
        facets, total = self._facets, SETS * n
        drawn = (np.arange(n) + self._random.random((SETS, n))) / n
        which = np.searchsorted(self._upto, drawn.reshape(-1) * self._cells_area, side="right")
        which = np.minimum(which, len(self._cells) - 1)
        rays = self._empty(total)
        if facets.images_of_nodes is not None:
            rays.images[:] = facets.images_of_nodes[facets.node[self._cells[which]]]
        start_mode_rays(
            facets.polygons, facets.nodes, facets.waves, self._cells[which], facets.view.basis(),
            self._convex.solid.planes, rays,
        )  # fmt: skip
        area = self._cells_area / n / self._weights[which]
        return self._followed(rays, area, np.repeat(np.arange(SETS), n))

    def _empty(self, n: int) -> ModeRays:
        return empty_mode_rays(
            n, self._random, follows_all=self._rules.follows_all, needs_images=self._tally.needs_images
        )  # fmt: skip

    def _of_rim(self, n: int) -> Paths:
        """Follow rays of each set from n lines across the rim."""
        unit = self._random.random((SETS, n, 2))
        unit[..., 0] = (np.arange(n) + unit[..., 0]) / n
        places, area, lines = self._rim.places(unit.reshape(-1, 2))
        rays = self._empty(len(places))
        enter_mode_rays(
            self._convex.solid, self._crystal, self._facets.view.basis(), places, empty_facet(), rays
        )  # fmt: skip
        return self._followed(rays, area / n, lines // n)

    def _followed(self, rays: ModeRays, area: np.ndarray, of_set: np.ndarray) -> Paths:
        """Follow rays that stand for areas (n,) of sets (n,)."""
        now = rays._replace(numbers=rays.numbers[0].copy(), facts=rays.facts[0].copy())
        follow_mode_rays(self._convex.solid, self._crystal, self._rules, empty_facet(), now, rays)
        self.rays += len(of_set)
        numbers, facts, facet = rays.numbers, rays.facts, self._convex.facet
        again = len(facts) // max(len(of_set), 1)
        status, exits = facts[:, STATUS], facts[:, STATUS] == RayStatus.EXITED
        return Paths(
            area=np.tile(area, again) * np.where(numbers[:, FACTOR] > 0.0, numbers[:, FACTOR], 1.0),
            weight=numbers[:, WEIGHT_],
            status=status,
            reflections=facts[:, REFLECTIONS],
            partial_reflections=np.where(status == RayStatus.MISSED, 0, facts[:, PARTIAL]),
            entry_facet=facet[facts[:, ENTRY]],
            exit_facet=np.where(exits, facet[facts[:, EXIT]], -1),
            cos_entry=numbers[:, COS_ENTRY],
            cos_exit=np.where(exits, numbers[:, COS_EXIT], 0.0),
            exit_point=numbers[:, X : X + 3],
            exit_direction=numbers[:, D : D + 3],
            entering=numbers[:, ENTERED],
            leaving=np.where(exits, numbers[:, LEAVES], 0.0),
            section=numbers[:, SECTION_],
            image_angle=numbers[:, ANGLE] if self._tally.needs_images else None,
            set_number=np.tile(of_set, again),
            stone=self._convex.stone,
        )


def _covered(facets: ModeFacets) -> float:
    """Return the area of the facets' outlines in the view [girdle radius^2]."""
    first = facets.paths.partial_reflections == 0
    return float(facets.paths.area[first].sum()) + facets.unaccounted

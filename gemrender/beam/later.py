"""What polygons leave of light that has been reflected in part, and how it changes when planes move.

Polygons follow such light down to a least share; so much as is left lies in cells, whose corners, share of
the light, place and direction inside the stone all have exact derivatives. Rays are spread over these cells,
each with its cell a little to either side: what all cells have together grows exactly, and how the mean of
what the rays find changes is a difference quotient of the very same rays, in independent sets.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from gemrender.beam.cells import cell_starts, fans, spread, triangle_areas
from gemrender.beam.compiled import STEP
from gemrender.beam.near_girdle import STEPS, by_sets, next_points
from gemrender.beam.polygons import GIRDLE_CELL, Traced
from gemrender.beam.rays import empty_rays, follow_rays, ray_paths
from gemrender.beam.solid import BeamStone
from gemrender.measures.tally import REST, SETS, Tally
from gemrender.optics.fresnel import transmittance
from gemrender.paths import Paths

__all__ = ["LaterCells"]

#: Step of the difference quotient: cells change by this share of themselves, and planes move by no more than
#: so much [stone's unit]. A hundred times smaller ones have the same means and ten times the scatter, up to
#: where so few rays part that chance may show none.
_CHANGE, _FURTHEST = 1.0, 2e-4


class LaterCells:
    """The cells of light that has been reflected in part.

    Parameters
    ----------
    convex : BeamStone
        The stone.
    planes : (p, 4) complex128
        Its planes with derivatives.
    traced : Traced
        All light, traced with these planes.
    paths : Paths
        Its paths.
    unfolding : (k, 3, 3) complex128
        Of its nodes.
    tally : Tally
        Measures, view and model.

    Attributes
    ----------
    amount : complex
        Area times the share of the light at the eye that is in them [stone's unit^2].
    """

    def __init__(
        self,
        convex: BeamStone,
        planes: np.ndarray,
        traced: Traced,
        paths: Paths,
        unfolding: np.ndarray,
        tally: Tally,
    ) -> None:
        self._convex, self._planes, self._tally = convex, planes, tally
        cells = np.flatnonzero((traced.facts[:, 0] == GIRDLE_CELL) & (paths.partial_reflections > 0))
        ends = traced.ends[cells]
        of, corners = fans(np.where(cells > 0, traced.ends[cells - 1], 0), ends)
        triangles = traced.corners[corners]
        areas = triangle_areas(triangles)
        share = paths.weight[cells] * transmittance(paths.cos_entry[cells], tally.model.index)
        amounts = areas * share[of]
        grows = np.abs(amounts.imag) / STEP
        self.amount, growth = complex(amounts.sum()), float(grows.sum())
        # As many rays to where cells change most as to where most of the light is.
        chance = np.abs(amounts.real) / max(self.amount.real, 1e-300)
        if growth > 0.0:
            chance = 0.5 * (chance + grows / growth)
        kept = np.flatnonzero(chance > 0.0)
        self._of, self._chance = of[kept], chance[kept] / chance[kept].sum()
        self._triangles, self._areas = triangles[kept], areas[kept]
        self._maps = traced.beams[cells, :9].reshape(-1, 3, 3)
        self._paths, self._unfolding = paths.rows(cells), unfolding[traced.facts[cells, 1]]
        moves = float(np.abs(planes.imag).max()) / STEP
        self._step = min(
            _CHANGE * self.amount.real / max(growth, 1e-300), _FURTHEST / max(moves, 1e-300)
        )  # fmt: skip

    def sums(self, seed: int, rays: int) -> np.ndarray:
        """Return the sums of all channels of the tally's measures with their derivatives, by sets of rays.

        Parameters
        ----------
        seed : int
            Seed of the sets' shifts, and of the rays' random numbers.
        rays : int
            Rays of each set.

        Returns
        -------
        (SETS, k) complex128
            Areas times contributions [stone's unit^2].
        """
        if not len(self._of):
            return np.zeros((SETS, self._tally.n_sums - REST - 1), complex)
        random = np.random.default_rng(seed)
        unit = next_points(random.random((SETS, 2)), STEPS, 0, rays)
        states = random.integers(1, 1 << 63, unit.shape[:2], dtype=np.uint64)
        low, high = (self._side(by, unit, states) for by in (-self._step, self._step))
        # Of each set what its rays find in per unit of what they have been given.
        low_mean, high_mean = (side[:, 1:] / side[:, :1] for side in (low, high))
        mean, changes = 0.5 * (low_mean + high_mean), (high_mean - low_mean) / (2.0 * self._step)
        return np.asarray(self.amount * mean + 1j * STEP * self.amount.real * changes)

    def _side(self, by: float, unit: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Follow rays with the parameter changed; return what they were given, and found, (SETS, 1 + k)."""
        convex, tally = self._convex, self._tally
        planes = _moved(self._planes, by)
        planes /= np.linalg.norm(planes[:, :3], axis=1)[:, None]
        solid = convex.solid._replace(planes=planes, values=planes, columns=np.ascontiguousarray(planes.T))
        columns = {field.name: getattr(self._paths, field.name) for field in fields(self._paths)}
        moved: dict[str, Any] = {name: _moved(of, by) for name, of in columns.items() if np.iscomplexobj(of)}
        of_cells = replace(self._paths, **moved)
        starts, maps = cell_starts(of_cells, _moved(self._unfolding, by)), _moved(self._maps, by)
        triangles, upto = _moved(self._triangles, by), np.cumsum(self._chance)
        share = of_cells.weight * transmittance(of_cells.cos_entry, tally.model.index)
        areas = _moved(self._areas, by) / self._chance
        amounts = areas * share[self._of]
        by_triangle = np.arange(len(self._of))
        starts = starts._replace(numbers=starts.numbers[:, self._of], facts=starts.facts[:, self._of])
        maps = maps[self._of]

        def some_sets(part: slice) -> np.ndarray:
            sets, n = states[part].shape
            rays = empty_rays(sets * n, states[part].reshape(-1).copy())
            chosen = np.empty(sets * n, np.int64)
            spread(unit[part].reshape(-1, 2), upto, triangles, by_triangle, maps, starts, rays, chosen)
            follow_rays(solid, convex.facet, tally.model.index, tally.model.max_reflections, rays)
            of = np.repeat(np.arange(sets), n)
            paths = ray_paths(rays, convex.facet, areas[chosen] / n, convex.stone, of)
            given = np.bincount(of, amounts[chosen] / n, sets)
            return np.column_stack([given, tally.sum_up(paths, sets)[:, REST + 1 :]])

        return by_sets(some_sets, SETS)


def _moved(values: np.ndarray, by: float) -> np.ndarray:
    """Return what values become when the parameter changes by so little."""
    return np.ascontiguousarray(values.real + values.imag * (by / STEP))

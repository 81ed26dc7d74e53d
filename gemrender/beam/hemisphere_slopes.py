"""How measures over all views from above change when a stone's planes move.

Light that falls in from all around makes them smooth: a facet that comes to the critical angle or the
horizon in one view has just left it in the next one. So a difference quotient tells their derivatives, of the
very same rays through the stone a little to either side, in independent sets; with twice the step it is off
by four times as much, which tells by how much.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.cells import fans
from gemrender.beam.compiled import STEP
from gemrender.beam.hemisphere import HEMISPHERE_STEPS, Crown, sector_of
from gemrender.beam.near_girdle import by_sets, next_points
from gemrender.beam.polygons import seen_outlines
from gemrender.beam.rays import follow_rays, ray_paths
from gemrender.beam.rules import Solid
from gemrender.beam.solid import BeamStone
from gemrender.errors import InputError
from gemrender.measures.measure import Measure
from gemrender.measures.tally import SETS, Tally, bounds_of_sets
from gemrender.observation import Model, View
from gemrender.stone.facets import CROWN

__all__ = ["hemisphere_slopes"]

#: Step of the difference quotient: by so much planes move [stone's unit]; some 0.5 % or degrees.
_MOVES = 1e-2
#: Rays of a set at first and at the most, and by how much they are increased.
_FIRST, _MOST, _MORE = 2048, 1 << 14, 4


def hemisphere_slopes(
    convex: BeamStone,
    planes: np.ndarray,
    model: Model,
    measures: Sequence[Measure],
    *,
    wanted: float,
    seed: int,
    whole: bool,
    budget: Budget,
    left: int = 1,
) -> np.ndarray:
    """Differentiate measures of the hemisphere of views by a parameter.

    Parameters
    ----------
    convex : BeamStone
        The stone.
    planes : (p, 4) complex128
        Its planes with derivatives by the parameter.
    model : Model
        The optical model.
    measures : sequence of Measure
        The measures; their values are shares, 0 to 1.
    wanted : float
        Wanted bound by the scatter of sets [% per unit].
    seed : int
        Seed of the rays.
    whole : bool
        Whether planes do not move as the stone's symmetry has it.
    budget : Budget
        Time to keep to.
    left : int
        So many parameters are to share what time is left.

    Returns
    -------
    (2, SETS, n) float64
        Derivatives of the values by each set of rays, with how much it bends added and taken off:
        half of what both differ by is how far a quotient may be off for that.

    Raises
    ------
    InputError
        The stone has no crown.
    """
    moves = float(np.abs(planes.imag).max()) / STEP
    keys = [measure.smooth_keys for measure in measures]
    if not moves:
        return np.zeros((2, SETS, sum(map(len, keys))))
    step, rays = _MOVES / moves, _FIRST
    sides = {by: _Side(convex, planes, by * step, model, measures, whole) for by in (-2, -1, 1, 2)}
    while True:
        before = budget.seconds
        found = {by: side.values(seed, rays) for by, side in sides.items()}
        near, far = ((found[by] - found[-by]) / (2.0 * by * step) for by in (1, 2))
        is_late = _MORE * left * (budget.seconds - before) > budget.left
        if 100.0 * float(bounds_of_sets(near).max()) <= wanted or rays >= _MOST or is_late:
            bend = np.abs(near.mean(axis=0) - far.mean(axis=0))
            return np.array([near + bend, near - bend])
        rays = min(rays * _MORE, _MOST)


class _Side:
    """A stone with its planes moved, and light that falls on its crown."""

    def __init__(
        self,
        convex: BeamStone,
        planes: np.ndarray,
        by: float,
        model: Model,
        measures: Sequence[Measure],
        whole: bool,
    ) -> None:
        moved = planes.real + planes.imag * (by / STEP)
        moved /= np.linalg.norm(moved[:, :3], axis=1)[:, None]
        self._solid = convex.solid._replace(
            planes=moved, values=moved, columns=np.ascontiguousarray(moved.T)
        )  # fmt: skip
        sector = (0.0, 2 * np.pi) if whole else sector_of(convex)
        self._crown = _crown_of(convex, self._solid, sector)
        self._convex, self._tally = convex, Tally(View(resolution=1), model, measures)

    def values(self, seed: int, rays: int) -> np.ndarray:
        """Return the values by each set of rays, (SETS, n)."""
        convex, model, tally = self._convex, self._tally.model, self._tally
        random = np.random.default_rng(seed)
        unit = next_points(random.random((SETS, 4)), HEMISPHERE_STEPS, 0, rays)
        states = random.integers(1, 1 << 63, unit.shape[:2], dtype=np.uint64)

        def some_sets(part: slice) -> np.ndarray:
            sets, n = states[part].shape
            inside, areas = self._crown.rays(unit[part].reshape(-1, 4), states[part].reshape(-1), model.index)
            follow_rays(self._solid, convex.facet, model.index, model.max_reflections, inside)
            of = np.repeat(np.arange(sets), n)
            return tally.sum_up(ray_paths(inside, convex.facet, areas, convex.stone, of), sets)

        values = tally.values(by_sets(some_sets, SETS))
        return np.concatenate(
            [of[:, [each.keys.index(key) for key in each.smooth_keys]] for each, of in zip(
                tally.measures, values, strict=True)],
            axis=1,
        )  # fmt: skip


def _crown_of(convex: BeamStone, solid: Solid, sector: tuple[float, float]) -> Crown:
    """Return the crown of planes that have moved: what the eye sees of them from straight above."""
    basis = View(resolution=1).basis()
    outlines, ends = seen_outlines(solid, basis)
    is_crown = np.array([side == CROWN for side in convex.stone.facet_sides])[convex.facet[:-1]]
    chosen = np.flatnonzero(is_crown & (np.diff(ends, prepend=0) > 2))
    if not len(chosen):
        raise InputError("has no crown, which light could fall on", source=convex.stone.name)
    of, corners = fans(np.append(0, ends)[chosen], ends[chosen])
    places = outlines[corners] @ basis[:2]
    planes = solid.values[chosen][of]
    # Along the axis to the plane of each.
    height = (planes[:, None, 3] - (places * planes[:, None, :3]).sum(axis=2)) / planes[:, None, 2]
    places[..., 2] += height
    return Crown(
        places, np.searchsorted(of, np.arange(len(chosen)), side="right"), solid.values[chosen, :3],
        convex.facet[chosen], sector,
    )  # fmt: skip

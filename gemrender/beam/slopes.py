"""How the scores of a stone with a round girdle change when its planes move, near the girdle too.

Near the girdle there are no virtual facets. What is exact there too is how its share of the view grows. How
the mean of its light changes is a difference quotient of rays, with its error; it is small, and from one
hundredth of a unit to the next too rough for a derivative to mean anything.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.compiled import STEP
from gemrender.beam.derivatives import facet_sides, smooth_values
from gemrender.beam.facets import VirtualFacets, trace_facets
from gemrender.beam.measure import PRINCIPAL_NORMALS, polygon_sums
from gemrender.beam.near_girdle import CELLS, NearGirdle
from gemrender.beam.solid import beam_stone
from gemrender.errors import InputError
from gemrender.measures.inoue import INTENSITY, MET, REAR
from gemrender.measures.tally import REST, Tally, bounds_of_sets
from gemrender.observation import LIGHT_LEVEL
from gemrender.stone import Stone

__all__ = ["Scored", "has_room", "refuse_left_over", "slopes_within"]

#: In one round of rays polygons are traced so many times a parameter; a budget lets them run for 0.4 of its
#: time.
_TRACES = 2

#: Steps of the difference quotient near the girdle [% or deg]; a smaller one is taken where the girdle cells
#: are not the same ones on both sides, told by their area, which may be off by this share.
_QUOTIENT_STEPS, _SAME_CELLS = (0.05, 0.02, 0.01, 0.005), 0.02
#: Rays of each set and side at first and at the most, and by how much they are increased.
_RAYS, _MOST_RAYS, _MORE = 1024, 8192, 4

#: The stone with one parameter changed by so much.
Moved = Callable[[Stone, float], Stone]


def slopes_within(
    stone: Stone,
    changes: Sequence[tuple[np.ndarray, Moved]],
    tally: Tally,
    wanted: float,
    seed: int,
    budget: Budget,
    progress: Callable[[float], None] | None,
) -> tuple[Scored, list[np.ndarray]]:
    """Differentiate scores by each of the changes, with more rays until the bounds are as wanted.

    Parameters
    ----------
    stone : Stone
        The stone.
    changes : sequence of pair
        Of each parameter the planes with their derivatives by it, (p, 4) complex128, and what makes the stone
        with the parameter changed.
    tally : Tally
        View, model, and further measures.
    wanted, seed, budget, progress
        As of `gemrender.beam.sensitivity.sensitivity`; the bound wanted is of the slopes themselves.

    Returns
    -------
    (Scored, list of (1 or 2, SETS, 2 + n) float64)
        The stone with its light, and the derivatives of Average, Rear and the values of measures by each set
        of rays, of two sides where they differ (`facet_sides`) [% per unit].
    """
    rays = _RAYS
    # Values of other units than per cent do not steer, as in `measure`.
    steers = np.array([True, True, *(of.unit == "%" for of in tally.measures for _ in of.smooth_keys)])
    while True:
        before = budget.seconds
        part = Budget(budget.time_limit / (_TRACES * len(changes)), budget.memory_limit)
        base = Scored(stone, tally, seed, rays, budget=part)
        slopes = []
        for done, (planes, moved) in enumerate(changes, start=1):
            slopes.append(_slope(base, planes, moved, seed))
            if progress is not None:
                progress(done / len(changes))
        reached = max(float(np.nanmax(bounds_of_sets(slope.mean(axis=0)[:, steers]))) for slope in slopes)
        if reached <= wanted or rays >= _MOST_RAYS or _MORE * (budget.seconds - before) > budget.left:
            return base, slopes
        rays *= _MORE


def has_room(stone: Stone, moved: Moved) -> bool:
    """Tell whether a parameter can be changed by a step of the difference quotient, to one side at least."""
    for by in (-_QUOTIENT_STEPS[-1], _QUOTIENT_STEPS[-1]):
        with contextlib.suppress(InputError):
            moved(stone, by)
            return True
    return False


def refuse_left_over(facets: VirtualFacets, stone: Stone) -> None:
    """Refuse a stone whose virtual facets were not all found within a budget."""
    if facets.left_over:
        raise InputError(
            f"falls into more virtual facets than can be differentiated: {facets.why_left_over}",
            source=stone.source or stone.name,
        )


class Scored:
    """A stone with its virtual facets and its light near the girdle."""

    def __init__(
        self,
        stone: Stone,
        tally: Tally,
        seed: int,
        rays: int,
        numbers: tuple[int, ...] | None = None,
        budget: Budget | None = None,
    ) -> None:
        self.stone, self.tally = stone, tally
        self.convex = beam_stone(stone)
        facets = trace_facets(
            self.convex, view=tally.view, model=tally.model, whole=not tally.is_axial, budget=budget,
            least=PRINCIPAL_NORMALS if tally.needs_normals else 0.0,
        )  # fmt: skip
        refuse_left_over(facets, stone)
        self.resolved = polygon_sums(tally, facets)
        near = NearGirdle(self.convex, facets, seed, tally, later=False)
        self.numbers = numbers or near.numbers(rays)
        near.go_on(self.numbers)
        self.near, self.cell_area, self.area = near.found(), near.areas[CELLS], near.view_area

    def scores(self) -> np.ndarray:
        """Average and Rear by each set of rays, (SETS, 2) [%]."""
        return np.asarray(100.0 * (self.resolved + self.near)[:, [INTENSITY, REAR]] / self.area)

    def values(self) -> np.ndarray:
        """Average, Rear and the values of measures by each set of rays, (SETS, 2 + n)."""
        return np.hstack([self.scores(), smooth_values(self.tally, np.array(self.area), self.sums()[:, 2:])])

    def sums(self) -> np.ndarray:
        """Return the sums of intensity, rear light and all channels by each set, (SETS, 2 + k) [unit^2]."""
        return np.asarray((self.resolved + self.near)[:, _summed(self.tally)])

    def near_means(self) -> np.ndarray:
        """Means near the girdle: intensity, share of rear light, and channels, by each set, (SETS, 2 + k)."""
        met = self.near[:, [MET]]
        return np.asarray(self.near[:, _summed(self.tally)] / np.where(met > 0, met, 1.0))

    @property
    def girdle(self) -> float:
        """Share of the view that no virtual facet tells [%]."""
        return float(100.0 * (1.0 - self.resolved[MET] / self.area))

    def moved(self, moved: Moved, by: float, seed: int) -> Scored:
        """Return the stone with one parameter changed, scored by the very same rays."""
        return Scored(moved(self.stone, by), self.tally, seed, 0, self.numbers)


def _summed(tally: Tally) -> list[int]:
    """Return the columns of a tally that are differentiated: intensity, rear light, and all channels."""
    return [INTENSITY, REAR, *range(REST + 1, tally.n_sums)]


def _slope(base: Scored, planes: np.ndarray, moved: Moved, seed: int) -> np.ndarray:
    """Differentiate Average, Rear and values of measures by a parameter, (1 or 2, SETS, 2 + n)."""
    tally = base.tally
    totals = facet_sides(base.convex, planes, tally, whole=not tally.is_axial).imag / STEP
    resolved, cells = totals[:, 2, None, None], float(totals[:, 3].mean())
    for step in _QUOTIENT_STEPS:
        low, high, between = _sides(base, moved, step, seed)
        grown = high.cell_area - low.cell_area - between * cells
        if abs(grown) <= _SAME_CELLS * base.cell_area:
            break
    grows = (high.area - low.area) / between
    near, near_grows = base.area - base.resolved[MET], grows - resolved
    change = (high.near_means() - low.near_means()) / between
    near_slope = base.near_means() * near_grows + near * change
    sums = np.delete(totals, (2, 3), axis=1)[:, None] + near_slope
    slope = sums[..., :2] - base.scores() / LIGHT_LEVEL * grows
    area = np.array(complex(base.area, STEP * grows))
    values = smooth_values(tally, area, (base.sums() + 1j * STEP * sums)[..., 2:])
    return np.concatenate([LIGHT_LEVEL * slope / base.area, values.imag / STEP], axis=-1)


def _sides(base: Scored, moved: Moved, step: float, seed: int) -> tuple[Scored, Scored, float]:
    """Return the stone with a parameter a step smaller and a step larger, and how far apart [its unit].

    At the end of the allowed range the stone itself is one of the two.
    """
    sides, between = [], 0.0
    for by in (-step, step):
        try:
            sides.append(base.moved(moved, by, seed))
        except InputError:
            sides.append(base)
        else:
            between += step
    if not between:
        raise InputError("leaves no room for a difference on either side", source=base.stone.name)
    return sides[0], sides[1], between

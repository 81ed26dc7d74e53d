"""How the scores of a stone with a round girdle change when its planes move, near the girdle too.

Near the girdle there are no virtual facets. What is exact there too is how its share of the view grows. How
the mean of its light changes is a difference quotient of rays, with its error; it is small, and from one
hundredth of a unit to the next too rough for a derivative to mean anything.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence

import numpy as np

from gemrender.beam.budget import TIME_RANGE, Budget
from gemrender.beam.compiled import STEP
from gemrender.beam.derivatives import score_slopes, smooth_values
from gemrender.beam.facets import trace_facets
from gemrender.beam.hemisphere_slopes import hemisphere_slopes
from gemrender.beam.measure import PRINCIPAL_NORMALS, polygon_sums
from gemrender.beam.near_girdle import CELLS, NearGirdle
from gemrender.beam.solid import BeamStone, beam_stone
from gemrender.beam.totals import facet_sides, least_share, refuse_left_over, side_sums
from gemrender.errors import InputError
from gemrender.measures.inoue import INTENSITY, MET, REAR
from gemrender.measures.measure import Measure
from gemrender.measures.tally import REST, Tally, bounds_of_sets
from gemrender.observation import LIGHT_LEVEL
from gemrender.stone import Stone

__all__ = ["Scored", "exact_slopes", "has_room", "slopes_within"]

#: In one round of rays polygons are traced so many times a parameter; a budget lets them run for 0.4 of its
#: time.
_TRACES = 2

#: Steps of the difference quotient near the girdle [% or deg]; a smaller one is taken where the girdle cells
#: are not the same ones on both sides, told by their area, which may be off by this share.
_QUOTIENT_STEPS, _SAME_CELLS = (0.05, 0.02, 0.01, 0.005), 0.02
#: Rays of each set and side at first and at the most, and by how much they are increased.
_RAYS, _MOST_RAYS, _MORE = 1024, 8192, 4
#: So many times as many where polygons leave later light, which rays of principal light say nothing of.
_LATER = 4

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
    over_views: Sequence[Measure] = (),
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
    over_views : sequence of Measure
        Measures of the hemisphere of views, whose values come last.

    Returns
    -------
    (Scored, list of (1 or 2, SETS, 2 + n) float64)
        The stone with its light, and the derivatives of Average, Rear and the values of measures by each set
        of rays, of two sides where they differ (`facet_sides`) [% per unit].
    """
    rays, least = _RAYS, _least_near(stone, tally, budget)
    while True:
        before = budget.seconds
        part = Budget(
            max(budget.time_limit / (_TRACES * len(changes)), TIME_RANGE[0]), budget.memory_limit
        )  # fmt: skip
        base = Scored(stone, tally, seed, rays, budget=part)
        slopes = []
        for done, (planes, moved) in enumerate(changes, start=1):
            slopes.append(_slope(base, planes, moved, seed, least))
            if progress is not None:
                progress(done / len(changes))
        reached = max(_reached(tally, slope) for slope in slopes)
        if reached <= wanted or rays >= _MOST_RAYS or _MORE * (budget.seconds - before) > budget.left:
            break
        rays = min(rays * _MORE, _MOST_RAYS)
    if over_views:
        moving = [planes for planes, _ in changes]
        more = _over_views(
            base.convex, moving, tally, over_views, wanted, seed, budget, progress, whole=False
        )  # fmt: skip
        slopes = [_joined(slope, of) for slope, of in zip(slopes, more, strict=True)]
    return base, slopes


def _over_views(
    convex: BeamStone,
    moving: Sequence[np.ndarray],
    tally: Tally,
    measures: Sequence[Measure],
    wanted: float,
    seed: int,
    budget: Budget,
    progress: Callable[[float], None] | None,
    *,
    whole: bool,
) -> list[np.ndarray]:
    """Differentiate measures of the hemisphere of views, (2, SETS, n) by each parameter."""
    out = []
    for done, planes in enumerate(moving):
        left = len(moving) - done
        out.append(
            hemisphere_slopes(
                convex, planes, tally.model, measures,
                wanted=wanted, seed=seed, whole=whole, budget=budget, left=left,
            )
        )  # fmt: skip
        if progress is not None:
            progress(1.0 - (left - 1) / len(moving))
    return out


def _joined(slopes: np.ndarray, more: np.ndarray) -> np.ndarray:
    """Put derivatives of some values behind those of others: sides and sets as many as either has."""
    sides = np.broadcast_shapes(slopes.shape[:2], more.shape[:2])
    return np.concatenate([np.broadcast_to(of, (*sides, of.shape[2])) for of in (slopes, more)], axis=2)


def _least_near(stone: Stone, tally: Tally, budget: Budget) -> float:
    """Return the least share that all light is followed to; refuse a stone of too many virtual facets."""
    if not tally.follows_all:
        return 1.0  # none
    return least_share(beam_stone(stone), tally, whole=not tally.is_axial, budget=budget)


def _reached(tally: Tally, slopes: np.ndarray) -> float:
    """Return the largest bound of slopes (1 or 2, SETS, 2 + n) by the scatter of sets."""
    # Values of other units than per cent do not steer, as in `measure`.
    steers = np.array([True, True, *(of.unit == "%" for of in tally.measures for _ in of.smooth_keys)])
    sets = slopes.mean(axis=0)[:, steers]
    return float(np.nanmax(bounds_of_sets(sets), initial=0.0)) if len(sets) > 1 else 0.0


def exact_slopes(
    convex: BeamStone,
    changes: Sequence[tuple[np.ndarray, float]],
    tally: Tally,
    wanted: float,
    seed: int,
    budget: Budget,
    progress: Callable[[float], None] | None,
    over_views: Sequence[Measure] = (),
    *,
    whole: bool,
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Differentiate scores of a stone whose principal light is nothing but polygons.

    Parameters
    ----------
    convex : BeamStone
        The stone.
    changes : sequence of (planes, scale)
        Of each parameter the planes with their derivatives, (p, 4) complex128, and a factor of the slopes.
    tally, wanted, seed, budget, progress, over_views
        As for `slopes_within`. Only where all light is followed some of it is left to rays.
    whole : bool
        Whether planes do not move as the stone's symmetry has it.

    Returns
    -------
    ((2 + n,) float64, list of (1 or 2, SETS or 1, 2 + n) float64)
        Average, Rear and the values of measures, and their derivatives by each.

    Raises
    ------
    InputError
        There are more virtual facets than can be differentiated within the budget.
    """
    least = least_share(convex, tally, whole=whole, budget=budget)
    scores, out = np.zeros(2), []
    for done, (planes, scale) in enumerate(changes, start=1):
        sides = facet_sides(convex, planes, tally, whole=whole or not tally.is_axial, least=least)
        rays = _RAYS
        while True:
            before = budget.seconds
            scores, slopes = score_slopes(tally, side_sums(sides, seed, _LATER * rays))
            slopes *= scale
            # What the other parameters take is not known: each has its part of the time that is left.
            is_late = _MORE * (budget.seconds - before) * (len(changes) - done + 1) > budget.left
            if _reached(tally, slopes) <= wanted or rays >= _MOST_RAYS or is_late:
                break
            rays = min(rays * _MORE, _MOST_RAYS)
        out.append(slopes)
        if progress is not None:
            progress(done / len(changes))
    if over_views:
        moving = [planes for planes, _ in changes]
        more = _over_views(convex, moving, tally, over_views, wanted, seed, budget, progress, whole=whole)
        scales = [scale for _, scale in changes]
        out = [_joined(slope, scale * of) for slope, scale, of in zip(out, scales, more, strict=True)]
    return scores, out


def has_room(stone: Stone, moved: Moved) -> bool:
    """Tell whether a parameter can be changed by a step of the difference quotient, to one side at least."""
    for by in (-_QUOTIENT_STEPS[-1], _QUOTIENT_STEPS[-1]):
        with contextlib.suppress(InputError):
            moved(stone, by)
            return True
    return False


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
        self.stone, self.tally, self.rays = stone, tally, rays
        self.convex = beam_stone(stone)
        facets = trace_facets(
            self.convex, view=tally.view, model=tally.model, whole=not tally.is_axial, budget=budget,
            least=PRINCIPAL_NORMALS if tally.needs_normals or tally.follows_all else 0.0,
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


def _slope(base: Scored, planes: np.ndarray, moved: Moved, seed: int, least: float) -> np.ndarray:
    """Differentiate Average, Rear and values of measures by a parameter, (1 or 2, SETS, 2 + n)."""
    tally = base.tally
    sides = facet_sides(base.convex, planes, tally, whole=not tally.is_axial, least=least)
    found = side_sums(sides, seed, _LATER * base.rays)
    totals = found.imag / STEP
    resolved, cells = totals[:, :, 2, None], float(totals[:, 0, 3].mean())
    for step in _QUOTIENT_STEPS:
        low, high, between = _sides(base, moved, step, seed)
        grown = high.cell_area - low.cell_area - between * cells
        if abs(grown) <= _SAME_CELLS * base.cell_area:
            break
    grows = (high.area - low.area) / between
    near, near_grows = base.area - base.resolved[MET], grows - resolved
    change = (high.near_means() - low.near_means()) / between
    near_slope = base.near_means() * near_grows + near * change
    sums = np.delete(totals, (2, 3), axis=2) + near_slope
    slope = sums[..., :2] - base.scores() / LIGHT_LEVEL * grows
    area = np.array(complex(base.area, STEP * grows))
    together = np.delete(found.real, (2, 3), axis=2) + base.near[:, _summed(tally)]
    values = smooth_values(tally, area, (together + 1j * STEP * sums)[..., 2:])
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

"""Derivatives of a round brilliant's scores by each of its proportions and angles.

Near the girdle there are no virtual facets. What is exact there too is how its share of the
view grows. How the mean of its light changes is a difference quotient of rays, with its error; it is small,
and from one hundredth of a per cent to the next too rough for a derivative to mean anything.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.compiled import STEP
from gemrender.beam.derivatives import Derivative, Sensitivity, facet_totals, result
from gemrender.beam.facets import trace_facets
from gemrender.beam.measure import facet_sums
from gemrender.beam.near_girdle import CELLS, NearGirdle
from gemrender.beam.solid import beam_stone
from gemrender.cuts.round_brilliant import RoundBrilliant
from gemrender.cuts.round_brilliant.planes import facet_planes
from gemrender.cuts.round_brilliant.proportions import brilliant_vertices
from gemrender.errors import InputError
from gemrender.measures.inoue import INTENSITY, MET, REAR
from gemrender.measures.tally import bounds_of_sets
from gemrender.observation import LIGHT_LEVEL, Model, View
from gemrender.stone import Stone

__all__ = ["PROPORTIONS", "by_proportions", "proportion_planes"]

#: The proportions that a stone is differentiated by, as `RoundBrilliant` names them.
PROPORTIONS = (
    "table", "star", "lower_girdle_contact", "crown_height", "pavilion_depth", "girdle_thickness"
)  # fmt: skip

#: In one round of rays polygons are traced so many times; a budget lets them run for 0.4 of its time.
_TRACES = 12

#: Steps of the difference quotient near the girdle [%]; a smaller one is taken where the girdle cells are not
#: the same ones on both sides, told by their area, which may differ by this share from what it should be.
_QUOTIENT_STEPS, _SAME_CELLS = (0.05, 0.02, 0.01, 0.005), 0.02
#: Rays of each set and side at first and at the most, and by how much they are increased.
_RAYS, _MOST_RAYS, _MORE = 1024, 8192, 4


def proportion_planes(proportions: RoundBrilliant, parameter: str) -> np.ndarray:
    """Return a brilliant's planes, (57, 4) complex128, with their derivatives by a proportion [1/%]."""
    numbers: dict[str, complex] = asdict(proportions)
    numbers[parameter] = complex(numbers[parameter], STEP)
    return facet_planes(brilliant_vertices(**numbers))


def by_proportions(
    stone: Stone,
    view: View,
    model: Model,
    wanted: float,
    seed: int,
    budget: Budget,
    progress: Callable[[float], None] | None,
    start: float,
) -> Sensitivity:
    """Differentiate by proportions and angles; see `gemrender.beam.sensitivity.sensitivity`."""
    assert stone.proportions is not None
    rays = _RAYS
    while True:
        before = budget.seconds
        base = _Scored(
            stone, view, model, seed, rays, budget=Budget(budget.time_limit / _TRACES, budget.memory_limit)
        )
        slopes = {}
        for done, parameter in enumerate(PROPORTIONS, start=1):
            slopes[parameter] = _slope(base, parameter, seed)
            if progress is not None:
                progress(done / len(PROPORTIONS))
        derivatives = _derivatives(stone.proportions, slopes)
        reached = max(max(d.average_bound, d.rear_bound) for d in derivatives)
        if reached <= wanted or rays >= _MOST_RAYS or _MORE * (budget.seconds - before) > budget.left:
            break
        rays *= _MORE
    average, rear = base.scores().mean(axis=0)
    girdle = 100.0 * (1.0 - base.resolved[MET] / base.area)
    return result(stone, view, model, (average, rear), derivatives, girdle, start)


class _Scored:
    """A stone with its virtual facets and its light near the girdle."""

    def __init__(
        self,
        stone: Stone,
        view: View,
        model: Model,
        seed: int,
        rays: int,
        numbers: tuple[int, ...] | None = None,
        budget: Budget | None = None,
    ) -> None:
        self.stone, self.view, self.model = stone, view, model
        self.convex = beam_stone(stone)
        facets = trace_facets(self.convex, view=view, model=model, whole=False, budget=budget)
        if facets.left_over:
            raise InputError(
                f"falls into more virtual facets than can be differentiated: {facets.why_left_over}",
                source=stone.source or stone.name,
            )
        self.resolved, near = facet_sums(facets), NearGirdle(self.convex, facets, seed)
        self.numbers = numbers or near.numbers(rays)
        near.go_on(self.numbers)
        self.near, self.cell_area, self.area = near.found(), near.areas[CELLS], near.view_area

    def scores(self) -> np.ndarray:
        """Average and Rear by each set of rays, (SETS, 2) [%]."""
        return np.asarray(100.0 * (self.resolved + self.near)[:, [INTENSITY, REAR]] / self.area)

    def near_means(self) -> np.ndarray:
        """Mean intensity and share of rear light near the girdle, by each set of rays, (SETS, 2) (0 to 1)."""
        met = self.near[:, [MET]]
        return np.asarray(self.near[:, [INTENSITY, REAR]] / np.where(met > 0, met, 1.0))

    def moved(self, parameter: str, by: float, seed: int) -> _Scored:
        """Return the stone with one proportion changed [%], scored by the very same rays."""
        assert self.stone.proportions is not None
        numbers = asdict(self.stone.proportions)
        numbers[parameter] += by
        stone = Stone.from_proportions(RoundBrilliant(**numbers), material=self.stone.material)
        return _Scored(stone, self.view, self.model, seed, 0, self.numbers)


def _slope(base: _Scored, parameter: str, seed: int) -> np.ndarray:
    """Differentiate Average and Rear by one proportion, by each set of rays, (SETS, 2)."""
    assert base.stone.proportions is not None
    planes = proportion_planes(base.stone.proportions, parameter)
    light, rear, resolved, cells = (
        facet_totals(base.convex, planes, view=base.view, model=base.model).imag / STEP
    )
    for step in _QUOTIENT_STEPS:
        low, high, between = _sides(base, parameter, step, seed)
        grown = high.cell_area - low.cell_area - between * cells
        if abs(grown) <= _SAME_CELLS * base.cell_area:
            break
    grows = (high.area - low.area) / between
    near, near_grows = base.area - base.resolved[MET], grows - resolved
    change = (high.near_means() - low.near_means()) / between
    near_slope = base.near_means() * near_grows + near * change
    slope = np.array([light, rear]) + near_slope - base.scores() / LIGHT_LEVEL * grows
    return np.asarray(LIGHT_LEVEL * slope / base.area)


def _sides(base: _Scored, parameter: str, step: float, seed: int) -> tuple[_Scored, _Scored, float]:
    """Return the stone with a proportion a step smaller and a step larger, and how far apart [%].

    At the end of the allowed range the stone itself is one of the two.
    """
    sides, between = [], 0.0
    for by in (-step, step):
        try:
            sides.append(base.moved(parameter, by, seed))
        except InputError:
            sides.append(base)
        else:
            between += step
    if not between:
        raise InputError("leaves no room for a difference on either side", key=parameter)
    return sides[0], sides[1], between


def _derivatives(proportions: RoundBrilliant, slopes: dict[str, np.ndarray]) -> list[Derivative]:
    """Put the derivatives together; those by angles follow from those by heights (the chain rule).

    crown height = (100 - table) / 2 tan(crown angle), pavilion depth = 50 tan(pavilion angle).
    """
    crown, pavilion = (math.radians(a) for a in (proportions.crown_angle_deg, proportions.pavilion_angle_deg))
    by_crown, by_pavilion = slopes["crown_height"], slopes["pavilion_depth"]
    degree = math.radians(1.0)
    angles = {
        "table": ("%", slopes["table"] - 0.5 * math.tan(crown) * by_crown),
        "crown_angle": ("deg", degree * (100.0 - proportions.table) / 2 / math.cos(crown) ** 2 * by_crown),
        "pavilion_angle": ("deg", degree * 50.0 / math.cos(pavilion) ** 2 * by_pavilion),
        "lower_half": ("%", -slopes["lower_girdle_contact"]),
    }
    rows = [(name, "proportions", "%", slope) for name, slope in slopes.items()]
    rows += [(name, "angles", unit, slope) for name, (unit, slope) in angles.items()]
    out = []
    for name, kept, unit, slope in rows:
        (average, rear), bounds = slope.mean(axis=0), [float(bound) for bound in bounds_of_sets(slope)]
        out.append(
            Derivative(
                parameter=name, kept=kept, unit=unit, average=float(average), rear=float(rear),
                average_bound=bounds[0], rear_bound=bounds[1],
            )
        )  # fmt: skip
    return out

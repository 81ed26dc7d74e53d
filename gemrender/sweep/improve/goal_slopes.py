"""How fast goals change with each parameter that is varied: exact where that can be, else by differences.

Exact slopes are a chain of three: of the goal by the values of measures (`Goal.partials`), of those by the
numbers that a stone is made from (`gemrender.beam.sensitivity`), and of those numbers by what is varied.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import compress
from typing import Any

import numpy as np

from gemrender.beam.sensitivity import sensitivity
from gemrender.errors import InputError
from gemrender.measures import Measure
from gemrender.request import ShortForms
from gemrender.stone import Stone
from gemrender.sweep.cliffs import parameters_of
from gemrender.sweep.improve.goals import Goal
from gemrender.sweep.improve.search import Search

__all__ = ["GoalSlope", "goal_slopes", "has_slopes"]

#: Step of differences of numbers that are closed forms of each other [deg, % or of a ratio]: an error of
#: 1e-8 of the slope.
_SMALL = 1e-4
#: Differences end at this share of the way to the next jump.
_WITHIN = 0.9
#: Wanted bound of the derivatives of measures [% per unit].
_BOUND = 0.2
#: What the derivatives of one stone may take [s]; past it they have a larger bound.
_TIME = 5.0
#: Numbers that change by less stay: the rounding of differences [of their unit per unit].
_STILL = 1e-9
#: What of `parameters_of` a stone is made from, each a number of its own.
_MADE_FROM = ("proportions", "tiers")
#: What derivatives of volume are called; it is told by differences of exact volumes.
_VOLUME = "volume"


@dataclass(frozen=True, slots=True, kw_only=True)
class GoalSlope:
    """How fast a goal changes with one parameter, the others that are varied kept.

    Attributes
    ----------
    parameter, unit : str
        The parameter, and what it counts: "deg", "%", or nothing where it is a ratio.
    slope : float
        The derivative [goal per unit]; NaN where there is none.
    bound : float or None
        How far an exact one may be off, with a confidence of 99.9 %: rays near a round girdle, and kinks.
    between : (float, float) or None
        Of a difference, the parameters that the goal was taken at; None of an exact slope.
    """

    parameter: str
    unit: str
    slope: float
    bound: float | None
    between: tuple[float, float] | None

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON; null for NaN."""
        is_known = math.isfinite(self.slope)
        return {
            "parameter": self.parameter,
            "unit": self.unit,
            "slope": self.slope if is_known else None,
            "bound": self.bound if is_known else None,
            "between": None if self.between is None else list(self.between),
        }


def has_slopes(goal: Goal) -> bool:
    """Whether a goal's slopes can be exact: it is of values that can be differentiated, face up."""
    smooth = {f"{of.name}.{key}" for of in goal.measures for key in of.smooth_keys}
    return goal.is_local and all(name == _VOLUME or name in smooth for name in goal.names)


def goal_slopes(
    search: Search,
    values: Mapping[str, float],
    room: Mapping[str, tuple[float, float]] | None = None,
    bound: float = _BOUND,
) -> list[dict[str, GoalSlope]]:
    """Return the slopes of each goal of a search by each parameter that it varies.

    Parameters
    ----------
    search : Search
        The search.
    values : mapping
        The parameters of a stone that can be made.
    room : mapping, optional
        How far below and above parameters nothing jumps, where that is known: differences of goals seen from
        straight above are taken within.
    bound : float
        Wanted bound of the derivatives of measures [% per unit].
    """
    exact: list[dict[str, GoalSlope] | None] = [None] * len(search.aims)
    if any(has_slopes(aim) for aim in search.aims):
        with contextlib.suppress(InputError):  # more virtual facets than can be differentiated
            exact = _exact(search, values, bound)
    if None in exact:
        by_differences = _by_differences(search, values, room or {})
        return [by_differences[k] if known is None else known for k, known in enumerate(exact)]
    return [known for known in exact if known is not None]


def _exact(search: Search, values: Mapping[str, float], bound: float) -> list[dict[str, GoalSlope] | None]:
    from gemrender.scoring import score

    stone = search.stone_of(values)
    told: dict[str, float] = {}
    slopes: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    if any(_VOLUME in aim.names for aim in search.aims):
        volume = np.array([_central(_volume, search, values, by.name) for by in search.ranges])
        told[_VOLUME], slopes[_VOLUME] = stone.solid.volume, (volume, np.zeros(len(volume)))
    measures = [of for of in search.measures if of.smooth_keys]
    if measures:
        slopes |= _measure_slopes(search, values, measures, bound)
        scored = score(stone, measures=measures, head=search.head, **search.options)
        for each in scored.measures or ():
            told |= {f"{each.name}.{key}": value for key, value in each.values.items()}
    return [_chain(aim, told, slopes, search) if has_slopes(aim) else None for aim in search.aims]


def _measure_slopes(
    search: Search, values: Mapping[str, float], measures: list[Measure], wanted: float
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return slopes of values of measures and their bounds, each by the ranges, (ranges,)."""
    stone = search.stone_of(values)
    short: Any = {key: of for key, of in search.options.items() if key in ShortForms.__annotations__}

    def made_from(stone: Stone) -> dict[tuple[str, str], float]:
        return {(of.name, of.kept): of.value for of in parameters_of(stone) if of.kept in _MADE_FROM}

    numbers = list(made_from(stone))

    def in_order(stone: Stone) -> np.ndarray:
        known = made_from(stone)
        return np.array([known[number] for number in numbers])

    moved = np.array(
        [np.broadcast_to(_central(in_order, search, values, by.name), len(numbers)) for by in search.ranges]
    )
    moves = ~(np.abs(moved) <= _STILL).all(axis=0)  # NaN does
    found = sensitivity(
        stone,
        measures=measures,
        head=search.head,
        bound=wanted,
        seed=search.options.get("seed", 1),
        time_limit=_TIME,
        parameters=list(compress(numbers, moves)),
        **short,
    )
    place = {number: k for k, number in enumerate(numbers)}
    moved = moved[:, [place[of.parameter, of.kept] for of in found.derivatives]]
    slopes = {}
    for k, of in enumerate(found.derivatives[0].measures):
        by_number = np.array([[each.measures[k].slope, each.measures[k].bound] for each in found.derivatives])
        slopes[f"{of.measure}.{of.key}"] = moved @ by_number[:, 0], np.abs(moved) @ by_number[:, 1]
    return slopes


def _chain(
    aim: Goal, told: Mapping[str, float], slopes: Mapping[str, tuple[np.ndarray, np.ndarray]], search: Search
) -> dict[str, GoalSlope]:
    """Return the slopes of a goal from those of its values, each and its bound (ranges,)."""
    partials = aim.partials(told)
    slope, bound = np.zeros(len(search.ranges)), np.zeros(len(search.ranges))
    for name, partial in partials.items():
        if partial:  # what does not count may be undefined
            slope += partial * slopes[name][0]
            bound += abs(partial) * slopes[name][1]
    return {
        by.name: GoalSlope(parameter=by.name, unit=by.unit, slope=float(each), bound=float(off), between=None)
        for by, each, off in zip(search.ranges, slope, bound, strict=True)
    }


def _by_differences(
    search: Search, values: Mapping[str, float], room: Mapping[str, tuple[float, float]]
) -> list[dict[str, GoalSlope]]:
    """Return differences over a step to either side, or as far as nothing jumps and stones can be made."""
    out: list[dict[str, GoalSlope]] = [{} for _ in search.aims]

    def told(made: Stone) -> np.ndarray:
        return np.array(search.goals_of(made))

    for by in search.ranges:
        found = {}
        for is_local in {aim.is_local for aim in search.aims}:
            below, above = room.get(by.name, (math.inf, math.inf)) if is_local else (math.inf, math.inf)
            ends = (-min(by.step, _WITHIN * below), min(by.step, _WITHIN * above))
            found[is_local] = _difference(told, search, values, by.name, ends)
        for k, aim in enumerate(search.aims):
            slopes, ends = found[aim.is_local]
            low, high = (float(f"{values[by.name] + end:.10g}") for end in ends)
            slope = float(np.broadcast_to(slopes, len(out))[k])
            out[k][by.name] = GoalSlope(
                parameter=by.name, unit=by.unit, slope=slope, bound=None, between=(low, high)
            )
    return out


def _central(
    of: Callable[[Stone], np.ndarray], search: Search, values: Mapping[str, float], name: str
) -> np.ndarray:
    """Return the derivative of what is told of stones by a parameter, of what is smooth."""
    return _difference(of, search, values, name, (-_SMALL, _SMALL))[0]


def _difference(
    of: Callable[[Stone], np.ndarray],
    search: Search,
    values: Mapping[str, float],
    name: str,
    ends: tuple[float, float],
) -> tuple[np.ndarray, tuple[float, float]]:
    """Return the difference quotient of what is told of stones by a parameter, and where it was taken.

    At an end where no stone can be made it is taken from the stone itself; NaN where neither can.
    """

    def told(by: float) -> np.ndarray | None:
        try:
            found = of(search.stone_of({**values, name: values[name] + by}))
        except InputError:
            return None
        return found if np.isfinite(found).all() else None

    found = {by: made for by in ends if (made := told(by)) is not None}
    if len(found) < 2 and (here := told(0.0)) is not None:
        found[0.0] = here
    if len(found) < 2:
        return np.array(math.nan), ends
    low, high = min(found), max(found)
    return np.asarray((found[high] - found[low]) / (high - low)), (low, high)


def _volume(stone: Stone) -> np.ndarray:
    return np.array(stone.solid.volume)

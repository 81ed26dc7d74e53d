"""Answers of a search, and what is told beside them: measures, a report's rounding, slopes, and cliffs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.observation import MeasureValues
from gemrender.request import ShortForms
from gemrender.stone import Stone
from gemrender.sweep.cliffs import Cliff, Parameter, find_cliffs
from gemrender.sweep.improve.checks import Check, EngineCheck, checked
from gemrender.sweep.improve.goal_slopes import GoalSlope, goal_slopes
from gemrender.sweep.improve.ranges import Range
from gemrender.sweep.improve.search import Places, Search
from gemrender.sweep.unknown import STEPS, figures_of

__all__ = ["Answer", "Details", "Phases", "SearchInterruptedError", "answer_at", "described", "start_of"]

#: Work beside that of the search, in stones that are measured: for each parameter of an answer that is
#: finished; of two cliffs; of an answer's slopes; of its check. Timed of three goals.
_FINISHED, _CLIFFS, _SLOPES, _CHECK = 8, 50, 80, 150


class SearchInterruptedError(KeyboardInterrupt):
    """Ctrl-C in a search, with what was found by then.

    Attributes
    ----------
    found : Improvement or Front
        The best of all that was tried, without details.
    """

    def __init__(self, found: Any) -> None:
        super().__init__()
        self.found = found


@dataclass(frozen=True, slots=True, kw_only=True)
class Details:
    """What is told beside an answer.

    Attributes
    ----------
    average, rear : float
        The paper's scores [%].
    measures : tuple of MeasureValues
        Every measure in the goals.
    report : dict of str to float
        What a laboratory's report would round its figures to [%, deg]; nothing of designs.
    slopes : tuple of tuple of GoalSlope
        How fast each goal changes, by each parameter that is varied.
    cliffs : tuple of Cliff
        The nearest jump below and above, of each parameter that is varied: of the values in the goals that
        are shares of light or view, seen from straight above; where there are none, of the paper's scores.
    """

    average: float
    rear: float
    measures: tuple[MeasureValues, ...]
    report: dict[str, float]
    slopes: tuple[tuple[GoalSlope, ...], ...]
    cliffs: tuple[Cliff, ...]

    def nearest(self, parameter: str) -> tuple[Cliff, Cliff]:
        """Return what was found below and above a parameter."""
        below, above = (of for of in self.cliffs if of.parameter == parameter)
        return below, above


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """A stone that was found.

    Attributes
    ----------
    values : dict of str to float
        The parameters that were varied.
    goals : tuple of float
        The goals; one, where one was searched for.
    stone : Stone
        The stone.
    details : Details or None
        What is told beside it, if that was asked for.
    checks : tuple of EngineCheck
        What other engines say of it, if that was asked for.
    """

    values: dict[str, float]
    goals: tuple[float, ...]
    stone: Stone
    details: Details | None = None
    checks: tuple[EngineCheck, ...] = ()

    @property
    def goal(self) -> float:
        """The goal, or the first of them."""
        return self.goals[0]


def answer_at(search: Search, places: Places) -> Answer:
    """Return a stone that was measured as an answer."""
    return Answer(
        values=search.values(places), goals=search.known[places],
        stone=search.sized.stone(search.stone(places)),
    )  # fmt: skip


def start_of(search: Search) -> Answer:
    """Return the stone that a search begins with, with its own values."""
    return Answer(values=search.own_values(), goals=search.goals_of(search.base), stone=search.base)


class Phases:
    """The progress of a search, of what finishes its answers, is told beside them, and checks them.

    Each phase has the share of the whole that it is likely to have of the time.

    Parameters
    ----------
    progress : callable or None
        Called with the share done, 0 to 1, and the best goal so far.
    search : Search
        The search.
    rounds, answers : int
        Its most rounds, and how many answers are wanted.
    finish, details, check : bool
        Whether there are such phases.
    """

    def __init__(
        self, progress: Callable[[float, float], None] | None, search: Search, *, rounds: int, answers: int,
        finish: bool, details: bool, check: bool,
    ) -> None:  # fmt: skip
        ranges, told = len(search.ranges), answers + 1  # the start is one
        works = {
            "search": search.population * (rounds + 1),
            "finish": finish * answers * ranges * _FINISHED,
            "details": details * told * (ranges * _CLIFFS + _SLOPES),
            "check": check * told * _CHECK,
        }
        ends = np.cumsum([0.0, *works.values()])
        self._begins = dict(zip(works, ends[:-1] / ends[-1], strict=True))
        self._ends = dict(zip(works, ends[1:] / ends[-1], strict=True))
        self._progress, self._best = progress, -math.inf

    def search(self, share: float, best: float) -> None:
        """Tell how much of the search is done, and its best goal."""
        self._best = best
        self._tell("search", share)

    def finish(self, share: float) -> None:
        """Tell what share of the answers is finished."""
        self._tell("finish", share)

    def details(self, share: float) -> None:
        """Tell how much of the details is done."""
        self._tell("details", share)

    def check(self, share: float) -> None:
        """Tell how much of the check is done."""
        self._tell("check", share)

    def _tell(self, phase: str, share: float) -> None:
        if self._progress is not None:
            begin, end = self._begins[phase], self._ends[phase]
            self._progress(float(begin + share * (end - begin)), self._best)


def described(
    search: Search,
    answers: Sequence[Answer],
    phases: Phases,
    *,
    details: bool,
    reach: float | None = None,
    check: Check | None = None,
) -> list[Answer]:
    """Return answers with details, and with their check, within the threads of a running search.

    Parameters
    ----------
    search : Search
        The search.
    answers : sequence of Answer
        Its answers.
    phases : Phases
        What is told of the progress.
    details : bool
        Whether there are to be details.
    reach : float, optional
        How far cliffs are looked for [% or deg], as of `find_cliffs`.
    check : Check, optional
        How they are checked; by default not.
    """
    if details:
        of_each = _details(search, answers, reach, phases.details)
        answers = [replace(answer, details=of) for answer, of in zip(answers, of_each, strict=True)]
    if check is not None:
        checks = checked(search, [answer.stone for answer in answers], check, phases.check)
        answers = [replace(answer, checks=of) for answer, of in zip(answers, checks, strict=True)]
    return list(answers)


def _details(
    search: Search, answers: Sequence[Answer], reach: float | None, progress: Callable[[float], None]
) -> list[Details]:
    from gemrender.scoring import score

    done, parts = 0, len(answers) * (1 + len(search.ranges))

    def step() -> None:
        nonlocal done
        done += 1
        progress(done / parts)

    cliffs: dict[int, list[Cliff]] = {number: [] for number in range(len(answers))}
    jobs = [(number, by) for number in cliffs for by in search.ranges]
    of_job = partial(_cliffs, search, [answer.values for answer in answers], reach)
    for (number, _), found in zip(jobs, search.map(of_job, jobs), strict=True):
        cliffs[number] += found
        step()
    out = []
    for number, answer in enumerate(answers):  # by turns: kernels of derivatives may have to be compiled
        scored = score(answer.stone, measures=search.measures or None, head=search.head, **search.options)
        slopes = goal_slopes(search, answer.values, _room(cliffs[number]))
        out.append(
            Details(
                average=scored.average,
                rear=scored.rear,
                measures=scored.measures or (),
                report=_as_reported(answer.stone),
                slopes=tuple(tuple(of_goal[by.name] for by in search.ranges) for of_goal in slopes),
                cliffs=tuple(cliffs[number]),
            )
        )
        step()
    return out


def _cliffs(
    search: Search, values: Sequence[Mapping[str, float]], reach: float | None, job: tuple[int, Range]
) -> tuple[Cliff, ...]:
    """Return the nearest jumps below and above one parameter of one answer."""
    number, by = job
    of = values[number]

    def moved(far: float) -> Stone:
        return search.stone_of({**of, by.name: of[by.name] + far})

    parameter = Parameter(name=by.name, kept="others", unit=by.unit, value=of[by.name], moved=moved)
    shares = {f"{of.name}.{key}" for of in search.measures if of.unit == "%" for key in of.keys}
    counted = shares & {name for aim in search.aims for name in aim.names}
    short: Any = {key: value for key, value in search.options.items() if key in ShortForms.__annotations__}
    found = find_cliffs(
        moved(0.0), [parameter], measures=search.measures if counted else "inoue", values=counted or None,
        head=search.head, reach=reach, bound=search.options["bound"], seed=search.options.get("seed", 1),
        **short,
    )  # fmt: skip
    if not counted:
        return found
    return tuple(
        replace(cliff, jumps=tuple(of for of in cliff.jumps if f"{of.measure}.{of.key}" in counted))
        for cliff in found
    )


def _room(cliffs: Sequence[Cliff]) -> dict[str, tuple[float, float]]:
    """Return how far below and above each parameter nothing jumps."""
    far = {(of.parameter, of.side): of.searched for of in cliffs if of.at is not None}
    return {
        of.parameter: (far.get((of.parameter, "below"), math.inf), far.get((of.parameter, "above"), math.inf))
        for of in cliffs
    }


def _as_reported(stone: Stone) -> dict[str, float]:
    """Return a stone's figures as a laboratory's report rounds them."""
    try:
        figures = figures_of(stone)
    except InputError:  # a design
        return {}
    return {
        key: float(f"{round(figures[key] / step) * step:.10g}")
        for key, step in STEPS.items()
        if key in figures
    }

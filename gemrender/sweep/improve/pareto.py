"""Several goals at once: the stones of which none is better by all of them, the Pareto front.

The search is NSGA-II (Deb et al., IEEE Trans. Evol. Comput. 6, 182 (2002)) by pymoo (Blank & Deb, IEEE Access
8, 89497 (2020)), over the steps that a cutter can hold.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Unpack

import numpy as np

from gemrender import signatures
from gemrender.cuts import StoneLike
from gemrender.engines import DEFAULT_HEAD
from gemrender.errors import BackendError, InputError
from gemrender.request import TracerOptions
from gemrender.shown import Tabled
from gemrender.sweep.improve.answers import (
    Answer,
    Phases,
    SearchInterruptedError,
    answer_at,
    described,
    start_of,
)
from gemrender.sweep.improve.checks import Check
from gemrender.sweep.improve.goals import Goal
from gemrender.sweep.improve.ranges import Range
from gemrender.sweep.improve.rough import Rough
from gemrender.sweep.improve.run import improve
from gemrender.sweep.improve.search import DEFAULT_DRAWS, Places, Search, prepare_search
from gemrender.sweep.unknown import Unknown

__all__ = ["Front", "FrontStone", "non_dominated", "pareto_front", "require_pymoo", "spread_out"]

#: Most goals: of more nearly every stone is on the front.
_MOST_GOALS = 4
#: Continuous ranges are searched in this share of a step.
_FINE = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class FrontStone:
    """A stone on the front.

    Attributes
    ----------
    values : dict of str to float
        The parameters that were varied.
    goals : tuple of float
        The goals.
    """

    values: dict[str, float]
    goals: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Front(Tabled):
    """What a search for several goals found.

    Attributes
    ----------
    goals : tuple of Goal
        What was searched for.
    start : Answer
        The stone that it began with, with its own values.
    answers : tuple of Answer
        Stones of the front, as far apart as can be by their goals, the best by the first goal first.
    front : tuple of FrontStone
        The whole front among the stones that were tried, the best by the first goal first.
    tried : int
        Number of different stones that were measured.
    seed : int
        Seed of the search.
    """

    goals: tuple[Goal, ...]
    start: Answer
    answers: tuple[Answer, ...]
    front: tuple[FrontStone, ...]
    tried: int
    seed: int

    def __repr__(self) -> str:
        return f"<Front from {self.start.stone.name!r}: {len(self.front)} of {self.tried} stones tried>"


@signatures.spelt_out(defaults={}, texts=signatures.parameter_texts(improve.__doc__), types={})
def pareto_front(
    stone: StoneLike,
    goals: Sequence[Goal | str],
    vary_by: Sequence[Range | str],
    *,
    keep: Mapping[str, tuple[float, float]] | None = None,
    unknown: Unknown | None = None,
    draws: int = DEFAULT_DRAWS,
    answers: int = 5,
    rounds: int = 40,
    seed: int = 1,
    head: float = DEFAULT_HEAD,
    meets: str | None = None,
    rough: Rough | str | None = None,
    journal: Path | None = None,
    threads: int | None = None,
    progress: Callable[[float, float], None] | None = None,
    details: bool = True,
    reach: float | None = None,
    check: Check | None = None,
    **options: Unpack[TracerOptions],
) -> Front:
    """Search for stones of which none is better by all of several goals.

    Parameters
    ----------
    stone : Stone, str or path
        Where the search begins, or what `load_stone` takes.
    goals : sequence of Goal or str
        From two to four goals.
    answers : int
        Most stones of the front that are told in full.
    progress : callable, optional
        Called with the share done, 0 to 1, and the best of the first goal so far.

    Raises
    ------
    InputError
        As for `gemrender.improve`; too few or too many goals.
    BackendError
        pymoo is missing.
    SearchInterruptedError
        Ctrl-C after the first stones were measured: a KeyboardInterrupt that has what was found.
    """
    if not 2 <= len(goals) <= _MOST_GOALS:
        raise InputError(f"must be from 2 to {_MOST_GOALS} goals, got {len(goals)}", key="goal")
    search = prepare_search(
        stone, goals, vary_by, keep=keep, unknown=unknown, draws=draws, answers=answers, rounds=rounds,
        seed=seed, head=head, meets=meets, rough=rough, options={**options}, reach=reach,
    )  # fmt: skip
    require_pymoo()
    phases = Phases(
        progress, search, rounds=rounds, answers=answers, finish=False, details=details,
        check=check is not None,
    )  # fmt: skip

    def found(of: Sequence[Answer]) -> Front:
        start, *others = of
        return Front(
            goals=search.aims,
            start=start,
            answers=tuple(others),
            front=tuple(
                FrontStone(values=search.values(at), goals=search.known[at]) for at in _front(search)
            ),
            tried=len(search.known),
            seed=seed,
        )

    with search.running(journal, threads):
        start = start_of(search)
        try:
            _evolve(search, rounds, phases.search)
            told = [start, *(answer_at(search, at) for at in _spread(search, answers))]
            return found(described(search, told, phases, details=details, reach=reach, check=check))
        except KeyboardInterrupt as stopped:
            with contextlib.suppress(InputError):  # nothing yet
                kept = (answer_at(search, at) for at in _spread(search, answers))
                raise SearchInterruptedError(found([start, *kept])) from stopped
            raise


def require_pymoo() -> None:
    """See that pymoo is here.

    Raises
    ------
    BackendError
        It is not.
    """
    try:
        import pymoo  # noqa: F401
    except ImportError as error:
        raise BackendError(
            f"several goals need pymoo ({error}); to cure it: pip install 'gemrender[pareto]'"
        ) from error


def _evolve(search: Search, rounds: int, after_each: Callable[[float, float], None]) -> None:
    """Search by NSGA-II; tell the share done, and the best of the first goal, after each generation."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.evaluator import Evaluator
    from pymoo.core.problem import Problem
    from pymoo.operators.crossover.sbx import SBX
    from pymoo.operators.mutation.pm import PM
    from pymoo.operators.repair.rounding import RoundingRepair
    from pymoo.problems.static import StaticProblem

    # Whole numbers throughout: steps, or small shares of them.
    scale = np.where(search.is_whole, 1.0, _FINE)
    problem = Problem(
        n_var=len(scale), n_obj=len(search.aims), xl=np.zeros(len(scale)), xu=np.floor(search.last / scale),
        vtype=int,
    )  # fmt: skip
    size = search.population
    algorithm = NSGA2(
        pop_size=size,
        sampling=np.rint(search.first_members(size) / scale),
        crossover=SBX(repair=RoundingRepair()),
        mutation=PM(repair=RoundingRepair()),
        eliminate_duplicates=True,
    )
    algorithm.setup(problem, termination=("n_gen", rounds + 1), seed=search.seed, verbose=False)
    generations = 0
    while algorithm.has_next() and not search.is_exhausted:  # for others it would mate a hundred times
        members = algorithm.ask()
        if members is None:
            break
        losses = search.losses(members.get("X") * scale)
        Evaluator().eval(StaticProblem(problem, F=losses), members)
        algorithm.tell(infills=members)
        after_each(min(generations / rounds, 1.0), -float(losses[:, 0].min()))
        generations += 1


# ---- Fronts --------------------------------------------------------------------------------------------


def non_dominated(goals: np.ndarray) -> np.ndarray:
    """Return which of some stones no other one is better than, (n,) bool.

    Parameters
    ----------
    goals : (n, k) float64
        Their goals: a stone is better than another if none of its goals is less and one is more.
    """
    kept = np.ones(len(goals), dtype=bool)
    for number, own in enumerate(goals):
        if kept[number]:
            worse = (goals <= own).all(axis=1) & (goals < own).any(axis=1)
            kept &= ~worse
    return kept


def spread_out(goals: np.ndarray, most: int) -> list[int]:
    """Return the numbers of stones that are far apart by their goals: the best by each, then the farthest.

    Parameters
    ----------
    goals : (n, k) float64
        Goals of a front; distances are in shares of each goal's range.
    most : int
        How many at the most.
    """
    low, high = goals.min(axis=0), goals.max(axis=0)
    shares = (goals - low) / np.where(high > low, high - low, 1.0)
    chosen: list[int] = list(dict.fromkeys(int(number) for number in shares.argmax(axis=0)))[:most]
    while len(chosen) < most:
        distances = np.linalg.norm(shares[:, None] - shares[chosen], axis=2).min(axis=1)
        if not distances.max() > 0.0:
            break
        chosen.append(int(distances.argmax()))
    return chosen


def _front(search: Search) -> list[Places]:
    """Return the front among all stones that were tried, the best by the first goal first.

    Raises
    ------
    InputError
        No stone could be made.
    """
    places = sorted(
        filter(search.is_possible, search.known), key=lambda at: (search.known[at], at), reverse=True
    )
    if not places:
        raise InputError("no stone within these ranges can be made, or keeps what must be kept", key="vary")
    kept = non_dominated(np.array([search.known[at] for at in places]))
    return [at for at, is_on in zip(places, kept, strict=True) if is_on]


def _spread(search: Search, most: int) -> list[Places]:
    """Return stones of the front that are far apart by their goals, the best by the first goal first."""
    front = _front(search)
    chosen = spread_out(np.array([search.known[at] for at in front]), most)
    return [front[number] for number in sorted(chosen)]

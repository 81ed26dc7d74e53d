"""Better stones: parameters of a cut searched for a goal, and several different answers.

The search is differential evolution (Storn & Price, J. Global Optimization 11, 341 (1997)) by scipy, over
values that a cutter can hold: each parameter in steps. What it has found is finished from where it is
(`gemrender.sweep.improve.finish`). Answers that are far apart are kept, not the best alone.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Unpack

from gemrender.cuts import StoneLike
from gemrender.engines import DEFAULT_HEAD
from gemrender.errors import InputError
from gemrender.request import TracerOptions, spelt_out
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
from gemrender.sweep.improve.finish import finished
from gemrender.sweep.improve.goals import Goal
from gemrender.sweep.improve.ranges import Range
from gemrender.sweep.improve.rough import Rough
from gemrender.sweep.improve.search import (
    DEFAULT_DRAWS,
    DEFAULT_SEARCH_BOUND,
    Places,
    Search,
    prepare_search,
)
from gemrender.sweep.unknown import Unknown

__all__ = ["Answer", "Improvement", "SearchInterruptedError", "improve"]


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Improvement(Tabled):
    """What a search found.

    Attributes
    ----------
    goal : Goal
        What was searched for.
    start : Answer
        The stone that it began with, with its own values.
    answers : tuple of Answer
        What was found, the best first; each differs from those before.
    tried : int
        Number of different stones that were measured.
    seed : int
        Seed of the search.
    """

    goal: Goal
    start: Answer
    answers: tuple[Answer, ...]
    tried: int
    seed: int

    def __repr__(self) -> str:
        name, answers = self.start.stone.name, len(self.answers)
        return f"<Improvement of {name!r}: {answers} answers of {self.tried} stones tried>"

    @property
    def goals(self) -> tuple[Goal, ...]:
        """What was searched for, as of a front."""
        return (self.goal,)


@spelt_out(bound=DEFAULT_SEARCH_BOUND)
def improve(
    stone: StoneLike,
    goal: Goal | str,
    vary_by: Sequence[Range | str],
    *,
    keep: Mapping[str, tuple[float, float]] | None = None,
    unknown: Unknown | None = None,
    draws: int = DEFAULT_DRAWS,
    answers: int = 3,
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
) -> Improvement:
    """Search for stones for which a goal is large.

    Parameters
    ----------
    stone : Stone, str or path
        Where the search begins: a stone that was made from proportions, of a family, or from a design; or
        what `load_stone` takes.
    goal : Goal or str
        The goal; see `gemrender.sweep.improve.goals`.
    vary_by : sequence of Range or str
        The parameters that are varied: as "crown_angle" or "pavilion_angle=40:42:0.1"
        (`gemrender.sweep.improve.ranges.ranges_of`), or ranges.
    keep : mapping of str to pair of float, optional
        Ranges that other figures of the stone must stay within, such as crown_height.
    unknown : Unknown, optional
        What `spread` is taken under; by default a report's rounding.
    draws : int
        Number of draws that it is taken over; the same ones for every stone.
    answers : int
        Most answers.
    rounds : int
        Most generations of the search; it ends sooner where all its members are alike.
    seed : int
        Seed of the search and of the draws: the same one gives the same answers.
    head : float
        Half the angle at which the viewer's head is seen from the stone, 0 to below 90 [deg].
    meets : {"kept", "loose"}, optional
        Of a faceter's design, what becomes of its meet points (`gemrender.sweep.improve.varied.remaker`).
    rough : Rough or str, optional
        What the stones are cut from, as `gemrender.sweep.improve.sized.read_rough` reads it, for goals of
        `yield` and `carat`; the answers have the size that fits.
    journal : Path, optional
        File that the goal of every stone is added to when it is known: the search goes on from it, since it
        takes the same way again.
    threads : int, optional
        Threads; by default one a processor.
    progress : callable, optional
        Called with the share done, 0 to 1, and the best goal so far.
    details : bool
        Whether answers are described: measures, slopes of the goal, cliffs (`Answer.details`).
    reach : float, optional
        How far cliffs are looked for [% or deg]; by default as `gemrender.sweep.cliffs.find_cliffs`.
    check : Check, optional
        How the start and the answers are checked by Mitsuba and the reference; by default they are not.
    **options
        How each stone is traced, as of `gemrender.score`.

    Raises
    ------
    InputError
        A value out of range, a stone that cannot be varied, or a journal that is of another search or in use.
    SearchInterruptedError
        Ctrl-C after the first stones were measured: a KeyboardInterrupt that has what was found.
    """
    search = prepare_search(
        stone, [goal], vary_by, keep=keep, unknown=unknown, draws=draws, answers=answers, rounds=rounds,
        seed=seed, head=head, meets=meets, rough=rough, options={**options}, reach=reach,
    )  # fmt: skip
    phases = Phases(
        progress, search, rounds=rounds, answers=answers, finish=True, details=details,
        check=check is not None,
    )  # fmt: skip

    def found(of: Sequence[Answer]) -> Improvement:
        start, *others = of
        return Improvement(
            goal=search.aims[0], start=start, answers=tuple(others), tried=len(search.known), seed=seed
        )

    with search.running(journal, threads):
        start = start_of(search)
        try:
            _evolve(search, rounds, phases.search)
            ended: list[Places] = []
            apart = search.apart(answers)
            for number, places in enumerate(apart, 1):
                last = finished(search, places)
                phases.finish(number / len(apart))
                if not any(search.alike(last, other) for other in ended):
                    ended.append(last)
            ended.sort(key=lambda places: -search.known[places][0])
            told = [start, *(answer_at(search, places) for places in ended)]
            return found(described(search, told, phases, details=details, reach=reach, check=check))
        except KeyboardInterrupt as stopped:
            with contextlib.suppress(InputError):  # nothing yet
                kept = (answer_at(search, places) for places in search.apart(answers))
                raise SearchInterruptedError(found([start, *kept])) from stopped
            raise


def _evolve(search: Search, rounds: int, after_each: Callable[[float, float], None]) -> None:
    """Search by differential evolution; tell the share done, and the best goal, after each generation."""
    from scipy.optimize import differential_evolution

    generations = 0

    def told(intermediate_result: Any) -> None:
        nonlocal generations
        generations += 1
        after_each(min(generations / rounds, 1.0), -float(intermediate_result.fun))

    differential_evolution(
        lambda members: search.losses(members.T)[:, 0],
        [(0.0, float(last)) for last in search.last],
        integrality=search.is_whole,
        vectorized=True,
        updating="deferred",
        popsize=1,
        init=search.first_members(search.population),
        maxiter=rounds,
        tol=1e-6,
        polish=False,
        seed=search.seed,
        callback=told,
    )

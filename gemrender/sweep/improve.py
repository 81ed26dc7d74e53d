"""Better stones: parameters of a cut searched for a goal, and several different answers.

The search is differential evolution (Storn & Price, J. Global Optimization 11, 341 (1997)) by scipy, over
values that a cutter can hold: each parameter in steps. What it has found is finished by trying every step to
either side until none is better, which needs no derivative where scores jump. Answers that are far apart are
kept, not the best alone.
"""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.engines import DEFAULT_HEAD, check_head, require_engine
from gemrender.errors import InputError
from gemrender.journal import Journal
from gemrender.reading import did_you_mean
from gemrender.stone import Stone
from gemrender.sweep.goals import Goal, Pose
from gemrender.sweep.ranges import Range, ranges_of
from gemrender.sweep.rough import Rough
from gemrender.sweep.sized import Sized, read_rough
from gemrender.sweep.tilt import solid_digest
from gemrender.sweep.unknown import Rounding, Unknown, draw
from gemrender.sweep.varied import remaker, varied_figures

__all__ = ["Answer", "Improvement", "improve"]

#: Answers differ in some parameter by this share of its range.
_APART = 0.15
#: Error bound of the exact values that candidates are compared by [%].
DEFAULT_SEARCH_BOUND = 0.1
#: Draws that a spread is taken over.
DEFAULT_DRAWS = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """A stone that was found.

    Attributes
    ----------
    values : dict of str to float
        The parameters that were varied.
    goal : float
        The goal.
    stone : Stone
        The stone.
    """

    values: dict[str, float]
    goal: float
    stone: Stone


@dataclass(frozen=True, slots=True, kw_only=True)
class Improvement:
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


def improve(
    stone: Stone,
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
    options: dict[str, Any] | None = None,
    journal: Path | None = None,
    threads: int | None = None,
    progress: Callable[[float, float], None] | None = None,
) -> Improvement:
    """Search for stones for which a goal is large.

    Parameters
    ----------
    stone : Stone
        Where the search begins: a stone that was made from proportions, or of a family.
    goal : Goal or str
        The goal; see `gemrender.sweep.goals`.
    vary_by : sequence of Range or str
        The parameters that are varied: as "crown_angle" or "pavilion_angle=40:42:0.1"
        (`gemrender.sweep.ranges.ranges_of`), or ranges.
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
        Of a faceter's design, what becomes of its meet points (`gemrender.sweep.varied.remaker`).
    rough : Rough or str, optional
        What the stones are cut from (`gemrender.sweep.sized.read_rough`), for goals of `yield` and `carat`;
        the answers have the size that fits.
    options : dict, optional
        Further arguments of `gemrender.score`: bound (0.1 by default), index ...
    journal : Path, optional
        File that the goal of every stone is added to when it is known: the search goes on from it, since it
        takes the same way again.
    threads : int, optional
        Threads; by default one a processor.
    progress : callable, optional
        Called with the share done, 0 to 1, and the best goal so far.

    Raises
    ------
    InputError
        A value out of range, a stone that cannot be varied, or a journal that is of another search or in use.
    """
    from scipy.optimize import differential_evolution

    aim = Goal.parse(goal) if isinstance(goal, str) else goal
    for key, value, low, high in (
        ("answers", answers, 1, 100), ("rounds", rounds, 1, 10_000), ("draws", draws, 2, 1000),
        ("seed", seed, 0, 2**31 - 1),
    ):  # fmt: skip
        if not low <= value <= high:
            raise InputError(f"must be from {low:g} to {high:g}", key=key, value=value)
    known = varied_figures(stone)
    by_text = [text for text in vary_by if isinstance(text, str)]
    ranges = (
        *(by for by in vary_by if not isinstance(by, str)),
        *(ranges_of(stone, by_text, keep) if by_text else ()),
    )
    for key in keep or {}:
        if key not in known:
            raise InputError(
                f"unknown key; must be one of {', '.join(known)}{did_you_mean(key, list(known))}", key="keep",
                value=key,
            )  # fmt: skip
    if aim.has_spread and unknown is None:
        Rounding.of(stone)  # refuses designs, which no report rounds
    traced = {"bound": DEFAULT_SEARCH_BOUND, **(options or {}), "engine": "exact"}
    require_engine("exact", stones=[stone])  # its first kernel must not be called by two threads at once
    search = _Search(
        stone, aim, ranges, dict(keep or {}), unknown, draws, seed, check_head(head), meets, rough, traced
    )
    with contextlib.ExitStack() as stack:
        if journal is not None:
            kept = stack.enter_context(Journal(journal, search.first_line(), search.entry, work="search"))
            search.known.update(kept.known)
            search.journal = kept
        pool = stack.enter_context(ThreadPoolExecutor(threads or os.cpu_count() or 1))
        search.map = pool.map
        sizes = np.array([by.count for by in ranges])
        size = min(60, max(16, 8 * len(sizes)))
        generations = 0

        def after_each(intermediate_result: Any) -> None:
            nonlocal generations
            generations += 1
            if progress is not None:
                progress(min(generations / rounds, 1.0), -float(intermediate_result.fun))

        start = tuple(int(place) for place in search.nearest())
        differential_evolution(
            search.losses,
            [(0.0, float(count - 1)) for count in sizes],
            integrality=np.ones(len(sizes), dtype=bool),
            vectorized=True,
            updating="deferred",
            popsize=1,
            init=_first(sizes, size, start, seed),
            maxiter=rounds,
            tol=1e-6,
            polish=False,
            seed=seed,
            callback=after_each,
        )
        found: list[tuple[int, ...]] = []
        for places in search.apart(answers):
            best = search.finished(places)
            if not any(search.alike(best, other) for other in found):
                found.append(best)
        found.sort(key=lambda places: -search.known[places])
        own = {by.name: known[by.name] for by in ranges}
        return Improvement(
            goal=aim,
            start=Answer(values=own, goal=search.goal_of(stone), stone=stone),
            answers=tuple(
                Answer(
                    values=search.values(places),
                    goal=search.known[places],
                    stone=search.sized.stone(search.stone(places)),
                )
                for places in found
            ),
            tried=len(search.known),
            seed=seed,
        )


def _first(sizes: np.ndarray, number: int, start: tuple[int, ...], seed: int) -> np.ndarray:
    """Return the first members: the start, and others evenly by Latin hypercube."""
    from scipy.stats import qmc

    share = qmc.LatinHypercube(len(sizes), seed=seed).random(number - 1)
    return np.concatenate([[start], np.floor(share * sizes)]).astype(float)


class _Search:
    """The stones of a search, by their places on the ranges, and their goals."""

    def __init__(
        self,
        stone: Stone,
        goal: Goal,
        ranges: tuple[Range, ...],
        keep: dict[str, tuple[float, float]],
        unknown: Unknown | None,
        draws: int,
        seed: int,
        head: float,
        meets: str | None,
        rough: Rough | str | None,
        options: dict[str, Any],
    ) -> None:
        self.base, self.aim, self.ranges, self.keep = stone, goal, ranges, keep
        self.unknown, self.draws, self.seed, self.head, self.options = unknown, draws, seed, head, options
        self.meets, self.remade = meets, remaker(stone, meets)
        self.sized = Sized.of(goal, stone, read_rough(rough) if isinstance(rough, str) else rough)
        self.known: dict[tuple[int, ...], float] = {}
        self.journal: Journal | None = None
        self.map: Callable[..., Iterable[Any]] = map

    # ---- Stones ----

    def nearest(self) -> list[int]:
        """Return the places next to the stone's own values."""
        own = varied_figures(self.base)
        return [min(max(round((own[by.name] - by.low) / by.step), 0), by.count - 1) for by in self.ranges]

    def values(self, places: Sequence[int]) -> dict[str, float]:
        """Return the parameters at these places."""
        return {by.name: by.at(place) for by, place in zip(self.ranges, places, strict=True)}

    def stone(self, places: Sequence[int]) -> Stone:
        """Make the stone at these places."""
        return self.remade(self.values(places))

    # ---- Goals ----

    def losses(self, members: np.ndarray) -> np.ndarray:
        """Return minus the goals of members, columns of (k, n): what scipy makes small."""
        places = [tuple(round(float(x)) for x in member) for member in members.T]
        self.measure(places)
        return np.array([-self.known[at] if math.isfinite(self.known[at]) else 1e9 for at in places])

    def measure(self, places: Iterable[tuple[int, ...]]) -> None:
        """Measure what is not known yet, by threads."""
        new = [at for at in dict.fromkeys(places) if at not in self.known]
        for at, goal in zip(new, self.map(self._goal_at, new), strict=True):
            self.known[at] = goal
            if self.journal is not None:
                self.journal.add(list(at), goal if math.isfinite(goal) else None)

    def _goal_at(self, places: tuple[int, ...]) -> float:
        try:
            stone = self.stone(places)
        except InputError:
            return -math.inf
        return self.goal_of(stone)

    def goal_of(self, stone: Stone) -> float:
        """Return the goal of a stone; minus infinity where it, or what must be kept of it, cannot be."""
        from gemrender.scoring import score

        figures = varied_figures(stone)
        if not all(low <= figures[key] <= high for key, (low, high) in self.keep.items()):
            return -math.inf
        unknown = self.unknown
        if unknown is None and self.aim.has_spread:
            unknown = Rounding.of(stone)
        stones: dict[int, Stone] = {0: stone}
        seen: dict[tuple[int, Pose], dict[str, float]] = {}

        def scorer(number: int, pose: Pose) -> Mapping[str, float]:
            if number not in stones:
                assert unknown is not None
                stones[number] = draw(stone, unknown, self.seed, number)
            if (number, pose) not in seen:
                tilt, azimuth = pose
                values = self.sized.values(stones[number])
                if self.aim.measures:
                    found = score(
                        stones[number], measures=self.aim.measures, head=self.head,
                        **self.options, tilt=tilt, tilt_azimuth=azimuth,
                    )  # fmt: skip
                    for of in found.measures or ():
                        values |= {f"{of.name}.{key}": value for key, value in of.values.items()}
                seen[number, pose] = values
            return seen[number, pose]

        try:
            return self.aim.value(scorer, self.draws)
        except InputError:  # a draw makes no stone: there is no room for what is not known
            return -math.inf

    # ---- Answers ----

    def alike(self, one: Sequence[int], other: Sequence[int]) -> bool:
        """Whether two stones differ little in every parameter."""
        return all(
            abs(a - b) < _APART * max(by.count - 1, 1)
            for by, a, b in zip(self.ranges, one, other, strict=True)
        )

    def apart(self, most: int) -> list[tuple[int, ...]]:
        """Return the best stones that are not alike, the best first."""
        best: list[tuple[int, ...]] = []
        for places in sorted(self.known, key=lambda at: (-self.known[at], at)):
            if math.isfinite(self.known[places]) and not any(self.alike(places, other) for other in best):
                best.append(places)
                if len(best) == most:
                    break
        if not best:
            raise InputError(
                "no stone within these ranges can be made, or keeps what must be kept", key="vary"
            )
        return best

    def finished(self, places: tuple[int, ...]) -> tuple[int, ...]:
        """Go from a stone by single steps of single parameters to better ones, until none is."""
        while True:
            beside = [
                (*places[:k], places[k] + by, *places[k + 1 :])
                for k, of in enumerate(self.ranges)
                for by in (-1, 1)
                if 0 <= places[k] + by < of.count
            ]
            self.measure(beside)
            best = max(beside, key=lambda at: (self.known[at], at), default=places)
            if not self.known[best] > self.known[places]:
                return places
            places = best

    # ---- The journal ----

    def first_line(self) -> dict[str, Any]:
        """Return all that a goal depends on."""
        return {
            "improve": self.base.name,
            "solid": solid_digest(self.base),
            "material": self.base.material,
            "goal": self.aim.text,
            "vary": [[by.name, by.low, by.high, by.step] for by in self.ranges],
            "keep": {key: list(limits) for key, limits in self.keep.items()},
            "unknown": None if self.unknown is None else self.unknown.to_dict(),
            "draws": self.draws,
            "seed": self.seed,
            "head_deg": self.head,
            "measures": [[of.name, of.version] for of in self.aim.measures],
            "options": self.options,
            **({} if self.meets is None else {"meets": self.meets}),
            **self.sized.to_dict(),
        }

    def entry(self, line: Any) -> tuple[tuple[int, ...], float]:
        """Return places and goal from a journal's line; ValueError or TypeError if it has none."""
        places, goal = line
        if len(places) != len(self.ranges) or not all(
            type(place) is int and 0 <= place < by.count
            for place, by in zip(places, self.ranges, strict=True)
        ):
            raise ValueError("are no places")
        return tuple(places), -math.inf if goal is None else float(goal)

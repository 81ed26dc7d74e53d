"""The stones that a search may try, by their places on ranges of parameters, and their goals."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.cuts import StoneLike, as_stone
from gemrender.engines import DEFAULT_HEAD, check_head, require_engine
from gemrender.errors import InputError
from gemrender.journal import Journal
from gemrender.measures import Measure
from gemrender.processors import usable_processors
from gemrender.reading import did_you_mean
from gemrender.stone import Stone
from gemrender.sweep.cliffs import check_reach
from gemrender.sweep.improve.goals import Goal, Pose
from gemrender.sweep.improve.ranges import Range, ranges_of
from gemrender.sweep.improve.rough import Rough
from gemrender.sweep.improve.sized import Sized, read_rough
from gemrender.sweep.improve.varied import Remake, remaker, varied_figures
from gemrender.sweep.tilt import solid_digest
from gemrender.sweep.unknown import Rounding, Unknown, draw

__all__ = ["DEFAULT_DRAWS", "Places", "Search", "prepare_search"]

#: Where a stone is: its place on each range, counted in steps; whole numbers but on continuous ranges.
Places = tuple[float, ...]

#: Stones differ in some parameter by this share of its range.
_APART = 0.15
#: Error bound of the exact values that candidates are compared by [%].
DEFAULT_SEARCH_BOUND = 0.1
#: Draws that a spread is taken over.
DEFAULT_DRAWS = 16
#: Decimals of places on continuous ranges: far finer than can be cut.
_DECIMALS = 6
#: What a goal is counted as that cannot be, where a number is needed.
_NO_GOAL = -1e9


@dataclass(kw_only=True)
class Search:
    """A search: what it depends on, and what is known by now.

    Attributes
    ----------
    base : Stone
        Where it begins.
    aims : tuple of Goal
        The goals.
    ranges : tuple of Range
        What is varied.
    keep : dict
        Ranges that other figures of the stone must stay within.
    unknown : Unknown or None
        What `spread` is taken under; None is a report's rounding.
    draws, seed : int
        Number of its draws; seed of them, and of the search.
    head : float
        Half the angle at which the viewer's head is seen [deg].
    meets : str or None
        Of a design, what becomes of its meet points (`gemrender.sweep.improve.varied.remaker`).
    remade : callable
        What makes a stone with parameters changed.
    sized : Sized
        What goals need of the size of stones.
    options : dict
        Further arguments of `gemrender.score`.
    known : dict
        The goals of every stone that was tried, by its places; minus infinity where there is no stone.
    """

    base: Stone
    aims: tuple[Goal, ...]
    ranges: tuple[Range, ...]
    keep: dict[str, tuple[float, float]]
    unknown: Unknown | None
    draws: int
    seed: int
    head: float
    meets: str | None
    remade: Remake
    sized: Sized
    options: dict[str, Any]
    known: dict[Places, tuple[float, ...]] = field(default_factory=dict)
    _journal: Journal | None = None
    map: Callable[..., Iterable[Any]] = map

    @contextlib.contextmanager
    def running(self, journal: Path | None, threads: int | None) -> Iterator[None]:
        """Take up and add to a journal, and measure by threads, within.

        Raises
        ------
        InputError
            The journal is of another search, or in use.
        """
        with contextlib.ExitStack() as stack:
            if journal is not None:
                self._journal = stack.enter_context(
                    Journal(journal, self._first_line(), self._entry, work="search")
                )
                self.known.update(self._journal.known)
            pool = ThreadPoolExecutor(threads or usable_processors())
            stack.callback(pool.shutdown, cancel_futures=True)  # after Ctrl-C what waits is not begun
            self.map = pool.map
            yield

    # ---- Stones ----

    def stone(self, places: Sequence[float]) -> Stone:
        """Make the stone at these places."""
        return self.stone_of(self.values(places))

    def stone_of(self, values: Mapping[str, float]) -> Stone:
        """Make the stone with these parameters.

        Raises
        ------
        InputError
            They make none.
        """
        return self.remade(values)

    def own_values(self) -> dict[str, float]:
        """Return the stone's own values of what is varied."""
        known = varied_figures(self.base)
        return {by.name: known[by.name] for by in self.ranges}

    def values(self, places: Sequence[float]) -> dict[str, float]:
        """Return the parameters at these places."""
        return {by.name: by.at(place) for by, place in zip(self.ranges, places, strict=True)}

    def nearest(self) -> Places:
        """Return the places next to the stone's own values."""
        own = self.own_values()
        return self.on_ranges((own[by.name] - by.low) / by.step for by in self.ranges)

    def on_ranges(self, numbers: Iterable[float]) -> Places:
        """Return the nearest places that there are."""
        return tuple(
            min(
                max(round(float(number), _DECIMALS) if by.is_continuous else round(float(number)), 0), by.last
            )
            for by, number in zip(self.ranges, numbers, strict=True)
        )

    @property
    def is_whole(self) -> np.ndarray:
        """Whether the places of each range are whole numbers, (k,) bool."""
        return np.array([not by.is_continuous for by in self.ranges])

    @property
    def last(self) -> np.ndarray:
        """The last place of each range, (k,) float64."""
        return np.array([float(by.last) for by in self.ranges])

    def first_members(self, number: int) -> np.ndarray:
        """Return the first members of a population, (n, k): the start, and others by Latin hypercube."""
        from scipy.stats import qmc

        share = qmc.LatinHypercube(len(self.ranges), seed=self.seed).random(number - 1)
        # Every whole place as often as the others.
        spread = np.where(self.is_whole, np.floor(share * (self.last + 1.0)), share * self.last)
        return np.concatenate([[self.nearest()], spread]).astype(float)

    @property
    def is_exhausted(self) -> bool:
        """Whether every stone on the ranges is known: there are few, on whole steps."""
        return bool(self.is_whole.all()) and len(self.known) >= math.prod(by.count for by in self.ranges)

    @property
    def population(self) -> int:
        """Members of a population, by the number of parameters."""
        return min(60, max(16, 8 * len(self.ranges)))

    # ---- Goals ----

    def losses(self, members: np.ndarray) -> np.ndarray:
        """Return minus the goals of members, (n, k), as (n, goals): what searches make small."""
        places = [self.on_ranges(member) for member in members]
        self.measure(places)
        return -np.array([[max(goal, _NO_GOAL) for goal in self.known[at]] for at in places])

    def measure(self, places: Iterable[Places]) -> None:
        """Measure what is not known yet, by threads."""
        new = [at for at in dict.fromkeys(places) if at not in self.known]
        for at, goals in zip(new, self.map(self._goals_at, new), strict=True):
            self.known[at] = goals
            if self._journal is not None:
                self._journal.add(list(at), *(goal if math.isfinite(goal) else None for goal in goals))

    def _goals_at(self, places: Places) -> tuple[float, ...]:
        try:
            stone = self.stone(places)
        except InputError:
            return (-math.inf,) * len(self.aims)
        return self.goals_of(stone)

    @property
    def measures(self) -> tuple[Measure, ...]:
        """The measures of all goals."""
        return tuple({of.name: of for aim in self.aims for of in aim.measures}.values())

    def goals_of(self, stone: Stone, **options: Any) -> tuple[float, ...]:
        """Return the goals of a stone; minus infinity where they, or what must be kept, cannot be.

        Further options, such as another engine, take the place of the search's own.
        """
        from gemrender.scoring import score

        if self.keep:
            figures = varied_figures(stone)
            if not all(low <= figures[key] <= high for key, (low, high) in self.keep.items()):
                return (-math.inf,) * len(self.aims)
        stones: dict[int, Stone] = {0: stone}
        sizes: dict[int, dict[str, float]] = {}  # of a round stone they take longer than its light
        seen: dict[tuple[int, Pose], dict[str, float]] = {}

        def scorer(number: int, pose: Pose) -> Mapping[str, float]:
            if number not in stones:
                unknown = self.unknown or Rounding.of(stone)
                stones[number] = draw(stone, unknown, self.seed, number)
            if (number, pose) not in seen:
                tilt, azimuth = pose
                if number not in sizes:
                    sizes[number] = self.sized.values(stones[number])
                values = dict(sizes[number])
                if self.measures:
                    found = score(
                        stones[number], measures=self.measures, head=self.head,
                        **{**self.options, **options}, tilt=tilt, tilt_azimuth=azimuth,
                    )  # fmt: skip
                    for of in found.measures or ():
                        values |= {f"{of.name}.{key}": value for key, value in of.values.items()}
                seen[number, pose] = values
            return seen[number, pose]

        try:
            return tuple(aim.value(scorer, self.draws) for aim in self.aims)
        except InputError:  # a draw makes no stone: there is no room for what is not known
            return (-math.inf,) * len(self.aims)

    # ---- Answers ----

    def is_possible(self, places: Places) -> bool:
        """Whether what is at these places is a stone that has the goals, and keeps what must be kept."""
        return all(math.isfinite(goal) for goal in self.known[places])

    def alike(self, one: Sequence[float], other: Sequence[float]) -> bool:
        """Whether two stones differ little in every parameter."""
        return all(
            abs(a - b) < _APART * max(by.last, 1) for by, a, b in zip(self.ranges, one, other, strict=True)
        )

    def apart(self, most: int) -> list[Places]:
        """Return the best stones by the first goal that are not alike, the best first.

        Raises
        ------
        InputError
            There is none.
        """
        best: list[Places] = []
        for places in sorted(self.known, key=lambda at: (-self.known[at][0], at)):
            if self.is_possible(places) and not any(self.alike(places, other) for other in best):
                best.append(places)
                if len(best) == most:
                    break
        if not best:
            raise InputError(
                "no stone within these ranges can be made, or keeps what must be kept", key="vary"
            )
        return best

    # ---- The journal ----

    def _first_line(self) -> dict[str, Any]:
        """Return all that goals depend on."""
        texts = [aim.text for aim in self.aims]
        return {
            "improve": self.base.name,
            "solid": solid_digest(self.base),
            "material": self.base.material,
            "goal": texts[0] if len(texts) == 1 else texts,
            "vary": [[by.name, by.low, by.high, 0.0 if by.is_continuous else by.step] for by in self.ranges],
            "keep": {key: list(limits) for key, limits in self.keep.items()},
            "unknown": None if self.unknown is None else self.unknown.to_dict(),
            "draws": self.draws,
            "seed": self.seed,
            "head_deg": self.head,
            "measures": [[of.name, of.version] for of in self.measures],
            "options": self.options,
            **({} if self.meets is None else {"meets": self.meets}),
            **self.sized.to_dict(),
        }

    def _entry(self, line: Any) -> tuple[Places, tuple[float, ...]]:
        """Return places and goals from a journal's line; ValueError or TypeError if it has none."""
        places, *goals = line
        if len(places) != len(self.ranges) or len(goals) != len(self.aims) or not all(
            type(place) in ((int, float) if by.is_continuous else (int,)) and 0 <= place <= by.last
            for place, by in zip(places, self.ranges, strict=True)
        ):  # fmt: skip
            raise ValueError("are no places")
        return tuple(places), tuple(-math.inf if goal is None else float(goal) for goal in goals)


def prepare_search(
    stone: StoneLike,
    goals: Sequence[Goal | str],
    vary_by: Sequence[Range | str],
    *,
    keep: Mapping[str, tuple[float, float]] | None = None,
    unknown: Unknown | None = None,
    draws: int = DEFAULT_DRAWS,
    answers: int = 1,
    rounds: int = 1,
    seed: int = 1,
    head: float = DEFAULT_HEAD,
    meets: str | None = None,
    rough: Rough | str | None = None,
    options: dict[str, Any] | None = None,
    reach: float | None = None,
) -> Search:
    """Check what a search is asked for, and make it ready; parameters as of `gemrender.improve`.

    Raises
    ------
    InputError
        A value out of range, no goal, or a stone that cannot be varied.
    """
    stone = as_stone(stone)
    aims = tuple(Goal.parse(goal) if isinstance(goal, str) else goal for goal in goals)
    for key, value, low, high in (
        ("answers", answers, 1, 100), ("rounds", rounds, 1, 10_000), ("draws", draws, 2, 1000),
        ("seed", seed, 0, 2**31 - 1),
    ):  # fmt: skip
        if not low <= value <= high:
            raise InputError(f"must be from {low:g} to {high:g}", key=key, value=value)
    check_reach(reach)
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
    if unknown is None and any(aim.has_spread for aim in aims):
        Rounding.of(stone)  # refuses designs, which no report rounds
    traced = {"bound": DEFAULT_SEARCH_BOUND, **(options or {}), "engine": "exact"}
    require_engine("exact", stones=[stone])  # its first kernel must not be called by two threads at once
    return Search(
        base=stone, aims=aims, ranges=ranges, keep=dict(keep or {}), unknown=unknown, draws=draws, seed=seed,
        head=check_head(head), meets=meets, remade=remaker(stone, meets),
        sized=Sized.of(aims, stone, read_rough(rough) if isinstance(rough, str) else rough), options=traced,
    )  # fmt: skip

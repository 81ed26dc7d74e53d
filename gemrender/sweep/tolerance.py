"""What is not known of a stone does to its measures: the stone drawn many times, and measured each time."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from gemrender.cuts import StoneLike, as_stone
from gemrender.engines import DEFAULT_ENGINE, DEFAULT_HEAD, check_head, engine_for, require_engine
from gemrender.errors import InputError
from gemrender.journal import Journal
from gemrender.measures import Measure, chosen_measures
from gemrender.request import StudyOptions, spelt_out
from gemrender.shown import Tabled
from gemrender.stone import Stone
from gemrender.sweep.spreading import FEW, STUDY_RESOLUTION, limit_threads, spread
from gemrender.sweep.symmetry import MOST_DRAWS
from gemrender.sweep.tilt import solid_digest
from gemrender.sweep.unknown import Rounding, Unknown, draw
from gemrender.sweep.workers import LostProcessError

__all__ = ["Spread", "ToleranceStudy", "study_tolerance"]

#: Error bound of each draw's exact values unless another is asked for [%]: well below any spread.
DEFAULT_TOLERANCE_BOUND = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """How one value of a measure is distributed.

    Attributes
    ----------
    measure, key : str
        The measure, and the value's name.
    stated : float
        The value of the stone as it is stated.
    bound : float or None
        Bound of that value.
    mean, deviation, low, median, high, least, most : float
        Mean, standard deviation, the limits of the central 95 % and the median, least and largest value of
        the draws; NaN where a draw's value is not defined.
    """

    measure: str
    key: str
    stated: float
    bound: float | None
    mean: float
    deviation: float
    low: float
    median: float
    high: float
    least: float
    most: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class ToleranceStudy(Tabled):
    """The measures of a stone's draws.

    Attributes
    ----------
    name : str
        The stone's name.
    unknown : Unknown
        What is not known of it.
    seed : int
        Seed of the draws.
    measures : tuple of Measure
        What was measured.
    bounds : tuple of float or None
        Of each measure, of the stone as it is stated.
    stated : (k,) float64
        All values of the stone as it is stated, measure by measure.
    drawn : (draws, k) float64
        Those of each draw; NaN where one is not defined.
    """

    name: str
    unknown: Unknown
    seed: int
    measures: tuple[Measure, ...]
    bounds: tuple[float | None, ...]
    stated: np.ndarray
    drawn: np.ndarray

    def __repr__(self) -> str:
        return f"<ToleranceStudy of {self.name!r}: {len(self.drawn)} draws>"

    def spreads(self) -> tuple[Spread, ...]:
        """Return how each value is distributed, measure by measure."""
        keys = [
            (of, key, bound) for of, bound in zip(self.measures, self.bounds, strict=True) for key in of.keys
        ]
        found = []
        for place, (of, key, bound) in enumerate(keys):
            values = self.drawn[:, place]
            low, median, high = np.percentile(values, [2.5, 50.0, 97.5]).tolist()
            found.append(
                Spread(
                    measure=of.name, key=key, stated=float(self.stated[place]), bound=bound,
                    mean=float(values.mean()),
                    deviation=float(values.std(ddof=1)) if len(values) > 1 else 0.0,
                    low=low, median=median, high=high,
                    least=float(values.min()), most=float(values.max()),
                )
            )  # fmt: skip
        return tuple(found)

    def to_dict(self) -> dict[str, Any]:
        """Return the study for JSON: what is not known, and each value's distribution; null for NaN."""
        measures: dict[str, dict[str, Any]] = {}
        for of in self.spreads():
            numbers = {
                name: getattr(of, name)
                for name in ("stated", "mean", "deviation", "low", "median", "high", "least", "most")
            }
            told = {name: None if math.isnan(number) else number for name, number in numbers.items()}
            measures.setdefault(of.measure, {})[of.key] = told | {"bound": of.bound}
        return {
            "name": self.name,
            "unknown": self.unknown.to_dict(),
            "draws": len(self.drawn),
            "seed": self.seed,
            "measures": measures,
        }


@spelt_out(bound=DEFAULT_TOLERANCE_BOUND, resolution=STUDY_RESOLUTION)
def study_tolerance(
    stone: StoneLike,
    unknown: Unknown | None = None,
    *,
    measures: str | Measure | Iterable[str | Measure] = "inoue",
    draws: int = 200,
    seed: int = 1,
    head: float = DEFAULT_HEAD,
    journal: Path | None = None,
    processes: int | None = None,
    progress: Callable[[float], None] | None = None,
    **options: Unpack[StudyOptions],
) -> ToleranceStudy:
    """Measure many stones that one might as well be, on all processors.

    Parameters
    ----------
    stone : Stone, str or path
        The stone as it is stated, or what `load_stone` takes.
    unknown : Unknown, optional
        What is not known of it: `Rounding`, `Cutting` or `Measuring`; by default a report's rounding.
    measures : str, Measure, or iterable of them
        What to measure, as `chosen_measures` takes them.
    draws, seed : int
        Number of draws and their seed.
    head : float
        Half the angle at which the viewer's head is seen from the stone, 0 to below 90 [deg].
    journal : Path, optional
        File that every draw is added to when it is known; a study that was stopped goes on from it.
    processes : int, optional
        Processes to use, or threads where the exact engine has few draws; by default one a processor.
    progress : callable, optional
        Called with the share done, 0 to 1.
    **options
        How each draw is traced, as of `gemrender.score`.

    Raises
    ------
    InputError
        A value out of range, a measure that there is not, a stone of which this cannot be drawn, or a journal
        that is of another study or in use.
    LostProcessError
        Processes were lost again and again; what is in the journal is kept.
    """
    stone = as_stone(stone)
    for key, value, low, high in (("draws", draws, 1, MOST_DRAWS), ("seed", seed, 0, 2**63 - 1)):
        if not low <= value <= high:
            raise InputError(f"must be from {low:g} to {high:g}", key=key, value=value)
    unknown = unknown or Rounding.of(stone)
    unknown.check(stone)
    chosen = chosen_measures(measures)
    asked: dict[str, Any] = {"bound": DEFAULT_TOLERANCE_BOUND, "resolution": STUDY_RESOLUTION, **options}
    used = engine_for(asked.get("engine", DEFAULT_ENGINE), stone)
    if used == "exact":  # its first kernel must not be called by two threads at once: numba has no lock there
        require_engine(used, stones=[stone])
    count = sum(len(of.keys) for of in chosen)
    work = partial(_measured, stone, unknown, seed, chosen, check_head(head), asked)
    with contextlib.ExitStack() as stack:
        kept = None
        if journal is not None:
            first = {
                "tolerance": stone.name,
                "solid": solid_digest(stone),
                "material": stone.material,
                "unknown": unknown.to_dict(),
                "seed": seed,
                "measures": [[of.name, of.version] for of in chosen],
                "head_deg": float(head),
                "options": {**asked, "rear": asked.get("rear") or stone.rear_rule},
            }
            kept = stack.enter_context(
                Journal(journal, first, partial(_entry, count, len(chosen)), work="study")
            )
        known = {} if kept is None else {number: of for number, of in kept.known.items() if number < draws}
        missing = [number for number in range(-1, draws) if number not in known]  # -1: as it is stated
        try:
            results = spread(
                work, missing, processes, by_threads=used == "exact" and len(missing) <= 10 * FEW
            )
            for number, found in stack.enter_context(contextlib.closing(results)):
                known[number] = found
                if kept is not None:
                    kept.add(number, *([None if math.isnan(x) else x for x in part] for part in found))
                if progress is not None:
                    progress(len(known) / (draws + 1))
        except LostProcessError as error:
            done = "" if kept is None else f"; what is done is kept in {journal}"
            raise LostProcessError(f"{error}{done}") from error
    return ToleranceStudy(
        name=stone.name,
        unknown=unknown,
        seed=seed,
        measures=chosen,
        bounds=tuple(None if math.isnan(bound) else bound for bound in known[-1][1]),
        stated=np.array(known[-1][0]),
        drawn=np.array([known[number][0] for number in range(draws)]),
    )


#: Values and bounds of all measures of a draw; NaN where one is not defined.
_Found = tuple[list[float], list[float]]


def _measured(
    stone: Stone,
    unknown: Unknown,
    seed: int,
    measures: tuple[Measure, ...],
    head: float,
    options: dict[str, Any],
    threads: int | None,
    number: int,
) -> tuple[int, _Found]:
    from gemrender.scoring import score

    limit_threads(threads, stone, options)
    drawn = stone if number < 0 else draw(stone, unknown, seed, number)
    found = score(drawn, measures=measures, head=head, **options).measures or ()
    values = [float(value) for of in found for value in of.values.values()]
    return number, (values, [math.nan if of.bound is None else of.bound for of in found])


def _entry(count: int, measures: int, line: Any) -> tuple[int, _Found]:
    """Return number and values of a draw from a journal's line; ValueError or TypeError if it has none."""
    number, values, bounds = line
    if type(number) is not int or not -1 <= number < MOST_DRAWS:
        raise ValueError("is no number of a draw")
    if len(values) != count or len(bounds) != measures:
        raise ValueError("has other measures")
    told = ([math.nan if x is None else float(x) for x in part] for part in (values, bounds))
    first, second = told
    return number, (first, second)

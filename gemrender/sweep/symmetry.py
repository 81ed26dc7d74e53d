"""What poor symmetry does to a stone's scores: the stone drawn many times, its facets tilted at random.

Each draw has a seed of its own, so that a study can be stopped and resumed, and any draw be made again.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Iterable
from dataclasses import asdict, dataclass
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from gemrender.cuts import StoneLike, as_stone
from gemrender.engines import DEFAULT_ENGINE, engine_for
from gemrender.errors import InputError
from gemrender.journal import Journal
from gemrender.request import StudyOptions, spelt_out
from gemrender.shown import Tabled
from gemrender.stone import Stone
from gemrender.sweep.spreading import STUDY_RESOLUTION, limit_threads, spread
from gemrender.sweep.unknown import MOST_JITTER, MOST_TILT_DEG, Cutting, Measuring, draw
from gemrender.sweep.workers import LostProcessError

__all__ = ["MOST_DRAWS", "SymmetryStudy", "check_study", "draw_stone", "study_symmetry"]

MOST_DRAWS = 100_000
#: What scores may be off 0 to 100 % by, as rounding may have it [%].
_ROUNDING = 1e-3
#: Draws that a process makes at a time: enough to hide the hand-over, few enough for a lively progress.
_BATCH = 4


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class SymmetryStudy(Tabled):
    """The scores of a stone's draws.

    Attributes
    ----------
    name : str
        The stone's name.
    tilt_deg, jitter : float
        Standard deviation of the facets' tilts [deg], or of the vertices' coordinates [girdle radius].
    seed : int
        Seed of the draws.
    resolution : int or None
        Pixels a side; exact scores have none.
    average, rear : tuple of float
        Average and Rear of each draw [%].
    perfect : (float, float)
        Average and Rear of the stone as it is [%].
    """

    name: str
    tilt_deg: float
    jitter: float
    seed: int
    resolution: int | None
    average: tuple[float, ...]
    rear: tuple[float, ...]
    perfect: tuple[float, float]

    def __repr__(self) -> str:
        return f"<SymmetryStudy of {self.name!r}: {len(self.average)} draws>"

    def summary(self) -> dict[str, dict[str, float]]:
        """Return mean, standard deviation, median and the limits of the central 95 % of both scores [%]."""
        out = {}
        for name in ("average", "rear"):
            values = np.array(getattr(self, name))
            low, median, high = np.percentile(values, [2.5, 50, 97.5])
            deviation = float(values.std(ddof=1)) if len(values) > 1 else 0.0
            out[name] = {
                "mean": float(values.mean()),
                "deviation": deviation,
                "low": float(low),
                "median": float(median),
                "high": float(high),
            }
        return out

    def to_dict(self) -> dict[str, Any]:
        """Return the study for JSON."""
        return {**asdict(self), "draws": len(self.average), "summary": self.summary()}


def draw_stone(stone: Stone, tilt_deg: float, jitter: float, seed: int, number: int) -> Stone:
    """Return draw `number` of a stone: facets tilted, or vertices jittered.

    Raises
    ------
    InputError
        No draw made a stone: the deviation is too large for it.
    """
    unknown = Measuring(jitter) if jitter else Cutting(tilt_deg)
    return draw(stone, unknown, seed, number)


@spelt_out(resolution=STUDY_RESOLUTION)
def study_symmetry(
    stone: StoneLike,
    *,
    tilt_deg: float = 0.5,
    jitter: float = 0.0,
    draws: int = 200,
    seed: int = 1,
    journal: Path | None = None,
    processes: int | None = None,
    progress: Callable[[float], None] | None = None,
    **options: Unpack[StudyOptions],
) -> SymmetryStudy:
    """Score many draws of a stone, on all processors.

    Parameters
    ----------
    stone : Stone, str or path
        The stone, or what `load_stone` takes.
    tilt_deg : float
        Standard deviation of the two angles that each facet is tilted by, about a point on it [deg].
    jitter : float
        If not 0, jitter the vertices instead: standard deviation of each coordinate [girdle radius].
    draws, seed : int
        Number of draws and their seed.
    journal : Path, optional
        File that every score is added to when it is known; a study that was stopped, however that came
        about, goes on from it (`gemrender.journal.Journal`).
    processes : int, optional
        Processes to use; by default one a processor.
    progress : callable, optional
        Called with the share done, 0 to 1.
    **options
        How each is traced, as of `gemrender.observe`.

    Raises
    ------
    InputError
        A value out of range, or a journal that is of another study or in use.
    LostProcessError
        Processes were lost again and again, as where memory runs out; what is in the journal is kept.
    """
    stone = as_stone(stone)
    check_study([stone], tilt_deg=tilt_deg, jitter=jitter, draws=draws, seed=seed)
    asked: dict[str, Any] = {"resolution": STUDY_RESOLUTION, **options}
    is_exact = engine_for(asked.get("engine", DEFAULT_ENGINE), stone) == "exact"
    head = {
        "stone": stone.name,
        "vertices": stone.vertices.tolist(),
        "material": stone.material,
        "tilt_deg": tilt_deg,
        "jitter": jitter,
        "seed": seed,
        "options": {**asked, "rear": asked.get("rear") or stone.rear_rule},
    }
    with contextlib.ExitStack() as stack:
        kept = None
        if journal is not None:
            kept = stack.enter_context(Journal(journal, head, _entry, work="study"))
        known: dict[int, tuple[float, float]] = {} if kept is None else kept.known
        known = {number: scores for number, scores in known.items() if number < draws}
        missing = [number for number in range(-1, draws) if number not in known]  # -1: the stone itself
        work = partial(_score_batch, stone, tilt_deg, jitter, seed, asked)
        try:
            for number, scores in stack.enter_context(contextlib.closing(_scores(work, missing, processes))):
                known[number] = scores
                if kept is not None:
                    kept.add(number, *scores)
                if progress is not None:
                    progress(len(known) / (draws + 1))
        except LostProcessError as error:
            done = "" if kept is None else f"; what is done is kept in {journal}"
            raise LostProcessError(f"{error}{done}") from error
    return SymmetryStudy(
        name=stone.name,
        tilt_deg=0.0 if jitter else tilt_deg,
        jitter=jitter,
        seed=seed,
        resolution=None if is_exact else options["resolution"],
        average=tuple(known[number][0] for number in range(draws)),
        rear=tuple(known[number][1] for number in range(draws)),
        perfect=known[-1],
    )


def check_study(stones: Iterable[Stone], *, tilt_deg: float, jitter: float, draws: int, seed: int) -> None:
    """Refuse values out of range, and stones that facets cannot be tilted of, before any work is done."""
    for key, value, low, high in (
        ("deviation", tilt_deg, 0.0, MOST_TILT_DEG),
        ("jitter", jitter, 0.0, MOST_JITTER),
        ("draws", draws, 1, MOST_DRAWS),
        ("seed", seed, 0, 2**63 - 1),
    ):
        if not low <= value <= high:
            raise InputError(f"must be from {low:g} to {high:g}", key=key, value=value)
    for stone in stones:
        if jitter and stone.labelled_vertices is None:
            raise InputError(
                "only the 57 vertices of round brilliants can be jittered", source=stone.source or stone.name
            )
        if not jitter and not stone.is_convex:
            raise InputError("facets can be tilted of convex stones only", source=stone.source or stone.name)


def _entry(line: Any) -> tuple[int, tuple[float, float]]:
    """Return number and scores of a draw from a journal's line; ValueError or TypeError if it has none."""
    number, average, rear = line
    if type(number) is not int or not -1 <= number < MOST_DRAWS:
        raise ValueError("is no number of a draw")
    for score in (average, rear):
        if type(score) not in (int, float) or not isfinite(score) or abs(score - 50) > 50 + _ROUNDING:
            raise ValueError("is no score")
    return number, (float(average), float(rear))


def _scores(
    work: Callable[[int | None, list[int]], list[tuple[int, tuple[float, float]]]],
    numbers: list[int],
    processes: int | None,
) -> Generator[tuple[int, tuple[float, float]], None, None]:
    """Score the draws of these numbers, in any order."""
    batches = [numbers[i : i + _BATCH] for i in range(0, len(numbers), _BATCH)]
    with contextlib.closing(spread(work, batches, processes, by_threads=False)) as results:
        for scores in results:
            yield from scores


def _score_batch(
    stone: Stone,
    tilt_deg: float,
    jitter: float,
    seed: int,
    options: dict[str, Any],
    threads: int | None,
    numbers: list[int],
) -> list[tuple[int, tuple[float, float]]]:
    from gemrender.scoring import score

    limit_threads(threads, stone, options)
    out = []
    for number in numbers:
        drawn = stone if number < 0 else draw_stone(stone, tilt_deg, jitter, seed, number)
        result = score(drawn, **options)
        out.append((number, (result.average, result.rear)))
    return out

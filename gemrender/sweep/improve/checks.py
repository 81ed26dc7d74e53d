"""Answers of a search checked by the engines that it did not use: Mitsuba and the reference."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from gemrender.crosscheck import crosscheck
from gemrender.engines import DEFAULT_VARIANT, observe_alike
from gemrender.scoring import score_pixels
from gemrender.stone import Stone
from gemrender.sweep.improve.search import Search

__all__ = ["CHECK_RESOLUTION", "Check", "EngineCheck", "checked", "is_better"]

#: Pixels a side unless others are asked for.
CHECK_RESOLUTION = 256


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """How answers are checked.

    Parameters
    ----------
    variant : str
        Mitsuba variant.
    resolution : int
        Pixels a side of both engines' maps.
    """

    variant: str = DEFAULT_VARIANT
    resolution: int = CHECK_RESOLUTION


@dataclass(frozen=True, slots=True, kw_only=True)
class EngineCheck:
    """What an engine says of a stone.

    Attributes
    ----------
    engine : {"mitsuba", "reference"}
        Which.
    resolution : int
        Pixels a side.
    goals : tuple of float
        The goals, from its own values of their measures.
    average, rear : float
        The paper's scores of its pixels [%].
    failures : tuple of str
        Where its rays and the reference's differ by more than `gemrender.crosscheck` allows, in words; of the
        reference, those of the exact engine against it.
    """

    engine: str
    resolution: int
    goals: tuple[float, ...]
    average: float
    rear: float
    failures: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return asdict(self) | {"goals": list(self.goals), "failures": list(self.failures)}


def is_better(goals: Sequence[float], others: Sequence[float]) -> bool:
    """Whether some goals are better than others: none is less, and one is more."""
    pairs = list(zip(goals, others, strict=True))
    return all(a >= b for a, b in pairs) and any(a > b for a, b in pairs)


def checked(
    search: Search, stones: Sequence[Stone], by: Check, progress: Callable[[float], None] | None = None
) -> list[tuple[EngineCheck, EngineCheck]]:
    """Return what Mitsuba and the reference say of stones.

    Both follow the same rays as the exact engine once, ray by ray (`gemrender.crosscheck`), and then tell the
    goals, tilts and draws of what is not known included.

    Parameters
    ----------
    search : Search
        What the goals are of.
    stones : sequence of Stone
        The stones.
    by : Check
        How finely.
    progress : callable, optional
        Called with the share done, 0 to 1.

    Raises
    ------
    BackendError
        Mitsuba cannot run here.
    """
    done, out = 0, []

    def step() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done / (3 * len(stones)))

    traced = {"variant": by.variant, "resolution": by.resolution}
    alike = {
        key: of for key, of in search.options.items() if key not in ("engine", "time_limit", "memory_limit")
    }
    for stone in stones:
        reference, mitsuba, exact = observe_alike(stone, **{**alike, **traced})
        failures = {
            "mitsuba": crosscheck(mitsuba, reference).failures,
            "reference": crosscheck(exact, reference).failures,
        }
        scores = {of.engine: score_pixels(of) for of in (mitsuba, reference)}
        del reference, mitsuba, exact
        step()
        both = []
        for engine, of in scores.items():
            both.append(
                EngineCheck(
                    engine=engine,
                    resolution=by.resolution,
                    goals=search.goals_of(stone, engine=engine, **traced),
                    average=of.average,
                    rear=of.rear,
                    failures=tuple(failures[engine]),
                )
            )
            step()
        out.append((both[0], both[1]))
    return out

"""Parameters that are varied for a goal: how far, and in which steps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields

from gemrender.cuts.design import Design
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.parameters import unit_of
from gemrender.cuts.round_brilliant.proportions import ANGLE_RANGES, RANGES
from gemrender.errors import InputError
from gemrender.reading import did_you_mean
from gemrender.stone import Stone
from gemrender.sweep.improve.varied import varied_figures

__all__ = ["Range", "figure_name", "ranges_of"]

#: Step of each parameter that is varied unless another is asked for [deg, %, or of a ratio]: what can be cut.
STEPS = {"angle": 0.1, "": 0.01, "%": 0.5}
#: How far a parameter is varied to either side unless a range is given [deg, %, or of a ratio].
REACH = {"angle": 3.0, "": 0.2, "%": 5.0}
#: Allowed angles and distances of a design's tiers [deg, % of half the stone's length].
TIER_RANGES = {"angle": (0.1, 89.9), "distance": (0.0, 1000.0)}


@dataclass(frozen=True, slots=True)
class Range:
    """A parameter that is varied.

    Parameters
    ----------
    name : str
        Its name.
    low, high, step : float
        Its least and largest value, and the step between.
    is_continuous : bool
        Whether it is any number between them; the step is what places are counted in all the same.
    unit : {"deg", "%", ""}
        What it counts; nothing where it is a ratio.
    """

    name: str
    low: float
    high: float
    step: float
    is_continuous: bool = False
    unit: str = ""

    @property
    def count(self) -> int:
        """Number of values, whole steps apart."""
        return math.floor((self.high - self.low) / self.step + 1e-9) + 1

    @property
    def last(self) -> float:
        """The last place."""
        return (self.high - self.low) / self.step if self.is_continuous else self.count - 1

    def at(self, place: float) -> float:
        """Return a value by its place, from 0; in decimals, as it is written."""
        return float(f"{self.low + place * self.step:.10g}")


def ranges_of(
    stone: Stone, chosen: Iterable[str], kept: Mapping[str, tuple[float, float]] | None = None
) -> tuple[Range, ...]:
    """Return the ranges of parameters that are varied: as "crown_angle", "table=54:58" or "table=54:58:0.5".

    A step of 0 is any number within the range. Of a design, as "P1 angle=40:43:0.1"
    (`gemrender.sweep.improve.varied`).

    Parameters
    ----------
    stone : Stone
        A stone that was made from proportions, of a family, or from a design.
    chosen : iterable of str
        The parameters.
    kept : mapping, optional
        Ranges of parameters without one of their own.

    Raises
    ------
    InputError
        A stone without parameters, a parameter that it has not, or a range that is none.
    """
    known = varied_figures(stone)
    ranges: dict[str, Range] = {}
    for text in chosen:
        name, _, limits = (part.strip() for part in text.partition("="))
        name = figure_name(stone, name)
        if name not in known:
            raise InputError(
                f"unknown parameter; must be one of {', '.join(known)}{did_you_mean(name, list(known))}",
                key="vary",
                value=name,
            )
        if name in ranges:
            raise InputError("is varied twice", key="vary", value=name)
        unit = _unit(stone, name)
        low, high = (kept or {}).get(name, (known[name] - REACH[unit], known[name] + REACH[unit]))
        step = STEPS[unit]
        if limits:
            cells = limits.split(":")
            try:
                numbers = [float(cell) for cell in cells]
            except ValueError:
                numbers = []
            if len(numbers) not in (2, 3) or not all(map(math.isfinite, numbers)):
                raise InputError(f"must be {name}=LOW:HIGH or {name}=LOW:HIGH:STEP", key="vary", value=text)
            low, high, *rest = numbers
            if isinstance(stone.cut, Design) and high < 0:  # as .asc files write the pavilion's
                low, high = -high, -low
            step = rest[0] if rest else step
        is_continuous = step == 0
        step = step or STEPS[unit]
        least, most = _allowed(stone, name)
        low, high = max(low, least), min(high, most)
        if not low < high or not step > 0 or (high - low) / step > 1e6:
            raise InputError(
                f"must have a range within {least:g} to {most:g} and a step of 0 or more",
                key="vary",
                value=text,
            )
        if not is_continuous:  # on whole steps, as a cutter counts them
            low = math.ceil(low / step - 1e-9) * step
            if low > high:
                raise InputError(f"must have a multiple of the step {step:g} in it", key="vary", value=text)
        ranges[name] = Range(name, low, high, step, is_continuous, "deg" if unit == "angle" else unit)
    if not ranges:
        raise InputError("names no parameter to vary", key="vary")
    return tuple(ranges.values())


def figure_name(stone: Stone, text: str) -> str:
    """Return a parameter's name as it was meant; of a design's tiers letters keep their case."""
    if isinstance(stone.cut, Design):
        return " ".join(text.split())
    return text.strip().replace("-", "_").lower()


def _unit(stone: Stone, name: str) -> str:
    if name.endswith("angle"):
        return "angle"
    if isinstance(stone.cut, Family):
        unit = unit_of(stone.cut, name)
        return "angle" if unit == "deg" else unit
    return "%"


def _allowed(stone: Stone, name: str) -> tuple[float, float]:
    if isinstance(stone.cut, Design):
        return TIER_RANGES[name.rsplit(" ", 1)[1]]
    if isinstance(stone.cut, Family):
        parts = {part.name: part for part in fields(stone.cut)}  # type: ignore[arg-type]
        if name in parts:
            low, high = parts[name].metadata["range"]
        else:
            other = next(other for other in stone.cut.ALTERNATIVES if other.name == name)
            low, high = other.low, other.high
        return float(low), float(high)
    return (RANGES | ANGLE_RANGES)[name]

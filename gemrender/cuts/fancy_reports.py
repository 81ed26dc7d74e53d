"""Reports of shapes other than the round brilliant: what they print makes a cut of a family."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

from gemrender.cuts.families.stated import read_values, stated_keys
from gemrender.cuts.families.suggest import stone_of
from gemrender.cuts.girdle_words import read_culet, read_girdle
from gemrender.cuts.laboratory import REPORT_KEYS, Assumed
from gemrender.cuts.shape_words import Shape
from gemrender.cuts.size import StatedSize
from gemrender.errors import InputError
from gemrender.reading import located_at
from gemrender.stone import Stone

__all__ = ["FancyReport", "fancy_keys", "fancy_stone", "read_fancy_report"]

#: What stands for the depth.
_DEPTH = ("depth", "pavilion_depth", "pavilion_angle")
#: By how much the thick places of a girdle may exceed a round brilliant's of the same word [%], and steps on
#: the way there. The word is judged at the thinnest places between the mains, and how far the thick ones are
#: above these depends on the outline; the figure is inferred.
_MOST_THICKER, _STEPS = 3.0, 12
#: Other names that reports have for keys of families.
_SAME = ("girdle", "girdle_thickness")


@dataclass(frozen=True, slots=True)
class FancyReport:
    """What was read from a report.

    Parameters
    ----------
    cut : Family
        The cut.
    assumed : tuple of Assumed
        What was assumed or inferred.
    passed_over : tuple of str
        Keys that the family has nothing for.
    """

    cut: Any
    assumed: tuple[Assumed, ...]
    passed_over: tuple[str, ...] = ()


def fancy_keys(kind: Any) -> tuple[str, ...]:
    """Return what a report may state of a cut of a family, in the order to tell it in."""
    known = stated_keys(kind)
    usual = [key for key in REPORT_KEYS if key in known or key in ("shape", "culet")]
    return (*usual, *(key for key in known if key not in usual))


def read_fancy_report(
    shape: Shape,
    values: Mapping[str, Any],
    size: StatedSize | None = None,
    *,
    size_source: str | None = None,
    passes_over: bool = False,
) -> FancyReport:
    """Make the cut that a report of a shape describes.

    Parameters
    ----------
    shape : Shape
        The shape.
    values : mapping
        By key of `fancy_keys`: numbers [%, deg]; girdle and culet may be words.
    size : StatedSize, optional
        Its millimetres, which give length over width and the depth.
    size_source : str, optional
        The file whose section [size] states them.
    passes_over : bool
        Whether keys that the family has nothing for are passed over, as in tables of many shapes.

    Raises
    ------
    InputError
        A key or a value that is not allowed, too few of them, or some that contradict each other.
    """
    kind = shape.kind
    stated = {key: value for key, value in values.items() if key != "shape"}
    by_words = tuple(_read_culet(kind, stated))
    _read_girdle(stated)
    over: tuple[str, ...] = ()
    if passes_over:
        known = stated_keys(kind)
        over = tuple(key for key in stated if key not in known)
        stated = {key: value for key, value in stated.items() if key in known}
    made: dict[str, float] = {}
    if size is not None:
        with nullcontext() if size_source is None else located_at(size_source, "size"):
            made = size.proportions(kind, stated)
    if missing := _missing(kind, stated | made):
        raise InputError(f"needs {missing}")
    with nullcontext() if size is None else size.blamed(made, size_source):
        cut, assumed = read_values(kind, {**shape.fixed, **stated, **made})
    return FancyReport(cut, (*assumed, *by_words), over)


def fancy_stone(
    shape: Shape,
    values: Mapping[str, Any],
    size: StatedSize | None = None,
    *,
    size_source: str | None = None,
    passes_over: bool = False,
    suggests: bool = True,
    **facts: Any,
) -> tuple[Stone, FancyReport]:
    """Make the stone that a report of a shape describes.

    A girdle that is known by its word alone is as much thicker as the cut needs, within limits.

    Parameters
    ----------
    shape, values, size, size_source, passes_over
        As of `read_fancy_report`.
    suggests : bool
        Whether the error of a cut that makes no stone says what would do, which takes its time.
    **facts
        Fields of `Stone`, such as its name.

    Returns
    -------
    (Stone, FancyReport)
        The stone, without its size, and what was read.

    Raises
    ------
    InputError
        As `read_fancy_report`, or the cut makes no stone.
    """

    def read(values: Mapping[str, Any]) -> FancyReport:
        return read_fancy_report(shape, values, size, size_source=size_source, passes_over=passes_over)

    report = read(values)
    words = next((values[key] for key in _SAME if isinstance(values.get(key), str)), "")
    if words and read_girdle(words).words:
        others = {key: value for key, value in values.items() if key not in _SAME}
        for k in range(_STEPS + 1):
            try:
                if k:
                    thickness = read_girdle(words).thickness + k * _MOST_THICKER / _STEPS
                    why = f"of '{' '.join(words.casefold().split())}', as thin as the cut can be"
                    report = read(others | {"girdle_thickness": thickness})
                    taken = Assumed("girdle", thickness, why)
                    report = replace(report, assumed=(taken, *report.assumed))
                return _stone(report, report.cut.stone, facts), report
            except InputError:
                continue
        report = read(values)
    make = partial(stone_of, report.cut) if suggests else report.cut.stone
    return _stone(report, make, facts), report


def _stone(report: FancyReport, make: Callable[..., Stone], facts: Mapping[str, Any]) -> Stone:
    return make(assumed=tuple(map(str, report.assumed)), **facts)


def _missing(kind: Any, known: Mapping[str, Any]) -> str:
    """Say what a report lacks that makes a stone; nothing if it is enough."""
    keys, parts = stated_keys(kind), []
    if "table" in keys and "table" not in known:
        parts.append("the table")
    if "depth" in keys and not any(key in known for key in _DEPTH):
        parts.append("the depth (depth, millimetres, pavilion_depth or pavilion_angle)")
    return ", ".join(parts)


def _read_culet(kind: Any, stated: dict[str, Any]) -> Iterator[Assumed]:
    """Make a number of a culet's words, and say so; a family without one takes "none" alone."""
    if "culet" not in stated:
        return
    value = stated["culet"]
    try:
        width = read_culet(value)
    except InputError as error:
        raise InputError(error.allowed, key="culet", value=value) from error
    if any(part.name == "culet" for part in fields(kind)):
        stated["culet"] = width
        if width and isinstance(value, str) and not any(c.isdigit() for c in value):
            yield Assumed("culet", width, f"of '{' '.join(value.casefold().split())}'")
    elif width:
        raise InputError("must be none: cuts of this shape have none", key="culet", value=value)
    else:
        del stated["culet"]


def _read_girdle(stated: dict[str, Any]) -> None:
    """Leave one girdle: per cent rather than words; numbers in words are numbers."""
    for key in _SAME:
        if isinstance(stated.get(key), str):
            try:
                girdle = read_girdle(stated[key])
            except InputError as error:
                raise InputError(error.allowed, key=key, value=stated[key]) from error
            if not girdle.words:
                stated[key] = girdle.thickness
    if all(key in stated for key in _SAME):
        worded = isinstance(stated["girdle_thickness"], str) and not isinstance(stated["girdle"], str)
        del stated["girdle_thickness" if worded else "girdle"]

"""Cuts from what a stone file or a report states of them: parameters, or what stands for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any

from gemrender.cuts.families.family import Family
from gemrender.cuts.families.parameters import Alternative, unit_of
from gemrender.cuts.laboratory import DEPTH_RANGE, OWN, ROUNDING, WORDS_TOLERANCE, Assumed
from gemrender.cuts.round_brilliant.proportions import number_within
from gemrender.errors import InputError
from gemrender.reading import did_you_mean

__all__ = ["from_values", "read_values", "stated_keys"]

#: What the depth is the sum of, in the order in which it stands for one that is not stated.
_PARTS = ("pavilion_depth", "crown_height", "girdle_thickness")
#: Another name of a parameter.
_SAME = {"girdle": "girdle_thickness"}


def stated_keys(kind: Any) -> tuple[str, ...]:
    """Return all that may be stated of a cut of a family: parameters, alternatives to them, the depth."""
    own = tuple(part.name for part in fields(kind))
    if not issubclass(kind, Family):
        return own
    keys = (*own, *(other.name for other in kind.ALTERNATIVES))
    has_depth = all(part in own for part in _PARTS)
    return (*keys, *(("depth",) if has_depth else ()), *(key for key, name in _SAME.items() if name in own))


def from_values(kind: Any, values: Mapping[str, Any]) -> tuple[Any, tuple[str, ...]]:
    """Make the cut of a family from what a stone file says, as `read_values`; what was taken in words."""
    cut, taken = read_values(kind, values)
    return cut, tuple(map(str, taken))


def read_values(kind: Any, values: Mapping[str, Any]) -> tuple[Any, tuple[Assumed, ...]]:
    """Make the cut of a family from what a stone file says.

    Of a height and an angle that stand for each other the angle counts, and the height must agree; the depth
    gives the pavilion's depth where that is not stated, else the crown's height, else the girdle.

    Parameters
    ----------
    kind : type
        The class of the family's parameters.
    values : mapping
        By key of `stated_keys`.

    Returns
    -------
    (cut, tuple of Assumed)
        The cut, and what was taken since the file does not say it.

    Raises
    ------
    InputError
        An unknown key, a missing one, a value that is refused, or values that contradict each other.
    """
    known = stated_keys(kind)
    for key in values:
        if key not in known:
            raise InputError(
                f"unknown key; must be one of {', '.join(known)}{did_you_mean(key, list(known))}", key=key
            )
    parts = {part.name: part for part in fields(kind)}
    missing = [key for key, part in parts.items() if part.default is MISSING and key not in values]
    if missing:
        raise InputError(f"missing; needs {', '.join(missing)}", key=missing[0])
    if not issubclass(kind, Family):
        return kind(**values), ()
    own: dict[str, Any] = {}
    for key, value in values.items():
        name = _SAME.get(key, key)
        if name in own:
            raise InputError(f"{name} and {key} are one thing; state only one of them", key=key)
        if name in parts:
            own[name] = value
    taken: list[Assumed] = []
    words = own.get("girdle_thickness")
    cut = kind(**own)
    stated = set(own)
    for other in kind.ALTERNATIVES:
        if other.name in values:
            own[other.stands_for] = _by_alternative(cut, other, values, stated)
            stated.add(other.stands_for)
            cut = kind(**own)
    if "depth" in values:
        own, note = _by_depth(cut, values["depth"], own, stated, words)
        taken += [note] if note else []
        cut = kind(**own)
    if isinstance(words, str) and "girdle_thickness" in stated:
        taken.insert(0, Assumed("girdle", cut.girdle_thickness, f"of '{words}'"))
    if isinstance(own.get("culet"), str):
        taken.append(Assumed("culet", cut.culet, f"of '{own['culet']}'"))
    open_parts = [(name, part) for name, part in parts.items() if name not in own]
    # What reports leave open comes first: that is what one may want to set.
    for name, part in sorted(open_parts, key=lambda item: not item[1].metadata["why"]):
        why = part.metadata["why"]
        taken.append(Assumed(_label(name), _text(getattr(cut, name)), f"({why})" if why else OWN))
    return cut, tuple(taken)


def _by_alternative(cut: Family, other: Alternative, values: Mapping[str, Any], stated: set[str]) -> float:
    """Return the parameter that an alternative makes; where it is stated too, it must agree."""
    number = number_within(other.name, values[other.name], (other.low, other.high), unit_of(cut, other.name))
    given = cut.values()
    made = other.to_parameter(number, given)
    low, high = cut.__dataclass_fields__[other.stands_for].metadata["range"]  # type: ignore[attr-defined]
    if not low <= made <= high:
        raise InputError(
            f"gives a {_label(other.stands_for)} of {made:.3g} %; must be from {low:g} to {high:g} %",
            key=other.name,
            value=number,
        )
    if other.stands_for in stated:
        least = ROUNDING.get(other.stands_for, 0.25)
        allowed = least + max(
            abs(other.to_parameter(number + by, given) - made) for by in (-other.rounding, other.rounding)
        )
        value = given[other.stands_for]
        if abs(value - made) > allowed:
            raise InputError(
                f"{other.name} = {number:g} makes it {made:.1f} %; the rounding of a report allows a "
                f"difference of {allowed:.2g} %",
                key=other.stands_for,
                value=value,
            )
    return float(made)


def _by_depth(
    cut: Family, depth: object, own: dict[str, Any], stated: set[str], words: object
) -> tuple[dict[str, Any], Assumed | None]:
    """Fill in the part that is not stated by the total depth, or check that it agrees."""
    total = number_within("depth", depth, DEPTH_RANGE)
    known = {part: float(getattr(cut, part)) for part in _PARTS}
    open_parts = [part for part in _PARTS if part not in stated]
    if not open_parts and isinstance(words, str):  # the depth counts more than a girdle in words
        rest = total - known["crown_height"] - known["pavilion_depth"]
        if abs(rest - known["girdle_thickness"]) <= WORDS_TOLERANCE and rest >= 0:
            stated.discard("girdle_thickness")
            made = Assumed("girdle", rest, "(depth less crown and pavilion)")
            return own | {"girdle_thickness": rest}, made
    if not open_parts:
        total_made, allowed = sum(known.values()), ROUNDING["depth"] + 3 * ROUNDING["crown_height"]
        if abs(total_made - total) > allowed:
            parts = " + ".join(f"{_label(part)} {value:.1f}" for part, value in known.items())
            raise InputError(
                f"{parts} make {total_made:.1f} %; the rounding of a report allows a difference of "
                f"{allowed:.2g} %",
                key="depth",
                value=total,
            )
        return own, None
    part = open_parts[0]
    rest = total - sum(value for name, value in known.items() if name != part)
    low, high = cut.__dataclass_fields__[part].metadata["range"]  # type: ignore[attr-defined]
    if not low <= rest <= high:
        others = " and ".join(_label(name) for name in _PARTS if name != part)
        raise InputError(
            f"less {others} ({total - rest:.1f} %) leaves a {_label(part)} of {rest:.1f} %, which must be "
            f"from {low:g} to {high:g} %",
            key="depth",
            value=total,
        )
    return own | {part: rest}, Assumed(_label(part), rest, "(depth less the other parts)")


def _label(name: str) -> str:
    return name.replace("_", " ")


def _text(value: Any) -> str:
    if isinstance(value, tuple):
        return ", ".join(map(_text, value))
    return value if isinstance(value, str) else f"{value:.4g}"

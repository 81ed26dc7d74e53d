"""What would do, where the parameters of a cut make no stone."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from gemrender.cuts.families.family import Family
from gemrender.errors import InputError
from gemrender.stone import Stone

__all__ = ["stone_of", "suggestion"]

#: Halvings of the way to the family's own value, so that a suggestion is near the edge of what can be made.
_HALVINGS = 6
#: So many parameters are suggested.
_MOST = 2


def stone_of(cut: Any, **facts: Any) -> Stone:
    """Make the stone of a cut; of a family's cut that makes none the error says what would do.

    Parameters
    ----------
    cut : Cut
        The cut.
    **facts
        Fields of `Stone`, such as its name.

    Raises
    ------
    InputError
        The cut makes no stone.
    """
    try:
        stone: Stone = cut.stone(**facts)
    except InputError as error:
        if isinstance(cut, Family) and (words := suggestion(cut)):
            error.allowed += f"; {words}"
        raise
    return stone


def suggestion(cut: Family) -> str:
    """Return which parameter would make a stone of a cut, moved a little towards the family's own value.

    Parameters
    ----------
    cut : Family
        A cut whose stone cannot be made.

    Returns
    -------
    str
        Such as "girdle_thickness = 3.4 would do"; empty where no single parameter does.
    """
    own = type(cut)().values()
    found = []
    for part in fields(cut):  # type: ignore[arg-type]
        value, default = getattr(cut, part.name), own[part.name]
        if "range" not in part.metadata or value == default or not _is_stone(cut, part.name, default):
            continue
        good, bad = 1.0, 0.0
        for _ in range(_HALVINGS):
            middle = 0.5 * (good + bad)
            if _is_stone(cut, part.name, value + middle * (default - value)):
                good = middle
            else:
                bad = middle
        low, high = part.metadata["range"]
        by = good * (default - value)
        # As short as it may be written and still does.
        text = next(
            (
                text
                for text in (f"{value + by:.{digits}g}" for digits in (2, 3, 4))
                if low <= float(text) <= high and _is_stone(cut, part.name, float(text))
            ),
            f"{default:g}",
        )
        found.append((abs(by) / (high - low), f"{part.name} = {text}"))
    words = [text for _, text in sorted(found)[:_MOST]]
    return f"{' or '.join(words)} would do" if words else ""


def _is_stone(cut: Family, name: str, value: float) -> bool:
    try:
        cut.changed(**{name: value}).construction().check()
    except InputError:
        return False
    return True

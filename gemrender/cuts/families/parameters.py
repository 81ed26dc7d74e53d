"""Parameters of families: what they are, their ranges, and how they are read from a stone file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, field, fields
from typing import Any

from gemrender.cuts.round_brilliant.proportions import number_within
from gemrender.errors import InputError
from gemrender.mistakes import Mistakes
from gemrender.reading import did_you_mean

__all__ = ["check_parameters", "from_values", "parameter"]

#: Most numbers of a parameter that is a list.
_MOST = 12


def parameter(low: float, high: float, *, default: Any = MISSING, many: bool = False) -> Any:
    """Return a field of a family's parameters.

    Parameters
    ----------
    low, high : float
        Its range; of a name that ends in angle or angles [deg], else [%].
    default : float or tuple of float, optional
        Its value where a file has none; without one it must be given.
    many : bool
        Whether it is a list of such numbers.
    """
    return field(default=default, metadata={"range": (low, high), "many": many})


def check_parameters(cut: Any) -> None:
    """Check every parameter of a cut, and make its numbers floats and its lists tuples; for `__post_init__`.

    Raises
    ------
    InputError
        For each that is no number, or out of its range.
    """
    with Mistakes() as mistakes:
        for part in fields(cut):
            value = mistakes.of(_checked, part, getattr(cut, part.name))
            object.__setattr__(cut, part.name, value)


def _checked(part: Any, value: Any) -> float | tuple[float, ...]:
    limits = part.metadata["range"]
    if not part.metadata["many"]:
        return number_within(part.name, value, limits)
    if not isinstance(value, (list, tuple)) or not 1 <= len(value) <= _MOST:
        raise InputError(f"must be a list of 1 to {_MOST} numbers", key=part.name, value=value)
    unit_key = part.name.removesuffix("s")
    try:
        return tuple(number_within(unit_key, number, limits) for number in value)
    except InputError as error:
        raise InputError(error.allowed, key=part.name, value=error.value) from error


def from_values(kind: Any, values: Mapping[str, Any]) -> Any:
    """Make the cut of a family from what a stone file says.

    Raises
    ------
    InputError
        An unknown key, a missing one, or a value that is refused.
    """
    known = {part.name: part for part in fields(kind)}
    for key in values:
        if key not in known:
            raise InputError(
                f"unknown key; must be one of {', '.join(known)}{did_you_mean(key, list(known))}", key=key
            )
    missing = [key for key, part in known.items() if part.default is MISSING and key not in values]
    if missing:
        raise InputError(f"missing; needs {', '.join(missing)}", key=missing[0])
    return kind(**values)

"""Parameters of families: what they are, their ranges, and how they are read from a stone file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, field, fields
from typing import Any

from gemrender.cuts.girdle_words import read_culet, read_girdle
from gemrender.cuts.round_brilliant.proportions import number_within
from gemrender.errors import InputError
from gemrender.mistakes import Mistakes

__all__ = ["Alternative", "check_parameters", "choice", "culet", "girdle_thickness", "parameter", "unit_of"]

#: Most numbers of a parameter that is a list.
_MOST = 12


def parameter(
    low: float,
    high: float,
    *,
    default: Any = MISSING,
    many: bool = False,
    unit: str | None = None,
    why: str = "",
    words: Callable[[str], float] | None = None,
    or_zero: bool = False,
) -> Any:
    """Return a field of a family's parameters.

    Parameters
    ----------
    low, high : float
        Its range.
    default : float or tuple of float, optional
        Its value where a file has none; without one it must be given.
    many : bool
        Whether it is a list of such numbers.
    unit : str, optional
        Its unit, "" for none; by default "deg" of a name that ends in angle or angles, else "%".
    why : str
        Of what reports leave open: why the default is what it is, such as "the commonest"; `gemrender
        inspect` says so.
    words : callable, optional
        What turns words into the number; raises InputError for words that it does not know.
    or_zero : bool
        Whether it may be 0, too: nothing at all, such as no culet.
    """
    return field(
        default=default,
        metadata={
            "range": (low, high), "many": many, "unit": unit, "why": why, "words": words, "or_zero": or_zero,
        },
    )  # fmt: skip


def choice(*allowed: Any, default: Any, why: str = "") -> Any:
    """Return a field of a family's parameters that is one of a few integers or words.

    Parameters
    ----------
    *allowed : int or str
        What it may be.
    default : int or str
        Its value where a file has none.
    why : str
        As of `parameter`.
    """
    return field(default=default, metadata={"allowed": allowed, "unit": "", "why": why})


def girdle_thickness(default: float = 3.0, low: float = 0.0, high: float = 20.0) -> Any:
    """Return the field of a girdle's thickness: per cent of the width, or a laboratory's words."""
    return parameter(low, high, default=default, words=lambda text: read_girdle(text).thickness)


def culet(low: float = 0.2, high: float = 20.0) -> Any:
    """Return the field of a culet's width: 0 for none, per cent of the width, or a laboratory's words."""
    return parameter(low, high, default=0.0, or_zero=True, words=read_culet)


@dataclass(frozen=True, slots=True)
class Alternative:
    """What may be stated in place of a parameter, such as an angle in place of a height.

    Parameters
    ----------
    name : str
        Its name, such as "crown_angle".
    stands_for : str
        The parameter.
    low, high : float
        Its range.
    to_parameter : callable
        From its value and the values of all parameters, the parameter's value; analytic.
    from_parameter : callable
        From the values of all parameters, its value; analytic.
    rounding : float
        Half of the step that laboratories round it to.
    """

    name: str
    stands_for: str
    low: float
    high: float
    to_parameter: Callable[[Any, Mapping[str, Any]], Any]
    from_parameter: Callable[[Mapping[str, Any]], Any]
    rounding: float


def unit_of(cut: Any, name: str) -> str:
    """Return the unit of a parameter of a family or of an alternative to one: "deg", "%", or "" for none."""
    known = {part.name: part for part in fields(cut)}
    unit = known[name].metadata["unit"] if name in known else None
    if unit is None:
        return "deg" if name.removesuffix("s").endswith("angle") else "%"
    return str(unit)


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


def _checked(part: Any, value: Any) -> Any:
    if "allowed" in part.metadata:
        return _chosen(part, value)
    limits, unit = part.metadata["range"], part.metadata["unit"]
    if part.metadata["words"] is not None and isinstance(value, str):
        try:
            value = part.metadata["words"](value)
        except InputError as error:
            raise InputError(error.allowed, key=part.name, value=value) from error
    if part.metadata["or_zero"] and not isinstance(value, bool) and value == 0:
        return 0.0
    if not part.metadata["many"]:
        try:
            return number_within(part.name, value, limits, unit)
        except InputError as error:
            if part.metadata["or_zero"]:
                error.allowed = error.allowed.replace("from", "0, or from", 1)
            raise
    if not isinstance(value, (list, tuple)) or not 1 <= len(value) <= _MOST:
        raise InputError(f"must be a list of 1 to {_MOST} numbers", key=part.name, value=value)
    unit_key = part.name.removesuffix("s")
    try:
        return tuple(number_within(unit_key, number, limits, unit) for number in value)
    except InputError as error:
        raise InputError(error.allowed, key=part.name, value=error.value) from error


def _chosen(part: Any, value: Any) -> Any:
    allowed = part.metadata["allowed"]
    given = value.strip().casefold() if isinstance(value, str) else value
    if isinstance(given, float) and given.is_integer():  # from a table of numbers
        given = int(given)
    if isinstance(given, bool) or given not in allowed:
        quoted = ", ".join(f'"{one}"' if isinstance(one, str) else f"{one}" for one in allowed)
        raise InputError(f"must be one of {quoted}", key=part.name, value=value)
    return given

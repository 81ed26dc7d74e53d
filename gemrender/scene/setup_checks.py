"""Checks of the parts of a set-up: each raises `InputError` where an attribute is not allowed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gemrender.errors import InputError
from gemrender.reading import did_you_mean

__all__ = ["RADIANCE_RANGE", "numbers", "one_line", "one_of", "radiance", "spectrum", "two_sizes", "within"]

#: Radiances that are not 0: single precision holds what is left of the least after many reflections.
RADIANCE_RANGE = (1e-20, 1e9)


def one_of(part: Any, key: str, allowed: Sequence[str]) -> None:
    """Check that an attribute is one of some words."""
    value = getattr(part, key)
    if value not in allowed:
        hint = did_you_mean(value, allowed) if isinstance(value, str) else ""
        raise InputError(f"must be one of {', '.join(allowed)}{hint}", key=key, value=value)


def numbers(part: Any, key: str, count: int, low: float, high: float) -> tuple[float, ...]:
    """Return an attribute that is so many numbers in a range."""
    value = getattr(part, key)
    good = isinstance(value, (list, tuple)) and len(value) == count
    for number in value if good else ():
        good &= isinstance(number, (int, float)) and not isinstance(number, bool) and low <= number <= high
    if not good:
        raise InputError(f"must be {count} numbers from {low:g} to {high:g}", key=key, value=value)
    return tuple(float(number) for number in value)


def two_sizes(value: Any) -> tuple[float, float]:
    """Return the two sizes that one or two numbers stand for."""
    size = value
    if isinstance(size, (int, float)) and not isinstance(size, bool):
        size = (size, size)
    allowed = "must be one or two numbers above 0 [girdle radius]"
    if not isinstance(size, (list, tuple)) or len(size) != 2:
        raise InputError(allowed, key="size", value=value)
    for side in size:
        if isinstance(side, bool) or not isinstance(side, (int, float)) or not 0 < side <= 1e4:
            raise InputError(allowed, key="size", value=value)
    return float(size[0]), float(size[1])


def within(part: Any, key: str, low: float, high: float) -> None:
    """Check that an attribute is a number in a range."""
    value = getattr(part, key)
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not number or not low <= value <= high:  # false for NaN too
        raise InputError(f"must be a number from {low:g} to {high:g}", key=key, value=value)


def one_line(part: Any, key: str) -> None:
    """Check that an attribute is text without line breaks or null characters."""
    value = getattr(part, key)
    if not isinstance(value, str) or not (value == "" or value.isprintable()):
        raise InputError("must be text, in one line", key=key, value=value)


def radiance(part: Any) -> None:
    """Check the radiance."""
    low, high = RADIANCE_RANGE
    within(part, "radiance", 0, high)
    if 0 < part.radiance < low:
        raise InputError(f"must be 0 or from {low:g} to {high:g}", key="radiance", value=part.radiance)


def spectrum(part: Any, key: str = "spectrum") -> None:
    """Check the name or the temperature of a light."""
    from gemrender.colorimetry import white_xyz

    try:
        white_xyz(getattr(part, key))
    except InputError as error:
        raise InputError(error.allowed, key=key, value=error.value) from error

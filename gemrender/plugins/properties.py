"""How plugins read their parameters: checked where they are read, told in one line."""

from __future__ import annotations

import math

import mitsuba as mi
import numpy as np

from gemrender.errors import InputError

__all__ = ["choice", "crystal_axes", "direction", "number", "three_numbers", "truth", "whole_number"]

#: Cosine of axes that are at right angles: numbers with four decimals are less than this off.
_ACROSS = 1e-3


def choice(props: mi.Properties, key: str, allowed: tuple[str, ...]) -> str:
    """Read one of some words, by default the first."""
    value = props.get(key, allowed[0])
    if value not in allowed:
        raise InputError(f"must be one of {', '.join(allowed)}", key=key, value=value)
    return str(value)


def number(props: mi.Properties, key: str, default: float) -> float:
    """Read a finite number."""
    value = props.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError("must be a finite number", key=key, value=value)
    return float(value)


def whole_number(props: mi.Properties, key: str, default: int, *, least: int) -> int:
    """Read a whole number of at least `least`."""
    value = props.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value < 1 << 32:
        raise InputError(f"must be a whole number, at least {least}", key=key, value=value)
    return value


def truth(props: mi.Properties, key: str, default: bool) -> bool:
    """Read true or false."""
    value = props.get(key, default)
    if not isinstance(value, bool):
        raise InputError("must be true or false", key=key, value=value)
    return value


def direction(
    props: mi.Properties, key: str, default: tuple[float, float, float] | None = None
) -> np.ndarray:
    """Read a direction, as a unit vector (3,)."""
    value = props[key] if default is None else props.get(key, mi.ScalarVector3f(*default))
    given = np.array(value, dtype=np.float64)
    length = np.linalg.norm(given)
    if given.shape != (3,) or not 0 < length < np.inf:
        raise InputError("must be a vector that is not 0", key=key, value=given.tolist())
    return np.asarray(given / length)


def three_numbers(props: mi.Properties, key: str) -> np.ndarray:
    """Read three finite numbers, (3,)."""
    try:
        given = np.array(props[key], dtype=np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape != (3,) or not np.isfinite(given).all():
        raise InputError("must be three finite numbers", key=key, value=props[key])
    return given


def crystal_axes(props: mi.Properties) -> np.ndarray:
    """Read `c_axis` and `a_axis`: the optic frame, (3, 3), rows its axes, unit vectors, right-handed."""
    third = direction(props, "c_axis", (0.0, 0.0, 1.0))
    if "a_axis" in props:
        first = direction(props, "a_axis", (1.0, 0.0, 0.0))
        off = abs(float(first @ third))
        if off > _ACROSS:
            angle = np.degrees(np.arcsin(min(off, 1.0)))
            raise InputError(
                f"must be at right angles to c_axis, and is {angle:.3g} degrees off",
                key="a_axis",
                value=first.tolist(),
            )
    else:
        first = np.eye(3)[int(np.argmin(np.abs(third)))]
    first = first - (first @ third) * third
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(third, first), third])

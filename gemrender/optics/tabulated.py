"""Values by wavelength as a table, and the checks of what goes into one."""

from __future__ import annotations

import math
import numbers
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.mistakes import Mistakes

__all__ = ["WAVELENGTHS_NM", "Table", "finite", "is_list", "numbers_of"]

#: Wavelengths that a range or a table may have [nm]: the far ultraviolet to the far infrared.
WAVELENGTHS_NM = (100.0, 100_000.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """Values at increasing wavelengths, linear in the wavelength between the rows.

    Parameters
    ----------
    wavelength_nm : sequence of float
        At least two, increasing, within `WAVELENGTHS_NM` [nm].
    values : sequence of float
        One for each wavelength, in the unit of what they are.
    key : str
        What errors call the values.

    Raises
    ------
    InputError
        Rows that make no table.
    """

    wavelength_nm: tuple[float, ...]
    values: tuple[float, ...]
    key: str = "values"

    def __post_init__(self) -> None:
        with Mistakes() as mistakes:
            mistakes.of(numbers_of, self.wavelength_nm, "wavelength_nm")
            mistakes.of(numbers_of, self.values, self.key)
        wavelengths = numbers_of(self.wavelength_nm, "wavelength_nm")
        values = numbers_of(self.values, self.key)
        if len(wavelengths) < 2:
            raise InputError(
                "must be at least 2 wavelengths [nm]", key="wavelength_nm", value=list(wavelengths)
            )
        low, high = WAVELENGTHS_NM
        for i, wavelength in enumerate(wavelengths):
            if not low <= wavelength <= high:
                raise InputError(
                    f"must be from {low:g} to {high:g} nm", key=f"wavelength_nm[{i}]", value=wavelength
                )
            if i and wavelength <= wavelengths[i - 1]:
                raise InputError(
                    f"must be increasing: above {wavelengths[i - 1]:g}",
                    key=f"wavelength_nm[{i}]",
                    value=wavelength,
                )
        if len(values) != len(wavelengths):
            raise InputError(
                f"must be as many as wavelength_nm: {len(wavelengths)}, not {len(values)}", key=self.key
            )
        object.__setattr__(self, "wavelength_nm", wavelengths)
        object.__setattr__(self, "values", values)

    def at(self, wavelength_nm: Any, *, continued: bool = False) -> np.ndarray:
        """Return the values at some wavelengths.

        Parameters
        ----------
        wavelength_nm : array_like
            Wavelengths [nm].
        continued : bool
            Beyond the ends, go on as the table's first and last pieces do; else keep the values of the ends.
        """
        asked = np.asarray(wavelength_nm, dtype=np.float64)
        x, y = np.array(self.wavelength_nm), np.array(self.values)
        values = np.interp(asked, x, y)
        if continued:
            values = np.where(asked < x[0], y[0] + (asked - x[0]) * (y[1] - y[0]) / (x[1] - x[0]), values)
            beyond = y[-1] + (asked - x[-1]) * (y[-1] - y[-2]) / (x[-1] - x[-2])
            values = np.where(asked > x[-1], beyond, values)
        return np.asarray(values)


def finite(value: object) -> bool:
    """Whether a value is a finite number, and no truth value."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond every float
        return False


def is_list(value: object) -> bool:
    """Whether a value is a list of something, and no text."""
    if isinstance(value, np.ndarray):
        return value.ndim > 0
    return isinstance(value, Sequence) and not isinstance(value, (str, bytes))


def numbers_of(values: Any, key: str) -> tuple[float, ...]:
    """Return a list's numbers as floats; refuse what is no list of finite numbers."""
    if not is_list(values):
        raise InputError("must be a list of numbers", key=key, value=values)
    for i, value in enumerate(values):
        if not finite(value):
            raise InputError("must be a finite number", key=f"{key}[{i}]", value=value)
    return tuple(float(value) for value in values)

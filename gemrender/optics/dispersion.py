"""Refractive index by wavelength: the formulae that materials are published in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.optics.tabulated import Table, is_list, numbers_of
from gemrender.reading import did_you_mean

__all__ = [
    "FORMULAE",
    "INDEX_RANGE",
    "LARGEST_COEFFICIENT",
    "SODIUM_NM",
    "VISIBLE_NM",
    "Dispersion",
    "Formula",
    "index_of",
]

#: Allowed range of a refractive index.
INDEX_RANGE = (1.05, 4.0)
#: Visible light, where every material has an index [nm].
VISIBLE_NM = (380.0, 760.0)
#: The sodium D line (the middle of its two) that gemmologists measure indices at [nm].
SODIUM_NM = 589.3

#: Names of the formulae, and what their coefficients are; L is the wavelength in vacuum [um].
FORMULAE: dict[str, str] = {
    "sellmeier": "pairs [B, C] of n^2 = 1 + sum B L^2 / (L^2 - C^2), C in um",
    "sellmeier-2": "pairs [B, C] of n^2 = 1 + sum B L^2 / (L^2 - C), C in um^2",
    "pole": "four numbers [A, B, C, D] of n^2 = A + B / (L^2 - C) + D L^2",
    "cauchy": "numbers [A, B, C, ...] of n = A + B / L^2 + C / L^4 + ...",
}
#: Largest coefficient, up or down: far above all that were ever published, and its square is a float.
LARGEST_COEFFICIENT = 1e9

#: The two forms of Sellmeier's equation, each by the other: catalogues have both, with the same letters.
_OTHER_SELLMEIER = {"sellmeier": "sellmeier-2", "sellmeier-2": "sellmeier"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Formula:
    """A formula for the refractive index.

    The forms are those of refractiveindex.info: "sellmeier" is its formula 1 and "sellmeier-2" its formula 2,
    where a pair [B, 0] stands for a constant; "pole" is its formula 4 with one pole, and "cauchy" its
    formula 5 with even powers. (M. N. Polyanskiy, Sci. Data 11, 94 (2024), doi 10.1038/s41597-023-02898-2.)

    Parameters
    ----------
    formula : str
        One of `FORMULAE`.
    coefficients : sequence of pairs of float, or of float
        As `FORMULAE` says, for L in micrometres.

    Raises
    ------
    InputError
        Unknown formula, or coefficients that are not its own.
    """

    formula: str
    coefficients: tuple[Any, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.formula, str) or self.formula not in FORMULAE:
            guess = did_you_mean(self.formula, FORMULAE) if isinstance(self.formula, str) else ""
            raise InputError(
                f"must be one of {', '.join(FORMULAE)}{guess}", key="formula", value=self.formula
            )
        allowed = f"must be {FORMULAE[self.formula]}"
        key, given = "coefficients", self.coefficients
        if not is_list(given) or not len(given):
            raise InputError(allowed, key=key, value=given)
        made: tuple[Any, ...]
        if self.formula.startswith("sellmeier"):
            for i, pair in enumerate(given):
                if not is_list(pair) or len(pair) != 2:
                    raise InputError(allowed, key=f"{key}[{i}]", value=pair)
            made = tuple(_coefficients(pair, f"{key}[{i}]") for i, pair in enumerate(given))
        else:
            made = _coefficients(given, key)
            if self.formula == "pole" and len(made) != 4:
                raise InputError(allowed, key=key, value=list(made))
        object.__setattr__(self, key, made)

    def index(self, wavelength_nm: Any) -> np.ndarray:
        """Return the index at some wavelengths [nm]; NaN or infinite where the formula makes none."""
        length_um = np.asarray(wavelength_nm, dtype=np.float64) / 1000
        with np.errstate(all="ignore"):
            return np.asarray(_COMPUTED[self.formula](length_um**2, self.coefficients))

    def other_sellmeier(self) -> Formula | None:
        """Return the formula of the same coefficients in the other of Sellmeier's forms; None for no such."""
        other = _OTHER_SELLMEIER.get(self.formula)
        return None if other is None else Formula(formula=other, coefficients=self.coefficients)

    def poles_nm(self) -> tuple[float, ...]:
        """Return the wavelengths [nm] at which the formula has a pole."""
        if self.formula == "sellmeier":
            squares = [c**2 for b, c in self.coefficients if b]
        elif self.formula == "sellmeier-2":
            squares = [c for b, c in self.coefficients if b]
        elif self.formula == "pole" and self.coefficients[1]:
            squares = [self.coefficients[2]]
        else:
            squares = []
        return tuple(1000 * square**0.5 for square in squares if square > 0)


def _coefficients(values: Any, key: str) -> tuple[float, ...]:
    made = numbers_of(values, key)
    for i, value in enumerate(made):
        if abs(value) > LARGEST_COEFFICIENT:
            allowed = f"must be from {-LARGEST_COEFFICIENT:g} to {LARGEST_COEFFICIENT:g}"
            raise InputError(allowed, key=f"{key}[{i}]", value=value)
    return made


#: Where a material's index comes from; a table is of the index.
Dispersion = Formula | Table


def index_of(dispersion: Dispersion, wavelength_nm: Any) -> np.ndarray:
    """Return the index at some wavelengths [nm]; a table is continued as its end pieces run."""
    if isinstance(dispersion, Table):
        return dispersion.at(wavelength_nm, continued=True)
    return dispersion.index(wavelength_nm)


def _sellmeier(square: np.ndarray, coefficients: tuple[tuple[float, float], ...]) -> np.ndarray:
    return np.asarray(np.sqrt(1.0 + sum(b * square / (square - c**2) for b, c in coefficients)))


def _sellmeier_2(square: np.ndarray, coefficients: tuple[tuple[float, float], ...]) -> np.ndarray:
    return np.asarray(np.sqrt(1.0 + sum(b * square / (square - c) for b, c in coefficients)))


def _pole(square: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
    a, b, c, d = coefficients
    return np.asarray(np.sqrt(a + b / (square - c) + d * square))


def _cauchy(square: np.ndarray, coefficients: tuple[float, ...]) -> np.ndarray:
    index = np.zeros_like(square)
    for coefficient in reversed(coefficients):
        index = index / square + coefficient
    return index


_COMPUTED: dict[str, Callable[[np.ndarray, Any], np.ndarray]] = {
    "sellmeier": _sellmeier,
    "sellmeier-2": _sellmeier_2,
    "pole": _pole,
    "cauchy": _cauchy,
}

"""What is measured of a view of a stone: scores and values of measures, each with its bound."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

__all__ = ["MeasureValues", "Measurement", "bound_text"]

#: Bounds are not told more closely [%].
_LEAST_BOUND = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeasureValues:
    """What one measure says of a view of a stone.

    Attributes
    ----------
    name, version : str, int
        Of the measure.
    values : dict of str to float
        Its values by name; NaN where one is not defined, such as a share of a table that there is not.
    bound : float or None
        Each of them is within this of the truth, with a confidence of 99.9 %; None where that is not known.
    details : dict
        Further values that are no means, such as numbers of virtual facets.
    """

    name: str
    version: int
    values: dict[str, float]
    bound: float | None
    details: dict[str, Any] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON has it: values and details by name, bound and version; null for NaN."""
        values: dict[str, Any] = {
            key: None if math.isnan(value) else value for key, value in self.values.items()
        }
        return values | self.details | {"bound": self.bound, "version": self.version}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Measurement:
    """The exact scores of one view of a stone, in per cent of the area of the view.

    Attributes
    ----------
    average : float
        Mean intensity, rear light counted as 0 [%].
    rear, trapped, lost : float
        Shares of the view [%].
    bands : (6,) float64
        Shares of the lit part by intensity, brightest first [%].
    bound : float
        Each of these is within this of the truth, with a confidence of 99.9 % [%].
    rays : int
        Rays that were followed near the girdle.
    area : float
        Area of the view [girdle radius^2].
    sizes : (n,) float64
        Areas of the virtual facets of the whole view, girdle cells left out [% of the view].
    girdle : float
        Share of the view that no polygon tells [%].
    seconds : float
        Time that it took [s].
    notes : tuple of str
        What was asked for and not reached, in words; empty where all was.
    measures : tuple of MeasureValues
        What further measures say.
    """

    average: float
    rear: float
    bands: np.ndarray
    trapped: float
    lost: float
    bound: float
    rays: int
    area: float
    sizes: np.ndarray
    girdle: float
    seconds: float
    notes: tuple[str, ...] = ()
    measures: tuple[MeasureValues, ...] = ()


def bound_text(bound: float) -> str:
    """Return an error bound [%] in words: with two digits, rounded up, so that what is stated is true."""
    bound = max(bound, _LEAST_BOUND)
    decimals = 1 - math.floor(math.log10(bound))
    step = 10.0**-decimals
    rounded = math.ceil(bound / step * (1.0 - 1e-12)) * step
    return f"{rounded:.{max(decimals, 0)}f}".rstrip("0").rstrip(".") if decimals > 0 else f"{rounded:.0f}"

"""A gem material: refractive index and absorption by wavelength, and density."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.optics.dispersion import Dispersion, Formula
from gemrender.optics.tabulated import WAVELENGTHS_NM, Table, finite, numbers_of

__all__ = [
    "DENSITY_RANGE",
    "INDEX_RANGE",
    "SODIUM_NM",
    "VISIBLE_NM",
    "Material",
    "carat_to_girdle_diameter_mm",
    "checked_range",
    "constant_index",
]

#: Allowed range of a refractive index.
INDEX_RANGE = (1.05, 4.0)
#: Allowed range of a density [g/cm^3]: lighter than amber, heavier than every gem.
DENSITY_RANGE = (0.5, 25.0)
#: Visible light, where every material has an index [nm].
VISIBLE_NM = (380.0, 760.0)
#: The sodium D line (the middle of its two) that gemmologists measure indices at [nm].
SODIUM_NM = 589.3
#: Fraunhofer's G and B lines, whose indices differ by what gemmologists call dispersion [nm].
FRAUNHOFER_G_NM, FRAUNHOFER_B_NM = 430.8, 686.7

#: Masses that a stone may have [carat]: from diamond dust of 0.1 mm to a boulder of 200 kg.
CARAT_RANGE = (1e-5, 1e6)
#: Mass of a carat [g].
_CARAT_G = 0.2
#: Wavelengths at which an index is checked: between its poles a formula is smooth.
_N_CHECKED = 2000


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """A gem material.

    Parameters
    ----------
    name : str
        What to call it in tables and messages.
    dispersion : Formula or Table
        Index by wavelength; of a birefringent material the ordinary one.
    range_nm : pair of float
        Wavelengths that the dispersion was published for [nm]. It is continued where visible light,
        `VISIBLE_NM`, goes beyond them.
    source : str
        Where the numbers come from.
    note : str
        What a user should know before trusting them.
    density : float or None
        Density [g/cm^3]; None is unknown.
    absorption : Table or None
        Absorption coefficient, to the base e [1/mm]; None is a colourless material. Beyond the ends of the
        table, their values hold.

    Raises
    ------
    InputError
        A range without visible light, an index that leaves `INDEX_RANGE` anywhere, a negative absorption
        coefficient, a density that no gem has.
    """

    name: str
    dispersion: Dispersion
    range_nm: tuple[float, float]
    source: str = ""
    note: str = ""
    density: float | None = None
    absorption: Table | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "range_nm", checked_range(self.range_nm))
        if self.density is not None:
            low, high = DENSITY_RANGE
            if not finite(self.density) or not low <= self.density <= high:
                raise InputError(
                    f"must be a number from {low:g} to {high:g} g/cm3", key="density", value=self.density
                )
            object.__setattr__(self, "density", float(self.density))
        self._check_index()
        if self.absorption is not None:
            for i, value in enumerate(self.absorption.values):
                if value < 0:
                    raise InputError(
                        "must be at least 0 [1/mm]", key=f"absorption.{self.absorption.key}[{i}]", value=value
                    )

    def _check_index(self) -> None:
        first, last = self.wavelengths_nm
        poles = self.dispersion.poles_nm() if isinstance(self.dispersion, Formula) else ()
        tried = np.concatenate([np.linspace(first, last, _N_CHECKED), VISIBLE_NM, self.range_nm, poles])
        if isinstance(self.dispersion, Table):
            tried = np.concatenate([tried, self.dispersion.wavelength_nm])
        tried = np.sort(tried[(tried >= first) & (tried <= last)])
        index = self._index(tried)
        low, high = INDEX_RANGE
        with np.errstate(invalid="ignore"):
            wrong = ~((index >= low) & (index <= high))  # true for NaN too
        if wrong.any():
            at = int(np.argmax(wrong))
            raise InputError(
                f"must be from {low:g} to {high:g} at every wavelength from {first:g} to {last:g} nm",
                key=f"index at {tried[at]:.6g} nm",
                value=float(index[at]),
            )

    def _index(self, wavelength_nm: np.ndarray) -> np.ndarray:
        if isinstance(self.dispersion, Table):
            return self.dispersion.at(wavelength_nm, continued=True)
        return self.dispersion.index(wavelength_nm)

    @classmethod
    def constant(cls, index: float) -> Material:
        """Make a colourless material without dispersion.

        Parameters
        ----------
        index : float
            Refractive index at every wavelength, within `INDEX_RANGE`.
        """
        value = constant_index(index)
        return cls(
            name=f"index {value:g}",
            dispersion=Formula(formula="cauchy", coefficients=(value,)),
            range_nm=WAVELENGTHS_NM,
            note="without dispersion",
        )

    @property
    def wavelengths_nm(self) -> tuple[float, float]:
        """The lowest and the highest wavelength that `index` takes [nm]: the range and visible light."""
        return min(self.range_nm[0], VISIBLE_NM[0]), max(self.range_nm[1], VISIBLE_NM[1])

    def index(self, wavelength_nm: Any) -> np.ndarray:
        """Return the refractive index relative to air.

        Parameters
        ----------
        wavelength_nm : array_like
            Wavelengths within `wavelengths_nm` [nm].

        Returns
        -------
        array like `wavelength_nm`

        Raises
        ------
        InputError
            A wavelength outside.
        """
        asked = np.asarray(wavelength_nm, dtype=np.float64)
        first, last = self.wavelengths_nm
        outside = ~((asked >= first) & (asked <= last))  # true for NaN too
        if outside.any():
            raise InputError(
                f"must be from {first:g} to {last:g} nm for {self.name}",
                key="wavelength_nm",
                value=float(asked[outside].flat[0]),
            )
        return self._index(asked)

    def absorption_per_mm(self, wavelength_nm: Any) -> np.ndarray:
        """Return the absorption coefficient a [1/mm]; light is down to exp(-a s) after a path of s mm.

        Parameters
        ----------
        wavelength_nm : array_like
            Wavelengths [nm].
        """
        if self.absorption is None:
            return np.zeros(np.shape(wavelength_nm))
        return self.absorption.at(wavelength_nm)

    @property
    def dispersion_b_g(self) -> float:
        """What gemmologists call dispersion: the index at 430.8 nm less that at 686.7 nm."""
        blue, red = self.index([FRAUNHOFER_G_NM, FRAUNHOFER_B_NM])
        return float(blue - red)


def constant_index(index: object) -> float:
    """Return an index given as a number, or refuse it."""
    low, high = INDEX_RANGE
    if isinstance(index, bool) or not isinstance(index, (int, float)) or not low <= index <= high:
        raise InputError(f"must be a number from {low:g} to {high:g}", key="index", value=index)
    return float(index)


def carat_to_girdle_diameter_mm(carat: float, volume: float, density: float) -> float:
    """Return the girdle's diameter of a stone of so many carats [mm].

    Parameters
    ----------
    carat : float
        Mass [carat of 0.2 g].
    volume : float
        Volume of the stone [girdle radius^3].
    density : float
        Density [g/cm^3].

    Raises
    ------
    InputError
        A value that is not finite and above 0, or a mass outside `CARAT_RANGE`.
    """
    for key, value in {"carat": carat, "volume": volume, "density": density}.items():
        if not finite(value) or value <= 0:
            raise InputError("must be a finite number above 0", key=key, value=value)
    low, high = CARAT_RANGE
    if not low <= carat <= high:
        raise InputError(f"must be from {low:g} to {high:g} [carat]", key="carat", value=carat)
    volume_mm3 = 1000.0 * _CARAT_G * carat / density
    return float(2.0 * (volume_mm3 / volume) ** (1 / 3))


def checked_range(range_nm: Sequence[float]) -> tuple[float, float]:
    """Return a range of wavelengths [nm] that a dispersion may have, or refuse it."""
    pair = numbers_of(range_nm, "range_nm")
    low, high = WAVELENGTHS_NM
    if len(pair) != 2 or not low <= pair[0] < pair[1] <= high:
        raise InputError(
            f"must be two wavelengths from {low:g} to {high:g} nm, the lower one first",
            key="range_nm",
            value=list(pair),
        )
    if pair[0] > VISIBLE_NM[1] or pair[1] < VISIBLE_NM[0]:
        raise InputError(
            f"must reach into visible light, {VISIBLE_NM[0]:g} to {VISIBLE_NM[1]:g} nm",
            key="range_nm",
            value=list(pair),
        )
    return pair[0], pair[1]

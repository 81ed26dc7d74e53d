"""A gem material: refractive index and absorption by wavelength, and density."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.mistakes import Mistakes
from gemrender.optics.abbe import (
    ABBE_LINES_NM,
    FRAUNHOFER_B_NM,
    FRAUNHOFER_G_NM,
    SODIUM_NM,
    abbe_number,
)
from gemrender.optics.cautions import beyond, cautions
from gemrender.optics.crystals.crystal import Crystal
from gemrender.optics.dispersion import INDEX_RANGE, VISIBLE_NM, Dispersion, Formula, index_of
from gemrender.optics.index_checks import check_index, visible_and
from gemrender.optics.principal import isotropic_absorption, ordinary, section_keys
from gemrender.optics.tabulated import WAVELENGTHS_NM, Table, finite, numbers_of

__all__ = [
    "DENSITY_RANGE",
    "DIAMETER_RANGE_MM",
    "INDEX_RANGE",
    "MOST_ABSORPTION",
    "SODIUM_NM",
    "VISIBLE_NM",
    "Material",
    "carat_to_girdle_diameter_mm",
    "checked_density",
    "checked_range",
    "constant_index",
]

#: Allowed range of a density [g/cm^3]: lighter than amber, heavier than every gem.
DENSITY_RANGE = (0.5, 25.0)
#: Highest absorption coefficient, that of metals [1/mm].
MOST_ABSORPTION = 1e6

#: Girdle diameters that stones may have [mm].
DIAMETER_RANGE_MM = (0.1, 1000.0)

#: Masses that a stone may have [carat]: from diamond dust of 0.1 mm to a boulder of 200 kg.
CARAT_RANGE = (1e-5, 1e6)
#: Mass of a carat [g].
_CARAT_G = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """A gem material.

    Parameters
    ----------
    name : str
        What to call it in tables and messages.
    dispersion : Formula or Table
        Index by wavelength; of a birefringent material the ordinary one, of a biaxial one the middle: what
        scores take, and pictures in which light is not split.
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
        table, their values hold. Of a pleochroic material what `principal.isotropic_absorption` makes of it.
    crystal : Crystal or None
        Of a birefringent material what each principal direction does; None is an isotropic one.

    Raises
    ------
    InputError
        A range without visible light, an index that leaves `INDEX_RANGE` anywhere, coefficients of the other
        of Sellmeier's forms, an absorption coefficient out of range, a density that no gem has, or a crystal
        of another index or absorption.
    """

    name: str
    dispersion: Dispersion
    range_nm: tuple[float, float]
    source: str = ""
    note: str = ""
    density: float | None = None
    absorption: Table | None = None
    crystal: Crystal | None = None

    @classmethod
    def of_crystal(cls, crystal: Crystal, *, absorption: Table | None = None, **facts: Any) -> Material:
        """Make a birefringent material.

        Parameters
        ----------
        crystal : Crystal
            What each principal direction does.
        absorption : Table, optional
            Absorption coefficient where it is the same in all directions [1/mm].
        **facts
            Other fields: name, range_nm and so on.

        Raises
        ------
        InputError
            As for the class.
        """
        if crystal.absorptions:
            absorption = isotropic_absorption(crystal)
        return cls(dispersion=ordinary(crystal), absorption=absorption, crystal=crystal, **facts)

    def __post_init__(self) -> None:
        object.__setattr__(self, "range_nm", checked_range(self.range_nm))
        object.__setattr__(self, "density", checked_density(self.density))
        with Mistakes() as mistakes:
            for key, dispersion in self.dispersions:
                mistakes.of(check_index, dispersion, self.range_nm, key)
            for key, absorption in self.absorptions:
                mistakes.of(_check_absorption, key, absorption)
        self._check_crystal()

    @property
    def dispersions(self) -> list[tuple[str, Dispersion]]:
        """The index of each principal direction, by the section of a material file that it is in."""
        if self.crystal is None:
            return [("index", self.dispersion)]
        return list(zip(section_keys(self.crystal, "index"), self.crystal.dispersions, strict=True))

    @property
    def absorptions(self) -> list[tuple[str, Table | None]]:
        """The absorption of each principal direction, or of all, by the section of a file that it is in."""
        if self.crystal is None or not self.crystal.absorptions:
            return [("absorption", self.absorption)]
        return list(zip(section_keys(self.crystal, "absorption"), self.crystal.absorptions, strict=True))

    def _check_crystal(self) -> None:
        crystal = self.crystal
        if crystal is None:
            return
        if self.dispersion != ordinary(crystal):
            raise InputError("must be the crystal's ordinary index, or its middle one", key="dispersion")
        if crystal.absorptions and self.absorption != isotropic_absorption(crystal):
            raise InputError("must be what the crystal's directions make", key="absorption")

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
        return visible_and(self.range_nm)

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
        return index_of(self.dispersion, asked)

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
    def abbe_number(self) -> float | None:
        """Abbe's number (n_D - 1) / (n_F - n_C), by the sodium line; None where n_F and n_C are equal."""
        return abbe_number(*index_of(self.dispersion, ABBE_LINES_NM))

    @property
    def continued_nm(self) -> tuple[tuple[float, float], ...]:
        """The stretches of visible light beyond `range_nm`, where the dispersion is continued [nm]."""
        return beyond(self.range_nm)

    @property
    def cautions(self) -> tuple[str, ...]:
        """What the numbers themselves give reason to say, each a line: what is continued, what no gem has."""
        return cautions(self)

    @property
    def notes(self) -> tuple[str, ...]:
        """What a user should know: the material's own note, if it has one, then its `cautions`."""
        return (*([self.note] if self.note else []), *self.cautions)

    @property
    def dispersion_b_g(self) -> float:
        """What gemmologists call dispersion: the index at 430.8 nm less that at 686.7 nm."""
        blue, red = self.index([FRAUNHOFER_G_NM, FRAUNHOFER_B_NM])
        return float(blue - red)


def _check_absorption(key: str, absorption: Table | None) -> None:
    for i, value in enumerate(absorption.values if absorption is not None else ()):
        if not 0 <= value <= MOST_ABSORPTION:
            least = "at least 0" if value < 0 else f"at most {MOST_ABSORPTION:g}"
            assert absorption is not None
            raise InputError(f"must be {least} [1/mm]", key=f"{key}.{absorption.key}[{i}]", value=value)


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
        A value that is not finite and above 0, a mass outside `CARAT_RANGE`, or a diameter outside
        `DIAMETER_RANGE_MM`.
    """
    for key, value in {"carat": carat, "volume": volume, "density": density}.items():
        if not finite(value) or value <= 0:
            raise InputError("must be a finite number above 0", key=key, value=value)
    low, high = CARAT_RANGE
    if not low <= carat <= high:
        raise InputError(f"must be from {low:g} to {high:g} [carat]", key="carat", value=carat)
    volume_mm3 = 1000.0 * _CARAT_G * carat / density
    diameter = float(2.0 * (volume_mm3 / volume) ** (1 / 3))
    low, high = DIAMETER_RANGE_MM
    if not low <= diameter <= high:
        allowed = f"must make a girdle of {low:g} to {high:g} mm; this makes {diameter:.3g} mm"
        raise InputError(allowed, key="carat", value=carat)
    return diameter


def checked_density(density: Any) -> float | None:
    """Return a density [g/cm^3] that a gem may have, None where it is not known.

    Raises
    ------
    InputError
        It is no number within `DENSITY_RANGE`.
    """
    if density is None:
        return None
    low, high = DENSITY_RANGE
    if not finite(density) or not low <= density <= high:
        raise InputError(f"must be a number from {low:g} to {high:g} g/cm3", key="density", value=density)
    return float(density)


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

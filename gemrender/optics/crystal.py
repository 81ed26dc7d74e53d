"""A crystal that splits light: its principal indices and absorption, by the wavelength."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.optics.dispersion import SODIUM_NM, Dispersion, index_of
from gemrender.optics.tabulated import Table

__all__ = ["BIAXIAL", "UNIAXIAL", "Crystal"]

#: Names of the principal directions, as keys of files end.
UNIAXIAL, BIAXIAL = ("o", "e"), ("alpha", "beta", "gamma")


@dataclass(frozen=True, slots=True, kw_only=True)
class Crystal:
    """What a crystal does to light along each of its principal directions.

    Parameters
    ----------
    dispersions : tuple of (Formula or Table)
        Of a uniaxial crystal the ordinary and the extraordinary index, of a biaxial one those of the axes
        alpha, beta and gamma: the least, the middle and the greatest one.
    absorptions : tuple of Table
        Absorption coefficient, to the base e [1/mm], of light whose field is along each of the same
        directions; empty where all absorb alike, as the material says.

    Raises
    ------
    InputError
        Another number of indices, or of absorption coefficients.
    """

    dispersions: tuple[Dispersion, ...]
    absorptions: tuple[Table, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "dispersions", tuple(self.dispersions))
        object.__setattr__(self, "absorptions", tuple(self.absorptions))
        if len(self.dispersions) not in (2, 3):
            raise InputError(
                "must be two (ordinary, extraordinary) or three (alpha, beta, gamma)",
                key="dispersions",
                value=len(self.dispersions),
            )
        if self.absorptions and len(self.absorptions) != len(self.dispersions):
            raise InputError(
                f"must be as many as dispersions, {len(self.dispersions)}, or none",
                key="absorptions",
                value=len(self.absorptions),
            )

    @property
    def is_biaxial(self) -> bool:
        """Whether it has two optic axes."""
        return len(self.dispersions) == 3

    @property
    def optic_class(self) -> str:
        """The word for it: "uniaxial" or "biaxial"."""
        return "biaxial" if self.is_biaxial else "uniaxial"

    @property
    def names(self) -> tuple[str, ...]:
        """What the principal directions are called: `UNIAXIAL` or `BIAXIAL`."""
        return BIAXIAL if self.is_biaxial else UNIAXIAL

    def keys(self, section: str) -> tuple[str, ...]:
        """Return what the sections of a file are called; those of the ordinary ray have no ending."""
        return tuple(section if name == "o" else f"{section}_{name}" for name in self.names)

    @property
    def ordinary(self) -> Dispersion:
        """What an isotropic material in its place has: the ordinary index, of a biaxial one the middle."""
        return self.dispersions[1 if self.is_biaxial else 0]

    @property
    def is_pleochroic(self) -> bool:
        """Whether its colour depends on the direction."""
        return any(table != self.absorptions[0] for table in self.absorptions)

    def isotropic_absorption(self) -> Table | None:
        """Return what an isotropic material in its place absorbs: as the ordinary ray, or the mean of three.

        Of a biaxial crystal no direction stands for the others.
        """
        if not self.is_biaxial:
            return self.absorptions[0] if self.absorptions else None
        if not self.absorptions:
            return None
        rows = sorted({nm for table in self.absorptions for nm in table.wavelength_nm})
        mean = np.mean([table.at(rows) for table in self.absorptions], axis=0)
        return Table(wavelength_nm=tuple(rows), values=tuple(mean.tolist()), key=self.absorptions[0].key)

    def index(self, wavelength_nm: Any) -> np.ndarray:
        """Return the principal indices at some wavelengths [nm]: (2, ...) or (3, ...)."""
        return np.stack([index_of(dispersion, wavelength_nm) for dispersion in self.dispersions])

    def along_axes(self, wavelength_nm: Any) -> np.ndarray:
        """Return the index along each axis of the optic frame, (3, ...): of a uniaxial crystal o, o, e.

        Parameters
        ----------
        wavelength_nm : array_like
            Wavelengths [nm].
        """
        return _along_axes(self.index(wavelength_nm))

    def absorption_along_axes(self, wavelength_nm: Any) -> np.ndarray:
        """Return the absorption coefficient along each axis of the optic frame [1/mm], (3, ...).

        Zeros where `absorption` is empty.
        """
        if not self.absorptions:
            return np.zeros((3, *np.shape(wavelength_nm)))
        return _along_axes(np.stack([table.at(wavelength_nm) for table in self.absorptions]))

    # ---- At the sodium line ----

    @property
    def birefringence(self) -> float:
        """The greatest index less the least one, at 589.3 nm."""
        return float(np.ptp(self.index(SODIUM_NM)))

    @property
    def optic_sign(self) -> str:
        """The sign at 589.3 nm: "+", "-", or "" where there is none.

        Positive is uniaxial with the greater extraordinary index, biaxial with the acute angle of the optic
        axes about gamma.
        """
        index = self.index(SODIUM_NM)
        if np.ptp(index) == 0.0:
            return ""
        if self.is_biaxial:
            return "+" if _about_gamma_deg(index) <= 90.0 else "-"
        return "+" if index[1] > index[0] else "-"

    @property
    def two_v_deg(self) -> float | None:
        """The acute angle between the optic axes at 589.3 nm [deg]; None of a uniaxial crystal."""
        if not self.is_biaxial:
            return None
        about_gamma = _about_gamma_deg(self.index(SODIUM_NM))
        return min(about_gamma, 180.0 - about_gamma)


def _along_axes(principal: np.ndarray) -> np.ndarray:
    return principal if len(principal) == 3 else principal[[0, 0, 1]]


def _about_gamma_deg(index: np.ndarray) -> float:
    """Return the angle of the optic axes about gamma [deg].

    Born & Wolf, Principles of Optics, 7th ed., section 15.3.1:
    tan^2 V = (1/a^2 - 1/b^2) / (1/b^2 - 1/c^2) for principal indices a, b, c.
    """
    a, b, c = np.sort(index).tolist()
    low, high = (b - a) * (b + a) * c**2, (c - b) * (c + b) * a**2
    return float(2 * np.degrees(np.arctan2(np.sqrt(low), np.sqrt(high))))

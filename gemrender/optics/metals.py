"""Metals of settings: complex refractive index by wavelength, as measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["METALS", "Metal"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Metal:
    """A metal by its complex index n + i k, linear in the wavelength between the rows.

    Attributes
    ----------
    name : str
        What it is called by.
    wavelength_nm : tuple of float
        Wavelengths, increasing [nm].
    n, k : tuple of float
        Real part and extinction coefficient, one for each wavelength.
    source : str
        Where the numbers come from.
    """

    name: str
    wavelength_nm: tuple[float, ...]
    n: tuple[float, ...]
    k: tuple[float, ...]
    source: str

    def reflectance(self, wavelength_nm: Any) -> np.ndarray:
        """Return the share of light that a smooth surface reflects at normal incidence.

        Born & Wolf, 7th ed., section 14.2, equation (8): |(n + ik - 1) / (n + ik + 1)|^2.
        """
        index = np.interp(wavelength_nm, self.wavelength_nm, self.n) + 1j * np.interp(
            wavelength_nm, self.wavelength_nm, self.k
        )
        return np.asarray(np.abs((index - 1) / (index + 1)) ** 2)


#: Where Johnson and Christy measured [nm]: photons of 3.50 to 1.51 eV.
_JOHNSON_CHRISTY_NM = (
    354.2, 367.9, 381.5, 397.4, 413.3, 430.5, 450.9, 471.4, 495.9, 520.9, 548.6, 579.4, 616.8, 659.5, 704.5,
    756.0, 821.1,
)  # fmt: skip
_JOHNSON_CHRISTY = "P. B. Johnson & R. W. Christy, Phys. Rev. B 6, 4370 (1972)"

_MADE = (
    Metal(
        name="gold",
        wavelength_nm=_JOHNSON_CHRISTY_NM,
        n=(
            1.50, 1.48, 1.46, 1.47, 1.46, 1.45, 1.38, 1.31, 1.04, 0.62, 0.43, 0.29, 0.21, 0.14, 0.13, 0.14,
            0.16,
        ),
        k=(
            1.866, 1.895, 1.933, 1.952, 1.958, 1.948, 1.914, 1.849, 1.833, 2.081, 2.455, 2.863, 3.272, 3.697,
            4.103, 4.542, 5.083,
        ),
        source=_JOHNSON_CHRISTY,
    ),
    Metal(
        name="silver",
        wavelength_nm=_JOHNSON_CHRISTY_NM,
        n=(
            0.10, 0.07, 0.05, 0.05, 0.05, 0.04, 0.04, 0.05, 0.05, 0.05, 0.06, 0.05, 0.06, 0.05, 0.04, 0.03,
            0.04,
        ),
        k=(
            1.419, 1.657, 1.864, 2.070, 2.275, 2.462, 2.657, 2.869, 3.093, 3.324, 3.586, 3.858, 4.152, 4.483,
            4.838, 5.242, 5.727,
        ),
        source=_JOHNSON_CHRISTY,
    ),
    Metal(
        name="platinum",
        wavelength_nm=tuple(range(360, 841, 40)),
        n=(1.615, 1.724, 1.827, 1.922, 2.017, 2.116, 2.224, 2.340, 2.463, 2.591, 2.721, 2.851, 2.978),
        k=(2.603, 2.853, 3.083, 3.308, 3.534, 3.760, 3.984, 4.201, 4.409, 4.606, 4.791, 4.966, 5.131),
        source=(
            "A. D. Rakic, A. B. Djurisic, J. M. Elazar & M. L. Majewski, Appl. Opt. 37, 5271 (1998): their "
            "Lorentz-Drude model of measured data"
        ),
    ),
)  # fmt: skip

#: The metals by their names.
METALS: dict[str, Metal] = {metal.name: metal for metal in _MADE}

"""Shapes of absorption by wavelength: bands, lines, a rise to the ultraviolet, and the table of their sum.

A crystal's bands are Gaussians in wavenumber (McClure, Solid State Physics 9, 399 (1959)), with two widths
where the band is lopsided; what lies in the ultraviolet reaches into the visible as an exponential in
wavenumber (Urbach, Phys. Rev. 92, 1324 (1953)).
"""

from __future__ import annotations

import numpy as np

from gemrender.optics.tabulated import Table

__all__ = ["absorption_table", "band", "line", "rise"]

#: Wavelengths of the rows [nm]. N3's line in diamond, 3 nm wide, is the narrowest thing there.
_WAVELENGTHS_NM = np.arange(360.0, 831.0)
_WAVENUMBERS = 1e7 / _WAVELENGTHS_NM


def absorption_table(per_mm: np.ndarray) -> Table:
    """Return the table of an absorption coefficient on the rows of this module [1/mm]."""
    return Table(wavelength_nm=tuple(_WAVELENGTHS_NM.tolist()), values=tuple(per_mm.tolist()), key="per_mm")


def band(centre: float, peak: float, *, below: float, above: float) -> np.ndarray:
    """Return a band: centre and full widths at half height, below and above the centre [1/cm]."""
    width = np.where(centre > _WAVENUMBERS, below, above)
    return np.asarray(peak * np.exp(-4 * np.log(2) * ((_WAVENUMBERS - centre) / width) ** 2))


def line(centre_nm: float, peak: float, width_nm: float) -> np.ndarray:
    """Return a narrow band: centre and full width at half height [nm]."""
    width = width_nm * 1e7 / centre_nm**2
    return band(1e7 / centre_nm, peak, below=width, above=width)


def rise(at_nm: float, there: float, width: float) -> np.ndarray:
    """Return a rise to the ultraviolet: its value at a wavelength [nm], its width to grow e-fold [1/cm]."""
    return np.asarray(there * np.exp((_WAVENUMBERS - 1e7 / at_nm) / width))

"""Tables over the wavelength in kernels, and the wavelengths of paths in RGB variants."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi

__all__ = [
    "FIRST_NM",
    "LAST_NM",
    "N_ROWS",
    "mean_of",
    "parting_colour",
    "row_of",
    "tabulated",
    "unpolarised",
]

#: Where materials are tabulated [nm]: Mitsuba's range of wavelengths, in steps of 1 nm. Diamond's index
#: between two rows is linear to 2e-7.
FIRST_NM, LAST_NM = 360, 830
N_ROWS = LAST_NM - FIRST_NM + 1


def unpolarised(value: mi.Spectrum) -> mi.UnpolarizedSpectrum:
    """Return what is left of unpolarised light, of a Mueller matrix: in other variants all."""
    return mi.unpolarized_spectrum(value) if mi.is_polarized else value


def mean_of(spectrum: mi.UnpolarizedSpectrum) -> mi.Float:
    """Return the mean over the channels.

    `dr.mean` writes the number of lanes into the kernel: pictures of each size would have their own.
    """
    return dr.sum(spectrum) * (1 / dr.size_v(spectrum))


def row_of(nm: mi.Float) -> mi.Float:
    """Return the place of wavelengths [nm] in a table, in rows."""
    return dr.clip(nm - FIRST_NM, 0, N_ROWS - 1)


def tabulated(table: mi.Float, start: mi.UInt32, row: mi.Float, active: mi.Bool) -> mi.Float:
    """Interpolate linearly between the rows of a table that begins at `start`."""
    below = mi.UInt32(dr.minimum(row, N_ROWS - 2))
    a, b = (dr.gather(mi.Float, table, start + below + k, active) for k in (0, 1))
    return dr.fma(row - mi.Float(below), b - a, a)


def parting_colour(sample: mi.Float) -> tuple[mi.Float, mi.Color3f]:
    """Draw the wavelength of a path [nm], and what linear sRGB channels it counts in.

    The wavelength's density follows Mitsuba's sampling for RGB; the weights have mean 1 in each channel, so
    that white stays white.
    """
    nm, weight = mi.sample_rgb_spectrum(sample)
    return nm, mi.linear_rgb_rec(nm) * weight / _rgb_of_white()


def _rgb_of_white() -> mi.Color3f:
    """Integrals of the response of the linear sRGB channels over the wavelength [nm]."""
    nm = dr.linspace(mi.Float, FIRST_NM, LAST_NM, 10 * N_ROWS)
    response = mi.linear_rgb_rec(nm)
    return mi.Color3f([dr.opaque(mi.Float, dr.mean(c)[0] * (LAST_NM - FIRST_NM)) for c in response])

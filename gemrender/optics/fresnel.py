"""Transmittance of an optically smooth surface: Fresnel's equations, and Gübelin's table for diamond."""

from __future__ import annotations

import numpy as np

__all__ = [
    "CRITICAL_TOLERANCE",
    "FRESNEL_LAWS",
    "GUBELIN_ANGLES_DEG",
    "GUBELIN_INDEX",
    "GUBELIN_REFLECTED",
    "LEAST_TOTAL",
    "brewster_angle_deg",
    "critical_angle_deg",
    "is_totally_reflected",
    "reflectance",
    "reflectance_polarised",
    "transmittance",
    "transmittance_gubelin",
]

#: Names of the two transmittance laws, as on the command line.
FRESNEL_LAWS = ("gubelin", "exact")

#: Refractive index of diamond that the paper uses, and that Gübelin's table holds for.
GUBELIN_INDEX = 2.4173

#: Gübelin's table (the paper's table 1): angle of incidence in air [deg] and reflected share. Below 1 deg
#: the first value, above 80 deg linear to 1 at 90 deg (`docs/model.md`, section 5).
GUBELIN_ANGLES_DEG = np.array([0.0, 1.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 67.31, 70.0, 80.0, 90.0])
GUBELIN_REFLECTED = (
    np.array([16.99, 16.99, 17.23, 17.36, 17.36, 17.77, 18.73, 21.12, 24.85, 27.21, 43.33, 100.0]) / 100
)
GUBELIN_ANGLES_DEG.setflags(write=False)
GUBELIN_REFLECTED.setflags(write=False)


#: Light is totally reflected where n sin(theta) is 1 or at most so much less. Facets that stand at the
#: critical angle itself are met a few roundings (1e-15) to either side of it, after hundreds of reflections
#: some 1e-13: all tracers, in whichever order they add, must take them for one side. In angle, 1e-9 degrees.
CRITICAL_TOLERANCE = 1e-11
#: The same as what tracers compute: n^2 sin^2(theta) from which on all light is reflected.
LEAST_TOTAL = (1.0 - CRITICAL_TOLERANCE) ** 2


def critical_angle_deg(index: float) -> float:
    """Return the critical angle of total reflection, asin(1/n) [deg]."""
    return float(np.degrees(np.arcsin(1.0 / index)))


def is_totally_reflected(cos_stone: np.ndarray, index: float) -> np.ndarray:
    """Whether all light is reflected, by the cosine of the angle inside: sin(theta) >= 1/n within rounding.

    The one rule of all tracers (`CRITICAL_TOLERANCE`); the compiled ones, Mitsuba's and the page's take
    `LEAST_TOTAL` for it.
    """
    return np.asarray(index**2 * (1.0 - np.square(cos_stone)) >= LEAST_TOTAL)


def brewster_angle_deg(index: float) -> float:
    """Return the angle of incidence in air without p-polarised reflection, atan(n) [deg]."""
    return float(np.degrees(np.arctan(index)))


def reflectance_polarised(cos_air: np.ndarray, index: float) -> tuple[np.ndarray, np.ndarray]:
    """Return Fresnel's reflectances for s- and p-polarised light.

    Born & Wolf, Principles of Optics, 7th ed., section 1.5.2, equations (21a).

    Parameters
    ----------
    cos_air : array_like
        Cosine of the angle of incidence on the air's side, 0 to 1; complex for complex steps.
    index : float
        Refractive index of the stone relative to air, at least 1.

    Returns
    -------
    (R_s, R_p) : arrays like `cos_air`
        Reflected share of the power; the same from either side of the surface.
    """
    cos_a = np.asarray(cos_air)
    cos_b = np.sqrt(1.0 - (1.0 - cos_a**2) / index**2)
    r_s = (cos_a - index * cos_b) / (cos_a + index * cos_b)
    r_p = (index * cos_a - cos_b) / (index * cos_a + cos_b)
    return r_s**2, r_p**2


def reflectance(cos_air: np.ndarray, index: float) -> np.ndarray:
    """Return the reflectance for unpolarised light: the mean of both polarisations."""
    r_s, r_p = reflectance_polarised(cos_air, index)
    return np.asarray(0.5 * (r_s + r_p))


def transmittance_gubelin(cos_air: np.ndarray) -> np.ndarray:
    """Return the transmitted share by Gübelin's table, linear in the angle between its rows.

    Holds for diamond at the sodium D line only (n = 2.4173).

    Parameters
    ----------
    cos_air : array_like
        Cosine of the angle of incidence on the air's side, 0 to 1; where it is complex its imaginary part is
        a derivative, and so is the result's.
    """
    cos = np.minimum(np.maximum(np.real(cos_air), 0.0), 1.0)
    angle_deg = np.degrees(np.arccos(cos))
    reflected = np.interp(angle_deg, GUBELIN_ANGLES_DEG, GUBELIN_REFLECTED)
    if not np.iscomplexobj(cos_air):
        return np.asarray(1.0 - reflected)
    # The imaginary part is a derivative: by the angle, the slope between two rows.
    row = np.clip(np.searchsorted(GUBELIN_ANGLES_DEG, angle_deg), 1, len(GUBELIN_ANGLES_DEG) - 1)
    slope = (np.diff(GUBELIN_REFLECTED) / np.diff(GUBELIN_ANGLES_DEG))[row - 1]
    sin = np.sqrt(1.0 - cos**2)
    by_cos = np.degrees(slope / np.where(sin > 0.0, sin, np.inf))
    return np.asarray(1.0 - reflected + 1j * by_cos * np.imag(cos_air))


def transmittance(cos_air: np.ndarray, index: float, law: str = "exact") -> np.ndarray:
    """Return the transmitted share T = 1 - R by the law "exact" (Fresnel) or "gubelin" (the table)."""
    if law == "gubelin":
        return transmittance_gubelin(cos_air)
    return 1.0 - reflectance(cos_air, index)

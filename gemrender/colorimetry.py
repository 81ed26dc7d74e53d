"""Colorimetry of photoreal pictures: from spectra to CIE XYZ, and from there to linear sRGB.

One convention throughout: a light's spectrum is scaled so that its luminance is that of an equal-energy
spectrum of radiance 1, and XYZ is divided by the integral of ybar. So a picture of the light itself has
Y = 1, whatever the light's colour.
"""

from __future__ import annotations

import importlib
import re
import sys
import warnings
from functools import lru_cache
from types import ModuleType
from typing import Any

import numpy as np

from gemrender.errors import InputError

__all__ = [
    "ADAPTATION",
    "KELVIN_RANGE",
    "VISIBLE_NM",
    "adapt",
    "adaptation_matrix",
    "check_image",
    "colour_matching",
    "colour_science",
    "colour_spectrum",
    "colour_xyz",
    "illuminant_names",
    "illuminant_spectrum",
    "luminance_weights",
    "matrix_to_linear_srgb",
    "white_xyz",
    "xyz_to_linear_srgb",
    "y_integral_nm",
]

#: Cone space of the chromatic adaptation, by colour-science's name: Hunt, Pointer and Estevez's. Bradford and
#: CAT02 predict surface colours better, but change the luminance of spectral colours, which fire is made of:
#: from illuminant A at 430 nm 13 and 17 times, under 10000 K they make violet negative. This one keeps it
#: within a few per cent, and white is white in any of them.
ADAPTATION = "Von Kries"

#: Visible light, which pictures are made of [nm].
VISIBLE_NM = (380.0, 760.0)

#: Allowed temperatures of a blackbody [K].
KELVIN_RANGE = (1000.0, 25000.0)

#: Second radiation constant, hc/k [nm K] (CODATA 2018).
_C2_NM_K = 1.438776877e7

_OBSERVER = "CIE 1931 2 Degree Standard Observer"


# ---- Spectra -------------------------------------------------------------------------------------------


def colour_matching(wavelength_nm: Any) -> np.ndarray:
    """Return xbar, ybar and zbar of the CIE 1931 2 degree observer (..., 3).

    Linear between the rows of the 1 nm table (CIE 018:2019, 360 to 830 nm), 0 outside.

    Parameters
    ----------
    wavelength_nm : array_like (...)
        Wavelengths in vacuum [nm].

    Raises
    ------
    InputError
        A wavelength that is not a positive, finite number.
    """
    wavelengths = _wavelengths(wavelength_nm)
    rows, bars = _observer()
    return np.stack([np.interp(wavelengths, rows, bar, left=0, right=0) for bar in bars.T], axis=-1)


def y_integral_nm() -> float:
    """Return the integral of ybar [nm], 106.857: what XYZ is divided by here."""
    return float(_observer()[1][:, 1].sum())


def illuminant_names() -> list[str]:
    """Return the names of the tabulated lights: CIE's, lower case, its FL1 being f1."""
    return list(_illuminants())


def illuminant_spectrum(name_or_kelvin: str | float, wavelength_nm: Any) -> np.ndarray:
    """Return a light's relative spectral power (...), scaled to the luminance of radiance 1.

    The scale is such that the sum of ybar S over the rows of the 1 nm table is that of ybar alone. Tables
    (5 nm) are linear between their rows and 0 outside, as CIE 15:2018 has it for D65; e is 1 everywhere.
    A blackbody follows Planck's law.

    Parameters
    ----------
    name_or_kelvin : str or float
        A name of `illuminant_names` (case does not count; fl2 is f2), or a temperature [K], as a number or
        as text ("5500", "5500 K").
    wavelength_nm : array_like (...)
        Wavelengths in vacuum [nm].

    Raises
    ------
    InputError
        Unknown light, a temperature outside `KELVIN_RANGE`, or a bad wavelength.
    """
    light = _light(name_or_kelvin)
    return _relative(light, _wavelengths(wavelength_nm)) * _scale(light)


def white_xyz(name_or_kelvin: str | float) -> np.ndarray:
    """Return X, Y and Z of a light (3,), with Y = 1.

    Raises
    ------
    InputError
        As `illuminant_spectrum`.
    """
    rows, bars = _observer()
    xyz = illuminant_spectrum(name_or_kelvin, rows) @ bars
    return np.asarray(xyz / xyz[1])


def colour_xyz(rgb: Any) -> np.ndarray:
    """Return X, Y and Z of a colour (3,) that comes out as `rgb` where white is D65.

    Parameters
    ----------
    rgb : array_like (3,)
        Linear sRGB.
    """
    return np.asarray(np.linalg.solve(_xyz_to_rgb(), np.asarray(rgb, dtype=np.float64)))


def colour_spectrum(rgb: Any, wavelength_nm: Any) -> np.ndarray:
    """Return the smoothest positive spectrum of a colour (...), such that a picture of it is `rgb` exactly.

    Of all that are positive it is the one whose logarithm has the least sum of squared steps from one row of
    a 5 nm table to the next, after Burns, "Numerical methods for smoothest reflectance reconstruction",
    Color Research and Application 45 (2020), method LHTSS (but unbounded above, as lights are). Mitsuba's
    upsampling of emissions is close to a colour only, and the light of a red lamp would count as green too.

    Parameters
    ----------
    rgb : array_like (3,)
        Linear sRGB where white is D65, at least 0 and not all 0.
    wavelength_nm : array_like (...)
        Wavelengths in vacuum [nm]; linear between rows, and 0 outside `VISIBLE_NM`.

    Raises
    ------
    InputError
        No such colour, or a bad wavelength.
    """
    colour = np.asarray(rgb, dtype=np.float64)
    if colour.shape != (3,) or not np.all(np.isfinite(colour) & (colour >= 0)) or not colour.any():
        raise InputError("must be three numbers of at least 0, not all 0", key="colour", value=rgb)
    wavelengths, most = _wavelengths(wavelength_nm), float(colour.max())
    table = _smoothest(tuple(float(x) for x in colour / most))
    return np.asarray(most * np.interp(wavelengths, _ROWS_NM, table, left=0, right=0))


#: Rows of the spectra of colours [nm].
_ROWS_NM = np.arange(VISIBLE_NM[0], VISIBLE_NM[1] + 1, 5.0)
#: How far from its colour a spectrum may be, and Newton steps until then: ten are usual.
_COLOUR_ERROR, _NEWTON_STEPS = 1e-10, 200


@lru_cache(maxsize=64)
def _smoothest(rgb: tuple[float, float, float]) -> np.ndarray:
    """Return the rows of the smoothest positive spectrum of a colour."""
    # Simpson's rule by 1 nm: exact for products of two tables that are linear in between, as of a picture
    grid = np.arange(2 * VISIBLE_NM[0], 2 * VISIBLE_NM[1] + 1) / 2.0
    weights = np.full(len(grid), 2.0 / 6.0)
    weights[1::2], weights[[0, -1]] = 4.0 / 6.0, 1.0 / 6.0
    hats = np.stack([np.interp(grid, _ROWS_NM, one) for one in np.eye(len(_ROWS_NM))], axis=1)
    response = _xyz_to_rgb() @ (colour_matching(grid) * weights[:, None]).T @ hats / y_integral_nm()
    steps = np.diff(np.eye(len(_ROWS_NM)), axis=0)
    slope = steps.T @ steps
    # Newton's method on the Lagrangian: unknown are the logarithms of the rows, and three multipliers
    log, multipliers = np.zeros(len(_ROWS_NM)), np.zeros(3)
    for _ in range(_NEWTON_STEPS):
        gradient = response * np.exp(log)
        missing = np.asarray(rgb) - gradient.sum(axis=1)
        if np.abs(missing).max() < _COLOUR_ERROR:
            break
        curved = slope + np.diag(gradient.T @ multipliers)
        matrix = np.block([[curved, gradient.T], [gradient, np.zeros((3, 3))]])
        step = np.linalg.solve(matrix, np.concatenate([-slope @ log - gradient.T @ multipliers, missing]))
        damped = min(1.0, 2.0 / float(np.abs(step[: len(log)]).max()))
        log += damped * step[: len(log)]
        multipliers += damped * step[len(log) :]
    else:
        raise InputError("must be a colour that light can have", key="colour", value=list(rgb))
    return np.exp(log)


def _xyz_to_rgb() -> np.ndarray:
    """Return the matrix (3, 3) from XYZ to the linear sRGB of a picture whose white is D65."""
    return np.asarray(matrix_to_linear_srgb() @ adaptation_matrix(white_xyz("d65")))


class _Plotting(ModuleType):
    """Stands for `colour.plotting` until somebody uses it: Matplotlib takes nearly half of the import."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(importlib.import_module(self.__name__), name)


@lru_cache(maxsize=1)
def colour_science() -> Any:
    """Return the module of colour-science, imported without its plotting.

    It warns of what it cannot do without SciPy: nothing that is needed here.
    """
    plotting = "colour.plotting"
    stand_in = sys.modules.setdefault(plotting, _Plotting(plotting))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import colour
    finally:
        if sys.modules.get(plotting) is stand_in and isinstance(stand_in, _Plotting):
            del sys.modules[plotting]  # who imports it has the whole of it
    return colour


def _wavelengths(wavelength_nm: Any) -> np.ndarray:
    wavelengths = np.asarray(wavelength_nm, dtype=np.float64)
    if not np.all(np.isfinite(wavelengths) & (wavelengths > 0)):
        raise InputError("must be finite and above 0 [nm]", key="wavelength", value=wavelength_nm)
    return wavelengths


@lru_cache(maxsize=1)
def _observer() -> tuple[np.ndarray, np.ndarray]:
    """Return wavelengths [nm] (n,) and the three bars (n, 3) of the table, 1 nm apart."""
    table = colour_science().MSDS_CMFS[_OBSERVER]
    rows, bars = np.array(table.wavelengths, dtype=np.float64), np.array(table.values, dtype=np.float64)
    rows.setflags(write=False)
    bars.setflags(write=False)
    return rows, bars


@lru_cache(maxsize=1)
def _illuminants() -> dict[str, str]:
    """Return colour-science's name of each light, without ISO 7589, whose tables end at 690 nm."""
    names = (name for name in colour_science().SDS_ILLUMINANTS if not name.startswith("ISO"))
    return {re.sub(r"^fl(?=\d)", "f", name.lower()): name for name in names}


def _light(name_or_kelvin: str | float) -> str | float:
    """Return a light as a name of `_illuminants`, or as a temperature [K]."""
    low, high = KELVIN_RANGE
    light: Any = name_or_kelvin
    if isinstance(light, str):
        plain = re.sub(r"^fl(?=\d)", "f", light.strip().lower())
        if plain in _illuminants():
            return plain
        try:
            light = float(re.sub(r"\s*k$", "", plain))
        except ValueError:
            light = None
    known = isinstance(light, (int, float, np.integer, np.floating)) and not isinstance(light, bool)
    if not known or not low <= light <= high:
        allowed = f"must be {low:g} to {high:g} [K] or one of {', '.join(illuminant_names())}"
        raise InputError(allowed, key="spectrum", value=name_or_kelvin)
    return float(light)


def _relative(light: str | float, wavelengths: np.ndarray) -> np.ndarray:
    if isinstance(light, float):
        with np.errstate(over="ignore"):  # infinite far in the ultraviolet, where the spectrum is 0
            ratio = np.expm1(_C2_NM_K / (560.0 * light)) / np.expm1(_C2_NM_K / (wavelengths * light))
            return np.asarray(ratio * (560.0 / wavelengths) ** 5)
    if light == "e":
        return np.ones_like(wavelengths)
    table = colour_science().SDS_ILLUMINANTS[_illuminants()[light]]
    return np.asarray(np.interp(wavelengths, table.wavelengths, table.values, left=0, right=0))


@lru_cache(maxsize=64)
def _scale(light: str | float) -> float:
    rows, bars = _observer()
    return y_integral_nm() / float(_relative(light, rows) @ bars[:, 1])


# ---- Tristimulus values --------------------------------------------------------------------------------


def adaptation_matrix(white: Any) -> np.ndarray:
    """Return the matrix (3, 3) that turns XYZ under a white into XYZ under D65.

    Linear von Kries scaling in the cone space `ADAPTATION`, with complete adaptation: what white light
    leaves as it is comes out as sRGB's white exactly.

    Parameters
    ----------
    white : array_like (3,)
        XYZ of the scene's white, of any luminance; only its colour counts.

    Raises
    ------
    InputError
        A white that no light has.
    """
    adaptation = colour_science().adaptation

    xyz = np.asarray(white, dtype=np.float64)
    if xyz.shape != (3,) or not np.all(np.isfinite(xyz)) or not xyz[0] > 0 < xyz[1] or xyz[2] < 0:
        raise InputError("must be X, Y, Z of a light, X and Y above 0", key="white", value=white)
    matrix = adaptation.matrix_chromatic_adaptation_VonKries(xyz / xyz[1], _srgb()[0], transform=ADAPTATION)
    return np.asarray(matrix, dtype=np.float64)


def matrix_to_linear_srgb() -> np.ndarray:
    """Return the matrix (3, 3) from XYZ (D65, Y of white = 1) to linear sRGB.

    Derived from the primaries and the white point of IEC 61966-2-1, not its rounded printed matrix: white
    is (1, 1, 1) exactly, and there and back is where one was.
    """
    return np.array(np.linalg.inv(_srgb()[1]))


def luminance_weights() -> np.ndarray:
    """Return the luminances of sRGB's red, green and blue (3,), which add up to 1."""
    return np.array(_srgb()[1][1])


def adapt(xyz: Any, white_xyz: Any) -> np.ndarray:
    """Return XYZ (..., 3) adapted from the scene's white to D65; float32 stays float32.

    Parameters
    ----------
    xyz : array_like (..., 3)
        Colours under the scene's light.
    white_xyz : array_like (3,)
        XYZ of the scene's white.

    Raises
    ------
    InputError
        Not three values a pixel, or a white that no light has.
    """
    return _transformed(xyz, adaptation_matrix(white_xyz))


def xyz_to_linear_srgb(xyz: Any) -> np.ndarray:
    """Return linear sRGB (..., 3) of XYZ under D65, unclipped: colours outside sRGB have values below 0.

    Raises
    ------
    InputError
        Not three values a pixel.
    """
    return _transformed(xyz, matrix_to_linear_srgb())


def check_image(image: Any, key: str) -> np.ndarray:
    """Return an array (..., 3) of floats, float32 as it is and all else as float64.

    Raises
    ------
    InputError
        It is of another shape, or no numbers.
    """
    array = np.asarray(image)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise InputError("must be an array (..., 3)", key=f"{key}.shape", value=array.shape)
    if array.dtype.kind not in "iuf":
        raise InputError("must be an array of real numbers", key=f"{key}.dtype", value=str(array.dtype))
    return array if array.dtype == np.float32 else array.astype(np.float64, copy=False)


def _transformed(xyz: Any, matrix: np.ndarray) -> np.ndarray:
    array = check_image(xyz, "xyz")
    # One product of (n, 3) by (3, 3); numpy would take (h, w, 3) row by row of the image.
    product = array.reshape(-1, 3) @ matrix.T.astype(array.dtype)
    return np.asarray(product.reshape(array.shape))


@lru_cache(maxsize=1)
def _srgb() -> tuple[np.ndarray, np.ndarray]:
    """Return sRGB's white XYZ (3,), Y = 1, and its matrix (3, 3) from linear sRGB to XYZ."""
    space = colour_science().RGB_COLOURSPACES["sRGB"]
    x, y = (float(value) for value in space.whitepoint)
    white = np.array([x / y, 1.0, (1 - x - y) / y])
    matrix = np.array(
        colour_science().normalised_primary_matrix(space.primaries, space.whitepoint), dtype=np.float64
    )
    white.setflags(write=False)
    matrix.setflags(write=False)
    return white, matrix

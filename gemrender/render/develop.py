"""From XYZ to a picture for the screen: exposure, curve, gamut and sRGB encoding.

What is done to a pixel, in order: adapt the scene's white to D65, go to linear sRGB, expose, bend by the
curve (see `curves`), mix with grey into the gamut, encode. Each step but the curve `agx` keeps the hue in the
sense of linear sRGB: a pixel only ever moves in the plane of its colour and grey.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.colorimetry import (
    adaptation_matrix,
    check_image,
    luminance_weights,
    matrix_to_linear_srgb,
)
from gemrender.errors import InputError
from gemrender.render.curves import CURVES, MID_GREY, apply_curve, filmic_gain

__all__ = [
    "CURVES",
    "EV_LIMIT",
    "EXPOSURE_RANGE",
    "MID_GREY",
    "auto_exposure",
    "decode_srgb",
    "develop",
    "encode_srgb",
    "filmic_gain",
    "fit_gamut",
]

#: Largest correction of the exposure [EV], either way.
EV_LIMIT = 20.0

#: Allowed factors of an exposure: of any radiance that a set-up may have, with any correction.
EXPOSURE_RANGE = (1e-40, 1e40)

#: Share of the covered pixels that stay below `EXPOSED_TO` by the automatic exposure [%]. Fireflies are a
#: few in a thousand; the sparkles of a stone may be more than one in a hundred, and shall blow out.
EXPOSED_PERCENTILE = 98.0

#: Luminance that the automatic exposure brings that percentile to.
EXPOSED_TO = 0.9

#: Pixels developed at a time: a few MB, so that a large picture needs little more than itself.
_BLOCK_PIXELS = 1 << 17


def auto_exposure(luminance: Any, mask: Any = None, *, ev: float = 0.0) -> float:
    """Return the factor of the exposure: `EXPOSED_TO` over a high percentile of the luminance, times 2^ev.

    A percentile, not the mean or the largest value: neither fireflies nor the size of the black background
    count. Pixels that are not finite are left out. A black picture gets 2^ev.

    Parameters
    ----------
    luminance : array_like (h, w)
        Y of each pixel, 1 being that of the light.
    mask : array_like (h, w) of bool, optional
        Pixels that count, the stone's; by default all that are not black.
    ev : float
        Correction by the user [EV]: 1 doubles the exposure.

    Raises
    ------
    InputError
        A correction beyond `EV_LIMIT`, or a mask of another shape.
    """
    _check_number(ev, "ev", -EV_LIMIT, EV_LIMIT, f"must be a number from {-EV_LIMIT:g} to {EV_LIMIT:g} [EV]")
    values = np.asarray(luminance)
    counted = values > 0 if mask is None else np.asarray(mask, dtype=bool)
    if counted.shape != values.shape:
        allowed = f"must be of the luminance's shape, {values.shape}"
        raise InputError(allowed, key="mask.shape", value=counted.shape)
    values = values[counted & np.isfinite(values)]
    level = float(np.percentile(values, EXPOSED_PERCENTILE)) if values.size else 0.0
    if level <= 0 and mask is not None:  # a stone that is black nearly all over
        return auto_exposure(np.where(counted, luminance, 0), ev=ev)
    return float(2.0**ev * (EXPOSED_TO / level if level > 0 else 1.0))


def fit_gamut(rgb: Any) -> np.ndarray:
    """Return linear sRGB (..., 3) within 0 to 1, by mixing with the grey of the same luminance.

    The share of grey is the least that brings the smallest component up to 0 and the largest down to 1, so
    hue and luminance stay, and saturation is what is lost. A luminance of 1 or more becomes white, one of
    0 or less black.

    Parameters
    ----------
    rgb : array_like (..., 3)
        Linear sRGB, unclipped.

    Raises
    ------
    InputError
        Not three values a pixel.
    """
    colours = check_image(rgb, "rgb")
    weights = luminance_weights().astype(colours.dtype)
    grey = np.clip((colours.reshape(-1, 3) @ weights).reshape(colours.shape[:-1]), 0, 1)
    low, high = colours.min(axis=-1), colours.max(axis=-1)
    kept = np.ones_like(grey)
    np.divide(grey, grey - low, out=kept, where=low < 0)
    room = np.ones_like(grey)
    np.divide(1 - grey, high - grey, out=room, where=high > 1)
    kept = np.minimum(kept, room)[..., None]
    # Mixed as two products: the colours of fireflies are too large to take a difference of.
    fitted = kept * colours + (1 - kept) * grey[..., None]
    return np.asarray(np.clip(fitted, 0, 1, out=fitted))


def encode_srgb(linear: Any) -> np.ndarray:
    """Return linear values (...), cut to 0 to 1, encoded for the screen (IEC 61966-2-1)."""
    values = np.clip(linear, 0, 1)
    return np.asarray(np.where(values <= 0.0031308, 12.92 * values, 1.055 * values ** (1 / 2.4) - 0.055))


def decode_srgb(encoded: Any) -> np.ndarray:
    """Return the linear values (...) of encoded ones, cut to 0 to 1: the inverse of `encode_srgb`."""
    values = np.clip(encoded, 0, 1)
    return np.asarray(np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4))


def develop(xyz: Any, *, white_xyz: Any, exposure: float, curve: str = "filmic") -> np.ndarray:
    """Return the picture for the screen (h, w, 3), uint8, sRGB.

    Parameters
    ----------
    xyz : array_like (h, w, 3)
        XYZ of the scene. A pixel that is not finite comes out black.
    white_xyz : array_like (3,)
        XYZ of the scene's white; it becomes the screen's.
    exposure : float
        Factor on XYZ, as of `auto_exposure`.
    curve : str
        A name of `CURVES`.

    Raises
    ------
    InputError
        Not (h, w, 3), a white that no light has, an exposure outside `EXPOSURE_RANGE`, or an unknown curve.
    """
    image = check_image(xyz, "xyz")
    if image.ndim != 3:
        raise InputError("must be an array (h, w, 3)", key="xyz.shape", value=image.shape)
    if curve not in CURVES:
        raise InputError(f"must be one of {', '.join(CURVES)}", key="curve", value=curve)
    low, high = EXPOSURE_RANGE
    _check_number(exposure, "exposure", low, high, f"must be a number from {low:g} to {high:g}")
    matrix = exposure * matrix_to_linear_srgb() @ adaptation_matrix(white_xyz)
    pixels = image.reshape(-1, 3)
    developed = np.empty(pixels.shape, dtype=np.uint8)
    for start in range(0, len(pixels), _BLOCK_PIXELS):
        block = pixels[start : start + _BLOCK_PIXELS].astype(np.float64)
        block[~np.isfinite(block).all(axis=-1)] = 0
        rgb = apply_curve(curve, block @ matrix.T)
        developed[start : start + _BLOCK_PIXELS] = np.rint(255 * encode_srgb(fit_gamut(rgb)))
    return developed.reshape(image.shape)


def _check_number(value: Any, key: str, low: float, high: float, allowed: str) -> None:
    number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    if not number or not low <= value <= high:
        raise InputError(allowed, key=key, value=value)

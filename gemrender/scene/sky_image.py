"""Skies that are images: read from a file, turned, and handed to Mitsuba."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.scene.bitmaps import read_bitmap

__all__ = ["IMAGE_SUFFIXES", "MOST_COLUMNS", "environment", "read_sky_image"]

#: Endings of the files that are read: OpenEXR, and Radiance's RGBE.
IMAGE_SUFFIXES = (".exr", ".hdr")
#: Widest image that is read, and that is kept [pixels]: what is wider is averaged down, to 0.09 degrees or
#: more a pixel. Mitsuba needs some 24 bytes for each.
MOST_COLUMNS, KEPT_COLUMNS = 16384, 4096
#: What a pixel's white is multiplied by in spectral variants: Mitsuba's D65 of 1 is by so much less than a
#: light of luminance 1.
_WHITE = 1.00109


def read_sky_image(path: str) -> np.ndarray:
    """Return the pixels of an equirectangular image, (h, 2 h, 3) float32, linear sRGB.

    Its left and right edges meet, its top row is the zenith. Negative values count as 0.

    Parameters
    ----------
    path : str
        An OpenEXR file with channels R, G and B, or a Radiance file (.hdr).

    Raises
    ------
    InputError
        No such file, no image, another shape, values that are not finite, or all black.
    """
    file = Path(path)
    try:
        with file.open("rb"):
            pass
    except (OSError, ValueError) as error:
        told = getattr(error, "strerror", None) or "no such file"
        raise InputError(f"cannot be read: {told}", key="sky.image", value=path) from error
    if file.suffix.lower() not in IMAGE_SUFFIXES:
        raise InputError(f"must end in {' or '.join(IMAGE_SUFFIXES)}", key="sky.image", value=path)
    try:
        pixels = _read(path)
    except InputError:
        raise
    except Exception as error:  # Mitsuba raises what its libraries do
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"is no image that can be read: {reason}", key="sky.image", value=path) from error
    height, width = pixels.shape[:2]
    if width != 2 * height or not 8 <= width <= MOST_COLUMNS:
        allowed = f"must be twice as wide as high, 8 to {MOST_COLUMNS} pixels: all around by zenith to nadir"
        raise InputError(allowed, key="sky.image", value=f"{path} ({width} x {height})")
    if not np.isfinite(pixels).all():
        raise InputError("must hold finite values only", key="sky.image", value=path)
    pixels = np.maximum(pixels, 0)
    if not pixels.any():
        raise InputError("must not be black all over", key="sky.image", value=path)
    return _smaller(pixels)


def _read(path: str) -> np.ndarray:
    bitmap = read_bitmap(path)
    names = [field.name for field in bitmap.struct_()]
    if missing := [name for name in "RGB" if name not in names]:
        raise InputError(f"has no channel {', '.join(missing)}", key="sky.image", value=path)
    values = np.array(bitmap)
    return np.stack([values[..., names.index(name)] for name in "RGB"], axis=2).astype(np.float32)


def _smaller(pixels: np.ndarray) -> np.ndarray:
    """Halve an image until it is at most `KEPT_COLUMNS` wide, by means of four pixels: all light is kept."""
    while pixels.shape[1] > KEPT_COLUMNS:
        height, width, _ = pixels.shape
        odd = height % 2  # a row more, where there is an odd one
        pixels = np.concatenate([pixels, pixels[-1:]]) if odd else pixels
        rows = 0.5 * (pixels[0::2] + pixels[1::2])
        half = width // 2
        pixels = 0.5 * (rows[:, 0 : 2 * half : 2] + rows[:, 1 : 2 * half : 2])
    return np.ascontiguousarray(pixels, dtype=np.float32)


def environment(pixels: np.ndarray, *, azimuth_deg: float, scale: float, stock: bool) -> dict[str, Any]:
    """Return Mitsuba's emitter of an image all around, which is drawn from by how bright it is.

    Parameters
    ----------
    pixels : (h, 2 h, 3) float32
        Linear sRGB; (1, 1, 1) is D65 of luminance 1. As seen from inside, right is right.
    azimuth_deg : float
        Where the middle column is, anticlockwise from x about the vertical [deg].
    scale : float
        What the radiance is multiplied by.
    stock : bool
        Whether it is for an RGB variant.
    """
    import mitsuba as mi

    # Mitsuba puts the first row at the zenith and the last at the nadir, here they are beside the poles
    rows = np.concatenate([pixels[:1], 0.5 * (pixels[:-1] + pixels[1:]), pixels[-1:]])
    rows[[0, -1]] = rows[[0, -1]].mean(axis=1, keepdims=True)  # the poles
    turn = np.radians(azimuth_deg)
    # Its image has the middle column at z and the zenith at y
    to_world = np.eye(4)
    to_world[:3, 0] = -np.sin(turn), np.cos(turn), 0.0
    to_world[:3, 1] = 0.0, 0.0, 1.0
    to_world[:3, 2] = np.cos(turn), np.sin(turn), 0.0
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(rows, dtype=np.float32)),
        "scale": float(scale) * (1.0 if stock else _WHITE),
        "to_world": mi.ScalarTransform4f(to_world),
    }

"""Photoreal pictures as files: PNG for looking, EXR for measuring."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import gemrender
from gemrender.errors import InputError
from gemrender.writing import write_whole

__all__ = [
    "SPECTRAL_ATTRIBUTES",
    "check_picture",
    "file_of",
    "png_bytes",
    "software",
    "spectral_channel",
    "write_exr",
    "write_png",
]

#: Attributes of an EXR with spectral channels (Fichet, Pacanowski & Wilkie, "An OpenEXR Layout for
#: Spectral Images", JCGT 10(3), 2021). The unit is the layout's for radiance; ours is relative to the light.
SPECTRAL_ATTRIBUTES = {"spectralLayoutVersion": "1.0", "emissiveUnits": "W.m^-2.sr^-1"}

#: Attributes that OpenEXR writes itself.
_OWN_ATTRIBUTES = {
    "channels",
    "chunkCount",
    "compression",
    "dataWindow",
    "displayWindow",
    "gemrender.version",
    "lineOrder",
    "name",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "tiles",
    "type",
    "version",
    "view",
}


def spectral_channel(wavelength_nm: float) -> str:
    """Return the channel's name of a spectral bin, as `S0.550,000000nm`.

    By Fichet et al. 2021: the Stokes component, and the bin's centre [nm] with a comma for its decimals.
    """
    return f"S0.{wavelength_nm:.6f}nm".replace(".", ",").replace(",", ".", 1)


def write_exr(
    path: str | os.PathLike[str],
    channels: Mapping[str, Any],
    attributes: Mapping[str, str | float] | None = None,
) -> Path:
    """Write channels as float32, row by row from the top, whole or not at all; return the path.

    Parameters
    ----------
    path : path
        The file, in a folder that is there.
    channels : mapping of str to array_like (h, w)
        By name: `R`, `G`, `B` (linear sRGB, unclipped), `A` (which they are multiplied by), `X`, `Y`, `Z`,
        `albedo.R`, `normal.X`, and spectral bins by `spectral_channel`, which want `SPECTRAL_ATTRIBUTES`.
    attributes : mapping of str to str, int or float, optional
        What the picture is; gemrender's version comes by itself.

    Raises
    ------
    InputError
        Channels of different shapes, attributes that OpenEXR has no type for or that are its own, or a
        file that cannot be written.
    """
    import OpenEXR

    path = file_of(path)
    header: dict[str, Any] = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    header["gemrender.version"] = gemrender.__version__
    for name, value in (attributes or {}).items():
        if not _is_exr_name(name) or name in _OWN_ATTRIBUTES:
            allowed = "must be a name of 1 to 255 characters that is not OpenEXR's own"
            raise InputError(allowed, source=str(path), key="attribute", value=name)
        if not isinstance(value, (str, int, float)):
            raise InputError("must be text or a number", source=str(path), key=name, value=value)
        header[name] = value
    planes = _planes(channels, str(path))
    writers = {path.name: lambda made: OpenEXR.File(header, planes).write(str(made))}
    return write_whole(path.parent, writers)[0]


def write_png(path: str | os.PathLike[str], rgb8: Any, text: Mapping[str, str] | None = None) -> Path:
    """Write a picture as PNG, 8 bits a channel, sRGB, whole or not at all; return the path.

    Parameters
    ----------
    path : path
        The file, in a folder that is there.
    rgb8 : array_like (h, w, 3) or (h, w, 4) of uint8
        The picture, as of `develop`; the fourth channel is alpha, which the others are not multiplied by.
    text : mapping of str to str, optional
        What the picture is, by keyword; `Software` comes by itself.

    Raises
    ------
    InputError
        Another shape or type, a keyword or a text that PNG has no place for, or a file that cannot be
        written.
    """
    path = file_of(path)
    pixels, texts = check_picture(rgb8, str(path)), _checked_texts(text or {}, str(path))
    return write_whole(path.parent, {path.name: lambda made: _write_png(made, pixels, texts)})[0]


def png_bytes(rgb8: Any, text: Mapping[str, str] | None = None) -> bytes:
    """Return what `write_png` would write of the same picture and texts."""
    made = io.BytesIO()
    _write_png(made, check_picture(rgb8, "PNG"), _checked_texts(text or {}, "PNG"))
    return made.getvalue()


def software() -> str:
    """Return what pictures say they are made by."""
    return f"gemrender {gemrender.__version__}"


def check_picture(rgb8: Any, source: str, *, alpha: bool = True) -> np.ndarray:
    """Return a picture for the screen as an array.

    Raises
    ------
    InputError
        Another shape or type than (h, w, 3) of uint8, or (h, w, 4) where `alpha` is allowed.
    """
    pixels = np.asarray(rgb8)
    channels = (3, 4) if alpha else (3,)
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] not in channels or not pixels.size:
        shown = f"{pixels.dtype} {pixels.shape}"
        allowed = f"must be an array (h, w, 3) of uint8{', or (h, w, 4)' if alpha else ''}"
        raise InputError(allowed, source=source, key="rgb8", value=shown)
    return pixels


def file_of(path: str | os.PathLike[str]) -> Path:
    """Return the path of a file to be written.

    Raises
    ------
    InputError
        It has no name.
    """
    file = Path(path)
    if not file.name:
        raise InputError("must be the name of a file", key="path", value=os.fspath(path))
    return file


def _planes(channels: Mapping[str, Any], source: str) -> dict[str, np.ndarray]:
    planes: dict[str, np.ndarray] = {}
    for name, values in channels.items():
        if not _is_exr_name(name):
            allowed = "must be a name of 1 to 255 characters"
            raise InputError(allowed, source=source, key="channel", value=name)
        plane = np.asarray(values)
        if plane.dtype.kind not in "biuf":
            allowed = "must be an array of real numbers"
            raise InputError(allowed, source=source, key=f"{name}.dtype", value=str(plane.dtype))
        first = next(iter(planes.values()), plane)
        if plane.ndim != 2 or not plane.size or plane.shape != first.shape:
            allowed = "must be an array (h, w), of one size for all channels"
            raise InputError(allowed, source=source, key=f"{name}.shape", value=plane.shape)
        with np.errstate(over="ignore"):  # beyond float32 is infinite
            planes[name] = np.ascontiguousarray(plane, dtype=np.float32)
    if not planes:
        raise InputError("must be one or more", source=source, key="channels", value=dict(channels))
    return planes


def _is_exr_name(name: Any) -> bool:
    return isinstance(name, str) and "\0" not in name and _is_unicode(name) and 0 < len(name.encode()) < 256


def _is_unicode(text: str) -> bool:
    """Whether a text can be written: no half of a surrogate pair."""
    return not any("\ud800" <= character <= "\udfff" for character in text)


def _checked_texts(text: Mapping[str, str], source: str) -> dict[str, str]:
    """Return what a PNG file says, by keyword."""
    texts = {"Software": software(), **text}
    for keyword, value in texts.items():
        if not re.fullmatch(r"(?! )[ -~¡-ÿ]{1,79}(?<! )", keyword) or "  " in keyword:
            allowed = "must be a keyword of 1 to 79 Latin-1 characters, without spare spaces"
            raise InputError(allowed, source=source, key="text", value=keyword)
        if not isinstance(value, str) or "\0" in value or not _is_unicode(value):
            allowed = "must be text, without null characters"
            raise InputError(allowed, source=source, key=keyword, value=value)
    return texts


def _write_png(file: Path | io.BytesIO, pixels: np.ndarray, texts: Mapping[str, str]) -> None:
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    info = PngInfo()
    info.add(b"sRGB", b"\0")  # for looking: perceptual intent
    for keyword, text in texts.items():
        info.add_itxt(keyword, text)
    Image.fromarray(pixels).save(file, "png", pnginfo=info)

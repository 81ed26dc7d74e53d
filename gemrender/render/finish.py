"""From a rendered picture to files: denoised if wished, developed, written as PNG or EXR."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.colorimetry import adapt, matrix_to_linear_srgb, white_xyz, xyz_to_linear_srgb
from gemrender.errors import InputError
from gemrender.render.develop import auto_exposure, develop
from gemrender.render.photoreal import Picture, require_denoiser
from gemrender.render.picture_files import SPECTRAL_ATTRIBUTES, spectral_channel, write_exr, write_png
from gemrender.scene.setup import Setup

__all__ = ["STILL_SUFFIXES", "denoised", "developed", "exposure_of", "write_picture"]

#: Memory that the denoiser may take [MB].
DENOISER_MB = 1024
#: Luminance that the ground gets, where it is exposed for.
PAPER = 0.8
#: How the names of still pictures end.
STILL_SUFFIXES = (".png", ".exr")


def denoised(picture: Picture) -> Picture:
    """Return the picture after Intel's Open Image Denoise, guided by albedo and normal.

    Raises
    ------
    BackendError
        The denoiser is not installed.
    """
    oidn = require_denoiser()
    rgb = xyz_to_linear_srgb(picture.xyz)
    albedo = np.ascontiguousarray(np.clip(picture.albedo, 0, 1))
    normal = np.ascontiguousarray(picture.normal)
    device, out = oidn.Device(oidn.DeviceType.CPU), np.zeros_like(rgb)
    # It takes values of 0 and above only: those outside the gamut go through it as a picture of their own.
    for sign in (1.0, -1.0):
        part = np.ascontiguousarray(np.maximum(sign * rgb, 0), dtype=np.float32)
        result = np.empty_like(part)
        denoise = device.new_filter("RT")
        for name, image in (("color", part), ("albedo", albedo), ("normal", normal), ("output", result)):
            denoise.set_image(name, image)
        denoise.hdr = True
        denoise.max_memory_mb = DENOISER_MB  # it works in tiles, then
        denoise.execute()
        out += sign * result
    back = np.linalg.inv(matrix_to_linear_srgb()).T.astype(np.float32)
    return replace(picture, xyz=out @ back)


def exposure_of(picture: Picture, setup: Setup, *, ev: float = 0.0) -> float:
    """Return the automatic exposure of a picture, with the set-up's and the user's correction [stops]."""
    covered = picture.coverage > 0.99
    on_stones = covered & (picture.albedo.min(axis=2) > 0.99)
    on_ground = covered & (picture.albedo.max(axis=2) < 0.99)
    luminance = picture.xyz[..., 1]
    if setup.expose_for == "ground" and on_ground.any():
        level = float(np.median(luminance[on_ground]))
        if level > 0:
            return float(PAPER * 2.0 ** (ev + setup.exposure) / level)
    return auto_exposure(luminance, on_stones if on_stones.any() else None, ev=ev + setup.exposure)


def developed(picture: Picture, setup: Setup, *, exposure: float, curve: str = "linear") -> np.ndarray:
    """Return the picture for the screen, (h, w, 3) uint8 sRGB."""
    return develop(picture.xyz, white_xyz=white_xyz(setup.white), exposure=exposure, curve=curve)


def write_picture(
    path: str | os.PathLike[str],
    picture: Picture,
    setup: Setup,
    *,
    exposure: float,
    curve: str = "linear",
    about: Mapping[str, str] | None = None,
) -> Path:
    """Write a picture as PNG, developed, or as EXR, with linear values and spectral bins.

    Raises
    ------
    InputError
        Another ending, or a file that cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".png":
        return write_png(path, developed(picture, setup, exposure=exposure, curve=curve), about)
    if suffix != ".exr":
        raise InputError(f"must end in {', '.join(STILL_SUFFIXES)}", key="out", value=str(path))
    rgb = xyz_to_linear_srgb(adapt(picture.xyz, white_xyz(setup.white)))
    channels: dict[str, Any] = {name: rgb[..., k] for k, name in enumerate("RGB")}
    channels |= {name: picture.xyz[..., k] for k, name in enumerate("XYZ")}
    channels |= {f"albedo.{name}": picture.albedo[..., k] for k, name in enumerate("RGB")}
    channels |= {f"normal.{name}": picture.normal[..., k] for k, name in enumerate("XYZ")}
    channels["coverage"] = picture.coverage
    attributes: dict[str, Any] = dict(about or {})
    if picture.bins_nm is not None:
        middles = 0.5 * (picture.bins_nm[1:] + picture.bins_nm[:-1])
        channels |= {spectral_channel(nm): picture.spectrum[..., k] for k, nm in enumerate(middles)}
        attributes |= SPECTRAL_ATTRIBUTES
    return write_exr(path, channels, attributes)

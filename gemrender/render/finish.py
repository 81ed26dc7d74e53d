"""From a rendered picture to files: denoised if wished, developed, written for the screen or as EXR."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.colorimetry import adapt, white_xyz, xyz_to_linear_srgb
from gemrender.errors import InputError
from gemrender.render.curves import needed_for
from gemrender.render.develop import auto_exposure, decode_srgb, develop
from gemrender.render.fireflies import without_fireflies
from gemrender.render.first_seen import Seen
from gemrender.render.formats import STILL_SUFFIXES
from gemrender.render.photoreal import Picture, require_denoiser
from gemrender.render.picture_files import SPECTRAL_ATTRIBUTES, spectral_channel, write_exr, write_png
from gemrender.render.web_files import write_jpeg, write_webp
from gemrender.scene.setup import Setup

__all__ = [
    "STILL_SUFFIXES",
    "denoised",
    "developed",
    "exposure_of",
    "for_screen",
    "white_of",
    "write_picture",
]

#: Memory that the denoiser may take [MB].
DENOISER_MB = 1024
#: Luminance that the ground gets, where it is exposed for; and its level in 8 bits, where it is to be white.
PAPER, WHITE_PAPER = 0.8, 250


def denoised(picture: Picture, *, clamp: bool = False) -> Picture:
    """Return the picture after Intel's Open Image Denoise, guided by albedo and normal.

    The denoiser takes bright lonely pixels for noise, and their light away: at 2 samples a pixel a quarter of
    a stone's under small lights, at 16 or more 1 to 4 %. It is given back: stones, ground, and what is beside
    them keep their mean luminance each, that of the clamped picture where fireflies are clamped.

    Parameters
    ----------
    picture : Picture
        What was rendered.
    clamp : bool
        Whether fireflies are clamped before, as is right for the screen and never for an EXR.

    Raises
    ------
    BackendError
        The denoiser is not installed.
    """
    oidn = require_denoiser()
    if clamp:
        picture = without_fireflies(picture)
    xyz = _as_bright(picture.xyz, _denoised(oidn, picture.xyz, picture.albedo, picture.normal), picture.shows)
    front = picture.foreground
    if front is not None:
        alone = _denoised(oidn, front.xyz, front.albedo, front.normal)
        alone[front.alpha == 0] = 0
        front = replace(front, xyz=_as_bright(front.xyz, alone, picture.shows))
    return replace(picture, xyz=xyz, foreground=front, halves=None)


def _denoised(oidn: Any, xyz: np.ndarray, albedo: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Return XYZ after the denoiser.

    It takes values of 0 and above only. Those of spectral colours, as stones throw them, are negative in any
    RGB of the screen, and luminance came out negative where both signs went through it apart. So it is given
    XYZ as shares of white's: grey is grey in them, and no colour is negative.
    """
    # It has been taught pictures of a luminance about 1, and is wrong in the dark.
    level = float(xyz[..., 1].mean(dtype=np.float64)) or 1.0
    white = (level * white_xyz("d65")).astype(np.float32)
    colour = np.ascontiguousarray(np.maximum(xyz / white, 0), dtype=np.float32)
    result = np.empty_like(colour)
    denoise = oidn.Device(oidn.DeviceType.CPU).new_filter("RT")
    guides = {"albedo": np.ascontiguousarray(np.clip(albedo, 0, 1)), "normal": np.ascontiguousarray(normal)}
    for name, image in {"color": colour, **guides, "output": result}.items():
        denoise.set_image(name, image)
    denoise.hdr = True
    denoise.max_memory_mb = DENOISER_MB  # it works in tiles, then
    denoise.execute()
    return np.asarray(result * white)


def _as_bright(before: np.ndarray, after: np.ndarray, shows: np.ndarray) -> np.ndarray:
    """Return XYZ after the denoiser, on average as bright as before where the same kind of thing is seen."""
    after = after.copy()
    for kind in np.unique(shows):
        here = shows == kind
        was, now = (float(xyz[here, 1].mean(dtype=np.float64)) for xyz in (before, after))
        if was > 0 and now > 0:
            after[here] *= np.float32(was / now)
    return after


def exposure_of(picture: Picture, setup: Setup, *, ev: float = 0.0, curve: str | None = None) -> float:
    """Return the automatic exposure of a picture, with the set-up's and the user's correction [stops].

    Parameters
    ----------
    picture, setup : Picture, Setup
        What was rendered, and in what.
    ev : float
        The user's correction [stops].
    curve : str, optional
        Tone curve that the picture is to be developed with, by default the set-up's. It counts where the
        ground is to be white: the exposure is what brings it to `WHITE_PAPER` through the curve.
    """
    stops = ev + setup.exposure
    if setup.expose_for == "light":
        return float(2.0**stops)
    on_stones, on_ground = _on_stones(picture), _on_ground(picture)
    luminance = picture.xyz[..., 1]
    if setup.expose_for in ("ground", "white") and on_ground.any():
        level = float(np.median(luminance[on_ground]))
        wanted = PAPER
        if setup.expose_for == "white":
            wanted = needed_for(float(decode_srgb(WHITE_PAPER / 255)), curve or setup.curve)
        if level > 0:
            return float(wanted * 2.0**stops / level)
    return auto_exposure(luminance, on_stones if on_stones.any() else None, ev=stops)


def white_of(picture: Picture, setup: Setup) -> np.ndarray:
    """Return XYZ of what is white (3,): the set-up's, or the ground where that is to be white."""
    if setup.expose_for == "white":
        paper = picture.xyz[_on_ground(picture)]
        if len(paper):
            found = np.median(paper, axis=0).astype(np.float64)
            if found.min() > 0:
                return np.asarray(found / found[1])
    return white_xyz(setup.white)


def _on_stones(picture: Picture) -> np.ndarray:
    only = (picture.coverage > 0.99) & (picture.albedo.min(axis=2) > 0.99)  # of stones it is 1
    return np.asarray((picture.shows == Seen.STONE) & only)


def _on_ground(picture: Picture) -> np.ndarray:
    return np.asarray((picture.shows == Seen.GROUND) & (picture.coverage > 0.99))


def developed(picture: Picture, setup: Setup, *, exposure: float, curve: str = "linear") -> np.ndarray:
    """Return the picture for the screen, uint8 sRGB: (h, w, 3), or (h, w, 4) where there is a foreground.

    Fireflies are clamped (see `without_fireflies`). The fourth channel is alpha. The others are not
    multiplied by it: at its edge a stone has its own colour, not one darkened by a background that is not
    there.
    """
    return _developed(without_fireflies(picture), white_of(picture, setup), exposure, curve)


def _developed(picture: Picture, white: np.ndarray, exposure: float, curve: str) -> np.ndarray:
    front = picture.foreground
    if front is None:
        return develop(picture.xyz, white_xyz=white, exposure=exposure, curve=curve)
    alpha = np.rint(255 * np.clip(front.alpha, 0, 1)).astype(np.uint8)
    own = np.zeros_like(front.xyz)
    np.divide(front.xyz, front.alpha[..., None], out=own, where=alpha[..., None] > 0)
    return np.dstack([develop(own, white_xyz=white, exposure=exposure, curve=curve), alpha])


def for_screen(
    picture: Picture,
    setup: Setup,
    *,
    exposure: float,
    curve: str = "linear",
    about: Mapping[str, str] | None = None,
) -> tuple[np.ndarray, dict[str, str]]:
    """Return the picture as `developed` has it, and what its file says: `about`, and how many fireflies."""
    white = white_of(picture, setup)
    picture = without_fireflies(picture)
    texts = dict(about or {})
    if picture.clamped:
        told = f"fireflies clamped in {picture.clamped} of {picture.xyz[..., 1].size} pixels"
        texts["Description"] = ", ".join(text for text in (texts.get("Description"), told) if text)
    return _developed(picture, white, exposure, curve), texts


def write_picture(
    path: str | os.PathLike[str],
    picture: Picture,
    setup: Setup,
    *,
    exposure: float,
    curve: str = "linear",
    about: Mapping[str, str] | None = None,
) -> Path:
    """Write a picture, developed, as PNG, JPEG or WebP, or as EXR, with linear values and spectral bins.

    Where there is a foreground, it is what is written: in PNG and WebP with alpha, its colour not multiplied
    by it; in EXR with the channel `A`, all others multiplied by it, as EXR has it. JPEG takes none. Fireflies
    are clamped in all but EXR, and the description says in how many pixels.

    Raises
    ------
    InputError
        Another ending, or a file that cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".exr":
        return _write_exr(path, picture, setup, dict(about or {}))
    if suffix not in STILL_SUFFIXES:
        raise InputError(f"must end in {', '.join(STILL_SUFFIXES)}", key="out", value=str(path))
    pixels, texts = for_screen(picture, setup, exposure=exposure, curve=curve, about=about)
    if suffix == ".png":
        return write_png(path, pixels, texts)
    write = write_webp if suffix == ".webp" else write_jpeg
    return write(path, pixels, title=texts.get("Title", ""), description=texts.get("Description", ""))


def _write_exr(
    path: str | os.PathLike[str], picture: Picture, setup: Setup, attributes: dict[str, Any]
) -> Path:
    front = picture.foreground
    xyz, albedo, normal, coverage = picture.xyz, picture.albedo, picture.normal, picture.coverage
    if front is not None:
        xyz, albedo, normal, coverage = front.xyz, front.albedo, front.normal, front.alpha
    rgb = xyz_to_linear_srgb(adapt(xyz, white_xyz(setup.white)))
    channels: dict[str, Any] = {name: rgb[..., k] for k, name in enumerate("RGB")}
    if front is not None:
        channels["A"] = front.alpha
    channels |= {name: xyz[..., k] for k, name in enumerate("XYZ")}
    channels |= {f"albedo.{name}": albedo[..., k] for k, name in enumerate("RGB")}
    channels |= {f"normal.{name}": normal[..., k] for k, name in enumerate("XYZ")}
    channels["coverage"] = coverage
    if picture.bins_nm is not None:
        middles = 0.5 * (picture.bins_nm[1:] + picture.bins_nm[:-1])
        channels |= {spectral_channel(nm): picture.spectrum[..., k] for k, nm in enumerate(middles)}
        attributes |= SPECTRAL_ATTRIBUTES
    return write_exr(path, channels, attributes)

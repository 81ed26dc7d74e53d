"""Photoreal pictures: a scene rendered in passes until it is good enough, time is up, or someone stops it."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gemrender.cuts.crystal_axes import orientation
from gemrender.errors import BackendError, GemrenderError, GemrenderWarning, InputError
from gemrender.optics import carat_to_girdle_diameter_mm, load_material
from gemrender.optics.material import DIAMETER_RANGE_MM
from gemrender.render.backend import ensure_variant
from gemrender.render.passes import Passes
from gemrender.render.picture import Foreground, Picture
from gemrender.scene.loading import load_scene
from gemrender.scene.moves import Move
from gemrender.scene.photoreal import Gem, check_size, photoreal_scene
from gemrender.scene.setup import Setup
from gemrender.stone import Stone

__all__ = [
    "DEFAULT_VARIANT",
    "Foreground",
    "Picture",
    "check_ends",
    "check_variant",
    "make_gems",
    "render",
    "require_denoiser",
]

DEFAULT_VARIANT = "llvm_ad_spectral"
#: Diameter of a stone whose size neither the user nor its file states [mm]: of round diamonds about 1 carat.
DEFAULT_DIAMETER_MM = 6.5
#: Radius of the tent that pixels are filtered by [pixel].
FILTER_RADIUS = 1.0
#: In a picture of fewer pixels the middle of none may show a stone, though parts do.
FEW_PIXELS = 64
#: Share of samples that may be left out, as they are no light: by far less than what is seen.
MOST_UNSOUND = 1e-4


def make_gems(
    stones: Sequence[Stone],
    *,
    material: str | float | None = None,
    carat: float | None = None,
    diameter_mm: float | None = None,
    c_axis: str | Sequence[float] | None = None,
) -> list[Gem]:
    """Return stones with material and size.

    Parameters
    ----------
    stones : sequence of Stone
        The stones.
    material : str or float, optional
        Name or file of the material of all, or its refractive index; by default each stone's own.
    carat, diameter_mm : float, optional
        Weight of each stone [carat], or its girdle diameter [mm], of stones that are not round the length of
        the outline's longer side; not both. By default the stone's own size, of one without 6.5 mm.
    c_axis : three floats or "table", optional
        How the crystal of each lies (`gemrender.cuts.orientation`); by default as the stone says.

    Raises
    ------
    InputError
        Unknown material, a size that no stone has, or a weight without a density.
    """
    if carat is not None and diameter_mm is not None:
        raise InputError("give a weight or a diameter, not both", key="carat", value=carat)
    low, high = DIAMETER_RANGE_MM
    if diameter_mm is not None and not low <= diameter_mm <= high:
        raise InputError(f"must be from {low:g} to {high:g} [mm]", key="diameter", value=diameter_mm)
    gems = []
    if c_axis is not None:
        crystal = orientation(c_axis=c_axis)
        stones = [replace(stone, crystal=crystal) for stone in stones]
    for stone in stones:
        named = material if material is not None else stone.material
        name = "diamond" if named is None else named
        try:
            of_stone = load_material(name)
        except InputError as error:
            if error.source is not None:
                raise
            if material is not None:
                raise InputError(error.allowed, key="material", value=material) from error
            raise error.at(stone.source or stone.name, "material") from error
        diameter = diameter_mm or stone.size_mm or DEFAULT_DIAMETER_MM
        if carat is not None:
            if of_stone.density is None:
                raise InputError(
                    "needs the material's density, which its file does not give", key="carat", value=carat
                )
            diameter = carat_to_girdle_diameter_mm(carat, stone.solid.volume, of_stone.density)
        gems.append(Gem(stone=stone, material=of_stone, material_name=name, diameter_mm=diameter))
    return gems


def require_denoiser() -> Any:
    """Import the denoiser.

    Raises
    ------
    BackendError
        It is not installed.
    """
    try:
        import mitsuba_oidn
    except ImportError as error:
        raise BackendError(
            f"the denoiser cannot be imported ({error}); to cure it: pip install mitsuba-oidn"
        ) from error
    return mitsuba_oidn


def render(
    gems: Sequence[Gem],
    setup: Setup,
    *,
    width: int,
    height: int,
    spp: int | None = 256,
    noise: float | None = None,
    time_limit: float | None = None,
    seed: int = 0,
    dispersion: bool = True,
    birefringence: bool = True,
    bins_nm: Sequence[float] | None = None,
    turn_deg: float = 0.0,
    move: Move | None = None,
    share: float = 0.0,
    transparent: bool = False,
    variant: str = DEFAULT_VARIANT,
    pass_samples: int | None = None,
    progress: Callable[[float], None] | None = None,
    on_pass: Callable[[Picture, float], object] | None = None,
) -> Picture:
    """Render stones in a set-up.

    It ends at `spp` samples a pixel, at a noise, or after a time, whichever comes first. An interruption
    (Ctrl-C) ends it too, and keeps the passes that are done.

    Parameters
    ----------
    gems : sequence of Gem
        The stones, from left to right.
    setup : Setup
        What stands around them.
    width, height : int
        Size [pixels].
    spp : int, optional
        Samples a pixel.
    noise : float, optional
        Root mean square error of luminance of the stones' pixels, as a share of their mean.
    time_limit : float, optional
        Time [s]; at least one pass is rendered.
    seed : int
        Seed.
    dispersion : bool
        Whether the index depends on the wavelength.
    birefringence : bool
        Whether birefringent stones split light; if not, they have their ordinary index.
    bins_nm : sequence of float, optional
        Edges of spectral bins [nm].
    turn_deg, move, share : float, Move, float
        As for `photoreal_scene`.
    transparent : bool
        Whether the stones, their settings and things are also kept by themselves, for a transparent
        background. Nothing else changes: ground, lights and sky light them, and the picture's exposure and
        noise are those with it.
    variant : str
        Spectral Mitsuba variant; set, and left set.
    pass_samples : int, optional
        As of `Passes`: fewer let who is shown each pass stop sooner.
    progress : callable, optional
        Called with the share done, 0 to 1.
    on_pass : callable, optional
        Called after each pass with the picture so far and the share done. If it returns False, that is an
        interruption.

    Raises
    ------
    InputError
        A value outside what is listed, or a scene that cannot be.
    BackendError
        Mitsuba cannot run here.
    KeyboardInterrupt
        Interrupted before the first pass was done.
    GemrenderError
        So many samples had a radiance that is negative or not finite that the picture is wrong.

    Warns
    -----
    GemrenderWarning
        Some samples had one, and were left out; or no stone is seen.
    """
    check_ends(spp, noise, time_limit, seed)
    check_variant(variant)
    ensure_variant(variant)
    started = time.perf_counter()
    check_size(width, height)
    window = setup.filters.window_width(width)
    common = math.gcd(window, height)
    scene = photoreal_scene(
        gems,
        setup,
        width=window // common,
        height=height // common,
        dispersion=dispersion,
        birefringence=birefringence,
        turn_deg=turn_deg,
        move=move,
        share=share,
    )
    passes = Passes(
        load_scene(scene.to_dict()),
        seed=seed,
        filter_radius=FILTER_RADIUS,
        bins_nm=bins_nm,
        foreground=transparent,
        size=(width, height),
        pass_samples=pass_samples,
    )

    def so_far(stopped: str) -> Picture:
        return Picture(
            xyz=passes.xyz,
            albedo=passes.albedo,
            normal=passes.normal,
            coverage=passes.coverage,
            shows=passes.shows,
            spectrum=passes.spectrum,
            bins_nm=passes.bins_nm,
            samples=passes.samples,
            noise=passes.noise(),
            noise_of="stones" if passes.stone_pixels.any() else "picture",
            left_out=passes.unsound,
            seconds=time.perf_counter() - started,
            stopped=stopped,
            foreground=_foreground(passes),
            halves=passes.halves,
            gems=tuple(gems),
            setup=setup,
            seed=seed,
        )

    def shown(share: float, stopped: str) -> bool:
        """Show the picture so far to who wants it; return whether to go on."""
        if progress is not None:
            progress(share)
        if on_pass is None or passes.samples == 0:
            return True
        answer = on_pass(so_far(stopped), share)
        return not isinstance(answer, (bool, np.bool_)) or bool(answer)

    stopped = _run(passes, spp, noise, time_limit, started, shown)
    if passes.unsound:
        warnings.warn(f"{_left_out_text(passes)}; they are left out", GemrenderWarning, stacklevel=2)
    if width * height >= FEW_PIXELS and not passes.stone_pixels.any():
        told = "no stone is seen in the picture: something stands between them and the camera"
        warnings.warn(told, GemrenderWarning, stacklevel=2)
    return so_far(stopped)


def _run(
    passes: Passes,
    spp: int | None,
    noise: float | None,
    time_limit: float | None,
    started: float,
    shown: Callable[[float, str], bool],
) -> str:
    """Add passes until one of the ends is reached, or who is shown them wants no more; return which."""
    try:
        while True:
            elapsed, found = time.perf_counter() - started, passes.noise()
            end = _end(passes, spp, noise, time_limit, elapsed, found)
            share = 1.0 if end else _share(passes.samples, spp, found, noise, elapsed, time_limit)
            if not shown(share, end or "interrupted"):
                return end or "interrupted"
            if end:
                return end
            most = passes.samples_of_a_pass()
            if spp is None:
                passes.add(most)
            elif passes.samples == 0 and spp % 2 == 0 and spp <= most:
                passes.add(spp // 2, both=True)
            else:  # in two passes at least: their difference tells the noise
                passes.add(min(most, -(-spp // 2), spp - passes.samples))
            _check_sound(passes)
    except KeyboardInterrupt:
        if passes.samples == 0:
            raise
        return "interrupted"


def _end(
    passes: Passes,
    spp: int | None,
    noise: float | None,
    time_limit: float | None,
    elapsed: float,
    found: float,
) -> str:
    """Return which end is reached, after so many seconds and at a noise that was found; else ''."""
    if spp == passes.samples:
        return "samples"
    if passes.samples and time_limit is not None:
        a_pass = elapsed * passes.samples_of_a_pass() / passes.samples
        if elapsed + 0.5 * a_pass > time_limit:
            return "time"
    return "noise" if noise is not None and found <= noise else ""


def _foreground(passes: Passes) -> Foreground | None:
    if passes.foreground is None:
        return None
    xyz, albedo, normal, alpha = passes.foreground
    return Foreground(xyz=xyz, albedo=albedo, normal=normal, alpha=alpha)


def _check_sound(passes: Passes) -> None:
    """Check that samples which are no light are few, and there is light beside them."""
    total = passes.samples * passes.width * passes.height
    if passes.unsound and (passes.unsound > MOST_UNSOUND * total or not passes.xyz.any()):
        raise GemrenderError(f"{_left_out_text(passes)}: too many to leave out")


def _left_out_text(passes: Passes) -> str:
    total = passes.samples * passes.width * passes.height
    return f"{passes.unsound} of {total} samples had a radiance that is negative or not finite"


def _share(
    samples: int,
    spp: int | None,
    found: float,
    noise: float | None,
    elapsed: float,
    time_limit: float | None,
) -> float:
    shares = [0.0]
    if spp is not None:
        shares.append(samples / spp)
    if noise is not None and np.isfinite(found):
        shares.append(min((noise / found) ** 2, 0.99))
    if time_limit is not None:
        shares.append(min(elapsed / time_limit, 0.99))
    return max(shares)


def check_variant(variant: str) -> None:
    """Check that a variant is spectral; whether there is such a one, Mitsuba tells.

    Raises
    ------
    InputError
        It is not.
    """
    if not isinstance(variant, str) or not variant.endswith("_spectral"):
        raise InputError("must be a spectral variant, as llvm_ad_spectral", key="variant", value=variant)


def check_ends(spp: int | None, noise: float | None, time_limit: float | None, seed: int) -> None:
    """Check where rendering ends, and its seed.

    Raises
    ------
    InputError
        No end at all, or a value out of range.
    """
    if spp is None and noise is None and time_limit is None:
        raise InputError("needs a number of samples, a noise or a time to end at", key="spp", value=spp)
    if spp is not None and not 1 <= spp <= 1 << 24:
        raise InputError(f"must be from 1 to {1 << 24}", key="spp", value=spp)
    if noise is not None and not 1e-5 <= noise <= 1:
        raise InputError("must be from 0.00001 to 1", key="noise", value=noise)
    if time_limit is not None and not 0 < time_limit <= 1e7:
        raise InputError("must be above 0 [s]", key="time", value=time_limit)
    if not 0 <= seed < 1 << 30:
        raise InputError(f"must be from 0 to {(1 << 30) - 1}", key="seed", value=seed)

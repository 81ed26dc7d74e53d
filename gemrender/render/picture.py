"""What was rendered: linear values as arrays, and how they are shown, saved and handed on."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.paths import library
from gemrender.scene.photoreal import Gem, title_of
from gemrender.scene.setup import Setup, Sky

__all__ = ["Foreground", "Picture"]

#: Of values that come from no set-up: white is daylight, and the exposure goes by the stones.
_NO_SETUP = Setup(name="none", sky=Sky(radiance=1.0))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Foreground:
    """What a picture shows of stones, their settings and things, for a transparent background.

    Values are premultiplied: a pixel half of which shows a stone has half the stone's light. What is seen
    in and through a stone, and in metal, belongs to it; ground, lights and sky beside it do not.

    Attributes
    ----------
    xyz : (h, w, 3) float32
        As of the picture.
    albedo, normal : (h, w, 3) float32
        Of the first surface.
    alpha : (h, w) float32
        Share of the pixel's samples that meet one of them before anything else.
    """

    xyz: np.ndarray
    albedo: np.ndarray
    normal: np.ndarray
    alpha: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Picture:
    """What was rendered, in linear values; in a notebook it shows itself.

    Attributes
    ----------
    xyz : (h, w, 3) float32
        CIE 1931 XYZ; equal-energy radiance 1 has Y = 1.
    albedo, normal : (h, w, 3) float32
        Of the first surface.
    coverage : (h, w) float32
        Share of the pixel that shows a surface.
    shows : (h, w) uint8
        What the middle of the pixel shows, of `gemrender.render.first_seen.Seen`.
    spectrum : (h, w, bins) float32
        Mean radiance in each bin; where there is a foreground, its.
    bins_nm : (bins + 1,) float64 or None
        Edges of the bins [nm].
    samples : int
        Samples a pixel.
    noise : float
        Root mean square error of luminance, as a share of its mean; of which pixels, `noise_of` says.
    noise_of : {"stones", "picture"}
        The pixels whose middle shows a stone, or all, where there are none of those.
    left_out : int
        Samples, of all pixels, that were left out, as their radiance was negative or not finite.
    seconds : float
        Time it took [s].
    stopped : {"samples", "noise", "time", "interrupted"}
        Why it ended.
    foreground : Foreground or None
        Without ground, lights and sky, where the background is transparent.
    halves : (2, h, w) float32 or None
        Luminance by each of two independent halves of the samples; None of a single pass, and after a change.
    clamped : int
        Pixels whose luminance was brought down for the screen, as fireflies.
    noisy : Picture or None
        What was rendered, where this is that after the denoiser.
    gems : tuple of Gem
        The stones, with material and size.
    setup : Setup
        What stands around them.
    seed : int
        The seed.
    ev : float
        Correction of the automatic exposure [stops].
    curve : str
        Tone curve of all but EXR pictures, of `gemrender.render.curves.CURVES`.
    """

    xyz: np.ndarray
    albedo: np.ndarray
    normal: np.ndarray
    coverage: np.ndarray
    shows: np.ndarray
    spectrum: np.ndarray
    bins_nm: np.ndarray | None
    samples: int
    noise: float
    noise_of: str = "stones"
    left_out: int = 0
    seconds: float
    stopped: str
    foreground: Foreground | None = None
    halves: np.ndarray | None = None
    clamped: int = 0
    noisy: Picture | None = None
    gems: tuple[Gem, ...] = ()
    setup: Setup = _NO_SETUP
    seed: int = 0
    ev: float = 0.0
    curve: str = "filmic"

    def __repr__(self) -> str:
        height, width = self.coverage.shape
        return (
            f"<Picture of {self.title or 'no stones'}, set-up {self.setup.name}: {width} x {height} pixels, "
            f"{self.samples} samples a pixel, noise {self.noise:.2g} of the {self.noise_of}>"
        )

    @property
    def title(self) -> str:
        """What it shows: stones and their materials."""
        return title_of(self.gems)

    @property
    def about(self) -> dict[str, str]:
        """What its files say of it."""
        return {
            "Title": self.title,
            "Description": f"set-up {self.setup.name}, {self.samples} samples a pixel",
        }

    @cached_property
    def for_screen(self) -> Picture:
        """What is developed: the picture itself; denoised, one whose fireflies were clamped before."""
        from gemrender.render.finish import denoised

        return self if self.noisy is None else denoised(self.noisy, clamp=True)

    @property
    def exposure(self) -> float:
        """Factor that luminance is multiplied by for the screen, its correction included."""
        from gemrender.render.finish import exposure_of

        return exposure_of(self.for_screen, self.setup, ev=self.ev, curve=self.curve)

    @property
    def metadata(self) -> dict[str, Any]:
        """What it is and how it was made, as plain values: for tables, JSON and attributes."""
        import gemrender

        return {
            "title": self.title,
            "stones": [gem.stone.name for gem in self.gems],
            "materials": [gem.material.name for gem in self.gems],
            "diameters_mm": [float(gem.diameter_mm) for gem in self.gems],
            "setup": self.setup.name,
            "seed": self.seed,
            "samples": self.samples,
            "noise": self.noise,
            "noise_of": self.noise_of,
            "left_out": self.left_out,
            "seconds": self.seconds,
            "stopped": self.stopped,
            "exposure": self.exposure,
            "curve": self.curve,
            "gemrender_version": gemrender.__version__,
        }

    def rgb8(self) -> np.ndarray:
        """Return it for the screen, uint8 sRGB: (h, w, 3), or (h, w, 4) with a foreground's alpha."""
        from gemrender.render.finish import developed

        return developed(self.for_screen, self.setup, exposure=self.exposure, curve=self.curve)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write it as `gemrender render` does; return the path.

        Parameters
        ----------
        path : path
            The file, in a folder that is there: .png, .jpg or .webp, developed; or .exr, with linear values,
            spectral bins and what is known of the first surface.

        Raises
        ------
        InputError
            Another ending, a transparent background or a size that such a file has no place for, or a file
            that cannot be written.
        """
        from gemrender.render.finish import write_picture
        from gemrender.render.formats import output_kind

        height, width = self.coverage.shape
        output_kind(path, transparent=self.foreground is not None, size=(width, height))
        shown = self if Path(path).suffix.lower() == ".exr" else self.for_screen
        return write_picture(
            path, shown, self.setup, exposure=self.exposure, curve=self.curve, about=self.about
        )

    def to_xarray(self) -> Any:
        """Return its arrays as an xarray Dataset along `y` (from the top) and `x`, with `metadata`.

        XYZ along `tristimulus`, albedo along `rgb`, normals along `axis`; spectral bins, where there are
        some, along `wavelength`, their middles [nm]; a foreground's arrays begin with `foreground_`.

        Raises
        ------
        BackendError
            xarray is not installed.
        """
        arrays: dict[str, Any] = {
            "xyz": (("y", "x", "tristimulus"), self.xyz),
            "albedo": (("y", "x", "rgb"), self.albedo),
            "normal": (("y", "x", "axis"), self.normal),
            "coverage": (("y", "x"), self.coverage),
        }
        places: dict[str, Any] = {
            "tristimulus": ["X", "Y", "Z"],
            "rgb": ["R", "G", "B"],
            "axis": ["x", "y", "z"],
        }
        if self.bins_nm is not None:
            arrays["spectrum"] = (("y", "x", "wavelength"), self.spectrum)
            middles = 0.5 * (self.bins_nm[1:] + self.bins_nm[:-1])
            places["wavelength"] = ("wavelength", middles, {"units": "nm"})
        if self.foreground is not None:
            arrays["foreground_xyz"] = (("y", "x", "tristimulus"), self.foreground.xyz)
            arrays["foreground_albedo"] = (("y", "x", "rgb"), self.foreground.albedo)
            arrays["foreground_normal"] = (("y", "x", "axis"), self.foreground.normal)
            arrays["foreground_alpha"] = (("y", "x"), self.foreground.alpha)
        return library("xarray").Dataset(arrays, coords=places, attrs=self.metadata)

    def _repr_png_(self) -> bytes:
        """Return the PNG file that `save` writes: what notebooks show."""
        from gemrender.render.finish import for_screen
        from gemrender.render.picture_files import png_bytes

        look: dict[str, Any] = {"exposure": self.exposure, "curve": self.curve, "about": self.about}
        return png_bytes(*for_screen(self.for_screen, self.setup, **look))

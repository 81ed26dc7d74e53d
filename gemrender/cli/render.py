"""The command `render`: photoreal pictures and turntables."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import Annotated, Any

import typer

from gemrender.cli.gems import SIZE, Carat, Diameter, Material, Size, load_gems, picture_size
from gemrender.cli.options import Stones, number, whole
from gemrender.cli.output import progress_bar, say
from gemrender.errors import InputError

__all__ = ["render"]

_FILM = ".mp4"


def render(
    stones: Stones,
    out: Annotated[
        str, typer.Option("--out", "-o", metavar="FILE", help="Picture or film to write: .png, .exr or .mp4.")
    ],
    setup: Annotated[
        str, typer.Option(metavar="NAME", help="Set-up: a bundled one (see: gemrender setups) or a file.")
    ] = "studio",
    size: Size = SIZE,
    spp: Annotated[
        str | None,
        typer.Option(
            metavar="NUMBER",
            help="Samples a pixel; by default 256, and without end where a noise or a time is given.",
        ),
    ] = None,
    noise: Annotated[
        str | None,
        typer.Option(metavar="SHARE", help="End at this noise: error of luminance by its mean, as 0.02."),
    ] = None,
    time: Annotated[
        str | None, typer.Option(metavar="SECONDS", help="End after this time (each frame of a film).")
    ] = None,
    material: Material = None,
    carat: Carat = None,
    diameter: Diameter = None,
    dispersion: Annotated[bool, typer.Option(help="Whether the index depends on the wavelength.")] = True,
    denoise: Annotated[
        bool, typer.Option("--denoise", help="Denoise the picture; needs mitsuba-oidn.")
    ] = False,
    exposure: Annotated[
        str, typer.Option(metavar="STOPS", help="Correction of the automatic exposure.")
    ] = "0",
    curve: Annotated[
        str, typer.Option(metavar="linear|filmic", help="Tone curve of PNG pictures and films.")
    ] = "filmic",
    bins: Annotated[
        str | None, typer.Option(metavar="NUMBER", help="Spectral bins of an EXR picture.")
    ] = None,
    range_: Annotated[
        str, typer.Option("--range", metavar="NM,NM", help="Wavelengths that the bins cover.")
    ] = "380,760",
    frames: Annotated[
        str | None, typer.Option(metavar="NUMBER", help="Frames of a film of one turn (.mp4).")
    ] = None,
    fps: Annotated[str, typer.Option(metavar="NUMBER", help="Frames a second.")] = "30",
    turn: Annotated[
        str, typer.Option(metavar="DEGREES", help="Turn of the stones about the vertical.")
    ] = "0",
    seed: Annotated[str, typer.Option(metavar="NUMBER", help="Seed.")] = "0",
    variant: Annotated[
        str, typer.Option(metavar="NAME", help="Spectral Mitsuba variant.")
    ] = "llvm_ad_spectral",
) -> None:
    """Render stones photoreally: spectra, dispersion, studio light."""
    from gemrender.render.develop import CURVES, EV_LIMIT
    from gemrender.render.finish import STILL_SUFFIXES
    from gemrender.render.frames import check_film
    from gemrender.render.photoreal import require_denoiser
    from gemrender.report.files import prepare_folder
    from gemrender.scene.setup import load_setup

    path = Path(out)
    suffix = path.suffix.lower()
    if suffix not in (*STILL_SUFFIXES, _FILM):
        raise InputError(f"must end in {', '.join((*STILL_SUFFIXES, _FILM))}", key="out", value=out)
    if not path.parent.is_dir():
        raise InputError("is in a folder that is not there", key="out", value=out)
    if path.is_dir():
        raise InputError("is a folder", key="out", value=out)
    if frames is None and suffix == _FILM:
        raise InputError("missing: a film needs a number of frames", key="frames")
    if frames is not None and suffix != _FILM:
        raise InputError(f"go with a film, a file that ends in {_FILM}", key="frames", value=frames)
    if curve not in CURVES:
        raise InputError(f"must be one of {', '.join(CURVES)}", key="curve", value=curve)
    width, height = picture_size(size)
    ends: dict[str, Any] = {
        "spp": None if spp is None else whole("spp", spp),
        "noise": None if noise is None else number("noise", noise, "0 to 1"),
        "time_limit": None if time is None else number("time", time, "seconds"),
    }
    if all(value is None for value in ends.values()):
        ends["spp"] = 256
    gems = load_gems(stones, material, carat, diameter)
    around = load_setup(setup)
    options = {
        "width": width,
        "height": height,
        **ends,
        "seed": whole("seed", seed),
        "dispersion": dispersion,
        "variant": variant,
    }
    ev, turn_deg = number("exposure", exposure, "stops"), number("turn", turn)
    bins_nm = _bins(bins, range_, suffix)
    if abs(ev + around.exposure) > EV_LIMIT:
        allowed = f"must be from {-EV_LIMIT:g} to {EV_LIMIT:g} with the set-up's own, {around.exposure:g}"
        raise InputError(allowed, key="exposure", value=exposure)
    if suffix == _FILM and turn_deg:
        raise InputError("is for still pictures only", key="turn", value=turn)
    if denoise:
        require_denoiser()
    prepare_folder(path.parent)
    if suffix == _FILM:
        n_frames, rate = whole("frames", frames or ""), number("fps", fps, "frames a second")
        check_film(path, width, height, n_frames, rate)
        _film(path, gems, around, frames=n_frames, fps=rate, ev=ev, curve=curve, denoise=denoise, **options)
    else:
        _still(path, gems, around, ev, curve, denoise, turn_deg=turn_deg, bins_nm=bins_nm, **options)


def _still(path: Path, gems: Any, setup: Any, ev: float, curve: str, denoise: bool, **options: Any) -> None:
    from gemrender.render.finish import denoised, exposure_of, write_picture
    from gemrender.render.photoreal import render as render_picture

    with progress_bar(1) as step:
        picture = render_picture(gems, setup, progress=step(0, "rendering"), **options)
    if denoise:
        picture = denoised(picture)
    exposure = exposure_of(picture, setup, ev=ev)
    about = {
        "Title": ", ".join(f"{gem.stone.name} ({gem.material.name})" for gem in gems),
        "Description": f"set-up {setup.name}, {picture.samples} samples a pixel",
    }
    write_picture(path, picture, setup, exposure=exposure, curve=curve, about=about)
    noise = f"noise {picture.noise:.2g}" if isfinite(picture.noise) else "noise not known of one pass"
    say(
        f"written: {path} ({picture.samples} samples a pixel, {noise}, "
        f"{picture.seconds:.1f} s, exposure {exposure:.3g})"
    )
    if picture.stopped == "interrupted":
        say("interrupted: the picture holds what was done")
        raise typer.Exit(130)


def _film(path: Path, gems: Any, setup: Any, *, frames: int, **options: Any) -> None:
    from gemrender.render.frames import render_film

    with progress_bar(frames) as step:
        try:
            render_film(
                path,
                gems,
                setup,
                frames=frames,
                progress=lambda k: step(k, f"frame {k + 1} of {frames}"),
                **options,
            )
        except KeyboardInterrupt:
            say(f"interrupted: the frames so far are in {path}.frames; the same command goes on from there")
            raise
    say(f"written: {path}")


def _bins(bins: str | None, range_: str, suffix: str) -> list[float] | None:
    from gemrender.render.passes import check_range

    low, comma, high = range_.partition(",")
    if not comma:
        raise InputError("must be two wavelengths, as 380,760 [nm]", key="range", value=range_)
    first, last = number("range", low, "nanometres"), number("range", high, "nanometres")
    check_range(first, last)
    if bins is None:
        return None
    if suffix != ".exr":
        raise InputError("go into EXR pictures only", key="bins", value=bins)
    n = whole("bins", bins)
    if not 1 <= n <= 200:
        raise InputError("must be from 1 to 200", key="bins", value=bins)
    return [first + (last - first) * k / n for k in range(n + 1)]

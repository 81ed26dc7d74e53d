"""The command `render`: photoreal pictures and turntables."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import Annotated, Any

import typer

from gemrender.cli.gems import (
    SIZE,
    GemOptions,
    SettingOptions,
    Setup,
    Size,
    load_gems,
    picture_size,
    with_settings,
)
from gemrender.cli.groups import command
from gemrender.cli.options import ENGINE, Stones, output_option
from gemrender.cli.output import output_file, progress_bar, say
from gemrender.cli.values import choice_option, complete_words, number_option, whole_option
from gemrender.errors import InputError
from gemrender.render.formats import Background
from gemrender.render.quality import Quality

__all__ = ["render"]

#: Headings of the help.
PICTURE, FILM = "Picture", "Film"


@command
def render(
    stones: Stones,
    gem: GemOptions,
    held: SettingOptions,
    out: Annotated[
        str,
        output_option(
            "Picture or film to write, or the folder for it: .png, .jpg, .webp, .exr; .mp4, .gif, .webp.",
            "FILE",
        ),
    ],
    setup: Annotated[str, Setup] = "studio",
    size: Size = SIZE,
    quality: Annotated[
        str | None,
        choice_option(
            "--quality",
            tuple(Quality),
            "Where to end, in a word; by default good, 256 samples. Samples or a noise stand in its place.",
            metavar="WORD",
        ),
    ] = None,
    spp: Annotated[int | None, whole_option("--spp", "Samples a pixel.")] = None,
    noise: Annotated[
        float | None,
        number_option(
            "--noise",
            "0 to 1",
            "End at this noise: error of luminance on the stones, by its mean.",
            metavar="SHARE",
        ),
    ] = None,
    time: Annotated[
        float | None,
        number_option("--time", "seconds", "End after this time (each frame of a film).", metavar="SECONDS"),
    ] = None,
    dispersion: Annotated[bool, typer.Option(help="Whether the index depends on the wavelength.")] = True,
    turn: Annotated[
        float,
        number_option("--turn", "degrees", "Turn of the stones about the vertical.", metavar="DEGREES"),
    ] = 0.0,
    seed: Annotated[int, whole_option("--seed", "Seed.")] = 0,
    variant: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="Spectral Mitsuba variant.",
            autocompletion=complete_words(lambda: ("llvm_ad_spectral", "cuda_ad_spectral")),
            rich_help_panel=ENGINE,
        ),
    ] = "llvm_ad_spectral",
    background: Annotated[
        str,
        choice_option(
            "--background",
            tuple(Background),
            "What is seen beside the stones.",
            metavar="WORD",
            rich_help_panel=PICTURE,
        ),
    ] = "setup",
    denoise: Annotated[
        bool,
        typer.Option("--denoise", help="Denoise the picture; needs mitsuba-oidn.", rich_help_panel=PICTURE),
    ] = False,
    exposure: Annotated[
        float,
        number_option(
            "--exposure",
            "stops",
            "Correction of the automatic exposure.",
            metavar="STOPS",
            rich_help_panel=PICTURE,
        ),
    ] = 0.0,
    curve: Annotated[
        str,
        choice_option(
            "--curve",
            ("linear", "filmic"),
            "Tone curve of all but EXR pictures.",
            metavar="CURVE",
            rich_help_panel=PICTURE,
        ),
    ] = "filmic",
    bins: Annotated[
        int | None,
        whole_option("--bins", "Spectral bins of an EXR picture.", low=1, high=200, rich_help_panel=PICTURE),
    ] = None,
    range_: Annotated[
        str,
        typer.Option(
            "--range", metavar="NM,NM", help="Wavelengths that the bins cover.", rich_help_panel=PICTURE
        ),
    ] = "380,760",
    frames: Annotated[
        int | None,
        whole_option("--frames", "Frames of a film of one turn (.mp4, .gif or .webp).", rich_help_panel=FILM),
    ] = None,
    fps: Annotated[
        float,
        number_option("--fps", "frames a second", "Frames a second.", metavar="NUMBER", rich_help_panel=FILM),
    ] = 30.0,
) -> None:
    """Render stones photoreally: spectra, dispersion, studio light."""
    from gemrender.render.develop import EV_LIMIT
    from gemrender.render.formats import output_kind
    from gemrender.render.frames import check_film
    from gemrender.render.photoreal import require_denoiser
    from gemrender.render.quality import ends_of
    from gemrender.report.files import file_stems, prepare_folder
    from gemrender.scene.setup import load_setup
    from gemrender.writing import check_place

    default = file_stems(stones)[0] + (".mp4" if frames else ".png")
    path = Path(output_file(out, default))
    suffix = path.suffix.lower()
    width, height = picture_size(size)
    transparent = background == Background.TRANSPARENT
    kind = output_kind(path, frames=frames, transparent=transparent, size=(width, height))
    ends = ends_of(Quality(quality) if quality else None, spp=spp, noise=noise, time_limit=time)
    gems = load_gems(stones, gem)
    around = with_settings(load_setup(setup), held)
    options: dict[str, Any] = {
        "width": width,
        "height": height,
        **ends,
        "seed": seed,
        "dispersion": dispersion,
        "transparent": transparent,
        "variant": variant,
    }
    bins_nm = _bins(bins, range_, suffix)
    if abs(exposure + around.exposure) > EV_LIMIT:
        allowed = f"must be from {-EV_LIMIT:g} to {EV_LIMIT:g} with the set-up's own, {around.exposure:g}"
        raise InputError(allowed, key="exposure", value=exposure)
    if kind == "film" and turn:
        raise InputError("is for still pictures only", key="turn", value=turn)
    if denoise:
        require_denoiser()
    prepare_folder(path.parent)
    check_place(path)
    shown: dict[str, Any] = {"ev": exposure, "curve": curve, "denoise": denoise}
    if frames is not None:
        check_film(path, width, height, frames, fps)
        _film(path, gems, around, frames=frames, fps=fps, **shown, **options)
    else:
        _still(path, gems, around, turn_deg=turn, bins_nm=bins_nm, **shown, **options)


def _still(
    path: Path, gems: Any, setup: Any, *, ev: float, curve: str, denoise: bool, **options: Any
) -> None:
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
    noise = "noise not known of one pass"
    if isfinite(picture.noise):
        noise = f"noise {picture.noise:.2g} of the {picture.noise_of}"
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


def _bins(bins: int | None, range_: str, suffix: str) -> list[float] | None:
    from gemrender.render.passes import check_range

    allowed = "must be two wavelengths, as 380,760 [nm]"
    try:
        first, last = (float(part) for part in range_.split(","))
    except ValueError as error:
        raise InputError(allowed, key="range", value=range_) from error
    if not (isfinite(first) and isfinite(last)):
        raise InputError(allowed, key="range", value=range_)
    check_range(first, last)
    if bins is None:
        return None
    if suffix != ".exr":
        raise InputError("go into EXR pictures only", key="bins", value=bins)
    return [first + (last - first) * k / bins for k in range(bins + 1)]

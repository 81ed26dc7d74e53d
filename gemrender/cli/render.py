"""The command `render`: photoreal pictures and films."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gemrender.cli.gems import SIZE, GemOptions, SettingOptions, Setup, Size, tell_assumptions
from gemrender.cli.groups import command
from gemrender.cli.options import ENGINE, Stones, output_option
from gemrender.cli.output import output_file, progress_bar, say
from gemrender.cli.values import choice_option, complete_words, number_option, whole_option
from gemrender.errors import InputError
from gemrender.render.formats import Background
from gemrender.render.quality import Quality

if TYPE_CHECKING:
    from gemrender.render.shots import Shot
    from gemrender.scene.moves import Move

__all__ = ["render"]

#: Headings of the help.
PICTURE, FILM = "Picture", "Film"
#: Its words are those of `gemrender.scene.moves`, which is heavier to import.
MOVES = ("turntable", "rock", "tilt")
#: What the shell completes; any other may be asked for.
ASPECTS = ("1:1", "4:5", "9:16", "3:2", "16:9")
#: Tone curves, those of set-ups.
CURVES = ("linear", "filmic", "contrast", "neutral", "agx")


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
    aspect: Annotated[
        str | None,
        typer.Option(
            metavar="W:H",
            help="Width to height, as 4:5 or 9:16; the size is the shorter side, then.",
            autocompletion=complete_words(lambda: ASPECTS),
        ),
    ] = None,
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
    birefringence: Annotated[
        bool,
        typer.Option(help="Whether birefringent stones split light, or have their ordinary index."),
    ] = True,
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
        str | None,
        choice_option(
            "--curve",
            CURVES,
            "Tone curve of all but EXR pictures; by default the set-up's.",
            metavar="CURVE",
            rich_help_panel=PICTURE,
        ),
    ] = None,
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
        whole_option("--frames", "Frames of a film (.mp4, .gif or .webp), a loop.", rich_help_panel=FILM),
    ] = None,
    move: Annotated[
        str,
        choice_option(
            "--move",
            MOVES,
            "How stones move: one turn about the vertical, from side to side, or to the camera and away.",
            metavar="WORD",
            rich_help_panel=FILM,
        ),
    ] = "turntable",
    to: Annotated[
        float | None,
        number_option(
            "--to",
            "degrees",
            "How far stones are rocked or tilted, either way; by default 15.",
            metavar="DEGREES",
            rich_help_panel=FILM,
        ),
    ] = None,
    fps: Annotated[
        float,
        number_option("--fps", "frames a second", "Frames a second.", metavar="NUMBER", rich_help_panel=FILM),
    ] = 30.0,
) -> None:
    """Render stones photoreally: spectra, dispersion, studio light."""
    from gemrender.render.formats import output_kind
    from gemrender.render.shots import prepare
    from gemrender.report.files import file_stems, prepare_folder
    from gemrender.scene.moves import Move
    from gemrender.writing import check_place

    default = file_stems(stones)[0] + (".mp4" if frames else ".png")
    path = Path(output_file(out, default))
    output_kind(path, frames=frames, transparent=background == Background.TRANSPARENT)
    if bins is not None and path.suffix.lower() != ".exr":
        raise InputError("go into EXR pictures only", key="bins", value=bins)
    shot = prepare(
        stones,
        setup,
        material=gem.material,
        carat=gem.carat,
        diameter=gem.diameter,
        c_axis=gem.c_axis,
        setting=held.setting,
        metal=held.metal,
        girdle=held.girdle,
        size=size,
        aspect=aspect,
        quality=quality,
        spp=spp,
        noise=noise,
        time=time,
        dispersion=dispersion,
        birefringence=birefringence,
        turn=turn,
        seed=seed,
        variant=variant,
        background=background,
        denoise=denoise,
        exposure=exposure,
        curve=curve,
        bins=bins,
        range=range_,
    )
    moved = Move.of(move, to)
    if frames is not None:
        shot.check_film(path, frames=frames, fps=fps, move=moved)
    else:
        output_kind(path, transparent=shot.transparent, size=shot.size)
    if frames is None and (move != "turntable" or to is not None):
        key, value = ("move", move) if move != "turntable" else ("to", to)
        raise InputError("is of films; give a number of --frames, too", key=key, value=value)
    tell_assumptions(stones, shot.gems)
    prepare_folder(path.parent)
    check_place(path)
    if frames is not None:
        _film(path, shot, frames=frames, fps=fps, move=moved)
    else:
        _still(path, shot)


def _still(path: Path, shot: Shot) -> None:
    with progress_bar(1) as step:
        picture = shot.picture(progress=step(0, "rendering"))
    picture.save(path)
    noise = "noise not known of one pass"
    if isfinite(picture.noise):
        noise = f"noise {picture.noise:.2g} of the {picture.noise_of}"
    say(
        f"written: {path} ({picture.samples} samples a pixel, {noise}, "
        f"{picture.seconds:.1f} s, exposure {picture.exposure:.3g})"
    )
    if picture.stopped == "interrupted":
        say("interrupted: the picture holds what was done")
        raise typer.Exit(130)


def _film(path: Path, shot: Shot, *, frames: int, fps: float, move: Move) -> None:
    with progress_bar(frames) as step:
        try:
            shot.film(
                path,
                frames=frames,
                fps=fps,
                move=move,
                progress=lambda k: step(k, f"frame {k + 1} of {frames}"),
            )
        except KeyboardInterrupt:
            say(f"interrupted: the frames so far are in {path}.frames; the same command goes on from there")
            raise
    say(f"written: {path}")

"""What Python users call: `gemrender.render` for a picture, `gemrender.render_film` for a film."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, TypedDict, Union, Unpack

from gemrender import signatures

if TYPE_CHECKING:
    from gemrender.cuts import StoneLike
    from gemrender.render.picture import Picture
    from gemrender.scene.setup import Setup

__all__ = ["FilmOptions", "Stones", "render", "render_film"]

#: A stone, the name of a bundled one, a stone file; or several of them, from left to right.
Stones: TypeAlias = Union["StoneLike", "Sequence[StoneLike]"]


def render(
    stone: Stones,
    setup: str | os.PathLike[str] | Setup = "studio",
    *,
    material: str | float | None = None,
    carat: float | None = None,
    diameter: float | None = None,
    c_axis: str | Sequence[float] | None = None,
    setting: str | None = None,
    metal: str | None = None,
    girdle: str | None = None,
    size: int | str | Sequence[int] = 1024,
    aspect: str | Sequence[float] | None = None,
    quality: str | None = None,
    spp: int | None = None,
    noise: float | None = None,
    time: float | None = None,
    dispersion: bool = True,
    birefringence: bool = True,
    turn: float = 0.0,
    seed: int = 0,
    variant: str = "llvm_ad_spectral",
    background: str = "setup",
    denoise: bool = False,
    exposure: float = 0.0,
    curve: str | None = None,
    bins: int | None = None,
    range: str | Sequence[float] = (380.0, 760.0),  # noqa: A002 (the option's name)
    on_pass: Callable[[Picture, float], object] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Picture:
    """Render a photoreal picture of stones: spectra, dispersion, studio light.

    ::

        picture = gemrender.render("inoue-3", setup="velvet", size=512, spp=64)
        picture.save("velvet.png")

        display = IPython.display.display(display_id=True)  # a notebook shows it as it gets better
        gemrender.render("inoue-3", on_pass=lambda so_far, share: display.update(so_far))

    It is what the command `gemrender render` does, with its options by their names. It ends at a number of
    samples, at a noise, or after a time, whichever comes first; Ctrl-C ends it too, and keeps the passes that
    are done.

    Parameters
    ----------
    stone : Stone, str, path, or several
        The stones, from left to right: as of `load_stone`, or what it takes.
    setup : str, path or Setup
        A bundled set-up (`gemrender setups`), a set-up file, or one that is loaded.
    material : str or float, optional
        Material of all stones, by name or file, or a refractive index; by default each stone's own.
    carat, diameter : float, optional
        Weight of each stone [carat], or its girdle diameter or longer side [mm].
    c_axis : three floats or "table", optional
        Optic axis of birefringent stones in the stone's frame, z up, or along the stone's axis; of biaxial
        ones the axis gamma. By default as each stone's file says, which without is "table".
    setting : {"none", "solitaire", "bezel", "pendant"}, optional
        What holds each stone; by default what the set-up says.
    metal : {"platinum", "gold", "silver"}, optional
        Metal of the setting.
    girdle : {"polished", "faceted", "bruted"}, optional
        Finish of the stones' girdles.
    size : int, str or (int, int)
        Side of the picture, or width and height [pixels].
    aspect : str or (float, float), optional
        Width to height, as "4:5" or "9:16"; `size` is the shorter side, then.
    quality : {"draft", "good", "best"}, optional
        Where to end, in a word; by default "good", 256 samples. Samples or a noise stand in its place.
    spp : int, optional
        Samples a pixel.
    noise : float, optional
        Error of luminance on the stones, as a share of its mean.
    time : float, optional
        Time [s]; at least one pass is rendered.
    dispersion : bool
        Whether the index depends on the wavelength.
    birefringence : bool
        Whether birefringent stones split light; if not, they have their ordinary index, of biaxial ones the
        middle one.
    turn : float
        Turn of the stones about the vertical [deg].
    seed : int
        Seed: one seed, one picture.
    variant : str
        Spectral Mitsuba variant; it is left set.
    background : {"setup", "transparent"}
        What is seen beside the stones.
    denoise : bool
        Whether the picture is denoised in the end; needs mitsuba-oidn.
    exposure : float
        Correction of the automatic exposure [stops].
    curve : {"linear", "filmic", "contrast", "neutral", "agx"}, optional
        Tone curve of all but EXR pictures; by default the set-up's.
    bins : int, optional
        Number of spectral bins, up to 200.
    range : (float, float)
        Wavelengths that the bins cover [nm].
    on_pass : callable, optional
        Called after each pass with the picture so far, not denoised, and the share of the work that is done,
        0 to 1. If it returns False, that ends the work, as Ctrl-C does.
    progress : callable, optional
        Called with the share that is done.

    Returns
    -------
    Picture
        Linear values as arrays, `save`, `to_xarray`; it shows itself in a notebook.

    Raises
    ------
    InputError
        A stone, a set-up or an option that cannot be; it says which, and what is allowed.
    BackendError
        Mitsuba or the denoiser cannot run here; with the cure.
    KeyboardInterrupt
        Interrupted before the first pass was done.
    """
    from gemrender.render.shots import prepare

    shot = prepare(
        stone,
        setup,
        material=material,
        carat=carat,
        diameter=diameter,
        c_axis=c_axis,
        setting=setting,
        metal=metal,
        girdle=girdle,
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
        range=range,
    )
    return shot.picture(on_pass=on_pass, progress=progress)


class FilmOptions(TypedDict, total=False):
    """What `render` takes that a film takes too; told there."""

    material: str | float | None
    carat: float | None
    diameter: float | None
    c_axis: str | Sequence[float] | None
    setting: str | None
    metal: str | None
    girdle: str | None
    size: int | str | Sequence[int]
    aspect: str | Sequence[float] | None
    quality: str | None
    spp: int | None
    noise: float | None
    time: float | None
    dispersion: bool
    birefringence: bool
    turn: float
    seed: int
    variant: str
    background: str
    denoise: bool
    exposure: float
    curve: str | None


@signatures.spelt_out(
    defaults={name: signature(render).parameters[name].default for name in FilmOptions.__annotations__},
    texts=signatures.parameter_texts(render.__doc__),
    types=signatures.types_of(FilmOptions),
)
def render_film(
    stone: Stones,
    path: str | os.PathLike[str],
    setup: str | os.PathLike[str] | Setup = "studio",
    *,
    frames: int,
    fps: float = 30.0,
    move: str = "turntable",
    to: float | None = None,
    progress: Callable[[float], None] | None = None,
    **options: Unpack[FilmOptions],
) -> Path:
    """Render a film of stones that move, and return its path.

    It is a loop: the last frame leads to the first. Frames are kept in a folder beside the film until it is
    written; the same call goes on where another one was stopped.

    Parameters
    ----------
    path : path
        The film, in a folder that is there: .mp4, .gif or .webp.
    frames : int
        Number of frames of the whole loop.
    fps : float
        Frames a second.
    move : {"turntable", "rock", "tilt"}
        One turn about the vertical; to and fro from side to side; or to the camera and away from it.
    to : float, optional
        How far stones are rocked or tilted, either way [deg]; by default 15.
    time : float, optional
        Time of each frame [s]; at least one pass is rendered.
    **options
        As of `render`.

    Returns
    -------
    Path
        The film.

    Raises
    ------
    InputError
        As for `render`; or the folder of frames holds something else or is in use, or a file cannot be
        written.
    BackendError
        Mitsuba, the denoiser or the library that writes the film is missing; with the cure.
    KeyboardInterrupt
        Interrupted; the frames that are done are kept.
    """
    from gemrender.render.shots import prepare
    from gemrender.scene.moves import Move

    shot, moved = prepare(stone, setup, **options), Move.of(move, to)
    shot.check_film(Path(path), frames=frames, fps=fps, move=moved)

    def of_frame(frame: int) -> Callable[[float], None]:
        return lambda share: progress((frame + share) / frames) if progress is not None else None

    return shot.film(Path(path), frames=frames, fps=fps, move=moved, progress=of_frame)

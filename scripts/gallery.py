"""Render the gallery of the README: each picture by its name, or all of them.

    python scripts/gallery.py                                  # all, into docs/gallery: about 45 minutes
    python scripts/gallery.py ruby sapphire --out /tmp/gallery --size 320 --samples 32
    python scripts/gallery.py viewers                          # a sheet of stones in gem viewers
    python scripts/gallery.py turntable                        # the film, and a small moving picture of it

Pictures are denoised where mitsuba-oidn is installed (pip install mitsuba-oidn), unless --raw; the
film needs pip install av.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from gemrender.cuts import load_stone
from gemrender.cuts.round_brilliant.proportions import RoundBrilliant
from gemrender.errors import BackendError
from gemrender.render.finish import denoised, developed, exposure_of
from gemrender.render.frames import render_film
from gemrender.render.photoreal import make_gems, render, require_denoiser
from gemrender.scene.moves import Move
from gemrender.scene.setup import load_setup
from gemrender.stone import Stone


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """A picture of the gallery.

    Attributes
    ----------
    setup : str
        Set-up.
    stones : tuple of str
        Stones or files, from left to right.
    material : str
        Material of all.
    dispersion : bool
        Whether the index depends on the wavelength.
    curve : str, optional
        Tone curve; by default the set-up's.
    aspect : float
        Width by height.
    """

    setup: str
    stones: tuple[str, ...] = ("inoue-3",)
    material: str = "diamond"
    dispersion: bool = True
    curve: str | None = None
    aspect: float = 1.0


#: Designs of faceters.
DESIGNS = Path(__file__).parents[1] / "tests" / "cases" / "stones"

SHOTS = {
    "face-up-hemisphere": Shot(setup="hemisphere", curve="linear"),
    "face-up-loupe": Shot(setup="loupe"),
    "face-up-fire": Shot(setup="fire"),
    "studio": Shot(setup="studio"),
    "window": Shot(setup="window"),
    "velvet": Shot(setup="velvet"),
    "samples-1-and-3": Shot(setup="hemisphere", stones=("inoue-1", "inoue-3"), curve="linear", aspect=2.0),
    "ruby": Shot(setup="white", material="ruby"),
    "sapphire": Shot(setup="white", material="blue sapphire"),
    "cubic-zirconia": Shot(setup="studio", material="cubic zirconia"),
    "moissanite": Shot(setup="studio", material="moissanite"),
    "without-dispersion": Shot(setup="fire", dispersion=False),
    "emerald": Shot(setup="studio", stones=(f"{DESIGNS}/emerald.asc",), material="quartz"),
    "pear": Shot(setup="velvet", stones=(f"{DESIGNS}/pear.asc",), material="quartz"),
    "checkerboard": Shot(setup="studio", stones=(f"{DESIGNS}/checkerboard-round.asc",), material="spinel"),
    "oval-bow-tie": Shot(setup="arrows", stones=("oval-bow-tie",), curve="linear"),
    "emerald-market": Shot(setup="arrows", stones=("emerald-market",), curve="linear"),
    "asscher-ideal": Shot(setup="arrows", stones=("asscher-ideal",), curve="linear"),
    "pear-bow-tie": Shot(setup="arrows", stones=("pear-bow-tie",), curve="linear"),
    "princess-excellent": Shot(setup="studio", stones=("princess-excellent",)),
    "radiant-classic": Shot(setup="studio", stones=("radiant-classic",)),
}
#: What the sheet shows: set-ups of gem viewers, from left to right, and stones with materials, downwards.
VIEWERS = ("aset", "ideal-scope", "arrows", "hearts")
VIEWED = (("near-ideal", "diamond"), (f"{DESIGNS}/emerald.asc", "quartz"), (f"{DESIGNS}/pear.asc", "quartz"))
#: Frames of the turntable, and how many a second shows.
FRAMES, FPS = 72, 24.0


def main() -> None:
    """Render what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("names", nargs="*", help=f"of {', '.join(SHOTS)}, viewers, turntable; by default all")
    parser.add_argument("--out", type=Path, default=Path("docs/gallery"), help="folder to write to")
    parser.add_argument("--size", type=int, default=720, help="pixels a side")
    parser.add_argument("--samples", type=int, default=128, help="samples a pixel")
    parser.add_argument("--seed", type=int, default=0, help="seed")
    parser.add_argument("--png", action="store_true", help="write PNG, not JPEG")
    parser.add_argument("--raw", action="store_true", help="do not denoise")
    arguments = parser.parse_args()
    known = [*SHOTS, "viewers", "turntable"]
    names = arguments.names or known
    if unknown := [name for name in names if name not in known]:
        parser.error(f"unknown picture {unknown[0]}; must be one of {', '.join(known)}")
    denoise = not arguments.raw and _can_denoise()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for name in names:
        if name == "turntable":
            turntable(arguments.out, arguments.size // 2, arguments.samples // 4, arguments.seed, denoise)
            continue
        render_shot = partial(shown, samples=arguments.samples, seed=arguments.seed, denoise=denoise)
        rgb = (
            sheet(render_shot, arguments.size)
            if name == "viewers"
            else render_shot(SHOTS[name], arguments.size)
        )
        file = arguments.out / f"{name}.{'png' if arguments.png else 'jpg'}"
        edges = name == "viewers" or SHOTS[name].setup == "arrows"  # many, which take room
        quality = 85 if edges else 93
        options = {"optimize": True} if arguments.png else {"quality": quality, "subsampling": 0}
        Image.fromarray(rgb).save(file, **options)
        print(name, flush=True)


def shown(shot: Shot, size: int, *, samples: int, seed: int, denoise: bool) -> np.ndarray:
    """Render a picture, and return it as it is shown, (h, w, 3) uint8."""
    gems = make_gems([stone_of(stone) for stone in shot.stones], material=shot.material, carat=1.0)
    setup = load_setup(shot.setup)
    height = round(size / shot.aspect)
    picture = render(
        gems, setup, width=size, height=height, spp=samples, seed=seed, dispersion=shot.dispersion
    )
    print(f"{picture.samples} samples a pixel, noise {picture.noise:.3f}, {picture.seconds:.0f} s", end="  ")
    if denoise:
        picture = denoised(picture, clamp=True)
    curve = shot.curve or setup.curve
    exposure = exposure_of(picture, setup, curve=curve)
    return developed(picture, setup, exposure=exposure, curve=curve)


def stone_of(name: str) -> Stone:
    """Return a stone by its name or file, or a round brilliant of near-ideal proportions."""
    if name != "near-ideal":
        return load_stone(name)
    cut = RoundBrilliant.from_angles(
        table=56, crown_angle=34.5, pavilion_angle=40.75, star=50, lower_half=77, girdle_thickness=2.5
    )
    return cut.stone(name=name)


def sheet(render_shot: Callable[[Shot, int], np.ndarray], size: int) -> np.ndarray:
    """Render stones in gem viewers side by side, each a third of the size of other pictures."""
    rows = [
        [
            render_shot(Shot(setup=setup, stones=(stone,), material=material, curve="linear"), size // 3)
            for setup in VIEWERS
        ]
        for stone, material in VIEWED
    ]
    return np.concatenate([np.concatenate(row, axis=1) for row in rows])


def turntable(out: Path, size: int, samples: int, seed: int, denoise: bool) -> None:
    """Render a turn of a stone: a film, and a small moving picture."""
    gems = make_gems([load_stone("inoue-3")], carat=1.0)
    setup = load_setup("velvet")
    film = render_film(
        out / "turntable.mp4",
        gems,
        setup,
        frames=FRAMES,
        fps=FPS,
        move=Move(),
        ev=0.0,
        curve=setup.curve,
        denoise=denoise,
        progress=lambda k: lambda share: None,
        width=size - size % 2,
        height=size - size % 2,
        spp=samples,
        seed=seed,
    )
    _moving_picture(film, out / "turntable.webp")
    print("turntable", flush=True)


def _moving_picture(film: Path, path: Path) -> None:
    """Write every other frame of a film as an animated WebP, half as large."""
    import av

    with av.open(str(film)) as container:
        frames = [Image.fromarray(frame.to_ndarray(format="rgb24")) for frame in container.decode(video=0)]
    small = [
        frame.resize((frame.width // 2 * 2 * 2 // 3,) * 2, Image.Resampling.LANCZOS) for frame in frames[::2]
    ]
    small[0].save(
        path, save_all=True, append_images=small[1:], duration=round(2000 / FPS), loop=0, quality=70
    )


def _can_denoise() -> bool:
    try:
        require_denoiser()
    except BackendError as error:
        print(error)
        return False
    return True


if __name__ == "__main__":
    main()

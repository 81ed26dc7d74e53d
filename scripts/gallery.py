"""Render the gallery of the README: each picture by its name, or all of them.

    python scripts/gallery.py                                  # all, into docs/gallery: an hour on two cores
    python scripts/gallery.py ruby sapphire --out gallery --size 320 --samples 32
    python scripts/gallery.py viewers                          # a sheet of stones in gem viewers
    python scripts/gallery.py turntable                        # the film, and a small moving picture of it
    python scripts/gallery.py --samples 256 --variant cuda_ad_spectral  # all on a graphics processor

Of each photograph what a photographer looks at is printed, as `measure_setups.py` does. Photographs are
denoised where mitsuba-oidn is installed (pip install mitsuba-oidn), unless --raw; films need pip install av.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from measure_setups import HEADINGS, can_denoise, measured, stone_of
from PIL import Image

import gemrender
from gemrender.render.picture import Picture


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """A picture of the gallery.

    Attributes
    ----------
    setup : str
        Set-up.
    stones : tuple of str
        Stones or files, from left to right.
    material : str, optional
        Material of all; by default each stone's own.
    setting, metal : str, optional
        What holds the stones.
    dispersion : bool
        Whether the index depends on the wavelength.
    curve : str, optional
        Tone curve; by default the set-up's.
    aspect : float
        Width by height.
    share : float
        Its size, as a share of that of photographs.
    effort : int
        So many times the samples of others.
    """

    setup: str
    stones: tuple[str, ...] = ("near-ideal",)
    material: str | None = None
    setting: str | None = None
    metal: str | None = None
    dispersion: bool = True
    curve: str | None = None
    aspect: float = 1.0
    share: float = 1.0
    effort: int = 1


def instrument(setup: str, *stones: str, aspect: float = 1.0) -> Shot:
    """Return a picture as an instrument shows it: half as large, radiance 1 is white."""
    return Shot(setup=setup, stones=stones, curve="linear", aspect=aspect, share=0.5)


#: Designs of faceters.
DESIGNS = Path(__file__).parents[1] / "tests" / "cases" / "stones"

PHOTOGRAPHS = {
    "product": Shot(setup="product"),
    "princess": Shot(setup="studio", stones=("princess-ideal",)),
    "sapphire": Shot(setup="studio", stones=("corundum-round",), material="blue sapphire"),
    "amethyst": Shot(setup="studio", stones=("quartz-emerald",), material="amethyst"),
    "ruby": Shot(setup="white", stones=("corundum-oval",), material="ruby"),
    "rhodolite": Shot(setup="window", stones=("garnet-cushion",), material="rhodolite"),
    "hand": Shot(setup="hand"),
    "pendant": Shot(setup="velvet", stones=("pear-classic",), setting="pendant", metal="gold"),
    "fire": Shot(setup="fire"),
    "asscher": Shot(setup="loupe", stones=("asscher-ideal",)),
    "moissanite": Shot(setup="macro", stones=("oval-classic",), material="moissanite", effort=3),
    "sun": Shot(setup="sun", stones=("marquise-classic",)),
}
INSTRUMENTS = {
    "without-dispersion": Shot(setup="fire", dispersion=False, share=0.5),
    "face-up-hemisphere": instrument("hemisphere", "inoue-3"),
    "samples-1-and-3": instrument("hemisphere", "inoue-1", "inoue-3", aspect=2.0),
    "oval-bow-tie": instrument("arrows", "oval-bow-tie"),
    "emerald-market": instrument("arrows", "emerald-market"),
    "pear-bow-tie": instrument("arrows", "pear-bow-tie"),
}
SHOTS = PHOTOGRAPHS | INSTRUMENTS
#: What the sheet shows: set-ups of gem viewers, from left to right, and stones with materials, downwards.
VIEWERS = ("aset", "ideal-scope", "arrows", "hearts")
VIEWED = (("near-ideal", "diamond"), (f"{DESIGNS}/emerald.asc", "quartz"), (f"{DESIGNS}/pear.asc", "quartz"))
#: Frames of the turntable, and how many a second shows.
FRAMES, FPS = 72, 24.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """How pictures are rendered: pixels a side, samples a pixel, seed, denoiser or not, Mitsuba's variant."""

    size: int
    samples: int
    seed: int
    denoise: bool
    variant: str


def main() -> None:
    """Render what is asked for."""
    known = [*SHOTS, "viewers", "turntable"]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("names", nargs="*", help=f"of {', '.join(known)}; by default all")
    parser.add_argument("--out", type=Path, default=Path("docs/gallery"), help="folder to write to")
    parser.add_argument("--size", type=int, default=1200, help="pixels a side")
    parser.add_argument("--samples", type=int, default=32, help="samples a pixel")
    parser.add_argument("--seed", type=int, default=0, help="seed")
    parser.add_argument("--variant", default="llvm_ad_spectral", help="spectral Mitsuba variant")
    parser.add_argument("--png", action="store_true", help="write PNG, not JPEG")
    parser.add_argument("--raw", action="store_true", help="do not denoise")
    arguments = parser.parse_args()
    names = arguments.names or known
    if unknown := [name for name in names if name not in known]:
        parser.error(f"unknown picture {unknown[0]}; must be one of {', '.join(known)}")
    options = Options(
        size=arguments.size,
        samples=arguments.samples,
        seed=arguments.seed,
        denoise=not arguments.raw and can_denoise(),
        variant=arguments.variant,
    )
    arguments.out.mkdir(parents=True, exist_ok=True)
    print(f"{'picture':20} {HEADINGS}")
    for name in names:
        if name == "turntable":
            turntable(arguments.out, options)
            continue
        if name == "viewers":
            rgb = sheet(options)
        else:
            picture = rendered(SHOTS[name], options)
            rgb = picture.rgb8()
            print(f"{name:20} {measured(picture, rgb)}", flush=True)
        _write(rgb, arguments.out / name, png=arguments.png, fine=name not in PHOTOGRAPHS)


def rendered(shot: Shot, options: Options) -> Picture:
    """Render a picture."""
    width = round(options.size * shot.share * (shot.aspect if shot.aspect > 1 else 1))
    return gemrender.render(
        [stone_of(stone) for stone in shot.stones],
        shot.setup,
        material=shot.material,
        carat=1.0,
        setting=shot.setting,
        metal=shot.metal,
        size=(width, round(width / shot.aspect)),
        spp=shot.effort * options.samples,
        seed=options.seed,
        dispersion=shot.dispersion,
        curve=shot.curve,
        denoise=options.denoise,
        variant=options.variant,
    )


def sheet(options: Options) -> np.ndarray:
    """Render stones in gem viewers side by side, each a fifth of the size of photographs."""
    rows = [
        [
            rendered(
                Shot(setup=setup, stones=(stone,), material=material, curve="linear", share=0.2), options
            ).rgb8()
            for setup in VIEWERS
        ]
        for stone, material in VIEWED
    ]
    return np.concatenate([np.concatenate(row, axis=1) for row in rows])


def turntable(out: Path, options: Options) -> None:
    """Render a turn of a stone: a film, and a small moving picture of it."""
    film = gemrender.render_film(
        "inoue-3",
        out / "turntable.mp4",
        "velvet",
        frames=FRAMES,
        fps=FPS,
        carat=1.0,
        size=options.size * 3 // 20 * 2,
        spp=max(1, options.samples * 3 // 8),
        seed=options.seed,
        denoise=options.denoise,
        variant=options.variant,
    )
    _moving_picture(film, out / "turntable.webp")
    print("turntable", flush=True)


def _write(rgb: np.ndarray, path: Path, *, png: bool, fine: bool) -> None:
    """Write a picture; one with many fine edges takes room."""
    quality = 85 if fine else 90
    options = {"optimize": True} if png else {"quality": quality, "subsampling": 0}
    Image.fromarray(rgb).save(path.with_suffix(".png" if png else ".jpg"), **options)


def _moving_picture(film: Path, path: Path) -> None:
    """Write every other frame of a film as an animated WebP, two thirds as large."""
    import av

    with av.open(str(film)) as container:
        frames = [Image.fromarray(frame.to_ndarray(format="rgb24")) for frame in container.decode(video=0)]
    small = [
        frame.resize((frame.width * 2 // 3, frame.height * 2 // 3), Image.Resampling.LANCZOS)
        for frame in frames[::2]
    ]
    small[0].save(
        path, save_all=True, append_images=small[1:], duration=round(2000 / FPS), loop=0, quality=70
    )


if __name__ == "__main__":
    main()

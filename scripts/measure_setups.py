"""Render each set-up small, and print what a photographer would look at; the pictures go into a folder.

    python scripts/measure_setups.py                              # all photographic set-ups: some minutes
    python scripts/measure_setups.py product fire --size 256 --samples 64 --out /tmp/setups

Of each picture, as the screen shows it (8 bits, through the set-up's own curve): the paper's median and how
far apart its channels are; the stone's 2nd and 98th percentile, its contrast (standard deviation of linear
luminance by its mean), and the share of its pixels with a colour. Face up, also how dark the arrows are: 1
less the median level of the darkest fifth of the ring that arrows lie in, by that of the rest.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

from gemrender.colorimetry import luminance_weights
from gemrender.cuts import load_stone
from gemrender.errors import BackendError
from gemrender.render.curves import MID_GREY
from gemrender.render.develop import decode_srgb
from gemrender.render.finish import denoised, developed, exposure_of
from gemrender.render.photoreal import Picture, make_gems, render, require_denoiser
from gemrender.scene.setup import Setup, load_setup
from gemrender.stone import Stone

#: Set-ups that picture a stone as a photographer does, and not as an instrument.
SETUPS = ("product", "studio", "white", "window", "velvet", "fire", "loupe", "macro", "sun")
#: What counts as a colour: chroma, the largest channel less the smallest, of a pixel of mid grey or brighter.
COLOURED = 0.12
#: Ring of the face-up stone that holds the arrows' shafts [girdle radius].
RING = (0.35, 0.85)


def main() -> None:
    """Render and measure what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("setups", nargs="*", default=SETUPS, help="set-ups or files; by default all")
    parser.add_argument("--stone", default="near-ideal", help="stone; a bundled one or a file")
    parser.add_argument("--material", help="a material's name or file")
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--raw", action="store_true", help="do not denoise")
    parser.add_argument("--out", type=Path, help="folder for the pictures")
    arguments = parser.parse_args()
    denoise = not arguments.raw and _can_denoise()
    print(f"{'set-up':10} paper  apart   dark  bright  contrast  coloured  arrows  noise  time")
    for name in arguments.setups:
        setup = load_setup(name)
        gems = make_gems([_stone(arguments.stone)], material=arguments.material, carat=1.0)
        size = arguments.size
        picture = render(gems, setup, width=size, height=size, spp=arguments.samples, seed=arguments.seed)
        rgb = shown(picture, setup, denoise)
        if arguments.out is not None:
            arguments.out.mkdir(parents=True, exist_ok=True)
            Image.fromarray(rgb).save(arguments.out / f"{Path(name).stem}.png")
        values = measured(picture, setup, rgb)
        print(f"{Path(name).stem:10} {values}  {picture.noise:5.3f}  {picture.seconds:3.0f} s", flush=True)


def shown(picture: Picture, setup: Setup, denoise: bool) -> np.ndarray:
    """Return the picture for the screen through the set-up's curve."""
    exposure = exposure_of(picture, setup)
    if denoise:
        picture = denoised(picture, clamp=True)
    return developed(picture, setup, exposure=exposure, curve=setup.curve)


def measured(picture: Picture, setup: Setup, rgb: np.ndarray) -> str:
    """Return the numbers of a picture as a row."""
    covered = picture.coverage > 0.99
    on_stone = covered & (picture.albedo.min(axis=2) > 0.99)
    on_ground = covered & (picture.albedo.max(axis=2) < 0.99)
    paper, apart = "  -  ", "  -  "
    if on_ground.any():
        median = np.median(rgb[on_ground], axis=0)
        paper, apart = f"{median.mean():5.0f}", f"{np.ptp(median):5.0f}"
    linear = decode_srgb(rgb[on_stone] / 255.0)
    luminance = linear @ luminance_weights()
    dark, bright = np.percentile(rgb[on_stone].mean(axis=1), [2, 98])
    contrast = luminance.std() / luminance.mean()
    encoded = rgb[on_stone] / 255.0
    coloured = (np.ptp(encoded, axis=1) > COLOURED) & (luminance > 0.5 * MID_GREY)
    arrows = "  -   "
    if setup.camera.elevation > 85 and setup.pose == "table-up":
        arrows = f"{arrow_darkness(rgb, on_stone):6.2f}"
    row = f"{paper}  {apart}  {dark:5.0f}  {bright:6.0f}  {contrast:8.2f}  {100 * coloured.mean():6.1f} %"
    return f"{row}  {arrows}"


def arrow_darkness(rgb: np.ndarray, on_stone: np.ndarray) -> float:
    """Return 1 less the level of the darkest fifth of the arrows' ring by that of the rest, 0 to 1."""
    rows, columns = np.nonzero(on_stone)
    middle = np.array([rows.mean(), columns.mean()])
    radius = 0.5 * max(np.ptp(rows), np.ptp(columns)) or 1.0
    away = np.hypot(rows - middle[0], columns - middle[1]) / radius
    level = np.sort(rgb[on_stone][(away > RING[0]) & (away < RING[1])].mean(axis=1))
    if len(level) < 10:
        return 0.0
    fifth = len(level) // 5
    return float(1 - np.median(level[:fifth]) / max(np.median(level[fifth:]), 1.0))


def _stone(name: str) -> Stone:
    if name == "near-ideal":
        from gallery import stone_of

        return stone_of(name)
    return load_stone(name)


def _can_denoise() -> bool:
    try:
        require_denoiser()
    except BackendError:
        return False
    return True


if __name__ == "__main__":
    main()

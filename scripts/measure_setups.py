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

import gemrender
from gemrender.colorimetry import luminance_weights
from gemrender.cuts import load_stone
from gemrender.cuts.round_brilliant.proportions import RoundBrilliant
from gemrender.errors import BackendError
from gemrender.render.curves import MID_GREY
from gemrender.render.develop import decode_srgb
from gemrender.render.first_seen import Seen
from gemrender.render.photoreal import require_denoiser
from gemrender.render.picture import Picture
from gemrender.stone import Stone

#: Set-ups that picture a stone as a photographer does, and not as an instrument.
SETUPS = ("product", "studio", "white", "window", "velvet", "fire", "loupe", "hand", "macro", "sun")
#: What `measured` prints.
HEADINGS = "paper  apart   dark  bright  contrast  coloured  arrows  noise  time"
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
    parser.add_argument("--variant", default="llvm_ad_spectral", help="spectral Mitsuba variant")
    parser.add_argument("--raw", action="store_true", help="do not denoise")
    parser.add_argument("--out", type=Path, help="folder for the pictures")
    arguments = parser.parse_args()
    denoise = not arguments.raw and can_denoise()
    print(f"{'set-up':10} {HEADINGS}")
    for name in arguments.setups:
        picture = gemrender.render(
            stone_of(arguments.stone),
            name,
            material=arguments.material,
            carat=1.0,
            size=arguments.size,
            spp=arguments.samples,
            seed=arguments.seed,
            denoise=denoise,
            variant=arguments.variant,
        )
        rgb = picture.rgb8()
        if arguments.out is not None:
            arguments.out.mkdir(parents=True, exist_ok=True)
            Image.fromarray(rgb).save(arguments.out / f"{Path(name).stem}.png")
        print(f"{Path(name).stem:10} {measured(picture, rgb)}", flush=True)


def measured(picture: Picture, rgb: np.ndarray) -> str:
    """Return the numbers of a picture, and of what the screen shows of it, below `HEADINGS`."""
    on_stone, on_ground = picture.shows == Seen.STONE, picture.shows == Seen.GROUND
    paper, apart = "  -  ", "  -  "
    if on_ground.any():
        median = np.median(rgb[on_ground], axis=0)
        paper, apart = f"{median.mean():5.0f}", f"{np.ptp(median):5.0f}"
    encoded = rgb[on_stone] / 255.0
    luminance = decode_srgb(encoded) @ luminance_weights()
    dark, bright = np.percentile(rgb[on_stone].mean(axis=1), [2, 98])
    contrast = luminance.std() / luminance.mean()
    coloured = (np.ptp(encoded, axis=1) > COLOURED) & (luminance > 0.5 * MID_GREY)
    arrows = "  -   "
    if picture.setup.camera.elevation > 85 and picture.setup.pose == "table-up":
        arrows = f"{arrow_darkness(rgb, on_stone):6.2f}"
    row = f"{paper}  {apart}  {dark:5.0f}  {bright:6.0f}  {contrast:8.2f}  {100 * coloured.mean():6.1f} %"
    return f"{row}  {arrows}  {picture.noise:5.3f}  {picture.seconds:3.0f} s"


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


def stone_of(name: str) -> Stone:
    """Return a stone by its name or file, or a round brilliant of near-ideal proportions."""
    if name != "near-ideal":
        return load_stone(name)
    cut = RoundBrilliant.from_angles(
        table=56, crown_angle=34.5, pavilion_angle=40.75, star=50, lower_half=77, girdle_thickness=2.5
    )
    return cut.stone(name=name)


def can_denoise() -> bool:
    """Return whether there is the denoiser; where there is none, say how to get it."""
    try:
        require_denoiser()
    except BackendError as error:
        print(error)
        return False
    return True


if __name__ == "__main__":
    main()

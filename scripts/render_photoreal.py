"""Render a picture of a stone from Python: what `gemrender render` does, step by step.

python scripts/render_photoreal.py                             # inoue-3 in the studio -> studio.png
python scripts/render_photoreal.py tolkowsky --setup velvet --material moissanite --out velvet.png
"""

from __future__ import annotations

import argparse

from gemrender.cuts import load_stone
from gemrender.render.finish import exposure_of, write_picture
from gemrender.render.photoreal import make_gems, render
from gemrender.scene.setup import load_setup


def main() -> None:
    """Render one picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("stone", nargs="?", default="inoue-3", help="a bundled stone or a stone file")
    parser.add_argument("--setup", default="studio", help="a bundled set-up or a set-up file")
    parser.add_argument("--material", help="a material's name or file; by default the stone's own")
    parser.add_argument("--size", type=int, default=512, help="pixels a side")
    parser.add_argument("--samples", type=int, default=64, help="samples a pixel")
    parser.add_argument("--seed", type=int, default=0, help="seed")
    parser.add_argument("--out", default="studio.png", help="picture to write: .png or .exr")
    arguments = parser.parse_args()

    # A stone, what it is made of and how large it is; several of them stand side by side.
    gems = make_gems([load_stone(arguments.stone)], material=arguments.material, carat=1.0)
    setup = load_setup(arguments.setup)
    picture = render(
        gems,
        setup,
        width=arguments.size,
        height=arguments.size,
        spp=arguments.samples,
        seed=arguments.seed,
        progress=lambda share: print(f"\r{100 * share:3.0f} %", end="", flush=True),
    )
    print(f"\r{picture.samples} samples a pixel, noise {picture.noise:.3f}, {picture.seconds:.1f} s")

    # Linear values are in picture.xyz; a PNG has an exposure and a curve.
    exposure = exposure_of(picture, setup)
    print("written:", write_picture(arguments.out, picture, setup, exposure=exposure, curve=setup.curve))


if __name__ == "__main__":
    main()

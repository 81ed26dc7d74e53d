"""Render a picture of a stone from Python, as `gemrender render` does.

python scripts/render_photoreal.py                             # inoue-3 in the studio -> studio.png
python scripts/render_photoreal.py tolkowsky --setup velvet --material moissanite --out velvet.png
"""

from __future__ import annotations

import argparse

import gemrender


def main() -> None:
    """Render one picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("stone", nargs="?", default="inoue-3", help="a bundled stone or a stone file")
    parser.add_argument("--setup", default="studio", help="a bundled set-up or a set-up file")
    parser.add_argument("--material", help="a material's name or file; by default the stone's own")
    parser.add_argument("--size", type=int, default=512, help="pixels a side")
    parser.add_argument("--samples", type=int, default=64, help="samples a pixel")
    parser.add_argument("--seed", type=int, default=0, help="seed")
    parser.add_argument("--out", default="studio.png", help="picture to write: .png, .jpg, .webp or .exr")
    arguments = parser.parse_args()

    def on_pass(so_far: gemrender.Picture, share: float) -> None:
        """Tell how far it is; a notebook would show the picture so far, and return False to end it."""
        print(f"\r{100 * share:3.0f} %, noise {so_far.noise:.3f}", end="", flush=True)

    picture = gemrender.render(
        arguments.stone,
        arguments.setup,
        material=arguments.material,
        carat=1.0,
        size=arguments.size,
        spp=arguments.samples,
        seed=arguments.seed,
        on_pass=on_pass,
    )
    # Linear values are in picture.xyz; a PNG has an exposure and a curve.
    print(f"\n{picture}, {picture.seconds:.1f} s, exposure {picture.exposure:.3g}")
    print("written:", picture.save(arguments.out))


if __name__ == "__main__":
    main()

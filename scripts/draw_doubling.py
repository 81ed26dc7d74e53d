"""Draw what birefringence does in pictures: doubled edges, colours by direction, a stone between filters.

    python scripts/draw_doubling.py [doubling] [pleochroism] [polariscope] [--out docs] [--size 400]
                                    [--samples 128]

One sheet each, of pictures side by side; denoised where mitsuba-oidn is installed.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from measure_setups import can_denoise
from PIL import Image

import gemrender
from gemrender.scene.setup import Camera, Setup


def studio(elevation: float) -> Setup:
    """Return the studio with the stone table up and the camera at an elevation [deg]."""
    camera = Camera(elevation=elevation, azimuth=-90, distance=15, margin=1.1)
    return replace(gemrender.load_setup("studio"), pose="table-up", camera=camera)


def shots() -> dict[str, list[dict[str, Any]]]:
    """Return what is in each sheet, from left to right."""
    aslant, above = studio(50), studio(90)
    moissanite: dict[str, Any] = {"stone": "gia-excellent", "material": "moissanite"}
    long, across = "table", (1.0, 0.0, 0.0)
    tourmaline: dict[str, Any] = {"setup": above, "stone": "emerald-even", "material": "green tourmaline"}
    tanzanite: dict[str, Any] = {"setup": above, "stone": "corundum-oval", "material": "tanzanite"}
    ruby: dict[str, Any] = {
        "setup": above,
        "stone": "corundum-oval",
        "material": "ruby",
        "c_axis": across,
    }
    between: dict[str, Any] = {"setup": "polariscope", "stone": "quartz-round"}
    return {
        "doubling": [
            moissanite | {"setup": aslant, "birefringence": False},
            moissanite | {"setup": aslant},
            moissanite | {"setup": above},
            {"setup": aslant, "stone": "gia-excellent", "material": "zircon"},
        ],
        "pleochroism": [
            tourmaline | {"c_axis": long},
            tourmaline | {"c_axis": across},
            tanzanite | {"c_axis": long},
            tanzanite | {"c_axis": across},
            ruby | {"c_axis": across, "analyser": 0.0},
            ruby | {"c_axis": across, "analyser": 90.0},
        ],
        "polariscope": [
            between | {"material": "spinel"},
            between | {"material": "quartz", "c_axis": (1.0, 0.0, 0.0)},
            between | {"material": "quartz", "c_axis": (1.0, 1.0, 0.0)},
            between | {"material": "quartz", "c_axis": "table"},
        ],
    }


def sheet(of: Sequence[Mapping[str, Any]], options: argparse.Namespace) -> Image.Image:
    """Render pictures and put them side by side."""
    out = Image.new("RGB", (options.size * len(of), options.size))
    for k, shot in enumerate(of):
        picture = gemrender.render(
            **shot, size=options.size, spp=options.samples, seed=options.seed, denoise=can_denoise()
        )
        out.paste(Image.fromarray(picture.rgb8()), (k * options.size, 0))
    return out


def main() -> None:
    """Draw what is asked for."""
    known = shots()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("names", nargs="*", help=f"of {', '.join(known)}; by default all")
    parser.add_argument("--out", type=Path, default=Path("docs"), help="folder to write to")
    parser.add_argument("--size", type=int, default=400, help="pixels a side")
    parser.add_argument("--samples", type=int, default=128, help="samples a pixel")
    parser.add_argument("--seed", type=int, default=0, help="seed")
    options = parser.parse_args()
    for name in options.names or known:
        if name not in known:
            parser.error(f"{name}: must be one of {', '.join(known)}")
        path = options.out / f"{name}.jpg"
        sheet(known[name], options).save(path, quality=90)
        print(f"written: {path}")


if __name__ == "__main__":
    main()

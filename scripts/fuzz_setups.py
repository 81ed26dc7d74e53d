"""Render stones in random set-ups, as far as set-up files allow, and count what comes out of it.

    python scripts/fuzz_setups.py [--setups 200] [--seed 0] [--size 12] [--samples 8] [--show]

Prints how many were rendered, how many were refused (`InputError`: a light among the stones, a camera under
the ground), and of the rest how many had samples that were negative or not finite, how many a picture, noise
or exposure that is not finite or negative, and how many ended in a traceback; the longest time; and, with
`--show`, each set-up that was not as it should be. Exits with 1 if there was any.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.errors import GemrenderError, InputError
from gemrender.scene.setup import (
    CAMERAS,
    CURVES,
    EXPOSURES,
    GROUNDS,
    LIGHTS,
    POSES,
    SKIES,
    Box,
    Camera,
    Ground,
    Light,
    Setup,
    Sky,
    Zone,
)
from gemrender.scene.sky_boxes import SHAPES

#: Angles at which things are edge-on, upright or level [deg].
TELLING = (-90.0, -89.5, 0.0, 1e-6, 45.0, 89.5, 90.0)


def main() -> int:
    """Render set-ups; print the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--setups", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--size", type=int, default=12)
    parser.add_argument("--samples", type=int, default=8)
    parser.add_argument("--show", action="store_true")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")  # that samples were left out is counted here
    counts: Counter[str] = Counter()
    longest = 0.0
    for number in range(arguments.setups):
        setup = random_setup(np.random.default_rng([arguments.seed, number]))
        started = time.perf_counter()
        found = outcome(setup, arguments.size, arguments.samples, number)
        longest = max(longest, time.perf_counter() - started)
        counts[found] += 1
        if arguments.show and found not in ("rendered", "refused"):
            print(f"{number}: {found}: {setup}", flush=True)
    wrong = arguments.setups - counts["rendered"] - counts["refused"]
    names = ("rendered", "refused", "samples left out", "not finite or negative", "traceback")
    print(", ".join(f"{name} {counts[name]}" for name in names), f"(longest {longest:.1f} s)")
    return int(wrong > 0)


def outcome(setup: Setup, size: int, samples: int, seed: int) -> str:
    """Render a stone in a set-up; return what came of it."""
    from gemrender.cuts import load_stone
    from gemrender.render.finish import developed, exposure_of
    from gemrender.render.photoreal import make_gems, render

    try:
        gems = make_gems([load_stone("inoue-3")])
        picture = render(gems, setup, width=size, height=size, spp=samples, seed=seed)
        exposure = exposure_of(picture, setup)
        developed(picture, setup, exposure=exposure, curve=setup.curve)
    except InputError:
        return "refused"
    except GemrenderError:
        return "samples left out"
    except Exception:
        traceback.print_exc()
        return "traceback"
    if picture.left_out:
        return "samples left out"
    sound = np.isfinite(picture.xyz).all() and picture.xyz[..., 1].min() >= 0
    sound &= np.isfinite(picture.albedo).all() and np.isfinite(picture.normal).all()
    sound &= np.isfinite(picture.noise) and picture.noise >= 0
    return "rendered" if sound and np.isfinite(exposure) and exposure > 0 else "not finite or negative"


def random_setup(rng: np.random.Generator) -> Setup:
    """Return a set-up drawn from all that are allowed, the odd ones more often."""
    while True:
        ground = str(rng.choice(GROUNDS))
        try:
            return Setup(
                name="random",
                pose="table-up" if ground == "cup" else str(rng.choice(POSES)),
                facing=float(rng.uniform(-360, 360)),
                camera=_camera(rng),
                lights=tuple(_light(rng) for _ in range(rng.integers(0, 4))),
                sky=_sky(rng),
                ground=Ground(
                    type=ground,
                    reflectance=float(rng.choice([0.0, 1.0, rng.uniform()])),
                    distance=float(10 ** rng.uniform(np.log10(3), 3)),
                ),
                white=_spectrum(rng),
                expose_for=str(rng.choice(EXPOSURES)),
                curve=str(rng.choice(CURVES)),
            )
        except InputError:  # no light, or a lens that focuses behind itself
            continue


def _camera(rng: np.random.Generator) -> Camera:
    distance = float(10 ** rng.uniform(0.4, 4))
    return Camera(
        type=str(rng.choice(CAMERAS)),
        elevation=_elevation(rng),
        azimuth=float(rng.choice([0.0, 90.0, rng.uniform(-360, 360)])),
        distance=distance,
        margin=float(10 ** rng.uniform(-1, 1)),
        aperture=float(10 ** rng.uniform(-2, 2)),
        focus=float(rng.uniform(-1, 1)),
    )


def _sky(rng: np.random.Generator) -> Sky:
    kind = str(rng.choice(SKIES))
    turned: dict[str, Any] = {
        "azimuth": float(rng.uniform(-360, 360)),
        "scale": float(rng.choice([1.0, 10 ** rng.uniform(-6, 6)])),
    }
    if kind == "image":
        return Sky(type=kind, image=_image(rng), **turned)
    if kind == "studio":
        boxes = tuple(_box(rng) for _ in range(rng.integers(1, 5)))
        return Sky(type=kind, radiance=_radiance(rng), spectrum=_spectrum(rng), boxes=boxes, **turned)
    if kind != "zones":
        return Sky(type=kind, radiance=_radiance(rng), spectrum=_spectrum(rng))
    edges = np.unique([_elevation(rng) for _ in range(rng.integers(2, 9))])
    zones = [
        Zone(elevation=(float(low), float(high)), colour=_colour(rng), radiance=_radiance(rng))
        for low, high in pairwise(edges)
    ]
    return Sky(type=kind, zones=tuple(zones))


def _image(rng: np.random.Generator) -> str:
    """Write an image of noise, a few pixels of which are by far brighter, negative or black."""
    import OpenEXR

    rows = int(rng.choice([8, 9, 64]))
    pixels = 10 ** rng.uniform(-9, 3, (rows, 2 * rows, 3))
    pixels[rng.uniform(size=(rows, 2 * rows)) < 0.2] = 0
    pixels[rng.integers(rows), rng.integers(2 * rows)] = [1e6, 1e-6, 0]
    pixels[rng.integers(rows), rng.integers(2 * rows)] = -1
    path = Path(tempfile.gettempdir()) / f"fuzz_setups_{os.getpid()}.exr"
    planes = {name: np.ascontiguousarray(pixels[..., k], dtype=np.float32) for k, name in enumerate("RGB")}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, planes).write(str(path))
    return str(path)


def _box(rng: np.random.Generator) -> Box:
    return Box(
        shape=str(rng.choice(SHAPES)),
        elevation=_elevation(rng),
        azimuth=float(rng.uniform(-360, 360)),
        size=(float(10 ** rng.uniform(-1, 2.2)), float(10 ** rng.uniform(-1, 2.2))),
        soft=float(rng.choice([0.0, 90.0, rng.uniform(0, 20)])),
        gradient=(float(rng.uniform()), float(rng.choice([0.0, 1.0]))),
        radiance=_radiance(rng),
        spectrum=_spectrum(rng),
    )


def _colour(rng: np.random.Generator) -> tuple[float, float, float]:
    red, green, blue = rng.choice([0.0, 1.0, 1e-12, 1e-3, rng.uniform()], size=3)
    return float(red), float(green), float(blue)


def _light(rng: np.random.Generator) -> Light:
    width, height = (float(x) for x in 10 ** rng.uniform(-3, 2, 2))
    return Light(
        shape=str(rng.choice(LIGHTS)),
        elevation=_elevation(rng),
        azimuth=float(rng.choice([0.0, 90.0, rng.uniform(-360, 360)])),
        distance=float(10 ** rng.uniform(0, 3)),
        size=(width, height),
        count=int(rng.integers(1, 9)),
        radiance=_radiance(rng),
        spectrum=_spectrum(rng),
    )


def _elevation(rng: np.random.Generator) -> float:
    return float(rng.choice(TELLING) if rng.uniform() < 0.4 else rng.uniform(-90, 90))


def _radiance(rng: np.random.Generator) -> float:
    return float(rng.choice([0.0, 1.0, 1e9, 10 ** rng.uniform(-9, 9)]))


def _spectrum(rng: np.random.Generator) -> str | float:
    if rng.uniform() < 0.5:
        return str(rng.choice(["d65", "a", "e", "f11"]))
    return float(rng.uniform(1000, 25000))


if __name__ == "__main__":
    sys.exit(main())

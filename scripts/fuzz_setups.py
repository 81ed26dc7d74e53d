"""Render stones in random set-ups, as far as set-up files and options allow, and count what comes out of it.

    python scripts/fuzz_setups.py [--setups 500] [--seed 0] [--size 32] [--samples 2] [--show]

Drawn are one to three bundled stones with their materials, sizes and how their crystals lie, their settings,
metals and girdles, the things beside them, cameras, filters, lights, skies and grounds, what is exposed for,
curves and backgrounds, the odd values more often. Prints how many were rendered, how many refused
(`InputError`: a light among the stones, a camera under the ground), and of the rest how many had samples
that were negative or not finite, how many a picture, noise or exposure that is not finite or negative, how
many were refused without a reason in one line that names a key, and how many ended in a traceback or a
warning that is not gemrender's; the longest time; and, with `--show`, the reasons of refusals, and each
set-up that was not as it should be. Exits with 1 if there was any.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np

import gemrender
from gemrender.cuts.bundled import bundled_stones
from gemrender.errors import GemrenderError, GemrenderWarning, InputError
from gemrender.optics import material_names
from gemrender.optics.metals import METALS
from gemrender.render.curves import CURVES
from gemrender.render.formats import Background
from gemrender.scene.settings.setting import SETTINGS
from gemrender.scene.setup import (
    CAMERAS,
    EXPOSURES,
    GIRDLES,
    GROUNDS,
    LIGHTS,
    POSES,
    SKIES,
    Box,
    Camera,
    Filters,
    Ground,
    Light,
    Setting,
    Setup,
    Sky,
    Thing,
    Zone,
)
from gemrender.scene.sky_boxes import SHAPES
from gemrender.scene.surfaces import COLOURED, FINISHED, FINISHES, MATERIALS
from gemrender.stone import Stone

#: Angles at which things are edge-on, upright or level [deg].
TELLING = (-90.0, -89.5, 0.0, 1e-6, 45.0, 89.5, 90.0)
#: What can come of a set-up, and which of it is as it should be.
RENDERED, REFUSED, LEFT_OUT, UNSOUND, UNCLEAR, TRACEBACK = OUTCOMES = (
    "rendered",
    "refused",
    "samples left out",
    "not finite or negative",
    "refused without a reason",
    "traceback",
)


def main() -> int:
    """Render set-ups; print the counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--setups", type=int, default=500)
    parser.add_argument("--first", type=int, default=0, help="number of the first set-up")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--size", type=int, default=32)
    parser.add_argument("--samples", type=int, default=2)
    parser.add_argument("--show", action="store_true")
    arguments = parser.parse_args()
    warnings.simplefilter("error")  # as of NumPy, where numbers overflow
    warnings.simplefilter("ignore", GemrenderWarning)  # that samples were left out is counted here
    counts: Counter[str] = Counter()
    reasons: Counter[str] = Counter()
    longest = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(arguments.first, arguments.first + arguments.setups):
            rng = np.random.default_rng([arguments.seed, number])
            drawn = {"setup": random_setup(rng, Path(folder)), **random_stones(rng)}
            started = time.perf_counter()
            found, reason = outcome(drawn, arguments.size, arguments.samples, number)
            longest = max(longest, time.perf_counter() - started)
            counts[found] += 1
            reasons[reason] += found == REFUSED
            if arguments.show and found not in (RENDERED, REFUSED):
                print(f"{number}: {found}: {reason}: {drawn}", flush=True)
            if arguments.show and sum(counts.values()) % 50 == 0:
                print(f"so far {dict(counts)}", file=sys.stderr, flush=True)
    wrong = arguments.setups - counts[RENDERED] - counts[REFUSED]
    if arguments.show:
        for reason, count in reasons.most_common():
            print(f"{count:4} refused: {reason}")
    print(", ".join(f"{name} {counts[name]}" for name in OUTCOMES), f"(longest {longest:.1f} s)")
    return int(wrong > 0)


def outcome(drawn: dict[str, Any], size: int, samples: int, seed: int) -> tuple[str, str]:
    """Render stones in a set-up; return what came of it, and why."""
    try:
        picture = gemrender.render(**drawn, size=size, spp=samples, seed=seed)
        exposure = picture.exposure
        picture.rgb8()
    except InputError as error:
        clear = error.key is not None and error.allowed and "\n" not in str(error)
        return (REFUSED, f"{error.key}: {error.allowed}") if clear else (UNCLEAR, repr(str(error)))
    except GemrenderError as error:
        return LEFT_OUT, str(error)
    except Exception:
        return TRACEBACK, traceback.format_exc()
    if picture.left_out:
        return LEFT_OUT, f"{picture.left_out}"
    parts = [picture.xyz, picture.albedo, picture.normal]
    front = picture.foreground
    if front is not None:
        parts += [front.xyz, front.albedo, front.normal, front.alpha]
    sound = all(np.isfinite(part).all() for part in parts) and picture.xyz[..., 1].min() >= 0
    sound &= np.isfinite(picture.noise) and picture.noise >= 0
    return (RENDERED if sound and np.isfinite(exposure) and exposure > 0 else UNSOUND), ""


def random_stones(rng: np.random.Generator) -> dict[str, Any]:
    """Return options of `gemrender.render` but the set-up: stones, and how they are pictured."""

    def one() -> Stone:
        stone = gemrender.load_stone(str(rng.choice(bundled_stones())))
        size = None if rng.uniform() < 0.7 else float(10 ** rng.uniform(-1, 3))
        index = float(rng.choice([1.05, 1.5, 4.0]))
        material = str(rng.choice(material_names())) if rng.uniform() < 0.8 else index
        return replace(stone, material=material, size_mm=size)

    lies = rng.spawn(1)[0]  # apart: set-ups of a number stay what they were
    return {
        "c_axis": None if lies.uniform() < 0.5 else lies.normal(size=3).tolist(),
        "stone": [one() for _ in range(rng.choice([1, 1, 1, 2, 3]))],
        "turn": float(rng.choice([0.0, rng.uniform(-360, 360)])),
        "dispersion": bool(rng.uniform() < 0.8),
        "background": str(rng.choice(tuple(Background))),
        "exposure": float(rng.choice([0.0, rng.uniform(-10, 10)])),
    }


def random_setup(rng: np.random.Generator, folder: Path) -> Setup:
    """Return a set-up drawn from all that are allowed; its files are in the folder."""
    while True:
        ground = str(rng.choice(GROUNDS))
        in_cup = ground == "cup"
        pose = "table-up" if in_cup else str(rng.choice(POSES))
        turned = rng.spawn(1)[0]
        held = not in_cup and pose != "table-down" and rng.uniform() < 0.5
        try:
            return Setup(
                name="random",
                pose=pose,
                facing=float(rng.uniform(-360, 360)),
                gap=float(10 ** rng.uniform(-2, 2)),
                girdle=str(rng.choice(GIRDLES)),
                camera=_camera(rng, above=ground in ("plane", "sweep") and rng.uniform() < 0.95),
                lights=tuple(_light(rng) for _ in range(rng.integers(0, 4))),
                sky=_sky(rng, folder),
                ground=Ground(
                    type=ground,
                    reflectance=float(rng.choice([0.0, 1.0, rng.uniform()])),
                    distance=float(10 ** rng.uniform(np.log10(3), 3)),
                ),
                setting=Setting(
                    type=str(rng.choice(SETTINGS[1:])) if held else "none",
                    metal=str(rng.choice(tuple(METALS))),
                    finish=str(rng.choice(FINISHES)),
                ),
                things=tuple(_thing(rng, folder) for _ in range(rng.choice([0, 0, 0, 1, 2]))),
                white=_spectrum(rng),
                expose_for=str(rng.choice(EXPOSURES)),
                curve=str(rng.choice(tuple(CURVES))),
                filters=Filters(
                    analyser=_filter(turned), polariser=_filter(turned), windows=1 + (turned.random() < 0.2)
                ),
            )
        except InputError:  # no light, or a lens that focuses behind itself
            continue


def _filter(rng: np.random.Generator) -> float | None:
    """Return the angle of a polarising filter, or none."""
    return None if rng.uniform() < 0.7 else float(rng.choice([0.0, 90.0, rng.uniform(-360, 360)]))


def _thing(rng: np.random.Generator, folder: Path) -> Thing:
    """Return a box, in part with holes, which most often stands beside the stones."""
    material = str(rng.choice(MATERIALS))
    corners = rng.uniform(0.01, 1, 3) * list(product((-1, 1), repeat=3))
    faces = np.array(_BOX)
    if material != "glass":  # which must be closed
        faces = faces[rng.uniform(size=len(faces)) < rng.choice([0.5, 1.0])]
    mesh = folder / f"thing-{rng.integers(1 << 30)}.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    mesh.write_text("\n".join([*lines, "f 1 2 3\n"] if not len(faces) else [*lines, ""]))
    x, y = float(rng.choice([2.0, 8.0, rng.uniform(-20, 20)])), float(rng.uniform(-6, 6))
    return Thing(
        mesh=str(mesh),
        material=material,
        finish=str(rng.choice(FINISHES)) if material in FINISHED else "polished",
        colour=_colour(rng) if material in COLOURED else None,
        place=(x, y, float(rng.choice([1.0, rng.uniform(-2, 8)]))),
        turn=float(rng.uniform(-360, 360)),
        scale=float(10 ** rng.uniform(-2, 1)),
        up=str(rng.choice(["z", "y"])),
    )


#: Triangles of a box, by its corners' numbers.
_BOX: Sequence[tuple[int, int, int]] = (
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
)  # fmt: skip


def _camera(rng: np.random.Generator, *, above: bool) -> Camera:
    distance = float(10 ** rng.uniform(0.4, 4))
    return Camera(
        type=str(rng.choice(CAMERAS)),
        elevation=abs(_elevation(rng)) if above else _elevation(rng),
        azimuth=float(rng.choice([0.0, 90.0, rng.uniform(-360, 360)])),
        distance=distance,
        margin=float(10 ** rng.uniform(-1, 1)),
        aperture=float(10 ** rng.uniform(-2, 2)),
        focus=float(rng.uniform(-1, 1)),
    )


def _sky(rng: np.random.Generator, folder: Path) -> Sky:
    kind = str(rng.choice(SKIES))
    turned: dict[str, Any] = {
        "azimuth": float(rng.uniform(-360, 360)),
        "scale": float(rng.choice([1.0, 10 ** rng.uniform(-6, 6)])),
    }
    if kind == "image":
        return Sky(type=kind, image=_image(rng, folder), **turned)
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


def _image(rng: np.random.Generator, folder: Path) -> str:
    """Write an image of noise, a few pixels of which are by far brighter, negative or black."""
    import OpenEXR

    rows = int(rng.choice([8, 9, 64]))
    pixels = 10 ** rng.uniform(-9, 3, (rows, 2 * rows, 3))
    pixels[rng.uniform(size=(rows, 2 * rows)) < 0.2] = 0
    pixels[rng.integers(rows), rng.integers(2 * rows)] = [1e6, 1e-6, 0]
    pixels[rng.integers(rows), rng.integers(2 * rows)] = -1
    path = folder / f"sky-{rng.integers(1 << 30)}.exr"
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

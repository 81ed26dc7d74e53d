"""Say in about a minute whether a Mitsuba variant works here, and how fast: one table.

    python scripts/check_variant.py --variant cuda_ad_spectral
    python scripts/check_variant.py --variant llvm_ad_mono [--stone inoue-3] [--seed 0] [--out picture.png]

White furnace (a stone in light of radiance 1 from everywhere cannot be seen), the cross-check with the
float64 reference, a picture, and the rays of `benchmark_rays.py`. What has a bar must keep it; what has none
tells how fast. Pictures are spectral: beside a variant that is not, its spectral sibling renders them. Exits
with 1 if anything is beyond its bar, and with 2 for a variant that there is not.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import gemrender
from gemrender.errors import GemrenderError, InputError
from gemrender.stone import Stone

#: Pixels a side of the furnace and samples a pixel: 0.3 million paths, whose noise is Russian roulette alone.
FURNACE_SIZE, FURNACE_SPP = 32, 256
#: Standard errors that the furnace may be off: 3 in a thousand are by chance, and the seed is fixed.
MOST_SIGMA = 3.0
#: Share of energy that may be lost or made where wavelengths part [%]; 60 000 paths tell it to 0.02 %.
MOST_COLOUR = 0.5
#: Pixels a side of the cross-check's map: 40 000 rays meet the stone, so that the reference takes seconds.
CROSSCHECK_SIZE = 256
#: Size and samples of the picture.
PICTURE_SIZE, PICTURE_SPP = 256, 16
#: Pixels a side of the timed map, and how often each way is timed.
RAYS_SIZE, REPEATS = 1024, 3
#: The engine's time by that of a bare loop which does the optics and nothing else: 1.2 on two free cores.
MOST_RATIO = 2.0


@dataclass(frozen=True, kw_only=True)
class Row:
    """A line of the table: what was found, what it must be, and whether it is; None where it need not."""

    check: str
    found: str
    bar: str = ""
    passes: bool | None = None


def main() -> int:
    """Run the checks and print their table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--variant", default="llvm_ad_spectral", metavar="NAME")
    parser.add_argument("--stone", default="inoue-3")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", help="write the picture there, to be looked at")
    arguments = parser.parse_args()
    try:
        stone = gemrender.load_stone(arguments.stone)
        rows = []
        for row in checks(arguments.variant, stone, arguments.seed, arguments.out):
            rows.append(row)
            if sys.stderr.isatty():
                print(f"\r{row.check:<70}", end="", file=sys.stderr, flush=True)
        if sys.stderr.isatty():
            print(f"\r{'':<70}\r", end="", file=sys.stderr, flush=True)
    except GemrenderError as error:
        print(f"check_variant: {error}", file=sys.stderr)
        return error.exit_status
    print_table(rows)
    return int(any(row.passes is False for row in rows))


def checks(variant: str, stone: Stone, seed: int, out: str | None) -> Iterator[Row]:
    """Yield the rows of the table, one check after the other."""
    started = time.perf_counter()
    mi = gemrender.mitsuba(variant)
    import drjit as dr

    spectral = "_".join([*variant.split("_")[:2], "spectral"])
    yield Row(check="variant", found=f"{variant}, Mitsuba {mi.__version__}, Dr.Jit {dr.__version__}")
    parts: dict[str, Callable[[], Iterator[Row]]] = {
        "white furnace": lambda: furnace(stone, seed),
        "cross-check": lambda: crosscheck(stone, variant),
        "principal rays": lambda: rays(stone),
        "white furnace in colour": lambda: colour(stone, spectral, seed),
        "picture": lambda: picture(stone, spectral, seed, out),
    }
    for name, check in parts.items():
        try:
            yield from check()
        except InputError:
            raise
        except Exception as error:  # what a variant lacks shows itself in many ways; the others go on
            told = " ".join(f"{type(error).__name__}: {error}".split())
            told = told if len(told) <= 100 else f"{told[:30]} ... {told[-65:]}"  # what and why
            yield Row(check=name, found=told, bar="works", passes=False)
    yield Row(check="time of all checks", found=f"{time.perf_counter() - started:.0f} s")


def furnace(stone: Stone, seed: int) -> Iterator[Row]:
    """Follow light through a stone without absorption, in the active variant: it comes back as radiance 1."""
    import drjit as dr
    import mitsuba as mi
    import numpy as np

    from gemrender.scene.loading import load_scene
    from gemrender.scene.mesh import placed_mesh
    from gemrender.scene.placing import place

    (placed,) = place([stone], pose="table-up", facing_deg=0, gap=1, azimuth_deg=0, sizes=[1.0])
    scene = load_scene(
        {
            "type": "scene",
            "integrator": {"type": "gem_path"},
            "light": {"type": "constant", "radiance": {"type": "uniform", "value": 1.0}},
            "stone": placed_mesh(placed, {"type": "gem_dielectric", "material": "diamond"}),
        }
    )
    n = FURNACE_SIZE**2 * FURNACE_SPP
    sampler = load_scene({"type": "independent"})
    sampler.seed(seed, n)
    ray = dr.zeros(mi.RayDifferential3f, n)
    across = 1.2 * sampler.next_2d() - 0.6
    ray.o, ray.d, ray.maxt = mi.Point3f(across.x, across.y, 10), mi.Vector3f(0, 0, -1), dr.largest(mi.Float)
    if mi.is_spectral:
        ray.wavelengths = mi.Spectrum(550.0)
    radiance, _, _ = scene.integrator().sample(scene, sampler, ray)
    values = np.array(radiance, dtype=np.float64).reshape(-1, n).mean(axis=0)
    off, error = values.mean() - 1, values.std(ddof=1) / np.sqrt(n)
    yield Row(
        check=f"white furnace, {n / 1e6:.2g} million paths",
        found=f"{100 * off:+.4f} %, {off / error:+.1f} standard errors",
        bar=f"within {MOST_SIGMA:g}",
        passes=bool(abs(off) <= MOST_SIGMA * error),
    )


def crosscheck(stone: Stone, variant: str) -> Iterator[Row]:
    """Follow the same rays by Mitsuba and by the reference."""
    from gemrender import crosscheck as of
    from gemrender.engines import observe_alike

    truth, by_mitsuba, *_ = observe_alike(stone, variant=variant, resolution=CROSSCHECK_SIZE)
    check = of.crosscheck(by_mitsuba, truth)
    what = f"cross-check, {check.rays} rays"
    yield Row(
        check=f"{what}: that end alike",
        found=f"{check.same_exit_short:.3f} %",
        bar=f"{of.LEAST_SAME_EXIT:g} % and more",
        passes=check.same_exit_short >= of.LEAST_SAME_EXIT,
    )
    for name, found, most in (
        ("Average", check.average, of.MOST_AVERAGE_DIFFERENCE),
        ("Rear", check.rear, of.MOST_REAR_DIFFERENCE),
    ):
        yield Row(
            check=f"{what}: {name} differs by",
            found=f"{found:+.4f}",
            bar=f"up to {most:g}",
            passes=abs(found) <= most,
        )
    yield Row(
        check=f"{what}: all its tolerances",
        found="; ".join(check.failures) or "kept",
        bar="kept",
        passes=not check.failures,
    )


def rays(stone: Stone) -> Iterator[Row]:
    """Time principal rays in the active variant."""
    from benchmark_rays import BARE, ENGINE, time_rays

    found = time_rays(stone, RAYS_SIZE, REPEATS, only=(BARE, ENGINE))
    yield Row(check="principal rays", found=f"{found.rate(ENGINE):.3g} M segments/s")
    yield Row(
        check="principal rays, time by a bare loop's",
        found=f"{found.ratio(ENGINE):.2f}",
        bar=f"up to {MOST_RATIO:g}",
        passes=found.ratio(ENGINE) <= MOST_RATIO,
    )


def colour(stone: Stone, variant: str, seed: int) -> Iterator[Row]:
    """Render a stone under a sky that is the same from everywhere: the picture is white all over."""
    import numpy as np

    from gemrender.scene.setup import Camera, Setup, Sky

    camera = Camera(type="orthographic", elevation=90, margin=0.5)
    everywhere = Setup(name="furnace", sky=Sky(radiance=1.0, spectrum="e"), camera=camera, expose_for="light")
    shown = gemrender.render(
        stone,
        everywhere,
        material="diamond",
        size=FURNACE_SIZE,
        spp=FURNACE_SPP // 4,
        variant=variant,
        seed=seed,
    )
    off = 100 * (shown.xyz.reshape(-1, 3).mean(axis=0, dtype=np.float64) - 1)
    yield Row(
        check="white furnace in colour, wavelengths parting",
        found=f"X {off[0]:+.2f} %, Y {off[1]:+.2f} %, Z {off[2]:+.2f} %",
        bar=f"within {MOST_COLOUR:g} %",
        passes=bool(np.abs(off).max() <= MOST_COLOUR),
    )


def picture(stone: Stone, variant: str, seed: int, out: str | None) -> Iterator[Row]:
    """Render a picture twice: no sample is other than light, and one seed makes one picture."""
    import numpy as np

    shown, again = (
        gemrender.render(stone, "studio", size=PICTURE_SIZE, spp=PICTURE_SPP, variant=variant, seed=seed)
        for _ in range(2)
    )
    what = f"picture, {PICTURE_SIZE} x {PICTURE_SIZE}, {variant}"
    differ = int(np.any(shown.xyz != again.xyz, axis=2).sum())
    yield Row(check=f"{what}: pixels that differ, same seed", found=f"{differ}", bar="0", passes=differ == 0)
    sound = bool(np.isfinite(shown.xyz).all()) and shown.left_out == 0
    yield Row(check=f"{what}: samples that are no light", found=f"{shown.left_out}", bar="0", passes=sound)
    rate = PICTURE_SIZE**2 * PICTURE_SPP / again.seconds / 1e6
    yield Row(check=f"{what}: speed", found=f"{rate:.3g} M samples/s")
    if out is not None:
        yield Row(check="written", found=str(shown.save(out)))


def print_table(rows: list[Row]) -> None:
    """Print the rows as a table in Markdown, which is read as it is, too."""
    words = {True: "yes", False: "NO", None: ""}
    cells = [
        ("check", "found", "bar", "passes"),
        *((row.check, row.found, row.bar, words[row.passes]) for row in rows),
    ]
    widths = [max(len(line[k]) for line in cells) for k in range(4)]
    cells.insert(1, tuple("-" * width for width in widths))  # type: ignore[arg-type]
    for line in cells:
        print("| " + " | ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) + " |")


if __name__ == "__main__":
    sys.exit(main())

"""How fast the Mitsuba engine follows principal rays, against a bare loop in the same run.

    python scripts/benchmark_rays.py [--resolution 2048] [--repeats 7] [--stone inoue-3]
                                     [--variant llvm_ad_mono] [--quick]

Prints ratios, since shared machines are noisy: the engine against a bare loop over
`scene.ray_intersect` that does the same optics and nothing else (single precision, no facet numbers, no
maps); what a second stone costs in new kernels; whole processes; and the peak memory of a large map.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from gemrender.cuts import load_stone
from gemrender.cuts.random import random_brilliant
from gemrender.engines import DEFAULT_VARIANT
from gemrender.observation import LIGHT_LEVEL, MOST_REFLECTIONS, Model, View
from gemrender.render import observe as engine
from gemrender.render.backend import ensure_variant
from gemrender.scene import stone_scene
from gemrender.stone import Stone

_OFFSET = 2e-6  # of the bare loop's rays, inwards along the normal


@dr.syntax
def bare_loop(scene, x, y, index):  # type: ignore[no-untyped-def]  # dr.syntax reads the source
    """Intensity and rear mask by the shortest code that does the optics."""
    si = scene.ray_intersect(mi.Ray3f(mi.Point3f(x, y, 10), mi.Vector3f(0, 0, -1)))
    inside = si.is_valid()
    cos_eye = si.n.z
    cos_stone = dr.sqrt(1 - (1 - cos_eye * cos_eye) / (index * index))
    direction = dr.select(inside, mi.Vector3f(0, 0, -1) / index + si.n * (cos_eye / index - cos_stone), 0)
    origin = dr.select(inside, si.p - si.n * _OFFSET, 0)
    factor = transmitted(cos_eye, cos_stone, index) * cos_stone / cos_eye
    reflections = mi.UInt32(0)
    intensity, rear = mi.Float(0), mi.Bool(False)
    while dr.hint(inside, label="bare loop"):
        si = scene.ray_intersect(mi.Ray3f(origin, direction), inside)
        hit = inside & si.is_valid()
        cos_in = dr.dot(direction, si.n)
        sin2 = index * index * (1 - cos_in * cos_in)
        exits = hit & (sin2 < 1)
        cos_out = dr.safe_sqrt(1 - sin2)
        value = LIGHT_LEVEL * factor * transmitted(cos_out, cos_in, index) * cos_out / cos_in
        from_below = si.p.z <= 0
        intensity = dr.select(exits & ~from_below, value, intensity)
        rear |= exits & from_below
        inside = hit & ~exits & (reflections < MOST_REFLECTIONS)
        direction = dr.select(inside, direction - 2 * cos_in * si.n, direction)
        origin = dr.select(inside, si.p - si.n * _OFFSET, origin)
        reflections[inside] += 1
    return intensity, rear, reflections


def transmitted(cos_air: mi.Float, cos_stone: mi.Float, index: mi.Float) -> mi.Float:
    """Fresnel's transmittance for unpolarised light."""
    r_s = (cos_air - index * cos_stone) / (cos_air + index * cos_stone)
    r_p = (index * cos_air - cos_stone) / (index * cos_air + cos_stone)
    return 1 - 0.5 * (r_s * r_s + r_p * r_p)


#: What `time_rays` calls the bare loop, and the engine's own part.
BARE, ENGINE = "bare loop", "sensor and gem_primary"


@dataclass(frozen=True, kw_only=True)
class RayTimes:
    """How long each way took [s], by its name; segments that rays have in all; and scores of two ways.

    Scores are Average and Rear [%], by the bare loop and by the engine.
    """

    seconds: dict[str, list[float]]
    segments: int
    average: tuple[float, float]
    rear: tuple[float, float]

    def rate(self, name: str) -> float:
        """Return millions of segments a second, at best."""
        return self.segments / min(self.seconds[name]) / 1e6

    def ratio(self, name: str) -> float:
        """Return the best time by the bare loop's."""
        return min(self.seconds[name]) / min(self.seconds[BARE])


def time_rays(stone: Stone, resolution: int, repeats: int, *, only: tuple[str, ...] = ()) -> RayTimes:
    """Time the bare loop, the plugins, the maps and `mi.render`, or `only` some, taking turns.

    They run in the active variant.
    """
    view, model = View.of(stone, resolution), Model.of(stone, fresnel="exact")
    scene: Any = mi.load_dict(stone_scene(stone, view, model))
    with_all: Any = mi.load_dict(stone_scene(stone, view, model, follow="all"))
    sampler: Any = mi.load_dict({"type": "independent"})
    step = 2 / resolution
    pixel = dr.arange(mi.UInt32, resolution * resolution)
    index = dr.opaque(mi.Float, model.index)

    def bare() -> Any:
        x = (mi.Float(pixel % resolution) + 0.5) * step - 1
        y = 1 - (mi.Float(pixel // resolution) + 0.5) * step
        found = bare_loop(scene, x, y, index)
        dr.eval(found)
        return found

    def render() -> None:
        dr.eval(mi.render(scene, spp=1))

    def all_light() -> None:
        sampler.seed(1, resolution * resolution)
        ray = engine.film_rays(with_all.sensors()[0])
        dr.eval(with_all.integrator().measure(with_all, ray, sampler))

    runs: dict[str, Callable[[], Any]] = {
        BARE: bare,
        ENGINE: lambda: engine.follow(scene, engine.film_rays(scene.sensors()[0])),
        "the same, all light": all_light,
        "observe, all maps": lambda: engine.observe(stone, view, model, variant=mi.variant()),
        "mi.render, 15 channels": render,
    }
    runs = {name: run for name, run in runs.items() if not only or name in only}
    seconds: dict[str, list[float]] = {name: [] for name in runs}
    for turn in range(repeats + 1):
        for name, run in runs.items():
            start = time.perf_counter()
            run()
            dr.sync_thread()
            if turn:  # the first turn compiles
                seconds[name].append(time.perf_counter() - start)

    intensity, rear, reflections = (np.array(a) for a in bare())
    observation = engine.observe(stone, view, model, variant=mi.variant())
    covered = int(np.count_nonzero(observation.coverage))
    return RayTimes(
        seconds=seconds,
        segments=covered * 2 + int(reflections.sum()),
        average=(
            float(intensity.sum()) / covered,
            float(observation.primary_intensity.sum()) / covered,
        ),
        rear=(100 * float(rear.sum()) / covered, 100 * float(observation.rear_mask.sum()) / covered),
    )


def ray_benchmark(stone: Stone, resolution: int, repeats: int) -> None:
    """Print the times of `time_rays`."""
    found = time_rays(stone, resolution, repeats)
    print(
        f"{stone.name}, {resolution} x {resolution} rays, {found.segments / 1e6:.1f} M segments, "
        f"{mi.variant()}"
    )
    print(f"  {'':<24}{'median':>9}{'lowest':>9}{'M seg/s':>9}{'ratio of medians':>18}{'of lowest':>11}")
    base = statistics.median(found.seconds[BARE])
    for name, times in found.seconds.items():
        middle = statistics.median(times)
        print(
            f"  {name:<24}{middle:>7.3f} s{min(times):>7.3f} s{found.rate(name):>9.1f}"
            f"{middle / base:>18.2f}{found.ratio(name):>11.2f}"
        )
    print(
        f"  Average: bare loop {found.average[0]:.3f}, engine {found.average[1]:.3f}; "
        f"Rear: {found.rear[0]:.3f}, {found.rear[1]:.3f}"
    )


def kernel_benchmark(stone: Stone, resolution: int) -> None:
    """Count the kernels that further stones and another index compile."""
    view, model = View.of(stone, resolution), Model.of(stone, fresnel="exact")
    engine.observe(stone, view, model, variant=mi.variant())
    rng = np.random.default_rng(1)
    others = [Stone.from_proportions(random_brilliant(rng)) for _ in range(5)]
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        for other in others:
            engine.observe(other, view, model, variant=mi.variant())
        engine.observe(stone, view, Model(index=1.77, fresnel="exact"), variant=mi.variant())
        kernels = [k for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT]
    compiled = sum(not k["cache_hit"] for k in kernels)
    print(f"5 further stones and another index: {len(kernels)} kernels run, {compiled} compiled")


def process_benchmark(repeats: int) -> None:
    """Time whole processes, kernel cache warm."""
    for words in (["--help"], ["score", "inoue-3"]):
        times = []
        for turn in range(repeats + 1):
            start = time.perf_counter()
            subprocess.run([sys.executable, "-m", "gemrender", *words], check=True, capture_output=True)
            if turn:
                times.append(time.perf_counter() - start)
        print(
            f"gemrender {' '.join(words)}: median {statistics.median(times):.2f} s, lowest {min(times):.2f} s"
        )


def memory_benchmark(stone: str, resolution: int) -> None:
    """Print the peak memory of a process that traces a large map."""
    code = (
        "import gemrender, json, resource, sys;"
        f"o = gemrender.observe(gemrender.load_stone({stone!r}), resolution={resolution});"
        "print(json.dumps([o.seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss]))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    seconds, kib = json.loads(done.stdout)
    print(f"{resolution} x {resolution}: {seconds:.1f} s, peak memory {kib / 2**20:.2f} GiB")


def main() -> None:
    """Run what the options ask for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--stone", default="inoue-3")
    parser.add_argument("--resolution", type=int, default=2048)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--variant", default=DEFAULT_VARIANT)
    parser.add_argument("--quick", action="store_true", help="leave out processes and memory")
    options = parser.parse_args()
    ensure_variant(options.variant)
    stone = load_stone(options.stone)
    ray_benchmark(stone, options.resolution, options.repeats)
    kernel_benchmark(stone, 512)
    if not options.quick:
        process_benchmark(options.repeats)
        memory_benchmark(options.stone, 4096)


if __name__ == "__main__":
    main()

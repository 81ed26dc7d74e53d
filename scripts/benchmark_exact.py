"""Time the exact engine beside the others, in one run; ratios count, since machines differ and are noisy.

python scripts/benchmark_exact.py [--repeats 7] [--stones 200] [--seed 1] [--quick]
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_context
from typing import Any

import numpy as np

from gemrender.beam import measure, prepare, trace_facets
from gemrender.engines import observe
from gemrender.observation import Measurement, Model
from gemrender.score import score_pixels
from gemrender.stone import RoundBrilliant, Stone, load_stone

MODEL = Model(fresnel="exact")
RESOLUTIONS = (256, 512, 1024, 2048, 4096)
#: Seeds that an exact error is taken over, and random stones that it is looked at.
SEEDS, ERROR_STONES = 6, 9


def cut(rng: np.random.Generator, number: int) -> Stone:
    """Draw a stone with a crown of 25 to 40 and a pavilion of 38 to 44 degrees."""
    ranges = {
        "table": (50, 65), "crown_angle": (25, 40), "pavilion_angle": (38, 44), "star": (45, 60),
        "lower_half": (70, 85), "girdle_thickness": (1, 5),
    }  # fmt: skip
    drawn = {key: float(rng.uniform(*span)) for key, span in ranges.items()}
    return Stone.from_proportions(RoundBrilliant.from_angles(**drawn), name=f"cut {number}")


def seconds(run: Callable[[], Any], repeats: int) -> float:
    """Median time of a call [s]; the first one does not count."""
    times = []
    for _ in range(repeats + 1):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return float(np.median(times[1:]))


def one_stone(repeats: int) -> None:
    """Time the three engines on sample 3."""
    stone = load_stone("inoue-3")
    found = measure(stone, model=MODEL)
    exact = seconds(lambda: measure(stone, model=MODEL), 3 * repeats)
    print(f"inoue-3, exact within {found.bound:.4f}, one core: {1e3 * exact:.2f} ms (wanted: 5)")
    for words, whole in (("a sixteenth of the view", False), ("the whole view", True)):
        polygons = seconds(partial(trace_facets, stone, model=MODEL, whole=whole), 3 * repeats)
        print(f"  its polygons alone, {words}: {1e3 * polygons:.2f} ms")
    for engine, resolution in (("mitsuba", 1024), ("mitsuba", 2048), ("reference", 512)):
        trace = partial(observe, stone, engine=engine, resolution=resolution, fresnel="exact")
        other = seconds(trace, min(repeats, 3))
        print(
            f"  {engine} at {resolution}, all cores: {1e3 * other:.0f} ms, {other / exact:.0f} times as long"
        )


def many_stones(stones: list[Stone]) -> None:
    """Time random stones one by one."""
    times, bounds = [], []
    for stone in stones:
        start = time.perf_counter()
        bounds.append(measure(stone, model=MODEL).bound)
        times.append(1e3 * (time.perf_counter() - start))
    within = 100 * np.mean(np.array(times) <= 20)
    print(
        f"{len(stones)} stones, bound 0.05: median {np.median(times):.1f} ms (wanted: 20), "
        f"mean {np.mean(times):.1f}, 90 % {np.percentile(times, 90):.1f}, longest {max(times):.0f}; "
        f"{within:.0f} % within 20 ms; largest bound {max(bounds):.3f}"
    )


def equal_error(stones: list[Stone], repeats: int) -> None:
    """Compare the times that the exact engine and Mitsuba take to the same error, stone by stone.

    The error of the exact engine is the root mean square over some seeds, of Average and Rear together; that
    of Mitsuba's maps over the resolutions, along the law that it follows: resolution to the - 3/2. Its time
    grows as the number of pixels.
    """
    print("Equal error, exact Fresnel, default bound; time of Mitsuba to the exact engine's error:")
    heads = (
        f"{'girdle':>8}{'exact error':>13}{'exact ms':>10}{'Mitsuba at':>12}{'Mitsuba ms':>12}{'ratio':>8}"
    )
    print(f"  {'':<16}{heads}")
    ratios = []
    for stone in stones:
        truth = measure(stone, model=MODEL, bound=0.001, seed=99)

        def off(average: float, rear: float, truth: Measurement = truth) -> float:
            return float(np.hypot(average - truth.average, rear - truth.rear) / np.sqrt(2))

        runs = [measure(stone, model=MODEL, seed=seed) for seed in range(SEEDS)]
        error = float(np.sqrt(np.mean([off(run.average, run.rear) ** 2 for run in runs])))
        taken = seconds(partial(measure, stone, model=MODEL), repeats)
        scaled, pixels_a_second = [], 0.0
        for resolution in RESOLUTIONS:
            trace = partial(observe, stone, engine="mitsuba", fresnel="exact", resolution=resolution)
            if stone is stones[0]:
                trace()  # compiles
            start = time.perf_counter()
            pixels = score_pixels(trace())
            pixels_a_second = resolution**2 / (time.perf_counter() - start)
            scaled.append(off(pixels.average, pixels.rear) * resolution**1.5)
        needed = (float(np.sqrt(np.mean(np.square(scaled)))) / error) ** (2 / 3)
        mitsuba = needed**2 / pixels_a_second
        ratios.append(mitsuba / taken)
        print(
            f"  {stone.name:<16}{truth.girdle:>6.2f} %{error:>13.5f}{1e3 * taken:>10.2f}{needed:>12.0f}"
            f"{1e3 * mitsuba:>12.0f}{ratios[-1]:>8.0f}"
        )
    print(f"  median ratio {np.median(ratios):.0f}, lowest {min(ratios):.0f} (wanted: 100)")


def _score_many(stones: list[Stone]) -> int:
    for stone in stones:
        measure(stone, model=MODEL)
    return len(stones)


def _score_seeds(seeds: list[int]) -> int:
    return _score_many([cut(np.random.default_rng(seed), seed) for seed in seeds])


def throughput(number: int) -> None:
    """Count stones a second by one thread, by threads and by processes."""
    cores = os.cpu_count() or 1
    stones = [cut(np.random.default_rng(seed), seed) for seed in range(number)]
    rates = {}
    start = time.perf_counter()
    _score_many(stones)
    rates["one thread"] = number / (time.perf_counter() - start)
    start = time.perf_counter()
    with ThreadPoolExecutor(cores) as pool:
        list(pool.map(_score_many, [stones[i::cores] for i in range(cores)]))
    rates[f"{cores} threads"] = number / (time.perf_counter() - start)
    with ProcessPoolExecutor(cores, mp_context=get_context("spawn"), initializer=prepare) as pool_:
        list(pool_.map(_score_seeds, [[0]] * cores))  # they load
        start = time.perf_counter()
        list(pool_.map(_score_seeds, [list(range(number))[i::cores] for i in range(cores)]))
        rates[f"{cores} processes"] = number / (time.perf_counter() - start)
    words = ", ".join(f"{rate:.0f} by {name}" for name, rate in rates.items())
    print(f"Stones a second (wanted: 100): {words}")


def processes(repeats: int) -> None:
    """Time whole processes, caches warm, and one with numba's cache cold."""
    base = [sys.executable, "-m", "gemrender"]
    for words in (
        ["--help"],
        ["score", "inoue-3", "--engine", "exact"],
        ["score", "inoue-3", "--engine", "mitsuba"],
    ):
        taken = seconds(partial(subprocess.run, [*base, *words], check=True, capture_output=True), repeats)
        print(f"gemrender {' '.join(words)}: {taken:.2f} s")
    with tempfile.TemporaryDirectory() as empty:
        start = time.perf_counter()
        subprocess.run(
            [*base, "score", "inoue-3", "--engine", "exact"],
            check=True,
            capture_output=True,
            env={**os.environ, "NUMBA_CACHE_DIR": empty},
        )
        print(f"gemrender score inoue-3 --engine exact, compiling: {time.perf_counter() - start:.1f} s")


def main() -> None:
    """Run what the options ask for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--stones", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help="leave out equal errors and whole processes")
    options = parser.parse_args()
    start = time.perf_counter()
    prepare()
    print(f"kernels ready in {time.perf_counter() - start:.2f} s (wanted: 1, from the cache)")
    rng = np.random.default_rng(options.seed)
    stones = [cut(rng, number) for number in range(options.stones)]
    one_stone(options.repeats)
    many_stones(stones)
    if not options.quick:
        samples = [load_stone(f"inoue-{number}") for number in (1, 2, 3)]
        equal_error([*samples, *stones[:ERROR_STONES]], options.repeats)
    throughput(2 * options.stones)
    if not options.quick:
        processes(min(options.repeats, 5))


if __name__ == "__main__":
    main()

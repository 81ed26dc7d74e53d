"""Time the exact engine beside the others, in one run; ratios count, since machines differ and are noisy.

python scripts/benchmark_exact.py [DESIGN ...] [--repeats 7] [--stones 200] [--seed 1] [--quick]

Designs are stone files of any kind, scored face-up and tilted by 15 degrees.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from typing import Any

import numpy as np

from gemrender.beam import BOUND_RANGE, beam_stone, measure, prepare, trace_facets
from gemrender.beam.rays import (
    COS_ENTRY,
    DIRECTION,
    INSIDE,
    STATUS,
    Rays,
    chosen_rays,
    empty_rays,
    enter_rays,
    follow_rays,
)
from gemrender.beam.solid import BeamStone
from gemrender.cuts import RoundBrilliant, load_stone
from gemrender.engines import DEFAULT_BOUND, observe
from gemrender.observation import Model, View
from gemrender.processors import usable_processors
from gemrender.scoring import score_pixels
from gemrender.stone import Stone

MODEL = Model(fresnel="exact")
RESOLUTIONS = (256, 512, 1024, 2048, 4096)
#: Seeds that an exact error is taken over, and random stones that it is looked at.
SEEDS, ERROR_STONES = 16, 9
#: Bound of what is taken for the truth, and how far at least below the default score's own [%].
TRUTH, BELOW = 0.001, 20
#: How errors of maps fall with the resolution, and how their time grows.
ERROR_POWER, TIME_POWER = -1.5, 2.0


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


@contextmanager
def one_core() -> Iterator[str]:
    """Keep to one core, where the system can (Linux); the words for it."""
    if not hasattr(os, "sched_setaffinity"):
        yield "one thread"
        return
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(cores)})
    try:
        yield "one core"
    finally:
        os.sched_setaffinity(0, cores)


def loading() -> None:
    """Time the first score of this process, and the rest of the kernels."""
    stone = load_stone("inoue-3")
    start = time.perf_counter()
    measure(stone, model=MODEL)
    first = time.perf_counter() - start
    prepare()
    every = time.perf_counter() - start
    print(f"first score of a process {first:.2f} s, all kernels {every:.2f} s (wanted: 1, from the cache)")
    if every > 3:
        print("  they were compiled, or the machine is busy: run again")


def one_stone(repeats: int) -> None:
    """Time the three engines on sample 3."""
    stone = load_stone("inoue-3")
    found = measure(stone, model=MODEL)
    with one_core() as where:
        exact = seconds(lambda: measure(stone, model=MODEL), 5 * repeats)
        print(
            f"inoue-3, exact within {found.bound:.4f}, {found.rays} rays, {where}: {1e3 * exact:.2f} ms "
            f"(median of {5 * repeats}; wanted: 5)"
        )
        parts: dict[str, Callable[[], Any]] = {
            "its planes": lambda: beam_stone(stone),
            "its polygons, a sixteenth of the view": lambda: trace_facets(stone, model=MODEL, whole=False),
            "its polygons, the whole view": lambda: trace_facets(stone, model=MODEL, whole=True),
        }
        for words, run in parts.items():
            print(f"  {words}, alone: {1e3 * seconds(run, 5 * repeats):.2f} ms")
    for resolution in (1024, 2048):
        trace = partial(observe, stone, engine="mitsuba", resolution=resolution, fresnel="exact")
        other = seconds(trace, min(repeats, 3))
        print(
            f"  mitsuba at {resolution}, all cores: {1e3 * other:.0f} ms, {other / exact:.0f} times as long"
        )
    other = observe(stone, engine="reference", resolution=512, fresnel="exact").seconds
    print(f"  reference at 512, once: {1e3 * other:.0f} ms, {other / exact:.0f} times as long")


def girdle_rays(stone: Stone, number: int) -> tuple[BeamStone, Rays]:
    """Return rays all over a stone's tilted view, as they have entered it."""
    ready, view = beam_stone(stone), View(resolution=1, tilt_deg=30, tilt_azimuth_deg=10)
    places, rays = np.random.default_rng(1).uniform(-1, 1, (number, 2)), empty_rays(number)
    enter_rays(places, view.basis(), ready.solid, ready.facet, MODEL.index, rays)
    return ready, chosen_rays(rays, np.flatnonzero(rays.facts[STATUS] == INSIDE))


def single_rays(repeats: int) -> None:
    """Time single rays: segments from surface to surface a second, by one core and by all of them.

    Beside it numpy's matrix product of as many rays and planes, which the machine's speed can be told by.
    """
    cores = usable_processors()
    ready, inside = girdle_rays(load_stone("fish-eye"), 200_000)

    def follow(part: np.ndarray) -> int:
        rays = chosen_rays(inside, part)
        return int(follow_rays(ready.solid, ready.facet, MODEL.index, MODEL.max_reflections, rays))

    every_ray = np.flatnonzero(inside.facts[STATUS] == INSIDE)
    parts = np.array_split(every_ray, 4 * cores)
    met = follow(every_ray)
    with one_core() as where:
        one = seconds(lambda: follow(every_ray), repeats)
        normals = np.ascontiguousarray(ready.solid.values[:, :3].T)
        directions = np.ascontiguousarray(inside.numbers[DIRECTION:COS_ENTRY, every_ray].T)
        product = seconds(lambda: directions @ normals, repeats) * met / len(every_ray)
    with ThreadPoolExecutor(cores) as threads:
        every = seconds(lambda: list(threads.map(follow, parts)), repeats)
    each = met / len(every_ray)
    print(f"single rays, {each:.1f} segments each, M segments a second (wanted: 40 by all cores):")
    print(f"  {met / one / 1e6:.1f} by {where}, {met / every / 1e6:.1f} by {cores} threads")
    print(f"  a segment takes {one / product:.2f} times as long as numpy's products of a ray and all normals")


def designs(stones: Sequence[Stone], repeats: int) -> None:
    """Time designs on one core."""
    tilted = View(resolution=1, tilt_deg=15, tilt_azimuth_deg=90)
    with one_core() as where:
        print(
            f"Designs in their own materials, bound {DEFAULT_BOUND:g}, {where} (wanted: 30 ms; tilted 150):"
        )
        for stone in stones:
            ready, row = beam_stone(stone), f"  {stone.name:<30}{stone.solid.n_facets:>4} facets"
            for view in (None, tilted):
                found = measure(ready, view=view)
                taken = 1e3 * seconds(partial(measure, ready, view=view), repeats)
                row += f"{taken:>9.1f} ms, {len(found.sizes):>6} virtual facets, {found.rays} rays"
            print(row)


def many_stones(stones: Sequence[Stone]) -> None:
    """Time random stones one by one."""
    times = 1e3 * np.array([seconds(partial(measure, stone, model=MODEL), 3) for stone in stones])
    found = [measure(stone, model=MODEL) for stone in stones]
    print(
        f"{len(stones)} stones, bound {DEFAULT_BOUND:g}: median {np.median(times):.1f} ms (wanted: 20), "
        f"mean {times.mean():.1f}, 90 % {np.percentile(times, 90):.1f}, longest {times.max():.0f}; "
        f"{100 * np.mean(times <= 20):.1f} % within 20 ms; largest bound "
        f"{max(one.bound for one in found):.4f}, most rays {max(one.rays for one in found)}"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """Errors and times of two engines on one stone.

    Attributes
    ----------
    name : str
        The stone.
    girdle, bound : float
        Share of the view that rays tell, and bound of what both are compared with [%].
    exact_error, exact_seconds : float
        Root mean square over seeds, of Average and Rear [%], and mean time [s].
    errors, times : (r,) float64
        Mitsuba's at each of `RESOLUTIONS`: of Average and Rear together [%], and [s].
    """

    name: str
    girdle: float
    bound: float
    exact_error: float
    exact_seconds: float
    errors: np.ndarray
    times: np.ndarray


def compare(stone: Stone, repeats: int) -> Compared:
    """Measure errors and times of the exact engine at its default bound, and of Mitsuba."""
    default = measure(stone, model=MODEL)
    tight = max(min(TRUTH, default.bound / BELOW), BOUND_RANGE[0])
    truth = measure(stone, model=MODEL, bound=tight, seed=99)

    def off(average: float, rear: float) -> float:
        return float(np.hypot(average - truth.average, rear - truth.rear) / np.sqrt(2))

    runs = [measure(stone, model=MODEL, seed=seed) for seed in range(1, SEEDS + 1)]
    # How many rays are needed depends on the seed: so do both, the error and the time.
    taken = [
        seconds(partial(measure, stone, model=MODEL, seed=seed), repeats) for seed in range(1, SEEDS + 1)
    ]
    errors, times = [], []
    for resolution in RESOLUTIONS:
        trace = partial(observe, stone, engine="mitsuba", fresnel="exact", resolution=resolution)
        pixels = score_pixels(trace())
        errors.append(off(pixels.average, pixels.rear))
        times.append(seconds(lambda trace=trace: score_pixels(trace()), 3))  # type: ignore[misc]
    return Compared(
        name=stone.name,
        girdle=truth.girdle,
        bound=truth.bound,
        exact_error=float(np.sqrt(np.mean([off(run.average, run.rear) ** 2 for run in runs]))),
        exact_seconds=float(np.mean(taken)),
        errors=np.array(errors),
        times=np.array(times),
    )


def needed_by_mitsuba(error: float, errors: np.ndarray, times: np.ndarray) -> tuple[float, float, str]:
    """Return the resolution at which Mitsuba reaches an error, its time there [s], and a mark.

    The resolution is that of the law `ERROR_POWER`, fitted to all errors, since a single map's may be small
    by luck. Times are interpolated, and beyond the resolutions looked at extrapolated by `TIME_POWER`: "*".
    """
    scaled = errors / np.power(RESOLUTIONS, ERROR_POWER, dtype=float)
    resolution = float((error / np.sqrt(np.mean(scaled**2))) ** (1 / ERROR_POWER))
    for end in (0, -1):
        beyond = resolution / RESOLUTIONS[end]
        if (beyond < 1) if end == 0 else (beyond > 1):
            return resolution, float(times[end] * beyond**TIME_POWER), "*"
    return resolution, float(np.exp(np.interp(np.log(resolution), np.log(RESOLUTIONS), np.log(times)))), " "


def equal_error(stones: Sequence[Stone], repeats: int) -> None:
    """Compare the times that the exact engine and Mitsuba take to the same error, each stone, and all."""
    print(f"Equal error, exact Fresnel, bound {DEFAULT_BOUND:g}: time of Mitsuba to the exact engine's error")
    print(
        f"  {'':<16}{'girdle':>9}{'truth within':>14}{'exact error':>13}{'exact ms':>10}{'Mitsuba at':>12}"
        f"{'Mitsuba ms':>12}{'ratio':>9}"
    )
    found, ratios = [], []
    for stone in stones:
        found.append(compare(stone, repeats))
        ratios.append(_print_compared(found[-1]))
    print(f"  median ratio {np.median(ratios):.0f}, lowest {min(ratios):.0f} (wanted: 100); * extrapolated")
    together = Compared(
        name="all of them",
        girdle=float(np.mean([one.girdle for one in found])),
        bound=max(one.bound for one in found),
        exact_error=float(np.sqrt(np.mean([one.exact_error**2 for one in found]))),
        exact_seconds=float(np.mean([one.exact_seconds for one in found])),
        errors=np.sqrt(np.mean([one.errors**2 for one in found], axis=0)),
        times=np.mean([one.times for one in found], axis=0),
    )
    print("  The same by root mean squares of errors, and means of times, over the stones:")
    _print_compared(together)
    power = np.polyfit(np.log(RESOLUTIONS), np.log(together.errors), 1)[0]
    print(f"  Mitsuba, error as the resolution to the {power:.2f}:")
    for resolution, error, taken in zip(RESOLUTIONS, together.errors, together.times, strict=True):
        print(f"    at {resolution:>4}: error {error:.5f}, {1e3 * taken:.0f} ms")


def _print_compared(one: Compared) -> float:
    """Print a line of the table; return the ratio of times."""
    resolution, taken, mark = needed_by_mitsuba(one.exact_error, one.errors, one.times)
    ratio = taken / one.exact_seconds
    print(
        f"  {one.name:<16}{one.girdle:>7.2f} %{one.bound:>14.5f}{one.exact_error:>13.5f}"
        f"{1e3 * one.exact_seconds:>10.2f}{resolution:>11.0f}{mark}{1e3 * taken:>12.0f}{ratio:>9.0f}"
    )
    return ratio


def _score_many(seeds: Sequence[int]) -> int:
    """Make and score stones one after the other."""
    for seed in seeds:
        measure(cut(np.random.default_rng(seed), seed), model=MODEL)
    return len(seeds)


def throughput(number: int) -> None:
    """Count stones made and scored in a second by one core, by threads and by processes; median of three."""
    cores = usable_processors()
    start = time.perf_counter()
    for seed in range(number):
        cut(np.random.default_rng(seed), seed)
    made = (time.perf_counter() - start) / number
    seeds = range(number)
    shares = [seeds[i::cores] for i in range(cores)]

    def rate(run: Callable[[], Any]) -> float:
        return number / seconds(run, 3)

    rates = {}
    with one_core() as where:
        rates[where] = rate(lambda: _score_many(seeds))
    rates["one thread, all cores for stones of many rays"] = rate(lambda: _score_many(seeds))
    with ThreadPoolExecutor(cores) as threads:
        rates[f"{cores} threads"] = rate(lambda: list(threads.map(_score_many, shares)))
    with ProcessPoolExecutor(cores, mp_context=get_context("spawn"), initializer=prepare) as workers:
        rates[f"{cores} processes"] = rate(lambda: list(workers.map(_score_many, shares)))
    best = max(rates, key=rates.__getitem__)
    print(f"Stones a second, made and scored, {number} of them (wanted: 500): {rates[best]:.0f} by {best}")
    for name, value in rates.items():
        print(f"  {value:.0f} by {name}")
    print(f"  of which to make a stone of its proportions takes {1e3 * made:.2f} ms (wanted: 0.5)")


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
        print(f"gemrender score inoue-3 --engine exact, compiling: {time.perf_counter() - start:.1f} s, once")


def main() -> None:
    """Run what the options ask for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("designs", nargs="*", metavar="DESIGN", help="stone files to time as well")
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--stones", type=int, default=200, help="random stones; for rates twice as many")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help="leave out equal errors and whole processes")
    options = parser.parse_args()
    loading()
    rng = np.random.default_rng(options.seed)
    stones = [cut(rng, number) for number in range(options.stones)]
    single_rays(options.repeats)
    if options.designs:
        designs([load_stone(path) for path in options.designs], options.repeats)
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

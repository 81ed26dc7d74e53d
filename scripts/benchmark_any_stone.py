"""Time stones of every cut: making and reading them, scoring them exactly, single rays, whole processes.

    python scripts/benchmark_any_stone.py [--only NAME ...] [--repeats 9] [--seed 1] [--before FOLDER]

Each line has a figure, what is wanted, and their ratio: above 1 it is better than wanted. Times are medians;
beside them stand the lowest, and the least that the processor took. For what runs on one core the latter
makes the ratio: other programs spoil it least. What runs on more is timed by the clock, and needs a quiet
machine; the first line tells how quiet it is. Mitsuba's `gem_primary` against a bare
loop is timed by `benchmark_rays.py`, the exact engine against the others by `benchmark_exact.py`.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from benchmark_exact import one_core

from gemrender.beam import beam_stone, measure, prepare
from gemrender.beam.rays import INSIDE, STATUS, Rays, chosen_rays, empty_rays, enter_rays, follow_rays
from gemrender.cuts import RoundBrilliant, load_stone
from gemrender.cuts.random import random_brilliant
from gemrender.observation import MOST_REFLECTIONS, View
from gemrender.processors import usable_processors
from gemrender.stone import Stone

DESIGNS = Path(__file__).parents[1] / "tests" / "cases" / "stones"
ENDINGS = {".asc", ".gem", ".gcs"}
PROCESSES = 2
#: Facets of an ordinary design: those must be scored sooner.
ORDINARY = range(60, 101)
#: Rays a side of the map that rays are timed on, rays that are followed together, and their index.
RAYS_A_SIDE, RAYS_A_BLOCK, INDEX = 512, 1 << 13, 2.42
#: Stones that rates are taken over.
RATE_STONES = 1000
#: What another version is asked for: the median and the lowest time of a score [s].
SCORE_OF_BEFORE = """
import sys, time, gemrender
from gemrender.beam import measure
stone, times = gemrender.load_stone("inoue-3"), []
for _ in range(int(sys.argv[1]) + 2):
    start = time.perf_counter(), time.process_time()
    measure(stone)
    times.append((time.perf_counter() - start[0], time.process_time() - start[1]))
times = times[2:]
print(sorted(t for t, _ in times)[len(times) // 2], min(t for t, _ in times), min(c for _, c in times))
"""


@dataclass(frozen=True, slots=True)
class Times:
    """Times of a call: their median, the lowest, and the least time of the processor [s]."""

    median: float
    lowest: float
    processor: float


def times(run: Callable[[], Any], repeats: int) -> Times:
    """Time a call; the first two do not count."""
    wall, processor = [], []
    for _ in range(repeats + 2):
        start = time.perf_counter(), time.process_time()
        run()
        wall.append(time.perf_counter() - start[0])
        processor.append(time.process_time() - start[1])
    return Times(float(np.median(wall[2:])), min(wall[2:]), min(processor[2:]))


class Table:
    """Lines of results on standard output; what is under way, on standard error."""

    def __init__(self) -> None:
        self._is_terminal = sys.stderr.isatty()
        self.missed: list[str] = []
        print(f"{'':<58}{'figure':>12}{'wanted':>12}{'ratio':>8}")

    def doing(self, what: str) -> None:
        """Say what is under way."""
        if self._is_terminal:
            sys.stderr.write(f"\r\x1b[K{what} ...")
            sys.stderr.flush()

    def line(self, what: str, figure: str, wanted: str = "", ratio: float | None = None) -> None:
        """Write a line; a ratio below 1 misses what is wanted."""
        if self._is_terminal:
            sys.stderr.write("\r\x1b[K")
        mark = "" if ratio is None else f"{ratio:.2f}"
        print(f"{what:<58}{figure:>12}{wanted:>12}{mark:>8}", flush=True)
        if ratio is not None and ratio < 1:
            self.missed.append(what)

    def time(self, what: str, found: Times, wanted: float | None = None) -> None:
        """Write a time on one core beside the one wanted [s]; the processor's decides."""
        self.line(
            f"{what} (lowest {_unit(found.lowest)}, processor {_unit(found.processor)})",
            _unit(found.median),
            "" if wanted is None else _unit(wanted),
            None if wanted is None else wanted / found.processor,
        )


def _unit(seconds: float) -> str:
    return f"{1e3 * seconds:.2f} ms" if seconds < 1 else f"{seconds:.2f} s"


# ---- What is timed -------------------------------------------------------------------------------------


def busy(table: Table, options: argparse.Namespace) -> None:
    """Tell how much of a core a process gets now."""
    start = time.perf_counter(), time.process_time()
    total = 0
    for number in range(20_000_000):
        total += number
    share = (time.process_time() - start[1]) / (time.perf_counter() - start[0])
    table.line("share of a core that this process gets", f"{100 * share:.0f} %")


def brilliant(table: Table, options: argparse.Namespace) -> None:
    """Make a round brilliant of its proportions."""
    rng = np.random.default_rng(options.seed)
    proportions = [random_brilliant(rng) for _ in range(100)]

    def make() -> None:
        for each in proportions:
            beam_stone.cache_clear()
            Stone.from_proportions(RoundBrilliant(**{key: getattr(each, key) for key in each.__slots__}))

    with one_core():
        found = times(make, options.repeats)
    one = Times(*(value / len(proportions) for value in (found.median, found.lowest, found.processor)))
    table.time("making a round brilliant", one, 0.5e-3)


def sample(table: Table, options: argparse.Namespace) -> None:
    """Score inoue-3, in turns with an earlier version if one is named."""
    stone, repeats = load_stone("inoue-3"), 5 * options.repeats
    now, before = [], []
    with one_core():
        for _ in range(4):
            now.append(times(lambda: measure(stone), repeats))
            if options.before:
                done = subprocess.run(
                    [sys.executable, "-c", SCORE_OF_BEFORE, str(repeats)],
                    check=True,
                    capture_output=True,
                    text=True,
                    env={**os.environ, "PYTHONPATH": options.before, "NUMBA_CACHE_DIR": options.before_cache},
                )
                before.append(Times(*map(float, done.stdout.split())))
    wanted = min((each.processor for each in before), default=None)
    table.time("scoring inoue-3", _together(now), wanted)
    if before:
        table.time("  the earlier version", _together(before))


def _together(found: list[Times]) -> Times:
    return Times(
        float(np.median([each.median for each in found])),
        min(each.lowest for each in found),
        min(each.processor for each in found),
    )


def designs(table: Table, options: argparse.Namespace) -> None:
    """Read and score each design of the cases, in its own index, within the default bound, on one core."""
    with one_core():
        for path in sorted(path for path in DESIGNS.iterdir() if path.suffix in ENDINGS):
            table.doing(path.name)
            reading = times(partial(load_stone, path), options.repeats)
            # Each score is that of a stone just read: whose corners and symmetry nobody has asked for.
            stones = iter([load_stone(path) for _ in range(options.repeats + 2)])
            scoring = times(lambda stones=stones: measure(next(stones)), options.repeats)  # type: ignore[misc]
            facets = len(load_stone(path).facets)
            wanted = 0.030 if facets in ORDINARY else 0.150
            table.time(f"{path.name}, {facets} facets: scored", scoring, wanted)
            table.time("  read", reading)


def _brilliants(seed: int, number: int) -> int:
    """Make and score random brilliants."""
    rng = np.random.default_rng(seed)
    for _ in range(number):
        measure(Stone.from_proportions(random_brilliant(rng)))
    return number


def rate(table: Table, options: argparse.Namespace) -> None:
    """Make and score random round brilliants in two processes."""
    pieces = 4 * PROCESSES
    jobs = [(options.seed + piece, RATE_STONES // pieces) for piece in range(pieces)]
    with get_context("spawn").Pool(PROCESSES, initializer=prepare) as pool:
        pool.starmap(_brilliants, [(0, 20)] * pieces)  # everything loaded
        best, taken = 0.0, []
        for _ in range(3):
            start = time.perf_counter()
            number = sum(pool.starmap(_brilliants, jobs, chunksize=1))
            taken.append(number / (time.perf_counter() - start))
            best = max(best, taken[-1])
    table.line(
        f"random brilliants made and scored, {PROCESSES} processes (best {best:.0f}/s)",
        f"{np.median(taken):.0f}/s",
        "500/s",
        best / 500,
    )


def rays(table: Table, options: argparse.Namespace) -> None:
    """Follow single rays of the whole view, on one core and on all."""
    cores = usable_processors()
    for name in ("inoue-3", DESIGNS / "emerald.asc"):
        stone = load_stone(name)
        ready, view = beam_stone(stone), View.of(stone, RAYS_A_SIDE)
        x, y = view.cell_centres()
        points = np.stack(np.broadcast_arrays(x, y[:, None]), axis=-1).reshape(-1, 2)
        rays = empty_rays(len(points))
        enter_rays(points, view.basis(), ready.solid, ready.facet, INDEX, rays)
        follow = partial(_follow, ready.solid, ready.facet)
        segments = sum(map(follow, _blocks(rays)))

        def rates(run: Callable[[list[Rays]], Any], rays: Rays = rays) -> Times:
            copies = iter([_blocks(rays) for _ in range(options.repeats + 2)])
            return times(lambda: run(next(copies)), options.repeats)

        with one_core():
            one = rates(lambda blocks: [follow(block) for block in blocks])  # noqa: B023
        with ThreadPoolExecutor(cores) as threads:
            every = rates(lambda blocks: list(threads.map(follow, blocks)))  # noqa: B023
        millions = segments / 1e6
        table.line(
            f"single rays, {stone.name}, {millions:.1f} M segments: one core "
            f"(processor {millions / one.processor:.0f} M/s)",
            f"{millions / one.lowest:.0f} M/s",
        )
        table.line(
            f"  {cores} threads (processor {cores * millions / every.processor:.0f} M/s)",
            f"{millions / every.lowest:.0f} M/s",
            "40 M/s",
            millions / every.lowest / 40,
        )


def _blocks(rays: Rays) -> list[Rays]:
    """Return copies of the rays that are inside."""
    inside = np.flatnonzero(rays.facts[STATUS] == INSIDE)
    parts = np.array_split(inside, -(-len(inside) // RAYS_A_BLOCK))
    return [chosen_rays(rays, part) for part in parts]


def _follow(solid: Any, facet: np.ndarray, rays: Rays) -> int:
    return int(follow_rays(solid, facet, INDEX, MOST_REFLECTIONS, rays))


def processes(table: Table, options: argparse.Namespace) -> None:
    """Start the command line."""
    compiled = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    words = [sys.executable, "-m", "gemrender", "--help"]
    run = partial(subprocess.run, words, check=True, capture_output=True, env=compiled)
    taken = []
    for _ in range(options.repeats + 1):
        start = time.perf_counter(), _children()
        run()
        taken.append((time.perf_counter() - start[0], _children() - start[1]))
    wall, processor = np.array(taken[1:]).T
    found = Times(float(np.median(wall)), wall.min(), processor.min())
    table.time("gemrender --help", found, 0.2)


def _children() -> float:
    """Processor's time that ended processes have taken [s]."""
    used = os.times()
    return used.children_user + used.children_system


def first(table: Table, options: argparse.Namespace) -> None:
    """Score for the first time on a machine, compiling; then another cut, which must compile nothing."""
    base = [sys.executable, "-m", "gemrender", "score"]
    with tempfile.TemporaryDirectory() as folder:
        run = partial(
            subprocess.run, check=True, capture_output=True, env={**os.environ, "NUMBA_CACHE_DIR": folder}
        )
        for name, words in (("inoue-3", ["inoue-3"]), ("a design", [str(DESIGNS / "emerald.asc")])):
            before, start = _files(folder), (time.perf_counter(), _children())
            run([*base, *words])
            taken, processor = time.perf_counter() - start[0], _children() - start[1]
            new = _files(folder) - before
            is_first = name == "inoue-3"
            table.line(
                f"gemrender score {name}, {'nothing compiled before' if is_first else 'next'} "
                f"(processor {processor:.1f} s)",
                f"{taken:.1f} s",
                "10.0 s" if is_first else "",
                10 / taken if is_first else None,
            )
            if is_first:
                table.line("  compiled kernels kept", str(len(new)))
            else:
                table.line("  compiled anew for another cut", str(len(new)), "0", 1.0 if not new else 0.0)


def _files(folder: str) -> set[str]:
    return {path.name for path in Path(folder).rglob("*.nbc")}


PARTS: dict[str, Callable[[Table, argparse.Namespace], None]] = {
    "busy": busy, "brilliant": brilliant, "sample": sample, "designs": designs, "rate": rate, "rays": rays,
    "processes": processes, "first": first,
}  # fmt: skip


def main() -> int:
    """Run what the options ask for; what was timed before Ctrl-C stands."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS), metavar="NAME",
                        help=f"some of {', '.join(PARTS)}")  # fmt: skip
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--before", metavar="FOLDER", help="a checkout of an earlier version, for inoue-3")
    options = parser.parse_args()
    table = Table()
    try:
        with ExitStack() as stack:
            options.before_cache = stack.enter_context(tempfile.TemporaryDirectory())
            table.doing("loading kernels")
            prepare()
            for name in options.only:
                table.doing(name)
                PARTS[name](table, options)
    except KeyboardInterrupt:
        sys.stderr.write("\nstopped\n")
        return 130
    print(f"missed: {'; '.join(table.missed) or 'nothing'}; gem_primary: benchmark_rays.py")
    return 0


if __name__ == "__main__":
    sys.exit(main())

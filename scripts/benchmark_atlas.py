"""Time atlases of random round brilliants: a Sobol design of six parameters, on two processes.

    python scripts/benchmark_atlas.py [--stones 2000] [--processes 2] [--dask]
    python scripts/benchmark_atlas.py --stones 50000 --dask       some 12 minutes on two cores

The first line tells how quiet the machine is, which the clock needs. For each case there are

- stones a second of all processes, what is wanted of two cores, and their ratio, from when every process has
  done its first stones, so that their start is left out; and how long a million stones take, extrapolated;
- linear in cores: that rate over what one process does with some of the stones, of so many processes;
- what share the exact engine alone has of a stone's time in that process: the rest is what the atlas adds;
- the most memory that a process has taken.

With `--dask` up to 20000 stones of the first case are measured by as many workers of a Dask cluster on this
machine, and once more without Dask: how much longer they take is what Dask adds.
"""

from __future__ import annotations

import argparse
import os
import resource
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from gemrender.sweep.atlas import AtlasPlan, make_atlas, read_plan
from gemrender.sweep.atlas.chunk import chunk_values

PLAN = """
stone = "gia-excellent"
measures = "{measures}"
bound = {bound}
[vary]
table = "50:66"
crown_angle = "30:38"
pavilion_angle = "39:43"
star = "40:65"
lower_half = "65:90"
girdle_thickness = "1:5"
[sobol]
number = {number}
seed = 1
"""
#: Measures, bound [%], and stones a second that are wanted of two cores.
CASES = (("inoue", 0.05, 500.0), ("inoue, iso, aset", 0.2, 50.0))
#: One process is timed on this share of the stones, and on so many at the least; the engine alone on so many.
SHARE, FEWEST, ALONE = 25, 200, 200
#: Most stones that Dask is timed on.
DASK = 20_000
#: Rates are counted from this share of the stones on.
WARM = 0.02


@dataclass(frozen=True, kw_only=True)
class Run:
    """Stones a second by the clock, and this process's own time for a stone [s]."""

    rate: float
    each: float


def planned(measures: str, bound: float, number: int, workers: int) -> AtlasPlan:
    """Return the plan of so many stones, in chunks of which every worker has several."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "plan.toml")
        path.write_text(PLAN.format(measures=measures, bound=bound, number=number))
        plan = read_plan(path)
    return replace(plan, chunk=min(plan.chunk, max(number // (4 * workers), 1)))


def timed(plan: AtlasPlan, workers: int, **options: Any) -> Run:
    """Make an atlas, and count from when each worker has done its first stones."""
    share = max(WARM, workers * plan.chunk / plan.stones if "dask" in options else 0.0)
    began = [0.0, 0.0, 0.0]

    def begin(done: float) -> None:
        if done >= share and not began[2]:
            began[:] = time.perf_counter(), time.process_time(), done

    with tempfile.TemporaryDirectory() as folder:
        make_atlas(plan, str(Path(folder, "a.zarr")), progress=begin, **options)
        took, own = time.perf_counter() - began[0], time.process_time() - began[1]
    stones = (1.0 - began[2]) * plan.stones
    return Run(rate=stones / took, each=own / stones)


def engine_seconds(plan: AtlasPlan) -> float:
    """Return this process's time for a stone, measured by the engine alone [s]."""
    stones = [plan.made(setting) for setting in plan.sample(ALONE)]
    start = time.process_time()
    for stone in stones:
        chunk_values(plan, stone, (0.0, 0.0))
    return (time.process_time() - start) / len(stones)


def most_memory() -> float:
    """Return the most memory that this process, or one that has ended, has taken [GiB]."""
    unit = 2**30 if sys.platform == "darwin" else 2**20
    return (
        max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        / unit
    )


def main() -> None:
    """Time the cases, and print what was found of each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--stones", type=int, default=2000)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--dask", action="store_true", help="time workers of a Dask cluster, too")
    options = parser.parse_args()
    stones, processes = options.stones, options.processes
    busy = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    print(f"{os.cpu_count()} cores{busy}; {stones} stones, {processes} processes", flush=True)
    for measures, bound, wanted in CASES:
        few = planned(measures, bound, max(stones // SHARE, FEWEST), 1)
        timed(planned(measures, bound, FEWEST // 10, 1), 1, processes=1)  # what happens once in a process
        one = timed(few, 1, processes=1)
        alone = engine_seconds(few)
        run = timed(planned(measures, bound, stones, processes), processes, processes=processes)
        print(
            f"{measures}, bound {bound:g}: {run.rate:.1f} a second, wanted {wanted:g}, ratio "
            f"{run.rate / wanted:.2f}; a million, extrapolated: {1e6 / run.rate / 3600:.2f} h"
        )
        print(
            f"  linear in cores: rate of {processes} processes / rate of 1 = {run.rate:.1f} / {one.rate:.1f} "
            f"= {run.rate / one.rate:.2f} of {processes}"
        )
        print(
            f"  engine alone: {1e3 * alone:.2f} of {1e3 * one.each:.2f} ms a stone, "
            f"{100 * min(alone / one.each, 1):.0f} %; most memory of a process {most_memory():.2f} GiB",
            flush=True,
        )
        if options.dask and measures == CASES[0][0]:
            plan = planned(measures, bound, min(stones, DASK), processes)
            by_dask = timed(plan, processes, dask=f"local:{processes}")
            without = timed(plan, processes, processes=processes)
            print(
                f"  by Dask, {plan.stones} stones: {by_dask.rate:.1f} a second, without it "
                f"{without.rate:.1f}: Dask adds {100 * (without.rate / by_dask.rate - 1):.1f} %",
                flush=True,
            )


if __name__ == "__main__":
    main()

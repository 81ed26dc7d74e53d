"""Time atlases of random round brilliants: a Sobol design of six parameters, on two threads.

    python scripts/benchmark_atlas.py [--stones 2000] [--threads 2] [--dask]

Each line has stones a second by the clock, what is wanted, and their ratio; the clock needs a quiet machine,
and the first line tells how quiet it is. Beside it stand the processors' time for a stone, which other
programs spoil less, and what share of that the same stones take of the exact engine alone, one after the
other in one thread: the rest is what the atlas adds. The last column is how long a million stones take at
that rate. With `--dask` the same is done by as many workers on this machine, their start left out.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from gemrender.sweep.atlas import make_atlas
from gemrender.sweep.atlas.chunk import chunk_values
from gemrender.sweep.atlas.plan import AtlasPlan
from gemrender.sweep.atlas.plan_file import read_plan

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
#: Stones that the engine alone is timed on.
ALONE = 200


def processor_seconds() -> float:
    """Return the time that processors have spent on this process and on those that have ended [s]."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def engine_seconds(plan: AtlasPlan) -> float:
    """Return the processor's time for a stone, made and measured by the engine alone [s]."""
    stones = [plan.made(setting) for setting in plan.sample(ALONE)]
    start = time.process_time()
    for stone in stones:
        chunk_values(plan, stone, (0.0, 0.0))
    return (time.process_time() - start) / len(stones)


def main() -> None:
    """Time the cases, and print a line for each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--stones", type=int, default=2000)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--dask", action="store_true", help="workers of a Dask cluster in place of threads")
    options = parser.parse_args()
    busy = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    print(f"{os.cpu_count()} cores{busy}; {options.threads} {'workers' if options.dask else 'threads'}")
    for measures, bound, wanted in CASES:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "plan.toml")
            path.write_text(PLAN.format(measures=measures, bound=bound, number=options.stones))
            plan = replace(read_plan(path), chunk=max(options.stones // (8 * options.threads), 1))
            alone = engine_seconds(plan)
            began = [0.0, 0.0, 0.0]

            def begin(share: float, began: list[float] = began) -> None:
                """Begin to count after the first chunk, when everything is loaded and started."""
                if share > 0 and not began[2]:
                    began[:] = time.perf_counter(), processor_seconds(), share

            dask = f"local:{options.threads}" if options.dask else None
            threads = None if options.dask else options.threads
            make_atlas(plan, str(Path(folder, "a.zarr")), threads=threads, dask=dask, progress=begin)
            took, processors = time.perf_counter() - began[0], processor_seconds() - began[1]
            stones = (1.0 - began[2]) * plan.stones
            rate, each = stones / took, processors / stones
            beside = "" if options.dask else (
                f"; processors {1e3 * each:.1f} ms a stone, {100 * min(alone / each, 1):.0f} % of it "
                "the engine"
            )  # fmt: skip
            print(
                f"{measures:<18} bound {bound:<5g} {rate:8.1f} a second, wanted {wanted:g}, ratio "
                f"{rate / wanted:.2f}{beside}; a million: {1e6 / rate / 3600:.1f} h",
                flush=True,
            )


if __name__ == "__main__":
    main()

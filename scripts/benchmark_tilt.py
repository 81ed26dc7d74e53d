"""Time tilt studies: 61 poses about x, -30 to 30 degrees, to a bound of 0.1, on two cores.

    python scripts/benchmark_tilt.py [--repeats 3] [--cores 2] [--processes]

Each line has the lowest time by the clock, what is wanted, and their ratio: above 1 it is better than wanted.
The clock needs a quiet machine; the first line tells how quiet it is. Beside it stands what the processors
took, shared evenly by the cores: the least that the clock can show where they are free. Kernels are loaded
before, and nothing is started: threads do the work, unless `--processes` asks for processes, whose start is
then in the times.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path
from unittest import mock

from gemrender.cuts import load_stone
from gemrender.engines import require_engine
from gemrender.stone import Stone
from gemrender.sweep import TiltStudy, study_tilt

DESIGNS = Path(__file__).parents[1] / "tests" / "cases" / "stones"
THREE = "inoue,iso,aset"
#: Stone, measures, and the time that is wanted [s].
CASES = (("inoue-3", "inoue", 1.5), ("inoue-3", THREE, 5.0), (str(DESIGNS / "emerald.asc"), THREE, 10.0))


def processor_seconds() -> float:
    """Return the time that processors have spent on this process and on those that it has started [s]."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def timed(stone: Stone, measures: str, cores: int) -> tuple[float, float, TiltStudy]:
    """Study a stone; return the time by the clock, that of the processors [s], and the study."""
    start = time.perf_counter(), processor_seconds()
    study = study_tilt(stone, measures=measures, processes=cores)
    return time.perf_counter() - start[0], processor_seconds() - start[1], study


def main() -> None:
    """Time the cases, and print a line for each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--processes", action="store_true", help="processes in place of threads")
    options = parser.parse_args()
    busy = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    print(f"{os.cpu_count()} cores{busy}; {options.cores} {'processes' if options.processes else 'threads'}")
    few = 0 if options.processes else 200
    for name, measures, wanted in CASES:
        stone = load_stone(name)
        require_engine("exact", stones=[stone])
        study_tilt(stone, measures=measures, to_deg=2.0, step_deg=2.0, processes=1)
        with mock.patch("gemrender.sweep.tilt.FEW", few):
            runs = [timed(stone, measures, options.cores) for _ in range(options.repeats)]
        clock = min(run[0] for run in runs)
        shared = min(run[1] for run in runs) / options.cores
        worst = max(found.bound(of.name) for found in runs[0][2].found for of in runs[0][2].measures)
        print(
            f"{stone.name:16} {measures:16} {clock:6.2f} s, wanted {wanted:4.1f} s: "
            f"ratio {wanted / clock:5.2f}; processors {shared:5.2f} s: {wanted / shared:5.2f}; "
            f"worst bound {worst:.3f}",
            flush=True,
        )


if __name__ == "__main__":
    main()

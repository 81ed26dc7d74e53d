"""Render one picture again and again, in several processes at once, and count how many come out different.

    python scripts/check_reproducibility.py [--renders 200] [--processes 3] [--renders-a-process 10]
                                            [--stone inoue-3] [--setups window] [--size 16] [--samples 2]
                                            [--seed 0] [--threads 0] [--variant llvm_ad_spectral]

Each process renders some pictures of the same seed, loading the scene anew for each, and ends; others take
its place until all are rendered. An outcome is all that is in a picture (XYZ, albedo, normal, coverage and
the noise) and in the maps of the stone's score, bit for bit. `--threads 1 2 3` gives the processes those
numbers of threads by turns (0: as many as there are cores). Exits with 1 if any set-up has more than one
outcome.
"""

from __future__ import annotations

import argparse
import hashlib
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import numpy as np


def main() -> int:
    """Count the outcomes of each set-up."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--renders", type=int, default=200)
    parser.add_argument("--processes", type=int, default=3)
    parser.add_argument("--renders-a-process", type=int, default=10)
    parser.add_argument("--stone", default="inoue-3")
    parser.add_argument("--setups", nargs="+", default=["window"])
    parser.add_argument("--size", type=int, default=16)
    parser.add_argument("--samples", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, nargs="+", default=[0])
    parser.add_argument("--variant", default="llvm_ad_spectral")
    parser.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.worker:
        for digest in outcomes(arguments):
            print(digest, flush=True)
        return 0
    most = 0
    for setup in arguments.setups:
        started = time.perf_counter()
        counts = count(arguments, setup)
        most = max(most, len(counts))
        print(
            f"{setup}: {counts.total()} renders, {arguments.processes} processes at once, "
            f"{len(counts)} outcome{'s' if len(counts) > 1 else ''} "
            f"({', '.join(f'{digest}: {n}' for digest, n in counts.most_common())}), "
            f"{time.perf_counter() - started:.0f} s",
            flush=True,
        )
    return int(most > 1)


def count(arguments: argparse.Namespace, setup: str) -> Counter[str]:
    """Render a set-up in fresh processes; count its outcomes."""
    a_process = arguments.renders_a_process
    parts = [min(a_process, arguments.renders - first) for first in range(0, arguments.renders, a_process)]
    common = [sys.executable, __file__, "--worker", "--setups", setup, "--stone", arguments.stone]
    for key in ("size", "samples", "seed", "variant"):
        common += [f"--{key}", str(getattr(arguments, key))]

    def run(numbered: tuple[int, int]) -> list[str]:
        number, renders = numbered
        threads = arguments.threads[number % len(arguments.threads)]
        command = [*common, "--renders", str(renders), "--threads", str(threads)]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.split()

    with ThreadPoolExecutor(arguments.processes) as pool:
        return Counter(digest for digests in pool.map(run, enumerate(parts)) for digest in digests)


def outcomes(arguments: argparse.Namespace) -> list[str]:
    """Render in this process; return a digest of each picture and the maps beside it."""
    from gemrender.cuts import load_stone
    from gemrender.observation import MAP_CHANNELS, View
    from gemrender.render.backend import ensure_variant
    from gemrender.render.observe import observe
    from gemrender.render.photoreal import make_gems, render
    from gemrender.scene.setup import load_setup

    ensure_variant(arguments.variant)
    import drjit as dr

    if arguments.threads[0]:
        dr.set_thread_count(arguments.threads[0])
    stone = load_stone(arguments.stone)
    gems, setup = make_gems([stone]), load_setup(arguments.setups[0])
    observed = observe(stone, View.of(stone, 8 * arguments.size))
    maps = hashlib.sha256()
    for name in MAP_CHANNELS:
        maps.update(np.ascontiguousarray(getattr(observed, name)).tobytes())
    digests = []
    for _ in range(arguments.renders):
        picture = render(
            gems,
            setup,
            width=arguments.size,
            height=arguments.size,
            spp=arguments.samples,
            seed=arguments.seed,
            variant=arguments.variant,
        )
        digest = maps.copy()
        for values in (picture.xyz, picture.albedo, picture.normal, picture.coverage, picture.noise):
            digest.update(np.ascontiguousarray(values).tobytes())
        digests.append(digest.hexdigest()[:12])
    return digests


if __name__ == "__main__":
    sys.exit(main())

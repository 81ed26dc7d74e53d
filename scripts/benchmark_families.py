"""Time every family of cuts: making a stone, and scoring it exactly in diamond, on one core.

    python scripts/benchmark_families.py [FAMILY ...] [--members 3] [--repeats 5] [--seed 1] [--bound 0.05]

Of each family the stone of its defaults is timed, and some random ones from all over its range, each as new:
nothing of it has been asked for before. Times are the least that the processor took, since other programs
spoil that least; beside them stand their ratios to inoue-3's, which is timed in the same run, and how many
virtual facets (of the whole view) and planes a stone has. The exit status is 1 where a default misses what is
wanted.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from benchmark_exact import one_core

from gemrender.beam import beam_stone, measure, prepare
from gemrender.cuts import load_stone
from gemrender.cuts.families import families
from gemrender.cuts.random import random_member
from gemrender.observation import Model
from gemrender.stone import Stone

#: Wanted of every family's defaults: to make a stone, and to score it [s].
MAKING, SCORING = 5e-3, 100e-3
DIAMOND = Model()


def least(run: Callable[[Any], Any], fresh: Callable[[], Any], repeats: int) -> float:
    """Return the least processor time that `run` takes for what `fresh` makes each time anew [s]."""
    taken = []
    for _ in range(repeats + 1):  # the first one does not count
        made, start = fresh(), time.process_time()
        run(made)
        taken.append(time.process_time() - start)
    return min(taken[1:])


class Table:
    """Lines of times, with their ratios to those of a first stone, inoue-3."""

    def __init__(self, repeats: int, bound: float) -> None:
        self._repeats, self._bound = repeats, bound
        self._first: tuple[float, float] | None = None
        print(
            f"{'':<28}{'planes':>7}{'facets':>8}{'bound':>9}{'making ms':>11}{'ratio':>7}"
            f"{'scoring ms':>12}{'ratio':>7}"
        )

    def time(self, name: str, make: Callable[[], Stone]) -> tuple[float, float]:
        """Time making and scoring a stone, and write a line; return both [s]."""
        making = least(lambda _: make(), lambda: None, 4 * self._repeats)
        found = measure(make(), model=DIAMOND, bound=self._bound)
        score = partial(measure, model=DIAMOND, bound=self._bound)
        scoring = least(score, make, self._repeats)
        self._first = self._first or (making, scoring)
        ratios = making / self._first[0], scoring / self._first[1]
        print(
            f"{name:<28}{len(beam_stone(make()).solid.planes):>7}{len(found.sizes):>8}{found.bound:>9.4f}"
            f"{1e3 * making:>11.2f}{ratios[0]:>7.1f}{1e3 * scoring:>12.2f}{ratios[1]:>7.1f}",
            flush=True,
        )
        return making, scoring


def main() -> int:
    """Time what the options ask for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("families", nargs="*", metavar="FAMILY", help="some of them; by default all")
    parser.add_argument("--members", type=int, default=3, help="random members of each")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bound", type=float, default=0.05, help="wanted error bound [%%]")
    options = parser.parse_args()
    known = families()
    for name in options.families:
        if name not in known:
            parser.error(f"{name} is no family; there are {', '.join(known)}")
    prepare()
    missed, random_scoring = [], []
    with one_core():
        table = Table(options.repeats, options.bound)
        table.time("inoue-3", lambda: load_stone("inoue-3"))
        for name in options.families or known:
            kind = known[name]
            making, scoring = table.time(name, lambda kind=kind: kind().stone())  # type: ignore[misc]
            if making > MAKING or scoring > SCORING:
                missed.append(name)
            rng = np.random.default_rng(options.seed)
            for number in range(options.members):
                member = random_member(kind, rng)
                random_scoring.append(table.time(f"  random {number + 1}", member.stone)[1])
    if random_scoring:
        print(
            f"random members scored: median {1e3 * np.median(random_scoring):.0f} ms, "
            f"longest {1e3 * max(random_scoring):.0f}, "
            f"{100 * np.mean(np.array(random_scoring) <= SCORING):.0f} % within {1e3 * SCORING:.0f} ms"
        )
    print(
        f"wanted of defaults: made in {1e3 * MAKING:g} ms, scored in {1e3 * SCORING:g} ms; missed: "
        f"{', '.join(missed) or 'nothing'}"
    )
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())

"""Check that the exact engine's bounds of all measures hold: many seeds against converged runs.

    python scripts/check_bounds.py [--stones 50] [--seeds 20] [--turns 4] [--bound 0.1] [--truth 0.005]
                                   [--longest 10] [--seed 1] [--tilt 20] [--journal FILE]

Random stones of several materials: round brilliants, step cuts, faceters' designs, and convex solids with
faces anywhere; each seen face-up and tilted. A value is outside when it differs from that of a converged run
of another seed by more than both bounds together. Each stone is also turned by random angles, the tilted eye
with it, which may change nothing beyond the bounds either. Shares that make a whole must make 100.

At most 0.5 % of the values of a measure may be outside the bounds, which are stated at 99.9 %; if more are,
or shares do not make 100, the exit status is 1. With a journal it can be stopped at any time and goes on.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.beam import Budget, measure
from gemrender.cuts import load_stone
from gemrender.cuts.families import families
from gemrender.cuts.random import random_brilliant
from gemrender.errors import InputError
from gemrender.journal import Journal
from gemrender.measures import Measure, measures
from gemrender.observation import Measurement, View
from gemrender.stone import Facet, Stone, convex_solid, in_frame, side_of

DESIGNS = Path(__file__).parents[1] / "tests" / "cases" / "stones"
#: What stones are made of at random; every other round brilliant is of diamond.
MATERIALS = ("diamond", "quartz", "spinel", "sapphire", "cubic zirconia", "moissanite", "rutile")
#: Largest share of values outside their bounds that is let pass.
ALLOWED = 0.005
#: Shares that make a whole make 100 within this [%].
WHOLE = 1e-6
#: Where nothing is random, two sums differ by rounding [%], [deg].
ROUNDING = 1e-9
#: The shares that make a whole, of measures by name, as (values, what they make): None for 100.
WHOLES: dict[str, list[tuple[tuple[str, ...], str | None]]] = {
    "inoue": [
        (("rear", "trapped", "lost", *(f"band_{edge}" for edge in (75, 60, 45, 30, 15, 0))), None),
    ],
    "aset": [
        (("green", "red", "blue", "leak", "trapped"), None),
        (
            ("weighted_green", "weighted_red", "weighted_blue", "weighted_leak", "surface", "rest"),
            None,
        ),
    ],
    **{
        prefix + sky: [(("internal", "surface"), "value")]
        for prefix in ("", "gemray-")
        for sky in ("iso", "cos", "sc2")
    },
}  # fmt: skip

#: What is found of a view: the bound and the values of each measure by its name.
Found = dict[str, tuple[float, list[float | None]]]


def random_solid(rng: np.random.Generator, number: int) -> Stone:
    """Return the solid inside so many planes in any direction that touch an ellipsoid."""
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0] * np.exp(rng.uniform(-0.5, 0.5, 3))
    while True:
        normals = rng.normal(size=(number, 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        planes = np.column_stack([normals, np.linalg.norm(normals @ axes, axis=1)])
        # It is not closed if all normals lie in one hemisphere.
        with contextlib.suppress(InputError):
            planes = in_frame(planes)[0]
            break
    solid = convex_solid(planes, np.arange(number))[0]
    facets = tuple(Facet(f"F{k}", "facet", side_of(plane[2])) for k, plane in enumerate(solid.planes))
    return Stone(solid=solid, facets=facets)


def random_step(rng: np.random.Generator) -> Stone:
    """Return a step cut of random parameters."""
    while True:
        # Some are refused: rows that do not make a convex stone.
        with contextlib.suppress(InputError):
            step: Stone = families()["step"](
                length=float(rng.uniform(100, 200)),
                corner=float(rng.choice([0.0, rng.uniform(5, 35)])),
                table=float(rng.uniform(40, 75)),
                girdle_thickness=float(rng.uniform(1, 6)),
                crown_angles=tuple(np.sort(rng.uniform(15, 50, rng.integers(1, 4)))[::-1].tolist()),
                pavilion_angles=tuple(np.sort(rng.uniform(30, 60, rng.integers(2, 5)))[::-1].tolist()),
            ).stone()
            return step


def stones(number: int, seed: int) -> list[Stone]:
    """Return random stones: of five, two round brilliants, a step cut, a design and a solid."""
    out: list[Stone] = []
    designs = sorted(path for path in DESIGNS.iterdir() if path.suffix in (".asc", ".gcs"))
    for k in range(number):
        rng = np.random.default_rng([seed, k])
        turn, kind = divmod(k, 5)
        if kind in (0, 2):
            stone, name = Stone.from_proportions(random_brilliant(rng)), "round"
        elif kind == 1:
            stone, name = random_step(rng), "step"
        elif kind == 3:
            path = designs[turn % len(designs)]
            stone, name = load_stone(path), path.stem
        else:
            stone, name = random_solid(rng, int(rng.integers(8, 40))), "solid"
        material = "diamond" if kind == 0 else MATERIALS[int(rng.integers(len(MATERIALS)))]
        out.append(replace(stone, material=material, name=f"{k} {name}, {material}"))
    return out


def runs(seeds: int, turns: int) -> Iterator[tuple[str, int]]:
    """Yield what is done of each view: a kind of run and its seed; the converged run first."""
    yield "truth", 0
    yield from (("seed", k) for k in range(1, seeds + 1))
    yield from (("turn", k) for k in range(1, turns + 1))


def values_of(measured: Measurement, measured_by: Sequence[Measure]) -> Found:
    """Return bound and values of each measure, None for NaN."""
    return {
        of.name: (
            float(of.bound or 0.0),
            [None if math.isnan(of.values[key]) else of.values[key] for key in by.keys],
        )
        for of, by in zip(measured.measures, measured_by, strict=True)
    }


def run(
    stone: Stone, tilt: float, kind: str, seed: int, chosen: Sequence[Measure], options: argparse.Namespace
) -> Found:
    """Measure a view: converged, of a seed, or of the stone turned by a random angle."""
    rng = np.random.default_rng([options.seed, seed])
    azimuth, budget, bound = 33.0, None, options.bound
    if kind == "turn":
        angle = float(rng.uniform(0.0, 360.0))
        stone, azimuth = stone.rotated(angle), azimuth + angle
    if kind == "truth":
        budget, bound = Budget(options.longest, 8.0), options.truth
    measured = measure(
        stone,
        view=View(resolution=1, tilt_deg=tilt, tilt_azimuth_deg=azimuth % 360.0),
        measures=chosen,
        bound=bound,
        seed=seed + 100_000 * (kind == "turn"),
        budget=budget,
    )
    return values_of(measured, chosen)


@dataclass
class Count:
    """What has been found of a measure: runs, values, those outside, and the largest ratio and its place."""

    runs: int = 0
    runs_outside: int = 0
    values: int = 0
    outside: int = 0
    ratio: float = 0.0
    place: str = ""
    at_most: list[float] = field(default_factory=list)

    def add(self, ratios: np.ndarray, keys: Sequence[str], place: str) -> None:
        """Add a run: |error| / bound of each value."""
        self.runs += 1
        self.runs_outside += bool((ratios > 1.0).any())
        self.values += len(ratios)
        self.outside += int((ratios > 1.0).sum())
        largest = float(ratios.max(initial=0.0))
        self.at_most.append(largest)
        if largest > self.ratio:
            self.ratio, self.place = largest, f"{keys[int(ratios.argmax())]}: {place}"


def ratios(found: Found, truth: Found, name: str) -> np.ndarray:
    """Return |error| / bound of the values of a measure, infinite where but one of both is defined."""
    (bound, values), (truth_bound, true_values) = found[name], truth[name]
    out = []
    for value, true_value in zip(values, true_values, strict=True):
        if value is None or true_value is None:
            out.append(0.0 if value is true_value else math.inf)
        else:
            out.append(abs(value - true_value) / (bound + truth_bound + ROUNDING))
    return np.array(out)


def whole_error(found: Found, measure_keys: Mapping[str, Sequence[str]]) -> float:
    """Return by how much shares that make a whole fail to do so, at the most [%]."""
    largest = 0.0
    for name, wholes in WHOLES.items():
        by_key = dict(zip(measure_keys[name], found[name][1], strict=True))
        for parts, whole in wholes:
            made = 100.0 if whole is None else by_key[whole] or 0.0
            largest = max(largest, abs(math.fsum(by_key[key] or 0.0 for key in parts) - made))
    return largest


def print_counts(title: str, counts: dict[str, Count]) -> bool:
    """Print a table; return whether no measure has more outside than is allowed."""
    print(f"\n{title}")
    print(
        f"{'measure':<12}{'values':>9}{'outside':>9}{'share':>9}{'runs outside':>14}{'99 % of runs':>14}"
        f"{'largest':>9}  where"
    )
    passed = True
    for name, of in counts.items():
        if not of.values:
            continue
        share = of.outside / of.values
        passed &= share <= ALLOWED
        of_runs = f"{of.runs_outside} of {of.runs}"
        print(
            f"{name:<12}{of.values:>9}{of.outside:>9}{share:>9.2%}{of_runs:>14}"
            f"{np.quantile(of.at_most, 0.99):>14.2f}{of.ratio:>9.2f}  {of.place}"
        )
    values, outside = (sum(getattr(of, key) for of in counts.values()) for key in ("values", "outside"))
    print(f"{'all':<12}{values:>9}{outside:>9}{outside / max(values, 1):>9.3%}")
    return passed


def entry(line: Any) -> tuple[tuple[int, float, str, int], Found]:
    """Return key and value of a journal's entry."""
    stone, tilt, kind, seed, found = line
    return (int(stone), float(tilt), str(kind), int(seed)), {
        name: (float(bound), values) for name, (bound, values) in found.items()
    }


def main() -> int:
    """Measure, count, print; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--stones", type=int, default=50)
    parser.add_argument("--seeds", type=int, default=20, help="runs of each stone and view")
    parser.add_argument("--turns", type=int, default=4, help="random angles that each stone is turned by")
    parser.add_argument("--bound", type=float, default=0.1, help="bound that is asked for [%%]")
    parser.add_argument("--truth", type=float, default=0.005, help="bound of the converged runs [%%]")
    parser.add_argument("--longest", type=float, default=10.0, help="longest time of a converged run [s]")
    parser.add_argument("--seed", type=int, default=1, help="seed of the stones")
    parser.add_argument("--tilt", type=float, default=20.0, help="tilt of the second view [deg]")
    parser.add_argument("--journal", type=Path, metavar="FILE", help="where to keep what has been found")
    options = parser.parse_args()

    chosen = [of for of in measures() if of.views == "one"]
    keys = {of.name: of.keys for of in chosen}
    head = {
        "bounds": {key: getattr(options, key) for key in ("bound", "truth", "longest", "seed", "tilt")},
        "measures": {of.name: [of.version, list(of.keys)] for of in chosen},
    }
    counts: dict[str, dict[str, Count]] = defaultdict(lambda: {of.name: Count() for of in chosen})
    whole = 0.0
    with contextlib.ExitStack() as stack:
        journal = None
        if options.journal:
            journal = stack.enter_context(Journal(options.journal, head, entry, work="check of bounds"))
        for number, stone in enumerate(stones(options.stones, options.seed)):
            print(f"\r{stone.name:<60}", end="", file=sys.stderr, flush=True)
            for tilt in (0.0, options.tilt):
                truth: Found = {}
                for kind, seed in runs(options.seeds, options.turns):
                    key = number, tilt, kind, seed
                    found = journal.known.get(key) if journal else None
                    if found is None:
                        found = run(stone, tilt, kind, seed, chosen, options)
                        if journal:
                            journal.add(*key, found)
                    whole = max(whole, whole_error(found, keys))
                    if kind == "truth":
                        truth = found
                        continue
                    place = f"{stone.name}, tilt {tilt:g}, {kind} {seed}"
                    for name, count in counts[kind].items():
                        count.add(ratios(found, truth, name), keys[name], place)
    print(file=sys.stderr)
    titles = {"seed": "Seeds against converged runs", "turn": "Stones turned, against converged runs"}
    passed = [print_counts(titles[kind], of) for kind, of in counts.items()]
    print(f"\nshares that make a whole fail to by {whole:.1e} % at the most")
    return 0 if all(passed) and whole <= WHOLE else 1


if __name__ == "__main__":
    sys.exit(main())

"""Time gem_path, Mitsuba's own path tracer and LuxCore to the same error, in one run; ratios count.

    python scripts/benchmark_photoreal.py [--size 128] [--shortest 0.5] [--longest 16] [--repeats 3]
                                          [--reference 64] [--errors 0.1 0.05 0.02] [--seed 1] [--out DIR]
                                          [--scenes alone ground small] [--contestants gem_path path LuxCore]
                                          [--kinds bidirectional lights] [--clock wall processor]

gem_path and LuxCore (`pip install pyluxcore`) render with dispersion, Mitsuba's `path` without. The same
stone, lights, camera and size; all on all cores, each in a process of its own, one at a time.

An error is the root mean square difference to the contestant's own reference, over the mean of that: of the
stone's pixels where it is alone; where it stands on a ground of all, of the ground's and of the stone's;
under a small light of the paper's, where the stone throws caustics, which are also found from the eye, by
chance, for comparison, and of all. The reference is the mean of two halves of other seeds. The mean of (x -
half 1) (x - half 2) is the square of the picture's error without that of the reference, which is printed too.
Compiling and building are timed apart. Each contestant comes in several kinds (sampler, Russian roulette):
the one of the least error of RGB in a short trial is measured. With `--clock processor` a time is that of the
processor over the number of cores: for a machine in use by others.
"""

from __future__ import annotations

import argparse
import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from photoreal_contestants import BUILDERS, ContestantError, Remote, Shot, View, cores, scene
from scipy.ndimage import binary_dilation

from gemrender.writing import write_whole

GEM_PATH, CHANCE, STOCK, LUXCORE = "gem_path", "gem_path by chance", "path", "LuxCore"
#: Scenes, and what they are.
SCENES = {
    "alone": "Stone alone", "ground": "Stone on a ground", "small": "Small light over a stone on paper",
}  # fmt: skip
#: Linear sRGB to luminance.
LUMINANCE = np.array([0.212639, 0.715169, 0.072192])
MEASURES = ("Y", "RGB")
#: How many times faster than others gem_path is wanted to be.
WANTED = {LUXCORE: 10.0, STOCK: 1.0, CHANCE: 20.0}
#: Samples a pixel of the first, untimed picture, and of that which gives the rate.
FIRST = 16
#: Errors fall as the time to the minus this, as of independent samples, beyond the budgets measured.
POWER = 0.5
#: Largest share of the reference's noise in the smallest error that is well below it.
WELL_BELOW = 0.5


@dataclass(slots=True, kw_only=True)
class Entry:
    """A contestant in a scene, and what was found of it.

    Attributes
    ----------
    name, kind : str
        Of `BUILDERS`.
    remote : Remote
        Its process.
    compiling : float
        How much longer the first picture took than the second [s].
    rate : float
        Samples a pixel and second.
    besides : float
        Time apart from the rendering itself, for each picture [s].
    halves : pair of (h, w, 3)
        The reference's halves.
    points : dict of int to list of (2 + 2 regions,) float64
        Time [s], busy share of the cores, and of each region squares of the errors by `MEASURES`, of each
        picture; keys are samples a pixel.
    """

    name: str
    kind: str
    remote: Remote
    compiling: float = 0.0
    rate: float = 0.0
    besides: float = 0.0
    halves: tuple[np.ndarray, np.ndarray] = field(default_factory=lambda: (np.zeros(0), np.zeros(0)))
    points: dict[int, list[np.ndarray]] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """Its name and kind."""
        return f"{self.name} ({self.kind})" if self.kind else self.name

    def curve(self, region: int) -> tuple[np.ndarray, np.ndarray]:
        """Return mean times (n,) and root mean square errors (n, 2) of the budgets, in a region."""
        means = np.array([np.mean(points, axis=0) for points in self.points.values()])
        # An estimate of a square, less the reference's noise, may by chance be below 0.
        return means[:, 0], np.sqrt(np.maximum(means[:, 2 + 2 * region : 4 + 2 * region], 1e-12))

    def busy(self) -> np.ndarray:
        """Return mean busy shares (n,) of the budgets."""
        return np.array([np.mean(points, axis=0)[1] for points in self.points.values()])


def law(times: np.ndarray, errors: np.ndarray) -> tuple[float, float]:
    """Fit error = factor * time ** -power; return factor and power."""
    slope, offset = np.polyfit(np.log(times), np.log(errors), 1)
    return float(np.exp(offset)), float(-slope)


def time_to(error: float, times: np.ndarray, errors: np.ndarray) -> tuple[float, str]:
    """Return the time to an error [s], interpolated, or extrapolated by `POWER` from the nearest end: "*"."""
    falling = np.minimum.accumulate(errors)
    for end, beyond in ((0, error > falling[0]), (-1, error < falling[-1])):
        if beyond:
            return float(times[end] * (falling[end] / error) ** (1 / POWER)), "*"
    return float(np.exp(np.interp(-np.log(error), -np.log(falling), np.log(times)))), " "


def differences(
    picture: np.ndarray, first: np.ndarray, second: np.ndarray, where: np.ndarray
) -> tuple[float, float]:
    """Return mean products of the differences to two pictures over the square of their mean, Y and RGB."""
    x, a, b = (image[where] for image in (picture, first, second))
    out = []
    for weights in (LUMINANCE[:, None], np.eye(3)):
        y, c, d = x @ weights, a @ weights, b @ weights
        out.append(float(np.mean((y - c) * (y - d)) / np.mean((c + d) / 2) ** 2))
    return out[0], out[1]


def noise(first: np.ndarray, second: np.ndarray, where: np.ndarray) -> np.ndarray:
    """Return the relative errors, Y and RGB, of two alike pictures, taken from their difference."""
    middle = (first + second) / 2
    # The middle's differences to the two are half of theirs, and of opposite signs.
    squares = np.array(differences(middle, first, second, where), dtype=float)
    return np.sqrt(-2.0 * squares)


def clocked(shot: Shot, clock: str) -> float:
    """Return the time that a picture took by a clock [s]."""
    return shot.seconds if clock == "wall" else shot.seconds * shot.busy


def power_of_two(value: float) -> int:
    """Return the power of two nearest to a number."""
    return int(2 ** max(round(float(np.log2(value))), 0))


def begin(view: View, name: str, kind: str) -> Entry:
    """Start a contestant, let it compile, and take its rate."""
    entry = Entry(name=name, kind=kind, remote=Remote(view, name, kind))
    cold = entry.remote.warm(FIRST)
    entry.compiling = max(cold - entry.remote.warm(FIRST), 0.0)
    shot = entry.remote.render(FIRST, 1)
    entry.rate = shot.samples / shot.seconds
    return entry


def best_kind(
    view: View,
    name: str,
    where: np.ndarray,
    options: argparse.Namespace,
    seeds: Iterator[int],
    stack: ExitStack,
) -> Entry | None:
    """Try all kinds of a contestant; return that of the least error in the same time, if any runs here."""
    best, least = None, np.inf
    kinds = [kind for kind in BUILDERS[name] if any(word in kind for word in options.kinds)]
    for kind in kinds or BUILDERS[name]:
        try:
            entry = begin(view, name, kind)
        except ContestantError as error:
            print(f"  {name}: not run: {error}")
            break  # what one kind lacks, the others do, too
        samples = power_of_two(entry.rate * options.trial)
        entry.remote.warm(samples)
        shots = [entry.remote.render(samples, next(seeds)) for _ in range(2)]
        errors = noise(shots[0].image, shots[1].image, where)
        taken = (clocked(shots[0], options.clock) + clocked(shots[1], options.clock)) / 2
        entry.rate, entry.besides = shots[0].samples / taken, shots[1].besides
        per_second = errors * np.sqrt(taken)
        print(
            f"  {entry.title:<38}{entry.remote.setup:>7.2f}{entry.compiling:>9.2f}{entry.besides:>9.2f}"
            f"{entry.rate:>9.1f}{per_second[0]:>9.4f}{per_second[1]:>9.4f}"
        )
        if per_second[1] < least:
            if best is not None:
                best.remote.close()
            best, least = entry, float(per_second[1])
        else:
            entry.remote.close()
    if best is not None:
        stack.enter_context(closing(best.remote))
    return best


def measure(
    entries: Sequence[Entry],
    regions: Mapping[str, np.ndarray],
    options: argparse.Namespace,
    seeds: Iterator[int],
) -> None:
    """Render the references, then pictures of growing budgets: by turns, since machines are noisy."""
    by_name = {entry.name: entry for entry in entries}
    for entry in entries:
        if entry.name == CHANCE and GEM_PATH in by_name:
            continue
        samples = power_of_two(entry.rate * options.reference)
        entry.remote.warm(samples)
        first, second = (entry.remote.render(samples, next(seeds)).image for _ in range(2))
        entry.halves = first, second
    if CHANCE in by_name and GEM_PATH in by_name:
        # The same light: what is found by chance would take very long to be a reference
        by_name[CHANCE].halves = by_name[GEM_PATH].halves
    budgets = []
    for entry in entries:
        low, high = (power_of_two(entry.rate * t) for t in (options.shortest, options.longest))
        budgets.append([2**n for n in range(low.bit_length() - 1, high.bit_length())])
        for samples in budgets[-1]:
            entry.remote.warm(samples)
    for _ in range(options.repeats):
        for step in range(max(map(len, budgets))):
            for entry, own in zip(entries, budgets, strict=True):
                if step < len(own):
                    shot = entry.remote.render(own[step], next(seeds))
                    squares = [differences(shot.image, *entry.halves, at) for at in regions.values()]
                    entry.points.setdefault(own[step], []).append(
                        np.array([clocked(shot, options.clock), shot.busy, *np.ravel(squares)])
                    )


def print_curves(entries: Sequence[Entry], region: int, where: np.ndarray) -> None:
    """Print all points of a region, the laws fitted to them, and the references' noise."""
    for entry in entries:
        times, errors = entry.curve(region)
        print(f"\n  {entry.title}: samples, seconds, cores busy, error of Y and of RGB")
        for samples, taken, busy, error in zip(entry.points, times, entry.busy(), errors, strict=True):
            print(f"    {samples:>8}{taken:>10.3f}{busy:>8.0%}{error[0]:>10.5f}{error[1]:>10.5f}")
        laws = [law(times, errors[:, index]) for index in range(len(MEASURES))]
        words = ", ".join(
            f"{name} {factor:.4f} t^-{power:.3f}"
            for name, (factor, power) in zip(MEASURES, laws, strict=True)
        )
        own = noise(*entry.halves, where) / np.sqrt(2)  # of the mean of the halves
        share = own / errors.min(axis=0)
        print(
            f"    error: {words}; reference's own {own[0]:.5f} and {own[1]:.5f}, {share[0]:.0%} and "
            f"{share[1]:.0%} of the smallest: {'well below' if share.max() <= WELL_BELOW else 'TOO MUCH'}"
        )


def print_means(entries: Sequence[Entry], stone: np.ndarray) -> None:
    """Print the mean radiances of the references, which should be nearly the same."""
    print("\n  Mean of the references, R G B    stone                     around it")
    for entry in entries:
        middle = (entry.halves[0] + entry.halves[1]) / 2
        words = ["".join(f"{value:>8.4f}" for value in middle[at].mean(axis=0)) for at in (stone, ~stone)]
        print(f"    {entry.name:<24}{words[0]}  {words[1]}")


def print_ratios(entries: Sequence[Entry], region: int, targets: Sequence[float]) -> None:
    """Print the times to the same errors, and their ratios to gem_path's and to `path`'s."""
    by_name = {entry.name: entry for entry in entries}
    for index, measure_name in enumerate(MEASURES):
        curves = {name: entry.curve(region) for name, entry in by_name.items()}
        for error in targets:
            print(f"\n  Seconds to an error of {error:g} in {measure_name} (* extrapolated)")
            found = {
                name: time_to(error, times, errors[:, index]) for name, (times, errors) in curves.items()
            }
            for name, (taken, mark) in found.items():
                words = "".join(
                    f"{f'{taken / found[other][0]:.2f} x {other}':>22}"
                    for other in (GEM_PATH, STOCK)
                    if other in found and other != name
                )
                print(f"    {by_name[name].title:<38}{taken:>10.3f}{mark}{words}")
            for other, wanted in WANTED.items():
                if GEM_PATH in found and other in found:
                    ratio = found[other][0] / found[GEM_PATH][0]
                    met = "met" if ratio >= wanted else "NOT MET"
                    print(f"    gem_path {ratio:.2f} times as fast as {other}, wanted {wanted:g}: {met}")


def picture(image: np.ndarray) -> Callable[[Path], None]:
    """Return what writes an image as a PNG of sRGB."""
    from matplotlib.image import imsave

    clipped = np.clip(image, 0, 1)
    curved = np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)
    return lambda part: imsave(part, curved, format="png")


def compare(name: str, options: argparse.Namespace, seeds: Iterator[int]) -> None:
    """Measure all contestants in a scene, and print what is found."""
    view = scene(name != "alone", size=options.size, small=name == "small")
    stone = view.silhouette()
    everywhere = np.ones_like(stone)
    beside = ~binary_dilation(stone, np.ones((3, 3)))  # pixels that the stone's edge crosses are the stone's
    regions: dict[str, np.ndarray] = {
        "alone": {"stone": stone},
        "ground": {"all": everywhere, "ground": beside, "stone": stone},
        "small": {"paper": beside, "all": everywhere},
    }[name]
    words = ", ".join(f"{key} {at.mean():.0%}" for key, at in regions.items())
    print(f"\n{SCENES[name]}. Errors over, of the image: {words}")
    print(f"  {'':<38}{'setup s':>7}{'compile':>9}{'besides':>9}{'spp/s':>9}{'Y, 1 s':>9}{'RGB, 1 s':>9}")
    with ExitStack() as stack:
        tried = [
            best_kind(view, one, next(iter(regions.values())), options, seeds, stack)
            for one in options.contestants
            if one != CHANCE or name == "small"
        ]
        entries = [entry for entry in tried if entry is not None]
        if not entries:
            return
        measure(entries, regions, options, seeds)
    print_means(entries, stone)
    for number, (region, where) in enumerate(regions.items()):
        print(f"\n  ---- {SCENES[name]}: {region} ----")
        print_curves(entries, number, where)
        print_ratios(entries, number, options.errors)
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
        files = {
            f"{name}-{entry.name}.png": picture((entry.halves[0] + entry.halves[1]) / 2) for entry in entries
        }
        print(f"  written: {', '.join(str(path) for path in write_whole(options.out, files))}")


def main() -> None:
    """Run what the options ask for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=128, help="pixels a side")
    parser.add_argument("--shortest", type=float, default=0.5, help="time of the smallest budget [s]")
    parser.add_argument("--longest", type=float, default=16.0, help="time of the largest budget [s]")
    parser.add_argument("--repeats", type=int, default=3, help="pictures of each budget")
    parser.add_argument("--reference", type=float, default=64.0, help="time of each half of a reference [s]")
    parser.add_argument(
        "--trial", type=float, default=2.0, help="time of pictures that kinds are chosen by [s]"
    )
    parser.add_argument("--errors", type=float, nargs="+", default=[0.1, 0.05, 0.02])
    parser.add_argument("--clock", choices=("wall", "processor"), default="wall")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES))
    parser.add_argument("--contestants", nargs="+", choices=list(BUILDERS), default=list(BUILDERS))
    parser.add_argument(
        "--kinds", nargs="+", default=[""], metavar="WORD",
        help="try kinds with one of these words in their name only, of contestants that have any",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="where to put the references' pictures")
    options = parser.parse_args()
    print(f"{platform.machine()}, {cores()} cores; {options.size} x {options.size} pixels")
    seeds = iter(range(1000 * options.seed, 1000 * (options.seed + 1)))
    for name in options.scenes:
        compare(name, options, seeds)


if __name__ == "__main__":
    main()

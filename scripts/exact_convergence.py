"""Show that the ray engines converge to the exact score, and that the exact engine's bound holds.

    python scripts/exact_convergence.py [--resolutions 128 256 512 1024 2048 4096] [--stones 10] [--seed 1]
                                        [--bound 0.002] [--reference [512]] [--out FOLDER]

Three groups of stones, with Fresnel's equations: sample 3, random ones, and girdle-heavy ones. What is taken
for the truth is an exact score of another seed, whose bound is a tenth of the default score's or less.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gemrender.beam import BOUND_RANGE, measure
from gemrender.cuts import RoundBrilliant, load_stone
from gemrender.cuts.random import random_brilliant
from gemrender.engines import DEFAULT_BOUND, observe
from gemrender.observation import Measurement, Model
from gemrender.report.lettering import save_png
from gemrender.scoring import score_pixels
from gemrender.stone import Stone
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MODEL = Model(fresnel="exact")
#: Ranges of girdle-heavy stones [%]: thick girdles, large tables, low crowns.
HEAVY = {
    "table": (62, 70), "star": (40, 55), "lower_girdle_contact": (10, 20), "crown_height": (8, 12),
    "pavilion_depth": (44, 48), "girdle_thickness": (4, 8),
}  # fmt: skip
#: What is wanted at 4096 pixels a side: differences in Average and Rear, and the exact score's bound [%].
WANTED_AT, WANTED, WANTED_BOUND = 4096, (0.01, 0.02), 0.01
SAMPLE, RANDOM, GIRDLE_HEAVY = "inoue-3", "random", "girdle-heavy"

_INK, _GREY, _FAINT = "#222222", "#666666", "#e4e4e4"
_COLOURS = {SAMPLE: "#1e9c89", RANDOM: "#3f4889", GIRDLE_HEAVY: "#d1703c"}
_SCORES = ("Average", "Rear")


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """What was found of one stone.

    Attributes
    ----------
    stone : Stone
        The stone.
    truth, default : Measurement
        Its exact score at a tight bound, and at the default one.
    own : float
        Largest difference of these two among Average, Rear, and the bands [%].
    errors : (r, 2) float64
        Mitsuba's Average and Rear at each resolution, minus the truth's [%].
    """

    stone: Stone
    truth: Measurement
    default: Measurement
    own: float
    errors: np.ndarray


def stones(number: int, seed: int) -> dict[str, list[Stone]]:
    """Return the stones of each group."""
    rng = np.random.default_rng(seed)
    random = [random_brilliant(rng) for _ in range(number)]
    heavy = [
        RoundBrilliant(**{key: float(rng.uniform(*span)) for key, span in HEAVY.items()})
        for _ in range(number)
    ]
    return {
        SAMPLE: [load_stone(SAMPLE)],
        RANDOM: [Stone.from_proportions(p, name=f"random {i}") for i, p in enumerate(random, 1)],
        GIRDLE_HEAVY: [Stone.from_proportions(p, name=f"heavy {i}") for i, p in enumerate(heavy, 1)],
    }


def pixel_errors(
    stone: Stone, truth: Measurement, resolutions: Sequence[int], engine: str = "mitsuba"
) -> np.ndarray:
    """Return a ray engine's Average and Rear minus the exact ones, (r, 2) [%]."""
    out = []
    for resolution in resolutions:  # one map at a time: at 4096 it takes a gigabyte
        pixels = score_pixels(observe(stone, engine=engine, resolution=resolution, fresnel="exact"))
        out.append((pixels.average - truth.average, pixels.rear - truth.rear))
    return np.array(out)


def look_at(stone: Stone, resolutions: Sequence[int], truth_bound: float) -> Row:
    """Score a stone exactly, twice, and by Mitsuba at each resolution."""
    default = measure(stone, model=MODEL)
    tight = max(min(truth_bound, default.bound / 10), BOUND_RANGE[0])
    truth = measure(stone, model=MODEL, bound=tight, seed=2)
    pairs = [
        (default.average, truth.average),
        (default.rear, truth.rear),
        *zip(default.bands, truth.bands, strict=True),
    ]
    return Row(
        stone=stone,
        truth=truth,
        default=default,
        own=max(abs(float(a - b)) for a, b in pairs),
        errors=pixel_errors(stone, truth, resolutions),
    )


def print_differences(found: dict[str, list[Row]], resolutions: Sequence[int]) -> None:
    """Print a table of Mitsuba's errors, and the largest ones of each group."""
    print("Mitsuba minus exact, Average and Rear [%]")
    print(
        f"{'':<16}{'Average':>9}{'Rear':>9}{'bound':>9} "
        + "".join(f"{f'at {resolution}':>18}" for resolution in resolutions)
    )
    for rows in found.values():
        for row in rows:
            print(
                f"{row.stone.name:<16}{row.truth.average:>9.4f}{row.truth.rear:>9.4f}{row.truth.bound:>9.4f} "
                + "".join(f"{average:>+10.4f}{rear:>+8.4f}" for average, rear in row.errors)
            )
    print(f"\nLargest difference at {resolutions[-1]}, and the slope of the group's root mean square")
    print(f"{'':<16}{'Average':>9}{'Rear':>9}{'bound':>9}{'slopes':>14}")
    everything = [row for rows in found.values() for row in rows]
    for group, rows in {**found, "all": everything}.items():
        errors = np.array([row.errors for row in rows])
        average, rear = np.abs(errors[:, -1]).max(axis=0)
        bound = max(row.truth.bound for row in rows)
        print(f"{group:<16}{average:>9.4f}{rear:>9.4f}{bound:>9.4f}{slopes(errors, resolutions):>14}")


def slopes(errors: np.ndarray, resolutions: Sequence[int]) -> str:
    """Fit powers of the resolution to root mean squares of errors (n, r, 2), in words."""
    if len(resolutions) < 2:
        return ""
    rms = np.maximum(np.sqrt((errors**2).mean(axis=0)), 1e-12)
    return "".join(f"{power:>7.2f}" for power in np.polyfit(np.log(resolutions), np.log(rms), 1)[0])


def print_bounds(found: dict[str, list[Row]]) -> None:
    """Print a table of the default score's true errors beside the bounds that it states."""
    print(f"\nThe exact score at the default bound, {DEFAULT_BOUND:g}: error of Average, Rear and bands")
    print(
        f"{'':<16}{'largest':>10}{'stated':>10}{'share':>9}{'held':>6}{'truth within':>14}{'rays':>9}"
        f"{'girdle':>9}"
    )
    for rows in found.values():
        for row in rows:
            stated = row.default.bound
            print(
                f"{row.stone.name:<16}{row.own:>10.5f}{stated:>10.5f}{row.own / stated:>9.0%}"
                f"{'yes' if row.own <= stated else 'NO':>6}{row.truth.bound:>14.5f}"
                f"{row.default.rays:>9}{row.default.girdle:>7.2f} %"
            )
    for group, rows in found.items():
        held = sum(row.own <= row.default.bound for row in rows)
        largest = max(row.own for row in rows)
        print(f"{group}: held for {held} of {len(rows)}; largest error {largest:.4f}")


def print_bars(found: dict[str, list[Row]], resolutions: Sequence[int]) -> None:
    """Print whether what is wanted is met."""
    print("\nWanted:")

    def say(words: str, met: bool) -> None:
        print(f"  {words}: {'met' if met else 'NOT MET'}")

    for group in (SAMPLE, RANDOM):
        rows = found.get(group, [])
        if WANTED_AT not in resolutions or not rows:
            print(f"  {group} at {WANTED_AT}: not looked at")
            continue
        at = list(resolutions).index(WANTED_AT)
        last = np.abs([row.errors[at] for row in rows]).max(axis=0)
        bound = max(row.truth.bound for row in rows)
        say(
            f"{group} at {WANTED_AT}: Average {last[0]:.4f} within {WANTED[0]}, Rear {last[1]:.4f} within "
            f"{WANTED[1]}, bound {bound:.4f} below {WANTED_BOUND}",
            bool((last <= WANTED).all()) and bound < WANTED_BOUND,
        )
    for group, rows in found.items():
        say(
            f"{group}: default scores within their bounds",
            all(row.own <= row.default.bound for row in rows),
        )


def print_reference(row: Row, resolutions: Sequence[int]) -> None:
    """Print the reference engine's errors beside Mitsuba's."""
    reference = pixel_errors(row.stone, row.truth, resolutions, engine="reference")
    print(f"\n{row.stone.name}: minus exact, Average and Rear [%]")
    print(f"{'':<10}{'reference':>22}{'Mitsuba':>24}")
    for resolution, by_reference, by_mitsuba in zip(resolutions, reference, row.errors, strict=False):
        words = "".join(f"{value:>+12.4f}" for value in (*by_reference, *by_mitsuba))
        print(f"  {resolution:>6}{words}")


def draw(found: dict[str, list[Row]], resolutions: Sequence[int]) -> Figure:
    """Draw error against resolution: Average on the left, Rear on the right."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.4, 5.4), dpi=140)
    title = "Mitsuba's maps converge to the exact score"
    figure.text(0.06, 0.935, title, fontsize=16, fontweight="bold", color=_INK)
    text = "Difference to the exact score: median of each group, shaded from the smallest to the largest"
    figure.text(0.06, 0.885, text, fontsize=10, color=_GREY)
    sizes = {group: np.abs([row.errors for row in rows]) for group, rows in found.items() if rows}
    everything = np.concatenate(list(sizes.values()))
    rows = [row for of_group in found.values() for row in of_group]
    bounds = {
        "bound of the default exact score": max(row.default.bound for row in rows),
        "bound of what is taken for the truth": max(row.truth.bound for row in rows),
    }
    # A difference that happens to be next to nothing is no reason for an empty decade.
    low = 0.5 * min(np.percentile(everything, 2), *bounds.values())
    high = 2.0 * everything.max()
    for column, name in enumerate(_SCORES):
        axes: Axes = figure.add_axes((0.08 + 0.48 * column, 0.115, 0.42, 0.61))
        axes.set_xscale("log", base=2)
        axes.set_yscale("log")
        for group, errors in sizes.items():
            e, colour = errors[:, :, column], _COLOURS[group]
            if len(e) > 1:
                smallest, largest = np.maximum(e.min(axis=0), low / 10), e.max(axis=0)
                axes.fill_between(resolutions, smallest, largest, color=colour, alpha=0.15, linewidth=0)
            label = group if len(e) == 1 else f"{len(e)} {group} stones"
            axes.plot(
                resolutions, np.median(e, axis=0), "o-", color=colour, markersize=4.5, lw=1.7, label=label
            )
        start = np.sqrt((everything[:, 0, column] ** 2).mean())
        guide = start * (np.array(resolutions) / resolutions[0]) ** -1.5
        axes.plot(resolutions, guide, ":", color=_INK, lw=1.4, label="resolution to the −3/2")
        for words, bound in bounds.items():
            axes.axhline(bound, color=_GREY, lw=1.0, ls=(0, (5, 3)), zorder=1)
            right = bound > np.sqrt(low * high)
            axes.annotate(
                words,
                (1.0 if right else 0.0, bound),
                (-2 if right else 4, 3),
                xycoords=("axes fraction", "data"),
                textcoords="offset points",
                ha="right" if right else "left",
                va="bottom",
                fontsize=8.5,
                color=_INK,
                annotation_clip=True,
            )
        axes.set_ylim(low, high)
        axes.set_title(f"Error of {name} [%]", loc="left", pad=10, fontsize=12, fontweight="bold", color=_INK)
        axes.set_xticks(resolutions, [str(resolution) for resolution in resolutions])
        axes.minorticks_off()
        axes.set_xlabel("pixels a side", fontsize=10.5, color=_INK)
        axes.tick_params(labelsize=9.5, colors=_GREY)
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(axis="y", color=_FAINT, lw=0.7)
        axes.set_axisbelow(True)
    figure.legend(
        *axes.get_legend_handles_labels(), ncols=4, frameon=False, fontsize=9.5, labelcolor=_INK,
        loc="center left", bbox_to_anchor=(0.05, 0.835), handlelength=2.6, columnspacing=2.2,
    )  # fmt: skip
    return figure


def main() -> None:
    """Trace, print, and draw if asked to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--resolutions", type=int, nargs="+", default=[128, 256, 512, 1024, 2048, 4096])
    parser.add_argument(
        "--stones", type=int, default=10, help="random and girdle-heavy stones, of each so many"
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the stones")
    parser.add_argument("--bound", type=float, default=0.002, help="largest error bound of the truth [%%]")
    parser.add_argument(
        "--reference",
        type=int,
        nargs="?",
        const=512,
        metavar="RESOLUTION",
        help="follow sample 3 with the reference engine too, up to this resolution (512)",
    )
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="where to put the figure")
    options = parser.parse_args()
    resolutions = sorted(options.resolutions)

    found = {
        group: [look_at(stone, resolutions, options.bound) for stone in members]
        for group, members in stones(options.stones, options.seed).items()
    }
    found = {group: rows for group, rows in found.items() if rows}
    print_differences(found, resolutions)
    print_bounds(found)
    if options.reference is not None:
        print_reference(found[SAMPLE][0], [r for r in resolutions if r <= options.reference])
    print_bars(found, resolutions)
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
        figure = draw(found, resolutions)
        name = "convergence.png"
        print(f"written: {write_whole(options.out, {name: lambda part: save_png(figure, part)})[0]}")


if __name__ == "__main__":
    main()

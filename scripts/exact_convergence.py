"""Show that the ray engines converge to the exact score, and that the exact engine's bound holds.

python scripts/exact_convergence.py [--resolutions 128 256 512 1024 2048 4096] [--stones 10] [--out FOLDER]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gemrender.beam import measure
from gemrender.engines import observe
from gemrender.observation import Model
from gemrender.score import score_pixels
from gemrender.stone import RoundBrilliant, Stone, load_stone
from gemrender.stone.random import random_brilliant

MODEL = Model(fresnel="exact")
#: Ranges of girdle-heavy stones [%]: thick girdles, large tables, low crowns.
HEAVY = {
    "table": (62, 70), "star": (40, 55), "lower_girdle_contact": (10, 20), "crown_height": (8, 12),
    "pavilion_depth": (44, 48), "girdle_thickness": (4, 8),
}  # fmt: skip
INK, GREY = "#222222", "#666666"
COLOURS = {"inoue-3": "#1e9c89", "random": "#3f4889", "girdle-heavy": "#d1703c"}


def stones(number: int, seed: int) -> dict[str, list[Stone]]:
    """Return the stones of each group."""
    rng = np.random.default_rng(seed)
    random = [random_brilliant(rng) for _ in range(number)]
    heavy = [
        RoundBrilliant(**{key: float(rng.uniform(*span)) for key, span in HEAVY.items()})
        for _ in range(number)
    ]
    return {
        "inoue-3": [load_stone("inoue-3")],
        "random": [Stone.from_proportions(p, name=f"random {i}") for i, p in enumerate(random, 1)],
        "girdle-heavy": [Stone.from_proportions(p, name=f"heavy {i}") for i, p in enumerate(heavy, 1)],
    }


def errors_of(stone: Stone, resolutions: list[int], truth_bound: float) -> tuple[np.ndarray, float, float]:
    """Print a stone's row; return Mitsuba's errors (r, 2), the exact default's largest one, and its bound."""
    truth = measure(stone, model=MODEL, bound=truth_bound, seed=2)
    stated = measure(stone, model=MODEL)
    pairs = [
        (stated.average, truth.average),
        (stated.rear, truth.rear),
        *zip(stated.bands, truth.bands, strict=True),
    ]
    own = max(abs(a - b) for a, b in pairs)
    out = []
    for resolution in resolutions:
        pixels = score_pixels(observe(stone, engine="mitsuba", resolution=resolution, fresnel="exact"))
        out.append((pixels.average - truth.average, pixels.rear - truth.rear))
    errors = np.array(out)
    print(
        f"{stone.name:<16}{truth.average:>9.4f}{truth.rear:>9.4f} ±{truth.bound:.4f}  "
        f"{own:.4f} of {stated.bound:.4f}  " + "  ".join(f"{a:+.4f} {r:+.4f}" for a, r in errors)
    )
    return errors, own, stated.bound


def draw(errors: dict[str, np.ndarray], bound: float, resolutions: list[int]) -> Figure:
    """Draw error against resolution: Average on the left, Rear on the right."""
    figure = Figure(figsize=(10.4, 4.9), dpi=140)
    title = "Mitsuba's maps converge to the exact score"
    figure.text(0.06, 0.93, title, fontsize=16, fontweight="bold", color=INK)
    text = "median difference to the exact score, shaded up to the largest; dotted: resolution to the −3/2"
    figure.text(0.06, 0.875, text, fontsize=10, color=GREY)
    for column, name in enumerate(("Average", "Rear")):
        axes: Axes = figure.add_axes((0.08 + 0.48 * column, 0.13, 0.4, 0.63))
        for group, values in errors.items():
            e = np.abs(values[:, :, column])
            colour = COLOURS[group]
            if len(e) > 1:
                axes.fill_between(
                    resolutions, np.median(e, axis=0), e.max(axis=0), color=colour, alpha=0.18, lw=0
                )
            axes.loglog(resolutions, np.median(e, axis=0), "o-", color=colour, ms=4, lw=1.6, label=group)
        guide = 0.06 * (np.array(resolutions) / resolutions[0]) ** -1.5
        axes.loglog(resolutions, guide, ":", color=GREY, lw=1.2)
        axes.axhline(bound, color=INK, lw=0.9, ls=(0, (5, 3)))
        axes.text(
            resolutions[-1],
            bound * 1.12,
            "bound of the exact score by default",
            ha="right",
            fontsize=8.5,
            color=INK,
        )
        axes.set_title(f"Error of {name} [%]", loc="left", fontsize=12, fontweight="bold", color=INK)
        axes.set_xticks(resolutions, [str(r) for r in resolutions], fontsize=9.5, color=GREY)
        axes.minorticks_off()
        axes.set_xlabel("pixels a side", fontsize=10.5, color=INK)
        axes.tick_params(labelsize=9.5, colors=GREY)
        axes.spines[["top", "right"]].set_visible(False)
        axes.grid(axis="y", color="#e4e4e4", lw=0.7)
        axes.set_axisbelow(True)
    axes.legend(frameon=False, fontsize=10, loc="lower left")
    return figure


def main() -> None:
    """Trace, print, and draw if asked to."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--resolutions", type=int, nargs="+", default=[128, 256, 512, 1024, 2048, 4096])
    parser.add_argument(
        "--stones", type=int, default=10, help="random and girdle-heavy stones, of each so many"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bound", type=float, default=0.005, help="error bound of the truth")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="where to put the figure")
    options = parser.parse_args()

    print(
        "Exact Average and Rear; largest error of the default exact score, of its bound; Mitsuba minus exact"
    )
    print(f"{'':<52}" + "  ".join(f"{r:>7}{'':<8}" for r in options.resolutions))
    errors, bounds = {}, []
    for group, members in stones(options.stones, options.seed).items():
        rows = [errors_of(stone, options.resolutions, options.bound) for stone in members]
        errors[group] = np.array([row[0] for row in rows])
        bounds += [row[2] for row in rows]
        last = np.abs(errors[group][:, -1]).max(axis=0)
        held = sum(own <= stated for _, own, stated in rows)
        print(
            f"{group}: at {options.resolutions[-1]} Average within {last[0]:.4f}, Rear within {last[1]:.4f}; "
            f"the default bound held in {held} of {len(rows)}"
        )
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
        draw(errors, max(bounds), options.resolutions).savefig(options.out / "convergence.png")
        print(f"written: {options.out / 'convergence.png'}")


if __name__ == "__main__":
    main()

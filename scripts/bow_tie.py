"""Bow-ties: virtual facets of stones from above, and how much of the belly the viewer's head darkens.

    python scripts/bow_tie.py                                  # the bundled pairs of oval, marquise and pear
    python scripts/bow_tie.py my-oval.toml pear-classic --head 15 --out docs/bow-tie.jpg

Prints a table, and with --out draws a map of each stone: black where a virtual facet would have its light
from the viewer's head, blue where from below the horizon. Lines part the belly from the ends.
"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gemrender.beam.bow_tie import HEAD_DEG, BowTie, belly_sectors, bow_tie
from gemrender.beam.facets import FacetStatus
from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.report.lettering import save_png
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: The same outline with a bow-tie, and with a better pavilion.
STONES = ("oval-bow-tie", "marquise-bow-tie", "pear-bow-tie", "oval-clear", "marquise-clear", "pear-clear")
DARK, LEAKING, SECTOR = "#0d0d0d", "#a9c3dd", "#d0342c"
#: Greys of what is bright, from the horizon to the head.
LOW, HIGH = 0.72, 1.0
#: Size of a map in the figure, what is left free about it [inch], and the figure's resolution [dots an inch].
SIZE, PAD, DPI = 3.0, 0.12, 110


def colours(found: BowTie) -> np.ndarray:
    """Return the colour of each virtual facet, (n, 3)."""
    from matplotlib.colors import to_rgb

    cosine = found.facets.paths.exit_direction[:, 2]
    leaves = found.facets.status == FacetStatus.EXITED
    head = math.cos(math.radians(found.head_deg))
    grey = LOW + (HIGH - LOW) * np.clip(cosine / head, 0.0, 1.0)
    out = np.repeat(grey[:, None], 3, axis=1)
    out[leaves & (cosine > head)] = to_rgb(DARK)
    out[~leaves | (cosine <= 0.0)] = to_rgb(LEAKING)
    return out


def draw_map(axes: Axes, found: BowTie) -> None:
    """Draw the virtual facets of a stone, and the sides of its belly."""
    from matplotlib.collections import PolyCollection

    facets = found.facets
    polygons = [facets.polygon(i) for i in range(len(facets))]
    axes.add_collection(
        PolyCollection(polygons, facecolors=colours(found), edgecolors="face", linewidths=0.2)
    )
    apex, sectors = belly_sectors(facets.stone)
    outline = np.concatenate(polygons)
    for side in np.concatenate(sectors):
        # As far as the outline's box.
        reach = np.min(
            np.where(side > 0, outline.max(axis=0) - apex, apex - outline.min(axis=0)) / np.abs(side)
        )
        axes.plot(*np.stack([apex, apex + reach * side], axis=1), color=SECTOR, linewidth=0.8)
    axes.set(xlim=(-1.05, 1.05), ylim=(-1.05, 1.05), aspect="equal")
    axes.axis("off")
    belly, ends = found.belly, found.ends
    axes.set_title(
        f"{facets.stone.name}\nbelly: dark {100 * belly.dark:.1f} %, leaking {100 * belly.leaking:.1f} %\n"
        f"ends: dark {100 * ends.dark:.1f} %, leaking {100 * ends.leaking:.1f} %",
        fontsize=8,
    )


def draw(found: list[BowTie]) -> Figure:
    """Draw the maps of all stones, three in a row."""
    from matplotlib.figure import Figure

    columns = min(3, len(found))
    rows = -(-len(found) // columns)
    figure = Figure(figsize=(SIZE * columns, (SIZE + 0.75) * rows + 0.7), dpi=DPI, layout="constrained")
    figure.get_layout_engine().set(h_pad=PAD, w_pad=PAD)
    places = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, one in zip(places, found, strict=False):
        draw_map(axes, one)
    for axes in places[len(found) :]:
        axes.axis("off")
    figure.supxlabel(
        f"Black: light from the viewer's head, {found[0].head_deg:g}° about the eye. Blue: from below the "
        "horizon. Grey to white: from the sky,\nfrom the horizon up to the head. "
        "To the left and right between the red lines: the belly.",
        fontsize=8,
    )
    return figure


def save(figure: Figure, path: Path) -> None:
    """Save a figure as PNG, or as JPEG where the file's name says so."""
    if path.suffix == ".jpg":
        figure.savefig(path, dpi=figure.dpi, pil_kwargs={"quality": 88, "optimize": True})
    else:
        save_png(figure, path)


def print_table(found: list[BowTie]) -> None:
    """Print the shares of each stone, in per cent."""
    print(f"{'[%]':<28} belly: dark  leaking  ends: dark  leaking  whole: dark  leaking  bright")
    for one in found:
        numbers = (
            one.belly.dark, one.belly.leaking, one.ends.dark, one.ends.leaking, one.whole.dark,
            one.whole.leaking, one.whole.bright,
        )  # fmt: skip
        widths = (12, 8, 11, 8, 12, 8, 7)
        cells = (f"{100 * value:>{width}.1f}" for value, width in zip(numbers, widths, strict=True))
        print(f"{one.facets.stone.name:<27}", *cells)


def main() -> None:
    """Measure, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("stones", nargs="*", default=STONES, metavar="STONE", help="bundled names or files")
    parser.add_argument("--head", type=float, default=HEAD_DEG, help="half the angle of the head [deg]")
    parser.add_argument("--out", type=Path, metavar="FILE", help="PNG or JPEG to draw the maps into")
    options = parser.parse_args()
    try:
        found = [bow_tie(load_stone(name), head_deg=options.head) for name in options.stones]
    except InputError as error:
        sys.exit(str(error))
    print_table(found)
    if options.out is not None:
        figure = draw(found)
        write_whole(options.out.parent, {options.out.name: lambda path: save(figure, path)})


if __name__ == "__main__":
    main()

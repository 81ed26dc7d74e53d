"""The facets of a stone by their names, each in the colour of its tier: crown, side and pavilion view."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from gemrender.report.displays.labels import Label, largest_fit, place_labels, text_boxes
from gemrender.report.displays.page import PAPER, draw_lines, fill_facets, three_views
from gemrender.report.displays.projection import StoneView
from gemrender.report.palettes import draw_swatch, kind_tints
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["polygons_figure"]

SCALE = 2.8  # inch per unit
#: Sizes that names are tried in [points]; what is too small for the last one has no name in the drawing.
_SIZES = (10.0, 8.5, 7.0, 5.8, 4.8)
#: Most rows of the legend's columns, and what a row takes at most [inch].
_ROWS, _ROW = 14, 0.3


def polygons_figure(stone: Stone) -> Figure:
    """Draw three views with the name of each visible facet that has room for it, and the tiers."""
    tints = kind_tints(stone)
    unnamed: set[int] = set(range(len(stone.facets)))

    def draw(axes: Axes, view: StoneView) -> None:
        unnamed.difference_update(_draw_facets(axes, stone, view, tints))

    def legend(axes: Axes) -> None:
        _draw_legend(axes, stone, tints, len(unnamed))

    return three_views(stone, f"The {len(stone.facets)} facets", scale=SCALE, draw=draw, legend=legend)


def _draw_facets(axes: Axes, stone: Stone, view: StoneView, tints: dict[tuple[str, str], str]) -> list[int]:
    """Draw the visible facets and their names; return those that have theirs."""
    facets = [stone.facets[number] for number in view.facets]
    fill_facets(axes, view, [tints[facet.side, facet.kind] for facet in facets])
    by_size: dict[float, list[tuple[int, Label]]] = {}
    for number, facet, polygon in zip(view.facets, facets, view.polygons, strict=True):
        label = Label(text=facet.name.replace("_", " "), at=polygon.mean(axis=0), polygon=polygon)
        size = largest_fit(axes, label, _SIZES)
        if size is not None:
            by_size.setdefault(size, []).append((number, label))
    draw_lines(axes, view, PAPER)
    named: list[int] = []
    for size in sorted(by_size, reverse=True):
        numbers, labels = zip(*by_size[size], strict=True)
        place_labels(axes, labels, fontsize=size, colour=PAPER.ink, parse_math=False)
        named += numbers
    return named if stone.is_convex else _without_overlaps(axes, named)


def _without_overlaps(axes: Axes, named: list[int]) -> list[int]:
    """Take out names that lie on larger ones: of a stone that is not convex facets may hide each other."""
    boxes, texts = text_boxes(axes), list(axes.texts)
    kept: list[int] = []
    for i, (left, bottom, right, top) in enumerate(boxes):
        if any(left < b[2] and b[0] < right and bottom < b[3] and b[1] < top for b in boxes[kept]):
            texts[i].remove()
        else:
            kept.append(i)
    return [named[i] for i in kept]


def _draw_legend(axes: Axes, stone: Stone, tints: dict[tuple[str, str], str], unnamed: int) -> None:
    """Draw which tiers there are, and how many facets each has; of very many the first."""
    count = Counter((facet.side, facet.kind) for facet in stone.facets)
    order = [pair for side in ("crown", "girdle", "pavilion") for pair in count if pair[0] == side]
    width, height = axes.get_xlim()[1] - 0.45, axes.get_ylim()[1]
    columns = min(4, -(-len(order) // _ROWS))
    rows = min(-(-len(order) // columns), int((height - 0.9) / 0.17))
    step = min(_ROW, (height - 0.9) / rows)
    size = min(11.0, 40.0 * step)
    axes.text(0.45, height - 0.3, "Tier, number of facets", fontsize=10.5, color=PAPER.soft)
    for place, pair in enumerate(order[: rows * columns]):
        column, row = divmod(place, rows)
        x, y = 0.45 + column * width / columns, height - 0.35 - (row + 1) * step
        draw_swatch(axes, x, y - 0.04, tints[pair], height=min(0.22, 0.8 * step))
        name = pair[1] if len(pair[1]) <= 14 else f"{pair[1][:13]}…"
        axes.text(x + 0.42, y, name, fontsize=size, fontweight="bold", parse_math=False)
        axes.text(x + width / columns - 0.15, y, f"{count[pair]}", fontsize=size, ha="right")
    left_out = len(order) - rows * columns
    notes = [f"{unnamed} facets have no room for their names"] if unnamed else []
    notes += [f"{left_out} more tiers"] if left_out > 0 else []
    if notes:
        text = "; ".join(notes) + ": gemrender inspect lists all."
        axes.text(0.45, 0.08, text, fontsize=9.5, color=PAPER.soft)

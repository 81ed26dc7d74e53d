"""The figure of an atlas: a map with contours, cliffs, a laboratory's range, and stones."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gemrender.errors import InputError
from gemrender.optics.materials import named_index
from gemrender.report.displays import save_figure
from gemrender.report.lettering import name_fonts
from gemrender.stone import Stone
from gemrender.sweep.atlas.map import STEEPER, AtlasMap, cliffs, parameter_of, two_mains_limit
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["EXCELLENT", "atlas_figure", "write_atlas_figure"]

#: Ranges within which round brilliants of diamond can have GIA's grade Excellent; not every stone within all
#: of them has it. (GIA, Estimating a cut grade using the GIA diamond cut grading system, 2006, and its
#: charts at diamondcut.gia.edu; the ranges as tabulated at benaderette-diamond.com/observe-diamond-en.)
EXCELLENT = {
    "table": (52.0, 62.0),
    "crown_angle": (31.5, 36.5),
    "pavilion_angle": (40.6, 41.8),
    "star": (45.0, 65.0),
    "lower_half": (70.0, 85.0),
}
#: Characters of a line below the title.
_WIDTH = 105

_INK, _GREY, _CLIFF, _FRAME = "#222222", "#666666", "#d1495b", "#ffffff"


def atlas_figure(shown: AtlasMap, marks: Sequence[Stone] = ()) -> Figure:
    """Draw a map with contours, cliffs, a laboratory's range where it is known, and stones.

    Parameters
    ----------
    shown : AtlasMap
        The map.
    marks : sequence of Stone
        Stones whose place is marked.

    Raises
    ------
    InputError
        A stone without the map's parameters, or outside it.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.6, 6.6), dpi=150)
    axes = figure.add_axes((0.1, 0.1, 0.76, 0.73))
    image = axes.pcolormesh(
        _edges(shown.at_x), _edges(shown.at_y), np.ma.masked_invalid(shown.values), cmap="viridis"
    )
    _draw_contours(axes, shown)
    words = _draw_limits(axes, shown)
    for stone in marks:
        _draw_mark(axes, shown, stone)
    axes.set_xlim(_edges(shown.at_x)[[0, -1]])
    axes.set_ylim(_edges(shown.at_y)[[0, -1]])
    axes.set_facecolor("#eeeeee")
    axes.set_xlabel(_label(shown.x), fontsize=11)
    axes.set_ylabel(_label(shown.y), fontsize=11)
    bar = figure.colorbar(image, cax=figure.add_axes((0.885, 0.1, 0.025, 0.73)))
    bar.set_label(f"{shown.measure}{f' [{shown.unit}]' if shown.unit else ''}", fontsize=11)
    figure.text(
        0.1,
        0.945, shown.title, fontsize=15, fontweight="bold", color=_INK, family=name_fonts(),
        parse_math=False,
    )  # fmt: skip
    lines = [part for line in (_subtitle(shown), words) for part in textwrap.wrap(line, _WIDTH)]
    figure.text(0.1, 0.92, "\n".join(lines), fontsize=9, color=_GREY, va="top", linespacing=1.35)
    return figure


def write_atlas_figure(
    shown: AtlasMap, folder: Path, stem: str, marks: Sequence[Stone] = (), formats: Sequence[str] = ("png",)
) -> list[Path]:
    """Write the figure as `stem`.png, .svg or .pdf, whole or not at all; return the paths."""
    figure = atlas_figure(shown, marks)

    return write_whole(
        folder,
        {f"{stem}.{form}": lambda made: save_figure(figure, made, shown.title) for form in formats},
    )


def _edges(values: np.ndarray) -> np.ndarray:
    middle = 0.5 * (values[1:] + values[:-1])
    first, last = 2 * values[0] - middle[0], 2 * values[-1] - middle[-1]
    return np.concatenate([[first], middle, [last]])


def _label(key: str) -> str:
    unit = "°" if key.endswith("angle") else "" if key == "index" else "%"
    return f"{key.replace('_', ' ').capitalize()}{f' [{unit}]' if unit else ''}"


def _subtitle(shown: AtlasMap) -> str:
    parts = [f"{key.replace('_', ' ')} {value if isinstance(value, str) else f'{value:g}'}"
             for key, value in shown.fixed.items()]  # fmt: skip
    if shown.averaged:
        parts.append(f"mean over {', '.join(key.replace('_', ' ') for key in shown.averaged)}")
    worst = np.nanmax(shown.bounds) if np.isfinite(shown.bounds).any() else math.nan
    parts.append(f"error bound at most {worst:.2g}{' ' + shown.unit if shown.unit else ''}")
    return "; ".join(parts)


def _draw_contours(axes: Axes, shown: AtlasMap) -> None:
    values = np.ma.masked_invalid(shown.values)
    if min(values.shape) < 2 or values.count() < 4 or np.ptp(values.compressed()) == 0:
        return
    lines = axes.contour(shown.at_x, shown.at_y, values, levels=8, colors=_INK, linewidths=0.6, alpha=0.75)
    axes.clabel(lines, fontsize=8, fmt="%g")


def _draw_limits(axes: Axes, shown: AtlasMap) -> str:
    """Draw cliffs, the closed form of one, and a laboratory's range; return what they are, in words."""
    words = []
    if not shown.averaged and _draw_cliffs(axes, shown):
        words.append(f"red: steps over {STEEPER:g} times as steep as beside")
    angles = {"crown_angle", "pavilion_angle"}
    if shown.index is not None and {shown.x, shown.y} == angles:
        crown = shown.at_x if shown.x == "crown_angle" else shown.at_y
        limit = two_mains_limit(crown, shown.index)
        pavilion = shown.at_y if shown.x == "crown_angle" else shown.at_x
        if (limit < pavilion.max()).any() and (limit > pavilion.min()).any():
            pair = (crown, limit) if shown.x == "crown_angle" else (limit, crown)
            axes.plot(*pair, color=_CLIFF, linewidth=1.2, linestyle=":")
            words.append("dotted: bezels hold back light from two mains")
    if shown.index is not None and shown.x in EXCELLENT and shown.y in EXCELLENT and _is_diamond(shown):
        from matplotlib.patches import Rectangle

        (left, right), (low, high) = EXCELLENT[shown.x], EXCELLENT[shown.y]
        axes.add_patch(
            Rectangle((left, low), right - left, high - low, fill=False, edgecolor=_FRAME, linewidth=1.8)
        )
        words.append("white: range of GIA's Excellent")
    return "; ".join(words)


def _is_diamond(shown: AtlasMap) -> bool:
    return shown.index == named_index(None)


def _draw_cliffs(axes: Axes, shown: AtlasMap) -> bool:
    """Draw a line between neighbours that differ by a cliff."""
    from matplotlib.collections import LineCollection

    x, y = _edges(shown.at_x), _edges(shown.at_y)
    lines = []
    for row, column in np.argwhere(cliffs(shown.at_x, shown.values, shown.bounds)):
        lines.append([(x[column + 1], y[row]), (x[column + 1], y[row + 1])])
    for column, row in np.argwhere(cliffs(shown.at_y, shown.values.T, shown.bounds.T)):
        lines.append([(x[column], y[row + 1]), (x[column + 1], y[row + 1])])
    axes.add_collection(LineCollection(lines, colors=_CLIFF, linewidths=2.0))
    return bool(lines)


def _draw_mark(axes: Axes, shown: AtlasMap, stone: Stone) -> None:
    place = []
    for key, along in ((shown.x, shown.at_x), (shown.y, shown.at_y)):
        value = parameter_of(stone, key)
        if value is None or math.isnan(value):
            raise InputError(f"has no {key.replace('_', ' ')}", key="--mark", value=stone.name)
        edges = _edges(along)
        if not edges[0] <= value <= edges[-1]:
            raise InputError(
                f"is outside the map: its {key.replace('_', ' ')} is {value:.4g}",
                key="--mark",
                value=stone.name,
            )
        place.append(value)
    axes.plot(*place, marker="o", markersize=9, markerfacecolor=_CLIFF, markeredgecolor="white")
    axes.annotate(
        stone.name, place, xytext=(8, 6), textcoords="offset points", fontsize=10, fontweight="bold",
        color="white", family=name_fonts(), parse_math=False,
        bbox={"boxstyle": "round,pad=0.2", "facecolor": _INK, "edgecolor": "none", "alpha": 0.7},
    )  # fmt: skip

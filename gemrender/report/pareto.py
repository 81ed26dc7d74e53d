"""A front of several goals as a figure."""

from __future__ import annotations

import itertools
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gemrender.report.lettering import name_fonts, save_png
from gemrender.sweep.improve import Front
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["front_figure", "front_words", "write_front_figure"]

_COLOUR, _START, _INK, _GREY = "#1e9c89", "#c2571a", "#222222", "#666666"
#: Panels in a row, and the size of each [inches].
_COLUMNS, _SIDE = 3, 4.3


def front_words(found: Front) -> str:
    """Say in words what the figure shows."""
    return (
        f"The front of {len(found.front)} among {found.tried} stones: none of them is better by all goals. "
        "Numbered: the answers; diamond: the stone that the search began with."
    )


def front_figure(found: Front) -> Figure:
    """Draw the front, a panel for each pair of goals, with the answers numbered and the start marked."""
    from matplotlib.figure import Figure

    pairs = list(itertools.combinations(range(len(found.goals)), 2))
    columns = min(len(pairs), _COLUMNS)
    rows = -(-len(pairs) // columns)
    width, height = max(_SIDE * columns + 0.6, 6.4), _SIDE * rows + 1.0
    figure = Figure(figsize=(width, height), dpi=140)
    figure.text(
        0.5 / width, 1 - 0.4 / height, found.start.stone.name, fontsize=16, fontweight="bold", color=_INK,
        family=name_fonts(), parse_math=False,
    )  # fmt: skip
    words = textwrap.fill(front_words(found), round(13 * width))
    figure.text(0.5 / width, 1 - 0.52 / height, words, fontsize=9, color=_GREY, va="top", linespacing=1.3)
    side = (width - 0.6) / columns
    for number, pair in enumerate(pairs):
        row, column = divmod(number, columns)
        left, bottom = 0.85 + side * column, _SIDE * (rows - row - 1) + 0.65
        axes = figure.add_axes(
            (left / width, bottom / height, (side - 0.75) / width, (_SIDE - 0.85) / height)
        )
        _draw(axes, found, pair)
    return figure


def _draw(axes: Axes, found: Front, pair: tuple[int, int]) -> None:
    """Draw two goals of all stones of the front."""
    one, other = pair
    points = np.array([[of.goals[one], of.goals[other]] for of in found.front])
    if len(found.goals) == 2:
        ordered = points[np.argsort(points[:, 0])]
        axes.plot(*ordered.T, color=_COLOUR, linewidth=1.0, alpha=0.5, drawstyle="steps-pre")
    axes.scatter(*points.T, s=16, color=_COLOUR, linewidth=0, alpha=0.6)
    for number, answer in enumerate(found.answers, start=1):
        x, y = answer.goals[one], answer.goals[other]
        axes.scatter(x, y, s=46, facecolor=_COLOUR, edgecolor="white", linewidth=0.8, zorder=3)
        axes.annotate(
            str(number), (x, y), xytext=(5, 5), textcoords="offset points", fontsize=10.5, fontweight="bold",
            color=_INK,
        )  # fmt: skip
    x, y = found.start.goals[one], found.start.goals[other]
    if np.isfinite([x, y]).all():
        axes.scatter(x, y, s=60, marker="D", facecolor="white", edgecolor=_START, linewidth=1.8, zorder=4)
        axes.annotate("start", (x, y), xytext=(7, -13), textcoords="offset points", fontsize=10, color=_START)
    axes.margins(0.09)
    for axis, place in ((axes.xaxis, one), (axes.yaxis, other)):
        axis.set_label_text(textwrap.fill(found.goals[place].text, 44), fontsize=10.5, parse_math=False)
    axes.tick_params(labelsize=9, length=3)
    axes.grid(color="#e5e5e5", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def write_front_figure(found: Front, path: Path) -> Path:
    """Write the figure as PNG, whole or not at all; return its path."""
    figure = front_figure(found)
    return write_whole(path.parent, {path.name: lambda part: save_png(figure, part)})[0]

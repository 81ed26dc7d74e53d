"""Dimension lines of an engineering drawing: extension lines, arrows, angles, and what is written at them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from gemrender.report.displays.page import PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_angle", "draw_arc", "draw_dimension", "draw_row", "write_beside", "write_outside"]

FONT_SIZE = 11.5
#: What an extension line leaves free at the stone, and goes beyond the dimension line [stone's unit].
EXTENSION_GAP, EXTENSION_BEYOND = 0.03, 0.05
#: Least length of a dimension with its arrows inside [stone's unit].
ARROWS_INSIDE = 0.16


def draw_dimension(
    axes: Axes,
    a: np.ndarray,
    b: np.ndarray,
    line: tuple[float, float],
    text: str,
    *,
    upright: bool = False,
    turned: bool = False,
    is_wide: bool = False,
    size: float = FONT_SIZE,
) -> None:
    """Draw a dimension with extension lines: level at the height line[1], or upright at line[0].

    Of an upright one the text is level, or `turned` along it. A text that `is_wide`, wider than its
    dimension, stands beyond the ends of the extension lines.
    """
    axis = 0 if upright else 1
    across = 1 - axis
    ends = np.array([a, b], dtype=float)
    ends[:, axis] = line[axis]
    for point, end in zip((a, b), ends, strict=True):
        away = np.sign(end[axis] - point[axis])
        extension = np.array([point, end])
        extension[0, axis] += EXTENSION_GAP * away
        extension[1, axis] += EXTENSION_BEYOND * away
        axes.plot(*extension.T, color=PAPER.accent, linewidth=PAPER.thin_width, zorder=5)
    length = float(abs(ends[1, across] - ends[0, across]))
    middle = ends.mean(axis=0)
    if length >= ARROWS_INSIDE:
        draw_arrow(axes, middle, ends[0])
        draw_arrow(axes, middle, ends[1])
    else:
        for end, other in (ends, ends[::-1]):
            outside = end + 0.14 * (end - other) / (length or 1.0)
            draw_arrow(axes, outside, end)
        axes.plot(*ends.T, color=PAPER.accent, linewidth=0.8, zorder=5)
    if upright:
        place = middle + np.array([EXTENSION_BEYOND + 0.02 if is_wide else 0.03 if turned else 0.06, 0.0])
        anchor = {"ha": "left", "va": "center" if turned else "center_baseline"}
    else:
        beyond = EXTENSION_BEYOND + 0.02 if is_wide else 0.035
        place, anchor = middle + np.array([0.0, beyond]), {"ha": "center", "va": "bottom"}
    # Where other extension lines pass, they are broken.
    ground = {"facecolor": PAPER.ground, "edgecolor": "none", "pad": 0.8}
    axes.text(
        *place, text, fontsize=size, color=PAPER.accent, zorder=10, rotation=90 if turned else 0, bbox=ground,
        **anchor,
    )  # fmt: skip


def draw_arrow(axes: Axes, tail: Sequence[float] | np.ndarray, tip: Sequence[float] | np.ndarray) -> None:
    from matplotlib.patches import FancyArrowPatch

    axes.add_patch(
        FancyArrowPatch(
            tuple(tail), tuple(tip), arrowstyle="-|>,head_length=0.42,head_width=0.14", mutation_scale=18,
            color=PAPER.accent, linewidth=0.8, shrinkA=0, shrinkB=0, zorder=6,
        )
    )  # fmt: skip


def draw_angle(axes: Axes, corner: np.ndarray, other: np.ndarray, radius: float, text: str) -> None:
    """Draw the angle at a corner between the level to the right and another point, and name it outside."""
    angle = float(np.degrees(np.arctan2(*(other - corner)[::-1])))
    draw_arc(axes, corner, corner + np.array([1.0, 0.0]), other, radius)
    # The text stands outside the stone, where nothing is drawn.
    place = corner + np.array([-0.05, 0.1 if angle > 0 else -0.1])
    axes.text(
        *place, text, fontsize=FONT_SIZE, color=PAPER.accent, ha="right", va="center_baseline", zorder=10
    )


def draw_arc(axes: Axes, corner: np.ndarray, start: np.ndarray, end: np.ndarray, radius: float) -> None:
    """Draw an angle's arc at a corner, from a dashed line towards one point to the direction of another."""
    from matplotlib.patches import Arc

    along = (start - corner) / np.hypot(*(start - corner))
    axes.plot(
        *np.array([corner, corner + (radius + 0.08) * along]).T, color=PAPER.accent,
        linewidth=PAPER.thin_width, zorder=5, linestyle=(0, (6, 3)),
    )  # fmt: skip
    first, last = (float(np.degrees(np.arctan2(*(point - corner)[::-1]))) for point in (start, end))
    turn = (last - first + 180.0) % 360.0 - 180.0
    axes.add_patch(
        Arc(
            corner, 2 * radius, 2 * radius, theta1=first + min(turn, 0.0), theta2=first + max(turn, 0.0),
            color=PAPER.accent, linewidth=0.9, zorder=6,
        )
    )  # fmt: skip


def draw_row(axes: Axes, points: list[np.ndarray]) -> None:
    """Draw dimensions in a row along a radius."""
    for a, b in pairwise(points):
        middle = (a + b) / 2
        if np.hypot(*(b - a)) >= ARROWS_INSIDE:
            draw_arrow(axes, middle, a)
            draw_arrow(axes, middle, b)
        axes.plot(*np.array([a, b]).T, color=PAPER.accent, linewidth=0.8, zorder=6)
    axes.scatter(*np.array(points).T, s=9, color=PAPER.accent, zorder=7)


def write_beside(axes: Axes, a: np.ndarray, b: np.ndarray, text: str) -> None:
    """Write a letter beside its dimension."""
    along = (b - a) / np.hypot(*(b - a))
    place = (a + b) / 2 + 0.06 * np.array([along[1], -along[0]])
    axes.text(
        *place, text, fontsize=FONT_SIZE, color=PAPER.accent, ha="center", va="center_baseline", zorder=10,
        fontstyle="italic",
    )  # fmt: skip


def write_outside(axes: Axes, end: np.ndarray, text: str) -> None:
    """Write beyond the girdle, with a line to the dimension that ends there."""
    out = end / np.hypot(*end)
    place = end + 0.12 * out
    axes.plot(*np.array([end, place]).T, color=PAPER.accent, linewidth=PAPER.thin_width, zorder=5)
    axes.text(
        *(place + 0.02 * out), text, fontsize=FONT_SIZE, color=PAPER.accent, zorder=10, linespacing=1.3,
        ha="left" if out[0] > 0 else "right", va="center" if abs(out[1]) < 0.3 else "bottom",
    )  # fmt: skip

"""The outline with its dimensions: side, crown and pavilion view as an engineering drawing."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from gemrender.cuts.round_brilliant.topology import (
    CONTACT,
    CULET,
    GIRDLE_LOWER,
    GIRDLE_UPPER,
    STAR_TIP,
    TABLE_CORNER,
)
from gemrender.report.dimensions import Dimension, dimensions
from gemrender.report.displays.page import PAPER, Page, draw_lines, stone_extent
from gemrender.report.displays.projection import CROWN, PAVILION, look_at, side
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["outline_figure"]

SCALE = 2.2  # inch per girdle radius
FONT_SIZE = 11.5
#: What an extension line leaves free at the stone, and goes beyond the dimension line [girdle radius].
EXTENSION_GAP, EXTENSION_BEYOND = 0.03, 0.05
#: Least length of a dimension with its arrows inside [girdle radius].
ARROWS_INSIDE = 0.16


def outline_figure(stone: Stone) -> Figure:
    """Draw the outline in three views to one scale, with dimension lines and a table of the values."""
    low, high, radius = stone_extent(stone)
    column = 2 * radius * SCALE + 2.1
    upper, lower = 2 * radius * SCALE + 1.35, (high - low) * SCALE + 1.95
    page = Page(
        stone,
        "Outline and proportions" if stone.proportions else "Outline and mean dimensions as measured",
        width=2 * column + 0.5 + 2 * Page.MARGIN,
        height=upper + lower + Page.TITLE + Page.MARGIN,
    )
    values = dimensions(stone)
    left, right = Page.MARGIN, Page.MARGIN + column + 0.5
    bottom, top = Page.MARGIN, Page.MARGIN + lower
    crown = page.view(left, top + 0.3, column, upper - 0.3, scale=SCALE, centre=(0, 0.06))
    draw_lines(crown, look_at(stone, CROWN), PAPER)
    _crown_dimensions(crown, stone, values)
    page.caption(left, top + 0.1, column, CROWN.name)

    pavilion = page.view(right, top + 0.3, column, upper - 0.3, scale=SCALE, centre=(0, 0.06))
    draw_lines(pavilion, look_at(stone, PAVILION), PAPER)
    _pavilion_dimensions(pavilion, stone, values)
    page.caption(right, top + 0.1, column, PAVILION.name)

    # A little wider: the heights stand to the right of the side view.
    profile = page.view(
        left, bottom + 0.3, column + 1.6, lower - 0.3, scale=SCALE,
        centre=(0.8 / SCALE, (low + high) / 2 + 0.03),
    )  # fmt: skip
    draw_lines(profile, look_at(stone, side()), PAPER)
    _side_dimensions(profile, stone, values)
    page.caption(left, bottom + 0.1, column, "Side view")
    _draw_table(page.axes(right + 0.85, bottom, column - 0.85, lower), values)
    return page.figure


# ---- The views' dimensions -----------------------------------------------------------------------------


def _side_dimensions(axes: Axes, stone: Stone, values: dict[str, Dimension]) -> None:
    flat = side().flat(stone.vertices)
    low, high, _ = stone_extent(stone)
    right = flat[:, 0].max()
    corners, culet = flat[TABLE_CORNER], flat[CULET]
    girdle_top, girdle_bottom = flat[GIRDLE_UPPER[0]], flat[GIRDLE_LOWER[0]]
    table = [corners[np.argmin(corners[:, 0])], corners[np.argmax(corners[:, 0])]]

    _dimension(axes, table[0], table[1], (0.0, high + 0.17), _named(values["table"]))
    ends = [flat[np.argmin(flat[:, 0])], flat[np.argmax(flat[:, 0])]]
    _dimension(axes, ends[0], ends[1], (0.0, low - 0.15), "girdle diameter 100 %")
    x = right + 0.2
    _dimension(axes, table[1], girdle_top, (x, 0.0), _named(values["crown_height"]), upright=True)
    _dimension(axes, girdle_top, girdle_bottom, (x, 0.0), _named(values["girdle_thickness"]), upright=True)
    _dimension(axes, girdle_bottom, culet, (x, 0.0), _named(values["pavilion_depth"]), upright=True)
    _angle(axes, flat[GIRDLE_UPPER[8]], flat[TABLE_CORNER[4]], 0.30, _named(values["crown_angle"]))
    _angle(axes, flat[GIRDLE_LOWER[8]], culet, 0.34, _named(values["pavilion_angle"]))


def _crown_dimensions(axes: Axes, stone: Stone, values: dict[str, Dimension]) -> None:
    """SU along the radius of a star tip: from the middle of the table's edge to it, and on to the girdle."""
    v = stone.vertices[:, :2]
    k = 1
    start = (v[TABLE_CORNER[k]] + v[TABLE_CORNER[k + 1]]) / 2
    tip, end = v[STAR_TIP[k]], v[GIRDLE_UPPER[2 * k + 1]]
    _along(axes, [start, tip, end])
    _beside(axes, start, tip, "a")
    _beside(axes, tip, end, "b")
    _outside(axes, end, f"SU a : b = {values['star'].text}")


def _pavilion_dimensions(axes: Axes, stone: Stone, values: dict[str, Dimension]) -> None:
    """LG along the radius of a contact: from the axis to the contact, and on to the girdle."""
    flat = PAVILION.flat(stone.vertices)
    k = 6
    contact, end = flat[CONTACT[k]], flat[GIRDLE_LOWER[2 * k + 1]]
    centre = flat[CULET]
    _along(axes, [centre, contact, end])
    value = values["lower_girdle_contact"]
    _outside(axes, end, f"{_named(value)}\nlower half {100 - value.value:.2f} %")


def _draw_table(axes: Axes, values: dict[str, Dimension]) -> None:
    width, height = axes.get_xlim()[1], axes.get_ylim()[1]
    spread = any(value.spread for value in values.values())
    step = 0.36
    y = (height + step * len(values)) / 2 + 0.2
    columns = (0.0, 0.62, width - (1.45 if spread else 0.0), width)
    axes.text(columns[2], y, "mean" if spread else "value", fontsize=10.5, color=PAPER.soft, ha="right")
    if spread:
        axes.text(columns[3], y, "least – most", fontsize=10.5, color=PAPER.soft, ha="right")
    for value in values.values():
        y -= step
        axes.plot([0, width], [y + 0.25] * 2, color=PAPER.faint, linewidth=0.6)
        axes.text(columns[0], y, value.symbol, fontsize=12, fontweight="bold", color=PAPER.accent)
        axes.text(columns[1], y, value.name, fontsize=12, color=PAPER.ink)
        axes.text(columns[2], y, value.text, fontsize=12, color=PAPER.ink, ha="right")
        axes.text(columns[3], y, value.spread, fontsize=10.5, color=PAPER.soft, ha="right")
    y -= 0.2
    axes.plot([0, width], [y + 0.09] * 2, color=PAPER.faint, linewidth=0.6)
    axes.text(
        0, y - 0.06, "Heights, table and depths in % of the girdle diameter,\nLG in % of its radius, "
        "SU in % of the way from\nthe table's edge to the girdle.",
        fontsize=10, color=PAPER.soft, va="top", linespacing=1.35,
    )  # fmt: skip


def _named(value: Dimension) -> str:
    return f"{value.symbol} {value.text}"


# ---- Dimension lines -----------------------------------------------------------------------------------


def _dimension(
    axes: Axes, a: np.ndarray, b: np.ndarray, line: tuple[float, float], text: str, *, upright: bool = False
) -> None:
    """Draw a dimension with extension lines: level at the height line[1], or upright at line[0]."""
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
        _arrow(axes, middle, ends[0])
        _arrow(axes, middle, ends[1])
    else:
        for end, other in (ends, ends[::-1]):
            outside = end + 0.14 * (end - other) / (length or 1.0)
            _arrow(axes, outside, end)
        axes.plot(*ends.T, color=PAPER.accent, linewidth=0.8, zorder=5)
    if upright:
        place, anchor = middle + np.array([0.06, 0.0]), {"ha": "left", "va": "center_baseline"}
    else:
        place, anchor = middle + np.array([0.0, 0.035]), {"ha": "center", "va": "bottom"}
    axes.text(*place, text, fontsize=FONT_SIZE, color=PAPER.accent, zorder=10, **anchor)


def _arrow(axes: Axes, tail: Sequence[float] | np.ndarray, tip: Sequence[float] | np.ndarray) -> None:
    from matplotlib.patches import FancyArrowPatch

    axes.add_patch(
        FancyArrowPatch(
            tuple(tail), tuple(tip), arrowstyle="-|>,head_length=0.42,head_width=0.14", mutation_scale=18,
            color=PAPER.accent, linewidth=0.8, shrinkA=0, shrinkB=0, zorder=6,
        )
    )  # fmt: skip


def _angle(axes: Axes, corner: np.ndarray, other: np.ndarray, radius: float, text: str) -> None:
    """Draw the angle at a corner between the level to the right and another point, and name it outside."""
    from matplotlib.patches import Arc

    angle = float(np.degrees(np.arctan2(*(other - corner)[::-1])))
    axes.plot(
        [corner[0], corner[0] + radius + 0.08], [corner[1]] * 2, color=PAPER.accent,
        linewidth=PAPER.thin_width, zorder=5, linestyle=(0, (6, 3)),
    )  # fmt: skip
    axes.add_patch(
        Arc(
            corner, 2 * radius, 2 * radius, theta1=min(angle, 0.0), theta2=max(angle, 0.0),
            color=PAPER.accent, linewidth=0.9, zorder=6,
        )
    )  # fmt: skip
    # The text stands outside the stone, where nothing is drawn.
    place = corner + np.array([-0.05, 0.1 if angle > 0 else -0.1])
    axes.text(
        *place, text, fontsize=FONT_SIZE, color=PAPER.accent, ha="right", va="center_baseline", zorder=10
    )


def _along(axes: Axes, points: list[np.ndarray]) -> None:
    """Draw dimensions in a row along a radius."""
    for a, b in pairwise(points):
        middle = (a + b) / 2
        if np.hypot(*(b - a)) >= ARROWS_INSIDE:
            _arrow(axes, middle, a)
            _arrow(axes, middle, b)
        axes.plot(*np.array([a, b]).T, color=PAPER.accent, linewidth=0.8, zorder=6)
    axes.scatter(*np.array(points).T, s=9, color=PAPER.accent, zorder=7)


def _beside(axes: Axes, a: np.ndarray, b: np.ndarray, text: str) -> None:
    """Write a letter beside its dimension."""
    along = (b - a) / np.hypot(*(b - a))
    place = (a + b) / 2 + 0.06 * np.array([along[1], -along[0]])
    axes.text(
        *place, text, fontsize=FONT_SIZE, color=PAPER.accent, ha="center", va="center_baseline", zorder=10,
        fontstyle="italic",
    )  # fmt: skip


def _outside(axes: Axes, end: np.ndarray, text: str) -> None:
    """Write beyond the girdle, with a line to the dimension that ends there."""
    out = end / np.hypot(*end)
    place = end + 0.12 * out
    axes.plot(*np.array([end, place]).T, color=PAPER.accent, linewidth=PAPER.thin_width, zorder=5)
    axes.text(
        *(place + 0.02 * out), text, fontsize=FONT_SIZE, color=PAPER.accent, zorder=10, linespacing=1.3,
        ha="left" if out[0] > 0 else "right", va="center" if abs(out[1]) < 0.3 else "bottom",
    )  # fmt: skip

"""The outline of a round brilliant with its proportions, in three views as an engineering drawing."""

from __future__ import annotations

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
from gemrender.report.brilliant.dimensions import brilliant_dimensions
from gemrender.report.displays.dimension_lines import (
    draw_angle,
    draw_dimension,
    draw_row,
    write_beside,
    write_outside,
)
from gemrender.report.displays.page import PAPER, Page, draw_lines, stone_extent
from gemrender.report.displays.projection import CROWN, PAVILION, look_at, side
from gemrender.report.measured import Dimension
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["brilliant_outline_figure"]

SCALE = 2.2  # inch per girdle radius


def brilliant_outline_figure(stone: Stone) -> Figure:
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
    values = brilliant_dimensions(stone)
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

    draw_dimension(axes, table[0], table[1], (0.0, high + 0.17), _named(values["table"]))
    ends = [flat[np.argmin(flat[:, 0])], flat[np.argmax(flat[:, 0])]]
    draw_dimension(axes, ends[0], ends[1], (0.0, low - 0.15), "girdle diameter 100 %")
    x = right + 0.2
    draw_dimension(axes, table[1], girdle_top, (x, 0.0), _named(values["crown_height"]), upright=True)
    draw_dimension(
        axes, girdle_top, girdle_bottom, (x, 0.0), _named(values["girdle_thickness"]), upright=True
    )
    draw_dimension(axes, girdle_bottom, culet, (x, 0.0), _named(values["pavilion_depth"]), upright=True)
    draw_angle(axes, flat[GIRDLE_UPPER[8]], flat[TABLE_CORNER[4]], 0.30, _named(values["crown_angle"]))
    draw_angle(axes, flat[GIRDLE_LOWER[8]], culet, 0.34, _named(values["pavilion_angle"]))


def _crown_dimensions(axes: Axes, stone: Stone, values: dict[str, Dimension]) -> None:
    """SU along the radius of a star tip: from the middle of the table's edge to it, and on to the girdle."""
    v = stone.vertices[:, :2]
    k = 1
    start = (v[TABLE_CORNER[k]] + v[TABLE_CORNER[k + 1]]) / 2
    tip, end = v[STAR_TIP[k]], v[GIRDLE_UPPER[2 * k + 1]]
    draw_row(axes, [start, tip, end])
    write_beside(axes, start, tip, "a")
    write_beside(axes, tip, end, "b")
    write_outside(axes, end, f"SU a : b = {values['star'].text}")


def _pavilion_dimensions(axes: Axes, stone: Stone, values: dict[str, Dimension]) -> None:
    """LG along the radius of a contact: from the axis to the contact, and on to the girdle."""
    flat = PAVILION.flat(stone.vertices)
    k = 6
    contact, end = flat[CONTACT[k]], flat[GIRDLE_LOWER[2 * k + 1]]
    centre = flat[CULET]
    draw_row(axes, [centre, contact, end])
    value = values["lower_girdle_contact"]
    write_outside(axes, end, f"{_named(value)}\nlower half {100 - value.value:.2f} %")


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

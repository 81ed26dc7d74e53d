"""The outline of any stone with its dimensions, and its tiers: three views as an engineering drawing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gemrender.report.displays.dimension_lines import draw_dimension
from gemrender.report.displays.page import PAPER, Page, draw_lines, stone_extent
from gemrender.report.displays.projection import CROWN, PAVILION, corners_of, look_at, side
from gemrender.report.measured import Dimension, measured_dimensions
from gemrender.report.tiers import TierFigures, tiers_of_stone
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_tiers", "outline_figure"]

SCALE = 2.2  # inch per unit
#: Least room for the tables [inch], and the width of that of dimensions.
_TABLES, _FIGURES = 4.0, 2.55
#: Height of a line of the tables, and the largest size of their letters [inch], [points].
_LINE, _SIZE = 0.30, 11.0
#: Width of a bold letter of size 1, on the average [inch].
_LETTER = 0.0095
#: Least height of a line; tiers that have no room for it are left out: `gemrender inspect` lists all [inch].
_LEAST_LINE = 0.18


def outline_figure(stone: Stone) -> Figure:
    """Draw the outline in three views to one scale, with dimension lines, its dimensions and its tiers."""
    low, high, radius = stone_extent(stone)
    column = 2 * radius * SCALE + 2.3
    upper, lower = 2 * radius * SCALE + 1.35, max((high - low) * SCALE + 1.95, _TABLES)
    page = Page(
        stone,
        "Outline and dimensions",
        width=2 * column + 0.5 + 2 * Page.MARGIN,
        height=upper + lower + Page.TITLE + Page.MARGIN,
    )
    values = measured_dimensions(stone)
    left, right = Page.MARGIN, Page.MARGIN + column + 0.5
    bottom, top = Page.MARGIN, Page.MARGIN + lower
    crown = page.view(left, top + 0.3, column, upper - 0.3, scale=SCALE, centre=(0.2, -0.06))
    draw_lines(crown, look_at(stone, CROWN), PAPER)
    _plan_dimensions(crown, stone, values)
    page.caption(left, top + 0.1, column, CROWN.name)

    pavilion = page.view(right, top + 0.3, column, upper - 0.3, scale=SCALE, centre=(0.2, -0.06))
    draw_lines(pavilion, look_at(stone, PAVILION), PAPER)
    page.caption(right, top + 0.1, column, PAVILION.name)

    # A little wider: the heights stand to the right of the side view.
    profile = page.view(
        left, bottom + 0.3, column + 0.6, lower - 0.3, scale=SCALE,
        centre=(0.2 + 0.3 / SCALE, (low + high) / 2 + 0.03),
    )  # fmt: skip
    draw_lines(profile, look_at(stone, side()), PAPER)
    _side_dimensions(profile, stone, values)
    page.caption(left, bottom + 0.1, column, "Side view")
    width = column - 0.5
    _draw_figures(page.axes(right + 0.5, bottom, _FIGURES, lower), values)
    tiers = page.axes(right + 0.8 + _FIGURES, bottom, width - _FIGURES - 0.3, lower)
    draw_tiers(tiers, tiers_of_stone(stone))
    return page.figure


def _plan_dimensions(axes: Axes, stone: Stone, values: dict[str, Dimension]) -> None:
    """Length and width of the outline, and the table's width, where there is one."""
    flat = corners_of(stone)[:, :2]
    low, high = flat.min(axis=0), flat.max(axis=0)
    if stone.is_round:
        low, high = np.full(2, -1.0), np.full(2, 1.0)
    lies = high[0] - low[0] > high[1] - low[1]  # the length, along x
    level, upright = ("length", "width") if lies else ("width", "length")
    ends = [flat[flat[:, 0].argmin()], flat[flat[:, 0].argmax()]]
    draw_dimension(axes, ends[0], ends[1], (0.0, low[1] - 0.2), _named(values[level]))
    ends = [flat[flat[:, 1].argmin()], flat[flat[:, 1].argmax()]]
    draw_dimension(axes, ends[0], ends[1], (high[0] + 0.2, 0.0), _named(values[upright]), upright=True)


def _side_dimensions(axes: Axes, stone: Stone, values: dict[str, Dimension]) -> None:
    """Heights of crown, girdle and pavilion, from the top to the bottom."""
    low, high, _ = stone_extent(stone)
    flat = side().flat(corners_of(stone))
    width = 2.0 * min(1.0, 1.0 / values["length_to_width"].value)
    edges = [high, high - values["crown_height"].value * width / 100]
    edges += [low + values["pavilion_depth"].value * width / 100, low]
    x = flat[:, 0].max() + 0.2
    for upper, lower, name in zip(
        edges, edges[1:], ("crown_height", "girdle_thickness", "pavilion_depth"), strict=False
    ):
        ends = [_outermost(flat, height) for height in (upper, lower)]
        if upper - lower > 1e-9 or name == "girdle_thickness":
            draw_dimension(axes, ends[0], ends[1], (x, 0.0), _named(values[name]), upright=True)


def _outermost(flat: np.ndarray, height: float) -> np.ndarray:
    """Return the rightmost corner at a height, or a point at that height above the rightmost corner."""
    near = flat[np.abs(flat[:, 1] - height) < 1e-6]
    x = near[:, 0].max() if len(near) else flat[:, 0].max()
    return np.array([x, height])


def _draw_figures(axes: Axes, values: dict[str, Dimension]) -> None:
    """Draw the table of dimensions."""
    width, height = axes.get_xlim()[1], axes.get_ylim()[1]
    y = height - 0.55
    axes.text(0, y, "Dimensions", fontsize=10.5, color=PAPER.soft)
    for key, value in values.items():
        if key == "width":
            continue
        y -= _LINE
        axes.plot([0, width], [y + 0.21] * 2, color=PAPER.faint, linewidth=0.6)
        axes.text(0, y, value.name, fontsize=_SIZE, color=PAPER.ink)
        axes.text(width, y, value.text, fontsize=_SIZE, color=PAPER.ink, ha="right")
        if value.spread:
            y -= 0.22
            axes.text(width, y, f"{value.spread} %", fontsize=9.5, color=PAPER.soft, ha="right")
    axes.plot([0, width], [y - 0.09] * 2, color=PAPER.faint, linewidth=0.6)
    axes.text(
        0, y - 0.2, "In % of the width; the crown above\nthe girdle’s highest point, the pavilion\nbelow its "
        "lowest.", fontsize=9.5, color=PAPER.soft, va="top", linespacing=1.3,
    )  # fmt: skip


def draw_tiers(axes: Axes, tiers: tuple[TierFigures, ...]) -> None:
    """Draw the table of tiers: name, number of facets and angle; smaller if there are many."""
    width, height = axes.get_xlim()[1], axes.get_ylim()[1]
    most = int((height - 0.75) / _LEAST_LINE) - 1
    shown = tiers[: 2 * most]
    columns = 1 if len(shown) <= 0.75 * most else 2
    rows = -(-len(shown) // columns) + (len(shown) < len(tiers))
    step = min(0.26, (height - 0.75) / rows)
    size = min(_SIZE, 42.0 * step)
    across = width / columns
    axes.text(0, height - 0.55, "Tiers: facets, angle", fontsize=10.5, color=PAPER.soft)
    for number, tier in enumerate(shown):
        column, row = divmod(number, -(-len(shown) // columns))
        x, y = column * across, height - 0.55 - (row + 1) * step
        colour = PAPER.soft if tier.side == "girdle" else PAPER.ink
        name = _shortened(tier.name, int((0.5 * across - 0.3) / (_LETTER * size)))
        axes.text(x, y, name, fontsize=size, color=PAPER.accent, fontweight="bold",
                  parse_math=False)  # fmt: skip
        axes.text(x + 0.5 * across, y, f"{tier.number}", fontsize=size, color=colour, ha="right")
        axes.text(x + 0.92 * across, y, _angle(tier), fontsize=size, color=colour, ha="right")
    if len(shown) < len(tiers):
        text = f"and {len(tiers) - len(shown)} more (gemrender inspect)"
        axes.text(0, height - 0.55 - (rows + 0.2) * step, text, fontsize=size, color=PAPER.soft)


def _shortened(name: str, most: int) -> str:
    return name if len(name) <= most else f"{name[: most - 1]}…"


def _angle(tier: TierFigures) -> str:
    if tier.angle_deg is None:
        return "90°"
    least, most = tier.least_angle_deg, tier.most_angle_deg
    assert least is not None
    assert most is not None
    return f"{tier.angle_deg:.2f}°" if most - least < 0.005 else f"{least:.1f}–{most:.1f}°"


def _named(value: Dimension) -> str:
    return f"{value.symbol} {value.text}"

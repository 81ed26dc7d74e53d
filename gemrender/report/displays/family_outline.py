"""The outline of a cut of a family, with what its family says of it: views, parameters and tiers."""

from __future__ import annotations

import textwrap
from dataclasses import fields
from typing import TYPE_CHECKING

import numpy as np

from gemrender.cuts.families.family import Family
from gemrender.cuts.families.parameters import unit_of
from gemrender.cuts.marks import VIEWS
from gemrender.report.displays.marks import MarkedView
from gemrender.report.displays.outline import draw_tiers
from gemrender.report.displays.page import PAPER, Page, draw_lines, stone_extent
from gemrender.report.displays.projection import CROWN, PAVILION, Projection, look_at, side
from gemrender.report.tiers import tiers_of_stone
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["family_outline_figure"]

SCALE = 2.1  # inch per unit
#: What the views are called.
_CAPTIONS = {
    "crown": "Crown view", "pavilion": "Pavilion view", "width": "Side view: across the width",
    "length": "Side view: along the length",
}  # fmt: skip
#: Room for a caption, and least width of a view [inch].
_CAPTION, _LEAST = 0.35, 3.0
#: Width of the tables, and height of a line of the parameters and of one of the tiers [inch].
_TABLE, _LINE, _TIER = 4.5, 0.29, 0.26


def family_outline_figure(stone: Stone) -> Figure:
    """Draw a cut of a family in four views to one scale, with its marks, its parameters and its tiers."""
    cut = stone.cut
    assert isinstance(cut, Family)
    name = cut.family()
    projections: dict[str, Projection] = {"crown": CROWN, "pavilion": PAVILION, "width": side()}
    if not stone.is_round:
        projections["length"] = side(90.0)
    boxes = {view: _box(stone, view) for view in projections}
    marks = cut.marks()
    views = {
        view: MarkedView(marks, view, low=low, high=high, scale=SCALE) for view, (low, high) in boxes.items()
    }

    # Two columns of two views each, and the tables: in a third column, or where a round stone has no view.
    columns = (("crown", "width"), ("pavilion", "length"))
    rows = (("crown", "pavilion"), ("width", "length"))
    sizes = {view: (high - low) * SCALE for view, (low, high) in boxes.items()}
    left = [max(views[view].left + sizes[view][0] / 2 for view in pair if view in views) for pair in columns]
    right = [
        max(views[view].right + sizes[view][0] / 2 for view in pair if view in views) for pair in columns
    ]
    above = [max(views[view].above + sizes[view][1] / 2 for view in pair if view in views) for pair in rows]
    below = [max(views[view].below + sizes[view][1] / 2 for view in pair if view in views) for pair in rows]
    wide = [max(a + b, _LEAST) for a, b in zip(left, right, strict=True)]
    high = [a + b + _CAPTION for a, b in zip(above, below, strict=True)]
    tables = _Tables(stone, cut)
    if stone.is_round:
        wide[1], high[1] = max(wide[1], 2 * _TABLE + 0.4), max(high[1], tables.side_by_side)
    else:
        high[0] += max(0.0, tables.stacked - sum(high))
    page = Page(
        stone,
        f"{name[:1].upper()}{name[1:]}: outline and dimensions",
        width=sum(wide) + 0.4 + (0.0 if stone.is_round else _TABLE + 0.4) + 2 * Page.MARGIN,
        height=sum(high) + Page.TITLE + Page.MARGIN,
    )
    x = (Page.MARGIN, Page.MARGIN + wide[0] + 0.4)
    y = (Page.MARGIN + high[1], Page.MARGIN)
    for row, pair in enumerate(rows):
        for column, view in enumerate(pair):
            if view not in views:
                continue
            low, top = boxes[view]
            # The middle of the stone is where both views of a column, or of a row, have room.
            inch = np.array([left[column] + (wide[column] - left[column] - right[column]) / 2,
                             below[row] + (high[row] - _CAPTION - above[row] - below[row]) / 2])  # fmt: skip
            size = np.array([wide[column], high[row] - _CAPTION])
            centre = (low + top) / 2 + (size / 2 - inch) / SCALE
            axes = page.view(x[column], y[row] + _CAPTION, *size, scale=SCALE, centre=centre)
            draw_lines(axes, look_at(stone, projections[view]), PAPER)
            views[view].draw(axes)
            words = "Side view" if stone.is_round and view == "width" else _CAPTIONS[view]
            page.caption(x[column] + inch[0] - wide[column] / 2, y[row] + 0.1, wide[column], words)
    if stone.is_round:
        tables.draw_parameters(page.axes(x[1], y[1], _TABLE, high[1]))
        tables.draw_tiers(page.axes(x[1] + _TABLE + 0.4, y[1], _TABLE, high[1]))
    else:
        at = x[1] + wide[1] + 0.4
        lower = sum(high) - tables.parameters
        tables.draw_parameters(page.axes(at, Page.MARGIN + lower, _TABLE, tables.parameters))
        tables.draw_tiers(page.axes(at, Page.MARGIN, _TABLE, lower))
    return page.figure


def _box(stone: Stone, view: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of a stone's box on the page, (2,) each [stone's unit]."""
    corners = stone.solid.vertices
    low, high = corners.min(axis=0), corners.max(axis=0)
    if stone.is_round:
        radius = stone_extent(stone)[2]
        low[:2], high[:2] = -radius, radius
    ends = np.array([low, high]) @ VIEWS[view].T
    return ends.min(axis=0), ends.max(axis=0)


class _Tables:
    """The parameters of a cut with their units and their family's defaults, and its tiers."""

    def __init__(self, stone: Stone, cut: Family) -> None:
        self._tiers = tiers_of_stone(stone)
        self._rows = [
            (_label(part.name), _valued(cut, part.name, getattr(cut, part.name)),
             _valued(cut, part.name, part.default))
            for part in fields(cut)  # type: ignore[arg-type]
        ]  # fmt: skip
        self._rows += [
            (_label(name), _valued(cut, name, float(value)), "") for name, value in cut.alternatives().items()
        ]
        if stone.size_mm is not None:
            low, high = stone.solid.vertices.min(axis=0), stone.solid.vertices.max(axis=0)
            sides = (high - low) * stone.size_mm / 2.0
            if stone.is_round:
                sides[:2] = stone.size_mm
            width, length = sorted(sides[:2].tolist())
            self._rows.append(("size", f"{length:.2f} × {width:.2f} × {sides[2]:.2f} mm", ""))
        taken = f"Taken: {'; '.join(stone.assumed)}." if stone.assumed else ""
        self._taken = textwrap.wrap(taken, 72)

    @property
    def parameters(self) -> float:
        """Height of the table of parameters [inch]."""
        return 0.75 + _LINE * len(self._rows) + 0.17 * len(self._taken) + 0.2

    @property
    def stacked(self) -> float:
        """Height of both tables, one above the other [inch]."""
        return self.parameters + 1.15 + _TIER * len(self._tiers)

    @property
    def side_by_side(self) -> float:
        """Height of both tables, side by side [inch]."""
        return max(self.parameters, 1.15 + _TIER * len(self._tiers))

    def draw_parameters(self, axes: Axes) -> None:
        width, height = axes.get_xlim()[1], axes.get_ylim()[1]
        y = height - 0.45
        ends = (0.0, 0.67 * width, width)
        axes.text(ends[0], y, "Parameters", fontsize=10.5, color=PAPER.soft)
        axes.text(ends[2], y, "default", fontsize=10.5, color=PAPER.soft, ha="right")
        for name, value, default in self._rows:
            y -= _LINE
            colour = PAPER.ink if default else PAPER.soft
            axes.plot([0, width], [y + 0.2] * 2, color=PAPER.faint, linewidth=0.6)
            axes.text(ends[0], y, name, fontsize=10.5, color=colour)
            weight = "bold" if default not in ("", value) else "normal"
            axes.text(ends[1], y, value, fontsize=10.5, color=colour, ha="right", fontweight=weight)
            axes.text(ends[2], y, default, fontsize=10.5, color=PAPER.soft, ha="right")
        axes.plot([0, width], [y - 0.09] * 2, color=PAPER.faint, linewidth=0.6)
        y -= 0.1
        for line in self._taken:
            y -= 0.17
            axes.text(0, y, line, fontsize=8.5, color=PAPER.soft)

    def draw_tiers(self, axes: Axes) -> None:
        draw_tiers(axes, self._tiers)


def _label(name: str) -> str:
    return name.replace("_", " ")


def _valued(cut: Family, name: str, value: object) -> str:
    """Return the value of a parameter with its unit, as it is written."""
    if isinstance(value, tuple):
        return ", ".join(_valued(cut, name, one) for one in value)
    if not isinstance(value, float):
        return f"{value}"
    unit = unit_of(cut, name)
    return f"{value:.4g}{'°' if unit == 'deg' else f' {unit}' if unit else ''}"

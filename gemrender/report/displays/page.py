"""The page that every display is drawn on: its size, its views to one scale, its title and its colours."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

import gemrender
from gemrender.report.displays.projection import CROWN, PAVILION, StoneView, look_at, side
from gemrender.report.lettering import boxes_for_letters, name_fonts
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["DARK", "PAPER", "Page", "Theme", "draw_lines", "fill_facets", "stone_extent", "three_views"]

#: Resolution of PNG files [pixels per inch].
DPI = 160


@dataclass(frozen=True, slots=True, kw_only=True)
class Theme:
    """Colours of a page, and widths of its lines [points]."""

    ground: str
    ink: str
    soft: str
    accent: str
    faint: str
    outline_width: float = 1.7
    edge_width: float = 0.9
    thin_width: float = 0.6


#: Ink on white paper, dimensions in blue.
PAPER = Theme(ground="#ffffff", ink="#16202b", soft="#5b6874", accent="#0b5cad", faint="#b9c2ca")
#: The paper's dark ground for rays.
DARK = Theme(
    ground="#10141a", ink="#e8edf2", soft="#9aa7b4", accent="#7fb4e6", faint="#36424f",
    outline_width=1.2, edge_width=0.8,
)  # fmt: skip


class Page:
    """A figure measured in inches from its lower left corner.

    Parameters
    ----------
    stone : Stone
        Whose name is the title.
    title : str
        What is shown.
    width, height : float
        Size [inch].
    theme : Theme
        Colours.
    """

    #: Room for the title at the top [inch].
    TITLE = 0.85
    #: Margin all around [inch].
    MARGIN = 0.4

    def __init__(
        self, stone: Stone, title: str, *, width: float, height: float, theme: Theme = PAPER
    ) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.theme, self.width, self.height = theme, width, height
        self.figure: Figure = Figure(figsize=(width, height), dpi=DPI, facecolor=theme.ground)
        FigureCanvasAgg(self.figure)
        self._write_title(stone.name, title)

    def axes(self, left: float, bottom: float, width: float, height: float) -> Axes:
        """Return a frameless axes whose data are inches from its lower left corner."""
        axes = self.figure.add_axes(
            (left / self.width, bottom / self.height, width / self.width, height / self.height)
        )
        axes.set(xlim=(0, width), ylim=(0, height))
        axes.set_axis_off()
        return axes

    def view(
        self,
        left: float,
        bottom: float,
        width: float,
        height: float,
        *,
        scale: float,
        centre: Sequence[float],
    ) -> Axes:
        """Return an axes in girdle radii, to a scale [inch per unit], its centre in the middle."""
        axes = self.axes(left, bottom, width, height)
        x, y = width / scale / 2, height / scale / 2
        axes.set(xlim=(centre[0] - x, centre[0] + x), ylim=(centre[1] - y, centre[1] + y))
        return axes

    def caption(self, left: float, bottom: float, width: float, text: str) -> None:
        """Write a view's name in the middle of its column."""
        self.figure.text(
            (left + width / 2) / self.width, bottom / self.height, text,
            ha="center", va="baseline", fontsize=12.5, color=self.theme.soft,
        )  # fmt: skip

    def _write_title(self, name: str, subject: str) -> None:
        lines = textwrap.wrap(name, 46)
        size = 19.0 if len(lines) == 1 else 13.5
        top = (self.height - self.MARGIN) / self.height
        title = self.figure.text(
            self.MARGIN / self.width, top, "\n".join(lines), fontsize=size, fontweight="bold", va="top",
            color=self.theme.ink, family=name_fonts(), parse_math=False, linespacing=1.1,
        )  # fmt: skip
        with boxes_for_letters():
            wanted = title.get_window_extent().width / DPI
        title.set_fontsize(min(size, size * 0.55 * (self.width - 2 * self.MARGIN) / wanted))
        self.figure.text(
            1 - self.MARGIN / self.width, top, subject, fontsize=14, va="top", ha="right",
            color=self.theme.soft,
        )  # fmt: skip
        self.figure.text(
            1 - self.MARGIN / self.width, 0.16 / self.height, f"gemrender {gemrender.__version__}",
            fontsize=8, ha="right", color=self.theme.soft,
        )  # fmt: skip


def stone_extent(stone: Stone) -> tuple[float, float, float]:
    """Return the lowest and highest height and the largest radius of a stone [stone's unit]."""
    low, high = stone.vertices[:, 2].min(), stone.vertices[:, 2].max()
    return float(low), float(high), float(np.hypot(*stone.vertices[:, :2].T).max())


def three_views(
    stone: Stone,
    title: str,
    *,
    scale: float,
    draw: Callable[[Axes, StoneView], None],
    legend: Callable[[Axes], None],
) -> Figure:
    """Draw the crown and the pavilion view side by side, beneath them the side view and a legend.

    Parameters
    ----------
    stone : Stone
        The stone.
    title : str
        What the page shows.
    scale : float
        Inches a girdle radius.
    draw, legend : callable
        What draws one view, and the legend.
    """
    low, high, radius = stone_extent(stone)
    column = 2 * radius * scale + 1.1
    upper, lower = column + 0.25, (high - low) * scale + 1.3
    gap = 0.3
    page = Page(
        stone,
        title,
        width=2 * column + gap + 2 * Page.MARGIN,
        height=upper + lower + Page.TITLE + Page.MARGIN,
    )
    left, right = Page.MARGIN, Page.MARGIN + column + gap
    bottom, top = Page.MARGIN, Page.MARGIN + lower
    for projection, x, y, rows, centre in (
        (CROWN, left, top, upper, 0.0),
        (PAVILION, right, top, upper, 0.0),
        (side(), left, bottom, lower, (low + high) / 2),
    ):
        axes = page.view(x, y + 0.3, column, rows - 0.3, scale=scale, centre=(0.0, centre))
        draw(axes, look_at(stone, projection))
        page.caption(x, y + 0.1, column, projection.name)
    legend(page.axes(right, bottom, column, lower))
    return page.figure


def fill_facets(axes: Axes, view: StoneView, colours: Sequence[Any]) -> None:
    """Fill the facets that are seen, each with its colour, in their order."""
    from matplotlib.collections import PolyCollection

    axes.add_collection(
        PolyCollection(view.polygons, facecolors=colours, edgecolors=colours, linewidths=0.4, zorder=1),
        autolim=False,
    )


def draw_lines(
    axes: Axes, view: StoneView, theme: Theme, *, hidden: bool = False, strength: float = 1.0
) -> None:
    """Draw the edges that are seen, the outline in a heavier line, and the hidden ones if wanted."""
    from matplotlib.collections import LineCollection

    kinds = [
        (view.visible, theme.ink, theme.edge_width, 3.0),
        (view.outline, theme.ink, theme.outline_width, 4.0),
    ]
    if hidden:
        kinds.insert(0, (view.hidden, theme.faint, theme.thin_width, 2.0))
    for lines, colour, width, order in kinds:
        axes.add_collection(
            LineCollection(
                lines, colors=colour, linewidths=width, zorder=order, capstyle="round", joinstyle="round",
                alpha=None if colour == theme.faint else strength,
            ),
            autolim=False,
        )  # fmt: skip

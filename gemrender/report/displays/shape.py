"""The shape: crown, side and pavilion view, and one from above and the side, hidden lines removed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gemrender.report.displays.page import PAPER, Page, draw_lines, fill_facets, stone_extent
from gemrender.report.displays.projection import CROWN, OBLIQUE, PAVILION, Projection, look_at, side
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["shape_figure"]

SCALE = 2.2  # inch per unit
#: Where the light of the shading comes from, relative to the page: left, up and towards the eye.
LIGHT = np.array([-0.45, 0.55, 0.70])
#: Brightness of facets that face the light and that are turned away from it.
BRIGHTEST, DARKEST = 0.99, 0.83


def shape_figure(stone: Stone) -> Figure:
    """Draw the stone as a solid, in four views to one scale."""
    low, high, radius = stone_extent(stone)
    column = 2 * radius * SCALE + 0.5
    upper = 2 * radius * SCALE + 0.7
    level = look_at(stone, OBLIQUE)
    tall = np.concatenate(level.outline)[:, 1]
    lower = max(high - low, float(np.ptp(tall))) * SCALE + 0.7
    gap = 0.5
    width = 2 * column + gap + 2 * Page.MARGIN
    height = upper + lower + Page.TITLE + Page.MARGIN
    page = Page(stone, "Shape", width=width, height=height)

    left, right = Page.MARGIN, Page.MARGIN + column + gap
    bottom, top = Page.MARGIN, Page.MARGIN + lower
    middle = (tall.min() + tall.max()) / 2
    for projection, x, y, rows, centre in (
        (CROWN, left, top, upper, 0.0),
        (PAVILION, right, top, upper, 0.0),
        (side(), left, bottom, lower, (low + high) / 2),
        (OBLIQUE, right, bottom, lower, middle),
    ):
        axes = page.view(x, y + 0.3, column, rows - 0.3, scale=SCALE, centre=(0.0, centre))
        view = look_at(stone, projection)
        fill_facets(axes, view, [_grey(stone, facet, projection) for facet in view.facets])
        draw_lines(axes, view, PAPER)
        page.caption(x, y + 0.12, column, projection.name)
    return page.figure


def _grey(stone: Stone, facet: int, projection: Projection) -> tuple[float, float, float]:
    """Return a bluish grey, the lighter the more a facet is turned to the light."""
    has_plane = facet < len(stone.facet_normals)  # unlike a round girdle
    normal = stone.facet_normals[facet] if has_plane else projection.eye
    page = np.array([normal @ projection.right, normal @ projection.up, normal @ projection.eye])
    share = float(np.clip(page @ LIGHT / np.linalg.norm(LIGHT), 0.0, 1.0))
    grey = DARKEST + (BRIGHTEST - DARKEST) * share
    return grey - 0.02, grey, min(grey + 0.015, 1.0)

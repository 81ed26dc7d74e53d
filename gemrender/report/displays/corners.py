"""The corners of a stone, numbered: crown, side and pavilion view."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gemrender.report.displays.labels import Label, place_labels, write_with_room
from gemrender.report.displays.page import PAPER, draw_lines, three_views
from gemrender.report.displays.projection import CROWN, ONE_CORNER, PAVILION, StoneView, corners_of
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["corners_figure"]

SCALE = 2.6  # inch per unit
#: Size of the numbers [points]: the largest, of so many corners in a view, and the smallest.
_SIZE, _FEW, _SMALLEST = 10.0, 30, 4.5
#: Of more corners in a view, numbers stand where their points are, those that have room: a search for better
#: places would take minutes.
_MOST_PLACED = 150
#: Colours by height: above the girdle, at it, below it (Okabe and Ito's, darkened for text).
_COLOURS = {"above": "#0067a5", "girdle": "#00684a", "below": "#a83200"}
_MEANINGS = {"above": "above the girdle", "girdle": "at the girdle", "below": "below the girdle"}


def corners_figure(stone: Stone) -> Figure:
    """Draw the visible corners of three views with their numbers, from 1, from the table downwards."""
    corners = corners_of(stone)
    order = _order(corners)
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.arange(1, len(order) + 1)
    zones = _zones(stone, corners)
    unnumbered: list[int] = []

    def draw(axes: Axes, view: StoneView) -> None:
        draw_lines(axes, view, PAPER)
        unnumbered.append(_number_corners(axes, corners, number, zones, view))

    def legend(axes: Axes) -> None:
        _draw_legend(axes, number, zones, max(unnumbered))

    return three_views(stone, f"The {len(corners)} corners", scale=SCALE, draw=draw, legend=legend)


def _order(corners: np.ndarray) -> np.ndarray:
    """Return the corners from the top down, those of one height by azimuth."""
    heights = corners[:, 2].round(6)
    azimuth = np.arctan2(corners[:, 1], corners[:, 0]).round(6) % (2 * np.pi)
    return np.lexsort([azimuth, -heights])


def _zones(stone: Stone, corners: np.ndarray) -> list[str]:
    """Tell which corners lie at the girdle, above and below it."""
    solid = stone.solid
    if not stone.is_convex:
        return ["girdle" if abs(z) < ONE_CORNER else "above" if z > 0 else "below" for z in corners[:, 2]]
    sides = np.array(stone.facet_sides)[solid.facet]
    on = np.abs(corners @ solid.planes[:, :3].T - solid.planes[:, 3]) < ONE_CORNER
    level, down = on[:, sides == "girdle"].any(axis=1), on[:, sides == "pavilion"].any(axis=1)
    up = on[:, sides == "crown"].any(axis=1)
    if stone.is_round:
        level |= np.hypot(*corners[:, :2].T) > 1.0 - 1e-4
    return [
        "girdle" if g or (u and d) else "above" if u else "below"
        for g, u, d in zip(level, up, down, strict=True)
    ]


def _number_corners(
    axes: Axes, corners: np.ndarray, number: np.ndarray, zones: list[str], view: StoneView
) -> int:
    """Draw and number the corners that are seen; return how many have no room for their number."""
    flat = view.projection.flat(corners)
    shown = [v for v in view.corners if _belongs(view, corners, zones, v)]
    shown.sort(key=lambda v: -float(np.hypot(*flat[v])))
    if not shown:
        return 0
    size = max(_SMALLEST, _SIZE * min(1.0, (_FEW / len(shown)) ** 0.5))
    colours = [_COLOURS[zones[v]] for v in shown]
    axes.scatter(*flat[shown].T, s=1.2 * size, color=colours, zorder=6, linewidths=0.5, edgecolors="white")
    labels = [
        Label(text=f"{number[v]}", at=flat[v], towards=_outward(flat[v]), colour=_COLOURS[zones[v]])
        for v in shown
    ]
    if len(labels) > _MOST_PLACED:
        return len(labels) - len(write_with_room(axes, labels, fontsize=size, fontweight="bold"))
    place_labels(
        axes, labels, lines=[*view.visible, *view.outline], fontsize=size, fontweight="bold",
        halo=PAPER.ground, line_cost=1.2,
    )  # fmt: skip
    return 0


def _belongs(view: StoneView, corners: np.ndarray, zones: list[str], vertex: int) -> bool:
    """Whether a visible corner is numbered in a view: those at the girdle from above, or else from below."""
    if view.projection is CROWN:
        return zones[vertex] != "below"
    if view.projection is PAVILION:
        return zones[vertex] != "above"
    return bool(corners[vertex] @ view.projection.eye > -1e-6)


def _outward(place: np.ndarray) -> np.ndarray:
    radius = float(np.hypot(*place))
    return place / radius if radius > 1e-3 else np.array([0.0, 1.0])


def _draw_legend(axes: Axes, number: np.ndarray, zones: list[str], unnumbered: int) -> None:
    y = axes.get_ylim()[1] / 2 + 0.6
    axes.text(0.55, y, "Numbered from the top down", fontsize=10.5, color=PAPER.soft)
    for zone, colour in _COLOURS.items():
        own = number[[other == zone for other in zones]]
        if not len(own):
            continue
        y -= 0.37
        axes.scatter(0.35, y + 0.06, s=42, color=colour)
        axes.text(0.55, y, f"{len(own)}", fontsize=12, color=colour, fontweight="bold")
        axes.text(1.15, y, _MEANINGS[zone], fontsize=12)
    if unnumbered:
        text = f"Up to {unnumbered} corners of a view have no room for their number."
        axes.text(0.55, y - 0.45, text, fontsize=9.5, color=PAPER.soft)

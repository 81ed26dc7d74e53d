"""The 78 triangles and the girdle, numbered as the paper counts them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gemrender.cuts.round_brilliant.topology import (
    CONTACT,
    CULET,
    FACET_KINDS,
    FACET_POLYGONS,
    GIRDLE,
    GIRDLE_LOWER,
    N_TRIANGLES,
    TRIANGLE_FACET,
    TRIANGLES,
)
from gemrender.report.displays.labels import Label, fits, place_labels
from gemrender.report.displays.page import PAPER, draw_lines, fill_facets, three_views
from gemrender.report.displays.projection import EDGE_ON, StoneView
from gemrender.report.palettes import BRILLIANT_TINTS, draw_swatch
from gemrender.stone import Stone
from gemrender.stone.planes import flat_facets

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["GIRDLE_NUMBER", "brilliant_triangles_figure", "visible_triangles"]

SCALE = 2.45  # inch per girdle radius
FONT_SIZE = 10.0
#: The girdle is surface number 79 (`docs/model.md`, section 2); triangles count from 1.
GIRDLE_NUMBER = N_TRIANGLES + 1

#: Where the numbers of pavilion mains too narrow for them stand: their distance from the axis, over that of
#: the girdle, and their turn from the middle of the main [deg].
LEADER_RADIUS, LEADER_TURN_DEG = 1.075, 3.4

_MEANINGS = {
    "table": "table",
    "star": "star facets",
    "bezel": "bezel mains",
    "upper_girdle": "upper girdle facets",
    "lower_girdle": "lower girdle facets",
    "pavilion_main": "pavilion mains",
    "girdle": "girdle",
}


def brilliant_triangles_figure(stone: Stone) -> Figure:
    """Draw three views with the number of each visible triangle, and which facets they make."""
    return three_views(
        stone,
        f"The {N_TRIANGLES} triangles and the girdle",
        scale=SCALE,
        draw=lambda axes, view: _draw_triangles(axes, stone, view),
        legend=_draw_legend,
    )


def visible_triangles(stone: Stone, view: StoneView) -> list[int]:
    """Return the triangles (0 to 77) that are turned to the eye."""
    normals = flat_facets(stone.vertices, TRIANGLES, TRIANGLE_FACET)[:, :3]
    return [int(i) for i in np.flatnonzero(normals @ view.projection.eye > EDGE_ON)]


def _draw_triangles(axes: Axes, stone: Stone, view: StoneView) -> None:
    fill_facets(axes, view, [BRILLIANT_TINTS[FACET_KINDS[facet]] for facet in view.facets])
    shown = visible_triangles(stone, view)
    flat = view.projection.flat(stone.vertices)
    from_side = bool(view.projection.up[2])
    cuts = [flat[list(pair)] for pair in _cuts(shown)]
    for cut in cuts:
        axes.plot(*cut.T, color=PAPER.ink, linewidth=PAPER.thin_width, zorder=2.5)
    draw_lines(axes, view, PAPER)

    corners = {triangle: flat[TRIANGLES[triangle]] for triangle in shown}
    mains = [t for t in shown if FACET_KINDS[TRIANGLE_FACET[t]] == "pavilion_main"]
    roomy = all(fits(axes, Label(text="88", at=(0, 0), polygon=corners[t]), FONT_SIZE) for t in mains)
    labels = []
    for triangle in sorted(shown, key=lambda t: -_incircle(corners[t])[1]):
        number, (middle, _) = str(triangle + 1), _incircle(corners[triangle])
        if (
            triangle in mains and not roomy and not from_side
        ):  # one outside, all outside: for the order's sake
            at, outside = _main_leader(triangle, stone, view)
            labels.append(Label(text=number, at=at, otherwise=outside))
        else:
            labels.append(Label(text=number, at=middle, towards=middle, polygon=corners[triangle]))
    lines = [*view.visible, *view.outline, *cuts]
    if from_side:  # the plan views number all: here those that have room
        labels = [label for label in labels if fits(axes, label, FONT_SIZE)]
        labels.insert(0, Label(text=str(GIRDLE_NUMBER), at=_girdle_place(view), towards=(1.0, 0.0)))
    place_labels(axes, labels, lines=lines, fontsize=FONT_SIZE, colour=PAPER.ink, leader_colour=PAPER.soft)


def _main_leader(triangle: int, stone: Stone, view: StoneView) -> tuple[np.ndarray, np.ndarray]:
    """Return a point halfway along half a pavilion main, and a place outside the girdle for its number."""
    flat = view.projection.flat(stone.vertices)
    corners = TRIANGLES[triangle]
    girdle = next(v for v in corners if v in GIRDLE_LOWER)
    contact = next(v for v in corners if v in CONTACT)
    tip = flat[girdle]
    point = 0.3 * flat[contact] + 0.52 * tip + 0.18 * flat[CULET]
    turn = np.sign(tip[0] * flat[contact][1] - tip[1] * flat[contact][0]) * np.radians(LEADER_TURN_DEG)
    cos, sin = np.cos(turn), np.sin(turn)
    outside = LEADER_RADIUS * np.array([cos * tip[0] - sin * tip[1], sin * tip[0] + cos * tip[1]])
    return point, outside


def _cuts(shown: list[int]) -> list[tuple[int, int]]:
    """Edges between two visible triangles of one facet."""
    cuts = []
    for facet, polygon in enumerate(FACET_POLYGONS):
        if len(polygon) > 3 and set(np.flatnonzero(facet == TRIANGLE_FACET)) <= set(shown):
            cuts += [(polygon[0], other) for other in polygon[2:-1]]
    return cuts


def _incircle(corners: np.ndarray) -> tuple[np.ndarray, float]:
    """Centre and radius of a triangle's incircle."""
    sides = np.hypot(*(np.roll(corners, -1, axis=0) - np.roll(corners, 1, axis=0)).T)
    u, v = corners[1] - corners[0], corners[2] - corners[0]
    return (sides[:, None] * corners).sum(axis=0) / sides.sum(), abs(u[0] * v[1] - u[1] * v[0]) / sides.sum()


def _girdle_place(view: StoneView) -> np.ndarray:
    """Return a point on the girdle's wall at the right end of the side view."""
    polygon = view.polygons[view.facets.index(GIRDLE)]
    right = polygon[:, 0].max()
    near = polygon[polygon[:, 0] > right - 0.03]
    return np.array([right - 0.01, (near[:, 1].min() + near[:, 1].max()) / 2])


def _draw_legend(axes: Axes) -> None:
    height = axes.get_ylim()[1]
    kinds = list(dict.fromkeys(FACET_KINDS))
    y = height / 2 + 0.36 * len(kinds) / 2 + 0.15
    axes.text(0.95, y, "Triangles", fontsize=10.5, color=PAPER.soft)
    axes.text(2.35, y, "Facets", fontsize=10.5, color=PAPER.soft)
    for kind in kinds:
        y -= 0.38
        facets = [i for i, other in enumerate(FACET_KINDS) if other == kind]
        numbers = np.flatnonzero(np.isin(TRIANGLE_FACET, facets)) + 1
        text = f"{numbers[0]} – {numbers[-1]}" if numbers.size else f"{GIRDLE_NUMBER}"
        draw_swatch(axes, 0.45, y - 0.05, BRILLIANT_TINTS[kind])
        axes.text(0.95, y, text, fontsize=12, fontweight="bold")
        axes.text(2.35, y, f"{len(facets)}", fontsize=12, ha="right")
        axes.text(2.5, y, _MEANINGS[kind], fontsize=12)

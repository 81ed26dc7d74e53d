"""The 57 vertices, labelled: crown, side and pavilion view."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gemrender.cuts.round_brilliant.topology import (
    CONTACT,
    CULET,
    FACET_POLYGONS,
    GIRDLE,
    GIRDLE_LOWER,
    GIRDLE_UPPER,
    N_SECTORS,
    N_VERTICES,
    STAR_TIP,
    TABLE_CORNER,
)
from gemrender.report.displays.labels import Label, place_labels
from gemrender.report.displays.page import PAPER, draw_lines, three_views
from gemrender.report.displays.projection import CROWN, PAVILION, StoneView
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["VERTEX_CODES", "brilliant_vertices_figure", "visible_vertices"]

SCALE = 2.2  # inch per girdle radius
FONT_SIZE = 10.5
#: Contacts nearer to the axis than this are labelled further out, with leaders [girdle radius].
CROWDED = 0.35
#: How far behind the axis a vertex of the side view's rim may lie [girdle radius].
BEHIND = 0.05
#: Letter, first vertex, number, name in files, meaning and colour of each kind of vertex. The colours are
#: Okabe and Ito's, darkened for text.
_KINDS = (
    ("T", TABLE_CORNER[0], 8, "table", "table corners", "#8a5a00"),
    ("S", STAR_TIP[0], 8, "star", "star tips", "#0067a5"),
    ("U", GIRDLE_UPPER[0], 16, "girdle_upper", "girdle, upper edge", "#00684a"),
    ("L", GIRDLE_LOWER[0], 16, "girdle_lower", "girdle, lower edge", "#6a3d9a"),
    ("C", CONTACT[0], 8, "contact", "lower-girdle contacts", "#a83200"),
    ("K", CULET, 1, "culet", "culet", "#16202b"),
)


def _codes() -> tuple[str, ...]:
    return tuple(
        letter if count == 1 else f"{letter}{i}" for letter, _, count, *_ in _KINDS for i in range(count)
    )


#: A short label for each vertex: T0 is `table_0`.
VERTEX_CODES = _codes()
_COLOURS = tuple(colour for *_, count, _, _, colour in _KINDS for _ in range(count))


def brilliant_vertices_figure(stone: Stone) -> Figure:
    """Draw the visible vertices of three views with their labels, and what the labels mean."""

    def draw(axes: Axes, view: StoneView) -> None:
        draw_lines(axes, view, PAPER)
        _label_vertices(axes, stone, view)

    return three_views(stone, f"The {N_VERTICES} vertices", scale=SCALE, draw=draw, legend=_draw_legend)


def _label_vertices(axes: Axes, stone: Stone, view: StoneView) -> None:
    flat = view.projection.flat(stone.vertices)
    shown = sorted(_shown(stone, view), key=lambda v: _rank(v, flat))
    axes.scatter(
        *flat[shown].T, s=17, color=[_COLOURS[v] for v in shown], zorder=6, linewidths=0.7, edgecolors="white"
    )
    from_above = view.projection.up[2] == 0
    labels = [
        Label(
            text=VERTEX_CODES[v],
            at=flat[v],
            towards=_outward(flat[v]) if from_above else _away_from_girdle(v, flat[v]),
            otherwise=_beside_contact(v, flat) if from_above else None,
            colour=_COLOURS[v],
        )
        for v in shown
    ]
    place_labels(
        axes, labels, lines=[*view.visible, *view.outline], fontsize=FONT_SIZE, fontweight="bold",
        halo=PAPER.ground,
        line_cost=1.2,
    )  # fmt: skip


def _shown(stone: Stone, view: StoneView) -> list[int]:
    """Return the vertices to label: not those at the rim that are just about seen from behind."""
    seen = visible_vertices(view)
    if view.projection is CROWN:
        return [v for v in seen if v < GIRDLE_LOWER[0]]
    if view.projection is PAVILION:
        return [v for v in seen if v >= GIRDLE_LOWER[0]]
    depth = stone.vertices @ view.projection.eye
    return [v for v in seen if depth[v] > -BEHIND]


def visible_vertices(view: StoneView) -> list[int]:
    """Return the vertices (0 to 56) of the facets that are seen."""
    return sorted({v for facet in view.facets if facet != GIRDLE for v in FACET_POLYGONS[facet]})


def _rank(vertex: int, flat: np.ndarray) -> tuple[int, float]:
    """Label the culet's crowded neighbours before the others, and the outermost before the inner ones."""
    kind = next(i for i, (_, first, count, *_) in enumerate(_KINDS) if first <= vertex < first + count)
    return (-kind, -float(np.hypot(*flat[vertex])))


def _beside_contact(vertex: int, flat: np.ndarray) -> np.ndarray | None:
    """Return a place in the lower girdle facet beyond a contact near the culet: there is room for all."""
    if vertex not in CONTACT or np.hypot(*flat[vertex]) > CROWDED:
        return None
    k = vertex - CONTACT[0]
    sides = flat[GIRDLE_LOWER[[2 * k + 1, (2 * k + 2) % N_SECTORS]]]
    return np.asarray(flat[vertex] + 0.28 * (sides - flat[vertex]).mean(axis=0))


def _outward(place: np.ndarray) -> np.ndarray:
    radius = float(np.hypot(*place))
    return place / radius if radius > 1e-3 else np.array([0.0, 1.0])


def _away_from_girdle(vertex: int, place: np.ndarray) -> np.ndarray:
    """In the side view labels of the upper girdle go up, those of the lower one down."""
    if vertex == CULET:
        return np.array([0.0, -1.0])
    if vertex >= CONTACT[0]:  # out of the stone, if that is near
        return np.array([np.sign(place[0]), 0.15])
    up = vertex < GIRDLE_LOWER[0]
    sideways = 3.0 * max(abs(place[0]) - 0.8, 0.0) * np.sign(place[0]) + 0.3 * place[0]
    return np.array([sideways, 0.5 if up else -0.5])


def _draw_legend(axes: Axes) -> None:
    width, height = axes.get_xlim()[1], axes.get_ylim()[1]
    y = height / 2 + 1.05
    axes.text(0.55, y, "In the drawing", fontsize=10.5, color=PAPER.soft)
    axes.text(1.95, y, "In files", fontsize=10.5, color=PAPER.soft)
    for letter, _, count, name, meaning, colour in _KINDS:
        y -= 0.37
        axes.scatter(0.35, y + 0.06, s=42, color=colour)
        last = count - 1
        code = f"{letter}0 – {letter}{last}" if last else letter
        axes.text(0.55, y, code, fontsize=12, color=colour, fontweight="bold")
        axes.text(1.95, y, f"{name}_0 – {last}" if last else name, fontsize=12, family="monospace")
        axes.text(width, y, meaning, fontsize=10.5, color=PAPER.soft, ha="right")
    assert len(VERTEX_CODES) == N_VERTICES

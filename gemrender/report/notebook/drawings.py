"""Drawings within a page: lines of a stone, virtual facets as paths, maps as small pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np

from gemrender.report.displays.projection import Projection, look_at
from gemrender.report.facets import GIRDLE_COLOUR, FacetClasses, edge_colours, silhouette
from gemrender.report.figures import picture_of_rows
from gemrender.report.notebook.elements import svg
from gemrender.stone import Stone

if TYPE_CHECKING:
    from gemrender.beam import VirtualFacets

__all__ = ["MOST_POLYGONS", "facets_drawing", "map_pixels", "stone_drawing"]

#: So many units of a drawing are one of the stone's: coordinates are whole numbers.
_UNITS = 1000.0
#: Virtual facets that are drawn, the largest ones; a page must stay small.
MOST_POLYGONS = 3000
#: Pixels a side of a map, at most.
_SIDE = 400


def stone_drawing(stone: Stone, projection: Projection, width: int) -> str:
    """Return a view of a stone: its edges, the outline in a heavier line, in the colour of the text."""
    view = look_at(stone, projection)
    shapes = [
        f'<path d="{_lines(lines)}" fill="none" stroke="currentColor" stroke-width="{stroke}" '
        'stroke-linejoin="round" stroke-linecap="round"/>'
        for lines, stroke in ((view.visible, 8), (view.outline, 16))
        if lines
    ]
    corners = np.concatenate([_units(line) for line in (*view.visible, *view.outline)])
    low, high = corners.min(axis=0) - 20, corners.max(axis=0) + 20
    # All views of a stone are to one scale: a unit is as wide in each.
    wide = max(round(width * (high - low)[0] / (2 * _UNITS + 40)), 1)
    return svg(wide, (*low.tolist(), *(high - low).tolist()), f"{stone.name}: {projection.name}", *shapes)


def facets_drawing(facets: VirtualFacets, classes: FacetClasses, width: int) -> tuple[str, int]:
    """Return the virtual facets as a drawing, and how many of them are too small to be in it."""
    outline = silhouette(facets.stone, facets.view)
    largest = np.argsort(-facets.area[classes.drawn], kind="stable")[:MOST_POLYGONS]
    shapes = [
        f'<path d="{_area([outline])}" fill="{GIRDLE_COLOUR}" stroke="currentColor" stroke-width="14"/>'
    ]
    for number, (colour, edge) in enumerate(zip(classes.colours, edge_colours(classes.colours), strict=True)):
        chosen = classes.drawn[largest[classes.of[largest] == number]]
        if len(chosen):
            path = _area(facets.polygon(i) for i in chosen)
            shapes.append(f'<path d="{path}" fill="{colour}" stroke="{edge}" stroke-width="2"/>')
    low, high = _units(outline).min(axis=0), _units(outline).max(axis=0)
    low, high = np.minimum(low, -high)[:2] - 20, np.maximum(high, -low)[:2] + 20
    drawn = svg(
        width, (*low.tolist(), *(high - low).tolist()), f"{facets.stone.name}: virtual facets", *shapes
    )
    return drawn, max(len(classes.drawn) - MOST_POLYGONS, 0)


def map_pixels(picture: np.ndarray, coverage: np.ndarray) -> np.ndarray:
    """Return a picture of a map (n, n, 3), smaller, and transparent beside the stone, (m, m, 4) uint8."""
    covered = np.where(coverage > 0, 0.0, 255.0)[..., None].repeat(3, axis=2)
    beside: Callable[[slice], np.ndarray] = covered.__getitem__
    alpha = 255 - picture_of_rows(beside, len(coverage))[..., :1]
    pixels = np.concatenate([picture, alpha], axis=2)
    step = -(-len(pixels) // _SIDE)
    side = len(pixels) // step
    blocks = pixels[: side * step, : side * step].reshape(side, step, side, step, 4)
    return np.asarray(np.rint(blocks.mean(axis=(1, 3))), dtype=np.uint8)


def _units(points: np.ndarray) -> np.ndarray:
    """Return points (n, 2) in a drawing's units, y down."""
    return np.rint(points * (_UNITS, -_UNITS)).astype(np.int64)


def _lines(lines: Iterable[np.ndarray]) -> str:
    return "".join(_path(_units(line)) for line in lines)


def _area(polygons: Iterable[np.ndarray]) -> str:
    return "".join(f"{path}z" for polygon in polygons if "l" in (path := _path(_units(polygon))))


def _path(points: np.ndarray) -> str:
    """Return a line through points (n, 2), by steps; those that are none are left out."""
    steps = np.diff(points, axis=0)
    steps = steps[np.any(steps != 0, axis=1)]
    told = " ".join(f"{x} {y}" for x, y in steps.tolist())
    return f"M{points[0, 0]} {points[0, 1]}" + (f"l{told}" if told else "")

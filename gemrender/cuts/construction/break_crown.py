"""Rectangles with sharp or cut corners, and their crown of two rows: princess and radiant.

The rows ("breaks": Grossbard, US 4,020,649, 1977) begin at the girdle and at the table. Along each side the
girdle break is one facet, and above it the table break is a triangle; stars, triangles too, lie to both sides
of it along the table, which has eight corners: above the middles of the sides and in the corners.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.cuts.construction.meet_points import Construction, points_at

__all__ = [
    "Corners",
    "Table",
    "add_break_crown",
    "add_side_girdle",
    "corner_points",
    "diagonal_points",
    "side_points",
]


@dataclass(frozen=True, slots=True)
class Corners:
    """A rectangle whose corners may be cut.

    Parameters
    ----------
    half : pair of number
        Half its width (along x) and half its length (along y).
    cut : pair of number
        What is cut from a corner along x and along y; 0 for sharp corners.
    across : pair of number
        Direction (x, y) square to a cut corner, in the first quadrant.
    """

    half: tuple[Any, Any]
    cut: tuple[Any, Any]
    across: tuple[Any, Any]

    @property
    def is_sharp(self) -> bool:
        """Whether the corners are not cut."""
        return bool(np.real(self.cut[0]) <= 0)

    @property
    def quarter(self) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """Both ends of the corner in the first quadrant: on the side along x, and on the one along y."""
        (width, length), (x, y) = self.half, self.cut
        return (width - x, length), (width, length - y)


@dataclass(frozen=True, slots=True)
class Table:
    """A table with eight corners.

    Parameters
    ----------
    half : pair of number
        Half its width and length, where the corners above the middles of the sides are.
    corner : pair of number
        Its corner (x, y) in the first quadrant.
    """

    half: tuple[Any, Any]
    corner: tuple[Any, Any]

    @classmethod
    def turned(cls, half: tuple[Any, Any], tangent: Any) -> Table:
        """Return the table whose edges are turned away from the sides by an angle of this tangent."""
        x, y = half
        share = 1.0 - tangent * tangent
        return cls(half, ((x - tangent * y) / share, (y - tangent * x) / share))


def corner_points(on_x: tuple[Any, Any], on_y: tuple[Any, Any]) -> np.ndarray:
    """Return (8, 2): the ends of the corners, two each, anticlockwise from the left end of the side at +y.

    Given those in the first quadrant: on the side that runs along x, and on the one along y.
    """
    (ex, ey), (sx, sy) = on_x, on_y
    return np.array([(-ex, ey), (-sx, sy), (-sx, -sy), (-ex, -ey), (ex, -ey), (sx, -sy), (sx, sy), (ex, ey)])


def side_points(half: tuple[Any, Any]) -> np.ndarray:
    """Return (4, 2): points above the middles of the sides, anticlockwise from the side at +y."""
    x, y = half
    return np.array([(0.0, y), (-x, 0.0), (0.0, -y), (x, 0.0)])


def diagonal_points(corner: tuple[Any, Any]) -> np.ndarray:
    """Return (4, 2): points towards the corners, anticlockwise from the one at -x and +y."""
    x, y = corner
    return np.array([(-x, y), (-x, -y), (x, -y), (x, y)])


def add_break_crown(
    stone: Construction,
    outline: Corners,
    table: Table,
    *,
    height: Any,
    thickness: Any,
    share: Any,
    split_corners: bool,
) -> np.ndarray:
    """Add a crown; return the numbers of the girdle's upper edge, (8,) int64, as `corner_points`.

    Parameters
    ----------
    outline : Corners
        The girdle.
    table : Table
        The table.
    height, thickness : number
        Heights of crown and girdle.
    share : number
        Height of the edges between the two breaks [share of the crown's]; midway along the sides.
    split_corners : bool
        Whether a corner has a facet in each break; else one bezel from the girdle to the table.
    """
    x, y = outline.across
    on_y, (inner_x, inner_y) = outline.quarter[1], table.corner
    inset = [0.5 * (outer - inner) for outer, inner in zip(outline.half, table.half, strict=True)]
    girdle, top = x * on_y[0] + y * on_y[1], x * inner_x + y * inner_y
    # Of a bezel the edge between the breaks lies in its plane; else it is midway, as along the sides.
    line = girdle - (0.5 if split_corners else share) * (girdle - top)
    end, side = outline.half[1] - inset[1], outline.half[0] - inset[0]
    breaks = corner_points(((line - y * end) / x, end), (side, (line - x * side) / y))

    upper = _girdle_edge(stone, "girdle_upper", outline, thickness)
    b = stone.ring("break", points_at(breaks, thickness + share * height))
    middles = stone.ring("table_side", points_at(side_points(table.half), thickness + height))
    corners = stone.ring("table_corner", points_at(diagonal_points(table.corner), thickness + height))
    stone.facet("table", np.stack([middles, corners], axis=1).reshape(-1))
    for k in range(4):
        before, after = 2 * k, 2 * k + 1
        stone.facet("star", (middles[k], b[before], corners[k]))
        stone.facet("star", (corners[k], b[after], middles[(k + 1) % 4]))
        stone.facet("table_break", (middles[k], b[before - 1], b[before]))
        stone.facet("girdle_break", (upper[before - 1], upper[before], b[before], b[before - 1]))
        ends = tuple(dict.fromkeys((upper[before], upper[after])))
        if split_corners:
            stone.facet("table_break", (corners[k], b[before], b[after]))
            stone.facet("girdle_break", (*ends, b[after], b[before]))
        else:
            stone.facet("bezel", (corners[k], b[before], *ends, b[after]))
    return upper


def add_side_girdle(stone: Construction, upper: np.ndarray, outline: Corners) -> np.ndarray:
    """Add the girdle, one facet a side and a cut corner; return its lower edge, as `add_break_crown`."""
    lower = _girdle_edge(stone, "girdle_lower", outline, 0.0)
    for k in range(8):
        after = (k + 1) % 8
        if lower[k] != lower[after]:
            stone.facet("girdle", (lower[k], lower[after], upper[after], upper[k]))
    return lower


def _girdle_edge(stone: Construction, name: str, outline: Corners, height: Any) -> np.ndarray:
    """Add an edge of the girdle, with one point at a sharp corner; return its numbers, (8,) int64."""
    points = corner_points(*outline.quarter)
    if outline.is_sharp:
        return np.repeat(stone.ring(name, points_at(points[::2], height)), 2)
    return stone.ring(name, points_at(points, height))

"""What the outline of any stone measures: length, width, table, crown, girdle, pavilion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.stone import ConvexSolid, MeshSolid, Stone
from gemrender.stone.facets import CROWN, GIRDLE, LEVEL, PAVILION

__all__ = ["Dimension", "measured_dimensions"]

#: Level facets that stand for a round girdle: their ends, where it is thickest and thinnest, are on it.
_PIECES = 256
#: Along the girdle, corners this close are one, as they are meant: in designs angles are rounded, and facets
#: that should meet in a point leave a chamfer [stone's unit].
_CHAMFER = 1e-4
#: Edges of a smaller length are rounding: meshes come in single precision [stone's unit].
_LEAST_LENGTH = 1e-6
#: Places times edges that are looked at together.
_AT_ONCE = 1 << 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Dimension:
    """A dimension of a stone: of a measured one the mean of its values, and their spread.

    Attributes
    ----------
    symbol, name, unit : str
        A symbol ("" if it has none), the field's name, and "%", "°" or "" for a ratio.
    value, least, most : float
        Mean, smallest and largest value; all the same where there is only one.
    """

    symbol: str
    name: str
    unit: str
    value: float
    least: float
    most: float

    @classmethod
    def of(cls, symbol: str, name: str, unit: str, values: Any) -> Dimension:
        """Return the dimension that has these values, (n,) or one."""
        every = np.atleast_1d(values)
        mean, least, most = float(every.mean()), float(every.min()), float(every.max())
        return cls(symbol=symbol, name=name, unit=unit, value=mean, least=least, most=most)

    @property
    def text(self) -> str:
        """The value as it is written."""
        if self.symbol == "SU":
            a = self.value if self.least == self.most else round(self.value, 1)
            return f"{_short(a)} : {_short(100 - a)}"
        if not self.unit:
            return f"{self.value:.3f}"
        return f"{self.value:.2f}{'°' if self.unit == '°' else ' %'}"

    @property
    def spread(self) -> str:
        """The range of several values, as it is written; "" if there is none."""
        digits = 1 if self.symbol == "SU" else 2
        least, most = f"{self.least:.{digits}f}", f"{self.most:.{digits}f}"
        return "" if least == most else f"{least} – {most}"


def measured_dimensions(stone: Stone) -> dict[str, Dimension]:
    """Return what any stone measures, in per cent of its width.

    Length and width are the longer and the shorter side of the outline's bounding box. The table is as wide
    as it is along the width. The crown is high above the highest point of the girdle's upper edge, the
    pavilion deep below the lowest point of its lower edge; without a girdle, of the edge between both. The
    girdle's thickness is told from its thinnest to its thickest place, and its mean along the outline.

    Returns
    -------
    dict of str to Dimension
        length, width, length_to_width, table (where there is one), crown_height, girdle_thickness,
        pavilion_depth, total_depth.
    """
    corners = stone.solid.vertices
    low, high = corners.min(axis=0), corners.max(axis=0)
    if stone.is_round:
        low[:2], high[:2] = -1.0, 1.0
    sides = (high - low)[:2]
    across = int(sides.argmin())
    length, width = float(sides.max()), float(sides.min())
    upper, lower = _girdle_heights(stone)
    thickness, mean = _girdle_thickness(stone)
    percent = 100.0 / width
    girdle = Dimension(
        symbol="GH", name="girdle thickness", unit="%", value=percent * mean,
        least=percent * min(thickness), most=percent * max(thickness),
    )  # fmt: skip
    table = _table_width(stone, across)
    return {
        "length": Dimension.of("L", "length", "%", percent * length),
        "width": Dimension.of("W", "width", "%", 100.0),
        "length_to_width": Dimension.of("L/W", "length to width", "", length / width),
        **({} if table is None else {"table": Dimension.of("TB", "table", "%", percent * table)}),
        "crown_height": Dimension.of("CH", "crown height", "%", percent * (float(high[2]) - upper)),
        "girdle_thickness": girdle,
        "pavilion_depth": Dimension.of("PD", "pavilion depth", "%", percent * (lower - float(low[2]))),
        "total_depth": Dimension.of("TD", "total depth", "%", percent * float(high[2] - low[2])),
    }


# ---- The girdle ----------------------------------------------------------------------------------------


def _sides(stone: Stone) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
    """Return corners (v, 3), polygons (their corners' numbers, anticlockwise), and the side of each."""
    solid = stone.solid
    of_facet = np.array(stone.facet_sides)
    if isinstance(solid, MeshSolid):
        return solid.vertices, list(solid.triangles), of_facet[solid.facet]
    body = solid.cut(_PIECES) if solid.is_round else solid.polyhedron
    facet = np.full(len(body.planes), solid.n_facets - 1)
    facet[: len(solid.facet)] = solid.facet
    bounds = np.flatnonzero(body.bounds)
    return body.vertices, [body.polygon(int(i)) for i in bounds], of_facet[facet[bounds]]


def _girdle_heights(stone: Stone) -> tuple[float, float]:
    """Return the highest point of the crown's lower edge, and the lowest of the pavilion's upper edge."""
    vertices, polygons, sides = _sides(stone)
    touched = {side: np.zeros(len(vertices), dtype=bool) for side in (CROWN, GIRDLE, PAVILION)}
    for polygon, side in zip(polygons, sides, strict=True):
        touched[side][polygon] = True
    heights = vertices[:, 2]
    upper = touched[CROWN] & (touched[GIRDLE] | touched[PAVILION])
    lower = touched[PAVILION] & (touched[GIRDLE] | touched[CROWN])
    # A slab has neither crown nor pavilion: its girdle goes from the one face to the other.
    top = heights[upper].max() if upper.any() else heights.max()
    bottom = heights[lower].min() if lower.any() else heights.min()
    return float(top), float(bottom)


def _girdle_thickness(stone: Stone) -> tuple[list[float], float]:
    """Return the girdle's thickness wherever an edge begins or ends, and its mean along the outline."""
    vertices, polygons, sides = _sides(stone)
    if isinstance(stone.solid, MeshSolid):
        walls = [wall[None] for wall in _walls_of(stone.solid, sides == GIRDLE, len(stone.facet_normals))]
    else:  # those with as many corners at once
        by_corners: dict[int, list[np.ndarray]] = {}
        for polygon, side in zip(polygons, sides, strict=True):
            if side == GIRDLE:
                by_corners.setdefault(len(polygon), []).append(vertices[polygon][None])
        walls = [np.array(alike) for alike in by_corners.values()]
    thickness, area, around = [], 0.0, 0.0
    for alike in walls:  # (w, polygons of each, corners of each, 3)
        edges = np.stack([alike, np.roll(alike, -1, axis=2)], axis=3).reshape(len(alike), -1, 2, 3)
        flat = np.stack([np.einsum("weki,wi->wek", edges[..., :2], _along(edges)), edges[..., 2]], axis=-1)
        places = np.sort(flat[:, :, 0, 0].round(6), axis=1)
        if len(alike) == 1:  # of a fine mesh most are the same
            places = np.unique(places)[None]
        heights = _heights_at(flat, places)
        widths = np.diff(places, axis=1)
        is_apart = np.insert(widths > _CHAMFER, 0, True, axis=1)
        thickness += np.maximum.reduceat(heights.ravel(), np.flatnonzero(is_apart)).tolist()
        area += 0.5 * float((widths * (heights[:, 1:] + heights[:, :-1])).sum())
        around += float(widths.sum())
    if _has_knife_edge(vertices, polygons, sides) or not thickness:
        thickness.append(0.0)
    return thickness, area / around if around else 0.0


def _walls_of(solid: MeshSolid, is_girdle: np.ndarray, n_planes: int) -> list[np.ndarray]:
    """Gather the triangles (n, 3, 3) of a mesh's girdle that lie in one plane."""
    walls: dict[tuple[float, ...], list[np.ndarray]] = {}
    for number in np.flatnonzero(is_girdle):
        facet, piece = int(solid.facet[number]), solid.vertices[solid.triangles[number]]
        key: tuple[float, ...] = (facet,)
        if facet >= n_planes:  # a girdle that is not plane: upright pieces, each above one line
            ends = np.unique((piece[:, :2] / _LEAST_LENGTH).round(), axis=0)
            key = (facet, *ends.ravel().tolist())
        walls.setdefault(key, []).append(piece)
    return [np.array(wall) for wall in walls.values()]


def _along(edges: np.ndarray) -> np.ndarray:
    """Return the level direction in which each wall of edges (w, n, 2, 3) runs, (w, 2)."""
    level = edges[:, :, 0, :2] - edges[:, :1, 0, :2]
    farthest = np.hypot(level[..., 0], level[..., 1]).argmax(axis=1)
    far = level[np.arange(len(edges)), farthest]
    return np.asarray(far / np.hypot(far[:, 0], far[:, 1])[:, None])


def _heights_at(edges: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return how high walls of edges (w, n, 2, 2) are at places (w, m) along them, on edges, (w, m)."""
    rows = max(1, _AT_ONCE // edges[..., 0, 0].size)
    if places.shape[1] > rows:
        parts = np.split(places, range(rows, places.shape[1], rows), axis=1)
        return np.concatenate([_heights_at(edges, part) for part in parts], axis=1)
    from_x, from_z, to_x, to_z = (edges[:, None, :, end, along] for end in (0, 1) for along in (0, 1))
    place = places[..., None]
    near = (np.minimum(from_x, to_x) <= place + _LEAST_LENGTH) & (
        np.maximum(from_x, to_x) >= place - _LEAST_LENGTH
    )
    upright = np.abs(to_x - from_x) <= _LEAST_LENGTH
    share = np.clip((place - from_x) / np.where(upright, 1.0, to_x - from_x), 0.0, 1.0)
    between = from_z + share * (to_z - from_z)
    one, other = np.where(upright, from_z, between), np.where(upright, to_z, between)
    top = np.where(near, np.maximum(one, other), -np.inf).max(axis=2)
    return np.asarray(top - np.where(near, np.minimum(one, other), np.inf).min(axis=2))


def _has_knife_edge(vertices: np.ndarray, polygons: list[np.ndarray], sides: np.ndarray) -> bool:
    """Whether crown and pavilion meet along an edge: there the girdle has no thickness."""
    edges: dict[tuple[int, int], str] = {}
    for polygon, side in zip(polygons, sides, strict=True):
        if side == GIRDLE:
            continue
        for a, b in zip(polygon.tolist(), np.roll(polygon, -1).tolist(), strict=True):
            other = edges.setdefault((b, a), side) if (b, a) in edges else edges.setdefault((a, b), side)
            if other != side and np.linalg.norm(vertices[a] - vertices[b]) > _CHAMFER:
                return True
    return False


def _table_width(stone: Stone, axis: int) -> float | None:
    """Return how far the table reaches along x (0) or y (1); None where no crown facet is level."""
    solid = stone.solid
    normals = stone.facet_normals
    level = [number for number in range(len(normals)) if normals[number, 2] > 1.0 - LEVEL]
    if not level:
        return None
    table = max(level, key=lambda number: solid.areas[number])
    if isinstance(solid, ConvexSolid):
        planes = np.flatnonzero(solid.facet == table)
        corners = np.concatenate([solid.polyhedron.polygon(int(plane)) for plane in planes])
    else:
        corners = solid.triangles[solid.facet == table].reshape(-1)
    return float(np.ptp(solid.vertices[corners, axis]))


def _short(number: float) -> str:
    """Write a share without zeros that say nothing."""
    return f"{number:.2f}".rstrip("0").rstrip(".")

"""A stone as its setting meets it: the outline from above, and how wide the stone is at each height."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gemrender.stone import ConvexSolid, Stone

__all__ = ["Outline", "claw_directions"]

#: Chords that stand for a round girdle: they are 3e-4 within it, a seventh of what metal keeps away.
_CHORDS = 128
#: A corner of the outline turns by this at least [deg],
_CORNER_DEG = 50.0
#: within such a stretch of its length [girdle radius].
_SHORT = 0.4
#: Neighbouring claws face apart by this at most, where no corners say where they stand [deg].
_APART_DEG = 75.0
#: Three corners or more need no claws between them that face apart by less [deg].
_HELD_DEG = 125.0
#: An outline whose length and width differ by less is round, or square.
_EVEN = 1.08


@dataclass(frozen=True, eq=False)
class Outline:
    """The convex outline of a stone from above, and its heights.

    Attributes
    ----------
    vertices : (v, 3) float64
        Corners of the stone [girdle radius].
    edges : (e, 2) int64
        Corners that the edges of its convex hull join.
    points : (n, 2) float64
        Corners of the outline, anticlockwise.
    """

    vertices: np.ndarray
    edges: np.ndarray
    points: np.ndarray

    @classmethod
    def of(cls, stone: Stone) -> Outline:
        """Make it of a stone."""
        from scipy.spatial import ConvexHull

        solid = stone.solid
        vertices = solid.vertices
        if isinstance(solid, ConvexSolid):
            body = solid.cut(_CHORDS) if solid.is_round else solid.polyhedron
            vertices, edges = body.vertices, body.edges[:, :2]
        else:
            faces = ConvexHull(solid.vertices).simplices
            edges = np.unique(np.sort(np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])), axis=0)
        return cls(vertices, edges, vertices[ConvexHull(vertices[:, :2]).vertices, :2])

    @cached_property
    def middle(self) -> np.ndarray:
        """Middle of its box, (2,)."""
        return np.asarray(0.5 * (self.points.min(axis=0) + self.points.max(axis=0)))

    @cached_property
    def edge_angles(self) -> np.ndarray:
        """Where the outward normal of the edge after each point faces, (n,) [rad]; increasing."""
        along = np.roll(self.points, -1, axis=0) - self.points
        return np.unwrap(np.arctan2(-along[:, 0], along[:, 1]))

    @cached_property
    def turns(self) -> np.ndarray:
        """Angle that the outline turns by at each point, (n,) [rad]."""
        before = np.roll(self.edge_angles, 1)
        before[0] -= 2 * np.pi
        return np.asarray(self.edge_angles - before)

    @cached_property
    def _edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Outward normals of the edges, (n, 2), and how far they are from the middle, (n,)."""
        normals = np.column_stack([np.cos(self.edge_angles), np.sin(self.edge_angles)])
        return normals, np.einsum("ij,ij->i", normals, self.points - self.middle)

    @property
    def inradius(self) -> float:
        """How far the nearest edge is from the middle."""
        return float(self._edges[1].min())

    def scales(self, points: np.ndarray) -> np.ndarray:
        """Return by what the outline is scaled about its middle to pass through points (k, 2), (k,)."""
        normals, offsets = self._edges
        return np.asarray(((points - self.middle) @ (normals / offsets[:, None]).T).max(axis=1))

    @cached_property
    def vertex_scales(self) -> np.ndarray:
        """`scales` of the stone's corners, (v,)."""
        return self.scales(self.vertices[:, :2])

    @cached_property
    def girdle(self) -> tuple[float, float]:
        """Lowest and highest point of the girdle."""
        z = self.vertices[self.vertex_scales > 1 - 1e-6, 2]
        return float(z.min()), float(z.max())

    @property
    def bottom(self) -> float:
        """Lowest point of the stone."""
        return float(self.vertices[:, 2].min())

    def support(self, angle: float) -> np.ndarray:
        """Return the outline's farthest point in a direction [rad], of several their middle, (2,)."""
        along = self.points @ np.array([np.cos(angle), np.sin(angle)])
        return np.asarray(self.points[along > along.max() - 1e-9].mean(axis=0))

    def height_beyond(self, scale: float) -> float:
        """Return how high the stone is outside the outline scaled by `scale` < 1.

        Beyond each edge of that outline the stone is highest at one of its corners, or where one of its own
        edges goes through the upright plane there.
        """
        normals, offsets = self._edges
        beyond = (self.vertices[:, :2] - self.middle) @ normals.T - scale * offsets
        highest = float(self.vertices[(beyond >= 0).any(axis=1), 2].max())
        z = self.vertices[self.edges, 2]
        for first in range(0, len(self.edges), 512):
            one, other = (beyond[self.edges[first : first + 512, k]] for k in (0, 1))
            through = (one < 0) != (other < 0)
            t = one[through] / (one[through] - other[through])
            low, high = z[first : first + 512].T
            row = np.nonzero(through)[0]
            highest = max(highest, float((low[row] + t * (high - low)[row]).max(initial=highest)))
        return highest

    def widest_slope(self) -> float:
        """Return how fast a cone below the girdle may narrow and still hold the stone [1/girdle radius].

        That is the largest m for which a point at depth d below the girdle has a scale of at most 1 - m d.
        """
        low, _ = self.girdle
        depth = low - self.vertices[:, 2]
        below = depth > 1e-6
        if not below.any():
            return float("inf")
        return float(max(((1 - self.vertex_scales[below]) / depth[below]).min(), 0.0))

    @property
    def is_round(self) -> bool:
        """Whether it is as long as wide, and fills no more of its box than a circle does."""
        x, y = self.points.T
        area = 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
        size = np.ptp(self.points, axis=0)
        return bool(size.max() < _EVEN * size.min() and area < 0.8 * size.prod())

    @property
    def long_angle(self) -> float:
        """Direction of the longer side, towards its narrower end [rad]; of even ones y."""
        size = np.ptp(self.points, axis=0)
        along = 0 if size[0] > _EVEN * size[1] else 1
        half = 0.5 * size[along]
        at = (self.points[:, along] - self.middle[along]) / half
        across = np.abs(self.points[:, 1 - along] - self.middle[1 - along])
        plus, minus = (_width_at(sign * at, across) for sign in (1, -1))
        back = np.pi if minus < 0.9 * plus else 0.0
        return float((0.0 if along == 0 else np.pi / 2) + back)


def _width_at(at: np.ndarray, across: np.ndarray) -> float:
    """Return half the width at 0.8 of the way to an end."""
    order = np.argsort(at)
    return float(np.interp(0.8, at[order], across[order]))


def claw_directions(outline: Outline, *, first: float | None = None) -> list[float]:
    """Return the directions that claws face, anticlockwise [rad]: corners first, as they break, then between.

    Six around a round stone, four at an oval's shoulders, one at each corner of a square or a trilliant, one
    at each tip of a marquise and of a pear, with more between.

    Parameters
    ----------
    outline : Outline
        The outline.
    first : float, optional
        A direction that one faces in any case [rad].
    """
    found = _corners(outline)
    if first is not None and not any(_apart(first, angle) < np.radians(20) for angle in found):
        found = sorted([*found, first % (2 * np.pi)])
    if not found:
        n, start = (6, np.pi / 6) if outline.is_round else (4, np.pi / 4)
        return [start + 2 * np.pi * k / n for k in range(n)]
    most = np.radians(_HELD_DEG if len(found) > 2 else _APART_DEG)
    out = []
    for angle, following in zip(found, [*found[1:], found[0] + 2 * np.pi], strict=True):
        gap = following - angle
        n = 1 if gap <= most else int(np.ceil(gap / np.radians(_APART_DEG) - 1e-6))
        out += [angle + gap * k / n for k in range(n)]
    return out


def _apart(a: float, b: float) -> float:
    return float(abs((a - b + np.pi) % (2 * np.pi) - np.pi))


def _corners(outline: Outline) -> list[float]:
    """Return the directions of the outline's corners, in order, from 0 to 2 pi [rad]."""
    points, turns = outline.points, outline.turns
    faces = outline.edge_angles - 0.5 * turns
    length = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    around = float(length.sum())
    place = np.cumsum(length) - length
    apart = np.abs((place[:, None] - place + 0.5 * around) % around - 0.5 * around)
    near = apart <= 0.5 * _SHORT
    turned = near @ turns
    found: list[float] = []
    left = turned >= np.radians(_CORNER_DEG)
    while left.any():
        k = int(np.argmax(np.where(left, turned + turns, 0.0)))  # of those alike the sharpest
        off = (faces - faces[k] + np.pi) % (2 * np.pi) - np.pi
        found.append(float(faces[k] + np.average(off, weights=near[k] * turns)) % (2 * np.pi))
        left &= apart[k] > _SHORT
    return sorted(found)

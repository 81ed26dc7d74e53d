"""Points in solids: how deep a point is inside a mesh, and whether a surface reaches into it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from gemrender.scene.convex import PlacedSolid

__all__ = ["Ball", "Inside", "crosses", "distinct_rows", "overlap", "reaches_into", "winding_number"]

#: Pairs of points and triangles that are looked at together: some 100 MiB.
_PAIRS = 1 << 20
#: How far a vertex may lie beyond a face of a convex mesh [share of its size]: rounding of its positions.
_FLAT = 3e-6
#: What a corner is off by in single precision, with a margin [share of the distance from the origin].
_ROUNDING = 4e-7
#: A triangle that is not as high has no normal to speak of [share of the distance from the origin].
_NARROW = 1e-4
#: How far beyond a triangle's border an edge still meets it: rounding [share of the triangle].
_BORDER = 1e-9
#: Edges side by side whose triangles are looked for together.
_TOGETHER = 64
#: Vertices times faces up to which convexity is looked for.
_MOST_CONVEX = 1 << 26


def winding_number(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return how often a surface winds around points: 1 inside a closed surface whose faces look out, else 0.

    The sum of the solid angles of the triangles by 4 pi; each by van Oosterom and Strackee, "The solid angle
    of a plane triangle", IEEE Trans. Biomed. Eng. 30 (1983), equation (8).

    Parameters
    ----------
    points : (k, 3) float64
    triangles : (n, 3, 3) float64
        Anticlockwise seen from outside.

    Returns
    -------
    (k,) float64
    """
    out = np.empty(len(points))
    for rows in _chunks(len(points), len(triangles)):
        to = triangles[None] - points[rows, None, None]
        a, b, c = (to[:, :, k] for k in range(3))
        la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
        volume = np.einsum("kni,kni->kn", a, np.cross(b, c))
        rest = la * lb * lc
        rest += np.einsum("kni,kni->kn", a, b) * lc + np.einsum("kni,kni->kn", b, c) * la
        rest += np.einsum("kni,kni->kn", c, a) * lb
        out[rows] = np.arctan2(volume, rest).sum(axis=1) / (2 * np.pi)
    return out


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Ball:
    """A ball: centre (3,) float64 and radius [scene unit]."""

    centre: np.ndarray
    radius: float

    def depth(self, points: np.ndarray) -> np.ndarray:
        """Return how far points (k, 3) are inside, negative outside, (k,)."""
        return np.asarray(self.radius - np.linalg.norm(points - self.centre, axis=1))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Inside:
    """The inside of a closed surface.

    Attributes
    ----------
    triangles : (n, 3, 3) float64
        The surface, anticlockwise seen from outside [scene unit].
    known : PlacedSolid, Ball or None
        The solid, where it is one of these.
    """

    triangles: np.ndarray
    known: PlacedSolid | Ball | None

    @classmethod
    def of(cls, triangles: np.ndarray) -> Inside:
        """Make it of triangles (n, 3, 3) that look outwards."""
        return cls(triangles=triangles, known=_convex(triangles))

    @property
    def size(self) -> float:
        """Longest extent [scene unit]."""
        return float(np.ptp(self.triangles.reshape(-1, 3), axis=0).max())

    def inner(self) -> np.ndarray:
        """Return a point inside, (3,): between the largest triangle and what is behind it."""
        area, _ = _area_and_height(self.triangles)
        largest = int(np.argmax(np.einsum("ij,ij->i", area, area)))
        start = self.triangles[largest].mean(axis=0)
        along = -area[largest] / np.linalg.norm(area[largest]) * 4 * self.size
        t = _cuts(np.array([[start, start + along]]), self.triangles)[2]
        t = t[t > 1e-6]
        return np.asarray(start + 0.5 * (t.min() if len(t) else 0.0) * along)

    def depth(self, points: np.ndarray) -> np.ndarray:
        """Return how far points (k, 3) are from the surface if they are inside, else 0 or less, (k,)."""
        out = np.zeros(len(points))
        if self.known is not None:
            for rows in _chunks(len(points), len(self.triangles)):
                out[rows] = self.known.depth(points[rows])
            return out
        inside = np.flatnonzero(winding_number(points, self.triangles) > 0.5)
        out[inside] = _distance(points[inside], self.triangles)
        return out


def _convex(triangles: np.ndarray) -> PlacedSolid | None:
    """Return the solid that triangles (n, 3, 3) bound if it is convex."""
    area, height = _area_and_height(triangles)
    corners = distinct_rows(triangles.reshape(-1, 3))
    size = float(np.ptp(corners, axis=0).max())
    scale = max(size, float(np.abs(corners).max()))
    wide = height > _NARROW * scale  # a sliver's normal is noise; the faces beside it bound what it does
    if not wide.any() or len(corners) * len(triangles) > _MOST_CONVEX:
        return None
    normals = area[wide] / np.linalg.norm(area[wide], axis=1, keepdims=True)
    offsets = np.einsum("ij,ij->i", normals, triangles[wide].mean(axis=1))
    # As far as a face's normal may turn by the rounding of its corners
    beyond = _FLAT * scale + _ROUNDING * scale * size / height[wide]
    for rows in _chunks(len(corners), len(normals)):
        if (corners[rows] @ normals.T > offsets + beyond).any():
            return None
    return PlacedSolid(planes=np.column_stack([normals, offsets]), cylinder=None)


def overlap(a: Inside, b: Inside, depth: float) -> bool:
    """Return whether two solids have points in common that are deeper than `depth` in one of them."""
    if not _boxes_meet(a.triangles, b.triangles, depth):
        return False
    ways = ((a, b), (b, a))
    return any((other.depth(one.inner()[None]) > depth).any() for one, other in ways) or any(
        reaches_into(one.triangles, other, depth) for one, other in ways
    )


def reaches_into(triangles: np.ndarray, solid: Inside, depth: float) -> bool:
    """Return whether a surface reaches deeper than `depth` into a solid.

    Looked for at corners and middles of triangles, at the middles of the pieces that the solid's faces cut
    edges into, and in the middle of where the solid's edges go through a triangle: what only touches never
    does.

    Parameters
    ----------
    triangles : (n, 3, 3) float64
        The surface, wound anyhow.
    solid : Inside
        The solid.
    depth : float
        At least 0 [scene unit].
    """
    hull = _hull(solid.triangles)
    triangles = _near(triangles, hull, depth)
    if not len(triangles):
        return False
    points = np.concatenate([triangles.reshape(-1, 3), triangles.mean(axis=1)])
    if _any_deeper(points, solid, hull, depth):
        return True
    own_hull = _hull(triangles)
    own = _near(solid.triangles, own_hull, 0)
    edges = _near(_edges(triangles), hull, depth)
    return _any_deeper(_between_cuts(edges, own), solid, hull, depth) or _any_deeper(
        _middles_of_cuts(_near(_edges(own), own_hull, 0), triangles), solid, hull, depth
    )


def crosses(a: Inside, b: Inside) -> bool:
    """Return whether edges of one surface go through the other."""
    sides = [(of.triangles, _hull(of.triangles)) for of in (a, b)]
    return any(
        len(_cuts(_near(_edges(one), other_hull, 0), _near(other, one_hull, 0))[0])
        for (one, one_hull), (other, other_hull) in permutations(sides)
    )


def _hull(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return how far the hull of triangles (n, 3, 3) reaches, down and up, in each of `_DIRECTIONS`, (d,)."""
    corners = triangles.reshape(-1, 3)
    low = np.full(_DIRECTIONS.shape[1], np.inf)
    high = -low
    for rows in _chunks(len(corners), _DIRECTIONS.shape[1]):
        along = corners[rows] @ _DIRECTIONS
        low, high = np.minimum(low, along.min(axis=0)), np.maximum(high, along.max(axis=0))
    slack = 1e-9 * float(np.abs(corners).max())
    return low - slack, high + slack


def _near(parts: np.ndarray, hull: tuple[np.ndarray, np.ndarray], depth: float) -> np.ndarray:
    """Return those of points, edges or triangles (n, k, 3) that reach deeper than `depth` into a hull."""
    low, high = hull[0] + depth, hull[1] - depth
    # Most are beyond in one of the axes
    for some in (slice(0, 1), slice(1, 2), slice(2, 3), slice(3, None)):
        kept = []
        for rows in _chunks(len(parts), parts.shape[1] * len(low[some])):
            along = parts[rows] @ _DIRECTIONS[:, some]
            reaches = (along.max(axis=1) >= low[some]) & (along.min(axis=1) <= high[some])
            kept.append(parts[rows][reaches.all(axis=1)])
        parts = np.concatenate(kept) if kept else parts
    return parts


def _any_deeper(points: np.ndarray, solid: Inside, hull: tuple[np.ndarray, np.ndarray], depth: float) -> bool:
    """Return whether any of points (k, 3) is deeper than `depth` in a solid, whose hull is known."""
    points = _near(points[:, None], hull, depth)[:, 0]
    points = distinct_rows(points)
    first, n = 0, 16  # what overlaps is mostly seen at once
    while first < len(points):
        if (solid.depth(points[first : first + n]) > depth).any():
            return True
        first, n = first + n, 4 * n
    return False


def _boxes_meet(a: np.ndarray, b: np.ndarray, depth: float) -> bool:
    low = np.maximum(a.min(axis=(0, 1)), b.min(axis=(0, 1)))
    high = np.minimum(a.max(axis=(0, 1)), b.max(axis=(0, 1)))
    return bool((high - low > depth).all())


def _directions(n: int) -> np.ndarray:
    """Return n directions that are spread over the sphere, (3, n): a spiral from pole to pole."""
    k = np.arange(n) + 0.5
    z, turn = 1 - k / n, np.pi * (1 + 5**0.5) * k
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z])


#: Directions that a solid's hull is bounded in; the opposite ones are bounded with them.
_DIRECTIONS = np.concatenate([np.eye(3), _directions(64)], axis=1)


# ---- Distances and cuts --------------------------------------------------------------------------------


def distinct_rows(rows: np.ndarray) -> np.ndarray:
    """Return the different rows of an array (n, m)."""
    if len(rows) < 2:
        return rows
    order = np.lexsort(rows.T)
    rows = rows[order]
    return np.asarray(rows[np.r_[True, (rows[1:] != rows[:-1]).any(axis=1)]])


def _area_and_height(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return twice the area vectors (n, 3) of triangles, and their least heights (n,)."""
    sides = np.roll(triangles, -1, axis=1) - triangles
    area = np.cross(sides[:, 0], -sides[:, 2])
    longest = np.sqrt((sides**2).sum(axis=2).max(axis=1))
    return area, np.linalg.norm(area, axis=1) / np.where(longest > 0, longest, 1)


def _chunks(n: int, others: int) -> Iterator[slice]:
    step = max(1, _PAIRS // max(others, 1))
    return (slice(first, min(first + step, n)) for first in range(0, n, step))


def _distance(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the distance of points (k, 3) from the nearest of triangles (n, 3, 3), (k,)."""
    out = np.empty(len(points))
    a, b, c = triangles.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    unit = normal / np.where(length > 0, length, 1)[:, None]
    for rows in _chunks(len(points), len(triangles)):
        p = points[rows, None]
        over = np.broadcast_to(length > 0, (p.shape[0], len(triangles))).copy()
        nearest = np.full(over.shape, np.inf)
        for start, end in ((a, b), (b, c), (c, a)):
            along = end - start
            to = p - start
            squared = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
            t = np.clip(np.einsum("kni,ni->kn", to, along) / squared, 0, 1)
            nearest = np.minimum(nearest, np.linalg.norm(to - t[..., None] * along, axis=2))
            over &= np.einsum("kni,ni->kn", to, np.cross(normal, along)) >= 0
        above = np.abs(np.einsum("kni,ni->kn", p - a, unit))
        out[rows] = np.where(over, above, nearest).min(axis=1)
    return out


def _edges(triangles: np.ndarray) -> np.ndarray:
    """Return the different edges of triangles, (e, 2, 3)."""
    ends = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    swap = ends[:, 0, 0] > ends[:, 1, 0]  # that most edges, which two faces share, are looked at once
    ends[swap] = ends[swap, ::-1]
    return distinct_rows(ends.reshape(-1, 6)).reshape(-1, 2, 3)


def _cuts(edges: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return where edges meet triangles, borders included: edge, triangle, share of the way along the edge.

    By Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), section 2.
    """
    edge, triangle = _pairs_of_near(edges, triangles)
    share = np.empty(len(edge))
    met = np.empty(len(edge), dtype=bool)
    for rows in _chunks(len(edge), 1):
        start, end = edges[edge[rows]].transpose(1, 0, 2)
        a, b, c = triangles[triangle[rows]].transpose(1, 0, 2)
        along, u, v, to = end - start, b - a, c - a, start - a
        p, q = np.cross(along, v), np.cross(to, u)
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = 1 / np.einsum("ki,ki->k", u, p)
            first, second, t = (np.einsum("ki,ki->k", x, y) * scale for x, y in ((to, p), (along, q), (v, q)))
            met[rows] = (first >= -_BORDER) & (second >= -_BORDER) & (first + second <= 1 + _BORDER)
            met[rows] &= (t >= 0) & (t <= 1)  # False of what is not a number: in its plane there is no cut
        share[rows] = t
    return edge[met], triangle[met], share[met]


def _pairs_of_near(edges: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the edges and triangles whose boxes meet, in order: all that can have a cut, and few more."""
    of_edge, of_triangle = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    if len(edges) and len(triangles):
        slack = 10 * _BORDER * max(float(np.abs(edges).max()), float(np.abs(triangles).max()))
        low, high = triangles.min(axis=1) - slack, triangles.max(axis=1) + slack
        middles = edges.mean(axis=1)
        order = np.argsort(middles[:, int(np.ptp(middles, axis=0).argmax())], kind="stable")
        for first in range(0, len(edges), _TOGETHER):
            rows = order[first : first + _TOGETHER]
            begin, end = edges[rows].min(axis=1), edges[rows].max(axis=1)
            near = np.flatnonzero(((low <= end.max(axis=0)) & (high >= begin.min(axis=0))).all(axis=1))
            k, n = np.nonzero(((low[near] <= end[:, None]) & (high[near] >= begin[:, None])).all(axis=2))
            of_edge.append(rows[k])
            of_triangle.append(near[n])
    edge, triangle = np.concatenate(of_edge), np.concatenate(of_triangle)
    by_edge = np.lexsort((triangle, edge))
    return edge[by_edge], triangle[by_edge]


def _between_cuts(edges: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the middles of the pieces that triangles cut edges into, (k, 3)."""
    if not len(edges):
        return np.zeros((0, 3))
    edge, _, t = _cuts(edges, triangles)
    n = np.arange(len(edges))
    edge, t = np.r_[edge, n, n], np.r_[t, np.zeros(len(n)), np.ones(len(n))]
    order = np.lexsort((t, edge))
    edge, t = edge[order], t[order]
    piece = edge[1:] == edge[:-1]
    of, middle = edge[1:][piece], (0.5 * (t[1:] + t[:-1]))[piece]
    return np.asarray(edges[of, 0] + middle[:, None] * (edges[of, 1] - edges[of, 0]))


def _middles_of_cuts(edges: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the middle of all places where edges go through each triangle, (k, 3)."""
    edge, triangle, t = _cuts(edges, triangles)
    if not len(edge):
        return np.zeros((0, 3))
    points = edges[edge, 0] + t[:, None] * (edges[edge, 1] - edges[edge, 0])
    _, rows = np.unique(triangle, return_inverse=True)
    count = np.bincount(rows)
    return np.stack([np.bincount(rows, weights=x) / count for x in points.T], axis=1)

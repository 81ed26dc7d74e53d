"""Convex polyhedra from half-spaces: corners, polygons, edges, areas, volume.

By Qhull through scipy: the planes' dual points have a convex hull whose faces are the corners (Preparata &
Shamos, Computational Geometry, 7.2.5). Corners that rounding parts are one, so that neighbours share them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gemrender.errors import InputError

__all__ = ["Polyhedron", "interior_point", "intersect"]

#: Corners closer than this are one, and lie on every plane this near [share of the solid's size]: rounding.
_SAME = 1e-10
#: Polygons of a smaller area are rounding [share of the square of the solid's size].
_LEAST_AREA = 1e-12
#: Planes whose normals and offsets differ by less are one plane, given twice.
_TWICE = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class Polyhedron:
    """A convex polyhedron.

    Attributes
    ----------
    planes : (p, 4) float64
        Outward unit normals and offsets of all planes that were given.
    vertices : (v, 3) float64
        Its corners.
    corners : (c,) int64
        Vertices of one plane's polygon after the other, anticlockwise seen from outside.
    starts : (p + 1,) int64
        Where the corners of each plane begin; planes that bound nothing have none.
    """

    planes: np.ndarray
    vertices: np.ndarray
    corners: np.ndarray
    starts: np.ndarray

    @property
    def bounds(self) -> np.ndarray:
        """(p,) bool: which planes bound it."""
        return np.asarray(np.diff(self.starts) > 0)

    def polygon(self, plane: int) -> np.ndarray:
        """Return the vertices of a plane's polygon, (k,) int64; none if it bounds nothing."""
        return self.corners[self.starts[plane] : self.starts[plane + 1]]

    @cached_property
    def crosses(self) -> np.ndarray:
        """(p, 3) float64: the areas of the polygons, along their normals."""
        return _crosses(self.vertices, self.corners, self.starts)

    @cached_property
    def areas(self) -> np.ndarray:
        """(p,) float64: areas of the polygons."""
        return np.asarray(np.einsum("ij,ij->i", self.crosses, self.planes[:, :3]))

    @property
    def volume(self) -> float:
        """The volume, by Gauss's theorem."""
        return float(self.areas @ self.planes[:, 3]) / 3.0

    @cached_property
    def edges(self) -> np.ndarray:
        """(e, 4) int64: both vertices of each edge, and the planes to its left and right from outside."""
        plane = np.repeat(np.arange(len(self.planes)), np.diff(self.starts))
        last = self.starts[1:][plane] - 1
        here = np.arange(len(self.corners))
        following = np.where(here == last, self.starts[:-1][plane], here + 1)
        a, b = self.corners, self.corners[following]
        key = np.minimum(a, b) * len(self.vertices) + np.maximum(a, b)
        order = np.lexsort([a > b, key])
        a, b, plane, key = a[order], b[order], plane[order], key[order]
        pairs = np.flatnonzero(key[:-1] == key[1:])
        return np.column_stack([a[pairs], b[pairs], plane[pairs], plane[pairs + 1]])

    @cached_property
    def centroid(self) -> np.ndarray:
        """(3,) float64: the middle of its volume."""
        corner, nxt = self.corners, np.roll(self.corners, -1)
        plane = np.repeat(np.arange(len(self.planes)), np.diff(self.starts))
        first = self.starts[:-1][plane]
        inner = np.arange(len(corner)) + 1 < self.starts[1:][plane]
        a, b, c = (self.vertices[k[inner]] for k in (corner[first], corner, nxt))
        volumes = np.einsum("ij,ij->i", a, np.cross(b, c))
        return np.asarray((volumes @ (a + b + c)) / (4.0 * volumes.sum()))


def intersect(planes: np.ndarray) -> Polyhedron:
    """Return the polyhedron that lies inside all planes.

    Parameters
    ----------
    planes : (p, 4) float64
        Outward unit normals and offsets: n . x <= offset inside.

    Raises
    ------
    InputError
        The planes do not close, or enclose nothing.
    """
    from scipy.spatial import ConvexHull, QhullError, cKDTree

    planes = np.asarray(planes, dtype=np.float64)
    inside = interior_point(planes)
    room = planes[:, 3] - planes[:, :3] @ inside
    try:
        hull = ConvexHull(planes[:, :3] / room[:, None])
    except QhullError as error:
        raise InputError("the planes do not close: they enclose no solid") from error
    away = hull.equations[:, 3]
    if not (away < -1e-9 * np.abs(hull.points).max()).all():
        raise InputError("the planes do not close: the solid is open")
    points = -hull.equations[:, :3] / away[:, None]
    size = float(np.ptp(points, axis=0).max())
    if not np.isfinite(size):
        raise InputError("the planes do not close: the solid is open")
    vertices = _merged(points, _SAME * size, cKDTree) + inside
    on = np.abs(vertices @ planes[:, :3].T - planes[:, 3]) <= 2 * _SAME * size
    on[:, ~_first_of_twins(planes, size, cKDTree)] = False
    plane, vertex = np.nonzero(on.T)
    return _polygons(planes, vertices, plane, vertex, _LEAST_AREA * size * size)


def interior_point(planes: np.ndarray) -> np.ndarray:
    """Return a point well inside all planes (p, 4), (3,) float64.

    Raises
    ------
    InputError
        There is none.
    """
    if (planes[:, 3] > 0.05 * np.abs(planes[:, 3]).max()).all():
        return np.zeros(3)
    from scipy.optimize import linprog

    # The centre of the largest sphere inside (Chebyshev's); its radius is bounded, so that open ones end too.
    most = 10.0 * float(np.abs(planes[:, 3]).max() or 1.0)
    found = linprog(
        [0.0, 0.0, 0.0, -1.0],
        A_ub=np.column_stack([planes[:, :3], np.ones(len(planes))]),
        b_ub=planes[:, 3],
        bounds=[(None, None)] * 3 + [(0.0, most)],
    )
    if found.status != 0 or found.x[3] <= 1e-9 * most:
        raise InputError("the planes do not close: they enclose no solid")
    return np.asarray(found.x[:3])


def _merged(points: np.ndarray, near: float, tree_type: type) -> np.ndarray:
    """Return the points (n, 3) with those that are near each other made one, their mean."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    pairs = tree_type(points).query_pairs(near, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points),) * 2)
    count, label = connected_components(links, directed=False)
    number = np.bincount(label, minlength=count)
    return np.column_stack([np.bincount(label, points[:, k], count) / number for k in range(3)])


def _first_of_twins(planes: np.ndarray, size: float, tree_type: type) -> np.ndarray:
    """Return which planes (p, 4) are not given before them, (p,) bool."""
    scaled = np.column_stack([planes[:, :3], planes[:, 3] / size])
    pairs = tree_type(scaled).query_pairs(_TWICE, output_type="ndarray")
    first = np.ones(len(planes), dtype=bool)
    first[pairs.max(axis=1, initial=-1) if len(pairs) else []] = False
    return first


def _polygons(
    planes: np.ndarray, vertices: np.ndarray, plane: np.ndarray, vertex: np.ndarray, least_area: float
) -> Polyhedron:
    """Put the vertices on each plane in order; drop planes that bound nothing, and corners of none."""
    p = len(planes)
    count = np.bincount(plane, minlength=p)
    middle = np.column_stack([np.bincount(plane, vertices[vertex, k], p) for k in range(3)])
    middle /= np.maximum(count, 1)[:, None]
    n = planes[:, :3]
    u = np.cross(n, np.eye(3)[np.abs(n).argmin(axis=1)])
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(n, u)
    to = vertices[vertex] - middle[plane]
    angle = np.arctan2(np.einsum("ij,ij->i", to, v[plane]), np.einsum("ij,ij->i", to, u[plane]))
    order = np.lexsort([angle, plane])
    plane, vertex = plane[order], vertex[order]
    starts = np.concatenate([[0], np.cumsum(count)])
    areas = np.einsum("ij,ij->i", _crosses(vertices, vertex, starts), n)
    keep = ((count > 2) & (areas > least_area))[plane]
    plane, vertex = plane[keep], vertex[keep]
    used, vertex = np.unique(vertex, return_inverse=True)
    return Polyhedron(
        planes=planes,
        vertices=vertices[used],
        corners=vertex,
        starts=np.concatenate([[0], np.cumsum(np.bincount(plane, minlength=p))]),
    )


def _crosses(vertices: np.ndarray, corners: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Areas of polygons along their normals, (p, 3): half the sum of the cross products of neighbours."""
    p = len(starts) - 1
    plane = np.repeat(np.arange(p), np.diff(starts))
    if not len(plane):
        return np.zeros((p, 3))
    here = np.arange(len(corners))
    following = np.where(here + 1 == starts[1:][plane], starts[:-1][plane], here + 1)
    about = vertices[corners[starts[:-1][plane]]]
    a, b = vertices[corners] - about, vertices[corners[following]] - about
    cross = np.cross(a, b)
    return 0.5 * np.column_stack([np.bincount(plane, cross[:, k], p) for k in range(3)])

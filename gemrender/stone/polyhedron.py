"""Convex polyhedra from half-spaces: corners, polygons, edges, areas, volume.

By Qhull through scipy: the planes' dual points have a convex hull whose faces are the corners (Preparata &
Shamos, Computational Geometry, 7.2.5). Corners that rounding parts are one, so that neighbours share them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gemrender.errors import InputError
from gemrender.stone.connected import connected

__all__ = ["Polyhedron", "interior_point", "intersect"]

#: Neighbouring corners closer than this are one [share of the solid's size]: rounding.
_SAME = 1e-10
#: A point is well inside that has so much room on all sides [share of the largest distance of a plane].
_ROOM = 0.05
#: A corner this many times further away than planes are is at infinity: the solid is open.
_OPEN = 1e-9


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

    def __post_init__(self) -> None:
        for name in ("planes", "vertices", "corners", "starts"):
            object.__setattr__(self, name, _read_only(getattr(self, name).view()))

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
        first, a, b = (self.vertices[k] for k in self._fans())
        plane = np.repeat(np.arange(len(self.planes)), np.diff(self.starts))
        cross = np.cross(a - first, b - first)
        sums = [np.bincount(plane, cross[:, k], len(self.planes)) for k in range(3)]
        return _read_only(0.5 * np.column_stack(sums))

    @cached_property
    def areas(self) -> np.ndarray:
        """(p,) float64: areas of the polygons."""
        return _read_only(np.einsum("ij,ij->i", self.crosses, self.planes[:, :3]))

    @cached_property
    def middles(self) -> np.ndarray:
        """(p, 3) float64: the middle of each polygon's area; nan of planes that bound nothing."""
        first, a, b = self._fans()
        plane = np.repeat(np.arange(len(self.planes)), np.diff(self.starts))
        about, p, q = (self.vertices[k] for k in (first, a, b))
        area = np.einsum("ij,ij->i", np.cross(p - about, q - about), self.planes[plane, :3])
        sums = [np.bincount(plane, area * (about + p + q)[:, k], len(self.planes)) for k in range(3)]
        with np.errstate(invalid="ignore"):
            return _read_only(np.column_stack(sums) / (6.0 * self.areas[:, None]))

    def _fans(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return each polygon's first vertex, its vertices, and those that follow them, each (c,)."""
        plane = np.repeat(np.arange(len(self.planes)), np.diff(self.starts))
        here = np.arange(len(self.corners))
        first = self.starts[:-1][plane]
        following = np.where(here + 1 == self.starts[1:][plane], first, here + 1)
        return self.corners[first], self.corners, self.corners[following]

    @property
    def volume(self) -> float:
        """The volume, by Gauss's theorem."""
        return float(self.areas @ self.planes[:, 3]) / 3.0

    @cached_property
    def edges(self) -> np.ndarray:
        """(e, 4) int64: both vertices of each edge, and the planes to its left and right from outside."""
        plane = np.repeat(np.arange(len(self.planes)), np.diff(self.starts))
        _, a, b = self._fans()
        key = np.minimum(a, b) * len(self.vertices) + np.maximum(a, b)
        order = np.lexsort([a > b, key])
        left, right = order[::2], order[1::2]
        return _read_only(np.column_stack([a[left], b[left], plane[left], plane[right]]))

    @cached_property
    def centroid(self) -> np.ndarray:
        """(3,) float64: the middle of its volume."""
        a, b, c = (self.vertices[k] for k in self._fans())
        volumes = np.einsum("ij,ij->i", a, np.cross(b, c))
        return _read_only((volumes @ (a + b + c)) / (4.0 * volumes.sum()))


def _read_only(array: np.ndarray) -> np.ndarray:
    """Return an array that nobody writes to: it is kept, and others get the same one."""
    array.setflags(write=False)
    return array


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
    from scipy.spatial import ConvexHull, QhullError

    planes = np.asarray(planes, dtype=np.float64)
    inside = interior_point(planes)
    room = planes[:, 3] - planes[:, :3] @ inside
    try:
        hull = ConvexHull(planes[:, :3] / room[:, None])
    except QhullError as error:
        raise InputError("the planes do not close: they enclose no solid") from error
    away = hull.equations[:, 3]
    if not (away < -_OPEN * np.abs(hull.points).max()).all():
        raise InputError("the planes do not close: the solid is open")
    points = -hull.equations[:, :3] / away[:, None]
    label = _one_each(points, hull.neighbors, _SAME * float(np.ptp(points, axis=0).max()))
    number = np.bincount(label)
    vertices = np.column_stack([np.bincount(label, points[:, k]) / number for k in range(3)]) + inside
    return _polygons(planes, vertices, label, _oriented(hull.simplices, hull.neighbors))


def interior_point(planes: np.ndarray) -> np.ndarray:
    """Return a point well inside all planes (p, 4), (3,) float64.

    Raises
    ------
    InputError
        There is none.
    """
    largest = float(np.abs(planes[:, 3]).max() or 1.0)
    # Stones stand about their axis: a point of it will do for nearly all.
    heights = np.linspace(-largest, largest, 65)
    room = (planes[:, 3:] - planes[:, 2:3] * heights).min(axis=0)
    if room.max() > _ROOM * largest:
        return np.array([0.0, 0.0, heights[int(room.argmax())]])
    from scipy.optimize import linprog

    # The centre of the largest sphere inside (Chebyshev's); its radius is bounded, so that open ones end too.
    most = 10.0 * largest
    found = linprog(
        [0.0, 0.0, 0.0, -1.0],
        A_ub=np.column_stack([planes[:, :3], np.ones(len(planes))]),
        b_ub=planes[:, 3],
        bounds=[(None, None)] * 3 + [(0.0, most)],
    )
    if found.status != 0 or found.x[3] <= 1e-9 * most:
        raise InputError("the planes do not close: they enclose no solid")
    return np.asarray(found.x[:3])


def _one_each(points: np.ndarray, neighbours: np.ndarray, near: float) -> np.ndarray:
    """Return a number for each corner (n, 3), one for neighbours that are near each other, (n,) int."""
    one, other = np.repeat(np.arange(len(points)), 3), neighbours.reshape(-1)
    short = (one < other) & (np.linalg.norm(points[one] - points[other], axis=1) <= near)
    least = connected(len(points), one[short], other[short])
    return np.unique(least, return_inverse=True)[1].reshape(-1)


def _oriented(simplices: np.ndarray, neighbours: np.ndarray) -> np.ndarray:
    """Return the hull's triangles (n, 3) wound alike, by their connections, not by rounding."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import breadth_first_order

    n = len(simplices)
    links = csr_array((np.ones(3 * n), neighbours.reshape(-1), np.arange(0, 3 * n + 1, 3)), shape=(n, n))
    order, parents = breadth_first_order(links, 0)
    here, parent, row = order[1:], parents[order[1:]], np.arange(len(order) - 1)
    ring, other = simplices[here], simplices[parent]
    # The edge that both share begins behind the corner across from which the parent is.
    k = (neighbours[here] == parent[:, None]).argmax(axis=1)
    start, end = ring[row, (k + 1) % 3], ring[row, (k + 2) % 3]
    at = (other == start[:, None]).argmax(axis=1)
    in_same_sense = other[row, (at + 1) % 3] == end
    turned = [False] * n
    for one, before, same in zip(here.tolist(), parent.tolist(), in_same_sense.tolist(), strict=True):
        turned[one] = turned[before] ^ same
    return np.where(np.array(turned)[:, None], simplices[:, [0, 2, 1]], simplices)


def _polygons(
    planes: np.ndarray, vertices: np.ndarray, label: np.ndarray, triangles: np.ndarray
) -> Polyhedron:
    """Walk round each plane's point on the dual hull: the triangles there are its corners, in order."""
    # Each corner of a triangle is a step round that plane's point, from one neighbour to the next.
    plane = triangles.reshape(-1)
    start, end = triangles[:, [1, 2, 0]].reshape(-1), triangles[:, [2, 0, 1]].reshape(-1)
    n = len(planes)
    by_start = np.argsort(plane * n + start)
    following = by_start[np.searchsorted((plane * n + start)[by_start], plane * n + end)].tolist()
    walked: list[int] = []
    for step in np.unique(plane, return_index=True)[1].tolist():
        at = step
        while True:
            walked.append(at)
            at = following[at]
            if at == step:
                break
    owner, number = plane[walked], label[np.array(walked) // 3]
    # Corners that are one are neighbours; the last of a polygon is the first one's too.
    first = np.searchsorted(owner, owner)
    is_new = (np.arange(len(owner)) == first) | (number != np.roll(number, 1))
    owner, number = owner[is_new], number[is_new]
    first = np.searchsorted(owner, owner)
    is_last = np.arange(len(owner)) == np.searchsorted(owner, owner, side="right") - 1
    is_new = ~is_last | (number != number[first]) | (np.arange(len(owner)) == first)
    owner, number = owner[is_new], number[is_new]
    is_polygon = (np.bincount(owner, minlength=n) > 2)[owner]
    owner, corners = owner[is_polygon], number[is_polygon]
    starts = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=n))])
    used, numbers = np.unique(corners, return_inverse=True)
    body = Polyhedron(planes=planes, vertices=vertices[used], corners=numbers.reshape(-1), starts=starts)
    if body.areas.sum() < 0:  # wound clockwise
        plane = np.repeat(np.arange(len(planes)), np.diff(body.starts))
        order = np.lexsort([-np.arange(len(numbers)), plane])
        body = Polyhedron(
            planes=planes, vertices=body.vertices, corners=body.corners[order], starts=body.starts
        )
    return body

"""Whether a mesh is the closed surface of a solid, and which of its faces look out of it.

Meshes come as they were exported: vertices shared or one for each face and corner, faces wound either way,
vertices on the edges of neighbours. What counts is the solid, so vertices are joined by place first.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gemrender.errors import InputError
from gemrender.scene.content_cache import cached_by_content
from gemrender.scene.nesting import nested
from gemrender.stone.connected import connected

__all__ = ["ClosedSurface", "closed_surface"]

#: Vertices that are no farther apart are one, and an edge passes through a vertex that is no farther from it
#: [share of the solid's size].
_SAME_PLACE = 1e-5
#: A part encloses no volume if it has less [share of the cube of its size]: a sheet with two sides.
_NO_VOLUME = 1e-9
#: How deep parts may reach into each other: rounding, of parts that touch [share of the mesh's size].
_TOUCHING = 1e-5
#: Open edges that are looked at for vertices on them; a mesh with more of them is open.
_MOST_SEAMS = 4000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ClosedSurface:
    """The surface of a solid, or of several.

    Attributes
    ----------
    triangles : (n, 3, 3) float64
        Corners of the faces that have an area, anticlockwise seen from outside the solid [scene unit].
    outward : (f,) int8
        Of each face of the mesh: 1 where it is wound so, -1 where it is wound the other way, 0 where it has
        no area.
    body : (n,) int64
        Number of the body that each triangle bounds: a connected part, with the hollows in it.
    """

    triangles: np.ndarray
    outward: np.ndarray
    body: np.ndarray

    def __post_init__(self) -> None:
        for array in (self.triangles, self.outward, self.body):
            array.setflags(write=False)  # the same surface is returned again


@cached_by_content
def closed_surface(positions: np.ndarray, faces: np.ndarray) -> ClosedSurface:
    """Find the solid that a mesh is the surface of.

    The faces of a part are turned to agree with each other, then outwards. A part inside another one is a
    hollow if it is wound the other way.

    Parameters
    ----------
    positions : (v, 3) float
        Vertices [scene unit].
    faces : (f, 3) int
        Vertices of each face.

    Raises
    ------
    InputError
        There is none: the surface is open, one-sided, encloses nothing, has faces twice, or overlaps itself.
    """
    faces = np.asarray(faces, dtype=np.int64).reshape(-1, 3)
    positions = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
    if not len(faces):
        raise InputError("must have faces")
    if faces.min() < 0 or faces.max() >= len(positions):
        raise InputError("must have a vertex of every number that a face names")
    if not np.isfinite(positions[np.unique(faces)]).all():
        raise InputError("must have vertices that are finite numbers")
    size = float(np.ptp(positions[np.unique(faces)], axis=0).max())
    vertex, edges, place = _joined(positions, faces, _SAME_PLACE * size)
    kept = _three_corners(vertex[faces])
    edges, place, block = _apart(len(faces), edges, place)
    _refuse_doubles(np.column_stack([np.sort(vertex[faces], axis=1), block])[kept])
    sign, label = _agreeing(len(faces), edges, place)
    corners = positions[faces][kept]
    part = np.unique(label[kept], return_inverse=True)[1].ravel()
    to = corners - corners[0, 0]
    volume = np.bincount(part, weights=sign[kept] * np.einsum("ij,ij->i", to[:, 0], _cross(to)) / 6)
    if (np.abs(volume) <= _NO_VOLUME * _sizes(corners, part) ** 3).any():
        raise InputError("must enclose a volume")
    outward = np.zeros(len(faces), dtype=np.int8)
    outward[kept] = sign[kept] * np.sign(volume)[part]
    _refuse_unbalanced(edges, place, outward)
    bodies = [_turned(corners[part == k], outward[kept][part == k]) for k in range(len(volume))]
    as_wound = np.sign(np.bincount(part, weights=outward[kept]) + 0.5)
    hollow, body = nested(bodies, as_wound, _TOUCHING * size)
    outward[kept] *= np.where(hollow[part], -1, 1).astype(np.int8)
    return ClosedSurface(
        triangles=_turned(corners, outward[kept]), outward=outward, body=body[part].astype(np.int64)
    )


# ---- Vertices and edges --------------------------------------------------------------------------------


def _joined(
    positions: np.ndarray, faces: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the number of each vertex's place, the faces' edges, and the number of each edge's place.

    (v,), (e, 3): from, to, face, and (e,). Every two ends have an even number of edges between them.
    """
    odd = np.zeros(0, dtype=np.int64)
    for join in (_same_numbers, _same_places):
        vertex = join(positions, tolerance)
        edges = _edges(vertex[faces])
        place, odd = _places(edges)
        if not len(odd):
            return vertex, edges, place
    if len(odd) <= _MOST_SEAMS:
        places = np.zeros((int(vertex.max()) + 1, 3))
        places[vertex] = positions
        edges = _split(edges, odd, places, tolerance)
        place, odd = _places(edges)
        if not len(odd):
            return vertex, edges, place
    raise InputError(f"must be a closed surface; {len(odd)} edges have a face on one side only")


def _same_numbers(positions: np.ndarray, _tolerance: float) -> np.ndarray:
    """Return the number of each vertex's place, as it is, (v,)."""
    return _row_numbers(positions)


def _same_places(positions: np.ndarray, tolerance: float) -> np.ndarray:
    """Return the number of each vertex's place, within a tolerance, (v,)."""
    a, b = [], []
    for shift in np.ndindex(
        2, 2, 2
    ):  # neighbours on two sides of a cell's wall are in one cell of another grid
        cell = np.floor(positions / (2 * tolerance) + 0.5 * np.array(shift))
        inverse = _row_numbers(cell)
        first = np.full(int(inverse.max()) + 1, len(positions))
        np.minimum.at(first, inverse, np.arange(len(positions)))
        a.append(np.arange(len(positions)))
        b.append(first[inverse])
    return np.unique(connected(len(positions), np.concatenate(a), np.concatenate(b)), return_inverse=True)[1]


def _row_numbers(rows: np.ndarray) -> np.ndarray:
    """Return a number for each row of an array (n, m), the same one for equal rows; (n,)."""
    order = np.lexsort(rows.T)
    new = (rows[order][1:] != rows[order][:-1]).any(axis=1)
    number = np.empty(len(rows), dtype=np.int64)
    number[order] = np.r_[0, np.cumsum(new)]
    return number


def _three_corners(triangles: np.ndarray) -> np.ndarray:
    """Return which triangles have three different vertices, (f,) bool."""
    a, b, c = triangles.T
    return np.asarray((a != b) & (b != c) & (c != a))


def _edges(triangles: np.ndarray) -> np.ndarray:
    """Return the directed edges of triangles (f, 3) with three different vertices, (e, 3): from, to, face."""
    number = np.flatnonzero(_three_corners(triangles))
    t = triangles[number]
    return np.concatenate([np.column_stack([t[:, k], t[:, (k + 1) % 3], number]) for k in range(3)])


def _keys(edges: np.ndarray) -> np.ndarray:
    """Return one number for both directions of an edge."""
    low, high = np.minimum(edges[:, 0], edges[:, 1]), np.maximum(edges[:, 0], edges[:, 1])
    return np.asarray(low * (int(edges[:, :2].max(initial=0)) + 1) + high)


def _places(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a number for each edge, (e,), one for those between the same ends, and the odd ones.

    Those are the rows of edges (one of each) that an odd number of faces meets at.
    """
    _, first, number, count = np.unique(
        _keys(edges), return_index=True, return_inverse=True, return_counts=True
    )
    return number.reshape(-1), first[count % 2 == 1]


def _split(edges: np.ndarray, odd: np.ndarray, places: np.ndarray, tolerance: float) -> np.ndarray:
    """Split the odd edges at the vertices of other odd edges that lie on them."""
    open_keys = _keys(edges)[odd]
    rows = np.flatnonzero(np.isin(_keys(edges), open_keys))
    vertices = np.unique(edges[rows, :2])
    new = [np.delete(edges, rows, axis=0)]
    for a, b, face in edges[rows]:
        along = places[b] - places[a]
        length = float(np.linalg.norm(along))
        to = places[vertices] - places[a]
        t = to @ along / length**2
        beside = np.linalg.norm(to - t[:, None] * along, axis=1)
        on = (beside <= tolerance) & (t * length > tolerance) & ((1 - t) * length > tolerance)
        chain = [a, *vertices[on][np.argsort(t[on])], b]
        new.append(np.array([[p, q, face] for p, q in pairwise(chain)]))
    return np.concatenate(new)


def _apart(n_faces: int, edges: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Keep surfaces apart that follow each other in the mesh, as when Mitsuba makes one mesh of several.

    Where they touch, their vertices and edges are in the same places. The sum modulo 2 of the edges of all
    faces so far is none exactly where a closed surface ends; edges stand in it as random numbers.

    Returns
    -------
    (edges, place, block)
        The edges (e, 3) with vertices of each surface's own, the numbers of their places (e,), and the
        number of each face's surface, (f,).
    """
    words = np.random.default_rng(0).integers(1, 1 << 62, size=int(place.max()) + 1)[place]
    of_face = np.zeros(n_faces, dtype=np.int64)
    np.bitwise_xor.at(of_face, edges[:, 2], words)
    ends = np.bitwise_xor.accumulate(of_face) == 0
    block = np.cumsum(ends) - ends
    if not block[-1]:
        return edges, place, block
    n_vertices = int(edges[:, :2].max()) + 1
    own = edges[:, :2] + n_vertices * block[edges[:, 2], None]
    number = np.unique(own, return_inverse=True)[1].reshape(-1, 2)
    edges = np.column_stack([number, edges[:, 2]])
    return edges, _places(edges)[0], block


def _refuse_doubles(triangles: np.ndarray) -> None:
    count = np.bincount(_row_numbers(triangles))
    if (count > 1).any():
        raise InputError(f"must have each face once; {int((count > 1).sum())} of them are there again")


# ---- Orientation ---------------------------------------------------------------------------------------


def _agreeing(n_faces: int, edges: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which faces to turn for all of a part to agree, 1 or -1, and the part of each, (f,).

    Two faces at an edge agree if they run along it in opposite directions. Each face is a pair of nodes, as
    it is and turned; nodes that agree are joined, and what is joined to the first face as it is stays so.
    """
    order = np.argsort(place, kind="stable")
    count = np.bincount(place)
    pairs = (np.cumsum(count) - count)[count == 2]  # edges of more faces join no parts
    one, other = edges[order[pairs]], edges[order[pairs + 1]]
    against = one[:, 0] == other[:, 0]
    f, g = one[:, 2], other[:, 2]
    as_it_is, turned = f, f + n_faces
    label = connected(
        2 * n_faces,
        np.concatenate([as_it_is, turned]),
        np.concatenate([np.where(against, g + n_faces, g), np.where(against, g, g + n_faces)]),
    )
    if (label[:n_faces] == label[n_faces:]).any():
        raise InputError("must have an inside and an outside; it is one-sided, as a Moebius strip is")
    part = np.minimum(label[:n_faces], label[n_faces:])
    return np.where(label[:n_faces] == part, 1, -1), part


def _refuse_unbalanced(edges: np.ndarray, place: np.ndarray, sign: np.ndarray) -> None:
    """Refuse surfaces of which as many faces do not run along an edge in one direction as in the other."""
    direction = np.where(edges[:, 0] < edges[:, 1], 1, -1) * sign[edges[:, 2]]
    if np.bincount(place, weights=direction).any():
        raise InputError("must have an inside and an outside; some edges join faces that disagree")


def _sizes(corners: np.ndarray, part: np.ndarray) -> np.ndarray:
    """Return the longest extent of each part of triangles (n, 3, 3)."""
    n_parts = int(part.max()) + 1
    low, high = np.full((n_parts, 3), np.inf), np.full((n_parts, 3), -np.inf)
    np.minimum.at(low, part, corners.min(axis=1))
    np.maximum.at(high, part, corners.max(axis=1))
    return np.asarray((high - low).max(axis=1))


def _turned(corners: np.ndarray, sign: np.ndarray) -> np.ndarray:
    """Return triangles (n, 3, 3), those of sign -1 wound the other way."""
    return np.where((sign < 0)[:, None, None], corners[:, ::-1], corners)


def _cross(corners: np.ndarray) -> np.ndarray:
    """Return twice the area vectors of triangles (n, 3, 3)."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

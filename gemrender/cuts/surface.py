"""Triangles as files have them, made a closed surface that faces outwards; what cannot be mended is refused.

Corners that rounding parts are made one; triangles that stand twice stand once; those that are wound the
wrong way are turned. A surface with a hole is refused, and it is said where the hole is.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.errors import InputError

__all__ = ["ALL_DIGITS", "MOST_TRIANGLES", "SIX_DIGITS", "Surface", "closed_surface"]

#: Most triangles of a mesh.
MOST_TRIANGLES = 300_000
#: Rounding of coordinates [half the size of the stone]: files have six digits and more; and all digits.
SIX_DIGITS, ALL_DIGITS = 2e-6, 1e-9
#: So many times the rounding are points on a plane off it, and cracks are wide.
FLAT = 5.0
#: Least volume that a surface encloses [share of its box's]; what runs through itself may enclose none.
LEAST_VOLUME = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A closed surface that faces outwards.

    Attributes
    ----------
    vertices : (v, 3) float64
        Positions.
    triangles : (f, 3) int64
        Vertices of each triangle, anticlockwise seen from outside.
    corners : (f, 3, 3) float64
        Its corners as they stand in the file, before corners near each other were made one.
    near : float
        Points this near a plane lie on it.
    is_convex : bool
        Whether it bounds a convex solid, up to rounding.
    notes : tuple of str
        What was mended.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    corners: np.ndarray
    near: float
    is_convex: bool
    notes: tuple[str, ...]


def closed_surface(vertices: np.ndarray, triangles: np.ndarray, rounding: float = SIX_DIGITS) -> Surface:
    """Make triangles a closed surface.

    Parameters
    ----------
    vertices : (v, 3) float64
        Positions, in any unit of length.
    triangles : (f, 3) int64
        Vertices of each triangle, in any order.
    rounding : float
        Rounding of the coordinates [half the longest side of the box].

    Raises
    ------
    InputError
        There are no triangles, or numbers that are not finite; the surface is flat, open, or more than one.
    """
    _check(vertices, triangles)
    size = 0.5 * float(np.ptp(vertices, axis=0).max())
    if not size > 0:
        raise InputError("all vertices are one point")
    corners = vertices[triangles]
    vertices, triangles, left = _with_shared_vertices(vertices, triangles, rounding * size)
    once = _once(triangles)
    doubled = len(triangles) - len(once)
    notes = [f"{doubled} triangles stand twice, once is used"] if doubled else []
    triangles, corners = triangles[once], corners[left][once]
    if len(triangles) < 4:
        raise InputError(f"has {len(triangles)} triangles; a closed surface has at least four")
    hull = _hull(vertices)
    near = FLAT * rounding * size
    is_convex = _lies_on(hull, vertices, triangles, near)
    if is_convex:
        outward = _seen_from(vertices, triangles, vertices[hull.vertices].mean(axis=0))
    else:
        outward = _wound_alike(vertices, triangles)
    turned = np.where(outward[:, None], triangles, triangles[:, ::-1])
    corners = np.where(outward[:, None, None], corners, corners[:, ::-1])
    _refuse_open(vertices, turned, near, cracks=is_convex)
    n_turned = int((~outward & (_areas(vertices, triangles) > 0)).sum())
    if n_turned:
        all_of_them = n_turned == int((_areas(vertices, triangles) > 0).sum())
        notes.append(
            "all triangles faced inwards; turned"
            if all_of_them
            else f"{n_turned} of {len(triangles)} triangles faced inwards; turned"
        )
    return Surface(vertices, turned, corners, near, is_convex, tuple(notes))


def _check(vertices: np.ndarray, triangles: np.ndarray) -> None:
    if not len(vertices) or not len(triangles):
        raise InputError("has no triangles")
    if len(triangles) > MOST_TRIANGLES:
        raise InputError(f"has {len(triangles)} triangles; at most {MOST_TRIANGLES} are allowed")
    if not (triangles.min() >= 0 and triangles.max() < len(vertices)):
        raise InputError(f"a face names a vertex that is not there; there are {len(vertices)}")
    used = vertices[np.unique(triangles)]
    if not (np.abs(used) < 1e50).all():  # false for NaN too
        raise InputError("the vertices must be finite numbers")


def _with_shared_vertices(
    vertices: np.ndarray, triangles: np.ndarray, near: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Make near vertices one; leave out those of no triangle, and triangles that are lines.

    Returns vertices, triangles, and the number (g,) that each of these had.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    used, triangles = np.unique(triangles, return_inverse=True)
    distinct, inverse = np.unique(vertices[used], axis=0, return_inverse=True)
    pairs = cKDTree(distinct).query_pairs(near, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(distinct),) * 2)
    count, label = connected_components(links, directed=False)
    number = np.bincount(label, minlength=count)
    merged = np.column_stack([np.bincount(label, distinct[:, k], count) / number for k in range(3)])
    merged[label[number[label] == 1]] = distinct[number[label] == 1]  # to the last bit
    triangles = label[inverse.reshape(-1)][triangles.reshape(-1, 3)]
    a, b, c = triangles.T
    left = np.flatnonzero((a != b) & (b != c) & (c != a))
    return merged, triangles[left].astype(np.int64), left


def _once(triangles: np.ndarray) -> np.ndarray:
    """Return the numbers of triangles that have not the vertices of one before."""
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    return np.sort(first)


def _hull(vertices: np.ndarray) -> Any:
    from scipy.spatial import ConvexHull, QhullError

    try:
        return ConvexHull(vertices)
    except (QhullError, ValueError) as error:
        raise InputError("is flat: its vertices lie in one plane") from error


def _lies_on(hull: Any, vertices: np.ndarray, triangles: np.ndarray, near: float) -> bool:
    """Whether all triangles lie on the surface of the hull, as those of a convex solid do."""
    middles = vertices[triangles].mean(axis=1)
    planes = np.unique(np.round(hull.equations, 12), axis=0)
    if len(planes) * len(middles) > 2e9:  # too many facets for a stone's
        return False
    part = max(1, 10_000_000 // len(planes))
    for begin in range(0, len(middles), part):
        depth = (middles[begin : begin + part] @ planes[:, :3].T + planes[:, 3]).max(axis=1)
        if (depth < -near).any():
            return False
    return True


def _areas(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    return 0.5 * np.asarray(np.linalg.norm(_crosses(vertices, triangles), axis=1))


def _crosses(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    return np.asarray(np.cross(b - a, c - a))


def _seen_from(vertices: np.ndarray, triangles: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Whether each triangle (f,) faces away from a point inside; lines do."""
    to = vertices[triangles].mean(axis=1) - inside
    return np.asarray(np.einsum("ij,ij->i", _crosses(vertices, triangles), to) >= 0)


def _half_edges(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return start, end, number of the undirected edge, and triangle of each half edge (3 f,)."""
    start, end = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    pair = np.column_stack([np.minimum(start, end), np.maximum(start, end)])
    edge = np.unique(pair, axis=0, return_inverse=True)[1].reshape(-1)
    return start, end, edge, np.repeat(np.arange(len(triangles)), 3)


def _wound_alike(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Whether each triangle (f,) of one surface faces outwards; they follow from their neighbours."""
    start, end, edge, triangle = _half_edges(triangles)
    count = np.bincount(edge)
    if (count > 2).any():
        crowded = np.flatnonzero(count > 2)
        at = vertices[[start[edge == crowded[0]][0], end[edge == crowded[0]][0]]].mean(axis=0)
        raise InputError(f"{len(crowded)} edges belong to more than two triangles, one near {_point(at)}")
    order = np.argsort(edge, kind="stable")
    inner = order[count[edge[order]] == 2]
    one, other = inner[0::2], inner[1::2]
    same_way = start[one] == start[other]  # two that are wound alike run along their edge in opposite ways
    neighbours: list[list[tuple[int, bool]]] = [[] for _ in triangles]
    for a, b, turn in zip(triangle[one].tolist(), triangle[other].tolist(), same_way.tolist(), strict=True):
        neighbours[a].append((b, turn))
        neighbours[b].append((a, turn))
    turned = np.full(len(triangles), -1)
    surfaces = 0
    for seed in range(len(triangles)):
        if turned[seed] >= 0:
            continue
        surfaces += 1
        turned[seed] = 0
        queue = deque([seed])
        while queue:
            here = queue.popleft()
            for there, turn in neighbours[here]:
                wanted = int(turned[here]) ^ turn
                if turned[there] < 0:
                    turned[there] = wanted
                    queue.append(there)
                elif turned[there] != wanted:
                    at = vertices[triangles[there]].mean(axis=0)
                    raise InputError(f"has no inside: it is twisted, near {_point(at)}")
    if surfaces > 1 and (count == 2).all():
        raise InputError(f"is {surfaces} closed surfaces; a stone is one")
    alike = turned == 0
    wound = np.where(alike[:, None], triangles, triangles[:, ::-1])
    about = vertices - vertices.mean(axis=0)
    volume = (_crosses(about, wound) * about[wound[:, 0]]).sum() / 6.0
    if abs(volume) < LEAST_VOLUME * float(np.prod(np.ptp(vertices, axis=0))):
        raise InputError("encloses no volume")
    return np.asarray(alike if volume >= 0 else ~alike)


def _refuse_open(vertices: np.ndarray, triangles: np.ndarray, near: float, *, cracks: bool) -> None:
    """Refuse a surface whose edges of one triangle go round a hole, or where they must not, a crack.

    Round a crack they enclose no area; a convex solid is given by its planes, and needs no shared edges.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    start, end, edge, _ = _half_edges(triangles)
    # Along an edge there and back is nothing; what is left goes round holes and cracks.
    balance = np.bincount(edge, np.where(start < end, 1, -1))
    loose = np.flatnonzero(balance[edge] != 0)
    if not len(loose):
        return
    links = coo_array((np.ones(len(loose)), (start[loose], end[loose])), shape=(len(vertices),) * 2)
    label = connected_components(links, directed=False)[1][start[loose]]
    holes, label = np.unique(label, return_inverse=True)
    a, b = vertices[start[loose]], vertices[end[loose]]
    middles = np.array([a[label == hole].mean(axis=0) for hole in range(len(holes))])
    turns = np.cross(a - middles[label], b - middles[label])
    enclosed = 0.5 * np.linalg.norm(
        np.column_stack([np.bincount(label, turns[:, k], len(holes)) for k in range(3)]), axis=1
    )
    length = np.bincount(label, np.linalg.norm(b - a, axis=1), len(holes))
    ends = np.bincount(start[loose], minlength=len(vertices)) != np.bincount(
        end[loose], minlength=len(vertices)
    )
    if cracks and (enclosed <= near * length).all() and not ends.any():
        return
    largest = int(enclosed.argmax())
    n_edges = int((label == largest).sum())
    holes_text = f"{len(holes)} holes, the largest" if len(holes) > 1 else "a hole"
    raise InputError(
        f"is an open surface: {holes_text} with {n_edges} edges round it near {_point(middles[largest])}"
    )


def _point(at: np.ndarray) -> str:
    return "(" + ", ".join(f"{x:.4g}" for x in at.tolist()) + ")"

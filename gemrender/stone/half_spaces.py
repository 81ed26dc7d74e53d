"""A stone whose facets were tilted: 57 half-spaces and the cylinder of radius 1, as a watertight mesh.

Tilted planes do not meet in the 57 vertices any more (where four facets met in a point there is a short edge
now), so the mesh is made from the planes: each facet is its plane, clipped by all others and by the cylinder.
Every corner is computed once, from the planes it lies on, and shared by its facets to the last bit.
"""

from __future__ import annotations

import numpy as np

from gemrender.errors import InputError
from gemrender.stone.topology import GIRDLE, IS_CROWN, N_SECTORS

__all__ = ["clip_half_spaces", "half_space_mesh"]

#: Half the side of the square that each facet is cut from [girdle radius]: beyond the cylinder everywhere.
_SQUARE = 4.0

Key = tuple[object, ...]
Polygon = list[tuple[Key, np.ndarray]]


def clip_half_spaces(normals: np.ndarray, offsets: np.ndarray) -> list[list[int]]:
    """Return the planes that bound each facet of the polyhedron, in order, anticlockwise from outside.

    Parameters
    ----------
    normals : (57, 3) float64
        Outward unit normals.
    offsets : (57,) float64
        Offsets [girdle radius].

    Returns
    -------
    list of 57 lists of int
        Neighbours of each facet; -1 stands for the rim of a plane that no other bounds there. Empty for a
        facet that the others have cut away.
    """
    out = []
    for facet, (normal, offset) in enumerate(zip(normals, offsets, strict=True)):
        helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
        u = np.cross(normal, helper)
        u /= np.linalg.norm(u)
        v = np.cross(normal, u)
        corners = offset * normal + _SQUARE * np.array([-u - v, u - v, u + v, v - u])
        labels = [-1, -1, -1, -1]  # of the edge from each corner to the next
        for other in range(len(normals)):
            if other == facet:
                continue
            distance = corners @ normals[other] - offsets[other]
            if (distance <= 0).all():
                continue
            corners, labels = _clip(corners, labels, distance, other)
            if not labels:
                break
        out.append(labels)
    return out


def _clip(
    corners: np.ndarray, labels: list[int], distance: np.ndarray, plane: int
) -> tuple[np.ndarray, list[int]]:
    """Keep the part of a convex polygon with distance <= 0."""
    points: list[np.ndarray] = []
    edges: list[int] = []
    n = len(labels)
    for k in range(n):
        here, there = distance[k], distance[(k + 1) % n]
        if here <= 0:
            points.append(corners[k])
            edges.append(labels[k])
        if (here <= 0) != (there <= 0):
            share = here / (here - there)
            points.append(corners[k] + share * (corners[(k + 1) % n] - corners[k]))
            edges.append(plane if here <= 0 else labels[k])
    return np.array(points), edges


def half_space_mesh(
    normals: np.ndarray, offsets: np.ndarray, arc_segments: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cut the solid into triangles.

    Parameters
    ----------
    normals, offsets : (57, 3), (57,) float64
        The facets' planes [girdle radius].
    arc_segments : int
        Straight pieces of a sixteenth of the girdle's circle.

    Returns
    -------
    vertices : (v, 3) float64
    faces : (f, 3) int32
        Anticlockwise seen from outside; closed.
    face_facet : (f,) int32
        Facet of each face, the girdle 57.

    Raises
    ------
    InputError
        Crown and pavilion meet before they reach the girdle's cylinder.
    """
    corner = _Corners(normals, offsets)
    grid = 2 * np.pi * np.arange(N_SECTORS * arc_segments) / (N_SECTORS * arc_segments) - np.pi
    vertices: list[np.ndarray] = []
    number: dict[Key, int] = {}
    faces: list[tuple[int, int, int]] = []
    facets: list[int] = []
    rims: dict[bool, dict[Key, np.ndarray]] = {True: {}, False: {}}

    def index(key: Key, point: np.ndarray) -> int:
        if key not in number:
            number[key] = len(vertices)
            vertices.append(point)
        return number[key]

    for facet, neighbours in enumerate(clip_half_spaces(normals, offsets)):
        if not neighbours:
            continue
        polygon, on_rim = _within_cylinder(facet, neighbours, corner, grid)
        if len(polygon) < 3:
            continue
        rims[bool(IS_CROWN[facet])].update(on_rim)
        ring = [index(key, point) for key, point in polygon]
        middle = index(("middle", facet), np.mean([point for _, point in polygon], axis=0))
        for a, b in zip(ring, [*ring[1:], ring[0]], strict=True):
            faces.append((middle, a, b))
            facets.append(facet)

    upper, lower = (
        sorted(((float(np.arctan2(p[1], p[0])), index(key, p)) for key, p in rims[side].items()))
        for side in (True, False)
    )
    if not upper or not lower or {i for _, i in upper} & {i for _, i in lower}:
        raise InputError("crown and pavilion meet: the girdle is too thin for facets tilted so far")
    for triangle in _band(upper, lower):
        faces.append(triangle)
        facets.append(GIRDLE)
    return np.array(vertices), np.array(faces, dtype=np.int32), np.array(facets, dtype=np.int32)


class _Corners:
    """Corners of the solid by the planes that they lie on, each computed once."""

    def __init__(self, normals: np.ndarray, offsets: np.ndarray) -> None:
        self.normals, self.offsets = normals, offsets
        self._known: dict[Key, np.ndarray] = {}

    def of_planes(self, *planes: int) -> tuple[Key, np.ndarray]:
        """Where three planes meet."""
        together = sorted(planes)
        key: Key = tuple(together)
        if key not in self._known:
            self._known[key] = np.linalg.solve(self.normals[together], self.offsets[together])
        return key, self._known[key]

    def on_cylinder(self, a: int, b: int) -> Polygon:
        """Where the line of two planes meets the cylinder: both points, or none."""
        a, b = min(a, b), max(a, b)
        direction = np.cross(self.normals[a], self.normals[b])
        planes = np.array([self.normals[a], self.normals[b], direction])
        start = np.linalg.solve(planes, [self.offsets[a], self.offsets[b], 0.0])
        p, q = direction[:2] @ direction[:2], start[:2] @ direction[:2]
        root = q * q - p * (start[:2] @ start[:2] - 1.0)
        if p == 0.0 or root <= 0.0:
            return []
        ends: Polygon = []
        for sign in (-1, 1):
            key: Key = (a, b, "cylinder", sign)
            if key not in self._known:
                self._known[key] = start + (-q + sign * np.sqrt(root)) / p * direction
            ends.append((key, self._known[key]))
        return ends


def _within_cylinder(
    facet: int, neighbours: list[int], corner: _Corners, grid: np.ndarray
) -> tuple[Polygon, dict[Key, np.ndarray]]:
    """Return the facet's outline in the cylinder, arcs in short pieces, and its points on the cylinder."""
    n = len(neighbours)
    pieces: list[tuple[Polygon, bool, bool]] = []  # of each edge: points, enters and leaves the cylinder
    for k, edge in enumerate(neighbours):
        if edge < 0:
            continue
        before, after = neighbours[k - 1], neighbours[(k + 1) % n]
        ends: list[tuple[Key, np.ndarray] | None] = [
            corner.of_planes(facet, edge, side) if side >= 0 else None for side in (before, after)
        ]
        inside = [end is not None and bool(np.hypot(*end[1][:2]) <= 1.0) for end in ends]
        cuts = corner.on_cylinder(facet, edge)
        # Along the outline, anticlockwise from outside, the edge runs along normal x neighbour's normal.
        along = np.cross(corner.normals[facet], corner.normals[edge])
        cuts.sort(key=lambda cut: float(cut[1] @ along))
        if not inside[0] and not inside[1] and (not cuts or not _between(cuts, ends, along)):
            continue
        first = ends[0] if inside[0] else cuts[0]
        last = ends[1] if inside[1] else cuts[1]
        assert first is not None
        assert last is not None
        pieces.append(([first, last], not inside[0], not inside[1]))
    out: Polygon = []
    rim: dict[Key, np.ndarray] = {}
    for number, ((first, last), enters, leaves) in enumerate(pieces):
        if enters:
            left_at = pieces[number - 1][0][1]
            arc = _arc(facet, left_at[1], first[1], corner, grid)
            out += [*arc, first]
            rim.update([*arc, first])
        elif not out or out[-1][0] != first[0]:
            out.append(first)
        if leaves:
            out.append(last)
            rim.update([last])
    return out, rim


def _between(
    cuts: list[tuple[Key, np.ndarray]], ends: list[tuple[Key, np.ndarray] | None], along: np.ndarray
) -> bool:
    """Whether an edge with both ends outside the cylinder passes through it."""
    low = -np.inf if ends[0] is None else float(ends[0][1] @ along)
    high = np.inf if ends[1] is None else float(ends[1][1] @ along)
    return low < float(cuts[0][1] @ along) and float(cuts[1][1] @ along) < high


def _arc(facet: int, start: np.ndarray, end: np.ndarray, corner: _Corners, grid: np.ndarray) -> Polygon:
    """Grid points of the circle between two of its points, on the facet's plane, ends left out."""
    crown = bool(IS_CROWN[facet])
    turn = 1.0 if crown else -1.0  # anticlockwise from outside is clockwise from above on the pavilion
    a, b = (float(np.arctan2(p[1], p[0])) for p in (start, end))
    span = (turn * (b - a)) % (2 * np.pi)
    beyond = (turn * (grid - a)) % (2 * np.pi)
    inner = np.flatnonzero((beyond > 1e-9) & (beyond < span - 1e-9))
    inner = inner[np.argsort(beyond[inner])]
    normal, offset = corner.normals[facet], corner.offsets[facet]
    out: Polygon = []
    for m in inner.tolist():
        x, y = np.cos(grid[m]), np.sin(grid[m])
        z = (offset - normal[0] * x - normal[1] * y) / normal[2]
        out.append((("arc", crown, m), np.array([x, y, z])))
    return out


def _band(upper: list[tuple[float, int]], lower: list[tuple[float, int]]) -> list[tuple[int, int, int]]:
    """Triangles between two rings of (azimuth, vertex), both sorted, seen anticlockwise from outside."""
    out = []
    i = j = 0
    turn = 2 * np.pi
    while i < len(upper) or j < len(lower):
        next_upper = upper[(i + 1) % len(upper)][0] + (turn if i + 1 >= len(upper) else 0.0)
        next_lower = lower[(j + 1) % len(lower)][0] + (turn if j + 1 >= len(lower) else 0.0)
        a, b = upper[i % len(upper)][1], lower[j % len(lower)][1]
        if j >= len(lower) or (i < len(upper) and next_upper <= next_lower):
            out.append((b, upper[(i + 1) % len(upper)][1], a))
            i += 1
        else:
            out.append((b, lower[(j + 1) % len(lower)][1], a))
            j += 1
    return out

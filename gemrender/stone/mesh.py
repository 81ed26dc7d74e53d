"""The stone as a watertight triangle mesh, with scalloped girdle edges.

Between two girdle vertices each upper and lower girdle facet goes on beyond its chord, as the same plane,
until it meets the girdle's wall (`docs/model.md`, section 2). The arcs are cut into short straight pieces, so
that the mesh has the same topology for every stone. Where a girdle is thinner than its scallops, the two
planes meet before they reach the wall; there the girdle has no height.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gemrender.stone.half_spaces import half_space_mesh
from gemrender.stone.solid import Stone
from gemrender.stone.topology import (
    GIRDLE,
    GIRDLE_LOWER,
    GIRDLE_UPPER,
    LOWER_GIRDLE_FACETS,
    LOWER_GIRDLE_TRIANGLES,
    N_SECTORS,
    N_VERTICES,
    TRIANGLE_FACET,
    TRIANGLES,
    UPPER_GIRDLE_FACETS,
    UPPER_GIRDLE_TRIANGLES,
)

__all__ = ["ARC_SEGMENTS", "StoneMesh", "tessellate"]

#: Straight pieces of each of the 16 girdle arcs. Their sagitta, (pi / 16 / 64)^2 / 2 = 4.7e-6 girdle
#: radii, is the mesh's largest distance from the true wall.
ARC_SEGMENTS = 64


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StoneMesh:
    """A closed triangle mesh of a stone.

    Attributes
    ----------
    vertices : (v, 3) float64
        Positions [girdle radius]; the first 57 are the stone's vertices.
    faces : (f, 3) int32
        Vertices of each face, anticlockwise seen from outside; every edge is shared by two faces.
    face_facet : (f,) int32
        Facet that each face belongs to (0 to 57, the girdle last).
    face_normals : (f, 3) float64
        Outward unit normal of the plane that each face lies in; 0 on the girdle.
    face_offsets : (f,) float64
        Offset of that plane [girdle radius]; on the girdle the radius of its cylinder, 0 if not round.
    face_patch : (f,) int64
        Plane or girdle sector of each face: across its border the normal changes.
    corner_normals : (f, 3, 3) float64
        Outward unit normal at each corner of each face: the facet's, or the girdle wall's.
    """

    vertices: np.ndarray
    faces: np.ndarray
    face_facet: np.ndarray
    face_normals: np.ndarray
    face_offsets: np.ndarray
    corner_normals: np.ndarray
    face_patch: np.ndarray

    def split(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the mesh with vertices of their own for each plane and girdle sector: one normal a vertex.

        Returns
        -------
        positions, normals : (w, 3) float64
            One position and one normal a vertex.
        faces : (f, 3) int32
            In the order of `self.faces`.
        """
        owner = np.repeat(self.face_patch, 3) * len(self.vertices) + self.faces.reshape(-1)
        _, corners, inverse = np.unique(owner, return_index=True, return_inverse=True)
        return (
            self.vertices[self.faces.reshape(-1)[corners]],
            self.corner_normals.reshape(-1, 3)[corners],
            inverse.reshape(-1, 3).astype(np.int32),
        )


def tessellate(stone: Stone, arc_segments: int = ARC_SEGMENTS) -> StoneMesh:
    """Cut the stone into a watertight mesh.

    Parameters
    ----------
    stone : Stone
        The stone.
    arc_segments : int
        Straight pieces of each of the 16 girdle arcs; a power of two.

    Returns
    -------
    StoneMesh
        78 + 64 `arc_segments` - 32 faces, in the same order for every stone but those with tilted facets.
    """
    if stone.is_half_spaces:
        vertices, faces, face_facet = half_space_mesh(stone.facet_normals, stone.facet_offsets, arc_segments)
        plane = np.where(face_facet == GIRDLE, 0, face_facet)
        return _with_normals(
            stone,
            vertices,
            faces,
            face_facet,
            face_facet,
            stone.facet_normals[plane],
            stone.facet_offsets[plane],
        )
    upper, lower = _arcs(stone, arc_segments)
    faces, face_triangle, face_facet = _topology(arc_segments)
    vertices = np.concatenate([stone.vertices, upper[:, 1:-1].reshape(-1, 3), lower[:, 1:-1].reshape(-1, 3)])
    return _with_normals(
        stone,
        vertices,
        faces,
        face_facet,
        face_triangle + N_SECTORS,
        stone.triangle_normals[face_triangle],
        stone.triangle_offsets[face_triangle],
    )


def _with_normals(
    stone: Stone,
    vertices: np.ndarray,
    faces: np.ndarray,
    face_facet: np.ndarray,
    face_patch: np.ndarray,
    face_normals: np.ndarray,
    face_offsets: np.ndarray,
) -> StoneMesh:
    """Make the mesh from its faces and their planes; what is said of girdle faces' planes does not count."""
    on_girdle = face_facet == GIRDLE
    face_normals = np.where(on_girdle[:, None], 0.0, face_normals)
    face_offsets = np.where(on_girdle, 1.0 if stone.girdle.is_round else 0.0, face_offsets)
    corner_normals = np.repeat(face_normals[:, None], 3, axis=1)
    wall = vertices[faces[on_girdle]]
    # Just inside the face: at a corner itself a measured wall may bend.
    inner = wall if stone.girdle.is_round else wall + 1e-6 * (wall.mean(axis=1, keepdims=True) - wall)
    corner_normals[on_girdle] = stone.girdle.normals(inner.reshape(-1, 3)).reshape(-1, 3, 3)
    return StoneMesh(
        vertices=vertices,
        faces=faces,
        face_facet=face_facet,
        face_normals=face_normals,
        face_offsets=face_offsets,
        face_patch=face_patch,
        corner_normals=corner_normals,
    )


# ---- Topology, the same for every stone ----


@lru_cache(maxsize=4)
def _topology(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Faces, the triangle (of 78) whose plane each lies in or -1 - its girdle sector, and its facet."""
    inner = np.arange(N_SECTORS * (n - 1)).reshape(N_SECTORS, n - 1) + N_VERTICES
    upper = np.column_stack([GIRDLE_UPPER, inner, np.roll(GIRDLE_UPPER, -1)])
    lower = np.column_stack([GIRDLE_LOWER, inner + inner.size, np.roll(GIRDLE_LOWER, -1)])
    fan = np.array(list(_halving(0, n)))

    faces, triangle = [TRIANGLES], [np.arange(len(TRIANGLES))]
    for arcs, of_facets, order in (
        (upper, UPPER_GIRDLE_TRIANGLES, (0, 1, 2)),
        (lower, LOWER_GIRDLE_TRIANGLES, (2, 1, 0)),
    ):
        faces.append(arcs[:, fan[:, order]].reshape(-1, 3))
        triangle.append(np.repeat(of_facets, len(fan)))
    a, b, c, d = lower[:, :-1], lower[:, 1:], upper[:, 1:], upper[:, :-1]
    quads = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2).reshape(-1, 3)
    faces.append(quads)
    triangle.append(np.repeat(-1 - np.arange(N_SECTORS), 2 * n))

    all_faces = np.concatenate(faces).astype(np.int32)
    all_triangles = np.concatenate(triangle)
    facet = np.where(all_triangles < 0, GIRDLE, TRIANGLE_FACET[all_triangles]).astype(np.int32)
    for array in (all_faces, all_triangles, facet):
        array.setflags(write=False)
    return all_faces, all_triangles, facet


def _halving(i: int, k: int) -> list[tuple[int, int, int]]:
    """Triangles that fill the segment between a chord and its arc, halving the arc: no slivers."""
    if k - i < 2:
        return []
    m = (i + k) // 2
    return [(i, m, k), *_halving(i, m), *_halving(m, k)]


# ---- Arcs ----


def _arcs(stone: Stone, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of the upper and lower girdle edge, each (16, n + 1, 3), ends included."""
    u = np.broadcast_to(np.linspace(0.0, 1.0, n + 1), (N_SECTORS, n + 1))
    thin = _thin_range(stone)
    if (thin[:, 0] < thin[:, 1]).any():
        # Put a point where the two planes leave the wall and one where they come back to it.
        knots = np.array([0.0, 0.25, 0.75, 1.0])
        u = np.array(
            [np.interp(x, knots, [0.0, *t, 1.0]) if t[0] < t[1] else x for x, t in zip(u, thin, strict=True)]
        )
    upper, lower = _edge(stone, u, "upper"), _edge(stone, u, "lower")
    return _join(stone, upper, lower)


def _edge(stone: Stone, u: np.ndarray, side: str) -> np.ndarray:
    """Points (16, m, 3) of the girdle's edge, at the shares u (16, m) of each sector's azimuth."""
    ring = stone.girdle.upper if side == "upper" else stone.girdle.lower
    facets = UPPER_GIRDLE_FACETS if side == "upper" else LOWER_GIRDLE_FACETS
    start = np.arctan2(ring[:, 1], ring[:, 0])
    step = np.diff(start, append=start[0]) % (2 * np.pi)
    azimuth = start[:, None] + u * step[:, None]
    direction = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)

    radius = np.ones_like(azimuth)
    for _ in range(1 if stone.girdle.is_round else 30):
        x, y = radius * direction[..., 0], radius * direction[..., 1]
        z = _plane_height(stone, facets, x, y)
        before, radius = radius, stone.girdle.radius(x, y, z)
        if np.abs(radius - before).max() < 1e-15:  # it contracts fast: the wall is nearly vertical
            break
    points = np.concatenate(
        [
            radius[..., None] * direction,
            _plane_height(stone, facets, radius * direction[..., 0], radius * direction[..., 1])[..., None],
        ],
        axis=-1,
    )
    # The ends are the stone's own vertices, to the last bit.
    points[u == 0.0] = ring[np.nonzero(u == 0.0)[0]]
    points[u == 1.0] = np.roll(ring, -1, axis=0)[np.nonzero(u == 1.0)[0]]
    return points


def _plane_height(stone: Stone, facets: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    n, offset = stone.facet_normals[facets][:, None], stone.facet_offsets[facets][:, None]
    return np.asarray((offset - n[..., 0] * x - n[..., 1] * y) / n[..., 2])


def _thin_range(stone: Stone) -> np.ndarray:
    """(16, 2): shares of each sector between which the lower edge would rise above the upper one."""
    u = np.broadcast_to(np.linspace(0.0, 1.0, 4097), (N_SECTORS, 4097))
    gap = _edge(stone, u, "upper")[..., 2] - _edge(stone, u, "lower")[..., 2]
    out = np.zeros((N_SECTORS, 2))
    for sector, thin in enumerate(gap < 0):
        inside = np.flatnonzero(thin)
        if inside.size:
            out[sector] = u[0, max(inside[0] - 1, 0)], u[0, min(inside[-1] + 1, u.shape[1] - 1)]
    return out


def _join(stone: Stone, upper: np.ndarray, lower: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Move the points of both edges, where they have crossed, to where the two planes meet."""
    crossed = upper[..., 2] < lower[..., 2]
    if not crossed.any():
        return upper, lower
    direction = upper[..., :2] + lower[..., :2]
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    sides = []
    for facets in (UPPER_GIRDLE_FACETS, LOWER_GIRDLE_FACETS):
        n = stone.facet_normals[facets][:, None]
        at_axis = stone.facet_offsets[facets][:, None] / n[..., 2]
        slope = -(n[..., :2] * direction).sum(axis=-1) / n[..., 2]
        sides.append((np.broadcast_to(at_axis, slope.shape), slope))
    (z_upper, slope_upper), (z_lower, slope_lower) = sides
    radius = (z_lower - z_upper) / (slope_upper - slope_lower)
    meeting = np.concatenate(
        [radius[..., None] * direction, (z_upper + slope_upper * radius)[..., None]], axis=-1
    )
    return np.where(crossed[..., None], meeting, upper), np.where(crossed[..., None], meeting, lower)

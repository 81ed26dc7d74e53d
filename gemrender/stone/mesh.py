"""The stone as a watertight triangle mesh.

A polyhedron's polygons are cut into triangles. A round girdle is cut into level pieces first, inside its
cylinder, so that each girdle facet goes on beyond its chord, as the same plane, in short straight pieces
(`docs/model.md`, section 2). Corners are computed once and shared by their facets to the last bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.stone.polyhedron import Polyhedron
from gemrender.stone.solid import ROUND_PIECES, MeshSolid
from gemrender.stone.stone import Stone

__all__ = ["StoneMesh", "tessellate"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StoneMesh:
    """A closed triangle mesh of a stone.

    Attributes
    ----------
    vertices : (v, 3) float64
        Positions [stone's unit].
    faces : (f, 3) int32
        Vertices of each face, anticlockwise seen from outside; every edge is shared by two faces.
    face_facet : (f,) int32
        Facet that each face belongs to.
    face_normals : (f, 3) float64
        Outward unit normal of the plane that each face lies in; 0 on a round girdle.
    face_offsets : (f,) float64
        Offset of that plane [stone's unit]; on a round girdle the radius of its cylinder.
    face_patch : (f,) int64
        Plane of each face, a round girdle's last: across its border the normal changes.
    corner_normals : (f, 3, 3) float64
        Outward unit normal at each corner of each face: the plane's, or the cylinder's.
    """

    vertices: np.ndarray
    faces: np.ndarray
    face_facet: np.ndarray
    face_normals: np.ndarray
    face_offsets: np.ndarray
    corner_normals: np.ndarray
    face_patch: np.ndarray

    def split(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the mesh with vertices of their own for each plane: one normal a vertex.

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


def tessellate(stone: Stone, pieces: int = ROUND_PIECES) -> StoneMesh:
    """Cut the stone into a watertight mesh.

    Parameters
    ----------
    stone : Stone
        The stone.
    pieces : int
        Level facets that a round girdle is cut into; a multiple of 32.
    """
    solid = stone.solid
    if isinstance(solid, MeshSolid):
        flat = np.unique(np.column_stack([solid.facet, solid.planes]), axis=0, return_inverse=True)[1]
        return _mesh(solid.vertices, solid.triangles, solid.facet, flat.reshape(-1), solid.planes)
    body = solid.polyhedron if pieces == ROUND_PIECES else solid.cut(pieces)
    faces, patch = _triangles(body)
    planes, n = solid.planes, len(solid.planes)
    facet = np.where(patch < n, solid.facet[np.minimum(patch, n - 1)], solid.n_facets - 1)
    if solid.is_round:
        planes = np.concatenate([planes, [[0.0, 0.0, 0.0, 1.0]]])
        patch = np.minimum(patch, n)
    return _mesh(body.vertices, faces, facet, patch, planes[patch])


def _triangles(body: Polyhedron) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of all polygons, (f, 3), and the plane that each lies in, (f,)."""
    corners = np.diff(body.starts)
    number = np.maximum(corners - 2, 0)
    before = np.cumsum(number) - number
    faces = np.empty((number.sum(), 3), dtype=np.int64)
    for k in np.unique(corners[corners > 2]).tolist():
        of_k = np.flatnonzero(corners == k)
        polygons = body.corners[body.starts[of_k][:, None] + np.arange(k)]
        faces[before[of_k][:, None] + np.arange(k - 2)] = polygons[:, _halving_of(k)]
    return faces, np.repeat(np.arange(len(corners)), number)


def _mesh(
    vertices: np.ndarray, faces: np.ndarray, facet: np.ndarray, patch: np.ndarray, planes: np.ndarray
) -> StoneMesh:
    normals = np.repeat(planes[:, None, :3], 3, axis=1)
    on_wall = ~planes[:, :3].any(axis=1)
    radial = vertices[faces[on_wall]] * (1.0, 1.0, 0.0)
    normals[on_wall] = radial / np.linalg.norm(radial, axis=-1, keepdims=True)
    return StoneMesh(
        vertices=vertices,
        faces=faces.astype(np.int32),
        face_facet=facet.astype(np.int32),
        face_normals=planes[:, :3],
        face_offsets=planes[:, 3],
        face_patch=patch,
        corner_normals=normals,
    )


_FANS: dict[int, np.ndarray] = {}


def _halving_of(corners: int) -> np.ndarray:
    """Triangles (corners - 2, 3) that fill a convex polygon, by halving it: no slivers on arcs."""
    if corners not in _FANS:
        _FANS[corners] = np.array(list(_halving(0, corners - 1)), dtype=np.int64).reshape(-1, 3)
    return _FANS[corners]


def _halving(first: int, last: int) -> list[tuple[int, int, int]]:
    if last - first < 2:
        return []
    middle = (first + last) // 2
    return [(first, middle, last), *_halving(first, middle), *_halving(middle, last)]

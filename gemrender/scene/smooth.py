"""Meshes with smooth normals, broken where faces meet at a crease."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["PlainMesh", "creased", "joined"]

#: Faces that meet at more than this are a crease [deg].
CREASE_DEG = 40.0
#: Faces of less area are none [share of the square of the mesh's size].
_NO_AREA = 1e-14


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlainMesh:
    """A mesh with one normal a vertex.

    Attributes
    ----------
    positions, normals : (v, 3) float64
        Vertices and their unit normals.
    faces : (f, 3) int64
        Vertices of each face.
    """

    positions: np.ndarray
    normals: np.ndarray
    faces: np.ndarray

    @property
    def triangles(self) -> np.ndarray:
        """The corners of each face, (f, 3, 3)."""
        return np.asarray(self.positions[self.faces])

    def moved(self, rotation: np.ndarray, scale: float, shift: np.ndarray) -> PlainMesh:
        """Return it with each point p at shift + scale * rotation p."""
        return PlainMesh(
            positions=scale * self.positions @ rotation.T + shift,
            normals=self.normals @ rotation.T,
            faces=self.faces,
        )


def joined(parts: list[PlainMesh]) -> PlainMesh:
    """Return several meshes as one."""
    first = np.cumsum([0, *(len(part.positions) for part in parts[:-1])])
    return PlainMesh(
        positions=np.concatenate([part.positions for part in parts]),
        normals=np.concatenate([part.normals for part in parts]),
        faces=np.concatenate([part.faces + start for part, start in zip(parts, first, strict=True)]),
    )


def creased(positions: np.ndarray, faces: np.ndarray, crease_deg: float = CREASE_DEG) -> PlainMesh:
    """Return a mesh with the normals of a surface that is smooth but for its creases.

    Vertices in one place are joined first. Corners of neighbours are then one vertex where the faces meet at
    no more than the crease's angle; its normal is the mean of theirs weighted by the angles (Thuermer &
    Wuethrich, "Computing vertex normals from polygonal facets", J. Graphics Tools 3 (1998)).

    Parameters
    ----------
    positions : (v, 3) float64
        Vertices.
    faces : (f, 3) int
        Vertices of each face, wound alike.
    crease_deg : float
        The angle [deg].
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    places, vertex = np.unique(positions, axis=0, return_inverse=True)
    faces = vertex.reshape(-1)[faces]
    corners = places[faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(area, axis=1)
    kept = length > _NO_AREA * float(np.ptp(positions, axis=0).max()) ** 2
    faces, corners, unit = faces[kept], corners[kept], area[kept] / length[kept, None]
    # Each edge of a face, with its corners' numbers, the one at the lower vertex first
    n = len(faces)
    start = np.concatenate([3 * np.arange(n) + k for k in range(3)])
    end = np.concatenate([3 * np.arange(n) + (k + 1) % 3 for k in range(3)])
    flat = faces.reshape(-1)
    swap = flat[start] > flat[end]
    low, high = np.where(swap, end, start), np.where(swap, start, end)
    order = np.lexsort((flat[high], flat[low]))
    low, high = low[order], high[order]
    same = (flat[low[1:]] == flat[low[:-1]]) & (flat[high[1:]] == flat[high[:-1]])
    a, b = np.flatnonzero(same), np.flatnonzero(same) + 1
    cos = np.einsum("ij,ij->i", unit[low[a] // 3], unit[low[b] // 3])
    a, b = a[cos >= np.cos(np.radians(crease_deg))], b[cos >= np.cos(np.radians(crease_deg))]
    ends = np.concatenate([low[a], high[a]]), np.concatenate([low[b], high[b]])
    graph = coo_array((np.ones(len(ends[0]), dtype=np.int8), ends), shape=(3 * n, 3 * n))
    count, label = connected_components(graph, directed=False)
    total = np.zeros((count, 3))
    for k in range(3):
        one, other = (corners[:, (k + j) % 3] - corners[:, k] for j in (1, 2))
        cross = np.linalg.norm(np.cross(one, other), axis=1)
        angle = np.arctan2(cross, np.einsum("ij,ij->i", one, other))
        np.add.at(total, label[k::3], angle[:, None] * unit)
    made = np.empty((count, 3))
    made[label] = corners.reshape(-1, 3)
    norm = np.linalg.norm(total, axis=1, keepdims=True)
    return PlainMesh(
        positions=made,
        normals=total / np.where(norm > 0, norm, 1.0),
        faces=label.reshape(-1, 3).astype(np.int64),
    )

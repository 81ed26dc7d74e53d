"""Planes of facets from vertices."""

from __future__ import annotations

import numpy as np

__all__ = ["FLAT_TOLERANCE", "flat_facets", "mean_planes"]

#: Largest distance of a vertex from its facet's plane that counts as flat [stone's unit]: rounding.
FLAT_TOLERANCE = 1e-12


def mean_planes(vertices: np.ndarray, triangles: np.ndarray, facet: np.ndarray) -> np.ndarray:
    """Return the mean plane of each facet over its area, (n, 4): outward unit normal and offset.

    Parameters
    ----------
    vertices : (v, 3) float64 or complex128
        Positions; complex ones give complex planes: analytic functions, for derivatives by the complex step.
    triangles : (f, 3) int
        Vertices of each triangle, anticlockwise seen from outside.
    facet : (f,) int
        Facet that each triangle belongs to, 0 to n - 1.
    """
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    # The normal of the facet's projected area: the sum over its triangles.
    total = np.zeros((int(facet.max()) + 1, 3), dtype=vertices.dtype)
    np.add.at(total, facet, np.cross(b - a, c - a))
    normals = total / _lengths(total)
    corner = np.unique(np.column_stack([np.repeat(facet, 3), triangles.reshape(-1)]), axis=0)
    sums = np.zeros((len(total), 3), dtype=vertices.dtype)
    np.add.at(sums, corner[:, 0], vertices[corner[:, 1]])
    middles = sums / np.bincount(corner[:, 0], minlength=len(total))[:, None]
    return np.column_stack([normals, (normals * middles).sum(axis=1)])


def flat_facets(
    vertices: np.ndarray, triangles: np.ndarray, facet: np.ndarray, tolerance: float = FLAT_TOLERANCE
) -> np.ndarray:
    """Return the plane of each triangle, (f, 4) float64; those of a flat facet are its own, to the last bit.

    Parameters as for `mean_planes`; a facet is flat if its vertices lie this near its mean plane.
    """
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = cross / _lengths(cross)
    planes = np.column_stack([normals, np.einsum("ij,ij->i", normals, corners.mean(axis=1))])
    mean = mean_planes(vertices, triangles, facet)[facet]
    off = np.abs(np.einsum("ijk,ik->ij", corners, mean[:, :3]) - mean[:, 3:]).max(axis=1)
    largest = np.zeros(int(facet.max()) + 1)
    np.maximum.at(largest, facet, off)
    flat = (largest <= tolerance)[facet]
    return np.where(flat[:, None], mean, planes)


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (n, 3), (n, 1); analytic, unlike a norm."""
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=1, keepdims=True)))

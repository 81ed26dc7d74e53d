"""Solids that touch face to face, where a ray from one starts within the other."""

from __future__ import annotations

import numpy as np

__all__ = ["faces_touch"]

#: Normals of faces that lie on each other [cosine].
_OPPOSITE = -1 + 1e-6
#: How far two triangles of one plane must reach into each other [share of the smaller solid's size].
_COMMON = 1e-4
#: Pairs of triangles that are looked at together.
_PAIRS = 1 << 20


def faces_touch(one: np.ndarray, other: np.ndarray, gap: float) -> bool:
    """Return whether faces of two solids lie on each other.

    Two triangles of a plane have an area in common exactly if no line along one of their sides separates
    them.

    Parameters
    ----------
    one, other : (n, 3, 3) float64
        Triangles of each, anticlockwise seen from outside.
    gap : float
        How far apart such faces may be [scene unit].
    """
    size = min(float(np.ptp(t.reshape(-1, 3), axis=0).max()) for t in (one, other))
    one = _meeting(one, other, gap)
    if not len(one):
        return False
    other = _meeting(other, one, gap)
    if not len(other):
        return False
    normals, others_normals = _normals(one), _normals(other)
    middles, places = one.mean(axis=1), other.mean(axis=1)
    step = max(1, _PAIRS // len(other))
    for first in range(0, len(one), step):
        n = normals[first : first + step]
        away = places @ n.T - np.einsum("ij,ij->i", middles[first : first + step], n)
        j, i = np.nonzero((others_normals @ n.T < _OPPOSITE) & (np.abs(away) <= gap))
        if len(i) and (_common(one[first + i], other[j], normals[first + i]) > _COMMON * size).any():
            return True
    return False


def _meeting(triangles: np.ndarray, other: np.ndarray, gap: float) -> np.ndarray:
    """Return the triangles whose boxes come as near as `gap` to the box around others."""
    low, high = other.min(axis=(0, 1)) - gap, other.max(axis=(0, 1)) + gap
    return np.asarray(
        triangles[((triangles.max(axis=1) >= low) & (triangles.min(axis=1) <= high)).all(axis=1)]
    )


def _normals(triangles: np.ndarray) -> np.ndarray:
    """Return unit normals (n, 3), 0 of triangles without an area."""
    area = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(area, axis=1, keepdims=True)
    return np.asarray(area / np.where(length > 0, length, 1))


def _common(a: np.ndarray, b: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return how far pairs of triangles (n, 3, 3) of one plane overlap across their sides, at least, (n,)."""
    least = np.full(len(a), np.inf)
    for triangle in (a, b):
        for k in range(3):
            across = np.cross(normals, triangle[:, (k + 1) % 3] - triangle[:, k])
            length = np.linalg.norm(across, axis=1, keepdims=True)
            across = across / np.where(length > 0, length, 1)
            p, q = (np.einsum("nki,ni->nk", t, across) for t in (a, b))
            overlap = np.minimum(p.max(axis=1), q.max(axis=1)) - np.maximum(p.min(axis=1), q.min(axis=1))
            least = np.minimum(least, overlap)
    return least

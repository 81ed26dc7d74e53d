"""Planes of a round brilliant's 57 plane facets from its vertices."""

from __future__ import annotations

import numpy as np

from gemrender.cuts.round_brilliant.topology import FACET_POLYGONS, N_VERTICES, TRIANGLE_FACET, TRIANGLES

__all__ = ["facet_planes"]

#: Where each facet's triangles begin, and what takes vertices (57, 3) to the mean of each facet's corners.
_FIRST = np.searchsorted(TRIANGLE_FACET, np.arange(len(FACET_POLYGONS)))
_MIDDLES = np.zeros((len(FACET_POLYGONS), N_VERTICES))
for _facet, _polygon in enumerate(FACET_POLYGONS):
    _MIDDLES[_facet, list(_polygon)] = 1 / len(_polygon)


def facet_planes(vertices: np.ndarray) -> np.ndarray:
    """Return the planes of the facets of 57 vertices (57, 3), (57, 4): outward unit normal and offset.

    Of a facet that is not flat, the mean over its area. Complex vertices give complex planes: analytic
    functions, for derivatives by the complex step.
    """
    a, b, c = vertices[TRIANGLES.T]
    b, c = b - a, c - a
    # The normal of the facet's projected area: the sum over its triangles.
    cross = b[:, [1, 2, 0]] * c[:, [2, 0, 1]] - b[:, [2, 0, 1]] * c[:, [1, 2, 0]]
    total = np.add.reduceat(cross, _FIRST)
    planes = np.empty((len(total), 4), dtype=total.dtype)
    planes[:, :3] = total / np.sqrt((total * total).sum(axis=1, keepdims=True))
    planes[:, 3] = (planes[:, :3] * (_MIDDLES @ vertices)).sum(axis=1)
    return planes

"""The frame of stones that are not round: the middle and half the longer side of the outline's box."""

from __future__ import annotations

import numpy as np

from gemrender.stone.facets import LEVEL
from gemrender.stone.polyhedron import Polyhedron, intersect

__all__ = ["frame_of_planes", "in_frame", "lower_edge"]


def in_frame(planes: np.ndarray) -> tuple[np.ndarray, float]:
    """Move and scale planes to the stone's frame.

    The origin is the middle of the outline's bounding box, at the height of the lowest point of the girdle's
    lower edge (without a girdle: of the edge between crown and pavilion); the unit is half the longer side.

    Parameters
    ----------
    planes : (p, 4) float64
        Outward unit normals and offsets, in any unit of length; z along the stone's axis, table up.

    Returns
    -------
    ((p, 4) float64, float)
        The planes in the frame, and its unit of length in that of the planes given.

    Raises
    ------
    InputError
        The planes do not close.
    """
    origin, unit = frame_of_planes(intersect(planes))
    moved = planes[:, 3] - planes[:, :3] @ origin
    return np.column_stack([planes[:, :3], moved / unit]), unit


def frame_of_planes(solid: Polyhedron) -> tuple[np.ndarray, float]:
    """Return origin (3,) and unit of a polyhedron's frame, in its own unit of length."""
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    middle = 0.5 * (low + high)
    return np.array([*middle[:2], lower_edge(solid).min()]), 0.5 * float((high - low)[:2].max())


def lower_edge(solid: Polyhedron) -> np.ndarray:
    """Return the heights of the corners of the pavilion's upper edge, (k,) float64.

    That is the girdle's lower edge, and where there is no girdle the edge between crown and pavilion.
    """
    rise = solid.planes[:, 2]
    plane = np.repeat(np.arange(len(rise)), np.diff(solid.starts))
    pavilion, above = np.zeros((2, len(solid.vertices)), dtype=bool)
    pavilion[solid.corners[(rise < -LEVEL)[plane]]] = True
    above[solid.corners[(rise >= -LEVEL)[plane]]] = True
    edge = pavilion & above
    return np.asarray(solid.vertices[edge if edge.any() else above, 2])

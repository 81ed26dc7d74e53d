"""The area of a stone's view, which scores are shares of."""

from __future__ import annotations

import numpy as np

from gemrender.observation import View
from gemrender.stone import ConvexSolid, Stone
from gemrender.stone.polyhedron import Polyhedron
from gemrender.stone.solid import ROUND_PIECES

__all__ = ["view_area"]

#: The outline of a thin stone is integrated by Gauss's rule over so many pieces, at so many azimuths each.
#: The corners of a symmetric one lie between pieces.
_PIECES, _NODES = 1024, 4
#: A girdle that is thicker than this at 128 azimuths is so everywhere [girdle radius]: between them its
#: thickness changes by a third of it.
_THICK, _LOOKS = 1e-3, 128


def view_area(stone: Stone, view: View) -> float:
    """Return the area of a stone's view [girdle radius^2], right to some 1e-6.

    A round girdle seen from straight above is the unit disc, unless it is so thin that crown and pavilion
    meet within it. Views from the side are measured on polyhedra with coarser and finer girdles, extrapolated
    to round ones: what they lack falls as the square of the number of pieces (Richardson).
    """
    solid = stone.solid
    assert isinstance(solid, ConvexSolid)
    if solid.is_round and view.tilt_deg == 0:
        return _area_from_above(stone)
    eye = view.basis()[2]

    def seen(body: Polyhedron) -> float:
        return float(np.maximum(body.crosses @ eye, 0.0).sum())

    if not solid.is_round:
        return seen(solid.polyhedron)
    coarse, fine = seen(solid.cut(ROUND_PIECES // 2)), seen(solid.polyhedron)
    return fine + (fine - coarse) / 3


def _area_from_above(stone: Stone) -> float:
    # Height of each plane along each azimuth: on the axis, and its slope by radius.
    normals, offsets = stone.facet_normals, stone.facet_offsets
    crown = normals[:, 2] > 0
    on_axis = offsets / normals[:, 2]

    def slopes_at(azimuth: np.ndarray) -> np.ndarray:
        return np.asarray(-(normals[:, :2] / normals[:, 2:]) @ [np.cos(azimuth), np.sin(azimuth)])

    heights = on_axis[:, None] + slopes_at((np.arange(_LOOKS) + 0.5) * (2 * np.pi / _LOOKS))
    if (heights[crown].min(axis=0) - heights[~crown].max(axis=0)).min() > _THICK:
        return np.pi
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    azimuth = (2 * np.pi / _PIECES) * (np.arange(_PIECES)[:, None] + 0.5 + 0.5 * nodes).ravel()
    slopes, rows, radius = slopes_at(azimuth), np.arange(len(azimuth)), np.ones(len(azimuth))
    # Newton's rule for where the crown's lowest and the pavilion's highest plane meet. Their distance is a
    # concave function of the radius, so that it comes from outside and ends after a few planes.
    for _ in range(len(normals)):
        heights = on_axis[:, None] + slopes * radius
        top = np.where(crown[:, None], heights, np.inf).argmin(axis=0)
        bottom = np.where(crown[:, None], -np.inf, heights).argmax(axis=0)
        thickness = heights[top, rows] - heights[bottom, rows]
        thin = thickness < 0.0
        if not thin.any():
            break
        by_radius = slopes[top, rows] - slopes[bottom, rows]
        radius[thin] -= thickness[thin] / by_radius[thin]
        if np.abs(thickness[thin]).max() < 1e-15:
            break
    lacking = (1.0 - radius**2).reshape(_PIECES, _NODES) @ weights  # of twice the mean
    return float(np.pi - 0.5 * np.pi * lacking.mean())

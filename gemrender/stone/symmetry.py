"""The symmetry of a stone about an upright axis: rotations and mirror planes, found from its planes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.stone.facets import LEVEL
from gemrender.stone.solid import ConvexSolid

__all__ = ["NONE", "Symmetry", "find_symmetry"]

#: How far a plane's image may be from the plane it falls on [stone's unit]: rounding in a file's nine digits.
_SAME = 3e-7
#: Most rotations that are looked for; real designs have up to 24.
_MOST_FOLD = 96


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Symmetry:
    """What leaves a stone as it is.

    Attributes
    ----------
    fold : int
        Turns by 360 / fold degrees about the axis do.
    mirrors : (m,) float64
        Azimuths of the upright mirror planes through the axis [rad], from 0 to below pi, ascending; there are
        `fold` of them, or none.
    centre : (2,) float64
        x and y of the axis [stone's unit].
    images : (m, n_facets) int64
        Facet that each facet falls on in each mirror.
    """

    fold: int
    mirrors: np.ndarray
    centre: np.ndarray
    images: np.ndarray

    def __str__(self) -> str:
        turns = "no rotation" if self.fold == 1 else f"{self.fold}-fold rotation"
        count = len(self.mirrors)
        planes = "no mirror plane" if not count else f"{count} mirror plane{'s' if count > 1 else ''}"
        return f"{turns}, {planes}"


#: No symmetry at all.
NONE = Symmetry(fold=1, mirrors=np.empty(0), centre=np.zeros(2), images=np.empty((0, 0), dtype=np.int64))


def find_symmetry(solid: ConvexSolid) -> Symmetry:
    """Find the symmetry of a convex solid about an upright axis, through the middle of its volume."""
    from scipy.spatial import cKDTree

    centre = np.zeros(2) if solid.is_round else solid.polyhedron.centroid[:2]
    planes = solid.planes.copy()
    planes[:, 3] -= planes[:, :2] @ centre
    tree = cKDTree(planes)

    def image(matrix: np.ndarray) -> np.ndarray | None:
        """Return the plane that each falls on, or None if one falls on none."""
        moved = np.column_stack([planes[:, :2] @ matrix.T, planes[:, 2:]])
        distance, plane = tree.query(moved, distance_upper_bound=_SAME)
        return plane if np.isfinite(distance).all() else None

    inclined = np.flatnonzero(np.abs(planes[:, 2]) < 1 - LEVEL)
    if not len(inclined):
        return NONE
    # Planes that one symmetry can send into each other have the same inclination and distance.
    key = planes[inclined, 2:]
    alike = cKDTree(key).query_ball_point(key, _SAME)
    rarest = int(np.argmin([len(others) for others in alike]))
    fold = next(
        (n for n in range(min(_MOST_FOLD, len(inclined)), 1, -1) if image(_turn(2 * np.pi / n)) is not None),
        1,
    )
    azimuth = np.arctan2(planes[inclined, 1], planes[inclined, 0])
    for other in alike[rarest]:
        first = 0.5 * (azimuth[rarest] + azimuth[other]) % (np.pi / fold)
        if np.pi / fold - first < _SAME:  # 0, but for rounding
            first = 0.0
        mirrors = first + np.arange(fold) * (np.pi / fold)
        fallen_on = []
        for at in mirrors:
            plane = image(_mirror(at))
            if plane is None:
                break
            fallen_on.append(plane)
        if len(fallen_on) < fold:
            continue
        images = np.tile(np.arange(solid.n_facets), (fold, 1))
        for row, plane in zip(images, fallen_on, strict=True):
            row[solid.facet] = solid.facet[plane]
        return Symmetry(fold=fold, mirrors=mirrors, centre=centre, images=images)
    return Symmetry(fold=fold, mirrors=np.empty(0), centre=centre, images=NONE.images)


def _turn(angle: float) -> np.ndarray:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def _mirror(azimuth: float) -> np.ndarray:
    cos, sin = np.cos(2 * azimuth), np.sin(2 * azimuth)
    return np.array([[cos, sin], [sin, -cos]])

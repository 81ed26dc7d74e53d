"""The area of a stone's view, which scores are shares of."""

from __future__ import annotations

import numpy as np

from gemrender.beam.polygons import seen_outlines
from gemrender.beam.solid import NO_WEDGE, BeamStone
from gemrender.observation import View
from gemrender.stone import ConvexSolid
from gemrender.stone.facets import LEVEL

__all__ = ["view_area"]

_UP, _RIGHT = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


def view_area(convex: BeamStone, view: View) -> float:
    """Return the area of a convex stone's view [girdle radius^2].

    It is what the surface shows towards the eye: of plane facets their areas times the cosine, and of a round
    girdle the integral of its height times the cosine. Both are known in closed form, since seen along the
    axis a facet is a polygon that the unit circle cuts.
    """
    solid, eye = convex.stone.solid, view.basis()[2]
    assert isinstance(solid, ConvexSolid)
    if not solid.is_round:
        return float(np.maximum(solid.polyhedron.crosses @ eye, 0.0).sum())
    planes, total = convex.solid.values, 0.0
    side = np.hypot(eye[0], eye[1])
    across = float(np.arctan2(eye[1], eye[0]))
    towards = np.array([[np.cos(across), np.sin(across)], [-np.sin(across), np.cos(across)]])
    level = np.abs(planes[:, 2]) <= LEVEL
    if not side and not level.any() and _is_thick(planes):
        return np.pi
    if level.any() and side:  # a flat cut into the cylinder, seen from neither end
        total += float(np.maximum(solid.polyhedron.crosses[: len(planes)][level] @ eye, 0.0).sum())
    for end in (1.0, -1.0) if side else (1.0,):
        basis = np.stack([_RIGHT, end * np.array([0.0, 1.0, 0.0]), end * _UP])
        outlines, ends = seen_outlines(convex.solid._replace(rim=NO_WEDGE), basis)
        of, start, stop = _edges(outlines * [1.0, end], ends, end)
        inside, from_angle, to_angle = _within_circle(start, stop)
        plane = planes[of]
        area = inside + 0.5 * (to_angle - from_angle).sum(axis=1)
        total += float(np.maximum(plane[:, :3] @ eye, 0.0) / np.abs(plane[:, 2]) @ area)
        if side:
            turned = np.column_stack([plane[:, :2] @ towards.T, plane[:, 2:]])
            wall = _under_arcs(turned, to_angle - across) - _under_arcs(turned, from_angle - across)
            total += float(end * side * wall.sum())
    return total


def _is_thick(planes: np.ndarray) -> bool:
    """Whether crown and pavilion planes (p, 4) meet nowhere within the unit circle."""
    heights = np.column_stack([planes[:, :2], planes[:, 3]]) / planes[:, 2:3]
    upper, lower = (heights[planes[:, 2] * sign > 0] for sign in (1.0, -1.0))
    if not len(upper) or not len(lower):
        return True
    # Each crown plane above every pavilion plane wherever either is within the circle: so of most stones.
    if (upper[:, 2] - np.hypot(upper[:, 0], upper[:, 1])).min() > (
        lower[:, 2] + np.hypot(lower[:, 0], lower[:, 1])
    ).max():
        return True
    between = upper[:, None] - lower
    return bool((between[..., 2] ** 2 >= between[..., 0] ** 2 + between[..., 1] ** 2).all())


def _edges(corners: np.ndarray, ends: np.ndarray, sense: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the polygon of each edge (e,), and where it begins and ends (e, 2), anticlockwise from above.

    From corners (c, 2) of polygons one after the other, in the sense +1 or -1, and where those of each end.
    """
    numbers = np.diff(ends, prepend=0)
    of = np.repeat(np.arange(len(ends)), numbers)
    after = np.arange(1, len(corners) + 1)
    last = ends[numbers > 0] - 1
    after[last] = (ends - numbers)[numbers > 0]
    return (of, corners, corners[after]) if sense > 0 else (of, corners[after], corners)


def _within_circle(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return what edges from a to b, (e, 2), add to the part of their polygons within the unit circle.

    Returns
    -------
    inside : (e,) float64
        Area between the origin and what of the edge lies within the circle, signed.
    start, stop : (e, 2) float64
        Angles between which the rest is seen from the origin, before it and after it [rad], signed: there the
        circle bounds the part.
    """
    along = b - a
    square, half = (along**2).sum(axis=1), (a * along).sum(axis=1)
    left = half**2 - square * ((a**2).sum(axis=1) - 1.0)
    meets = (left > 0.0) & (square > 0.0)
    root, length = np.sqrt(np.where(meets, left, 0.0)), np.where(square > 0.0, square, 1.0)
    t0, t1 = (np.clip(np.where(meets, (-half + s * root) / length, 1.0), 0.0, 1.0) for s in (-1.0, 1.0))
    enters, leaves = a + t0[:, None] * along, b - (1.0 - t1)[:, None] * along  # a and b themselves, if inside
    inside = 0.5 * (enters[:, 0] * leaves[:, 1] - enters[:, 1] * leaves[:, 0])
    points = np.stack([a, enters, leaves, b], axis=1)
    angle = np.arctan2(points[..., 1], points[..., 0])
    start, turn = angle[:, [0, 2]], angle[:, [1, 3]] - angle[:, [0, 2]]
    return inside, start, start + (turn + np.pi) % (2 * np.pi) - np.pi


def _under_arcs(planes: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Integrate the height of planes (e, 4) on the unit circle times the cosine where that is positive.

    From the azimuth 0 to angles (e, k) [rad], from -3 pi to 3 pi.
    """
    nx, ny, nz, offset = (planes[:, k, None] for k in range(4))

    def upto(x: np.ndarray | float) -> np.ndarray:
        sin = np.sin(x)
        return np.asarray((offset * sin - 0.5 * nx * (x + sin * np.cos(x)) - 0.5 * ny * sin**2) / nz)

    wrapped = (angle + np.pi) % (2 * np.pi) - np.pi
    turns = np.round((angle - wrapped) / (2 * np.pi))
    whole = upto(0.5 * np.pi) - upto(-0.5 * np.pi)
    return np.asarray(upto(np.clip(wrapped, -0.5 * np.pi, 0.5 * np.pi)) + turns * whole)

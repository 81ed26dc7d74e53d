"""Convex solids of meshes that carry their planes, and the cylinder of a round girdle.

A ray inside a convex solid needs no ray tracer: the next surface is the nearest plane that it runs towards.
That takes a fraction of the time of a query to Embree, and no edge can be slipped through.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.scene.content_cache import cached_by_content

__all__ = ["PlacedSolid", "fits", "placed_solid"]

#: How far a vertex may lie beyond a plane, or beside the girdle's cylinder [share of the solid's size]: the
#: rounding of single precision in positions and normals.
_FLAT = 3e-6
#: A mesh with more planes is no cut stone, and is left to the ray tracer.
_MOST_PLANES = 5000
#: Vertices times planes that are looked at together.
_AT_ONCE = 1 << 22


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlacedSolid:
    """A convex solid in world coordinates.

    Attributes
    ----------
    planes : (n, 4) float64
        Outward unit normal, and offset: a point p of the plane has normal . p = offset [scene unit].
    cylinder : (7,) float64 or None
        Axis (unit vector), a point of the axis, and the radius of the girdle's cylinder [scene unit].
    """

    planes: np.ndarray
    cylinder: np.ndarray | None

    def __post_init__(self) -> None:
        for array in (self.planes, *([] if self.cylinder is None else [self.cylinder])):
            array.setflags(write=False)  # the same solid is returned again

    def holds(self, points: np.ndarray, margin: float = 0.0) -> np.ndarray:
        """Return whether points (k, 3) lie inside, or less than `margin` outside, (k,) bool."""
        return self.depth(points) >= -margin

    def depth(self, points: np.ndarray) -> np.ndarray:
        """Return how far points (k, 3) are inside, negative outside, (k,) [scene unit]."""
        depth = np.full(len(points), np.inf)
        step = max(1, _AT_ONCE // max(len(points), 1))
        for first in range(0, len(self.planes), step):
            planes = self.planes[first : first + step]
            np.minimum(depth, (planes[:, 3] - points @ planes[:, :3].T).min(axis=1), out=depth)
        if self.cylinder is not None:
            beside = _radii(points, self.cylinder[:3], self.cylinder[3:6])
            depth = np.minimum(depth, self.cylinder[6] - beside)
        return depth


def fits(positions: np.ndarray, faces: np.ndarray, planes: np.ndarray) -> bool:
    """Return whether the vertices of each face lie on its plane; false where a mesh has been moved.

    Parameters
    ----------
    positions : (v, 3) float
        Vertices.
    faces : (f, 3) int
        Vertices of each face.
    planes : (f, 4) float64
        Outward unit normal and offset of each. Of a round girdle, whose normals are 0, it is not looked at.
    """
    flat = planes[:, :3].any(axis=1)
    off = np.einsum("fki,fi->fk", positions[faces[flat]], planes[flat, :3]) - planes[flat, 3:]
    return bool((np.abs(off) <= _FLAT * _size(positions)).all())  # false for NaN too


@cached_by_content
def placed_solid(
    positions: np.ndarray, normals: np.ndarray, faces: np.ndarray, planes: np.ndarray
) -> PlacedSolid | None:
    """Return the solid that a stone's mesh bounds, or None if it is not convex or its girdle not round.

    The planes are taken as the mesh carries them. Where they do not fit, as after a transform of the mesh,
    each is fitted anew to its faces, to the single precision of their vertices.

    Parameters
    ----------
    positions, normals : (v, 3) float
        Vertices [scene unit] and their outward normals; a vertex belongs to one plane only.
    faces : (f, 3) int
        Vertices of each face.
    planes : (f, 4) float64
        Outward unit normal and offset of the plane of each face, to the last bit the same for faces of one
        plane; on a round girdle the normal is 0.
    """
    positions, normals = np.asarray(positions, dtype=np.float64), np.asarray(normals, dtype=np.float64)
    size = _size(positions)
    flat = planes[:, :3].any(axis=1)
    distinct, plane_of = np.unique(planes[flat], axis=0, return_inverse=True)
    if not 0 < len(distinct) <= _MOST_PLANES:
        return None
    if not fits(positions, faces, planes):
        plane_of, flat_faces = plane_of.reshape(-1), faces[flat]
        corners = positions[flat_faces]
        area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        # Vertex normals that were moved with the mesh are the best; those that Mitsuba makes anew are less
        # so than the faces themselves.
        for towards in (normals[flat_faces].sum(axis=1), area):
            distinct = _fitted(corners, towards, plane_of)
            if fits(positions, flat_faces, distinct[plane_of]):
                break
        else:
            return None
    solid = PlacedSolid(planes=distinct, cylinder=None)
    if not solid.holds(positions, margin=_FLAT * size).all():
        return None
    if flat.all():
        return solid
    on_girdle = np.unique(faces[~flat])
    if not normals[on_girdle].any():
        return None
    cylinder = _cylinder(positions[on_girdle], normals[on_girdle])
    beside = np.abs(_radii(positions[on_girdle], cylinder[:3], cylinder[3:6]) - cylinder[6])
    if not beside.max() <= _FLAT * size:
        return None
    return PlacedSolid(planes=distinct, cylinder=cylinder)


def _size(positions: np.ndarray) -> float:
    """Return what single precision rounds shares of: it goes with the distance from the origin."""
    return max(float(np.linalg.norm(np.ptp(positions, axis=0))), 0.1 * float(np.abs(positions).max()))


def _fitted(corners: np.ndarray, towards: np.ndarray, plane_of: np.ndarray) -> np.ndarray:
    """Fit planes to faces that are known to share them, (n, 4).

    Parameters
    ----------
    corners : (f, 3, 3) float64
        Corners of the faces.
    towards : (f, 3) float64
        Vectors along their normals, in or out, with their weights.
    plane_of : (f,) int
        Plane of each.
    """
    count = np.bincount(plane_of)
    normal, middle = (
        np.column_stack([np.bincount(plane_of, values[:, k]) for k in range(3)]) / count[:, None]
        for values in (towards, corners.mean(axis=1))
    )
    length = np.linalg.norm(normal, axis=1)
    normal /= np.where(length > 0, length, 1)[:, None]
    normal *= np.where(np.einsum("ij,ij->i", normal, middle - corners.mean(axis=(0, 1))) < 0, -1, 1)[:, None]
    offset = np.einsum("ij,ij->i", normal, middle)
    return np.column_stack([normal, np.where(length > 0, offset, np.inf)])  # without a normal it fits nothing


def _cylinder(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Fit a cylinder to points with normals: axis, a point of it, radius, (7,)."""
    axis = np.linalg.svd(normals, full_matrices=False)[2][-1]
    # p - radius n lies on the axis: linear in the centre and the radius.
    flat = points - np.outer(points @ axis, axis)
    across = normals - np.outer(normals @ axis, axis)
    middle_p, middle_n = flat.mean(axis=0), across.mean(axis=0)
    dp, dn = flat - middle_p, across - middle_n
    radius = float((dp * dn).sum() / (dn * dn).sum())
    return np.array([*axis, *(middle_p - radius * middle_n), radius])


def _radii(points: np.ndarray, axis: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Distances of points from an axis, (k,)."""
    to = points - centre
    return np.asarray(np.linalg.norm(to - np.outer(to @ axis, axis), axis=1))

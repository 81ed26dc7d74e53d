"""How a stone rests on a plane: which of its facets it can lie on."""

from __future__ import annotations

import numpy as np

from gemrender.stone import MeshSolid, Stone
from gemrender.stone.facets import LEVEL
from gemrender.stone.polyhedron import Polyhedron, intersect

__all__ = ["resting_plane"]

#: Heights of the centre of mass that differ by a smaller share are alike, and the flattest facet is taken:
#: mains and lower girdle facets of a brilliant, of which a dealer's stones lie on the mains.
_ALIKE = 0.005
#: Inclinations that differ by less are one, and the first plane is taken; so near to the border of a facet
#: the centre of mass does not count as above it [stone's unit].
_SAME = 1e-6
#: Planes of a hull whose normals and offsets differ by less are one.
_SAME_PLANE = 1e-7


def resting_plane(stone: Stone) -> np.ndarray:
    """Return the outward unit normal of the plane that a loose stone lies on, table up, (3,).

    A stone is at rest on a facet (of its convex hull) if its centre of mass is above the facet. Of such
    facets of pavilion and girdle it is the one where the centre of mass is lowest, and of those that are
    alike in that the flattest. A stone that rests on its crown only is held with the nearest of them down.
    """
    solid = stone.solid
    if isinstance(solid, MeshSolid):
        body, centre = _hull(solid.vertices), _centre_of_mass(solid)
    else:
        body, centre = solid.polyhedron, solid.polyhedron.centroid
    down = np.flatnonzero((body.planes[:, 2] <= LEVEL) & (np.diff(body.starts) > 2))
    normals = body.planes[down, :3]
    distances = body.planes[down, 3] - normals @ centre
    stable: list[int] = []
    for k in np.argsort(distances, kind="stable"):  # from the lowest on: few are looked at
        if stable and distances[k] > (1 + _ALIKE) * distances[stable[0]]:
            break
        if _is_above(body, int(down[k]), centre):
            stable.append(int(k))
    if stable:
        normals, distances = normals[sorted(stable)], distances[sorted(stable)]
    normals = normals[distances <= (1 + _ALIKE) * distances.min()]
    return np.asarray(normals[np.flatnonzero(normals[:, 2] <= normals[:, 2].min() + _SAME)[0]])


def _is_above(body: Polyhedron, plane: int, centre: np.ndarray) -> bool:
    """Return whether the foot of a point's perpendicular on a plane lies within its polygon."""
    corners, normal = body.vertices[body.polygon(plane)], body.planes[plane, :3]
    along = np.roll(corners, -1, axis=0) - corners
    inwards = np.cross(normal, along / np.linalg.norm(along, axis=1, keepdims=True))
    return bool((np.einsum("ij,ij->i", inwards, centre - corners) > _SAME).all())


def _hull(vertices: np.ndarray) -> Polyhedron:
    from scipy.spatial import ConvexHull

    equations = ConvexHull(vertices).equations
    planes = np.column_stack([equations[:, :3], -equations[:, 3]])
    _, first = np.unique(np.round(planes / _SAME_PLANE), axis=0, return_index=True)
    return intersect(planes[np.sort(first)])


def _centre_of_mass(solid: MeshSolid) -> np.ndarray:
    """Return the middle of a mesh's volume, (3,), by Gauss's theorem."""
    a, b, c = solid.vertices[solid.triangles].transpose(1, 0, 2)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c))
    return np.asarray(volumes @ (a + b + c) / (4 * volumes.sum()))

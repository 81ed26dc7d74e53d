"""What stands beside a stone must not cut it: the check of meshes against stones in their places."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gemrender.errors import InputError
from gemrender.scene.closed import closed_surface
from gemrender.scene.convex import PlacedSolid
from gemrender.scene.inside import Inside, reaches_into, winding_number
from gemrender.scene.placing import Placed

__all__ = ["TOUCHING", "inside_of", "refuse_cutting"]

#: How deep a mesh may reach into a stone: rounding, of what touches [share of the stone's size].
TOUCHING = 1e-5
#: How far a vertex of a convex stone may lie beyond its planes [share of the stone's size].
_FLAT = 3e-6
#: Planes that are looked at together.
_TOGETHER = 64
#: More triangles are not looked at for a stone inside them: no ring has as many.
_MOST_AROUND = 400_000


def inside_of(placed: Placed) -> Inside:
    """Return the inside of a stone in its place."""
    points, planes = placed.points(), placed.planes()
    triangles = points[placed.mesh.faces]
    flat = planes[:, :3].any(axis=1)
    cylinder = None
    if not flat.all():
        cylinder = np.array([*placed.rotation[:, 2], *placed.shift, placed.scale])
    solid = PlacedSolid(planes=np.unique(planes[flat], axis=0), cylinder=cylinder)
    size = float(np.ptp(points, axis=0).max())
    convex = solid.holds(points, margin=_FLAT * size).all()
    return Inside(triangles=triangles, known=solid) if convex else Inside.of(triangles)


def refuse_cutting(
    triangles: np.ndarray,
    stones: Sequence[tuple[str, Inside]],
    *,
    key: str,
    value: object,
    may_hold: bool = True,
) -> None:
    """Refuse a mesh that reaches into a stone, or holds one inside.

    Parameters
    ----------
    triangles : (n, 3, 3) float64
        The mesh [scene unit].
    stones : sequence of (str, Inside)
        The stones' names, and the space that they take up.
    key, value
        What the error names.
    may_hold : bool
        Whether it could be a solid around a stone; of what was made around one by its outline it is known.

    Raises
    ------
    InputError
        It cuts a stone.
    """
    for name, inside in stones:
        if reaches_into(_not_beside(triangles, inside), inside, TOUCHING * inside.size):
            raise InputError(f"must not cut a stone; it reaches into {name}", key=key, value=value)
        if may_hold and len(triangles) <= _MOST_AROUND and _holds(triangles, inside.inner()):
            raise InputError(f"must not have a stone inside; {name} is in it", key=key, value=value)


def _holds(triangles: np.ndarray, point: np.ndarray) -> bool:
    """Return whether a point is in the space that a mesh encloses; never of an open one."""
    corners = triangles.reshape(-1, 3)
    if (point < corners.min(axis=0)).any() or (point > corners.max(axis=0)).any():
        return False
    try:
        closed = closed_surface(corners, np.arange(len(corners)).reshape(-1, 3)).triangles
    except InputError:
        return False
    return bool(winding_number(point[None], closed)[0] > 0.5)


def _not_beside(triangles: np.ndarray, inside: Inside) -> np.ndarray:
    """Return the triangles that are not wholly beyond one plane of a convex stone, or beside its girdle."""
    if not isinstance(inside.known, PlacedSolid):
        return triangles
    planes, cylinder = inside.known.planes, inside.known.cylinder
    for first in range(0, len(planes), _TOGETHER):
        some = planes[first : first + _TOGETHER]
        beyond = (triangles @ some[:, :3].T >= some[:, 3]).all(axis=1).any(axis=1)
        triangles = triangles[~beyond]
    if cylinder is not None and len(triangles):
        across = triangles - cylinder[3:6]
        across = across - (across @ cylinder[:3])[..., None] * cylinder[:3]
        out = across.mean(axis=1)
        out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), np.finfo(float).tiny)
        triangles = triangles[(np.einsum("nki,ni->nk", across, out) < cylinder[6]).any(axis=1)]
    return triangles

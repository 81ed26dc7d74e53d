"""What Mitsuba's shapes are in space: their triangles, and the solids of those that are stones."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.scene.closed import ClosedSurface, closed_surface
from gemrender.scene.convex import PlacedSolid
from gemrender.scene.inside import Ball, Inside
from gemrender.scene.mesh import mesh_solid

__all__ = ["FLAT", "StoneShape", "mesh_buffers", "name_of", "surface_points"]

#: Facing of a face whose own normal counts, not those of its vertices; -FLAT where it looks inwards.
FLAT = 2
#: Vertex normals that are farther from their face's smooth no surface but round off a stone's edges [cosine].
_SMOOTH = np.cos(np.radians(30.0))
#: A triangle that is not as high has no normal to speak of [share of the distance from the origin].
_NARROW = 1e-5
#: Vertex normals that differ by less are the same.
_SAME_NORMAL = 1e-3
#: Shapes that bound no solid, and how many points or corners stand for round ones.
_OPEN = ("Rectangle", "Disk", "Cylinder")
_AROUND, _ALONG = 64, 32
#: Triangles that are looked at together.
_AT_ONCE = 1 << 18
_INWARDS = "looks inwards; it is turned round"


class StoneShape:
    """A shape that is a stone.

    Parameters
    ----------
    shape : mi.Shape
        The shape.

    Attributes
    ----------
    name : str
        Its id, or its file's name.
    ptr : int
        Address of the shape.
    solid : PlacedSolid or None
        Its planes, where it is one of `placed_mesh`'s.
    facing : (f,) float32 or None
        For each face, what its normal is multiplied by to be the stone's outward one: 1 or -1 for that of the
        vertices, `FLAT` or -`FLAT` for that of the face. None where all are right as they are.
    low, high : (3,) float64
        Its box [scene unit].
    size : float
        What tolerances are shares of: its longest extent [scene unit].
    mended : str
        What is wrong and what is done about it, for the user; empty where nothing is.

    Raises
    ------
    InputError
        It bounds no solid.
    """

    def __init__(self, shape: Any) -> None:
        self.name, self.ptr = name_of(shape), shape.ptr
        self.solid: PlacedSolid | None = None
        self.facing: np.ndarray | None = None
        self.mended = ""
        self._surface: ClosedSurface | None = None
        box = shape.bbox()
        self.low, self.high = np.array(box.min, dtype=np.float64), np.array(box.max, dtype=np.float64)
        extent = float((self.high - self.low).max())
        # Rounding goes with the distance from the origin
        self.size = max(extent, 0.1 * float(np.abs([self.low, self.high]).max()))
        kind = shape.class_name()
        if kind in _OPEN:
            raise self._refused("must be closed: a mesh or a sphere, not a " + kind.lower())
        self._ball: Ball | None = None
        if kind == "Sphere":
            self._ball = Ball(centre=0.5 * (self.low + self.high), radius=0.5 * extent)
            if shape.has_flipped_normals():
                self.facing, self.mended = np.array([-1.0], dtype=np.float32), _INWARDS
            return
        if not shape.is_mesh():
            self.mended = f"is a {kind.lower()}; whether it is closed and apart from others is not checked"
            return
        positions, faces, normals = mesh_buffers(shape)
        try:
            self._surface = closed_surface(positions, faces)
        except InputError as error:
            raise self._refused(error.allowed) from error
        self.solid = mesh_solid(shape)
        normals = -normals if shape.has_flipped_normals() else normals
        wound = -self._surface.outward if shape.has_flipped_normals() else self._surface.outward
        self.facing, self.mended = _facing(positions, faces, normals, self._surface.outward, wound)

    def _refused(self, allowed: str) -> InputError:
        return InputError(allowed, key="stone", value=self.name)

    @functools.cached_property
    def insides(self) -> list[Inside]:
        """The space inside: of each of its bodies; none where it is not known."""
        if self._ball is not None:
            return [Inside(triangles=_sphere(self._ball), known=self._ball)]
        if self._surface is None:
            return []
        if self.solid is not None:
            return [Inside(triangles=self._surface.triangles, known=self.solid)]
        return [Inside.of(triangles) for triangles in self.bodies]

    @property
    def bodies(self) -> list[np.ndarray]:
        """The triangles (n, 3, 3) of each body of a mesh."""
        if self._surface is None:
            return []
        triangles, body = self._surface.triangles, self._surface.body
        return [triangles[body == k] for k in range(int(body.max()) + 1)]


def name_of(shape: Any) -> str:
    """Return how to tell a shape to the user: its id, the name of its file, or its kind."""
    if shape.id():
        return str(shape.id())
    for line in str(shape).splitlines():
        key, _, value = line.partition(" = ")
        if key.strip() == "name":
            return value.strip().rstrip(",").strip('"')
    return f"a {shape.class_name().lower()} without an id"


def mesh_buffers(shape: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return vertices (v, 3), faces (f, 3) and vertex normals (v, 3), or (0, 3) where it has none."""
    normals = np.array(shape.vertex_normals_buffer()) if shape.has_vertex_normals() else np.zeros(0)
    return (
        np.array(shape.vertex_positions_buffer(), dtype=np.float64).reshape(-1, 3),
        np.array(shape.faces_buffer(), dtype=np.int64).reshape(-1, 3),
        normals.astype(np.float64).reshape(-1, 3),
    )


def surface_points(shape: Any, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return triangles (n, 3, 3) that lie on a shape and meet a box; of round shapes points thrice.

    None of shapes that are neither meshes nor rectangles, disks, spheres or cylinders.
    """
    box = shape.bbox()
    if (np.array(box.min) > high).any() or (np.array(box.max) < low).any():
        return np.zeros((0, 3, 3))
    if not shape.is_mesh():
        triangles = _round_points(shape)
        return np.asarray(triangles[_meeting(triangles, low, high)])
    positions, faces, _ = mesh_buffers(shape)
    found = [np.zeros((0, 3, 3))]
    for first in range(0, len(faces), _AT_ONCE):
        triangles = positions[faces[first : first + _AT_ONCE]]
        found.append(triangles[_meeting(triangles, low, high)])
    return np.concatenate(found)


def _meeting(triangles: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return which triangles' boxes meet a box, (n,) bool."""
    return np.asarray(((triangles.max(axis=1) >= low) & (triangles.min(axis=1) <= high)).all(axis=1))


def _round_points(shape: Any) -> np.ndarray:
    """Return what `surface_points` does of a shape that is no mesh, all of it."""
    kind = shape.class_name()
    turn = np.linspace(0, 2 * np.pi, _AROUND, endpoint=False)
    x, y = np.cos(turn), np.sin(turn)
    if kind == "Sphere":
        low, high = np.array(shape.bbox().min), np.array(shape.bbox().max)
        triangles = _sphere(Ball(centre=0.5 * (low + high), radius=0.5 * float((high - low).max())))
        return np.repeat(triangles.reshape(-1, 1, 3), 3, axis=1)
    if kind == "Disk":
        to_world = _to_world(shape)
        rim = np.stack([x, y, 0 * x], axis=1)
        fan = np.stack([np.zeros_like(rim), rim, np.roll(rim, -1, axis=0)], axis=1)
        return np.asarray(fan @ to_world[:3, :3].T + to_world[:3, 3])
    if kind == "Cylinder":
        to_world = _to_world(shape)
        z = np.linspace(0, 1, _ALONG)
        wall = np.stack([np.tile(x, _ALONG), np.tile(y, _ALONG), np.repeat(z, _AROUND)], axis=1)
        return np.repeat((wall @ to_world[:3, :3].T + to_world[:3, 3])[:, None], 3, axis=1)
    return np.zeros((0, 3, 3))


def _to_world(shape: Any) -> np.ndarray:
    import mitsuba as mi

    return np.array(mi.traverse(shape)["to_world"].matrix, dtype=np.float64).reshape(4, 4)


def _sphere(ball: Ball) -> np.ndarray:
    """Return triangles (n, 3, 3) with their corners on a sphere, anticlockwise seen from outside."""
    polar, turn = np.linspace(0, np.pi, _ALONG + 1), np.linspace(0, 2 * np.pi, _AROUND + 1)
    grid = np.stack(
        [
            np.outer(np.sin(polar), np.cos(turn)),
            np.outer(np.sin(polar), np.sin(turn)),
            np.outer(np.cos(polar), np.ones_like(turn)),
        ],
        axis=2,
    )
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    triangles = np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])
    return np.asarray(ball.centre + ball.radius * triangles)


# ---- Which way faces look ------------------------------------------------------------------------------


def _facing(
    positions: np.ndarray, faces: np.ndarray, normals: np.ndarray, outward: np.ndarray, wound: np.ndarray
) -> tuple[np.ndarray | None, str]:
    """Return what `StoneShape` says of a mesh's faces, and what was wrong.

    Parameters
    ----------
    positions, faces
        The mesh.
    normals : (v, 3) float64
        Vertex normals as Mitsuba takes them, or none.
    outward, wound : (f,) int8
        Whether the winding is that of a face that looks out of the solid, and whether Mitsuba's normal of the
        face looks out; 0 for faces without an area.
    """
    corners = positions[faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    longest = np.sqrt(((np.roll(corners, -1, axis=1) - corners) ** 2).sum(axis=2).max(axis=1))
    length = np.linalg.norm(area, axis=1)
    # The normals of slivers are noise
    wide = length > _NARROW * float(np.abs(positions).max()) * longest
    wide &= outward != 0
    if not len(normals):
        return _signed(wound, 1)
    of_solid = area / np.where(length > 0, length, 1)[:, None] * outward[:, None]
    at_corners = normals[faces]
    norm = np.linalg.norm(at_corners, axis=2)
    cos = np.einsum("fki,fi->fk", at_corners, of_solid) / np.where(norm > 0, norm, 1)
    side = np.sign(cos[:, 0]).astype(np.int8)
    if (np.abs(cos[wide]) >= _SMOOTH).all() and (np.sign(cos[wide]) == side[wide, None]).all():
        return _signed(np.where(wide, side, 0), 1)
    facing, mended = _signed(wound, FLAT)
    if not mended and not _made_up(normals, positions, faces):
        mended = "has vertex normals that are not those of its faces; its facets are taken as flat"
    return facing, mended


def _signed(side: np.ndarray, factor: int) -> tuple[np.ndarray | None, str]:
    """Return facing from the side that faces look to, (f,), 1, -1, or 0 for any; and what is wrong."""
    inwards, known = int((side < 0).sum()), int((side != 0).sum())
    if not inwards and factor == 1:
        return None, ""
    mended = ""
    if inwards:
        some = f"has {inwards} faces of {known} that look inwards; they are turned round"
        mended = _INWARDS if inwards == known else some
    facing = np.where(side == 0, -1 if inwards == known else 1, side)
    return (factor * facing).astype(np.float32), mended


def _made_up(normals: np.ndarray, positions: np.ndarray, faces: np.ndarray) -> bool:
    """Return whether vertex normals are those that Mitsuba makes for a file without.

    The mean of the faces' normals weighted by their angles: Thuermer & Wuethrich, "Computing vertex normals
    from polygonal facets", J. Graphics Tools 3 (1998).
    """
    corners = positions[faces]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    unit = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), np.finfo(float).tiny)
    total = np.zeros_like(positions)
    for k in range(3):
        one, other = (corners[:, (k + j) % 3] - corners[:, k] for j in (1, 2))
        norm = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
        cos = np.einsum("ij,ij->i", one, other) / np.maximum(norm, np.finfo(float).tiny)
        np.add.at(total, faces[:, k], np.arccos(np.clip(cos, -1, 1))[:, None] * unit)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    used = np.unique(faces)
    used = used[length[used, 0] > _SAME_NORMAL]
    made = total[used] / length[used]
    off = np.minimum(
        np.linalg.norm(made - normals[used], axis=1), np.linalg.norm(made + normals[used], axis=1)
    )
    return bool((off < _SAME_NORMAL).all())

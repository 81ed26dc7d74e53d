"""Stones in their places: poses, rows of stones, and where the camera must stand to see them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from gemrender.errors import InputError
from gemrender.scene.resting import resting_plane
from gemrender.stone import Stone, StoneMesh, tessellate

if TYPE_CHECKING:
    from gemrender.scene.settings import MadeSetting
    from gemrender.scene.setup import Camera

__all__ = ["Placed", "frame", "place", "towards"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Placed:
    """A stone's mesh, and the similarity that brings it to its place.

    Attributes
    ----------
    name : str
        The stone's name.
    mesh : StoneMesh
        In the stone's own frame.
    rotation : (3, 3) float64
    scale : float
    shift : (3,) float64
        A point p of the stone's frame comes to shift + scale * rotation p [scene unit].
    beside : (n, 3) float64 or None
        What a picture shows with the stone, such as its setting, in the stone's frame.
    """

    name: str
    mesh: StoneMesh
    rotation: np.ndarray
    scale: float
    shift: np.ndarray
    beside: np.ndarray | None = None

    def points(self) -> np.ndarray:
        """Return the vertices in their place, (v, 3) [scene unit]."""
        return np.asarray(self.scale * self.mesh.vertices @ self.rotation.T + self.shift)

    def shown_points(self) -> np.ndarray:
        """Return the vertices with what is beside them, in their place, (n, 3) [scene unit]."""
        if self.beside is None:
            return self.points()
        beside = self.scale * self.beside @ self.rotation.T + self.shift
        return np.concatenate([self.points(), beside])

    def growth(self) -> float:
        """Return how many times as large the stone is with what is beside it."""
        whole, alone = (0.5 * float(np.ptp(p, axis=0).max()) for p in (self.shown_points(), self.points()))
        return max(1.0, whole / alone)

    def split_points(self) -> np.ndarray:
        """Return the vertices of `StoneMesh.split` in their place, (w, 3) [scene unit]."""
        return np.asarray(self.scale * self.mesh.split()[0] @ self.rotation.T + self.shift)

    def planes(self) -> np.ndarray:
        """Return the plane of each face in its place, (f, 4): outward unit normal, and offset [scene unit].

        On a round girdle the normal is 0 and the offset the radius.
        """
        normals = self.mesh.face_normals @ self.rotation.T
        return np.column_stack([normals, self.scale * self.mesh.face_offsets + normals @ self.shift])

    def turned(self, turn_deg: float) -> Placed:
        """Return it turned about the vertical through the origin, anticlockwise seen from above [deg]."""
        return self.rotated(_about_z(np.radians(turn_deg)), about=np.zeros(3))

    def rotated(self, rotation: np.ndarray, *, about: np.ndarray) -> Placed:
        """Return it after a rotation (3, 3) about a point (3,) [scene unit]."""
        shift = about + rotation @ (self.shift - about)
        return replace(self, rotation=rotation @ self.rotation, shift=shift)

    def shifted(self, by: np.ndarray) -> Placed:
        """Return it moved by a vector (3,) [scene unit]."""
        return replace(self, shift=self.shift + by)


def place(
    stones: list[Stone],
    *,
    pose: str,
    facing_deg: float,
    gap: float,
    azimuth_deg: float,
    sizes: list[float],
    settings: list[MadeSetting] | None = None,
) -> list[Placed]:
    """Lay stones in a row that a camera sees from left to right, on the plane z = 0 about the origin.

    Parameters
    ----------
    stones : list of Stone
        The stones.
    pose : {"table-up", "lying", "table-down"}
        How they rest.
    facing_deg : float
        Azimuth that the table of a lying stone leans to, from the camera's [deg].
    gap : float
        Between neighbours [scene unit].
    azimuth_deg : float
        Azimuth of the camera [deg].
    sizes : list of float
        The unit of each, such as the girdle radius [scene unit].
    settings : list of MadeSetting, optional
        What each is held by, table up, and what then stands on the plane.
    """
    across = _about_z(np.radians(azimuth_deg + 90)) @ np.array([1.0, 0.0, 0.0])
    placed, edge = [], 0.0
    held_by: list[MadeSetting | None] = [*settings] if settings else [None] * len(stones)
    for stone, size, setting in zip(stones, sizes, held_by, strict=True):
        mesh = tessellate(stone)
        held = mesh.vertices
        if setting is None:
            rotation = _rotation(stone, pose, azimuth_deg + facing_deg)
        else:
            rotation = _about_z(np.radians(azimuth_deg + 90 + setting.turn_deg))
            held = np.concatenate([held, setting.framed])
        points = size * held @ rotation.T
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        along = points @ across
        low = points[:, 2].min() if setting is None else size * setting.lowest
        shift = -np.array([middle[0], middle[1], low])
        # Side by side along the row: from `edge` on, whatever the stone's outline there
        shift += (edge - along.min() - shift @ across) * across
        edge += float(np.ptp(along)) + gap
        beside = None if setting is None else setting.framed
        placed.append(
            Placed(name=stone.name, mesh=mesh, rotation=rotation, scale=size, shift=shift, beside=beside)
        )
    back = 0.5 * (edge - gap) * across
    return [replace(p, shift=p.shift - back) for p in placed]


def towards(elevation_deg: float, azimuth_deg: float) -> np.ndarray:
    """Return the unit vector to an elevation above the horizon and an azimuth, (3,)."""
    e, a = np.radians(elevation_deg), np.radians(azimuth_deg)
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def frame(
    camera: Camera, stones: Iterable[Placed], target: np.ndarray, aspect: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Return where the camera stands, its right and up, and half the width that it sees.

    Parameters
    ----------
    camera : Camera
        The camera.
    stones : iterable of Placed
        What it must see; those that move in all their places.
    target : (3,) float64
        What it looks at.
    aspect : float
        Width of the picture by its height.

    Returns
    -------
    (origin, right, up, half_width)
        half_width [scene unit] at the target's distance, with the camera's margin.

    Raises
    ------
    InputError
        A stone is beside or behind the camera.
    """
    back = towards(camera.elevation, camera.azimuth)
    right = _about_z(np.radians(camera.azimuth + 90)) @ np.array([1.0, 0.0, 0.0])
    up = np.cross(back, right)
    origin = target + camera.distance * back
    half = 0.0
    for stone in stones:
        to = stone.shown_points() - origin
        depth = -to @ back
        if depth.min() <= 0.02 * camera.distance:
            raise InputError(
                f"is too near to see {stone.name} from outside; its front is "
                f"{camera.distance - depth.min():.3g} girdle radii from the middle",
                key="camera.distance",
                value=camera.distance,
            )
        magnified = 1.0 if camera.type == "orthographic" else camera.distance / depth
        x, y = np.abs(to @ right) * magnified, np.abs(to @ up) * magnified
        half = max(half, float(x.max()), float(y.max()) * aspect)
    return origin, right, up, half * camera.margin


def _rotation(stone: Stone, pose: str, azimuth_deg: float) -> np.ndarray:
    """Return the rotation (3, 3) that brings a stone into a pose, its table leaning to an azimuth."""
    if pose == "table-up":
        return np.eye(3)
    if pose == "table-down":
        return np.diag([1.0, -1.0, -1.0])
    tilt = _onto(resting_plane(stone), np.array([0.0, 0.0, -1.0]))
    table = tilt @ np.array([0.0, 0.0, 1.0])
    return np.asarray(_about_z(np.radians(azimuth_deg) - np.arctan2(table[1], table[0])) @ tilt)


def _onto(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the least rotation (3, 3) that turns the unit vector a to b (not to -a)."""
    axis, cos = np.cross(a, b), float(a @ b)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1 + cos))


def _about_z(angle: float) -> np.ndarray:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])

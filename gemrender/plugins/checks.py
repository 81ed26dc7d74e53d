"""What `gem_path` takes for granted of a scene, checked once: stones closed and apart, all else outside."""

from __future__ import annotations

import sys
import warnings
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from gemrender.errors import GemrenderWarning, InputError
from gemrender.scene.contact import faces_touch
from gemrender.scene.convex import fits
from gemrender.scene.inside import overlap, reaches_into
from gemrender.scene.mesh import FACET_ATTRIBUTE, carried_planes, mesh_solid
from gemrender.scene.shapes import StoneShape, mesh_buffers, name_of, surface_points

__all__ = ["RAY_OFFSET", "FacetCheck", "SceneCheck", "is_stone"]

#: How far a ray starts from the facet it leaves [radius of the largest stone]: more than single precision's
#: rounding, far less than a facet. Mitsuba's own offset loses one path in a few thousand at edges.
RAY_OFFSET = 2e-6
#: How far a stone, a light or a camera may reach into a stone: rounding, of what touches [share of its size].
_TOUCHING = 1e-5
#: How far other things may, as a ground that a stone sinks into, before it is said [share of its size].
_SUNK = 1e-3
#: How many of them are named.
_LISTED = 5
#: How far a vertex of a round girdle may be from its cylinder [girdle radius]: on the chords it is cut into.
_BESIDE = 1e-5
#: A camera's rays are looked at in a grid of so many by so many.
_RAYS = 9
#: How many cameras are remembered.
_CAMERAS = 16


def is_stone(shape: mi.Shape) -> bool:
    """Return whether a shape's surface is a `gem_dielectric`."""
    return type(shape.bsdf()).__name__ == "GemDielectric"


class SceneCheck:
    """Checks a scene, and remembers that it has: again only when something has changed.

    It holds arrays of the scene but not the scene itself, so that scenes go when their users drop them.
    """

    def __init__(self) -> None:
        self._seen: list[Any] | None = None
        self._cameras: list[Any] = []
        self._stones: list[StoneShape] = []

    def stones(self, scene: mi.Scene) -> list[StoneShape]:
        """Return the stones among the shapes, in order.

        What can be mended is, with a `GemrenderWarning`.

        Raises
        ------
        InputError
            A stone is open or otherwise no solid, stones overlap, or a light is inside one.
        """
        shapes = scene.shapes()
        state = [_state(shape) for shape in shapes] + [_state_of_light(e) for e in scene.emitters()]
        if self._seen is None or not _same(self._seen, state):
            self._seen, self._cameras = None, []
            self._stones = _check(scene, shapes)
            self._seen = state
        return self._stones

    def camera(self, scene: mi.Scene, sensor: mi.Sensor) -> None:
        """Check that a camera is outside all stones.

        Raises
        ------
        InputError
            It is not, or what `stones` refuses.
        """
        stones = self.stones(scene)
        matrix = np.array(sensor.world_transform().matrix)
        state = [sensor.ptr, str(matrix), str(sensor)]
        if not stones or state in self._cameras:
            return
        seen = _starts(sensor)
        for stone in stones:
            if _reaches(seen, stone, _TOUCHING):
                raise InputError("must be outside all stones", key="camera", value=f"inside {stone.name}")
        self._cameras = [*self._cameras[-_CAMERAS:], state]


class FacetCheck:
    """Checks that stones have facets and planes, as `gem_primary` needs them, and remembers that it has."""

    def __init__(self) -> None:
        self._seen: list[Any] | None = None
        self._hides = False

    def hides(self, scene: mi.Scene) -> bool:
        """Return whether something can hide the light from a ray that has left the stone.

        That is a second shape, or the stone itself where it is not convex.

        Raises
        ------
        InputError
            A shape with a dielectric surface has no planes, or such that do not fit, or no shape has any.
        """
        shapes = scene.shapes()
        state = [_state(shape) for shape in shapes]
        if self._seen is None or not _same(self._seen, state):
            self._seen = None
            self._hides = _require_facets(shapes)
            self._seen = state
        return self._hides


def _require_facets(shapes: list[mi.Shape]) -> bool:
    lacking, carrying = [], []
    for shape in shapes:
        if shape.is_emitter():
            continue
        planes = carried_planes(shape)
        if planes is None or not np.all(shape.has_attribute(FACET_ATTRIBUTE)):
            lacking.append(shape)
            continue
        carrying.append(shape)
        positions, faces, _ = mesh_buffers(shape)
        if not _is_in_place(positions, faces, planes):
            raise InputError(
                "must stand where its planes do; it has been moved since they were written",
                key="stone",
                value=name_of(shape),
            )
    stones = [s for s in lacking if mi.has_flag(s.bsdf().flags(), mi.BSDFFlags.DeltaTransmission)]
    if stones or (lacking and not carrying):
        raise InputError(
            "must be a mesh with facets and their planes, as gemrender scene writes it",
            key="stone",
            value=name_of((stones or lacking)[0]),
        )
    return len(shapes) > 1 or any(mesh_solid(shape) is None for shape in carrying)


def _is_in_place(positions: np.ndarray, faces: np.ndarray, planes: np.ndarray) -> bool:
    """Return whether a mesh fits its planes, and its girdle the upright cylinder about the z axis."""
    wall = ~planes[:, :3].any(axis=1)
    beside = np.linalg.norm(positions[faces[wall], :2], axis=2) - planes[wall, 3:]
    return fits(positions, faces, planes) and bool((np.abs(beside) <= _BESIDE).all())


# ---- What is compared ----------------------------------------------------------------------------------


def _state(shape: mi.Shape) -> list[Any]:
    """Return what tells whether a shape has changed; arrays themselves, so that their numbers stay taken."""
    box = shape.bbox()
    state: list[Any] = [shape.ptr, shape.bsdf().ptr, str(box)]
    if shape.is_mesh():
        state += [shape.vertex_positions_buffer(), shape.vertex_normals_buffer(), shape.faces_buffer()]
    return state


def _state_of_light(emitter: mi.Emitter) -> list[Any]:
    return [emitter.ptr, str(emitter.bbox()), str(emitter.world_transform().matrix)]


def _same(one: list[Any], other: list[Any]) -> bool:
    return len(one) == len(other) and all(map(_same_value, one, other))


def _same_value(one: Any, other: Any) -> bool:
    if isinstance(one, list):
        return _same(one, other)
    if isinstance(one, int | str):
        return bool(one == other)
    return bool(one.index == other.index)  # Dr.Jit arrays: one that is written to gets a new number


# ---- The checks ----------------------------------------------------------------------------------------


def _check(scene: mi.Scene, shapes: list[mi.Shape]) -> list[StoneShape]:
    _refuse_grouped(scene, shapes)
    stones = []
    for shape in shapes:
        if is_stone(shape):
            stones.append(StoneShape(shape))
            if shape.is_emitter():
                raise InputError("must not be a light as well", key="stone", value=stones[-1].name)
    if not stones:
        return stones
    for k, stone in enumerate(stones):
        for other in stones[:k]:
            if _overlap(stone, other):
                raise InputError("must not overlap", key="stones", value=f"{stone.name} in {other.name}")
    _check_lights(scene, shapes, stones)
    for stone in stones:
        if stone.mended:
            _say(f"stone {stone.name} {stone.mended}")
    _check_contact(stones)
    _check_others(shapes, stones)
    return stones


def _refuse_grouped(scene: mi.Scene, shapes: list[mi.Shape]) -> None:
    """Refuse stones in shape groups: a ray inside an instance does not know which one it is in."""
    if not any(shape.class_name() == "Instance" for shape in shapes):
        return
    for node in mi.traverse(scene).hierarchy:
        if isinstance(node, mi.Shape) and is_stone(node) and node not in shapes:
            raise InputError(
                "must stand by itself, not in a shape group with instances", key="stone", value=name_of(node)
            )


def _check_lights(scene: mi.Scene, shapes: list[mi.Shape], stones: list[StoneShape]) -> None:
    unseen = []
    on_shape = {shape.emitter().ptr: shape for shape in shapes if shape.is_emitter()}
    for emitter in scene.emitters():
        shape = on_shape.get(emitter.ptr)
        name = name_of(shape) if shape is not None else emitter.id() or emitter.class_name()
        flags = emitter.flags()
        if mi.has_flag(flags, mi.EmitterFlags.DeltaPosition | mi.EmitterFlags.DeltaDirection):
            unseen.append(name)
        if shape is not None:
            places = surface_points(shape, *_box(stones))
        elif mi.has_flag(flags, mi.EmitterFlags.DeltaPosition):
            places = np.tile(_place(emitter), (1, 3, 1))
        else:
            continue
        for stone in stones:
            if _reaches(places, stone, _TOUCHING):
                raise InputError("must be outside all stones", key="light", value=f"{name} in {stone.name}")
    if unseen:
        _say(
            f"{', '.join(unseen)}: point and directional lights light plain surfaces, but are not seen in or "
            "through stones; give them a size"
        )


def _place(emitter: mi.Emitter) -> np.ndarray:
    """Return where a light without a size is, (3,)."""
    box = emitter.bbox()  # of a point light; a projector has none, of which the transform is the place
    place = box.min if box.valid() else emitter.world_transform().translation()
    return np.array(place, dtype=np.float64).reshape(3)


def _check_contact(stones: list[StoneShape]) -> None:
    """Say which stones lie face to face: a ray that has left one starts behind the other's surface."""
    gap = RAY_OFFSET * max(stone.size for stone in stones)
    bodies = [(stone.name, triangles) for stone in stones for triangles in stone.bodies]
    pairs = []
    for k, (name, triangles) in enumerate(bodies):
        for other_name, other in bodies[:k]:
            if faces_touch(triangles, other, gap):
                pairs.append(name if name == other_name else f"{other_name} and {name}")
    if pairs:
        _say(
            f"stones lie face to face, and light passes between them as through no surface; leave "
            f"{5 * gap:.1g} or more between: {_some(pairs)}"
        )


def _some(names: list[str]) -> str:
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    return ", ".join(names[:_LISTED]) + more


def _check_others(shapes: list[mi.Shape], stones: list[StoneShape]) -> None:
    """Say which other things reach into stones."""
    within = []
    for shape in shapes:
        if not is_stone(shape) and not shape.is_emitter():
            places = surface_points(shape, *_box(stones))
            within += [f"{name_of(shape)} in {s.name}" for s in stones if _reaches(places, s, _SUNK)]
    if within:
        _say(f"other things reach into stones, and are not seen inside: {_some(within)}")
    if any(shape.is_medium_transition() for shape in shapes):
        _say("gem_path does not follow light in media; a stone absorbs by its material")


def _box(stones: list[StoneShape]) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest corner of the box around all stones."""
    return np.min([s.low for s in stones], axis=0), np.max([s.high for s in stones], axis=0)


def _reaches(places: np.ndarray, stone: StoneShape, share: float) -> bool:
    """Return whether triangles (n, 3, 3) reach into a stone, by more than a share of its size."""
    if not len(places) or (places.min(axis=(0, 1)) > stone.high).any():
        return False
    if (places.max(axis=(0, 1)) < stone.low).any():
        return False
    return any(reaches_into(places, inside, share * stone.size) for inside in stone.insides)


def _overlap(one: StoneShape, other: StoneShape) -> bool:
    """Return whether two stones have space in common, by more than what touches has."""
    if not (np.minimum(one.high, other.high) > np.maximum(one.low, other.low)).all():
        return False
    depth = _TOUCHING * min(one.size, other.size)
    return any(overlap(a, b, depth) for a in one.insides for b in other.insides)


def _starts(sensor: mi.Sensor) -> np.ndarray:
    """Return where a sensor's rays start, as triangles (n, 3, 3)."""
    share = dr.linspace(mi.Float, 0, 1, _RAYS)
    x, y = dr.meshgrid(share, share)
    ray, _ = sensor.sample_ray(mi.Float(0), mi.Float(0.5), mi.Point2f(x, y), mi.Point2f(0.5))
    points = np.zeros((3, _RAYS * _RAYS)) + np.array(ray.o, dtype=np.float64)
    grid = points.T.reshape(_RAYS, _RAYS, 3)
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    return np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, b, c), (a, c, d))])


def _say(message: str) -> None:
    """Warn as from the user's own line, each time: Python would tell the same of a second scene no more."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] in (
        "gemrender",
        "mitsuba",
        "drjit",
    ):
        frame = frame.f_back
    warnings.warn_explicit(message, GemrenderWarning, frame.f_code.co_filename, frame.f_lineno)

"""Scenes for pictures: stones in a set-up, as Mitsuba dictionaries."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.optics import Material
from gemrender.scene.beside import beside
from gemrender.scene.lighting import lights, reflectance, sky
from gemrender.scene.mesh import placed_mesh, sweep_mesh, tube_mesh
from gemrender.scene.moves import Move
from gemrender.scene.placing import Placed, frame, place, towards
from gemrender.scene.settings import make_setting
from gemrender.scene.setup import Light, Setup
from gemrender.scene.surfaces import GROUND
from gemrender.stone import ConvexSolid, Stone
from gemrender.stone.solid import with_chords

__all__ = ["MOST_PIXELS", "Gem", "PhotorealScene", "check_size", "photoreal_scene", "title_of"]

#: How many times as large set-ups may be made, that a row of stones has room.
_GROWN = tuple(1.25**k for k in range(12))
#: Longest side of a picture [pixels].
MOST_PIXELS = 16384
#: Half a width of grounds [girdle radius]: their edge is out of sight.
_WIDE = 60.0
#: Level facets of a round girdle that is faceted, as brilliants have 64 or more.
GIRDLE_FACETS = 64
#: How far below the stones the ground is for Mitsuba's own plugins [girdle radius]: level with a facet that
#: lies on it, it would take half of the light that is reflected there, in the stone. `gem_path` knows better.
_STOCK_GAP = 1e-4
#: How much wider than its stone a cup is.
_LOOSE = 1.0005


@dataclass(frozen=True, slots=True, kw_only=True)
class Gem:
    """A stone with what it is made of.

    Attributes
    ----------
    stone : Stone
        Its shape.
    material : Material
        Its material.
    material_name : str or float
        What the material is loaded by: a name, a file or an index.
    diameter_mm : float
        Girdle diameter, of stones that are not round the length of the outline's longer side [mm].
    """

    stone: Stone
    material: Material
    material_name: str | float
    diameter_mm: float


def title_of(gems: Sequence[Gem]) -> str:
    """Return what a picture of stones is called: the stones and their materials."""
    return ", ".join(f"{gem.stone.name} ({gem.material.name})" for gem in gems)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PhotorealScene:
    """A scene in parts: all that is plain, and the stones.

    Attributes
    ----------
    plain : dict
        The scene for `mi.load_dict`, without the stones.
    stones : tuple of Placed
        The stones in their places.
    surfaces : tuple of dict
        Surface of each.
    built : dict of str to (callable, dict)
        Other meshes by their names: what builds each of a surface and a name, and its surface.
    """

    plain: dict[str, Any]
    stones: tuple[Placed, ...]
    surfaces: tuple[dict[str, Any], ...]
    built: dict[str, tuple[Callable[..., Any], dict[str, Any]]]

    def meshes(self, *, with_surface: bool = True) -> dict[str, Any]:
        """Build the meshes for the active variant, by their names in the scene."""
        out = {
            f"stone_{k}": placed_mesh(placed, surface if with_surface else None, f"stone_{k}")
            for k, (placed, surface) in enumerate(zip(self.stones, self.surfaces, strict=True), start=1)
        }
        for name, (build, surface) in self.built.items():
            out[name] = build(bsdf=surface if with_surface else None, name=name)
        return out

    def mesh_surfaces(self) -> dict[str, dict[str, Any]]:
        """Return the surfaces of the meshes, by their names in the scene."""
        out = {f"stone_{k}": surface for k, surface in enumerate(self.surfaces, start=1)}
        return out | {name: surface for name, (_, surface) in self.built.items()}

    def to_dict(self) -> dict[str, Any]:
        """Return the scene for `mi.load_dict`, with meshes of the active variant."""
        return {**self.plain, **self.meshes()}


def photoreal_scene(
    gems: Sequence[Gem],
    setup: Setup,
    *,
    width: int,
    height: int,
    dispersion: bool = True,
    birefringence: bool = True,
    stock: bool = False,
    turn_deg: float = 0.0,
    move: Move | None = None,
    share: float = 0.0,
    samples: int = 64,
) -> PhotorealScene:
    """Return the scene of stones in a set-up.

    Parameters
    ----------
    gems : sequence of Gem
        The stones, from left to right. A scene unit is that of the first: its girdle radius, or half the
        longer side of its outline.
    setup : Setup
        What stands around them.
    width, height : int
        Size of the picture [pixels].
    dispersion : bool
        Whether the index depends on the wavelength.
    birefringence : bool
        Whether birefringent stones split light; if not, they have their ordinary index.
    stock : bool
        Whether to use Mitsuba's own plugins only: `path` and `dielectric`, without dispersion and
        absorption, colours as RGB.
    turn_deg : float
        Turn of the stones about the vertical [deg].
    move : Move, optional
        How the stones move in a film; the camera leaves room for all of it.
    share : float
        Share of the film that is over, 0 to 1.
    samples : int
        Samples a pixel where Mitsuba renders the scene.

    Raises
    ------
    InputError
        A size that no picture has, a camera too near, a mesh that cuts a stone, or a move that a cup does not
        allow.
    """
    check_size(width, height)
    if setup.girdle == "faceted":
        gems = [replace(gem, stone=_faceted(gem.stone)) for gem in gems]
    first_mm = gems[0].diameter_mm
    settings = None
    if setup.setting.type != "none":
        settings = [make_setting(g.stone, setup.setting.type, radius_mm=0.5 * g.diameter_mm) for g in gems]
    placed = place(
        [gem.stone for gem in gems],
        pose=setup.pose,
        facing_deg=setup.facing,
        gap=setup.gap,
        azimuth_deg=setup.camera.azimuth,
        sizes=[gem.diameter_mm / first_mm for gem in gems],
        settings=settings,
    )
    if settings is not None:
        setup = setup.grown(max(p.growth() for p in placed))
    heights = np.concatenate([p.shown_points()[:, 2] for p in placed])
    target = np.array([0.0, 0.0, 0.5 * (heights.min() + heights.max())])
    stones = [p.turned(turn_deg) for p in placed] if turn_deg else placed
    seen = placed
    if move is not None:
        move.check_ground(setup.ground.type)
        from_camera, on_ground = setup.camera.azimuth, setup.ground.type != "none"
        every = move.all_placed(stones, azimuth_deg=from_camera, on_ground=on_ground)
        seen = [stone for places in every for stone in places]
        stones = move.placed(stones, share, azimuth_deg=from_camera, on_ground=on_ground)
    points = np.concatenate([p.shown_points() for p in seen])
    reach = float(np.hypot(*points[:, :2].T).max())
    if len(gems) > 1:
        setup = _with_room(setup, target, reach, float(points[:, 2].max()))
    try:
        _check_apart(setup, target, reach, float(points[:, 2].max()))
        view = _sensor(setup, seen, target, width, height, samples)
    except InputError as error:
        raise error.at(setup.source or setup.name) from error
    scene: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path" if stock else "gem_path", "max_depth": -1},
        "sensor": view,
    }
    if stock:
        scene["integrator"]["rr_depth"] = 32
    else:
        _, right, up, _ = frame(setup.camera, seen, target, width / height)
        scene["integrator"] |= setup.filters.axes(right, up)
    scene |= lights(setup, target, stock)
    scene |= sky(setup, target, stock)
    built: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {}
    wide = _WIDE if settings is None else max(_WIDE, 4 * setup.camera.distance)
    paper = {"type": "diffuse", "reflectance": reflectance(setup.ground.reflectance, stock)}
    gap = _STOCK_GAP if stock else 0.0
    if setup.ground.type == "plane":
        scene["ground"] = {"type": "disk", "to_world": _lowered(gap) @ _scaled(wide), "bsdf": paper}
    elif setup.ground.type == "sweep":
        # Towards the wall that stands behind the stones, as the camera sees them
        wall = max(setup.ground.distance, 2.5 * reach)  # the bend begins beyond the stones
        build = partial(
            sweep_mesh,
            half_width=wide,
            wall=wall,
            bend=0.6 * wall,
            azimuth_deg=setup.camera.azimuth + 180,
            level=-gap,
        )
        built["ground"] = (build, {"type": "twosided", "bsdf": paper})
    elif setup.ground.type == "cup":
        for k, (gem, stone) in enumerate(zip(gems, stones, strict=True), start=1):
            if gem.stone.is_round:
                scene[f"cup_{k}"] = _cup(stone, paper)
            else:
                built[f"cup_{k}"] = (_outline_cup(stone), {"type": "twosided", "bsdf": paper})
    built |= beside(setup, stones, settings, radius_mm=0.5 * first_mm, stock=stock)
    surfaces = tuple(
        _surface(gem, first_mm, dispersion, stock)
        | ({} if stock else _crystal(gem, stone, birefringence))
        | ({} if stock or setup.girdle != "bruted" else _bruted(stone))
        for gem, stone in zip(gems, stones, strict=True)
    )
    return PhotorealScene(
        plain=scene,
        stones=tuple(stones),
        surfaces=surfaces,
        built=built,
    )


def check_size(width: int, height: int) -> None:
    """Check the size of a picture [pixels].

    Raises
    ------
    InputError
        A size that no picture has.
    """
    for key, side in (("width", width), ("height", height)):
        if not 1 <= side <= MOST_PIXELS:
            raise InputError(f"must be from 1 to {MOST_PIXELS} [pixels]", key=f"size: {key}", value=side)


# ---- Parts ---------------------------------------------------------------------------------------------


def _check_apart(setup: Setup, target: np.ndarray, reach: float, height: float) -> None:
    """Check that the camera is above the ground, and no light where stones are or come in a turn."""
    camera = target + setup.camera.distance * towards(setup.camera.elevation, setup.camera.azimuth)
    if setup.ground.type in ("plane", "sweep") and camera[2] <= 0:
        raise InputError(
            "must be such that the camera is above the ground",
            key="camera.elevation",
            value=setup.camera.elevation,
        )
    for number, light in enumerate(setup.lights, start=1):
        if _is_near(light, target, reach, height):
            raise InputError(
                f"too near: the stones reach {reach:.3g} girdle radii from the middle",
                key=f"light {number}.distance",
                value=light.distance,
            )


def _is_near(light: Light, target: np.ndarray, reach: float, height: float) -> bool:
    """Whether a light is where stones are: the ball that it takes up meets the cylinder that they do."""
    middle = target + light.distance * towards(light.elevation, light.azimuth)
    half = 0.5 * float(np.hypot(*light.size))
    beside = max(float(np.hypot(middle[0], middle[1])) - reach, 0.0)
    above = max(float(middle[2]) - height, -float(middle[2]), 0.0)
    return bool(np.hypot(beside, above) <= half and light.shape != "ring")


def _with_room(setup: Setup, target: np.ndarray, reach: float, height: float) -> Setup:
    """Return the set-up, or for a row of stones that reaches its lights a larger one."""
    for scale in _GROWN:
        grown = setup if scale == 1.0 else setup.grown(scale)
        if not any(_is_near(light, target, reach, height) for light in grown.lights):
            return grown
    return setup


def _surface(gem: Gem, first_mm: float, dispersion: bool, stock: bool) -> dict[str, Any]:
    if stock:
        return {"type": "dielectric", "int_ior": float(gem.material.index(589.3)), "ext_ior": 1.0}
    name = gem.material_name
    return {
        "type": "gem_dielectric",
        ("material" if isinstance(name, str) else "int_ior"): name,
        "dispersion": dispersion,
        "unit_mm": 0.5 * first_mm,
    }


def _crystal(gem: Gem, placed: Placed, birefringence: bool) -> dict[str, Any]:
    """Return what a birefringent stone's surface says of its crystal: how it lies in the world."""
    if gem.material.crystal is None:
        return {}
    if not birefringence:
        return {"birefringence": False}
    axes = gem.stone.crystal_axes @ placed.rotation.T
    return {"c_axis": axes[2].tolist(), "a_axis": axes[0].tolist()}


def _faceted(stone: Stone) -> Stone:
    """Return a stone with level facets in place of a round girdle, within it; others stay as they are."""
    solid = stone.solid
    if not isinstance(solid, ConvexSolid) or not solid.is_round:
        return stone
    planes = with_chords(solid.planes, GIRDLE_FACETS)
    facet = np.full(len(planes), solid.n_facets - 1)
    facet[: len(solid.facet)] = solid.facet
    return replace(stone, solid=ConvexSolid(planes=planes, facet=facet), cut=None, labelled_vertices=None)


def _bruted(placed: Placed) -> dict[str, Any]:
    """Return what makes the girdle of a stone's surface rough."""
    return {"girdle_alpha": GROUND, "axis": placed.rotation[:, 2].tolist()}


def _sensor(
    setup: Setup,
    seen: list[Placed],
    target: np.ndarray,
    width: int,
    height: int,
    samples: int,
) -> dict[str, Any]:
    import mitsuba as mi

    camera = setup.camera
    origin, _, up, half = frame(camera, seen, target, width / height)
    to_world = mi.ScalarTransform4f().look_at(origin.tolist(), target.tolist(), up.tolist())
    film = {
        "type": "hdrfilm",
        "width": width,
        "height": height,
        "pixel_format": "rgb",
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }
    common = {
        "film": film,
        "sampler": {"type": "independent", "sample_count": samples},
        "near_clip": 0.01,
        "far_clip": 1e5,
    }
    if camera.type == "orthographic":
        to_world = to_world @ mi.ScalarTransform4f().scale([half, half, 1.0])
        return {"type": "orthographic", "to_world": to_world, **common}
    sensor = {
        "type": "perspective" if camera.type == "perspective" else "thinlens",
        "fov": float(2 * np.degrees(np.arctan(half / camera.distance))),
        "fov_axis": "x",
        "to_world": to_world,
        **common,
    }
    if camera.type == "thin-lens":
        sensor |= {"aperture_radius": camera.aperture, "focus_distance": camera.distance - camera.focus}
    return sensor


def _outline_cup(placed: Placed) -> Callable[..., Any]:
    """Return what builds the same of a stone that is not round: an upright tube about its outline."""
    from scipy.spatial import ConvexHull

    points = placed.points()
    outline = points[ConvexHull(points[:, :2]).vertices, :2]
    middle = outline.mean(axis=0)
    outline = middle + _LOOSE * (outline - middle)
    low, high = float(points[:, 2].min()), float(placed.shift[2])
    return partial(tube_mesh, outline=outline, low=low, high=high)


def _cup(placed: Placed, paper: dict[str, Any]) -> dict[str, Any]:
    """Return an upright tube about a stone's pavilion, up to the girdle's lower edge."""
    edge = placed.shift  # z = 0 of the stone's frame
    return {
        "type": "cylinder",
        "p0": [float(edge[0]), float(edge[1]), float(placed.points()[:, 2].min())],
        "p1": edge.tolist(),
        "radius": _LOOSE * placed.scale,
        "bsdf": {"type": "twosided", "bsdf": paper},
    }


def _lowered(by: float) -> Any:
    import mitsuba as mi

    return mi.ScalarTransform4f().translate([0.0, 0.0, -by])


def _scaled(factor: float) -> Any:
    import mitsuba as mi

    return mi.ScalarTransform4f().scale([factor, factor, 1.0])

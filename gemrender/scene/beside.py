"""What stands beside the stones: their settings, and the things of the set-up."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from gemrender.errors import InputError
from gemrender.scene.cutting import inside_of, refuse_cutting
from gemrender.scene.mesh import plain_mesh
from gemrender.scene.placing import Placed
from gemrender.scene.settings import MadeSetting
from gemrender.scene.setup import Setup
from gemrender.scene.smooth import PlainMesh
from gemrender.scene.surfaces import surface_of
from gemrender.scene.things import thing_mesh

__all__ = ["beside"]


def beside(
    setup: Setup,
    stones: Sequence[Placed],
    settings: Sequence[MadeSetting] | None,
    *,
    radius_mm: float,
    stock: bool,
) -> dict[str, tuple[Callable[..., Any], dict[str, Any]]]:
    """Return what builds each of the meshes beside the stones, and its surface, by their names in the scene.

    Parameters
    ----------
    setup : Setup
        The set-up.
    stones : sequence of Placed
        The stones in their places.
    settings : sequence of MadeSetting, optional
        What each is held by.
    radius_mm : float
        Size of a scene unit [mm].
    stock : bool
        Whether colours are RGB.

    Raises
    ------
    InputError
        A mesh that cannot be read, or one that cuts a stone.
    """
    made: dict[str, tuple[PlainMesh, dict[str, Any]]] = {}
    metal = surface_of(setup.setting.metal, finish=setup.setting.finish, stock=stock)
    for k, (stone, setting) in enumerate(zip(stones, settings or [], strict=bool(settings)), start=1):
        made[f"setting_{k}"] = (setting.mesh.moved(stone.rotation, stone.scale, stone.shift), metal)
    for k, thing in enumerate(setup.things, start=1):
        mesh = thing_mesh(thing, radius_mm=radius_mm)
        surface = surface_of(thing.material, finish=thing.finish, colour=thing.colour, stock=stock)
        made[f"thing_{k}"] = (mesh, surface)
    if made:
        _refuse_cutting(made, setup, stones)
    return {name: (partial(plain_mesh, mesh), surface) for name, (mesh, surface) in made.items()}


def _refuse_cutting(
    made: dict[str, tuple[PlainMesh, dict[str, Any]]], setup: Setup, stones: Sequence[Placed]
) -> None:
    insides = [(stone.name, inside_of(stone)) for stone in stones]
    for name, (mesh, _) in made.items():
        kind, _, number = name.partition("_")
        is_thing = kind == "thing"
        value = setup.things[int(number) - 1].mesh if is_thing else setup.setting.type
        try:
            refuse_cutting(
                mesh.triangles,
                insides,
                key=f"thing {number}.mesh" if is_thing else "setting",
                value=value,
                may_hold=is_thing,
            )
        except InputError as error:
            raise error.at(setup.source or setup.name) from error

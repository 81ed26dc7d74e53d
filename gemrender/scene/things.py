"""Things of a set-up: meshes beside the stones, of metal, glass, paper, velvet or skin."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.cuts.mesh_files import MESH_KINDS, MOST_BYTES, parse_mesh
from gemrender.errors import InputError
from gemrender.mistakes import Mistakes
from gemrender.reading import bundled_folder, located_at, read_bytes, section
from gemrender.scene import setup_checks as check
from gemrender.scene.closed import closed_surface
from gemrender.scene.smooth import PlainMesh, creased
from gemrender.scene.surfaces import COLOURED, FINISHED, FINISHES, MATERIALS

__all__ = ["Thing", "thing_mesh", "things_of"]

UPS = ("z", "y")
#: Largest mesh [triangles].
MOST_TRIANGLES = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Thing:
    """A mesh beside the stones.

    Attributes
    ----------
    mesh : str
        Its file: .ply, .obj, .stl or .glb; in a set-up file as seen from there.
    material : str
        One of `surfaces.MATERIALS`.
    finish : {"polished", "rough"}
        Of metals and glass.
    colour : (float, float, float) or None
        Diffuse reflectance of paper and velvet, linear sRGB 0 to 1; by default white paper, black velvet.
    place : (float, float, float)
        Where the mesh's origin stands: x, y and height above the ground; (0, 0, 0) is below the stones'
        middle [girdle radius].
    turn : float
        Turn about the vertical, anticlockwise seen from above [deg].
    scale : float
        Size of the mesh's unit [girdle radius].
    unit_mm : float or None
        Size of the mesh's unit [mm], in place of `scale`.
    up : {"z", "y"}
        The mesh's axis that points up.
    """

    mesh: str
    material: str
    finish: str = "polished"
    colour: tuple[float, float, float] | None = None
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: float = 0.0
    scale: float = 1.0
    unit_mm: float | None = None
    up: str = "z"

    def __post_init__(self) -> None:
        with Mistakes() as mistakes:
            mistakes.of(self._check_mesh)
            mistakes.of(check.one_of, self, "material", MATERIALS)
            mistakes.of(check.one_of, self, "finish", FINISHES)
            mistakes.of(check.one_of, self, "up", UPS)
            mistakes.of(check.within, self, "turn", -360, 360)
            mistakes.of(check.within, self, "scale", 1e-6, 1e6)
            if self.unit_mm is not None:
                mistakes.of(check.within, self, "unit_mm", 1e-6, 1e6)
                if self.scale != 1.0:
                    mistakes.add(InputError("give scale or unit_mm, not both", key="scale", value=self.scale))
            if self.finish != "polished" and self.material in MATERIALS and self.material not in FINISHED:
                allowed = f"is for {', '.join(FINISHED)} only"
                mistakes.add(InputError(allowed, key="finish", value=self.finish))
            place = mistakes.of(check.numbers, self, "place", 3, -1e4, 1e4)
            colour: Any = self.colour
            if colour is not None:
                if self.material in MATERIALS and self.material not in COLOURED:
                    allowed = f"is for {', '.join(COLOURED)} only"
                    mistakes.add(InputError(allowed, key="colour", value=self.colour))
                colour = mistakes.of(check.numbers, self, "colour", 3, 0, 1)
        object.__setattr__(self, "place", place)
        object.__setattr__(self, "colour", colour)

    def _check_mesh(self) -> None:
        kinds = tuple(f".{kind}" for kind in MESH_KINDS)
        if not isinstance(self.mesh, str) or not self.mesh.lower().endswith(kinds):
            raise InputError(f"must be a file of {', '.join(kinds)}", key="mesh", value=self.mesh)


def things_of(tables: object, folder: Path, mistakes: Mistakes) -> tuple[Thing, ...]:
    """Return the things of a set-up file's tables; their meshes are named as seen from its folder."""
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise InputError("must be sections: a line [[thing]] before each", key="thing", value=tables)
    made = [mistakes.of(_thing, table, f"thing {k}", folder, mistakes) for k, table in enumerate(tables, 1)]
    return tuple(thing for thing in made if thing is not None)


def _thing(table: dict[str, Any], name: str, folder: Path, mistakes: Mistakes) -> Thing:
    values = section({name: table}, name, [f.name for f in fields(Thing)], mistakes=mistakes)
    with located_at(None, name), Mistakes() as own:
        for key in ("mesh", "material"):
            if key not in table:
                allowed = "a mesh file" if key == "mesh" else f"one of {', '.join(MATERIALS)}"
                own.add(InputError(f"missing; must be {allowed}", key=key))
        needed = {"mesh": "missing.ply", "material": MATERIALS[0]}
        thing = own.of(Thing, **needed | values)
        if thing is not None and "mesh" in table:
            file, bundled = folder / thing.mesh, bundled_folder("setups")
            bare = thing.mesh == Path(thing.mesh).name
            if bare and not file.is_file() and bundled is not None and (bundled / thing.mesh).is_file():
                file = bundled / thing.mesh  # of a copy of a set-up that comes along
            if not file.is_file():
                own.add(InputError("no such file", key="mesh", value=thing.mesh))
            thing = Thing(**needed | values | {"mesh": str(file)})
    assert thing is not None
    return thing


def thing_mesh(thing: Thing, *, radius_mm: float) -> PlainMesh:
    """Read a thing's mesh, and return it in its place.

    Parameters
    ----------
    thing : Thing
        The thing.
    radius_mm : float
        Size of a scene unit [mm].

    Raises
    ------
    InputError
        The file cannot be read, has no triangles or too many, or, of glass, is not closed.
    BackendError
        There is no trimesh.
    """
    file = Path(thing.mesh)
    with located_at(str(file)):
        data = read_bytes(file, kind="mesh", most_bytes=MOST_BYTES)
        positions, faces = parse_mesh(data, file.suffix.lower().lstrip("."))
        if not 1 <= len(faces) <= MOST_TRIANGLES:
            raise InputError(f"must have 1 to {MOST_TRIANGLES} triangles; it has {len(faces)}")
        if not np.isfinite(positions).all():
            raise InputError("must have vertices that are finite numbers")
        if thing.material == "glass":  # which side its inside is on
            outward = closed_surface(positions, faces).outward
            faces = np.where((outward < 0)[:, None], faces[:, ::-1], faces)
        made = creased(positions, faces)
        if not len(made.faces):
            raise InputError("must have triangles with an area")
    if thing.up == "y":
        made = made.moved(np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]), 1.0, np.zeros(3))
    scale = thing.scale if thing.unit_mm is None else thing.unit_mm / radius_mm
    cos, sin = np.cos(np.radians(thing.turn)), np.sin(np.radians(thing.turn))
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return made.moved(turn, scale, np.array(thing.place))

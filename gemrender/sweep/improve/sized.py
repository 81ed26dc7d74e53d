"""The size of stones as goals have it: volume, share of given rough, weight; and rough as it is written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from gemrender.cuts.mesh_files import MESH_KINDS, MOST_BYTES, parse_mesh
from gemrender.errors import InputError
from gemrender.optics import load_material
from gemrender.reading import located_at, read_bytes
from gemrender.stone import Stone
from gemrender.sweep.improve.goals import Goal
from gemrender.sweep.improve.rough import Box, Diameter, Rough
from gemrender.sweep.improve.rough_mesh import MeshRough

__all__ = ["Sized", "density_of", "read_rough"]


@dataclass(frozen=True, slots=True)
class Sized:
    """What a goal needs of the size of stones.

    Parameters
    ----------
    sizes : tuple of str
        Which of "volume", "yield" and "carat".
    rough : Rough or None
        What they are cut from.
    density : float or None
        Their density, for carat [g/cm^3].
    """

    sizes: tuple[str, ...]
    rough: Rough | None = None
    density: float | None = None

    @classmethod
    def of(cls, goals: Sequence[Goal], stone: Stone, rough: Rough | None) -> Sized:
        """Return what goals need of the sizes of stones such as this one.

        Raises
        ------
        InputError
            They need rough that is not given, or a density that the material has not.
        """
        sizes = tuple(dict.fromkeys(name for goal in goals for name in goal.sizes))
        text = "; ".join(goal.text for goal in goals)
        if rough is None and stone.size_mm is not None and "yield" not in sizes:
            rough = Diameter(stone.size_mm)  # the size that it has is kept
        for name in ("yield", "carat"):
            if name in sizes and rough is None:
                raise InputError(f"{name} needs rough, as --rough box=10x8x6", key="goal", value=text)
        if "yield" in sizes and rough is not None and rough.volume_mm3 is None:
            raise InputError(
                "yield needs rough that has a volume, a box or a mesh; carat does not",
                key="goal", value=text,
            )  # fmt: skip
        return cls(sizes, rough, density_of(stone) if "carat" in sizes else None)

    def values(self, stone: Stone) -> dict[str, float]:
        """Return the values of a stone by name: [half length cubed], [%], [carat]."""
        values = {"volume": float(stone.solid.volume)} if "volume" in self.sizes else {}
        if self.rough is not None and ("yield" in self.sizes or "carat" in self.sizes):
            fit = self.rough.fit(stone)
            if fit.yielded is not None:
                values["yield"] = fit.yielded
            if self.density is not None:
                values["carat"] = fit.carat(self.density)
        return values

    def stone(self, stone: Stone) -> Stone:
        """Return a stone with the size that rough gives it, if there is any."""
        if self.rough is None:
            return stone
        return replace(stone, size_mm=2.0 * self.rough.fit(stone).scale_mm)

    def to_dict(self) -> dict[str, Any]:
        """Return what goals depend on, of JSON's types; nothing without rough."""
        return {} if self.rough is None else {"rough": self.rough.to_dict()}


def read_rough(text: str) -> Rough:
    """Read what rough there is: "box=10x8x6", "mesh=FILE" or "diameter=6.5", lengths in mm.

    Raises
    ------
    InputError
        It is none of these, a side is out of range, or the file is no closed mesh.
    """
    kind, _, value = (part.strip() for part in text.partition("="))
    if kind == "mesh" and value:
        path = Path(value)
        if path.suffix.lower().lstrip(".") not in MESH_KINDS:
            kinds = ", ".join(f".{kind}" for kind in MESH_KINDS)
            raise InputError(f"must be a mesh, one of {kinds}", key="rough", value=value)
        with located_at(value):
            data = read_bytes(path, kind="mesh", most_bytes=MOST_BYTES)
            return MeshRough(path.name, *parse_mesh(data, path.suffix.lower().lstrip(".")))
    try:
        numbers = tuple(float(cell) for cell in value.lower().replace("\u00d7", "x").split("x"))
    except ValueError:
        numbers = ()
    if kind == "box" and len(numbers) == 3:
        return Box((numbers[0], numbers[1], numbers[2]))
    if kind == "diameter" and len(numbers) == 1:
        return Diameter(numbers[0])
    raise InputError(
        "must be box=LENGTHxWIDTHxHEIGHT, diameter=D (in mm) or mesh=FILE", key="rough", value=text
    )


def density_of(stone: Stone) -> float:
    """Return the density of a stone's material [g/cm^3].

    Raises
    ------
    InputError
        The material is an index, or has no density.
    """
    density = load_material(stone.material, warn=False).density
    if density is None:
        raise InputError(
            "carat needs a material with a density, as --material quartz",
            source=stone.source or stone.name, key="material", value=stone.material,
        )  # fmt: skip
    return density

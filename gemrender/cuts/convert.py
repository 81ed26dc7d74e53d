"""Stones written as files of every kind that is written."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from gemrender.cuts.asc import write_asc
from gemrender.cuts.design import MOST_FACETS, Design
from gemrender.cuts.gcs import write_gcs
from gemrender.cuts.gem import write_gem
from gemrender.cuts.given import StoneLike, as_stone
from gemrender.cuts.mesh_files import MESH_KINDS, write_mesh
from gemrender.cuts.round_girdle import girdle_planes
from gemrender.cuts.tiers import gear_of, tiers_of
from gemrender.errors import InputError
from gemrender.optics.material_files import refractive_index
from gemrender.reading import located_at
from gemrender.stone.polyhedron import interior_point
from gemrender.stone.solid import ROUND_PIECES, ConvexSolid
from gemrender.stone.stone import Stone

__all__ = ["WRITTEN_KINDS", "design_of", "save_stone"]

_DESIGNS: dict[str, Callable[[Design, Path], None]] = {"asc": write_asc, "gem": write_gem, "gcs": write_gcs}
#: Kinds that are written.
WRITTEN_KINDS = (*_DESIGNS, *MESH_KINDS, "csv")
#: Fewest level facets that a round girdle becomes in a design; a multiple of the gear's teeth.
FEWEST_PIECES = 90
#: Least distance of a plane from the point that a design's distances are told from [stone's unit].
LEAST_DISTANCE = 0.01


def save_stone(stone: StoneLike, path: str | os.PathLike[str], *, kind: str | None = None) -> tuple[str, ...]:
    """Write a stone to a file, whole or not at all; a file that is there is replaced.

    Parameters
    ----------
    stone : Stone, str or path-like
        The stone, or what `load_stone` takes.
    path : str or path-like
        The file: a design (.asc, .gem, .gcs), a mesh (.stl, .obj, .ply, .glb), or the 57 vertices of a round
        brilliant (.csv).
    kind : str, optional
        One of `WRITTEN_KINDS`; by default what the name ends in.

    Returns
    -------
    tuple of str
        What the file says otherwise than the stone, such as how many facets its round girdle has.

    Raises
    ------
    InputError
        There is no such kind, the kind cannot hold the stone, or the file cannot be written.
    BackendError
        A library that the kind needs is not installed; says the cure.
    """
    stone, file = as_stone(stone), Path(path)
    kind = kind or file.suffix.lower().lstrip(".")
    with located_at(str(file)):
        if kind not in WRITTEN_KINDS:
            kinds = ", ".join(f".{kind}" for kind in WRITTEN_KINDS)
            raise InputError(f"must end in one of {kinds}", key="file", value=file.name)
        if kind in _DESIGNS:
            design, notes = design_of(stone)
            _DESIGNS[kind](design, file)
            return notes
        if kind == "csv":
            from gemrender.cuts.files import save_vertices

            if stone.labelled_vertices is None:
                raise InputError("only the 57 vertices of round brilliants are written as .csv")
            save_vertices(stone, file)
            return ()
        write_mesh(stone, file, kind=kind)
        return (_girdle_note(ROUND_PIECES),) if stone.is_round else ()


def design_of(stone: Stone) -> tuple[Design, tuple[str, ...]]:
    """Return a stone as a faceter's design, and what it says otherwise than the stone.

    A stone that was made from a design has that design, its angles and distances as they were. Others get
    tiers by the kinds of their facets, on the commonest index wheel on which these lie at whole teeth. Facets
    that are not flat become several, a round girdle level facets that touch it.

    Parameters
    ----------
    stone : Stone
        A convex stone.

    Raises
    ------
    InputError
        It is not convex, or has more planes than a design may.
    """
    index = refractive_index(stone.material)
    if isinstance(stone.cut, Design):
        return replace(stone.cut, index=index), ()
    solid = stone.solid
    if not isinstance(solid, ConvexSolid):
        raise InputError("is not convex, and so no design; .stl, .obj, .ply and .glb can hold it")
    planes, facet = solid.planes, solid.facet
    gear = gear_of(planes)
    notes: tuple[str, ...] = ()
    if stone.is_round:
        pieces = gear * -(-FEWEST_PIECES // gear)
        girdle = girdle_planes(solid, pieces)
        planes = np.concatenate([planes, girdle])
        facet = np.concatenate([facet, np.full(len(girdle), solid.n_facets - 1)])
        notes = (_girdle_note(len(girdle)),)
    elif len(planes) > solid.n_facets:
        notes = (f"facets that are not flat became {len(planes) - solid.n_facets} more",)
    if len(planes) > MOST_FACETS:
        raise InputError(f"has {len(planes)} planes; a design has at most {MOST_FACETS}")
    planes = planes[np.argsort(facet, kind="stable")]
    kinds = ["_".join(stone.facets[number].kind.split()) for number in np.sort(facet).tolist()]
    distances = planes[:, 3] - planes[:, :3] @ _origin(planes)
    return Design(
        tiers=tiers_of(np.column_stack([planes[:, :3], distances]), gear=gear, keys=kinds, names=kinds),
        gear=gear,
        index=index,
    ), notes


def _origin(planes: np.ndarray) -> np.ndarray:
    """Return a point inside planes to tell distances from, (3,): the stone's origin, else one on its axis.

    A facet through the point has no side there. Off the axis, facets of one tier have different distances.
    """
    return np.zeros(3) if planes[:, 3].min() >= LEAST_DISTANCE else interior_point(planes)


def _girdle_note(pieces: int) -> str:
    return f"the round girdle became {pieces} level facets"

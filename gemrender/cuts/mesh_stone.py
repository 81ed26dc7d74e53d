"""A stone from the triangles of a mesh: half-spaces where it is convex, else a closed mesh with facets."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.cuts.mesh_facets import (
    UP,
    MeshFacets,
    facets_of,
    find_up,
    levelled,
    named_facets,
    turned_up,
)
from gemrender.cuts.surface import SIX_DIGITS, Surface, closed_surface
from gemrender.errors import InputError
from gemrender.stone.facets import LEVEL
from gemrender.stone.frame import in_frame
from gemrender.stone.solid import ConvexSolid, MeshSolid, convex_solid
from gemrender.stone.stone import Stone

__all__ = ["check_up", "stone_of_triangles"]


def stone_of_triangles(
    vertices: np.ndarray,
    triangles: np.ndarray,
    *,
    up: str | None = None,
    rounding: float = SIX_DIGITS,
    **facts: Any,
) -> Stone:
    """Make the stone that a closed surface of triangles bounds.

    Facets are coplanar triangles, up to the rounding of six digits. The surface is mended where that is
    possible, and the stone's `notes` say how.

    Parameters
    ----------
    vertices : (v, 3) array_like
        Positions, in any unit of length.
    triangles : (f, 3) array_like of int
        Vertices of each triangle.
    up : {"x", "y", "z", "-x", "-y", "-z"}, optional
        Direction of the stone's axis, table up. Without it the largest facet is taken for the table.
    rounding : float
        Rounding of the coordinates [half the longest side of the box].
    **facts
        Fields of `Stone`, such as its name.

    Raises
    ------
    InputError
        The surface is open (it says where), flat, twisted, or more than one; or `up` is no direction.
    """
    check_up(up)
    surface = closed_surface(
        np.asarray(vertices, dtype=np.float64), np.asarray(triangles, dtype=np.int64), rounding
    )
    facets = facets_of(surface)
    notes = [*surface.notes]
    if up is None:
        axis = find_up(surface, facets)
        notes.append(f"the largest facet was taken for the table: {_axis_note(axis)} is up")
    else:
        axis = np.array(UP[up])
    turn = turned_up(axis)
    planes = np.column_stack([facets.planes[:, :3] @ turn.T, facets.planes[:, 3]])
    make = _convex if surface.is_convex else _hollow
    solid, planes = make(surface, facets, turn, planes)
    order, named = named_facets(planes, solid.areas)
    number = np.argsort(order)
    if isinstance(solid, ConvexSolid):
        solid = ConvexSolid(planes=solid.planes[order], facet=np.arange(len(order)))
    else:
        solid = MeshSolid(vertices=solid.vertices, triangles=solid.triangles, facet=number[solid.facet])
        notes.append("it is not convex")
    assumed = tuple(facts.pop("assumed", ()))
    if facts.get("material") is None:
        assumed = (*assumed, "diamond (no material in the file)")
    return Stone(solid=solid, facets=named, notes=(*facts.pop("notes", ()), *notes), assumed=assumed, **facts)


def check_up(up: object, key: str = "up") -> None:
    """Refuse what is no direction that can be up.

    Raises
    ------
    InputError
        It is none of x, y, z, -x, -y, -z, nor None.
    """
    if up is not None and up not in UP:
        raise InputError(f"must be one of {', '.join(UP)}", key=key, value=up)


def _convex(
    surface: Surface, facets: MeshFacets, turn: np.ndarray, planes: np.ndarray
) -> tuple[ConvexSolid, np.ndarray]:
    """Return the half-spaces of a convex surface in their frame, and the planes of its facets."""
    framed, _ = in_frame(levelled(planes, facets.middles @ turn.T, facets.reach, surface.near))
    solid, _ = convex_solid(framed, np.arange(len(framed)))
    return solid, solid.planes


def _hollow(
    surface: Surface, facets: MeshFacets, turn: np.ndarray, planes: np.ndarray
) -> tuple[MeshSolid, np.ndarray]:
    """Return a surface that is not convex in its frame, and the planes of its facets."""
    vertices = surface.vertices @ turn.T
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    rise = planes[facets.facet, 2]
    pavilion, above = np.zeros((2, len(vertices)), dtype=bool)
    pavilion[surface.triangles[rise < -LEVEL]] = True
    above[surface.triangles[rise >= -LEVEL]] = True
    edge = pavilion & above
    origin = np.array([*(0.5 * (low + high))[:2], vertices[edge if edge.any() else above, 2].min()])
    unit = 0.5 * float((high - low)[:2].max())
    solid = MeshSolid(vertices=(vertices - origin) / unit, triangles=surface.triangles, facet=facets.facet)
    moved = planes[:, 3] - planes[:, :3] @ origin
    return solid, np.column_stack([planes[:, :3], moved / unit])


def _axis_note(axis: np.ndarray) -> str:
    for name, direction in UP.items():
        if np.array_equal(axis, direction):
            return name
    return "(" + ", ".join(f"{x:.4f}" for x in axis.tolist()) + ")"

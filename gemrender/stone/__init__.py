"""Stones: solids with named facets, their symmetry and meshes. Needs numpy, and scipy where it is used."""

from __future__ import annotations

from gemrender.stone.facets import Facet, side_of
from gemrender.stone.frame import in_frame
from gemrender.stone.mesh import StoneMesh, tessellate
from gemrender.stone.orientation import Orientation
from gemrender.stone.solid import ConvexSolid, MeshSolid, convex_solid
from gemrender.stone.stone import Stone
from gemrender.stone.symmetry import Symmetry

__all__ = [
    "ConvexSolid",
    "Facet",
    "MeshSolid",
    "Orientation",
    "Stone",
    "StoneMesh",
    "Symmetry",
    "convex_solid",
    "in_frame",
    "side_of",
    "tessellate",
]

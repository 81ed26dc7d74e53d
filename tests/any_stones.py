"""Stones of other cuts than the round brilliant: faceters' designs, and a mesh that is not convex."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from gemrender.cuts.asc import read_asc
from gemrender.stone import Facet, MeshSolid, Stone, side_of
from gemrender.stone.planes import mean_planes

FOLDER = Path(__file__).parent / "cases" / "stones"
#: A step cut whose girdle is level, a pear whose girdle is not, and a design without symmetry or table.
DESIGNS = ("emerald", "pear", "slab-chiral")


@cache
def design(name: str) -> Stone:
    """Return a design of the cases."""
    return read_asc(FOLDER / f"{name}.asc").stone(name=name)


@cache
def facets_in(name: str) -> list[int]:
    """How many facets each tier of an .asc file of the cases has: a number each, on the tier's line.

    Such a line is ``a ANGLE DISTANCE INDEX [INDEX ...] [n NAME] ... [G what is to be met]``.
    """
    found = []
    for line in (FOLDER / f"{name}.asc").read_text(encoding="utf-8").splitlines():
        if line.startswith("a "):
            words = line.partition(" G ")[0].split()[3:]
            named = [before == "n" for before in ("", *words[:-1])]
            found.append(sum(word != "n" and not is_name for word, is_name in zip(words, named, strict=True)))
    return found


def hollow_stone() -> Stone:
    """Return an emerald whose table is a shallow inverted pyramid."""
    stone = design("emerald")
    body = stone.solid.polyhedron
    deep = stone.facet_names.index("T")
    vertices, triangles, facet = [*body.vertices], [], []
    for number in range(len(body.planes)):
        polygon = body.polygon(number).tolist()
        if number == deep:
            middle = len(vertices)
            vertices.append(body.vertices[polygon].mean(axis=0) - [0.0, 0.0, 0.1])
            triangles += [(middle, a, b) for a, b in zip(polygon, [*polygon[1:], polygon[0]], strict=True)]
            facet += [number + k for k in range(len(polygon))]
            hollows = len(polygon)
        else:
            triangles += [(polygon[0], a, b) for a, b in pairwise(polygon[1:])]
            facet += [number + (hollows - 1 if number > deep else 0)] * (len(polygon) - 2)
    solid = MeshSolid(vertices=np.array(vertices), triangles=np.array(triangles), facet=np.array(facet))
    normals = mean_planes(solid.vertices, solid.triangles, solid.facet)[:, :3]
    facets = tuple(Facet(f"F{i + 1}", f"F{i + 1}", side_of(n[2])) for i, n in enumerate(normals))
    return Stone(solid=solid, facets=facets, name="hollow", material=1.54)

"""Mesh files: .stl .obj .ply .glb read by trimesh; written with all their digits where the format has them.

What gemrender writes says which way is up, so that a stone without a table comes back the same way.
"""

from __future__ import annotations

import io
import json
import logging
import os
import re
import struct
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.cuts.mesh_stone import stone_of_triangles
from gemrender.cuts.round_girdle import girdle_planes
from gemrender.cuts.surface import ALL_DIGITS, SIX_DIGITS
from gemrender.cuts.text import one_line
from gemrender.errors import BackendError, InputError
from gemrender.reading import located_at, read_bytes
from gemrender.stone.polyhedron import intersect
from gemrender.stone.solid import ROUND_PIECES, MeshSolid
from gemrender.stone.stone import Stone
from gemrender.writing import write_whole

__all__ = ["MESH_KINDS", "parse_mesh", "read_mesh", "write_mesh"]

#: Kinds of mesh files.
MESH_KINDS = ("stl", "obj", "ply", "glb")
#: Largest file [bytes]: 300,000 triangles as text.
MOST_BYTES = 100_000_000
#: What files written by gemrender say.
_UP = re.compile(rb"gemrender up=(-?[xyz])\b")
#: So far into a file it may be said [bytes].
_BEGINNING = 100_000


def read_mesh(
    path: str | os.PathLike[str], *, kind: str | None = None, up: str | None = None, **facts: Any
) -> Stone:
    """Read a mesh file and make its stone.

    Parameters
    ----------
    path : str or path-like
        The file.
    kind : {"stl", "obj", "ply", "glb"}, optional
        What it is; by default what its name ends in.
    up : {"x", "y", "z", "-x", "-y", "-z"}, optional
        Direction of the stone's axis, table up. Without it the largest facet is taken for the table, unless
        the file was written by gemrender.
    **facts
        Fields of `Stone`, such as its name.

    Raises
    ------
    InputError
        The file cannot be read, is damaged, or its surface bounds no stone.
    BackendError
        There is no trimesh.
    """
    file = Path(path)
    with located_at(str(file)):
        data = read_bytes(file, kind="mesh", most_bytes=MOST_BYTES)
        kind = kind or file.suffix.lower().lstrip(".")
        vertices, triangles = parse_mesh(data, kind)
        own = _UP.search(data[:_BEGINNING])
        return stone_of_triangles(
            vertices,
            triangles,
            up=up or (own.group(1).decode() if own else None),
            rounding=ALL_DIGITS if own and kind != "glb" else SIX_DIGITS,
            **facts,
        )


def parse_mesh(data: bytes, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices (v, 3) float64 and the triangles (f, 3) int64 in the bytes of a mesh file.

    Raises
    ------
    InputError
        They are damaged, or hold no mesh. It has no source: see `located_at`.
    BackendError
        There is no trimesh.
    """
    if kind == "glb":
        _check_glb(data)
    try:
        with _quiet():
            trimesh = _require_trimesh()
            loaded = trimesh.load_scene(io.BytesIO(data), file_type=kind, process=False)
            mesh = loaded.to_mesh()
            vertices, triangles = (
                np.array(mesh.vertices, dtype=np.float64),
                np.array(mesh.faces, dtype=np.int64),
            )
    except BackendError:
        raise
    except MemoryError as error:
        raise InputError(f"is no readable .{kind} file: it asks for more memory than there is") from error
    except Exception as error:  # whatever trimesh meets in a damaged file
        raise InputError(f"is no readable .{kind} file: {one_line(str(error))[:200]}") from error
    if vertices.ndim != 2 or triangles.ndim != 2 or vertices.shape[1:] != (3,) or triangles.shape[1:] != (3,):
        raise InputError(f"is a .{kind} file without triangles")
    return vertices, triangles


def write_mesh(stone: Stone, path: str | os.PathLike[str], *, kind: str | None = None) -> None:
    """Write a stone as a mesh file; a round girdle becomes `solid.ROUND_PIECES` level facets.

    .obj and .ply hold the facets as polygons; .obj, .ply and .stl are text with all digits; .glb has numbers
    of 32 bits, and y up. Facets of .obj files keep their names and order.

    Parameters
    ----------
    stone : Stone
        The stone; lengths are in its own unit.
    path : str or path-like
        File to write, whole or not at all; a file that is there is replaced.
    kind : {"stl", "obj", "ply", "glb"}, optional
        By default what its name ends in.

    Raises
    ------
    InputError
        The file cannot be written.
    BackendError
        There is no trimesh, for .glb.
    """
    file = Path(path)
    kind = kind or file.suffix.lower().lstrip(".")
    make = {"stl": _stl, "obj": _obj, "ply": _ply, "glb": _glb}[kind]
    data = make(stone)
    write_whole(file.parent, {file.name: lambda made: made.write_bytes(data)})


# ---- Writing -------------------------------------------------------------------------------------------


def _polygons(stone: Stone) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
    """Return vertices, polygons and the facet of each, facet by facet."""
    solid = stone.solid
    if isinstance(solid, MeshSolid):
        order = np.argsort(solid.facet, kind="stable")
        return solid.vertices, list(solid.triangles[order]), solid.facet[order]
    body = solid.polyhedron
    if solid.is_round:
        body = intersect(np.concatenate([solid.planes, girdle_planes(solid, ROUND_PIECES)]))
    facet = np.full(len(body.planes), solid.n_facets - 1)
    facet[: len(solid.facet)] = solid.facet
    bounding = np.flatnonzero(body.bounds)
    bounding = bounding[np.argsort(facet[bounding], kind="stable")]
    return body.vertices, [body.polygon(number) for number in bounding.tolist()], facet[bounding]


def _triangles(stone: Stone) -> tuple[np.ndarray, np.ndarray]:
    vertices, polygons, _ = _polygons(stone)
    fans = [np.column_stack([np.full(len(p) - 2, p[0]), p[1:-1], p[2:]]) for p in polygons]
    return vertices, np.concatenate(fans)


def _title(stone: Stone) -> str:
    title = f"{one_line(stone.name)}, gemrender up=z"
    return title + (f", a round girdle of {ROUND_PIECES} level facets" if stone.is_round else "")


def _row(numbers: list[float]) -> str:
    return " ".join(map(repr, numbers))


def _obj(stone: Stone) -> bytes:
    vertices, polygons, facet = _polygons(stone)
    lines = [f"# {_title(stone)}", *(f"v {_row(v)}" for v in vertices.tolist())]
    before = -1
    for polygon, number in zip(polygons, facet.tolist(), strict=True):
        if number != before:
            lines.append("g " + "_".join(stone.facets[number].name.split()))
            before = number
        lines.append("f " + " ".join(str(k + 1) for k in polygon.tolist()))
    return ("\n".join(lines) + "\n").encode()


def _ply(stone: Stone) -> bytes:
    vertices, polygons, _ = _polygons(stone)
    lines = ["ply", "format ascii 1.0", f"comment {_title(stone)}", f"element vertex {len(vertices)}"]
    lines += [f"property double {axis}" for axis in "xyz"]
    lines += [f"element face {len(polygons)}", "property list int int vertex_indices", "end_header"]
    lines += map(_row, vertices.tolist())
    lines += (f"{len(p)} " + " ".join(map(str, p.tolist())) for p in polygons)
    return ("\n".join(lines) + "\n").encode()


def _stl(stone: Stone) -> bytes:
    vertices, triangles = _triangles(stone)
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.where(lengths > 0, lengths, 1.0)
    lines = [f"solid {_title(stone)}"]
    for normal, triangle in zip(normals.tolist(), corners.tolist(), strict=True):
        lines += [f"facet normal {_row(normal)}", "outer loop"]
        lines += [f"vertex {_row(corner)}" for corner in triangle]
        lines += ["endloop", "endfacet"]
    return ("\n".join([*lines, "endsolid"]) + "\n").encode()


def _glb(stone: Stone) -> bytes:
    trimesh = _require_trimesh()
    vertices, triangles = _triangles(stone)
    # glTF has y up.
    turned = np.column_stack([vertices[:, 0], vertices[:, 2], -vertices[:, 1]])
    mesh = trimesh.Trimesh(turned, triangles, process=False)
    mesh.metadata["written_by"] = "gemrender up=y"
    with _quiet():
        return bytes(trimesh.exchange.gltf.export_glb(trimesh.Scene(mesh)))


# ---- Reading -------------------------------------------------------------------------------------------


def _check_glb(data: bytes) -> None:
    """Refuse a .glb file that says it has more than it can hold, before anyone makes room for it."""
    try:
        magic, _, _, length, chunk = struct.unpack_from("<4sIII4s", data)
        content = json.loads(data[20 : 20 + length])
        if magic != b"glTF" or chunk != b"JSON" or not isinstance(content, dict):
            raise ValueError("no glTF")
        counts = [accessor["count"] for accessor in content.get("accessors", [])]
    except (struct.error, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError("is no readable .glb file: its first part is damaged") from error
    if not all(isinstance(count, int) and 0 <= count <= len(data) for count in counts):
        raise InputError("is no readable .glb file: it says that it has more than it holds")


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep trimesh's warnings and log from the user: what matters is refused or noted in one line."""
    log = logging.getLogger("trimesh")
    level, log.disabled = log.disabled, True
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    finally:
        log.disabled = level


def _require_trimesh() -> Any:
    try:
        import trimesh
    except ImportError as error:
        raise BackendError(
            f"meshes cannot be read ({error}); to cure it: pip install 'gemrender[mesh]'"
        ) from error
    return trimesh

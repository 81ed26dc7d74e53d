"""Sarine's scans, .srn, by srn-parser: experimental, as no real file was there to test with.

Coordinates are in micrometres; the stone has its own unit, as every stone.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.cuts.mesh_stone import stone_of_triangles
from gemrender.cuts.text import one_line
from gemrender.errors import BackendError, InputError
from gemrender.reading import located_at, read_bytes
from gemrender.stone.stone import Stone

__all__ = ["MICROMETRE_MM", "read_scan"]

#: A scan's unit of length [mm].
MICROMETRE_MM = 0.001
#: Largest file [bytes].
MOST_BYTES = 100_000_000


def read_scan(path: str | os.PathLike[str], *, up: str | None = None, **facts: Any) -> Stone:
    """Read a scan and make its stone: facets are coplanar triangles, as of a mesh.

    Of two meshes in a file the one with fewer, flat faces is used. Its name, weight and grades are not kept.

    Parameters
    ----------
    path : str or path-like
        The file.
    up : {"x", "y", "z", "-x", "-y", "-z"}, optional
        Direction of the stone's axis, table up; without it the largest facet is taken for the table.
    **facts
        Fields of `Stone`, such as its name.

    Raises
    ------
    InputError
        The file cannot be read, is damaged, or its surface bounds no stone.
    BackendError
        There is no srn-parser.
    """
    file = Path(path)
    with located_at(str(file)):
        read_bytes(file, kind="scan", most_bytes=MOST_BYTES)
        parse = _require_parser()
        try:
            found = parse(file)
            mesh = found.mesh if found.mesh.faces else (found.high_res_mesh or found.mesh)
            vertices = np.array(mesh.vertices, dtype=np.float64).reshape(-1, 3)
            triangles = _fans(mesh.faces)
        except Exception as error:  # whatever the parser meets in a damaged file
            raise InputError(f"is no readable .srn file: {one_line(str(error))[:200]}") from error
        longest = float(np.ptp(vertices, axis=0).max()) if len(vertices) else 0.0
        notes = (
            f"a scan, which is read experimentally; its longest side is {longest * MICROMETRE_MM:.3f} mm",
        )
        return stone_of_triangles(vertices, triangles, up=up, notes=notes, **facts)


def _fans(faces: list[tuple[int, ...]]) -> np.ndarray:
    """Cut polygons into triangles (f, 3)."""
    triangles = [(face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1)]
    return np.array(triangles, dtype=np.int64).reshape(-1, 3)


def _require_parser() -> Any:
    try:
        from srn_parser import parse_srn
    except ImportError as error:
        raise BackendError(
            f"scans cannot be read ({error}); to cure it: pip install 'gemrender[scan]'"
        ) from error
    return parse_srn

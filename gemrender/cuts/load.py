"""Stones from files of designs, meshes and scans: whatever `content` tells them to be."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from gemrender.cuts.asc import read_asc
from gemrender.cuts.content import DESIGN_KINDS, SOLID_KINDS, kind_of_file
from gemrender.cuts.design import Design
from gemrender.cuts.gcs import read_gcs
from gemrender.cuts.gem import read_gem
from gemrender.cuts.mesh_files import read_mesh
from gemrender.cuts.mesh_stone import check_up
from gemrender.cuts.scans import read_scan
from gemrender.errors import InputError
from gemrender.reading import located_at, read_bytes, stem
from gemrender.stone.stone import Stone

__all__ = ["load_design_file", "read_design"]

_READERS = {"asc": read_asc, "gem": read_gem, "gcs": read_gcs}


def read_design(path: str | os.PathLike[str], *, missing: str = "no such file") -> Design:
    """Read a faceter's design of any kind: .asc, .gem or .gcs, told by content, then by ending.

    Parameters
    ----------
    path : str or path-like
        The file.
    missing : str
        What to say where there is no such file.

    Raises
    ------
    InputError
        The file cannot be read, or holds no design.
    """
    kind = _kind(Path(path), missing)
    if kind not in DESIGN_KINDS:
        kinds = ", ".join(f".{kind}" for kind in DESIGN_KINDS)
        raise InputError(f"is a .{kind} file; a design is one of {kinds}", source=os.fspath(path))
    return _READERS[kind](path)


def load_design_file(
    path: str | os.PathLike[str],
    *,
    name: str | None = None,
    material: str | float | None = None,
    up: str | None = None,
    source: str | None = None,
    kinds: tuple[str, ...] = (*DESIGN_KINDS, *SOLID_KINDS),
    missing: str = "no such file",
    with_headers: bool = False,
) -> Stone:
    """Load the stone of a design, a mesh or a scan.

    Parameters
    ----------
    path : str or path-like
        The file: .asc, .gem, .gcs, .stl, .obj, .ply, .glb or .srn, told by content, then by ending.
    name : str, optional
        What to call the stone; by default the file's name.
    material : str or float, optional
        Material or refractive index in place of the design's own.
    up : {"x", "y", "z", "-x", "-y", "-z"}, optional
        Of meshes and scans the direction of the stone's axis, table up; without it the largest facet is taken
        for the table.
    source : str, optional
        Where the stone came from; by default the file.
    kinds : tuple of str
        The kinds that are allowed.
    missing : str
        What to say where there is no such file.
    with_headers : bool
        Whether the stone keeps a design's headers and footnotes, which hold people's names.

    Raises
    ------
    InputError
        The file cannot be read, is of no such kind, or makes no stone.
    BackendError
        A library that the kind needs is not installed; says the cure.
    """
    file = Path(path)
    kind = _kind(file, missing)
    if kind not in kinds:
        told = ", ".join(f".{kind}" for kind in kinds)
        raise InputError(f"is a .{kind} file; here it must be one of {told}", source=str(file))
    facts: dict[str, Any] = {
        "name": name or stem(file, "stone"),
        "material": material,
        "source": source or str(file),
    }
    if kind in DESIGN_KINDS:
        if up is not None:
            raise InputError(
                "is of meshes only; a design has its table up", source=str(file), key="up", value=up
            )
        design = _READERS[kind](file)
        with located_at(str(file)):
            return design.stone(with_headers=with_headers, **facts)
    with located_at(str(file)):
        check_up(up)
    if kind == "srn":
        return read_scan(file, up=up, **facts)
    return read_mesh(file, kind=kind, up=up, **facts)


def _kind(file: Path, missing: str) -> str:
    kind = kind_of_file(file)
    if kind is None:  # it cannot be read, or is empty: told by who reads it
        if not read_bytes(file, kind="stone", missing=missing).strip():
            raise InputError("is empty", source=str(file))
        raise InputError("cannot be read", source=str(file))
    return kind

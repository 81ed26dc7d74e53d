"""A measured round brilliant as a CSV file: its 57 vertices, a row each."""

from __future__ import annotations

import csv
import os
import sys
from pathlib import Path

import numpy as np

from gemrender.cuts.round_brilliant import stone_from_vertices
from gemrender.cuts.round_brilliant.topology import N_VERTICES, VERTEX_LABELS
from gemrender.errors import InputError
from gemrender.reading import located_at, read_lines
from gemrender.stone import Stone
from gemrender.writing import write_whole

__all__ = ["A_CSV", "load_vertices", "save_vertices"]

_COLUMNS = ("label", "x", "y", "z")
A_CSV = f"a CSV file with {N_VERTICES} rows {', '.join(_COLUMNS)}"
_ROWS = "8 table corners, 8 star tips, 16 upper and 16 lower girdle vertices, 8 contacts, the culet"


def load_vertices(
    path: Path, *, name: str, material: str | float | None = None, toml: Path | None = None, missing: str
) -> Stone:
    """Load the vertices that a TOML file names, or a bare CSV file.

    Parameters
    ----------
    path : Path
        The CSV file.
    name : str
        What to call the stone.
    material : str or float, optional
        Its material or refractive index.
    toml : Path, optional
        The file that names it.
    missing : str
        What to say where there is no such file.

    Raises
    ------
    InputError
        It cannot be read, or makes no round brilliant.
    """
    with located_at(str(path)):
        vertices = _vertices(read_lines(path, kind="stone", missing=missing))
        return stone_from_vertices(vertices, name=name, material=material, source=str(toml or path))


def save_vertices(stone: Stone, path: str | os.PathLike[str]) -> None:
    """Write a stone's 57 vertices as CSV, with all their digits: loaded again they are equal to the last bit.

    Parameters
    ----------
    stone : Stone
        The stone; its vertices are written in its own frame [girdle radius].
    path : str or path-like
        File to write, ending in .csv, whole or not at all; a file that is there is replaced.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    rows = [
        (label, *map(repr, xyz)) for label, xyz in zip(VERTEX_LABELS, stone.vertices.tolist(), strict=True)
    ]
    text = "".join(",".join(row) + "\n" for row in (_COLUMNS, *rows))
    target = Path(path)
    try:
        write_whole(
            target.parent, {target.name: lambda made: made.write_text(text, encoding="utf-8", newline="\n")}
        )
    except InputError as error:
        raise InputError(error.allowed, source=os.fspath(path)) from error


def _vertices(lines: list[str]) -> np.ndarray:
    """Read 57 rows label, x, y, z: commas between the columns, # before comments, at most one header."""
    labels: list[str] = []
    rows: list[list[float]] = []
    keys: list[str] = []
    for number, line in enumerate(lines, start=1):
        if not line.strip(" \t,") or line.lstrip().startswith("#"):
            continue
        key = f"row {len(rows) + 1} (line {number})"
        try:
            cells = [cell.strip() for cell in next(csv.reader([line], skipinitialspace=True, strict=True))]
        except csv.Error as error:
            raise InputError(f"is not CSV: {error}", key=key) from error
        if len(cells) != len(_COLUMNS):
            raise InputError(
                f"must have the {len(_COLUMNS)} columns {', '.join(_COLUMNS)}, with commas between them and "
                f"points in decimals; has {len(cells)}",
                key=key,
            )
        if not rows and [cell[:1].lower() for cell in cells[1:]] == ["x", "y", "z"]:
            continue
        rows.append(
            [_coordinate(f"{key}, {column}", cell) for column, cell in zip("xyz", cells[1:], strict=True)]
        )
        labels.append(cells[0])
        keys.append(key)
    if len(rows) != N_VERTICES:
        raise InputError(f"must be {N_VERTICES}: {_ROWS}", key=f"{len(rows)} rows")
    if sorted(labels) == sorted(VERTEX_LABELS):
        for key, label, expected in zip(keys, labels, VERTEX_LABELS, strict=True):
            if label != expected:
                raise InputError(f"expected {expected}, got {label}", key=key)
    return np.array(rows)


def _coordinate(key: str, cell: str) -> float:
    try:
        number = float(cell if "_" not in cell else "")
    except ValueError as error:
        raise InputError("must be a number, with a point in decimals", key=key, value=cell) from error
    if not abs(number) <= sys.float_info.max:
        raise InputError("must be a finite number", key=key, value=cell)
    return number

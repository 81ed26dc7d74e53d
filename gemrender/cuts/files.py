"""Stone files: TOML that describes a stone or names its file; CSV of vertices or stones; designs and meshes.

Whatever is wrong with a file is told in one line: the file, the key, the value, and what is allowed.
"""

from __future__ import annotations

import csv
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.cuts.content import DESIGN_KINDS, SOLID_KINDS, kind_of_file
from gemrender.cuts.families import families
from gemrender.cuts.families.stated import from_values
from gemrender.cuts.families.suggest import stone_of
from gemrender.cuts.laboratory import DEFAULTS, REPORT_KEYS, missing_parts, read_report
from gemrender.cuts.load import load_design_file
from gemrender.cuts.mesh_stone import check_up
from gemrender.cuts.round_brilliant import stone_from_vertices
from gemrender.cuts.round_brilliant.proportions import ANGLE_RANGES, RANGES, RoundBrilliant, checked_values
from gemrender.cuts.round_brilliant.topology import N_VERTICES, VERTEX_LABELS
from gemrender.cuts.stones import LONGEST_NAME, OneStone, Stones
from gemrender.cuts.table import is_table, open_table
from gemrender.errors import InputError
from gemrender.mistakes import Mistakes
from gemrender.reading import LONGEST_LINE as LONGEST_LINE
from gemrender.reading import MOST_BYTES as MOST_BYTES
from gemrender.reading import (
    bundled_files,
    did_you_mean,
    located_at,
    parse_toml,
    read_lines,
    refuse_missing,
    refuse_unknown,
    section,
    stem,
    text_line,
)
from gemrender.stone import Stone
from gemrender.writing import write_whole

__all__ = ["bundled_stones", "load_stone", "load_stones", "save_vertices"]

#: Keys of each section. Of `_SHAPES`, some of which are no sections, a file has exactly one.
_SECTIONS: dict[str, tuple[str, ...]] = {
    "proportions": (
        "table", "star", "lower_girdle_contact", "crown_height", "pavilion_depth", "girdle_thickness",
    ),
    "angles": ("table", "crown_angle", "pavilion_angle", "star", "lower_half", "girdle_thickness"),
    "report": REPORT_KEYS,
    "mesh": ("file", "up"),
    "material": ("name", "index"),
}  # fmt: skip
#: What only reports state: [angles] with one of them is read as [report] is, as where it lacks the star.
_OF_REPORTS = ("depth", "girdle", "culet", "shape")
_SHAPES = ("proportions", "angles", "report", "cut", "vertices", "design", "mesh")
_TOP = ("name", *_SHAPES, "material")

_COLUMNS = ("label", "x", "y", "z")
_A_CSV = f"a CSV file with {N_VERTICES} rows {', '.join(_COLUMNS)}"
_ROWS = "8 table corners, 8 star tips, 16 upper and 16 lower girdle vertices, 8 contacts, the culet"


def load_stone(stone: str | os.PathLike[str]) -> Stone:
    """Load a stone from a file, or a bundled stone by its name.

    Parameters
    ----------
    stone : str or path-like
        A TOML stone file, a CSV file of 57 vertices (label, x, y, z, in any unit of length), a table of one
        stone, a faceter's design (.asc, .gem, .gcs), a mesh (.stl, .obj, .ply, .glb), a scan (.srn), or a
        name of `bundled_stones`. A file of that name wins over the bundled stone. What a file is, is told by
        its content, then by what its name ends in.

    Returns
    -------
    Stone
        Its `source` is the file.

    Raises
    ------
    InputError
        No such stone, a file that cannot be read, or one that makes no stone.
    """
    stones = load_stones(stone)
    if len(stones) > 1:
        raise InputError(
            f"is a table of {len(stones)} stones, a row a stone; one stone is needed here",
            source=os.fspath(stone),
        )
    return stones[0]


def load_stones(stones: str | os.PathLike[str]) -> Stones:
    """Load the stone or the stones of a file, or a bundled stone by its name.

    Parameters
    ----------
    stones : str or path-like
        What `load_stone` takes, or a table of stones, ending in .csv or .tsv: a row a stone, columns called
        as in stone files or as in laboratory reports (`table.open_table`).

    Returns
    -------
    Stones
        A sequence of `Stone`, checked whole. The stones of a table are made when they are asked for.

    Raises
    ------
    InputError
        As `load_stone`; of a table, the first bad row is told.
    """
    path = _find(os.fspath(stones))
    # A file that cannot be read is told by who reads it.
    kind = kind_of_file(path) or path.suffix.lower().lstrip(".")
    if kind == "tsv" or (kind == "csv" and is_table(path)):
        return open_table(path, missing=_no_such_file(path))
    if kind == "csv":
        return OneStone(_measured(path, name=stem(path, "stone")))
    if kind in (*DESIGN_KINDS, *SOLID_KINDS):
        return OneStone(load_design_file(path, missing=_no_such_file(path)))
    return OneStone(_from_toml(path))


def bundled_stones() -> list[str]:
    """Return the names of the stones that come with gemrender, in alphabetical order."""
    return sorted(bundled_files(""))


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


# ---- Finding files -------------------------------------------------------------------------------------


def _find(stone: str) -> Path:
    path, bundled = Path(stone), bundled_files("")
    if not stone.strip():
        raise InputError(
            f"must be a stone file or one of {', '.join(sorted(bundled))}", key="stone", value=stone
        )
    if stone in bundled and not path.is_file():  # a folder of that name may well hold earlier results
        return bundled[stone]
    return path


def _no_such_file(path: Path) -> str:
    if path.name != str(path):
        return "no such file"
    names = bundled_stones()
    return f"no such file; the bundled stones are {', '.join(names)}{did_you_mean(path.stem, names)}"


# ---- TOML ----------------------------------------------------------------------------------------------


def _from_toml(path: Path) -> Stone:
    source = str(path)
    with located_at(source), Mistakes() as mistakes:
        top = parse_toml(read_lines(path, kind="stone", missing=_no_such_file(path)), kind="stone")
        mistakes.of(refuse_unknown, top, _TOP, hint=_home)
        name = mistakes.of(text_line, top, "name", stem(path, "stone"), LONGEST_NAME)
        material = mistakes.of(_material, top, mistakes)
        given = [key for key in _SHAPES if key in top]
        if not given and any(key not in _TOP for key in top):  # one of them misspelt
            mistakes.refuse()
        if len(given) != 1:
            raise InputError(
                "needs exactly one of [proportions], [angles], [report], [cut], vertices, design and mesh; "
                f"has {' and '.join(given) or 'none'}"
            )
        shape = given[0]
        if shape == "cut":
            cut, taken = _cut(top["cut"])
        elif shape == "vertices":
            vertices = _named_file(top["vertices"], path, "vertices", _A_CSV)
        elif shape == "design":
            design = _named_file(top["design"], path, "design", _a_file(DESIGN_KINDS))
        elif shape == "mesh":
            mesh, up = _mesh(top, path, mistakes)
        else:
            proportions, assumed = _proportions(top, shape, mistakes)
    if shape == "cut":
        with located_at(source, shape):
            return stone_of(
                cut, name=str(name), material=material, source=source, description=shape, assumed=taken
            )
    if shape == "vertices":
        return _measured(vertices, name=str(name), material=material, toml=path)
    if shape in ("design", "mesh"):
        return load_design_file(
            design if shape == "design" else mesh,
            name=str(name),
            material=material,
            up=None if shape == "design" else up,
            source=source,
            kinds=DESIGN_KINDS if shape == "design" else SOLID_KINDS,
            missing=f"no such file; named by {shape} in {path}",
        )
    assert proportions is not None
    with located_at(source, shape):
        return Stone.from_proportions(
            proportions,
            name=str(name),
            material=material,
            source=source,
            description=shape,
            assumed=assumed,
        )


def _proportions(top: dict[str, Any], shape: str, mistakes: Mistakes) -> tuple[Any, tuple[str, ...]]:
    """Return the cut that a section gives, and what was assumed; none where it has mistakes."""
    before = len(mistakes.errors)
    is_report = shape == "report" or (shape == "angles" and _is_report(top[shape]))
    keys = REPORT_KEYS if is_report else _SECTIONS[shape]
    values = section(top, shape, keys, _home, mistakes)
    misspelt = len(mistakes.errors) > before

    def made() -> tuple[Any, tuple[str, ...]]:
        with located_at(None, shape):
            if is_report:
                checked_values({key: value for key, value in values.items() if _has_range(key, value)})
                if missing_parts(values):
                    return None, ()
                report = read_report(values)
                return report.cut, tuple(map(str, report.assumed))
            if len(values) == len(keys):
                make = RoundBrilliant if shape == "proportions" else RoundBrilliant.from_angles
                return make(**values), ()
            checked_values(values)
            return None, ()

    found = mistakes.of(made)
    if not misspelt:
        if not is_report:
            refuse_missing(values, keys, shape)
        elif missing := missing_parts(values):
            raise InputError(f"needs {missing}", key=f"[{shape}]")
    return found or (None, ())


def _has_range(key: str, value: object) -> bool:
    """Return whether a value of a report is a number with a range of its own; a girdle may be words."""
    return key in RANGES | ANGLE_RANGES and not (key == "girdle_thickness" and isinstance(value, str))


def _is_report(angles: object) -> bool:
    """Return whether [angles] states, or leaves out, what a report does, and so is read as one."""
    return isinstance(angles, dict) and (
        any(key in angles for key in _OF_REPORTS)
        or isinstance(angles.get("girdle_thickness"), str)
        # One that is misspelt is not missing.
        or (not all(key in angles for key in DEFAULTS) and all(key in _SECTIONS["angles"] for key in angles))
    )


def _home(key: str) -> str:
    """Say which sections a key belongs in, if any."""
    homes = [f"[{name}]" for name, keys in _SECTIONS.items() if key in keys]
    return f"; it belongs in {' or '.join(homes)}" if homes else ""


def _material(top: dict[str, Any], mistakes: Mistakes) -> str | float | None:
    """Return the material's name or index; whether there is such a material is for the optics to say."""
    if "material" not in top:
        return None
    before = len(mistakes.errors)
    material = section(top, "material", _SECTIONS["material"], _home, mistakes)
    if len(material) != 1:
        if not material and len(mistakes.errors) > before:  # one of them misspelt
            return None
        raise InputError(
            f"needs exactly one of name and index; has {'both' if material else 'none'}", key="[material]"
        )
    if "name" in material:
        name = material["name"]
        if not isinstance(name, str) or not name.strip():
            raise InputError("must be the name of a material, in quotes", key="material.name", value=name)
        return name
    index = material["index"]
    number = isinstance(index, (int, float)) and not isinstance(index, bool)
    if not number or not 1 < index <= sys.float_info.max:  # false for NaN too
        raise InputError("must be a finite number above 1", key="material.index", value=index)
    return float(index)


def _mesh(top: dict[str, Any], toml: Path, mistakes: Mistakes) -> tuple[Path, str | None]:
    """Return the mesh that a file names, by `mesh = "file.stl"` or in a section, and its way up."""
    if not isinstance(top["mesh"], dict):
        return _named_file(top["mesh"], toml, "mesh", _a_file(SOLID_KINDS) + ", or a section [mesh]"), None
    values = section(top, "mesh", _SECTIONS["mesh"], _home, mistakes)
    refuse_missing(values, ("file",), "mesh")
    up = values.get("up")
    check_up(up, "mesh.up")
    return _named_file(values["file"], toml, "mesh.file", _a_file(SOLID_KINDS)), up


def _cut(values: object) -> tuple[Any, tuple[str, ...]]:
    """Return the cut that [cut] describes, a family by its name and its parameters, and what was taken."""
    known = families()
    allowed = ", ".join(f'"{name}"' for name in known)
    with located_at(None, "cut"):
        if not isinstance(values, dict) or "family" not in values:
            raise InputError(f"missing; must be one of {allowed}", key="family")
        family = values["family"]
        name = " ".join(str(family).lower().replace("-", " ").replace("_", " ").split())
        if name not in known:
            raise InputError(
                f"must be one of {allowed}{did_you_mean(name, list(known))}", key="family", value=family
            )
        return from_values(known[name], {key: value for key, value in values.items() if key != "family"})


def _named_file(value: object, toml: Path, key: str, what: str) -> Path:
    if not isinstance(value, str) or not value.strip():
        raise InputError(f"must be the name of {what}", key=key, value=value)
    return toml.parent / value


def _a_file(kinds: tuple[str, ...]) -> str:
    return "a file " + ", ".join(f".{kind}" for kind in kinds)


# ---- CSV -----------------------------------------------------------------------------------------------


def _measured(
    path: Path, *, name: str, material: str | float | None = None, toml: Path | None = None
) -> Stone:
    """Load the vertices that a TOML file names, or a bare CSV file."""
    source = str(path)
    missing = _no_such_file(path) if toml is None else f"no such file; named by vertices in {toml}"
    with located_at(source):
        vertices = _vertices(read_lines(path, kind="stone", missing=missing))
        return stone_from_vertices(vertices, name=name, material=material, source=str(toml or path))


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

"""Stone files: TOML that describes a stone or names its file; CSV of vertices or stones; designs and meshes.

Whatever is wrong with a file is told in one line: the file, the key, the value, and what is allowed.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

from gemrender.cuts.bundled import bundled_stones, find_stone, no_such_stone
from gemrender.cuts.content import DESIGN_KINDS, SOLID_KINDS, kind_of_file
from gemrender.cuts.crystal_axes import CRYSTAL_KEYS, read_orientation
from gemrender.cuts.families import families
from gemrender.cuts.families.stated import from_values, stated_keys
from gemrender.cuts.families.suggest import stone_of
from gemrender.cuts.fancy_reports import fancy_keys, fancy_stone
from gemrender.cuts.laboratory import DEFAULTS, REPORT_KEYS, missing_parts, read_report
from gemrender.cuts.load import load_design_file
from gemrender.cuts.measurements import SIZE_KEYS, read_size
from gemrender.cuts.mesh_stone import check_up
from gemrender.cuts.round_brilliant.proportions import ANGLE_RANGES, RANGES, RoundBrilliant, checked_values
from gemrender.cuts.shape_words import read_shape
from gemrender.cuts.size import StatedSize
from gemrender.cuts.stones import LONGEST_NAME, OneStone, Stones
from gemrender.cuts.table import is_table, open_table
from gemrender.cuts.vertices import A_CSV, load_vertices, save_vertices
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
from gemrender.stone import Orientation, Stone

__all__ = ["bundled_stones", "load_stone", "load_stones", "read_cut", "save_vertices"]

#: Keys of each section. Of `_SHAPES`, some of which are no sections, a file has exactly one.
_SECTIONS: dict[str, tuple[str, ...]] = {
    "proportions": (
        "table", "star", "lower_girdle_contact", "crown_height", "pavilion_depth", "girdle_thickness",
    ),
    "angles": ("table", "crown_angle", "pavilion_angle", "star", "lower_half", "girdle_thickness"),
    "report": REPORT_KEYS,
    "mesh": ("file", "up"),
    "material": ("name", "index"),
    "size": SIZE_KEYS,
    "crystal": CRYSTAL_KEYS,
}  # fmt: skip
#: What only reports state: [angles] with one of them is read as [report] is, as where it lacks the star.
_OF_REPORTS = ("depth", "girdle", "culet", "shape")
_SHAPES = ("proportions", "angles", "report", "cut", "vertices", "design", "mesh")
_TOP = ("name", *_SHAPES, "material", "size", "crystal")


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
    given = os.fspath(stones)
    path = find_stone(given)
    if path == bundled_files("").get(given):
        return OneStone(_bundled(path))
    # A file that cannot be read is told by who reads it.
    kind = kind_of_file(path) or path.suffix.lower().lstrip(".")
    if kind == "tsv" or (kind == "csv" and is_table(path)):
        return open_table(path, missing=no_such_stone(path))
    if kind == "csv":
        return OneStone(load_vertices(path, name=stem(path, "stone"), missing=no_such_stone(path)))
    if kind in (*DESIGN_KINDS, *SOLID_KINDS):
        return OneStone(load_design_file(path, missing=no_such_stone(path)))
    return OneStone(_from_toml(path))


# ---- TOML ----------------------------------------------------------------------------------------------


@cache
def _bundled(path: Path) -> Stone:
    """Return a bundled stone: one object, whose corners are found once."""
    return _from_toml(path)


def _from_toml(path: Path) -> Stone:
    source = str(path)
    size: StatedSize | None = None
    made: _Made | None = None
    with located_at(source), Mistakes() as mistakes:
        top = parse_toml(read_lines(path, kind="stone", missing=no_such_stone(path)), kind="stone")
        mistakes.of(refuse_unknown, top, _TOP, hint=_home)
        name = mistakes.of(text_line, top, "name", stem(path, "stone"), LONGEST_NAME)
        material = mistakes.of(_material, top, mistakes)
        if "size" in top:
            size = mistakes.of(_size, top, mistakes)
        crystal = mistakes.of(_crystal, top, mistakes)
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
            made = _cut(top["cut"], size, source)
        elif shape == "vertices":
            vertices = _named_file(top["vertices"], path, "vertices", A_CSV)
        elif shape == "design":
            design = _named_file(top["design"], path, "design", _a_file(DESIGN_KINDS))
        elif shape == "mesh":
            mesh, up = _mesh(top, path, mistakes)
        else:
            made = _reported(top, shape, size, source, mistakes)
    agreed: tuple[str, ...] = ()
    if shape == "vertices":
        missing = f"no such file; named by vertices in {path}"
        stone = load_vertices(vertices, name=str(name), material=material, toml=path, missing=missing)
    elif shape in ("design", "mesh"):
        stone = load_design_file(
            design if shape == "design" else mesh,
            name=str(name),
            material=material,
            up=None if shape == "design" else up,
            source=source,
            kinds=DESIGN_KINDS if shape == "design" else SOLID_KINDS,
            missing=f"no such file; named by {shape} in {path}",
        )
    else:
        assert made is not None
        make, agreed = made
        with located_at(source, shape):
            stone = make(name=str(name), material=material, source=source, description=shape)
    if crystal is not None:
        stone = replace(stone, crystal=crystal)
    if size is None:
        return stone
    with located_at(source, "size"):
        return size.sized(stone, agreed)


#: What makes the stone of its facts, and the proportions that agree with the millimetres.
_Made = tuple[Callable[..., Stone], tuple[str, ...]]


def _reported(
    top: dict[str, Any], shape: str, size: StatedSize | None, source: str, mistakes: Mistakes
) -> _Made | None:
    """Return what makes the stone of [report], [angles] or [proportions]; nothing where it has mistakes."""
    is_report = shape == "report" or (shape == "angles" and _is_report(top[shape]))
    if is_report and isinstance(top[shape], dict) and "shape" in top[shape]:
        with located_at(None, shape):
            word = read_shape(str(top[shape]["shape"]))
        if not word.is_round_brilliant:
            values = section(top, shape, fancy_keys(word.kind), _home, mistakes)
            return (
                lambda **facts: fancy_stone(word, values, size, size_source=source, **facts)[0],
                stated_keys(word.kind),
            )
    return _round_brilliant(top, shape, is_report, size, source, mistakes)


def _round_brilliant(
    top: dict[str, Any],
    shape: str,
    is_report: bool,
    size: StatedSize | None,
    source: str,
    mistakes: Mistakes,
) -> _Made | None:
    before = len(mistakes.errors)
    keys = REPORT_KEYS if is_report else _SECTIONS[shape]
    values = section(top, shape, keys, _home, mistakes)
    misspelt = len(mistakes.errors) > before
    by_size: dict[str, float] = {}
    if is_report and size is not None:
        with located_at(None, "size"):
            by_size = size.depth_of_round(values)

    def made() -> _Made | None:
        with located_at(None, shape), nullcontext() if size is None else size.blamed(by_size, source):
            if is_report:
                checked_values({key: value for key, value in values.items() if _has_range(key, value)})
                if missing_parts(values | by_size):
                    return None
                report = read_report(values | by_size)
                assumed = tuple(map(str, report.assumed))
                return partial(stone_of, report.cut, assumed=assumed), ("depth",)
            if len(values) == len(keys):
                make = RoundBrilliant if shape == "proportions" else RoundBrilliant.from_angles
                return partial(stone_of, make(**values)), ()
            checked_values(values)
            return None

    found = mistakes.of(made)
    if not misspelt:
        if not is_report:
            refuse_missing(values, keys, shape)
        elif missing := missing_parts(values | by_size):
            raise InputError(f"needs {missing}", key=f"[{shape}]")
    return found


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


def _size(top: dict[str, Any], mistakes: Mistakes) -> StatedSize | None:
    before = len(mistakes.errors)
    values = section(top, "size", _SECTIONS["size"], _home, mistakes)
    if not values and len(mistakes.errors) > before:  # one of them misspelt
        return None
    with located_at(None, "size"):
        return read_size(values)


def _crystal(top: dict[str, Any], mistakes: Mistakes) -> Orientation | None:
    """Return how the crystal lies; None where a file does not say it, and where there are mistakes."""
    if "crystal" not in top:
        return None
    before = len(mistakes.errors)
    values = section(top, "crystal", CRYSTAL_KEYS, _home, mistakes)
    if len(mistakes.errors) > before:
        return None
    if len(values) != 1:
        return read_orientation(values)  # refused: the section as a whole
    with located_at(None, "crystal"):
        return read_orientation(values)


def _mesh(top: dict[str, Any], toml: Path, mistakes: Mistakes) -> tuple[Path, str | None]:
    """Return the mesh that a file names, by `mesh = "file.stl"` or in a section, and its way up."""
    if not isinstance(top["mesh"], dict):
        return _named_file(top["mesh"], toml, "mesh", _a_file(SOLID_KINDS) + ", or a section [mesh]"), None
    values = section(top, "mesh", _SECTIONS["mesh"], _home, mistakes)
    refuse_missing(values, ("file",), "mesh")
    up = values.get("up")
    check_up(up, "mesh.up")
    return _named_file(values["file"], toml, "mesh.file", _a_file(SOLID_KINDS)), up


def read_cut(values: object) -> tuple[Any, tuple[str, ...]]:
    """Return the cut that a section [cut] describes, by its family and parameters, and what was taken.

    Raises
    ------
    InputError
        No such family, or what `from_values` refuses.
    """
    kind, stated = _stated_cut(values)
    with located_at(None, "cut"):
        return from_values(kind, stated)


def _cut(values: object, size: StatedSize | None, source: str) -> _Made:
    """Return what makes the stone of [cut], with the proportions that its millimetres give."""
    kind, stated = _stated_cut(values)
    by_size: dict[str, float] = {}
    if size is not None:
        with located_at(None, "size"):
            by_size = size.proportions(kind, stated)
    with located_at(None, "cut"), nullcontext() if size is None else size.blamed(by_size, source):
        cut, assumed = from_values(kind, stated | by_size)
    return partial(stone_of, cut, assumed=assumed), stated_keys(kind)


def _stated_cut(values: object) -> tuple[Any, dict[str, Any]]:
    """Return the family that [cut] names, and what it states of the cut."""
    known = families()
    allowed = ", ".join(f'"{name}"' for name in known)
    with located_at(None, "cut"):
        if not isinstance(values, dict) or "family" not in values:
            raise InputError(f"missing; must be one of {allowed}", key="family")
        family = values["family"]
        folded = " ".join(str(family).casefold().replace("-", " ").replace("_", " ").split())
        kind = {name.casefold(): kind for name, kind in known.items()}.get(folded)
        if kind is None:
            guess = did_you_mean(folded, list(known))
            raise InputError(f"must be one of {allowed}{guess}", key="family", value=family)
    return kind, {key: value for key, value in values.items() if key != "family"}


def _named_file(value: object, toml: Path, key: str, what: str) -> Path:
    if not isinstance(value, str) or not value.strip():
        raise InputError(f"must be the name of {what}", key=key, value=value)
    return toml.parent / value


def _a_file(kinds: tuple[str, ...]) -> str:
    return "a file " + ", ".join(f".{kind}" for kind in kinds)

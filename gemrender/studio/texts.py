"""Designs and stone files as text, and files that were dropped on a page; no path of the user's is opened."""

from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from functools import lru_cache
from pathlib import Path, PurePosixPath

from gemrender.cuts import load_stones
from gemrender.cuts.asc import read_asc, write_asc
from gemrender.cuts.content import HEAD, kind_of
from gemrender.cuts.convert import WRITTEN_KINDS, save_stone
from gemrender.cuts.design import Design
from gemrender.cuts.stone_file import stone_file_text
from gemrender.errors import InputError
from gemrender.optics.materials import material_names, normal_name
from gemrender.reading import parse_toml
from gemrender.stone import Stone

__all__ = [
    "MOST_BYTES", "SAVED_KINDS", "asc_text", "design_of_text", "dropped_stones", "is_number",
    "known_material", "saved",
]  # fmt: skip

#: Largest file that is taken [bytes]: meshes and scans have a few megabytes.
MOST_BYTES = 32 * 1024 * 1024
#: Most stones that a dropped table may have.
MOST_STONES = 200
#: Kinds that a stone is saved as.
SAVED_KINDS = ("toml", *WRITTEN_KINDS)
#: Keys of a stone file that name other files, and a section whose name may be one.
_NAMES_FILES = ("design", "mesh", "vertices")


def known_material(material: object) -> str | float | None:
    """Return a material that a page may ask for: by a name that is known, never a file.

    Raises
    ------
    InputError
        It is no such name, and no number above 1.
    """
    if material is None:
        return None
    if isinstance(material, str):
        if normal_name(material) not in material_names():
            raise InputError("must be the name of a material", key="material", value=material)
        return material
    if not is_number(material) or not 1.0 < float(material) < 10.0:  # type: ignore[arg-type]
        raise InputError("must be a refractive index above 1", key="material", value=material)
    return float(material)  # type: ignore[arg-type]


def is_number(value: object) -> bool:
    """Tell whether a value of a message is a finite number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def asc_text(design: Design) -> str:
    """Return a design as the text of an .asc file."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "design.asc")
        write_asc(design, file)
        return file.read_text(encoding="utf-8")


@lru_cache(maxsize=8)
def design_of_text(text: str) -> Design:
    """Return the design of the text of an .asc file.

    Raises
    ------
    InputError
        It is none.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "design.asc")
        file.write_text(text, encoding="utf-8")
        try:
            return read_asc(file)
        except InputError as error:
            raise InputError(error.allowed, source="design", key=error.key) from error


def dropped_stones(name: str, data: bytes) -> list[Stone]:
    """Return the stones of a file's bytes, told by content as files are.

    Parameters
    ----------
    name : str
        What the file is called on the other side; only its last part is used, in words.
    data : bytes
        What is in it.

    Raises
    ------
    InputError
        It is too large, names other files, or makes no stones.
    """
    shown = PurePosixPath(name.replace("\\", "/")).name[:80] or "file"
    if len(data) > MOST_BYTES:
        raise InputError(f"is larger than {MOST_BYTES} bytes", source=shown)
    suffix = PurePosixPath(shown).suffix.lower()
    if kind_of(data[:HEAD], len(data), suffix) == "toml":
        _refuse_files(shown, data)
    with tempfile.TemporaryDirectory() as folder:
        safe = "".join(c for c in suffix if c.isalnum() or c == ".")[:8]
        file = Path(folder, f"dropped{safe}")
        file.write_bytes(data)
        try:
            stones = load_stones(file)
            if len(stones) > MOST_STONES:
                raise InputError(f"is a table of {len(stones)} stones; at most {MOST_STONES} are taken")
            found = list(stones)
        except InputError as error:
            raise InputError(error.allowed, source=shown, key=error.key, value=error.value) from error
    return [_named(stone, shown) for stone in found]


def _refuse_files(shown: str, data: bytes) -> None:
    """Refuse a stone file that names other files: they would be looked for on this machine."""
    lines = data.decode("utf-8-sig", errors="replace").splitlines()
    top = parse_toml(lines, kind="stone")
    for key in _NAMES_FILES:
        if key in top:
            raise InputError("names another file; open that one itself", source=shown, key=key)
    material = top.get("material")
    named = material.get("name") if isinstance(material, dict) else None
    if isinstance(named, str):
        try:
            known_material(named)
        except InputError as error:
            raise InputError(error.allowed, source=shown, key="material.name", value=named) from error


def _named(stone: Stone, shown: str) -> Stone:
    own = stone.name if not stone.name.startswith("dropped") else PurePosixPath(shown).stem
    return replace(stone, name=own or "stone", source=None)


def saved(stone: Stone, kind: str) -> bytes:
    """Return a stone as the bytes of a file of a kind.

    Raises
    ------
    InputError
        There is no such kind, or it cannot hold the stone.
    BackendError
        A library that the kind needs is not installed; says the cure.
    """
    if kind not in SAVED_KINDS:
        raise InputError(f"must be one of {', '.join(SAVED_KINDS)}", key="kind", value=kind)
    if kind == "toml":
        return stone_file_text(stone).encode()
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, f"stone.{kind}")
        try:
            save_stone(stone, file)
        except InputError as error:
            raise InputError(error.allowed, key=error.key) from error
        return file.read_bytes()

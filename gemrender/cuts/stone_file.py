"""Stone files written: a round brilliant's proportions, the parameters of a family, or a design beside it."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from gemrender.cuts.asc import write_asc
from gemrender.cuts.convert import design_of
from gemrender.cuts.crystal_axes import crystal_lines
from gemrender.cuts.design import Design
from gemrender.cuts.families.family import Family
from gemrender.errors import InputError
from gemrender.stone import Stone
from gemrender.writing import write_whole

__all__ = ["save_stone_file", "stone_file_text"]


def stone_file_text(stone: Stone, *, comments: tuple[str, ...] = (), design: str = "") -> str:
    """Return the stone file of a stone that was made from proportions or of a family, with all digits.

    Parameters
    ----------
    stone : Stone
        The stone.
    comments : tuple of str
        Lines that stand above it.
    design : str
        Of a stone that was made from a design, the name of the file that holds it.

    Raises
    ------
    InputError
        It was made from none of them, or the design's file has no name.
    """
    if design and isinstance(stone.cut, Design):
        section, values = "", {"design": design}
    elif stone.proportions is not None:
        section, values = "proportions", dict(asdict(stone.proportions))
    elif isinstance(stone.cut, Family):
        section, values = "cut", {"family": stone.cut.family(), **stone.cut.values()}
    else:
        raise InputError(
            "was made neither from proportions nor of a family", source=stone.source or stone.name
        )
    lines = [f"# {line}" for line in comments]
    lines += [f"name = {_toml(stone.name)}", *(["", f"[{section}]"] if section else [])]
    lines += [f"{key} = {_toml(value)}" for key, value in values.items()]
    if stone.material is not None:
        key = "name" if isinstance(stone.material, str) else "index"
        lines += ["", "[material]", f"{key} = {_toml(stone.material)}"]
    if stone.size_mm is not None:
        lines += ["", "[size]", f"length_mm = {_toml(stone.size_mm)}"]
    if stone.crystal is not None:
        lines += crystal_lines(stone.crystal)
    return "\n".join(lines) + "\n"


def save_stone_file(stone: Stone, path: str | os.PathLike[str], *, comments: tuple[str, ...] = ()) -> None:
    """Write the stone file of a stone, whole or not at all; errors as of `stone_file_text`.

    Of a stone that was made from a design it names the design, which is written beside it as an .asc file of
    the same name.
    """
    target = Path(path)
    beside = target.with_suffix(".asc").name if isinstance(stone.cut, Design) else ""
    text = stone_file_text(stone, comments=comments, design=beside)
    writers: dict[str, Callable[[Path], object]] = {}
    if beside:
        writers[beside] = partial(write_asc, design_of(stone)[0])
    writers[target.name] = lambda made: made.write_text(text, encoding="utf-8", newline="\n")
    write_whole(target.parent, writers)


def _toml(value: Any) -> str:
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    return repr(value)

"""Stone files written: a round brilliant's proportions, or the parameters of a family."""

from __future__ import annotations

import os
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gemrender.cuts.families.family import Family
from gemrender.errors import InputError
from gemrender.stone import Stone
from gemrender.writing import write_whole

__all__ = ["save_stone_file", "stone_file_text"]


def stone_file_text(stone: Stone, *, comments: tuple[str, ...] = ()) -> str:
    """Return the stone file of a stone that was made from proportions or of a family, with all digits.

    Parameters
    ----------
    stone : Stone
        The stone.
    comments : tuple of str
        Lines that stand above it.

    Raises
    ------
    InputError
        It was made from neither.
    """
    if stone.proportions is not None:
        section, values = "proportions", dict(asdict(stone.proportions))
    elif isinstance(stone.cut, Family):
        section, values = "cut", {"family": stone.cut.family(), **stone.cut.values()}
    else:
        raise InputError(
            "was made neither from proportions nor of a family", source=stone.source or stone.name
        )
    lines = [f"# {line}" for line in comments]
    lines += [f"name = {_toml(stone.name)}", "", f"[{section}]"]
    lines += [f"{key} = {_toml(value)}" for key, value in values.items()]
    if stone.material is not None:
        key = "name" if isinstance(stone.material, str) else "index"
        lines += ["", "[material]", f"{key} = {_toml(stone.material)}"]
    if stone.size_mm is not None:
        lines += ["", "[size]", f"length_mm = {_toml(stone.size_mm)}"]
    return "\n".join(lines) + "\n"


def save_stone_file(stone: Stone, path: str | os.PathLike[str], *, comments: tuple[str, ...] = ()) -> None:
    """Write the stone file of a stone, whole or not at all; errors as of `stone_file_text`."""
    text, target = stone_file_text(stone, comments=comments), Path(path)
    write_whole(
        target.parent, {target.name: lambda made: made.write_text(text, encoding="utf-8", newline="\n")}
    )


def _toml(value: Any) -> str:
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    return repr(value)

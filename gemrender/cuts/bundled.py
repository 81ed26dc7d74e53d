"""The stones that come with gemrender, found by their names."""

from __future__ import annotations

from pathlib import Path

from gemrender.errors import InputError
from gemrender.reading import bundled_files, did_you_mean

__all__ = ["bundled_stones", "find_stone", "no_such_stone"]

#: How to see all of them.
_SEE = "(see: gemrender stones)"


def bundled_stones() -> list[str]:
    """Return the names of the stones that come with gemrender, in alphabetical order."""
    return sorted(bundled_files(""))


def find_stone(stone: str) -> Path:
    """Return the file of a bundled stone by its name; anything else is a path. A file of that name wins.

    Raises
    ------
    InputError
        The name is blank.
    """
    path, bundled = Path(stone), bundled_files("")
    if not stone.strip():
        raise InputError(f"must be a stone file or a bundled stone {_SEE}", key="stone", value=stone)
    if stone in bundled and not path.is_file():  # a folder of that name may well hold earlier results
        return bundled[stone]
    return path


def no_such_stone(path: Path) -> str:
    """Return what to say where there is no such file, and, of a bare name, no such bundled stone."""
    if path.name != str(path):
        return "no such file"
    return f"no such file, and no bundled stone {_SEE}{did_you_mean(path.stem, bundled_stones(), most=3)}"

"""A stone as it is given: itself, the name of a bundled one, or a file."""

from __future__ import annotations

import os
from typing import TypeAlias, Union

from gemrender.cuts.files import load_stone
from gemrender.errors import InputError
from gemrender.stone import Stone

__all__ = ["StoneLike", "as_stone"]

#: A stone, the name of a bundled one, or a stone file.
StoneLike: TypeAlias = Union["Stone", str, os.PathLike[str]]


def as_stone(stone: StoneLike) -> Stone:
    """Return a stone as it is, or the one that `load_stone` loads.

    Raises
    ------
    InputError
        It is none of them, or as for `load_stone`.
    """
    if isinstance(stone, Stone):
        return stone
    if isinstance(stone, (str, os.PathLike)):
        return load_stone(stone)
    raise InputError("must be a stone, a name or a file", key="stone", value=stone)

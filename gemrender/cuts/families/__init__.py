"""Families of cuts: each file here is one, from a few parameters to a stone.

A family is a file with the family's name, `FAMILY`, and a frozen dataclass, `Parameters`, whose fields are
made by `parameter` and whose method `stone` makes the stone. Stone files name it: `[cut] family = "..."`.
Nothing else has to be told of a new file; `docs/adding-a-cut.md` shows one.
"""

from __future__ import annotations

import importlib
import pkgutil
from functools import lru_cache
from typing import Any

__all__ = ["families"]


@lru_cache(maxsize=1)
def families() -> dict[str, Any]:
    """Return the class of parameters of each family, by the family's name."""
    found = {}
    for module in pkgutil.iter_modules(__path__):
        file = importlib.import_module(f"{__name__}.{module.name}")
        if hasattr(file, "FAMILY"):
            found[file.FAMILY] = file.Parameters
    return found

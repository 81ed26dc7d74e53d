"""How results show themselves: each says that it can, and the report, high above, is loaded to do it.

It is the one way back from below, as pandas has for its plots: what draws is looked up when it is asked for.
"""

from __future__ import annotations

import importlib
from typing import Any

__all__ = ["Shown", "Tabled", "library", "plots"]


class Shown:
    """What notebooks show as HTML."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        """Return what notebooks show."""
        return str(importlib.import_module("gemrender.report.notebook").html_of(self))


class Tabled(Shown):
    """What is a table too."""

    __slots__ = ()

    def to_pandas(self) -> Any:
        """Return a pandas DataFrame, with the columns and the rows of the command's `--format csv`.

        Several make one table: `pandas.concat([a.to_pandas(), b.to_pandas()])`.

        Raises
        ------
        BackendError
            pandas is not installed.
        """
        records = importlib.import_module("gemrender.report.records").records_of(self)
        return library("pandas").DataFrame(records)


def plots() -> Any:
    """Return the module that draws results onto matplotlib's axes."""
    return importlib.import_module("gemrender.report.plots")


def library(name: str) -> Any:
    """Import a library that only some need.

    Raises
    ------
    BackendError
        It is not installed; with the cure.
    """
    from gemrender.errors import BackendError

    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise BackendError(f"{name} is needed for this; to get it: pip install {name}") from error

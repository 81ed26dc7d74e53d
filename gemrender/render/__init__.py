"""Mitsuba at work: variants, maps and paths by it, pictures and films. Called, it renders a picture.

::

    picture = gemrender.render("inoue-3", setup="velvet")
"""

from __future__ import annotations

import inspect
import sys
from types import ModuleType
from typing import Any

from gemrender.render.from_python import render

__all__ = ["render"]


class _CallablePackage(ModuleType):
    """The package, under whose name users find the function; what is in it stays where it is."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """Render a picture; see the package's signature, and `gemrender.render.render`."""
        return render(*arguments, **options)


_package = sys.modules[__name__]
_package.__class__ = _CallablePackage
_package.__signature__ = inspect.signature(render)  # type: ignore[attr-defined]
_package.__doc__ = render.__doc__

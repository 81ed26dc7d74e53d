"""Many stones, or many views: studies over draws of one stone, and over its poses."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gemrender.sweep.symmetry import SymmetryStudy, check_study, study_symmetry
    from gemrender.sweep.tilt import TiltStudy, study_tilt

__all__ = ["SymmetryStudy", "TiltStudy", "check_study", "study_symmetry", "study_tilt"]


def __getattr__(name: str) -> Any:
    """Import a study when it is asked for: every process for work imports `gemrender.sweep.workers` first."""
    if name in __all__:
        module = "tilt" if "tilt" in name.lower() else "symmetry"
        return getattr(importlib.import_module(f"gemrender.sweep.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

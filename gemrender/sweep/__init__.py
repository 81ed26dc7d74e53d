"""Many stones: studies over draws of one stone."""

from __future__ import annotations

from gemrender.sweep.symmetry import SymmetryStudy, check_study, study_symmetry

__all__ = ["SymmetryStudy", "check_study", "study_symmetry"]

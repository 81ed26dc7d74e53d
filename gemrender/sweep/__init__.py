"""Many stones, or many views: studies over draws of one stone, and over its poses."""

from __future__ import annotations

from gemrender.sweep.symmetry import SymmetryStudy, check_study, study_symmetry
from gemrender.sweep.tilt import TiltStudy, study_tilt

__all__ = ["SymmetryStudy", "TiltStudy", "check_study", "study_symmetry", "study_tilt"]

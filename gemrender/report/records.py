"""Results as flat records, whatever they are: the rows that the command line writes as CSV."""

from __future__ import annotations

import importlib
from typing import Any

__all__ = ["records_of"]

#: By the names of the results' classes, what makes their records.
_MAKERS = {
    "Score": ("tables", "score_record"),
    "StereoScore": ("tables", "stereo_record"),
    "Sensitivity": ("sensitivity", "sensitivity_records"),
    "TiltStudy": ("tilt", "tilt_records"),
    "SymmetryStudy": ("symmetry", "study_records"),
    "ToleranceStudy": ("tolerance", "tolerance_records"),
    "Improvement": ("improve", "improvement_records"),
    "Front": ("improve", "improvement_records"),
}


def records_of(result: Any) -> list[dict[str, Any]]:
    """Return a score, a study or a search as records, one a row."""
    module, function = _MAKERS[type(result).__name__]
    made = getattr(importlib.import_module(f"gemrender.report.{module}"), function)(result)
    return made if isinstance(made, list) else [made]

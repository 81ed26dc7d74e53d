"""Measures of light return: functions of paths, one file a measure."""

from __future__ import annotations

from gemrender.measures.evaluate import contributions, evaluate
from gemrender.measures.measure import HEAD_DEG, Light, Measure
from gemrender.measures.registry import chosen_measures, measure_named, measures

__all__ = [
    "HEAD_DEG",
    "Light",
    "Measure",
    "chosen_measures",
    "contributions",
    "evaluate",
    "measure_named",
    "measures",
]

"""See, measure and improve how a cut stone handles light.

::

    import gemrender

    result = gemrender.score("inoue-3")
    print(result.average, result.rear)

Importing the package imports no Mitsuba and sets no variant; `gemrender.mitsuba` does both.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from gemrender.engines import observe, trace_paths
from gemrender.errors import BackendError, GemrenderError, GemrenderWarning, InputError
from gemrender.render import import_order as _import_order

# At once, not on demand: the function has its module's name, and must be bound after the module. `render`,
# the package, is itself called.
from gemrender.scoring import Score, score

if TYPE_CHECKING:
    from gemrender.beam import VirtualFacets, trace_facets
    from gemrender.beam.sensitivity import sensitivity
    from gemrender.cuts import (
        RoundBrilliant,
        bundled_stones,
        load_stone,
        load_stones,
        save_stone,
        stone_from_vertices,
        vary,
    )
    from gemrender.cuts.families import families
    from gemrender.mapping import measure_maps
    from gemrender.measures import Measure
    from gemrender.measures.maps import MeasureMaps
    from gemrender.observation import Model, Observation, RayStatus, View
    from gemrender.paths import Paths
    from gemrender.render.backend import mitsuba
    from gemrender.render.from_python import render, render_film
    from gemrender.render.picture import Picture
    from gemrender.scene.setup import Setup, bundled_setups, load_setup
    from gemrender.stereo import StereoScore, score_stereo
    from gemrender.stone import Stone
    from gemrender.studio.widget import Studio
    from gemrender.sweep.improve import improve, pareto_front
    from gemrender.sweep.symmetry import SymmetryStudy, study_symmetry
    from gemrender.sweep.tilt import TiltStudy, study_tilt
    from gemrender.sweep.tolerance import ToleranceStudy, study_tolerance
    from gemrender.sweep.unknown import Cutting, Measuring, Rounding

__version__ = "0.2.0"

__all__ = [
    "BackendError",
    "Cutting",
    "GemrenderError",
    "GemrenderWarning",
    "InputError",
    "Measure",
    "MeasureMaps",
    "Measuring",
    "Model",
    "Observation",
    "Paths",
    "Picture",
    "RayStatus",
    "RoundBrilliant",
    "Rounding",
    "Score",
    "Setup",
    "StereoScore",
    "Stone",
    "Studio",
    "SymmetryStudy",
    "TiltStudy",
    "ToleranceStudy",
    "View",
    "VirtualFacets",
    "bundled_setups",
    "bundled_stones",
    "families",
    "improve",
    "load_setup",
    "load_stone",
    "load_stones",
    "measure_maps",
    "mitsuba",
    "observe",
    "pareto_front",
    "render",
    "render_film",
    "save_stone",
    "score",
    "score_stereo",
    "sensitivity",
    "stone_from_vertices",
    "study_symmetry",
    "study_tilt",
    "study_tolerance",
    "trace_facets",
    "trace_paths",
    "vary",
]

_ON_DEMAND = {
    "Measure": "gemrender.measures",
    "MeasureMaps": "gemrender.measures.maps",
    "Paths": "gemrender.paths",
    "Model": "gemrender.observation",
    "Observation": "gemrender.observation",
    "RayStatus": "gemrender.observation",
    "View": "gemrender.observation",
    "RoundBrilliant": "gemrender.cuts",
    "Stone": "gemrender.stone",
    "Studio": "gemrender.studio.widget",
    "bundled_stones": "gemrender.cuts",
    "load_stone": "gemrender.cuts",
    "load_stones": "gemrender.cuts",
    "measure_maps": "gemrender.mapping",
    "mitsuba": "gemrender.render.backend",
    "Picture": "gemrender.render.picture",
    "render_film": "gemrender.render.from_python",
    "Setup": "gemrender.scene.setup",
    "bundled_setups": "gemrender.scene.setup",
    "load_setup": "gemrender.scene.setup",
    "save_stone": "gemrender.cuts",
    "stone_from_vertices": "gemrender.cuts",
    "vary": "gemrender.cuts",
    "StereoScore": "gemrender.stereo",
    "score_stereo": "gemrender.stereo",
    "Cutting": "gemrender.sweep.unknown",
    "Measuring": "gemrender.sweep.unknown",
    "Rounding": "gemrender.sweep.unknown",
    "families": "gemrender.cuts.families",
    "improve": "gemrender.sweep.improve",
    "pareto_front": "gemrender.sweep.improve",
    "study_symmetry": "gemrender.sweep.symmetry",
    "study_tilt": "gemrender.sweep.tilt",
    "study_tolerance": "gemrender.sweep.tolerance",
    "SymmetryStudy": "gemrender.sweep.symmetry",
    "TiltStudy": "gemrender.sweep.tilt",
    "ToleranceStudy": "gemrender.sweep.tolerance",
    "VirtualFacets": "gemrender.beam",
    "sensitivity": "gemrender.beam.sensitivity",
    "trace_facets": "gemrender.beam",
}


_import_order.name_llvm_before_drjit()


def __getattr__(name: str) -> Any:
    """Import numpy and what needs it only when it is asked for."""
    if name in _ON_DEMAND:
        return getattr(importlib.import_module(_ON_DEMAND[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

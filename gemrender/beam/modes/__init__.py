"""Beams through birefringent stones: polygons that split in two wherever light is reflected."""

from __future__ import annotations

from gemrender.beam.modes.crystal import Biaxial, Uniaxial, optical_crystal
from gemrender.beam.modes.facets import ModeFacets, trace_mode_facets
from gemrender.beam.modes.measure import measure_modes, score_modes
from gemrender.beam.modes.stones import crystal_of

__all__ = [
    "Biaxial",
    "ModeFacets",
    "Uniaxial",
    "crystal_of",
    "measure_modes",
    "optical_crystal",
    "score_modes",
    "trace_mode_facets",
]

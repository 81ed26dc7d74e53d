"""Exact scores of convex stones: parallel beams traced as polygons, no pixels."""

from __future__ import annotations

from gemrender.beam.budget import Budget, MemoryBudget, check_limits
from gemrender.beam.facets import FacetStatus, VirtualFacets, trace_facets
from gemrender.beam.measure import BOUND_RANGE, check_bound, measure
from gemrender.beam.prepare import damaged_cache_files, is_compiled, prepare
from gemrender.beam.solid import beam_stone

__all__ = [
    "BOUND_RANGE",
    "Budget",
    "FacetStatus",
    "MemoryBudget",
    "VirtualFacets",
    "beam_stone",
    "check_bound",
    "check_limits",
    "damaged_cache_files",
    "is_compiled",
    "measure",
    "prepare",
    "trace_facets",
]

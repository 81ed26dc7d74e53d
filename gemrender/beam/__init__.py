"""Exact scores of convex stones: parallel beams traced as polygons, no pixels."""

from __future__ import annotations

from gemrender.beam.facets import FacetStatus, VirtualFacets, trace_facets
from gemrender.beam.measure import BOUND_RANGE, check_bound, measure
from gemrender.beam.prepare import prepare
from gemrender.beam.solid import beam_stone

__all__ = [
    "BOUND_RANGE",
    "FacetStatus",
    "VirtualFacets",
    "beam_stone",
    "check_bound",
    "measure",
    "prepare",
    "trace_facets",
]

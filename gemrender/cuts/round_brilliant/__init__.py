"""Round brilliants: proportions, 57 vertices, 58 facets. Nothing outside this folder knows these numbers."""

from __future__ import annotations

from gemrender.cuts.round_brilliant.proportions import RoundBrilliant
from gemrender.cuts.round_brilliant.stones import stone_from_vertices

__all__ = ["RoundBrilliant", "stone_from_vertices"]

"""Cuts: families with their parameters, files and tables of stones."""

from __future__ import annotations

from gemrender.cuts.files import bundled_stones, load_stone, load_stones
from gemrender.cuts.round_brilliant import RoundBrilliant, stone_from_vertices
from gemrender.cuts.variations import vary

__all__ = [
    "RoundBrilliant",
    "bundled_stones",
    "load_stone",
    "load_stones",
    "stone_from_vertices",
    "vary",
]

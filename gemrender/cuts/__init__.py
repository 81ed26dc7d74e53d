"""Cuts: families with their parameters, files and tables of stones."""

from __future__ import annotations

from gemrender.cuts.convert import save_stone
from gemrender.cuts.crystal_axes import orientation
from gemrender.cuts.design import Design, Tier
from gemrender.cuts.files import bundled_stones, load_stone, load_stones
from gemrender.cuts.given import StoneLike, as_stone
from gemrender.cuts.load import load_design_file, read_design
from gemrender.cuts.round_brilliant import RoundBrilliant, stone_from_vertices
from gemrender.cuts.variations import vary

__all__ = [
    "Design",
    "RoundBrilliant",
    "StoneLike",
    "Tier",
    "as_stone",
    "bundled_stones",
    "load_design_file",
    "load_stone",
    "load_stones",
    "orientation",
    "read_design",
    "save_stone",
    "stone_from_vertices",
    "vary",
]

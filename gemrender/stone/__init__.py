"""Stones: files, proportions or vertices in, planes, triangles, girdle and mesh out. Needs numpy only."""

from __future__ import annotations

from gemrender.stone.files import bundled_stones, load_stone, load_stones
from gemrender.stone.girdle import Girdle
from gemrender.stone.mesh import StoneMesh, tessellate
from gemrender.stone.proportions import RoundBrilliant
from gemrender.stone.solid import Stone
from gemrender.stone.variations import vary

__all__ = [
    "Girdle",
    "RoundBrilliant",
    "Stone",
    "StoneMesh",
    "bundled_stones",
    "load_stone",
    "load_stones",
    "tessellate",
    "vary",
]

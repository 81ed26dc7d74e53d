"""Stones: files, proportions or vertices in, planes, triangles, girdle and mesh out. Needs numpy only."""

from __future__ import annotations

from gemrender.stone.files import bundled_stones, load_stone
from gemrender.stone.girdle import Girdle
from gemrender.stone.mesh import StoneMesh, tessellate
from gemrender.stone.proportions import RoundBrilliant
from gemrender.stone.solid import Stone

__all__ = ["Girdle", "RoundBrilliant", "Stone", "StoneMesh", "bundled_stones", "load_stone", "tessellate"]

"""Atlases: scores over a grid or a quasi-random design of parameters, in a store that can be gone on with."""

from __future__ import annotations

from gemrender.sweep.atlas.cost import AtlasCost, atlas_cost
from gemrender.sweep.atlas.plan import AtlasPlan
from gemrender.sweep.atlas.plan_file import read_plan
from gemrender.sweep.atlas.run import AtlasMade, make_atlas
from gemrender.sweep.atlas.store import open_atlas

__all__ = ["AtlasCost", "AtlasMade", "AtlasPlan", "atlas_cost", "make_atlas", "open_atlas", "read_plan"]

"""What the kernels are told of the model and of the stone."""

from __future__ import annotations

from typing import Any, NamedTuple

__all__ = ["REAR_DIRECTION", "REAR_FACET", "REAR_POSITION", "Rules", "Solid"]

#: What tells rear light, in the order of `gemrender.observation.REAR_RULES`.
REAR_POSITION, REAR_FACET, REAR_DIRECTION = 0, 1, 2


class Rules(NamedTuple):
    """The optical model (`gemrender.observation.Model`) as the kernels take it."""

    refractive_index: float
    law: int  # EXACT or GUBELIN
    radiance: bool
    rear: int  # REAR_POSITION, REAR_FACET or REAR_DIRECTION
    max_reflections: int


class Solid(NamedTuple):
    """The stone as the kernels take it.

    planes : (p, 4) float64 or complex128
        Outward unit normals and offsets of the facets' planes [girdle radius].
    values : (p, 4) float64
        The same without derivatives.
    columns : (4, p) float64
        The same, transposed.
    walls : (w, 3) float64
        Normals (x, y) and offsets of upright planes inside the girdle, which beams inside the stone meet.
    rim : (w', 3) float64
        The same, closer to the girdle, for what of the crown the view's polygons cover.
    is_round : bool
        Whether the girdle is the cylinder of radius 1.
    """

    planes: Any
    values: Any
    columns: Any
    walls: Any
    rim: Any
    is_round: bool

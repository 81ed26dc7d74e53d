"""What the kernels are told of the model and of the stone."""

from __future__ import annotations

from typing import Any, NamedTuple

from gemrender.beam.wall import Wall

__all__ = ["Rules", "Solid"]


class Rules(NamedTuple):
    """The optical model (`gemrender.observation.Model`) as the kernels take it."""

    refractive_index: float
    law: int  # EXACT or GUBELIN
    radiance: bool
    rear_by_position: bool
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
    wall : Wall
        The girdle.
    """

    planes: Any
    values: Any
    columns: Any
    walls: Any
    rim: Any
    wall: Wall

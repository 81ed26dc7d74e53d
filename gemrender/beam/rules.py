"""What the kernels are told of the model and of the stone."""

from __future__ import annotations

from typing import Any, NamedTuple

__all__ = ["Rules", "Solid"]


class Rules(NamedTuple):
    """What of the optical model (`gemrender.observation.Model`) decides on paths."""

    refractive_index: float
    max_reflections: int
    cut_at_ground: bool  # whether polygons that leave are cut along z = ground
    ground: float
    follows_all: bool  # whether what is reflected below the critical angle goes on
    least: float  # area x weight below which it becomes a cell, for single rays to follow [share of the view]
    #: Whether the line in the view where later light ends at the walls moves with the planes: it is none of
    #: the stone's own edges, and derivatives of both sides together are the same either way.
    walls_move: bool = True


class Solid(NamedTuple):
    """The stone as the kernels take it.

    planes : (p, 4) float64 or complex128
        Outward unit normals and offsets of the facets' planes [girdle radius].
    values : (p, 4) float64
        The same without derivatives.
    columns : (4, p) float64
        The same, transposed.
    walls : (w, 3) float64
        Normals (x, y) and offsets of upright planes inside a round girdle, which beams inside the stone meet.
    rim : (w', 3) float64
        The same, closer to the girdle, for what of the crown the view's polygons cover.
    is_round : bool
        Whether the girdle is the cylinder of radius 1; if not there are neither walls nor a rim.
    reach : float
        Radius of a sphere about the origin that holds the stone [girdle radius].
    """

    planes: Any
    values: Any
    columns: Any
    walls: Any
    rim: Any
    is_round: bool
    reach: float

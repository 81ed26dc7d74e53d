"""The dimensions of a stone: of a round brilliant its proportions, of others what their outline measures."""

from __future__ import annotations

from gemrender.report.brilliant.dimensions import brilliant_dimensions
from gemrender.report.measured import Dimension, measured_dimensions
from gemrender.stone import Stone

__all__ = ["dimensions", "length_unit"]


def dimensions(stone: Stone) -> dict[str, Dimension]:
    """Return a stone's dimensions: of a round brilliant its proportions, else `measured_dimensions`."""
    is_brilliant = stone.labelled_vertices is not None
    return brilliant_dimensions(stone) if is_brilliant else measured_dimensions(stone)


def length_unit(stone: Stone) -> str:
    """Return what lengths of the stone count: "girdle radius", or "half length" of one that is not round."""
    is_brilliant = stone.is_round or stone.labelled_vertices is not None
    return "girdle radius" if is_brilliant else "half length"

"""The facets of a stone: each has a name, a kind and a side."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["CROWN", "GIRDLE", "LEVEL", "PAVILION", "Facet", "side_of"]

CROWN, GIRDLE, PAVILION = "crown", "girdle", "pavilion"

#: A normal that rises or falls by less than this belongs to a level facet, one of the girdle: files write
#: 90 degrees, whose cosine is 6e-17, with nine digits.
LEVEL = 1e-8


@dataclass(frozen=True, slots=True)
class Facet:
    """One facet.

    Parameters
    ----------
    name : str
        Its name, unique in the stone, such as "star_1".
    kind : str
        What it is one of, such as "star"; in a faceter's design the name of its tier.
    side : {"crown", "girdle", "pavilion"}
        Where its normal points: up, level, down.
    """

    name: str
    kind: str
    side: str


def side_of(rise: float) -> str:
    """Return the side of a facet whose outward unit normal has this z."""
    if abs(rise) <= LEVEL:
        return GIRDLE
    return CROWN if rise > 0 else PAVILION

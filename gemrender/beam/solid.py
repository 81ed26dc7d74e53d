"""A stone as the beam tracer sees it: a convex solid, and upright planes just inside its girdle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from gemrender.beam.rules import Solid
from gemrender.errors import InputError
from gemrender.observation import View
from gemrender.stone import ConvexSolid, Stone

__all__ = ["NO_WEDGE", "BeamStone", "beam_stone"]

#: Upright planes inside a round girdle: for beams inside the stone, and for the rim of the view. More of them
#: leave less light to single rays, and cut it into more cells.
_WALLS, _RIM = 32, 256

#: The whole view.
NO_WEDGE = np.empty((0, 3))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BeamStone:
    """A convex stone as beams meet it.

    Attributes
    ----------
    stone : Stone
        The stone.
    solid : Solid
        Its planes and walls.
    facet : (p + 1,) int64
        The facet that each plane belongs to; the last one is the girdle.
    """

    stone: Stone
    solid: Solid
    facet: np.ndarray

    def wedge(self, view: View) -> np.ndarray:
        """Return the part of a view that tells all of it, between two mirror planes: rows (a, b, c), (k, 3).

        There a u + b v + c <= 0. Without mirror planes, or tilted, there are no rows: it is the whole view.
        """
        symmetry = self.stone.symmetry
        if view.tilt_deg or not len(symmetry.mirrors):
            return NO_WEDGE
        first = symmetry.mirrors[0]
        last = first + np.pi / symmetry.fold
        rows = np.array([[np.sin(first), -np.cos(first)], [-np.sin(last), np.cos(last)]])
        rows = rows[: min(symmetry.fold, 2)]  # of a single mirror plane one side is the half of the view
        return np.column_stack([rows, -rows @ symmetry.centre])


@lru_cache(maxsize=4)  # a score asks for it when the engine is chosen, checked and used
def beam_stone(stone: Stone) -> BeamStone:
    """Return the stone as planes and walls.

    Raises
    ------
    InputError
        The stone is not convex.
    """
    solid = stone.solid
    if not isinstance(solid, ConvexSolid):
        raise InputError(
            "is not convex; the exact engine traces convex stones only, the engines mitsuba and "
            "reference trace this one",
            source=stone.source or stone.name,
        )
    planes, facet, none = np.array(solid.planes), solid.facet, np.empty((0, 3))
    walls, rim = (_chords(_WALLS), _chords(_RIM)) if solid.is_round else (none, none)
    return BeamStone(
        stone=stone,
        solid=Solid(planes, planes, np.ascontiguousarray(planes.T), walls, rim, solid.is_round, stone.reach),
        facet=np.append(facet, solid.n_facets - 1),
    )


@cache
def _chords(number: int) -> np.ndarray:
    """Upright planes through so many even chords of the circle of radius 1, (number, 3)."""
    azimuth = (np.arange(number) + 0.5) * (2 * np.pi / number)
    offset = np.full(number, np.cos(np.pi / number))
    return np.column_stack([np.cos(azimuth), np.sin(azimuth), offset])

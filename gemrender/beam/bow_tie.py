"""Bow-ties: how much of the belly of an elongated stone is dark under the viewer's head, exactly.

The belly of a stone seen from above is what lies towards the sides of its width from the culet: two sectors,
which with the outline stretched to a square box are 45 degrees wide, as two bezels of a brilliant are. Of an
ellipse they are a quarter. A virtual facet there is dark where its light would come from the viewer's head.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Unpack

import numpy as np

from gemrender.beam.facets import FacetStatus, VirtualFacets, trace_facets
from gemrender.cuts import StoneLike, as_stone
from gemrender.measures.measure import TIE
from gemrender.request import ShortForms, spelt_out
from gemrender.stone import Stone

__all__ = ["HEAD_DEG", "BowTie", "Part", "area_in_sector", "belly_sectors", "bow_tie"]

#: Half the angle at which the head is seen [deg]: of ASET's blue zone, close by.
HEAD_DEG = 15.0
#: Corners as high as the lowest one, the culet's [stone's unit].
_LEVEL = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """What is seen in a part of a stone, of its principal light.

    Attributes
    ----------
    area : float
        Area [share of the view].
    dark : float
        Share of the part whose light would come from the viewer's head.
    leaking : float
        Share of the part whose light would come from below the viewer's horizon, or never leaves.
    """

    area: float
    dark: float
    leaking: float

    @property
    def bright(self) -> float:
        """Share of the part whose light comes from the open sky between head and horizon."""
        return 1.0 - self.dark - self.leaking


@dataclass(frozen=True, kw_only=True, eq=False)
class BowTie:
    """The belly of a stone and the rest of it, seen from above.

    Attributes
    ----------
    belly, ends, whole : Part
        The sectors of the belly, all but these, and both together.
    head_deg : float
        Half the angle at which the head is seen [deg].
    facets : VirtualFacets
        What is seen.
    """

    belly: Part
    ends: Part
    whole: Part
    head_deg: float
    facets: VirtualFacets

    @property
    def contrast(self) -> float:
        """How much larger the dark share of the belly is than that of the ends; a bow-tie is above 0."""
        return self.belly.dark - self.ends.dark


@spelt_out()
def bow_tie(stone: StoneLike, *, head_deg: float = HEAD_DEG, **short: Unpack[ShortForms]) -> BowTie:
    """Return the dark shares of belly and ends of a convex stone, from straight above.

    Parameters
    ----------
    stone : Stone, str or path
        The stone, its length along y; or what `load_stone` takes.
    head_deg : float
        Half the angle at which the head is seen [deg].
    **short
        As of `ShortForms`.

    Raises
    ------
    InputError
        The stone is not convex, or a short form is refused.
    """
    stone = as_stone(stone)
    facets = trace_facets(stone, **short)
    cosine = facets.paths.exit_direction[:, 2]
    leaves = facets.status == FacetStatus.EXITED
    dark = leaves & (cosine > math.cos(math.radians(head_deg)) + TIE)
    leaking = ~leaves | (cosine <= TIE)
    apex, sectors = belly_sectors(stone)
    in_belly = sum(
        (area_in_sector(facets.corners, facets.starts, facets.ends, apex, sector) for sector in sectors),
        start=np.zeros(len(facets)),
    )
    view = float(facets.area.sum())

    def part(areas: np.ndarray) -> Part:
        area = float(areas.sum())
        return Part(
            area=area / view, dark=float(areas[dark].sum()) / area, leaking=float(areas[leaking].sum()) / area
        )

    return BowTie(
        belly=part(in_belly),
        ends=part(facets.area - in_belly),
        whole=part(facets.area),
        head_deg=head_deg,
        facets=facets,
    )


def belly_sectors(stone: Stone) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Return where the sectors of the belly meet, (2,), and the directions of their sides, (2, 2) each.

    Each sector goes anticlockwise from the first of its directions to the second.
    """
    corners = stone.solid.vertices
    culet = corners[corners[:, 2] <= corners[:, 2].min() + _LEVEL, :2].mean(axis=0)
    width, length = (1.0, 1.0) if stone.is_round else np.ptp(corners[:, :2], axis=0)
    rise = math.tan(math.radians(22.5)) * length / width
    right = np.array([[1.0, -rise], [1.0, rise]])
    return culet, (right, -right)


def area_in_sector(
    corners: np.ndarray, starts: np.ndarray, ends: np.ndarray, apex: np.ndarray, sector: np.ndarray
) -> np.ndarray:
    """Return the area of polygons within a sector narrower than half a turn.

    The sector's sides pass through the apex, so the area is that of the triangles from the apex to what of
    each edge lies in the sector.

    Parameters
    ----------
    corners : (c, 2) float64
        Corners of all polygons, one after the other, anticlockwise.
    starts, ends : (n,) int64
        Where the corners of each begin and end.
    apex : (2,) float64
        Where the sides of the sector meet.
    sector : (2, 2) float64
        Directions of its sides, anticlockwise.

    Returns
    -------
    (n,) float64
    """
    a = corners - apex
    after = np.arange(1, len(corners) + 1)
    after[ends - 1] = starts
    b = a[after]
    low, high = np.zeros(len(a)), np.ones(len(a))
    for side, sign in zip(sector, (1.0, -1.0), strict=True):
        at_a, at_b = (sign * (side[0] * p[:, 1] - side[1] * p[:, 0]) for p in (a, b))
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = at_a / (at_a - at_b)
        low = np.where((at_a < 0) & (at_b > 0), np.maximum(low, crossing), low)
        high = np.where((at_a > 0) & (at_b < 0), np.minimum(high, crossing), high)
        high = np.where((at_a <= 0) & (at_b <= 0), low, high)
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    parts = 0.5 * cross * np.maximum(high - low, 0.0)
    return np.asarray(np.add.reduceat(parts, starts)) if len(starts) else np.zeros(0)

"""The facets of a stone by tier: how many there are, their angles, indices and area."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.cuts.design import Design
from gemrender.stone import Stone

__all__ = ["TierFigures", "tiers_of_stone"]

#: Places on an index wheel nearer to its beginning than this are there: rounding [teeth].
_TOOTH = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class TierFigures:
    """The facets of one kind on one side of a stone.

    Attributes
    ----------
    name : str
        Their kind; in a design the tier's name.
    side : {"crown", "girdle", "pavilion"}
        The side they are on.
    number : int
        How many facets there are.
    angle_deg, least_angle_deg, most_angle_deg : float or None
        Angle to the girdle plane: mean, least and largest [deg]; None of a girdle that is not plane.
    indices : tuple of float or None
        Where the cut is a design, their places on its index wheel [teeth].
    area : float
        Their share of the stone's surface [%].
    """

    name: str
    side: str
    number: int
    angle_deg: float | None
    least_angle_deg: float | None
    most_angle_deg: float | None
    indices: tuple[float, ...] | None
    area: float


def tiers_of_stone(stone: Stone) -> tuple[TierFigures, ...]:
    """Return the facets of a stone by side and kind, in the order of the facets on each side."""
    count = len(stone.facet_normals)
    angles = np.degrees(np.arccos(np.clip(np.abs(stone.facet_normals[:, 2]), 0.0, 1.0)))
    areas = stone.solid.areas
    indices = _indices(stone)
    groups: dict[tuple[str, str], list[int]] = {}
    for side in ("crown", "girdle", "pavilion"):
        for number, facet in enumerate(stone.facets):
            if facet.side == side:
                groups.setdefault((side, facet.kind), []).append(number)
    tiers = []
    for (side, kind), numbers in groups.items():
        own = angles[[number for number in numbers if number < count]]
        placed = [indices[stone.facets[n].name] for n in numbers if stone.facets[n].name in indices]
        tiers.append(
            TierFigures(
                name=kind,
                side=side,
                number=len(numbers),
                angle_deg=float(own.mean()) if own.size else None,
                least_angle_deg=float(own.min()) if own.size else None,
                most_angle_deg=float(own.max()) if own.size else None,
                indices=tuple(placed) if placed else None,
                area=100.0 * float(areas[numbers].sum() / areas.sum()),
            )
        )
    return tuple(tiers)


def _indices(stone: Stone) -> dict[str, float]:
    """Return the place on the index wheel of each facet of a design, by its name; else nothing."""
    if not isinstance(stone.cut, Design):
        return {}
    teeth = abs(stone.cut.gear)
    places = [float(np.real(index)) % teeth for tier in stone.cut.tiers for index in tier.indices]
    shown = [place if place > _TOOTH else teeth for place in places]
    return dict(zip(stone.cut.facet_names(), shown, strict=True))

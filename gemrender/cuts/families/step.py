"""Step cuts (emerald cut, baguette, Asscher cut): rows of facets parallel to the sides of an outline.

All edges of one row are parallel to the outline, so that a row lies at one angle all round. On the crown the
rows are equally wide from the girdle to the table, on the pavilion from the girdle to the keel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from gemrender.cuts.design import Design, Tier
from gemrender.cuts.families.parameters import check_parameters, parameter
from gemrender.errors import InputError
from gemrender.stone import Stone

__all__ = ["FAMILY", "Parameters"]

FAMILY = "step"

#: Teeth of the index wheel, and the teeth of the sides: the long ones at +x and -x, the ends, the corners.
_GEAR = 96
_SIDES, _ENDS, _CORNERS = (24.0, 72.0), (0.0, 48.0), (12.0, 36.0, 60.0, 84.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters:
    """A step cut.

    Parameters
    ----------
    length : float
        Length of the outline [% of its width], 100 to 400.
    corner : float
        Width of the outline's cut corners, along a side [% of the width]; 0 for none.
    table : float
        Width of the table [% of the width].
    girdle_thickness : float
        Height of the girdle [% of the width].
    crown_angles, pavilion_angles : tuple of float
        Angle of each row to the girdle plane, from the girdle on [deg]; each smaller than the one before.

    Raises
    ------
    InputError
        A value out of range, or rows that do not make a convex stone.
    """

    length: float = parameter(100.0, 400.0, default=140.0)
    corner: float = parameter(0.0, 45.0, default=15.0)
    table: float = parameter(5.0, 95.0, default=60.0)
    girdle_thickness: float = parameter(0.1, 50.0, default=3.0)
    crown_angles: tuple[float, ...] = parameter(1.0, 85.0, default=(46.0, 36.0, 26.0), many=True)
    pavilion_angles: tuple[float, ...] = parameter(1.0, 85.0, default=(54.0, 46.0, 40.0), many=True)

    def __post_init__(self) -> None:
        check_parameters(self)
        for key in ("crown_angles", "pavilion_angles"):
            angles = getattr(self, key)
            if any(after >= before for before, after in pairwise(angles)):
                raise InputError(
                    "must fall from the girdle on: the stone would be hollow", key=key, value=list(angles)
                )

    def design(self) -> Design:
        """Return it as tiers of facets; the unit is half the width."""
        half_length = self.length / 100.0
        corner = 2.0 * self.corner / 100.0
        across: list[tuple[tuple[float, ...], float, str]]
        across = [(_SIDES, 1.0, "side"), (_ENDS, half_length, "end")]
        if corner:
            across.append((_CORNERS, (1.0 + half_length - corner) / math.sqrt(2.0), "corner"))
        girdle = 2.0 * self.girdle_thickness / 100.0
        tiers = [
            Tier(angle_deg=-90.0, distance=distance, indices=teeth, names=(f"girdle_{name}",))
            for teeth, distance, name in across
        ]
        # The origin lies in the middle of the girdle, inside all planes.
        for part, up, angles, reach in (
            ("crown", 1.0, self.crown_angles, 1.0 - self.table / 100.0),
            ("pavilion", -1.0, self.pavilion_angles, 1.0),
        ):
            height, width = 0.5 * girdle, reach / len(angles)
            for row, angle in enumerate(angles):
                sin, cos = math.sin(math.radians(angle)), math.cos(math.radians(angle))
                tiers += [
                    Tier(
                        angle_deg=up * angle,
                        distance=sin * (distance - row * width) + cos * height,
                        indices=teeth,
                        names=(f"{part}_{name}_{row + 1}",),
                    )
                    for teeth, distance, name in across
                ]
                height += width * math.tan(math.radians(angle))
            if part == "crown":
                tiers.append(Tier(angle_deg=0.0, distance=height, indices=(0.0,), names=("table",)))
        return Design(tiers=tuple(tiers), gear=_GEAR)

    def stone(self, **facts: Any) -> Stone:
        """Make the stone; `facts` are fields of `Stone` such as its name."""
        return self.design().stone(**facts)

"""The oval brilliant: a round brilliant's facets on an ellipse."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.brilliant import brilliant
from gemrender.cuts.construction.outlines import ellipse
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.heights import CROWN_ANGLE, PAVILION_ANGLE
from gemrender.cuts.families.parameters import Alternative, choice, girdle_thickness, parameter

__all__ = ["FAMILY", "Parameters"]

FAMILY = "oval"

#: Girdle points of pavilion mains by their number; the first girdle point is an end of the length.
_MAINS = {4: (2, 6, 10, 14), 6: (2, 4, 6, 10, 12, 14), 8: tuple(range(0, 16, 2))}


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(Family):
    """An oval brilliant.

    Parameters
    ----------
    length_to_width : float
        Length of the outline over its width, 1 to 2.5.
    table : float
        Width of the table [% of the width].
    table_length : float
        Length of the table [% of the length].
    crown_height, pavilion_depth : float
        Heights of crown and pavilion [% of the width]; `crown_angle` and `pavilion_angle`, measured across
        the width [deg], stand for them.
    girdle_thickness : float
        Height of the girdle at its thick places, where the mains meet it [% of the width].
    star, lower_half : float
        Lengths of stars and lower halves, as of round brilliants [%].
    culet : float
        Width of the culet [% of the width]; 0 for a point.
    mains : {4, 6, 8}
        Number of pavilion mains.

    Raises
    ------
    InputError
        A value out of range.
    """

    ALTERNATIVES: ClassVar[tuple[Alternative, ...]] = (CROWN_ANGLE, PAVILION_ANGLE)

    length_to_width: float = parameter(1.0, 2.5, default=1.4, unit="")
    table: float = parameter(30.0, 80.0, default=57.0)
    table_length: float = parameter(30.0, 85.0, default=61.0, why="bezels somewhat less steep at the ends")
    crown_height: float = parameter(5.0, 30.0, default=14.0)
    girdle_thickness: float = girdle_thickness(3.5)
    pavilion_depth: float = parameter(25.0, 65.0, default=43.5)
    star: float = parameter(20.0, 80.0, default=50.0)
    lower_half: float = parameter(30.0, 95.0, default=75.0)
    culet: float = parameter(0.2, 20.0, default=0.0, or_zero=True)
    mains: int = choice(4, 6, 8, default=8, why="the commonest")

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        half_width = 1.0 / values["length_to_width"]
        girdle = ellipse(half_width)
        percent = 2.0 * half_width / 100.0
        table = girdle.feet[::2] * np.array([values["table"], values["table_length"]]) / 100.0
        return brilliant(
            girdle,
            table=table,
            star=values["star"] / 100.0,
            crown_height=percent * values["crown_height"],
            thickness=percent * values["girdle_thickness"],
            pavilion_depth=percent * values["pavilion_depth"],
            lower_half=values["lower_half"] / 100.0,
            culet=values["culet"] / 100.0,
            mains=_MAINS[values["mains"]],
        )

"""The single cut: a table, eight bezels and eight mains, 17 facets, and often a culet; most are melee.

The facets are those of the trade's glossaries (such as diamondhelpers.com/glossary/single-cut). No laboratory
prints proportions of single cuts: the defaults are inferred from those of full cuts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.meet_points import points_at
from gemrender.cuts.construction.outlines import circle
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.heights import PAVILION_ANGLE, by_angle
from gemrender.cuts.families.parameters import Alternative, girdle_thickness, parameter
from gemrender.cuts.girdle_words import CULET_RANGE, read_culet
from gemrender.cuts.laboratory import ROUNDING
from gemrender.cuts.marks import Length, Mark, Share, tilt, usual_marks

__all__ = ["FAMILY", "Parameters"]

FAMILY = "single cut"

#: From the middle of one of eight facets to its end: a sixteenth of a turn.
_COS = float(np.cos(np.pi / 8))


def _crown_run(values: Mapping[str, Any]) -> Any:
    """Level distance from the girdle to the middle of a table edge [%]."""
    return (100.0 - _COS * values["table"]) / 2


#: Angle of the bezels: crown height = (100 - table cos(22.5 deg))/2 tan(angle) [% of the diameter].
_CROWN_ANGLE = by_angle("crown_angle", "crown_height", _crown_run, 5.0, 70.0, ROUNDING["crown_angle"])


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(Family):
    """A single cut.

    Each facet leaves the round girdle thinnest below or above its middle, where it stands furthest out, and
    thickest where two facets meet. Thickness and heights are measured in the middle of facets, in the plane
    in which their angles are, so that table to culet is crown height + girdle + pavilion depth. The
    middle of a bezel lies at +x, as that of round brilliants, and z is 0 at the girdle's lower edge where
    mains meet.

    Parameters
    ----------
    table : float
        Distance between opposite corners of the table [% of the diameter].
    crown_height, pavilion_depth : float
        Heights of crown and pavilion, down to the culet [% of the diameter]; `crown_angle` and
        `pavilion_angle` [deg] stand for them.
    girdle_thickness : float
        Height of the girdle where it is thinnest, in the middle of facets [% of the diameter].
    culet : float
        Width of the culet, from main to main [% of the diameter], or a laboratory's words; 0 for a point.

    Raises
    ------
    InputError
        A value out of range.
    """

    ALTERNATIVES: ClassVar[tuple[Alternative, ...]] = (_CROWN_ANGLE, PAVILION_ANGLE)
    IS_ROUND: ClassVar[bool] = True

    table: float = parameter(20.0, 85.0, default=60.0, why="as in full cuts of its size")
    crown_height: float = parameter(3.0, 35.0, default=14.0, why="32 deg")
    girdle_thickness: float = girdle_thickness(2.0)
    pavilion_depth: float = parameter(20.0, 65.0, default=43.0, why="41 deg")
    culet: float = parameter(*CULET_RANGE, default=0.0, or_zero=True, words=read_culet)

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        crown, pavilion, thickness = (
            values[name] / 50.0 for name in ("crown_height", "pavilion_depth", "girdle_thickness")
        )
        table, culet = values["table"] / 100.0, values["culet"] / 100.0
        # What facets rise or fall from their middle to their corners, on the circle.
        rise = (1.0 - _COS) * crown / (1.0 - _COS * table)
        fall = (1.0 - _COS) * pavilion / (1.0 - culet)
        corners = circle().feet[1::2]
        stone = Construction()
        t = stone.ring("table", points_at(table * corners, fall + thickness + crown))
        u = stone.ring("girdle_upper", points_at(corners, fall + thickness + rise))
        low = stone.ring("girdle_lower", points_at(corners, 0.0 * fall))
        end = fall - pavilion
        stone.facet("table", t)
        for k in range(8):
            stone.facet("bezel", (t[k - 1], u[k - 1], u[k], t[k]))
        if np.real(culet) > 0:
            c = stone.ring("culet", points_at(culet / _COS * corners, end))
        else:
            c = np.repeat(stone.ring("culet", points_at(np.zeros(2), end)), 8)
        for k in range(8):
            stone.facet("pavilion_main", dict.fromkeys(map(int, (low[k], low[k - 1], c[k - 1], c[k]))))
        if np.real(culet) > 0:
            stone.facet("culet", c[::-1])
        return stone

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows; heights and angles are those in the middle of facets."""
        made = self.construction()
        points = made.points.real
        bezel, main = (made.planes.real[made.kinds.index(kind)] for kind in ("bezel", "pavilion_main"))
        # Where a facet stands furthest out, at the girdle.
        upper, lower = ((plane[3] - np.hypot(*plane[:2])) / plane[2] for plane in (bezel, main))
        heights = (points[:, 2].max(), upper, lower, points[:, 2].min())
        places = np.zeros((4, 3))
        places[:, 0], places[:, 2] = (self.table / 100.0, _COS, _COS, 0.0), heights
        without = (
            "table",
            "crown height",
            "girdle",
            "pavilion depth",
            "crown angle",
            "pavilion angle",
            "culet",
        )
        names = ("crown height", "girdle", "pavilion depth")
        keys = ("crown_height", "girdle_thickness", "pavilion_depth")
        marks: list[Mark] = [
            *usual_marks(made, is_round=True, without=without),
            *(Length(name=name, view="width", start=low, end=high, axis=2, whole=2.0, parameter=key)
              for name, key, high, low in zip(names, keys, places, places[1:], strict=False)),
            tilt(made, "bezel", "crown angle", "crown", parameter="crown_angle"),
            tilt(made, "pavilion_main", "pavilion angle", "pavilion", parameter="pavilion_angle"),
        ]  # fmt: skip
        corner = points[made.rings["table"][0]]
        start, end = corner * [0.0, 0.0, 1.0], corner / [*[np.hypot(*corner[:2])] * 2, 1.0]
        marks.append(Share(name="table", view="crown", start=start, end=end, at=corner, parameter="table"))
        if self.culet:
            culet = points[made.rings["culet"]]
            at = culet[2:4].mean(axis=0)
            marks.append(
                Share(name="culet", view="pavilion", start=culet.mean(axis=0),
                      end=at * np.array([1.0, 1.0, 0.0]) / np.hypot(*at[:2]), at=at, parameter="culet")
            )  # fmt: skip
        return tuple(marks)

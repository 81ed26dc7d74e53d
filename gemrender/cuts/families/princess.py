"""The princess cut: a square or rectangle with a pavilion of chevrons.

How the facets lie, sourced: two sets of crown mains, bezels in the corners and stars that are turned by 6
degrees, both rows of the crown equally wide at the middle of a side; on the pavilion mains at the sides (P1)
and in the corners (P2), and between them two to four chevrons whose points lie on the middle lines of the
sides, of two chevrons 5, 15 and 25 % of the width from the axis. So B. Harding, "Grading the Princess Cut"
(pricescope.com, 2005), of the American Gem Society's designs, and whiteflash.com, "AGSL Diamond Cut Grading";
drawings of two to four chevrons: github.com/vlad0007/polyhedron2, chapter 30. 21 crown and 24, 32 or 40
pavilion facets, 49, 57 or 65 with the girdle's four: mgc-labs.ru, "Princess". The rows' names are Grossbard's
(US 4,020,649).

Inferred: how steep the chevrons between the two mains are, where the edge between the crown's rows lies, and
that a rectangle is a stretched square. Defaults: within what diamondscreener.com's "Princess Cut Diamond
Guide" finds best, by "ideal" stones of the American Gem Society (depth 71 to 75 %, table 68 to 72 %, crown
height 9.5 to 14 %, two or three chevrons).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.break_crown import (
    Corners,
    Table,
    add_break_crown,
    add_side_girdle,
    side_points,
)
from gemrender.cuts.construction.meet_points import points_at
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.heights import by_angle
from gemrender.cuts.families.parameters import Alternative, choice, culet, girdle_thickness, parameter
from gemrender.cuts.laboratory import ROUNDING
from gemrender.cuts.marks import Mark, Share, break_marks, corner_mark, slope, tilt, usual_marks

__all__ = ["FAMILY", "Parameters"]

FAMILY = "princess"

_DEGREE = np.pi / 180
_AGS = "the American Gem Society's designs"


def _crown_angle_run(values: Mapping[str, Any]) -> Any:
    """Level width of the girdle break over its share of the crown's height [% of the width]."""
    return (100.0 - values["table"]) / 4 / (values["crown_break"] / 100.0)


def _corner_run(values: Mapping[str, Any]) -> Any:
    """Level distance from the cut or sharp corner to the culet of a square [% of the width]."""
    corner, culet = values["corner"] / 100.0, values["culet"] / 100.0
    return 50.0 * np.sqrt(2.0) * (1.0 - corner - 0.5 * culet)


def _side_slopes(values: Mapping[str, Any]) -> tuple[Any, Any]:
    """Slopes of the side mains between which the pavilion is convex; of the width."""
    side, tip = (values[key] / 100.0 for key in ("side_length", "tip"))
    depth, fall = _apex(values)
    low, high = (2.0 * depth * (1.0 - fall * at) / (1.0 - at) for at in (tip, 1.0 - side))
    return low, high


def _apex(values: Mapping[str, Any]) -> tuple[Any, Any]:
    """Depth where the mains in the corners meet [of the width]; of it, their rise across half the width."""
    fall = 0.5 / (1.0 - values["corner"] / 100.0)
    return values["pavilion_depth"] / 100.0 / (1.0 - fall * values["culet"] / 100.0), fall


def _bulge_from_side(angle: Any, values: Mapping[str, Any]) -> Any:
    low, high = _side_slopes(values)
    return 100.0 * (np.tan(angle * _DEGREE) - low) / (high - low)


def _side_slope(values: Mapping[str, Any]) -> Any:
    low, high = _side_slopes(values)
    return low + values["bulge"] / 100.0 * (high - low)


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(Family):
    """A princess cut.

    Parameters
    ----------
    length_to_width : float
        Length of the outline over its width, 1 to 1.5.
    corner : float
        What is cut from each side at a corner [% of the side]; 0 for sharp corners.
    table : float
        Width of the table, from side to side at the middle [% of the width].
    star_azimuth : float
        Angle by which the edges of the table are turned from the sides of a square [deg].
    crown_height, pavilion_depth : float
        Heights of crown and pavilion [% of the width]; `crown_angle`, of the row at the girdle on the long
        sides, and `corner_angle`, of the pavilion mains in the corners of a square [deg], stand for them.
    crown_break : float
        Height of the edges between the crown's rows [% of the crown height].
    girdle_thickness : float
        Height of the girdle [% of the width].
    chevrons : {2, 3, 4}
        Number of chevrons on each side.
    side_length : float
        Length of the side mains: share of the way from the girdle to the axis [%].
    tip : float
        Distance of the innermost points of the chevrons from the axis [% of half the width].
    bulge : float
        How steep the side mains are, between the flattest (0) and the steepest (100) that leave the pavilion
        convex [%]; `side_angle`, their angle on the long sides [deg], stands for it.
    culet : float
        Width of the culet, from side to side [% of the width], or a laboratory's words; 0 for a point.

    Raises
    ------
    InputError
        A value out of range.
    """

    ALTERNATIVES: ClassVar[tuple[Alternative, ...]] = (
        by_angle("crown_angle", "crown_height", _crown_angle_run, 10.0, 60.0, ROUNDING["crown_angle"]),
        by_angle("corner_angle", "pavilion_depth", _corner_run, 20.0, 60.0, ROUNDING["pavilion_angle"]),
        Alternative(
            "side_angle", "bulge", 30.0, 80.0,
            _bulge_from_side,
            lambda values: np.arctan(_side_slope(values)) / _DEGREE,
            ROUNDING["pavilion_angle"],
        ),
    )  # fmt: skip

    length_to_width: float = parameter(1.0, 1.5, default=1.0, unit="")
    corner: float = parameter(0.5, 6.0, default=0.0, or_zero=True)
    table: float = parameter(45.0, 85.0, default=69.0)
    star_azimuth: float = parameter(2.0, 10.0, default=6.0, unit="deg", why=_AGS)
    crown_height: float = parameter(4.0, 20.0, default=11.0)
    crown_break: float = parameter(52.0, 70.0, default=57.0)
    girdle_thickness: float = girdle_thickness(3.5)
    pavilion_depth: float = parameter(40.0, 75.0, default=58.0)
    chevrons: int = choice(2, 3, 4, default=3)
    side_length: float = parameter(40.0, 65.0, default=50.0, why=_AGS)
    tip: float = parameter(6.0, 25.0, default=10.0, why=_AGS)
    bulge: float = parameter(15.0, 90.0, default=70.0)
    culet: float = culet(high=5.0)

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        half = 1.0 / values["length_to_width"], 1.0
        percent = 2.0 * half[0] / 100.0
        cut = 2.0 * values["corner"] / 100.0
        outline = Corners(half, (cut * half[0], cut * half[1]), (1.0 / half[0], 1.0))
        share, tangent = values["table"] / 100.0, np.tan(values["star_azimuth"] * _DEGREE)
        inner = share / (1.0 + tangent)
        table = Table((share * half[0], share * half[1]), (inner * half[0], inner * half[1]))
        stone = Construction()
        upper = add_break_crown(
            stone,
            outline,
            table,
            height=percent * values["crown_height"],
            thickness=percent * values["girdle_thickness"],
            share=values["crown_break"] / 100.0,
            split_corners=False,
        )
        lower = add_side_girdle(stone, upper, outline)
        _add_chevrons(stone, lower, half, values)
        return stone

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows, on the left side and on the end at +y."""
        made = self.construction()
        points, rings = made.points.real, made.rings
        thickness = points[rings["girdle_upper"], 2].max()
        edge = np.array([points[:, 0].min(), 0.0, 0.0])
        crossing = points[rings["break"]]
        main, tip = points[rings["chevron_0"]][1], points[rings[f"chevron_{self.chevrons}"]][0]
        axis = np.zeros(3)
        # The angles of crown and pavilion are those of its rows.
        without = [f"{part} angle{where}" for part in ("crown", "pavilion") for where in ("", " at the ends")]
        marks = [
            *usual_marks(made, without=without),
            # The table of a rectangle is that of a square, stretched.
            *(mark for mark in break_marks(made) if self.length_to_width == 1 or mark.name != "star azimuth"),
            slope("crown angle", "width", edge + np.array([0.0, 0.0, thickness]),
                  crossing[crossing[:, 0].argmin()], parameter="crown_angle"),
            slope("side angle", "width", edge, main, parameter="side_angle"),
            Share(name="side length", view="pavilion", start=edge, end=axis, at=main,
                  parameter="side_length"),
            Share(name="tip of chevrons", view="pavilion", start=axis, end=np.array([0.0, 1.0, 0.0]), at=tip,
                  parameter="tip"),
        ]  # fmt: skip
        if self.length_to_width == 1:
            marks.append(tilt(made, "pavilion_main", "corner angle", "pavilion", parameter="corner_angle"))
        return (*marks, *([corner_mark(made)] if self.corner else []))


def _add_chevrons(
    stone: Construction, lower: np.ndarray, half: tuple[Any, Any], values: Mapping[str, Any]
) -> None:
    """Add the pavilion: facets that radiate from the corners to points on the middle lines of the sides."""
    unit = 2.0 * half[0]
    depth, fall = _apex(values)
    outer, inner = 1.0 - values["side_length"] / 100.0, values["tip"] / 100.0
    # Heights along a middle line, from the axis (0) to the girdle (1).
    low, high = -depth * (1.0 - fall * inner), -0.5 * _side_slope(values) * (1.0 - outer)
    # Chords from end to end are less steep by `bend` than the parabola at the girdle's end, and steeper than
    # at the axis's: with this one it is between both mains at either end, and everything is convex.
    chord = (high - low) / (outer - inner)
    bend = 1.0 / (1.0 / (chord - fall * depth) + 1.0 / (0.5 * _side_slope(values) - chord))
    count = values["chevrons"]
    rows = []
    for k in range(count + 1):
        at = outer + (inner - outer) * k / count
        height = low + chord * (at - inner) + bend / (outer - inner) * (at - inner) * (at - outer)
        rows.append(
            stone.ring(f"chevron_{k}", points_at(side_points((at * half[0], at * half[1])), unit * height))
        )
    for k in range(4):
        stone.facet("pavilion_side", (lower[2 * k], lower[2 * k - 1], rows[0][k]))
    for before, after in pairwise(rows):
        for k in range(4):
            stone.facet("chevron", (lower[2 * k - 1], after[k], before[k]))
            stone.facet("chevron", (lower[2 * k], before[k], after[k]))
    culet = values["culet"] / 100.0
    has_culet = np.real(culet) > 0
    if has_culet:
        flat = side_points((culet * half[0], culet * half[1]))
        tips = stone.ring("culet", points_at(flat, -unit * values["pavilion_depth"] / 100.0))
    else:
        tips = np.repeat(stone.ring("culet", points_at(np.zeros(2), -unit * depth)), 4)
    for k in range(4):
        n = (k + 1) % 4
        ring = (lower[2 * k], rows[-1][k], tips[k], tips[n], rows[-1][n], lower[2 * k + 1])
        stone.facet("pavilion_main", dict.fromkeys(map(int, ring)))
    if has_culet:
        stone.facet("culet", tips)

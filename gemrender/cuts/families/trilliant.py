"""The trilliant, or trillion: a brilliant on a triangle.

How the facets lie, sourced: 25 crown facets, a table, 6 stars, 6 mains (rhombs and kites: three at the sides,
three in the corners) and 12 upper halves, and with three mains 15 pavilion facets: mgc-labs.ru, "Trillion"
(T-52, with 12 of the girdle); with six mains 18, and the culet: 25 and 19 (diamondsonweb.com, "Trillion cut
diamond"). Sides bowed (trilliant) or straight, corners rounded or sharp: diamondshapes.net, "Trilliant";
sides as arcs and rounded corners: github.com/vlad0007/polyhedron2, chapter 28. Length and width are measured
as by gemgate.com, "Triangular Brilliant Estimation".

Inferred: where the girdle points between corners and middles lie, the proportions, which are those that
return much light, and that three mains lie at the sides, since in the corners they would be slight. Straight
sides cannot be made: a main at the middle of one would hold all of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.brilliant import Girdle, add_crown, add_girdle, add_pavilion
from gemrender.cuts.construction.triangle import Triangle
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.heights import by_angle
from gemrender.cuts.families.parameters import Alternative, choice, culet, girdle_thickness, parameter
from gemrender.cuts.laboratory import ROUNDING
from gemrender.cuts.marks import Angle, Length, Mark, Place, Share, apex, tilt, usual_marks

__all__ = ["FAMILY", "Parameters"]

FAMILY = "trilliant"

_DEGREE = np.pi / 180
_ENDS = (" at the side", " at the corner")
#: Girdle points of pavilion mains by their number; the first girdle point is the corner at the length's end.
_MAINS = {3: (2, 6, 10), 6: (0, 2, 4, 6, 8, 10)}


@dataclass(frozen=True, slots=True)
class _Shape:
    """An outline, how much it is stretched along y, and the table's corners; in units of the outline.

    Parameters
    ----------
    outline : Triangle
        The outline with three equal sides.
    stretch : number
        What it is stretched by.
    width, longer : number
        Shorter and longer side of its box.
    table : pair of number
        Distances of the table's corners from the axis before that: towards corners, and towards sides.
    """

    outline: Triangle
    stretch: Any
    width: Any
    longer: Any
    table: tuple[Any, Any]

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> _Shape:
        """Return that of a cut with these parameters."""
        outline = Triangle(bow=values["bow"] / 100.0, radius=values["corner"] / 100.0)
        given, equal = values["length_to_width"], outline.length / outline.width
        stretch = given / equal if np.real(given) > 0 else 1.0
        sides = outline.width, outline.length * stretch
        across = sides[0].real <= sides[1].real
        width, longer = sides if across else sides[::-1]
        # The table is measured along the width; its corners at the sides are so far from the axis.
        reach = 0.5 + np.sqrt(0.75) * np.tan(values["star_azimuth"] * _DEGREE)
        extent = np.sqrt(3.0) if across else (1.0 + reach) * stretch
        corner = values["table"] / 100.0 * width / extent
        return cls(outline, stretch, width, longer, (corner, corner * reach))


def _crown_run(values: Mapping[str, Any]) -> Any:
    """Level distance from the middle of the lower side to the table [% of the width]."""
    shape = _Shape.of(values)
    return 100.0 * (shape.outline.side - shape.table[1]) * shape.stretch / shape.width


def _pavilion_run(values: Mapping[str, Any]) -> Any:
    """Level distance from the middle of the lower side to the culet [% of the width]."""
    shape = _Shape.of(values)
    return (100.0 - values["culet"]) * shape.outline.side * shape.stretch / shape.width


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(Family):
    """A trilliant.

    Parameters
    ----------
    length_to_width : float
        Length, from a side to the corner opposite, over the length of that side; 0 for three equal sides.
    bow : float
        Height of the sides' arcs over their chords [% of the chord].
    corner : float
        Radius of the rounded corners [% of the chord]; 0 for points.
    table : float
        Width of the table [% of the width, the shorter side of the outline's box], along the width.
    star_azimuth : float
        Angle by which the edges of the table are turned from the sides [deg].
    crown_height, pavilion_depth : float
        Heights of crown and pavilion [% of the width]; `crown_angle` and `pavilion_angle`, of the mains at
        the middle of the lower side [deg], stand for them.
    girdle_thickness : float
        Height of the girdle where the mains meet it [% of the width].
    star, lower_half : float
        Lengths of stars and lower halves, as of round brilliants [%].
    culet : float
        Size of the culet [% of what a pavilion cut there would be], or a laboratory's words; 0 for a
        point.
    mains : {3, 6}
        Number of pavilion mains: at the sides only, or in the corners too.

    Raises
    ------
    InputError
        A value out of range.
    """

    ALTERNATIVES: ClassVar[tuple[Alternative, ...]] = (
        by_angle("crown_angle", "crown_height", _crown_run, 5.0, 70.0, ROUNDING["crown_angle"]),
        by_angle("pavilion_angle", "pavilion_depth", _pavilion_run, 20.0, 70.0, ROUNDING["pavilion_angle"]),
    )  # fmt: skip

    length_to_width: float = parameter(0.8, 1.15, default=0.0, unit="", or_zero=True, why="three equal sides")
    bow: float = parameter(3.0, 12.0, default=10.0)
    corner: float = parameter(1.0, 8.0, default=0.0, or_zero=True)
    table: float = parameter(40.0, 75.0, default=60.0)
    star_azimuth: float = parameter(3.0, 14.0, default=8.0, unit="deg", why="somewhat bowed, as the sides")
    crown_height: float = parameter(4.0, 18.0, default=10.0)
    girdle_thickness: float = girdle_thickness(3.0)
    pavilion_depth: float = parameter(18.0, 45.0, default=33.0)
    star: float = parameter(55.0, 85.0, default=70.0)
    lower_half: float = parameter(30.0, 90.0, default=80.0)
    culet: float = culet(high=10.0)
    mains: int = choice(3, 6, default=6)

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        shape = _Shape.of(values)
        outline = shape.outline
        axes = np.array([2.0, 2.0 * shape.stretch]) / shape.longer
        centre = np.array([0.0, -0.5 * (outline.corner - outline.side)]) * axes
        equal = outline.girdle()
        girdle = Girdle(equal.points * axes + centre, equal.tangents * axes)
        turns = 60.0 * _DEGREE * np.arange(6)
        reach = np.where(np.arange(6) % 2 == 0, *shape.table)
        table = np.stack([-np.sin(turns), np.cos(turns)], axis=-1) * reach[:, None] * axes + centre
        percent = 2.0 * shape.width / shape.longer / 100.0
        stone = Construction()
        upper = add_crown(
            stone,
            girdle,
            table=table,
            star=values["star"] / 100.0,
            height=percent * values["crown_height"],
            thickness=percent * values["girdle_thickness"],
        )
        lower = add_pavilion(
            stone,
            girdle,
            depth=percent * values["pavilion_depth"],
            lower_half=values["lower_half"] / 100.0,
            culet=values["culet"] / 100.0,
            mains=_MAINS[values["mains"]],
            axis=tuple(centre),
        )
        add_girdle(stone, upper, lower, girdle)
        return stone

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows, of the side at -y and the corner at +y.

        How far table and sides are bowed are parameters where the three sides are equal; else it is only
        measured, or named.
        """
        made = self.construction()
        points, rings = made.points.real, made.rings
        edge = points[rings["girdle_upper"]].reshape(12, -1, 3)
        table, corner, side = points[rings["table"]], edge[0, 0], edge[6, 0]
        is_equal = not self.length_to_width
        without = [f"{part} angle{at}" for part in ("crown", "pavilion") for at in ("", *_ENDS)]
        marks = [
            *usual_marks(made, ends=("side", "corner"), without=[*without, "culet"]),
            Place(name="corner", view="crown", at=corner, parameter="corner"),
            *(tilt(made, kind, f"{view} angle", view, towards=(0.0, -1.0),
                   parameter=f"{view}_angle")
              for kind, view in (("bezel", "crown"), ("pavilion_main", "pavilion"))),
            Angle(name="star azimuth", view="crown", corner=table[3],
                  start=table[3] - np.array([1.0, 0.0, 0.0]), end=table[2],
                  parameter="star_azimuth" if is_equal else ""),
        ]  # fmt: skip
        if is_equal and not self.corner:
            chord = edge[4, 0] * [0.0, 1.0, 1.0]
            whole = abs(2.0 * float(edge[4, 0, 0]))
            bow: Mark = Length(name="bow", view="crown", start=side, end=chord, axis=1, whole=whole,
                         is_inside=True, parameter="bow")  # fmt: skip
        else:
            bow = Place(name="bowed side", view="crown", at=side, parameter="bow")
        marks.append(bow)
        if self.culet:
            at = points[rings["culet"]]
            marks.append(
                Share(name="culet", view="pavilion", start=apex(made), end=side, parameter="culet",
                      at=at[at[:, 1].argmin()])
            )  # fmt: skip
        return tuple(marks)

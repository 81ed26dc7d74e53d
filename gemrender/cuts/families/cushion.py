"""The cushion: a brilliant on a square or a rectangle with round corners and sides that bow out.

Laboratories tell two cutting styles (nadb.com/cushion-brilliant-vs-cushion-modified-brilliant): the *cushion
brilliant* has a round brilliant's facets; in the *cushion modified brilliant*, nearly all of today's
(petragems.com/cushion-brilliant-vs-cushion-modified-, 98 %), an extra row of facets goes round the pavilion
below the girdle, and mains and lower halves end at that row. How wide and steep it is no report says. Here it
has a facet below each half and keeps its width and depth all round, so that a smaller brilliant's pavilion
stands within it; this is the simplest of many patterns, and its width is inferred. Cushions of a public list
(huggingface.co/datasets/debadas/diamonds) are 64 to 71 % deep, as the default is. The row is as deep as makes
stones of their measurements weigh what theirs do, on average within 3 %, with a scatter of 5 %
(`scripts/weigh_reports.py`): some pavilions bulge much more than others.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.brilliant import Girdle, add_crown, add_girdle, add_pavilion
from gemrender.cuts.construction.cushion_outline import cushion
from gemrender.cuts.construction.meet_points import height_of, plane_through, points_at
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.heights import CROWN_ANGLE, PAVILION_ANGLE
from gemrender.cuts.families.parameters import Alternative, choice, girdle_thickness, parameter
from gemrender.cuts.girdle_words import CULET_RANGE, read_culet
from gemrender.cuts.marks import Mark, Place, Share, usual_marks

__all__ = ["FAMILY", "Parameters"]

FAMILY = "cushion"

_MODIFIED, _BRILLIANT = "modified brilliant", "brilliant"


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(Family):
    """A cushion.

    Parameters
    ----------
    style : {"modified brilliant", "brilliant"}
        The cutting style.
    length_to_width : float
        Length of the outline over its width, 1 to 1.5.
    bulge : float
        How far sides bow out: the height of their arc over a straight line [% of the side's length].
    corner_radius : float
        Radius of the round corners [% of the width].
    table : float
        Width of the table [% of the width], and its length [% of the length].
    table_corner : float
        How far the table's other corners, below the stone's corners, are out [% of where an outline like the
        stone's would have them]; the smaller, the more of an octagon the table is.
    crown_height, pavilion_depth : float
        Heights of crown and pavilion [% of the width]; `crown_angle` and `pavilion_angle`, from the girdle
        to the table and to the culet across the width [deg], stand for them. Of a cushion brilliant they are
        the angles of its mains there.
    girdle_thickness : float
        Height of the girdle at its thick places, where halves meet it [% of the width].
    star, lower_half : float
        Lengths of stars and lower halves, as of round brilliants [%]; the latter within the extra row.
    row_width, row_depth : float
        Of a modified brilliant, how far the extra row of facets reaches in [% of the way from the girdle to
        the axis] and down [% of the pavilion's depth].
    culet : float
        Width of the culet [% of the width], or a laboratory's words; 0 for a point.

    Raises
    ------
    InputError
        A value out of range, or corners that are rounder than the sides leave room for.
    """

    ALTERNATIVES: ClassVar[tuple[Alternative, ...]] = (CROWN_ANGLE, PAVILION_ANGLE)

    style: str = choice(_MODIFIED, _BRILLIANT, default=_MODIFIED, why="the commonest")
    length_to_width: float = parameter(1.0, 1.5, default=1.05, unit="")
    bulge: float = parameter(2.0, 15.0, default=5.0, why="a pillow, neither round nor square")
    corner_radius: float = parameter(10.0, 40.0, default=20.0, why="a pillow, neither round nor square")
    table: float = parameter(40.0, 72.0, default=60.0)
    table_corner: float = parameter(85.0, 100.0, default=92.0, why="stars about alike all round")
    crown_height: float = parameter(5.0, 30.0, default=13.0)
    girdle_thickness: float = girdle_thickness(4.5)
    pavilion_depth: float = parameter(30.0, 70.0, default=52.0)
    star: float = parameter(30.0, 75.0, default=50.0)
    lower_half: float = parameter(40.0, 90.0, default=75.0)
    row_width: float = parameter(5.0, 20.0, default=8.0, why="no report says it")
    row_depth: float = parameter(15.0, 40.0, default=29.0, why="what cushions weigh")
    culet: float = parameter(*CULET_RANGE, default=0.0, or_zero=True, words=read_culet)

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        half_width = 1.0 / values["length_to_width"]
        girdle = cushion(
            half_width,
            1.0,
            bulge=values["bulge"] / 100.0,
            corner=2.0 * half_width * values["corner_radius"] / 100.0,
        )
        percent = 2.0 * half_width / 100.0
        table = values["table"] / 100.0 * np.array([1.0, values["table_corner"] / 100.0] * 4)
        stone = Construction()
        upper = add_crown(
            stone,
            girdle,
            table=girdle.feet[::2] * table[:, None],
            star=values["star"] / 100.0,
            height=percent * values["crown_height"],
            thickness=percent * values["girdle_thickness"],
        )
        depth, culet = percent * values["pavilion_depth"], values["culet"] / 100.0
        below = {"lower_half": values["lower_half"] / 100.0, "mains": range(0, 16, 2), "axis": (0.0, 0.0)}
        if values["style"] == _BRILLIANT:
            lower = add_pavilion(stone, girdle, depth=depth, culet=culet, **below)
        else:
            share = 1.0 - values["row_width"] / 100.0
            fall = depth * values["row_depth"] / 100.0
            inner = Girdle(girdle.points[:, :1] * share, girdle.tangents)
            end = add_pavilion(
                stone, inner, depth=depth - fall, culet=culet / share, top=-fall, ring="row", **below
            )
            lower = _add_row(stone, girdle, inner.feet, -fall, end[:, 0])
        add_girdle(stone, upper, lower, girdle)
        return stone

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows."""
        made = self.construction()
        points, rings = made.points.real, made.rings
        edge = points[rings["girdle_upper"]].reshape(16, -1, 3)
        corner, middle = points[rings["table"]][1], np.array([0.0, 0.0, 1.0])
        like_outline = edge[2, 0] * self.table / 100.0
        marks = [
            *usual_marks(made),
            Place(name="bowed side", view="crown", at=edge[4, 0], parameter="bulge"),
            Place(name="round corner", view="crown", at=edge[2, 0], parameter="corner_radius"),
            Share(name="table corner", view="crown", start=middle * corner, end=like_outline, at=corner,
                  parameter="table_corner"),
        ]  # fmt: skip
        if "row" in rings:
            row, foot = points[rings["row"]][4], points[rings["girdle_lower"]].reshape(16, -1, 3)[4, 0]
            top, bottom = row * [1.0, 1.0, 0.0], np.array([row[0], row[1], points[:, 2].min()])
            marks += [
                Share(name="row width", view="pavilion", start=foot, end=middle * foot, at=row,
                      parameter="row_width"),
                Share(name="row depth", view="width", start=top, end=bottom, at=row, parameter="row_depth"),
            ]  # fmt: skip
        return tuple(marks)


def _add_row(
    stone: Construction, girdle: Girdle, inner: np.ndarray, height: Any, end: np.ndarray
) -> np.ndarray:
    """Add the extra row, down to points (16, 2) of a height, numbered `end`; return the girdle's edge."""
    feet, between = girdle.feet, girdle.points[:, 1:]
    level = points_at(feet, 0.0 * height)
    planes = plane_through(level, np.roll(level, -1, axis=0), points_at(inner, height))
    risen = points_at(between, height_of(planes[:, None], between))
    edge = np.concatenate([level[:, None], risen], axis=1)
    low = stone.ring("girdle_lower", edge.reshape(-1, 3)).reshape(edge.shape[:2])
    for j in range(len(low)):
        after_j = (j + 1) % len(low)
        stone.facet("break", (end[j], end[after_j], low[after_j, 0], *low[j, ::-1]))
    return low

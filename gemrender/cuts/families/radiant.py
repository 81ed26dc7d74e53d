"""The radiant cut: an emerald cut's outline with a brilliant's facets.

How the facets lie, sourced: H. Grossbard, US 4,020,649 (1977), claim 1: a crown of a girdle break and of a
table break of triangles; on the pavilion ridges from the culet towards the corners, about each a fan of three
pairs of triangular halves, between the fans a kite on each side at the culet, and a shield at the girdle with
its tip at the kite's. With a facet at each cut corner, as in his US 4,555,916 (1985), that makes the trade's
25 crown, 8 girdle and 37 pavilion facets, the culet counted (hkjewellery.co.uk, "Radiant Cut Diamonds").

Inferred: where the meet points lie, and that the triangles of the table break stand as in a princess's crown.
Defaults: the best table (63 to 70 %) and depth (65 to 70 %) of pobjoydiamonds.com's "Anatomy of a Radiant Cut
Diamond"; the meet points are those that return much light at such depths.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.break_crown import (
    Corners,
    Table,
    add_break_crown,
    add_side_girdle,
    corner_points,
    diagonal_points,
    side_points,
)
from gemrender.cuts.construction.meet_points import points_at
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.heights import CROWN_ANGLE, PAVILION_ANGLE
from gemrender.cuts.families.parameters import Alternative, girdle_thickness, parameter
from gemrender.cuts.marks import Mark, Place, Share, break_marks, corner_mark, slope, usual_marks

__all__ = ["FAMILY", "Parameters"]

FAMILY = "radiant"

_DEGREE = np.pi / 180


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(Family):
    """A radiant cut.

    Parameters
    ----------
    length_to_width : float
        Length of the outline over its width, 1 to 1.6.
    corner : float
        What is cut from each side at a corner [% of the width].
    table : float
        Width of the table, from side to side at the middle [% of the width].
    star_azimuth : float
        Angle by which the edges of the table are turned from the sides [deg].
    crown_height, pavilion_depth : float
        Heights of crown and pavilion [% of the width]; `crown_angle` and `pavilion_angle`, measured across
        the width [deg], stand for them.
    crown_break : float
        Height of the edges between the crown's breaks [% of the crown height].
    girdle_thickness : float
        Height of the girdle [% of the width].
    shield : float
        Length of the shields: share of the way from the girdle to the axis [%].
    ridge : float
        Length of the ridges: share of the way from the axis to the corner [%].
    kite : float
        Half the width of the kites, over their distance from the axis there [%].
    bulge : float
        By how much the kites are less steep than a straight line from the culet to the girdle [%].
    culet : float
        Width of the culet, from side to side [% of the width]; 0 for a point.

    Raises
    ------
    InputError
        A value out of range, or a pavilion that would be hollow.
    """

    ALTERNATIVES: ClassVar[tuple[Alternative, ...]] = (CROWN_ANGLE, PAVILION_ANGLE)

    length_to_width: float = parameter(1.0, 1.6, default=1.2, unit="")
    corner: float = parameter(6.0, 20.0, default=13.0)
    table: float = parameter(50.0, 80.0, default=66.0)
    star_azimuth: float = parameter(2.0, 10.0, default=6.0, unit="deg", why="as of princesses")
    crown_height: float = parameter(4.0, 20.0, default=12.0)
    crown_break: float = parameter(52.0, 70.0, default=57.0)
    girdle_thickness: float = girdle_thickness(3.5)
    pavilion_depth: float = parameter(40.0, 70.0, default=53.0)
    shield: float = parameter(35.0, 60.0, default=50.0)
    ridge: float = parameter(50.0, 75.0, default=60.0)
    kite: float = parameter(20.0, 60.0, default=40.0)
    bulge: float = parameter(10.0, 35.0, default=20.0)
    culet: float = parameter(0.2, 5.0, default=0.0, or_zero=True)

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        width, length = half = 1.0 / values["length_to_width"], 1.0
        percent = 2.0 * width / 100.0
        cut = percent * values["corner"]
        outline = Corners(half, (cut, cut), (1.0, 1.0))
        run = width * (1.0 - values["table"] / 100.0)
        stone = Construction()
        upper = add_break_crown(
            stone,
            outline,
            Table.turned((width - run, length - run), np.tan(values["star_azimuth"] * _DEGREE)),
            height=percent * values["crown_height"],
            thickness=percent * values["girdle_thickness"],
            share=values["crown_break"] / 100.0,
            split_corners=True,
        )
        lower = add_side_girdle(stone, upper, outline)
        _add_fans(stone, lower, outline, values)
        return stone

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows, on the left side and in the corner beside it."""
        made = self.construction()
        points, rings = made.points.real, made.rings
        axis, edge = np.zeros(3), np.array([points[:, 0].min(), 0.0, 0.0])
        shield, ridge, kites = points[rings["shield"]][1], points[rings["ridge"]][0], points[rings["kite"]]
        lower = points[rings["girdle_lower"]]
        return (
            *usual_marks(made),
            *break_marks(made),
            corner_mark(made),
            Share(name="shield", view="pavilion", start=edge, end=axis, at=shield, parameter="shield"),
            Share(name="ridge", view="pavilion", start=axis, end=(lower[0] + lower[1]) / 2, at=ridge,
                  parameter="ridge"),
            Place(name="kite", view="pavilion", at=kites[kites[:, 0].argmin()], parameter="kite"),
            slope("kite angle", "width", shield, points[rings["culet"]][0] * np.array([0.0, 0.0, 1.0])),
        )  # fmt: skip


def _add_fans(stone: Construction, lower: np.ndarray, outline: Corners, values: Mapping[str, Any]) -> None:
    """Add the pavilion: kites, shields and corners, and between them the fans of halves."""
    width, length = outline.half
    depth, culet = 2.0 * width * values["pavilion_depth"] / 100.0, values["culet"] / 100.0
    rise = 1.0 - values["bulge"] / 100.0  # of the kites, from the axis to the girdle, of the depth
    apex = depth / (1.0 - rise * culet)
    tip, slender = 1.0 - values["shield"] / 100.0, values["kite"] / 100.0
    wide = 0.5 * tip  # where the kites are widest
    reach = values["ridge"] / 100.0
    corner_x = reach * (width - 0.5 * outline.cut[0])
    corner_y = reach * (length - 0.5 * outline.cut[1])
    # A ridge rises more than the kites beside it, and less than where both halves along it were one facet.
    mean = 0.5 * (corner_x / width + corner_y / length)
    ridge_rise = rise * mean * (1.0 + 0.25 * (1.0 - slender) / (1.0 + slender))

    kites = points_at(
        corner_points((slender * wide * width, wide * length), (wide * width, slender * wide * length)),
        apex * (rise * wide - 1.0),
    )
    ridges = points_at(diagonal_points((corner_x, corner_y)), apex * (ridge_rise - 1.0))
    tip_flat = side_points((tip * width, tip * length))
    s = stone.ring("shield", points_at(tip_flat, apex * (rise * tip - 1.0)))
    k, r = stone.ring("kite", kites), stone.ring("ridge", ridges)
    bottom = np.array([0.0, 0.0, -apex])
    # From the axis out, anticlockwise: the ridge of a corner between the edges of two kites.
    edges = np.stack([kites[::2], ridges, kites[1::2]], axis=1)
    if np.real(culet) > 0:
        cut = bottom + (edges - bottom) * ((apex - depth) / (edges[..., 2:] + apex))
        c = stone.ring("culet", cut.reshape(-1, 3)).reshape(4, 3)
        stone.facet("culet", c.reshape(-1))
    else:
        c = np.repeat(stone.ring("culet", bottom), 12).reshape(4, 3)
    for j in range(4):
        after = (j + 1) % 4
        _add(stone, "kite", c[j, 0], k[2 * j], s[j], k[2 * j - 1], c[j - 1, 2])
        stone.facet("shield", (lower[2 * j], lower[2 * j - 1], s[j]))
        stone.facet("pavilion_corner", (lower[2 * j], lower[2 * j + 1], r[j]))
        _add(stone, "half", r[j], c[j, 1], c[j, 0], k[2 * j])
        stone.facet("half", (r[j], k[2 * j], s[j]))
        stone.facet("half", (r[j], s[j], lower[2 * j]))
        _add(stone, "half", r[j], k[2 * j + 1], c[j, 2], c[j, 1])
        stone.facet("half", (r[j], s[after], k[2 * j + 1]))
        stone.facet("half", (r[j], lower[2 * j + 1], s[after]))


def _add(stone: Construction, kind: str, *ring: int) -> None:
    """Add a facet some of whose points may be one, at the culet."""
    stone.facet(kind, dict.fromkeys(map(int, ring)))

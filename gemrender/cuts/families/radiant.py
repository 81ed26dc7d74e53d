"""The radiant cut: an emerald cut's outline with a brilliant's facets.

How the facets lie, sourced: H. Grossbard, US 4,020,649 (1977), claim 1: a crown of a girdle break and of a
table break of triangles; on the pavilion ridges from the culet towards the corners, about each a fan of three
pairs of triangular halves, between the fans a kite on each side at the culet, and a shield at the girdle with
its tip at the kite's. With a facet at each cut corner, as in his US 4,555,916 (1985), that makes the trade's
25 crown, 8 girdle and 37 pavilion facets, the culet counted. By claim 1 of the second patent kites go from
the culet to the corners, ridges to the shields, and fans are of two pairs, the outer halves of four sides: 29
of the pavilion, 62 in all. Both counts, the second as the commonest: hkjewellery.co.uk, "Radiant Cut".

Inferred: where the meet points lie, that the triangles of the table break stand as in a princess's crown, and
that the pavilion of a rectangle is a stretched one but for the corners, cut at 45 degrees. Defaults: the best
table (63 to 70 %) and depth (65 to 70 %) of pobjoydiamonds.com's "Anatomy of a Radiant Cut Diamond"; the meet
points are those that return much light at such depths.
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
from gemrender.cuts.construction.meet_points import plane_through, points_at
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.heights import CROWN_ANGLE, PAVILION_ANGLE
from gemrender.cuts.families.parameters import Alternative, choice, culet, girdle_thickness, parameter
from gemrender.cuts.marks import Mark, Place, Share, break_marks, corner_mark, slope, usual_marks

__all__ = ["FAMILY", "Parameters"]

FAMILY = "radiant"

_DEGREE = np.pi / 180
_Point = tuple[Any, Any, Any]


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
    halves : {2, 3}
        Pairs of halves in each of the pavilion's four fans: three about ridges to the corners, with kites at
        the sides, 70 facets with the culet; or two about ridges to the sides, with kites in the corners, 62.
    shield : float
        Length of the shields: share of the way from the girdle to the axis [%].
    ridge : float
        Length of the ridges to the corners, or of the kites there: share of the way from the axis [%].
    kite : float
        Half the width of the kites, over their distance from the axis there [%].
    bulge : float
        By how much the kites are less steep than a straight line from the culet to the girdle, at a side or
        at a corner [%].
    culet : float
        Width of the culet, from side to side [% of the width], or a laboratory's words; 0 for a point.

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
    halves: int = choice(2, 3, default=3, why="the patent's and 70 facets")
    shield: float = parameter(35.0, 60.0, default=50.0)
    ridge: float = parameter(50.0, 75.0, default=60.0)
    kite: float = parameter(20.0, 60.0, default=40.0)
    bulge: float = parameter(10.0, 35.0, default=20.0)
    culet: float = culet(high=5.0)

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
        _add_pavilion(stone, lower, outline, values)
        return stone

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows, on the left side and in the corner beside it."""
        made = self.construction()
        points, rings = made.points.real, made.rings
        axis, edge = np.zeros(3), np.array([points[:, 0].min(), 0.0, 0.0])
        shield, ridge, kites = points[rings["shield"]][1], points[rings["ridge"]][0], points[rings["kite"]]
        lower = points[rings["girdle_lower"]]
        # What goes from the culet to the shield's tip.
        steep = "kite angle" if self.halves == 3 else "ridge angle"
        return (
            *usual_marks(made),
            *break_marks(made),
            corner_mark(made),
            Share(name="shield", view="pavilion", start=edge, end=axis, at=shield, parameter="shield"),
            Share(name="ridge", view="pavilion", start=axis, end=(lower[0] + lower[1]) / 2, at=ridge,
                  parameter="ridge"),
            Place(name="kite", view="pavilion", at=kites[kites[:, 0].argmin()], parameter="kite"),
            slope(steep, "width", shield, points[rings["culet"]][0] * np.array([0.0, 0.0, 1.0])),
        )  # fmt: skip


def _add_pavilion(
    stone: Construction, lower: np.ndarray, outline: Corners, values: Mapping[str, Any]
) -> None:
    """Add the pavilion: kites, shields and corners, and between them the fans of halves."""
    width, length = outline.half
    depth, culet = 2.0 * width * values["pavilion_depth"] / 100.0, values["culet"] / 100.0
    at_corners = values["halves"] == 2
    place = _kites_in_corners if at_corners else _kites_at_sides
    # In shares of half the width, half the length, and the depth where the facets meet at the axis.
    tip, corner, on_x, on_y = place(outline, values)
    apex = depth / (1.0 - (tip[2] + 1.0) / tip[0] * culet)
    unit = np.array([width, length, apex])
    flat = side_points((tip[0], tip[0])), diagonal_points(corner[:2]), corner_points(on_x[:2], on_y[:2])
    heights = tip[2], corner[2], np.tile([on_x[2], on_y[2], on_y[2], on_x[2]], 2)
    tips, ridges, kites = (points_at(*pair) * unit for pair in zip(flat, heights, strict=True))
    s, r, k = stone.ring("shield", tips), stone.ring("ridge", ridges), stone.ring("kite", kites)
    bottom = np.array([0.0, 0.0, -apex])
    # From the axis out, anticlockwise, of each corner: a kite's edges, and the ridge of a fan.
    if at_corners:
        edges = np.stack([tips, kites[::2], kites[1::2]], axis=1)
    else:
        edges = np.stack([kites[::2], ridges, kites[1::2]], axis=1)
    if np.real(culet) > 0:
        cut = bottom + (edges - bottom) * ((apex - depth) / (edges[..., 2:] + apex))
        c = stone.ring("culet", cut.reshape(-1, 3)).reshape(4, 3)
        stone.facet("culet", c.reshape(-1))
    else:
        c = np.repeat(stone.ring("culet", bottom), 12).reshape(4, 3)
    for j in range(4):
        before, after, n = 2 * j, 2 * j + 1, (j + 1) % 4
        stone.facet("shield", (lower[before], lower[before - 1], s[j]))
        stone.facet("pavilion_corner", (lower[before], lower[after], r[j]))
        if at_corners:
            _add(stone, "kite", c[j, 1], k[before], r[j], k[after], c[j, 2])
            _add(stone, "half", c[j, 0], s[j], k[before], c[j, 1])
            stone.facet("half", (k[before], s[j], lower[before], r[j]))
            _add(stone, "half", c[n, 0], s[n], k[after], c[j, 2])
            stone.facet("half", (k[after], r[j], lower[after], s[n]))
        else:
            _add(stone, "kite", c[j, 0], k[before], s[j], k[before - 1], c[j - 1, 2])
            _add(stone, "half", r[j], c[j, 1], c[j, 0], k[before])
            stone.facet("half", (r[j], k[before], s[j]))
            stone.facet("half", (r[j], s[j], lower[before]))
            _add(stone, "half", r[j], k[after], c[j, 2], c[j, 1])
            stone.facet("half", (r[j], s[n], k[after]))
            stone.facet("half", (r[j], lower[after], s[n]))


def _kites_at_sides(outline: Corners, values: Mapping[str, Any]) -> tuple[_Point, ...]:
    """Return points of the first quadrant, with ridges to the corners.

    Tip of the shield on the side along y, end of the ridge, and sides of the kites that lie on the side along
    x, and on the one along y.
    """
    rise = 1.0 - values["bulge"] / 100.0
    tip, slender = 1.0 - values["shield"] / 100.0, values["kite"] / 100.0
    wide = 0.5 * tip  # where the kites are widest
    corner = _corner(outline, values)
    # A ridge rises more than the kites beside it, and less than where both halves along it were one facet.
    ridge = rise * 0.5 * (corner[0] + corner[1]) * (1.0 + 0.25 * (1.0 - slender) / (1.0 + slender))
    height = rise * wide - 1.0
    kites = (slender * wide, wide, height), (wide, slender * wide, height)
    return (tip, 0.0, rise * tip - 1.0), (*corner, ridge - 1.0), *kites


def _kites_in_corners(outline: Corners, values: Mapping[str, Any]) -> tuple[_Point, ...]:
    """Return points as `_kites_at_sides`, with ridges to the sides; kites end where ridges did."""
    tip, slender = 1.0 - values["shield"] / 100.0, values["kite"] / 100.0
    corner = _corner(outline, values)
    # Of a kite, along x as along y; at the corner's edge it would be as high as `bulge` says.
    rise = (1.0 - values["bulge"] / 100.0) * values["ridge"] / 100.0 / (corner[0] + corner[1])
    lean = (1.0 - slender) / (1.0 + slender)  # of a kite's edge to the middle of the side
    # A ridge rises more than the kites do along it, and less than where both halves along it were one facet.
    shield = rise * (1.0 + 0.5 * lean) * tip - 1.0
    end = (*corner, rise * (corner[0] + corner[1]) - 1.0)
    kites = []
    for side, girdle in zip(((0.0, tip, shield), (tip, 0.0, shield)), outline.quarter, strict=True):
        # The outer half holds the shield's tip, the girdle's corner and the kite's tip, and meets its edge.
        level = girdle[0] / outline.half[0], girdle[1] / outline.half[1], 0.0
        x, y, z, offset = plane_through(*np.array([side, level, end])[:, None])[0]
        way = (1.0, lean) if side[1] == 0.0 else (lean, 1.0)
        at = (offset / z + 1.0) / (rise * (1.0 + lean) + (way[0] * x + way[1] * y) / z)
        kites.append((way[0] * at, way[1] * at, rise * (1.0 + lean) * at - 1.0))
    return (tip, 0.0, shield), end, *kites


def _corner(outline: Corners, values: Mapping[str, Any]) -> tuple[Any, Any]:
    """Return where the facet at a corner ends, in shares of half width and length."""
    reach = values["ridge"] / 100.0
    x, y = (reach * (1.0 - 0.5 * cut / half) for cut, half in zip(outline.cut, outline.half, strict=True))
    return x, y


def _add(stone: Construction, kind: str, *ring: int) -> None:
    """Add a facet some of whose points may be one, at the culet."""
    stone.facet(kind, dict.fromkeys(map(int, ring)))

"""The marks of every cut: outline, table, heights, angles, culet, and the halves of brilliants."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.marks.kinds import Length, Mark, Share, Tilt, slope
from gemrender.stone.facets import CROWN, GIRDLE, PAVILION, side_of

__all__ = ["apex", "tilt", "usual_marks"]

#: Points whose heights, or distances from the outline's box, differ by less are in one place: rounding.
_SAME = 1e-9


def apex(made: Construction) -> np.ndarray:
    """Return where the pavilion mains of a brilliant meet, (3,): the culet, or below it."""
    mains = made.planes.real[[kind == "pavilion_main" for kind in made.kinds]]
    return np.asarray(np.linalg.lstsq(mains[:, :3], mains[:, 3], rcond=None)[0])


def tilt(
    made: Construction,
    kind: str,
    name: str,
    view: str,
    *,
    towards: Sequence[float] = (-1.0, 0.5),
    **more: Any,
) -> Tilt:
    """Return the angle of the facet of a kind that lies furthest towards a direction (x, y)."""
    points = made.points.real
    middles = {
        number: points[list(ring)].mean(axis=0)
        for number, ring in enumerate(made.corners)
        if made.kinds[number] == kind
    }
    facet = max(middles, key=lambda number: float(middles[number][:2] @ towards))
    return Tilt(name=name, view=view, at=middles[facet], normal=made.planes.real[facet, :3], **more)


def usual_marks(
    made: Construction,
    *,
    is_round: bool = False,
    ends: tuple[str, str] | None = None,
    without: Collection[str] = (),
) -> tuple[Mark, ...]:
    """Return the marks that every cut has, by their names: outline, table, heights, angles, culet, halves.

    Parameters
    ----------
    made : Construction
        The meet points, with facets "table" and, where there is one, "culet".
    is_round : bool
        Whether the girdle is the cylinder of radius 1.
    ends : tuple of str, optional
        What the ends of the length at -y and at +y are called, where they differ, such as head and point.
    without : collection of str
        Names of marks that do not suit the cut, or that its family states itself.
    """
    body = _Body.of(made, is_round=is_round)
    marks = [*_outline(body, is_round), *_profile(body, is_round, ends), *_halves(made)]
    return tuple(mark for mark in marks if mark.name not in without)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Body:
    """Where the parts of a stone are, [stone's unit]."""

    points: np.ndarray
    low: np.ndarray
    high: np.ndarray
    girdle_top: float
    girdle_bottom: float
    table: np.ndarray
    culet: np.ndarray
    bottom: np.ndarray

    @classmethod
    def of(cls, made: Construction, *, is_round: bool) -> _Body:
        points, rise = made.points.real, made.planes[:, 2].real
        low, high = points.min(axis=0), points.max(axis=0)
        if is_round:
            low[:2], high[:2] = -1.0, 1.0
        on: dict[str, set[int]] = {CROWN: set(), GIRDLE: set(), PAVILION: set()}
        for corners, z in zip(made.corners, rise.tolist(), strict=True):
            on[side_of(z)].update(corners)
        upper = on[CROWN] & (on[GIRDLE] | on[PAVILION])
        lower = on[PAVILION] & (on[GIRDLE] | on[CROWN])
        if is_round:
            upper, lower = (set(made.rings[f"girdle_{edge}"].tolist()) for edge in ("upper", "lower"))
        if "upper_girdle" in made.kinds:  # of brilliants the places where the mains meet the girdle
            upper = upper & _points_of(made, "bezel")
            lower = lower & _points_of(made, "pavilion_main") or lower
        return cls(
            points=points,
            low=low,
            high=high,
            girdle_top=float(points[sorted(upper), 2].max()),
            girdle_bottom=float(points[sorted(lower), 2].min()),
            table=_facet(made, "table"),
            culet=_facet(made, "culet"),
            bottom=points[points[:, 2] <= low[2] + _SAME],
        )

    @property
    def sides(self) -> np.ndarray:
        """(2,): the sides of the outline's box, along x and y."""
        return np.asarray((self.high - self.low)[:2])

    @property
    def across(self) -> int:
        """The axis of the width, the shorter side: 0 for x, 1 for y."""
        return int(self.sides[0] > self.sides[1] + _SAME)

    @property
    def width(self) -> float:
        return float(self.sides.min())


def _points_of(made: Construction, kind: str) -> set[int]:
    """Return the points of all facets of a kind."""
    return {
        point
        for other, corners in zip(made.kinds, made.corners, strict=True)
        if other == kind
        for point in corners
    }


def _facet(made: Construction, kind: str) -> np.ndarray:
    """Return the corners of the only facet of its kind, (k, 3); none where there is no such facet."""
    corners = made.corners[made.kinds.index(kind)] if kind in made.kinds else ()
    return np.asarray(made.points.real[np.array(corners, dtype=int)])


def _outermost(points: np.ndarray, axis: int, then: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the first and the last point along an axis; of several the outermost along another axis."""
    low, high = points[:, axis].min(), points[:, axis].max()
    other, way = then
    ends = []
    for end in (low, high):
        there = points[np.abs(points[:, axis] - end) <= _SAME]
        ends.append(there[(way * there[:, other]).argmax()])
    return ends[0], ends[1]


def _outline(body: _Body, is_round: bool) -> list[Mark]:
    """Length and width of the outline, and of the table."""
    marks: list[Mark] = []
    # Width below the stone, the table's above it, lengths to the right of it.
    if is_round:
        ends = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
        marks.append(
            Length(name="diameter", view="crown", start=ends[0], end=ends[1], axis=0, whole=body.width)
        )
    else:
        first, last = _outermost(body.points, 0, (1, -1))
        name = "width" if body.across == 0 else "side"
        marks.append(Length(name=name, view="crown", start=first, end=last, axis=0, whole=body.width))
        first, last = _outermost(body.points, 1, (0, 1))
        marks.append(
            Length(name="length-to-width", view="crown", start=first, end=last, axis=1,
                   whole=float(body.sides[0]), is_ratio=True, parameter="length_to_width")
        )  # fmt: skip
    if len(body.table):
        for axis in (0,) if is_round else (0, 1):
            first, last = _outermost(body.table, axis, (1 - axis, 1))
            is_width = axis == body.across
            words = "table" if is_round else f"table {'width' if is_width else 'length'}"
            marks.append(
                Length(name=words, view="crown", start=first, end=last, axis=axis,
                       whole=body.width if is_width else float(body.sides.max()),
                       per="width" if is_width else "length",
                       parameter="table" if is_width else "table_length")
            )  # fmt: skip
    return marks


def _profile(body: _Body, is_round: bool, ends: tuple[str, str] | None) -> list[Mark]:
    """Heights, and the angles of crown and pavilion as seen from the side: of the width, and at the ends."""
    middle = (body.low + body.high) / 2
    top = _outermost(body.points[body.points[:, 2] >= body.high[2] - _SAME], 0, (0, 1))[1]
    edges = [np.array([body.high[0], 0.0, z]) for z in (body.girdle_top, body.girdle_bottom)]
    bottom = _outermost(body.bottom, 0, (0, 1))[1]
    marks: list[Mark] = [
        Length(name=name, view="width", start=low, end=high, axis=2, whole=body.width, parameter=key)
        for name, key, low, high in (
            ("crown height", "crown_height", edges[0], top),
            ("girdle", "girdle_thickness", edges[1], edges[0]),
            ("pavilion depth", "pavilion_depth", bottom, edges[1]),
            ("depth", "depth", bottom, top),
        )
    ]
    if len(body.culet):
        first, last = _outermost(body.culet, 0, (1, 1))
        marks.append(
            Length(name="culet", view="pavilion", start=first, end=last, axis=0, whole=body.width,
                   parameter="culet")
        )  # fmt: skip
    corners: list[tuple[str, int, int, str]] = [("width", 0, 0, "")]  # view, axis, which end of it, where
    if not is_round:
        whiches = (
            [(0, " at the ends")] if ends is None else [(k, f" at the {end}") for k, end in enumerate(ends)]
        )
        corners += [("length", 1, which, where) for which, where in whiches]
    for view, axis, which, where in corners:
        for part, edge, inner in (
            ("crown", body.girdle_top, body.table),
            ("pavilion", body.girdle_bottom, body.bottom),
        ):
            if not len(inner):
                continue
            corner = middle.copy()
            corner[axis], corner[2] = (body.low, body.high)[which][axis], edge
            end = _outermost(inner, axis, (axis, 1))[which]
            key = f"{part}_angle" if axis == 0 else ""
            marks.append(slope(f"{part} angle{where}", view, corner, end, parameter=key))
    return marks


def _halves(made: Construction) -> list[Mark]:
    """Star length and lower-half length, of brilliants."""
    points, marks = made.points.real, list[Mark]()
    of_kind = {
        kind: [c for k, c in zip(made.kinds, made.corners, strict=True) if k == kind] for kind in made.kinds
    }
    if "star" in of_kind and "upper_girdle" in of_kind:
        # The star on the left, next to the end of the length; at a French tip it has a corner more.
        star = min(
            (ring for ring in of_kind["star"] if len(ring) == 3),
            key=lambda ring: (points[list(ring), 0].mean() > 0, -points[list(ring), 1].mean()),
        )
        [tip] = set(star) - set(of_kind["table"][0])
        base = [corner for corner in star if corner != tip]
        feet = _feet([ring for ring in of_kind["upper_girdle"] if tip in ring], tip)
        marks.append(
            Share(name="star length", view="crown", parameter="star", start=points[base].mean(axis=0),
                  end=_middle(points, feet), at=points[tip])
        )  # fmt: skip
    if "lower_girdle" in of_kind and "contact" in made.rings and "pavilion_main" in of_kind:
        contact = max(made.rings["contact"].tolist(), key=lambda c: (points[c, 0] < -_SAME, -points[c, 1]))
        feet = _feet([ring for ring in of_kind["lower_girdle"] if contact in ring], contact)
        marks.append(
            Share(name="lower-half length", view="pavilion", parameter="lower_half",
                  start=_middle(points, feet), end=apex(made), at=points[contact])
        )  # fmt: skip
    return marks


def _feet(halves: Sequence[tuple[int, ...]], tip: int) -> list[int]:
    """Return the girdle points of halves that meet in a tip, in order along the girdle."""
    pairs = []
    for ring in halves:
        place = ring.index(tip)
        turned = ring[place + 1 :] + ring[:place]
        pairs.append((turned[0], turned[-1]))
    after = dict(pairs)
    [first] = set(after) - set(after.values())
    feet = [first]
    while feet[-1] in after:
        feet.append(after[feet[-1]])
    return feet


def _middle(points: np.ndarray, feet: list[int]) -> np.ndarray:
    """Return the girdle point in the middle of some, or the middle of the two that are there."""
    last = len(feet) - 1
    return np.asarray((points[feet[last // 2]] + points[feet[(last + 1) // 2]]) / 2)

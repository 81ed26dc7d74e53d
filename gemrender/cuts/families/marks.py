"""What the drawing of a cut says at its arrows: lengths, angles, shares and names of places, at meet points.

A family states them in its method `marks`: those of every cut are made by `usual_marks`, those of its own by
the classes here. All are measured from the points, so that a drawing shows what the stone is.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.stone.facets import CROWN, GIRDLE, PAVILION, side_of

__all__ = ["VIEWS", "Angle", "Length", "Mark", "Place", "Share", "slope", "usual_marks"]

#: The views of a drawing, and which way their page's right and up point in the stone's frame: the crown from
#: above, the pavilion from below, and from the side with the width or the length to the right.
VIEWS: dict[str, np.ndarray] = {
    "crown": np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    "pavilion": np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]),
    "width": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "length": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
}
#: Points whose heights, or distances from the outline's box, differ by less are in one place: rounding.
_SAME = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Mark:
    """Something that a drawing says at an arrow.

    Attributes
    ----------
    name : str
        In a laboratory's words, such as "crown height".
    view : str
        The view it is drawn in, one of `VIEWS`.
    parameter : str
        The parameter or the alternative to one that it shows, where the family has it, or "depth"; "" for
        none.
    """

    name: str
    view: str
    parameter: str = ""

    @property
    def value(self) -> float | None:
        """What it measures, in the unit of the parameter; None of a place, which only has a name."""
        return None

    @property
    def text(self) -> str:
        """What is written at the arrow."""
        return self.name


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Length(Mark):
    """A length along x, y or z, drawn as a dimension line beside the stone.

    Attributes
    ----------
    start, end : (3,) float64
        The points it is measured between.
    axis : int
        Along x (0, across the width), y (1, along the length) or z (2, a height).
    whole : float
        What is 100 % [stone's unit].
    per : str
        What that is: "width" or "length".
    is_ratio : bool
        Whether it is told as a number of wholes, not in per cent.
    """

    start: np.ndarray
    end: np.ndarray
    axis: int
    whole: float
    per: str = "width"
    is_ratio: bool = False

    @property
    def value(self) -> float:
        """The length [% of the whole], or how many wholes it is."""
        length = float(abs(self.end[self.axis] - self.start[self.axis]))
        return length / self.whole if self.is_ratio else 100.0 * length / self.whole

    @property
    def text(self) -> str:
        """Name and value, as a laboratory rounds it."""
        if self.is_ratio:
            return f"{self.name} {self.value:.2f}"
        return f"{self.name} {self.value:.1f} %{' of the length' if self.per == 'length' else ''}"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Angle(Mark):
    """An angle at a corner, as it is seen in its view.

    Attributes
    ----------
    corner, start, end : (3,) float64
        The corner, and a point on either side; `slope` has level for one of them.
    """

    corner: np.ndarray
    start: np.ndarray
    end: np.ndarray

    @property
    def value(self) -> float:
        """The angle [deg]."""
        (a, b), (c, d) = (VIEWS[self.view] @ (point - self.corner) for point in (self.start, self.end))
        return float(np.degrees(np.arctan2(abs(a * d - b * c), a * c + b * d)))

    @property
    def text(self) -> str:
        """Name and value, as a laboratory rounds it."""
        return f"{self.name} {self.value:.1f}°"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Share(Mark):
    """How far along a way something reaches, drawn as arrows on the stone.

    Attributes
    ----------
    start, end : (3,) float64
        The way.
    at : (3,) float64
        Where it reaches to; it may lie beside the way.
    """

    start: np.ndarray
    end: np.ndarray
    at: np.ndarray

    @property
    def value(self) -> float:
        """The share of the way as seen in the view [%]."""
        way, reach = (VIEWS[self.view] @ (point - self.start) for point in (self.end, self.at))
        return float(100.0 * (way @ reach) / (way @ way))

    @property
    def text(self) -> str:
        """Name and value, as a laboratory rounds it."""
        return f"{self.name} {self.value:.1f} %"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Place(Mark):
    """The name of a place, such as the wing of a marquise.

    Attributes
    ----------
    at : (3,) float64
        The place.
    """

    at: np.ndarray


def slope(name: str, view: str, corner: np.ndarray, end: np.ndarray, **more: Any) -> Angle:
    """Return the angle to the level of a line from a corner, as it is seen in a view from the side."""
    level = np.array([*end[:2], corner[2]])
    return Angle(name=name, view=view, corner=corner, start=level, end=end, **more)


def usual_marks(
    made: Construction, *, is_round: bool = False, without: Collection[str] = ()
) -> tuple[Mark, ...]:
    """Return the marks that every cut has, by their names: outline, table, heights, angles, culet, halves.

    Parameters
    ----------
    made : Construction
        The meet points, with facets "table" and, where there is one, "culet".
    is_round : bool
        Whether the girdle is the cylinder of radius 1.
    without : collection of str
        Names of marks that do not suit the cut, or that its family states itself.
    """
    body = _Body.of(made, is_round=is_round)
    marks = [*_outline(body, is_round), *_profile(body, is_round), *_halves(made)]
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
    def width(self) -> float:
        return float(self.high[0] - self.low[0])

    @property
    def length(self) -> float:
        return float(self.high[1] - self.low[1])


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
        for axis, name, more in (
            (0, "width", {}),
            (1, "length-to-width", {"parameter": "length_to_width", "is_ratio": True}),
        ):
            first, last = _outermost(body.points, axis, (1, -1) if axis == 0 else (0, 1))
            marks.append(
                Length(name=name, view="crown", start=first, end=last, axis=axis, whole=body.width, **more)  # type: ignore[arg-type]
            )
    if len(body.table):
        first, last = _outermost(body.table, 0, (1, 1))
        words = "table" if is_round else "table width"
        marks.append(
            Length(name=words, view="crown", start=first, end=last, axis=0, whole=body.width,
                   parameter="table")
        )  # fmt: skip
    if len(body.table) and not is_round:
        first, last = _outermost(body.table, 1, (0, 1))
        marks.append(
            Length(name="table length", view="crown", start=first, end=last, axis=1, whole=body.length,
                   per="length", parameter="table_length")
        )  # fmt: skip
    return marks


def _profile(body: _Body, is_round: bool) -> list[Mark]:
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
    for axis, view, where in ((0, "width", ""), (1, "length", " at the ends")):
        if axis == 1 and is_round:
            continue
        for part, edge, inner in (
            ("crown", body.girdle_top, body.table),
            ("pavilion", body.girdle_bottom, body.bottom),
        ):
            if not len(inner):
                continue
            corner = middle.copy()
            corner[axis], corner[2] = body.low[axis], edge
            key = f"{part}_angle" if axis == 0 else ""
            marks.append(
                slope(
                    f"{part} angle{where}", view, corner, _outermost(inner, axis, (axis, 1))[0], parameter=key
                )
            )
    return marks


def _halves(made: Construction) -> list[Mark]:
    """Star length and lower-half length, of brilliants."""
    points, marks = made.points.real, list[Mark]()
    of_kind = {
        kind: [c for k, c in zip(made.kinds, made.corners, strict=True) if k == kind] for kind in made.kinds
    }
    if "star" in of_kind and "upper_girdle" in of_kind:
        # The star on the left, next to the end of the length.
        star = min(
            of_kind["star"],
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
        mains = made.planes.real[[kind == "pavilion_main" for kind in made.kinds]]
        apex = np.linalg.lstsq(mains[:, :3], mains[:, 3], rcond=None)[0]
        marks.append(
            Share(name="lower-half length", view="pavilion", parameter="lower_half",
                  start=_middle(points, feet), end=apex, at=points[contact])
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

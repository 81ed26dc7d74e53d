"""Kinds of marks: lengths, angles, shares of a way, and names of places."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["VIEWS", "Angle", "Length", "Mark", "Place", "Share", "Tilt", "slope"]

#: The views of a drawing, and which way their page's right and up point in the stone's frame: the crown from
#: above, the pavilion from below, and from the side with the width or the length to the right.
VIEWS: dict[str, np.ndarray] = {
    "crown": np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
    "pavilion": np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]),
    "width": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "length": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
}


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
    """A length along x, y or z, drawn as a dimension line beside the stone, or on it.

    Attributes
    ----------
    start, end : (3,) float64
        The points it is measured between; from the one to the other it is positive along its axis.
    axis : int
        Along x (0, across the width), y (1, along the length) or z (2, a height).
    whole : float
        What is 100 % [stone's unit].
    per : str
        What that is: "width" or "length".
    is_ratio : bool
        Whether it is told as a number of wholes, not in per cent.
    is_inside : bool
        Whether it is drawn on the stone itself.
    """

    start: np.ndarray
    end: np.ndarray
    axis: int
    whole: float
    per: str = "width"
    is_ratio: bool = False
    is_inside: bool = False

    @property
    def value(self) -> float:
        """The length [% of the whole], or how many wholes it is."""
        length = float(self.end[self.axis] - self.start[self.axis])
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
    is_beyond : bool
        Whether it is told how far beyond the end it reaches, or short of it.
    """

    start: np.ndarray
    end: np.ndarray
    at: np.ndarray
    is_beyond: bool = False

    @property
    def value(self) -> float:
        """The share of the way as seen in the view, or what is beyond its end [%]."""
        start, end, at = (VIEWS[self.view] @ point for point in (self.start, self.end, self.at))
        way = end - start
        return float(100.0 * (way @ (at - (end if self.is_beyond else start))) / (way @ way))

    @property
    def text(self) -> str:
        """Name and value, as a laboratory rounds it."""
        if not self.is_beyond:
            return f"{self.name} {self.value:.1f} %"
        # Rounding has a sign, too.
        return f"{self.name} {round(self.value, 1) + 0.0:+.1f} %"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Place(Mark):
    """The name of a place, such as the wing of a marquise.

    Attributes
    ----------
    at : (3,) float64
        The place.
    """

    at: np.ndarray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tilt(Mark):
    """The angle of a facet to the girdle plane, told at the facet.

    Attributes
    ----------
    at : (3,) float64
        A place on the facet.
    normal : (3,) float64
        Its normal.
    """

    at: np.ndarray
    normal: np.ndarray

    @property
    def value(self) -> float:
        """The angle [deg]."""
        x, y, z = self.normal.tolist()
        return float(np.degrees(np.arctan2(np.hypot(x, y), abs(z))))

    @property
    def text(self) -> str:
        """Name and value, as a laboratory rounds it."""
        return f"{self.name} {self.value:.1f}°"


def slope(name: str, view: str, corner: np.ndarray, end: np.ndarray, **more: Any) -> Angle:
    """Return the angle to the level of a line from a corner, as it is seen in a view from the side."""
    level = np.array([*end[:2], corner[2]])
    return Angle(name=name, view=view, corner=corner, start=level, end=end, **more)

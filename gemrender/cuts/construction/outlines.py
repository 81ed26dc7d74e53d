"""Outlines of stones seen from above, as girdle points and points between them; analytic.

An outline with two or one mirror planes is made of curves from the belly, its widest place, to an end: the
round end of an oval, or a wing, which ends in a point.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gemrender.cuts.construction.brilliant import Girdle

__all__ = ["PIECES", "circle", "ellipse", "marquise", "pear"]

#: Facets of a girdle that is not round, between two girdle points: 64 all round, as girdles are faceted.
PIECES = 4

#: From places along a curve, 0 at the belly and 1 at its end, its points and directions (..., 2): on the
#: right of the stone, with the end above the belly.
_Curve = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def circle(count: int = 16) -> Girdle:
    """Return the circle of radius 1, whose girdle is a cylinder, with so many girdle points.

    The first lies at +x, as that of round brilliants in the paper's frame.
    """
    end = _round_end(1.0, 1.0, 0.0)
    outline = _outline(end, end, count=count, pieces=1)
    points, tangents = (np.roll(of, count // 4, axis=0) for of in (outline.points, outline.tangents))
    return Girdle(points, tangents, is_round=True)


def ellipse(half_width: Any, half_length: Any = 1.0, *, shoulder: Any = 0.0, count: int = 16) -> Girdle:
    """Return an ellipse: a circle that is stretched, with its girdle points.

    Parameters
    ----------
    half_width, half_length : number
        Half of its sides.
    shoulder : number
        How much further out its shoulders are than those of an ellipse, half-way between the ends of width
        and length [share of the distance from the middle]; less than 0 where they slope.
    count : int
        Number of girdle points, 4 times a whole number.
    """
    end = _round_end(half_width, half_length, shoulder)
    return _outline(end, end, count=count)


def marquise(half_width: Any, *, wing: Any = 0.0, count: int = 16) -> Girdle:
    """Return two arcs that meet in points, half a length of 1 from the middle.

    Parameters
    ----------
    half_width : number
        Half of its width.
    wing : number
        How much further out its wings are than arcs of circles, half-way to the point [share of the half
        width]; less than 0 for flatter ones.
    count : int
        Number of girdle points, 4 times a whole number.
    """
    end = _wing(half_width, 1.0, wing)
    return _outline(end, end, count=count)


def pear(half_width: Any, head: Any, *, shoulder: Any = 0.0, wing: Any = 0.0, count: int = 16) -> Girdle:
    """Return a round head below the belly and two wings above, which meet in a point; smooth at the belly.

    Parameters
    ----------
    half_width : number
        Half of its width.
    head : number
        Height of the head, from its end to the belly; the whole length is 2.
    shoulder, wing : number
        As of `ellipse` and `marquise`.
    count : int
        Number of girdle points, 4 times a whole number.
    """
    lower, upper = _round_end(half_width, head, shoulder), _wing(half_width, 2.0 - head, wing)
    return _outline(upper, lower, belly=head - 1.0, count=count)


def _round_end(half_width: Any, height: Any, shoulder: Any) -> _Curve:
    """Return a quarter of an ellipse; its distance from the middle times 1 + shoulder sin^2(2 angle)."""

    def curve(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        turn = np.pi / 2
        sin, cos = np.sin(places * turn), np.cos(places * turn)
        far = 1.0 + shoulder * (2.0 * sin * cos) ** 2
        farther = shoulder * 8.0 * sin * cos * (cos * cos - sin * sin)
        points = np.stack([half_width * cos * far, height * sin * far], axis=-1)
        along = [half_width * (cos * farther - sin * far), height * (sin * farther + cos * far)]
        return points, np.stack(along, axis=-1)

    return curve


def _wing(half_width: Any, height: Any, bulge: Any) -> _Curve:
    """Return an arc that runs along the length at the belly and ends in a point.

    Its radius is (half_width^2 + height^2) / (2 half_width). With v, the share of the way to the point, it
    lies half_width bulge 4 v^2 (1 - v^2) further out.
    """

    def curve(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        radius = (half_width**2 + height**2) / (2.0 * half_width)
        turn = 2.0 * np.arctan(half_width / height)
        sin, cos = np.sin(places * turn), np.cos(places * turn)
        v = radius * sin / height
        out = 4.0 * half_width * bulge
        x = radius * cos - (radius - half_width) + out * v**2 * (1.0 - v**2)
        further = out * (2.0 * v - 4.0 * v**3) * radius * cos / height
        return np.stack([x, v * height], axis=-1), np.stack([further - radius * sin, radius * cos], axis=-1)

    return curve


def _outline(upper: _Curve, lower: _Curve, *, belly: Any = 0.0, count: int, pieces: int = PIECES) -> Girdle:
    """Return an outline from the curves above and below the belly, anticlockwise from its end at +y on."""
    quarter = count * pieces // 4
    places = np.arange(quarter + 1) / quarter
    (up, up_along), (down, down_along) = upper(places), lower(places)
    down, down_along = down * [1.0, -1.0], down_along * [1.0, -1.0]
    for points, along, side in ((up, up_along, 1.0), (down, down_along, -1.0)):
        # On the axes exactly; at an end the direction across the length, even where it is a point.
        points[0, 1] = points[-1, 0] = along[0, 0] = along[-1, 1] = 0.0
        along[0, 1], along[-1, 0] = side, -1.0
    left = [-1.0, 1.0]
    points = np.concatenate([up[:0:-1] * left, down[:-1] * left, down[:0:-1], up[:-1]])
    along = np.concatenate(
        [-up_along[:0:-1] * left, down_along[:-1] * left, -down_along[:0:-1], up_along[:-1]]
    )
    points[:, 1] += belly
    return Girdle(points.reshape(count, pieces, 2), along.reshape(count, pieces, 2)[:, 0])

"""Outlines of stones seen from above, as girdle points and points between them; analytic."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.cuts.construction.brilliant import Girdle

__all__ = ["PIECES", "circle", "ellipse"]

#: Facets of a girdle that is not round, between two girdle points: 64 all round, as girdles are faceted.
PIECES = 4


def circle(count: int = 16) -> Girdle:
    """Return the circle of radius 1, whose girdle is a cylinder, with so many girdle points.

    The first lies at +x, as that of round brilliants in the paper's frame.
    """
    points, tangents = _on_circle(0.75 + np.arange(count)[:, None] / count)
    return Girdle(points, tangents[:, 0], is_round=True)


def ellipse(half_width: Any, half_length: Any = 1.0, *, count: int = 16, pieces: int = PIECES) -> Girdle:
    """Return an ellipse: a circle that is stretched, with its girdle points."""
    places = (np.arange(count)[:, None] + np.arange(pieces) / pieces) / count
    points, tangents = _on_circle(places)
    axes = np.array([half_width, half_length])
    return Girdle(points * axes, tangents[:, 0] * axes)


def _on_circle(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points of the unit circle and its directions there, anticlockwise from +y [turns]."""
    # Exact on the axes and alike in all octants.
    quarter, rest = np.divmod(places * 4.0 % 4.0, 1.0)
    sin, cos = np.sin(rest * (np.pi / 2)), np.cos(rest * (np.pi / 2))
    x = np.choose(quarter.astype(int), [-sin, -cos, sin, cos])
    y = np.choose(quarter.astype(int), [cos, -sin, -cos, sin])
    return np.stack([x, y], axis=-1), np.stack([-y, x], axis=-1)

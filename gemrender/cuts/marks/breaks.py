"""The marks of a crown of two rows, as of princesses and radiants."""

from __future__ import annotations

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.marks.kinds import Angle, Mark, Share

__all__ = ["break_marks"]


def break_marks(made: Construction) -> tuple[Mark, ...]:
    """Return the marks of a crown with rings "break", "table_side" and "table_corner", on its left side.

    The height of the edge between both rows, as share of the crown's, and the angle by which the table's edge
    is turned from the side.
    """
    points = made.points.real
    edge = points[made.rings["break"]]
    at = edge[edge[:, 0].argmin()]
    start, end = at.copy(), at.copy()
    start[2], end[2] = points[made.rings["girdle_upper"], 2].max(), points[:, 2].max()
    side = points[made.rings["table_side"]][1]
    corner = points[made.rings["table_corner"]][0]
    return (
        Share(name="crown break", view="width", start=start, end=end, at=at, parameter="crown_break"),
        Angle(name="star azimuth", view="crown", corner=side, start=side + np.array([0.0, 1.0, 0.0]),
              end=corner, parameter="star_azimuth"),
    )  # fmt: skip

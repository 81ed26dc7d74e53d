"""The marks of step cuts: the angle of each step, how far they bulge, and the keel."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.marks.kinds import Length, Mark, slope

__all__ = ["corner_mark", "step_marks"]

#: Points whose places differ by less are in one place: rounding.
_SAME = 1e-9


def corner_mark(made: Construction, **more: Any) -> Mark:
    """Return what the cut corner at the upper left takes from a side, of an outline with straight sides."""
    points = made.points.real
    on_left = points[points[:, 0] <= points[:, 0].min() + _SAME]
    on_end = points[points[:, 1] >= points[:, 1].max() - _SAME]
    start, end = on_left[on_left[:, 1].argmax()], on_end[on_end[:, 0].argmin()]
    width = float(np.ptp(points[:, 0]))
    more = {"name": "corner", "parameter": "corner", **more}
    return Length(view="crown", start=start, end=end, axis=0, whole=width, **more)


def step_marks(made: Construction) -> tuple[Mark, ...]:
    """Return the marks of steps between levels: rings "crown_0", "crown_1" ..., "pavilion_0" ... and "keel".

    The angles are those of the steps at the end of the length, on the left of that view. The bulge is how far
    the level in the middle, of two the one nearer to the girdle, stands out of the line from the girdle to
    the table or the keel, in height.
    """
    points = made.points.real
    width = float(np.ptp(points[:, 0]))
    marks: list[Mark] = []
    for part in ("crown", "pavilion"):
        levels = [points[ring] for name, ring in made.rings.items() if name.startswith(f"{part}_")]
        if part == "pavilion" and "keel" in made.rings:
            levels.append(points[made.rings["keel"]])
        steps = len(levels) - 1
        ends = [level[level[:, 1].argmin()] for level in levels]
        marks += [slope(f"{part} step {row + 1}", "length", ends[row], ends[row + 1]) for row in range(steps)]
        if steps < 2:
            continue
        sides = [level[level[:, 0].argmin()] for level in levels]
        row = steps // 2
        out, first, last = sides[row], sides[0], sides[-1]
        on_line = out.copy()
        on_line[2] = first[2] + (last[2] - first[2]) * (out[0] - first[0]) / (last[0] - first[0])
        low, high = sorted((on_line, out), key=lambda point: float(point[2]))
        marks.append(
            Length(name=f"{part} bulge", view="width", start=low, end=high, axis=2, whole=width,
                   is_inside=True, parameter=f"{part}_bulge")
        )  # fmt: skip
    if "keel" in made.rings:
        high, low = points[made.rings["keel"]]
        if high[1] - low[1] > _SAME:
            marks.append(
                Length(name="keel length", view="pavilion", start=low, end=high, axis=1,
                       whole=float(np.ptp(points[:, 1])), per="length")
            )  # fmt: skip
    return tuple(marks)

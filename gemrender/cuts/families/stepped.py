"""What step cuts have in common: what their drawings say besides that of every cut."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.marks import Length, Mark, slope, usual_marks

__all__ = ["SteppedCut"]


class SteppedCut(Family):
    """A family of step cuts, made by `construction.steps.step_cut`."""

    __slots__ = ()

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows: also the angle of each step, the bulges, the corners."""
        made = self.construction()
        return (*usual_marks(made), *_corner(made), *_steps(made, "crown"), *_steps(made, "pavilion"))


def _corner(made: Construction) -> list[Mark]:
    """Return what a cut corner takes from an end, at +y on the left."""
    if "crown_corner_1" not in made.kinds:
        return []
    outline = made.points.real[made.rings["crown_0"]]
    left, inner = sorted(outline[np.argsort(-outline[:, 1], kind="stable")[:4]], key=lambda point: point[0])[
        :2
    ]
    return [
        Length(
            name="corner", view="crown", parameter="corner", start=left, end=inner, axis=0, whole=_width(made)
        )
    ]


def _steps(made: Construction, part: str) -> list[Mark]:
    """Return the angles of the rows across the width, and how far they stand out of the straight line."""
    rows = sum(kind.startswith(f"{part}_side_") for kind in set(made.kinds))
    rings = [made.rings.get(f"{part}_{row}", made.rings.get("keel")) for row in range(rows + 1)]
    levels = [made.points.real[ring] for ring in rings]
    left = [ring[ring[:, 0].argmin()] for ring in levels]
    marks: list[Mark] = [
        slope(f"{part} step {row}", "width", start, end) for row, (start, end) in enumerate(pairwise(left), 1)
    ]
    # Along the length, where heights do not need the place beside the stone.
    end = [ring[ring[:, 1].argmax()] for ring in levels]
    first, most, last = end[0], end[rows // 2], end[-1]
    line = first + (most[1] - first[1]) / (last[1] - first[1]) * (last - first)
    marks.append(
        Length(
            name=f"{part} bulge", view="length", parameter=f"{part}_bulge", start=line, end=most, axis=2,
            whole=_width(made),
        )
    )  # fmt: skip
    return marks


def _width(made: Construction) -> float:
    return float(np.ptp(made.points.real[:, 0]))

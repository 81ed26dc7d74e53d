"""The pear brilliant, or drop: a round brilliant's facets on a round head and two wings to a point."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.outlines import pear
from gemrender.cuts.families.elongated import ElongatedBrilliant, shoulder_mark, tips, wing_marks
from gemrender.cuts.families.parameters import parameter
from gemrender.cuts.marks import Length, Mark, apex, usual_marks

__all__ = ["FAMILY", "Parameters"]

FAMILY = "pear"


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(ElongatedBrilliant):
    """A pear brilliant, its point at +y.

    It has the parameters of ovals and marquises, and some of outline, point and culet. Length to width:
    1.50 to 1.75 is common (diamonds27.com, "Length to width ratio"), 1.50 to 1.65 preferred (Adamas Studio).

    Parameters
    ----------
    head : float
        Height of the head, from its end to the belly [% of the width]: 50 for half a circle.
    shoulder : float
        How much further out the shoulders of the head are than those of half an ellipse, as of an oval [%].
        GIA, "Girdle Outline": squared shoulders make pears look triangular.
    wing : float
        How much further out the wings are than arcs of circles, as of a marquise [% of half the width].
    tips : {"bezel", "french"}
        Whether a bezel ends at the point, or a ridge, as of a marquise.
    culet_to_point : float
        How far from the belly towards the point the culet lies [% of the length].

    Raises
    ------
    InputError
        A value out of range.
    """

    length_to_width: float = parameter(1.1, 2.5, default=1.55, unit="")
    head: float = parameter(40.0, 60.0, default=50.0, why="half a circle")
    shoulder: float = parameter(-6.0, 8.0, default=2.5, why="as full as weights in the trade")
    wing: float = parameter(-8.0, 8.0, default=4.0, why="as full as weights in the trade")
    tips: str = tips()
    culet_to_point: float = parameter(-5.0, 15.0, default=0.0, why="on the belly")

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        half_width = 1.0 / values["length_to_width"]
        head = half_width * values["head"] / 50.0
        girdle = pear(half_width, head, shoulder=values["shoulder"] / 100.0, wing=values["wing"] / 100.0)
        belly = head - 1.0
        return cls.on_outline(
            girdle,
            values,
            belly=belly,
            culet_at=belly + values["culet_to_point"] / 50.0,
            french=(0,) if values["tips"] == "french" else (),
        )

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows."""
        made = self.construction()
        width = 2.0 / self.length_to_width
        edge = made.points.real[made.rings["girdle_upper"]]
        end, belly = edge[edge[:, 1].argmin()], edge[edge[:, 0].argmax()]
        head = Length(name="head", view="crown", start=end, end=belly, axis=1, whole=width, parameter="head")
        marks = [*usual_marks(made, ends=("head", "point")), *wing_marks(made), head]
        height = float(belly[1] - end[1])
        marks.append(shoulder_mark(made, width / 2, height, belly=float(belly[1]), below=True))
        if self.culet_to_point:
            marks.append(
                Length(name="culet from the belly", view="pavilion", start=belly * np.array([0.0, 1.0, 1.0]),
                       end=apex(made), axis=1, whole=2.0, per="length", is_inside=True,
                       parameter="culet_to_point")
            )  # fmt: skip
        return tuple(marks)

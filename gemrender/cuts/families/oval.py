"""The oval brilliant: a round brilliant's facets on an ellipse."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.outlines import ellipse
from gemrender.cuts.families.elongated import ElongatedBrilliant, shoulder_mark
from gemrender.cuts.families.parameters import girdle_thickness, parameter
from gemrender.cuts.marks import Mark, usual_marks

__all__ = ["FAMILY", "Parameters"]

FAMILY = "oval"


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(ElongatedBrilliant):
    """An oval brilliant.

    It has the parameters of marquises and pears, and one of its outline. Length to width: 1.33 to 1.66 is
    common (diamonds27.com, "Length to width ratio"), 1.37 to 1.55 recommended (Diamond Screener, "Oval Cut
    Diamond Guide").

    Parameters
    ----------
    shoulder : float
        How much further out its shoulders are than those of an ellipse, half-way between the ends of width
        and length [% of the distance from the middle]; less than 0 where they slope. Fuller by default, for
        the weight. GIA, "Girdle Outline": shoulders "should be gently and evenly rounded", and squared ones
        make a stone weigh more.

    Raises
    ------
    InputError
        A value out of range.
    """

    length_to_width: float = parameter(1.0, 2.5, default=1.4, unit="")
    girdle_thickness: float = girdle_thickness(4.5)
    shoulder: float = parameter(-6.0, 8.0, default=2.5, why="as full as weights in the trade")

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        girdle = ellipse(1.0 / values["length_to_width"], shoulder=values["shoulder"] / 100.0)
        return cls.on_outline(girdle, values)

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows."""
        made = self.construction()
        return (*usual_marks(made), shoulder_mark(made, 1.0 / self.length_to_width, 1.0))

"""The marquise brilliant, or navette: a round brilliant's facets on two arcs that meet in points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.outlines import marquise
from gemrender.cuts.families.elongated import ElongatedBrilliant, tips, wing_marks
from gemrender.cuts.families.parameters import parameter
from gemrender.cuts.marks import Mark, usual_marks

__all__ = ["FAMILY", "Parameters"]

FAMILY = "marquise"


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(ElongatedBrilliant):
    """A marquise brilliant.

    It has the parameters of ovals and pears, and two of wings and points. Length to width: 1.75 to
    2.25 is common (diamonds27.com, "Length to width ratio"), 1.90 to 2.10 preferred (Adamas Studio).

    Parameters
    ----------
    wing : float
        How much further out the wings, the sides near the points, are than arcs of circles, half-way to the
        point [% of half the width]; less than 0 for flatter ones. GIA, "Girdle Outline": too flat they make
        a stone look narrow, too rounded they make it look short and stubby. The default is inferred: then a
        marquise of 2 to 1 weighs the 0.0058 carat/mm^3 x length x width x depth of the trade's formula
        (Esslinger, "Stone weight estimation formula", blog.esslinger.com, 2014) within 1 %.
    tips : {"bezel", "french"}
        Whether a bezel ends at each point, or it is left out (French tip): then stars and upper halves are
        extended and meet in a ridge to the point. "Sometimes cut with a French tip; this serves as a
        replacement for the large bezel facet at the point with star and upper girdle facets" (Diamond World,
        "Marquise", diamondworld.be).

    Raises
    ------
    InputError
        A value out of range.
    """

    length_to_width: float = parameter(1.2, 3.0, default=2.0, unit="")
    wing: float = parameter(-8.0, 8.0, default=4.0, why="as full as weights in the trade")
    tips: str = tips()

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        girdle = marquise(1.0 / values["length_to_width"], wing=values["wing"] / 100.0)
        return cls.on_outline(girdle, values, french=(0, 4) if values["tips"] == "french" else ())

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows."""
        made = self.construction()
        return (*usual_marks(made), *wing_marks(made))

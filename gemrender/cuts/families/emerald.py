"""The emerald cut: a rectangle with cut corners, in steps.

Facets: a table and three rows of eight facets on the crown, three on the pavilion, 49 without the girdle's
eight; also four and five rows on the pavilion ("Asscher": 49, 57 or 75 facets, mgc-labs.ru; 58 with a girdle,
prosumerdiamonds.com, "Emerald cut"). Rows of one half are equally wide, seen from above, as a cutter makes
them: Duncan Miller, "Facetips: a simple emerald cut" (ctminsoc.org.za), with pavilion rows 5 to 10 degrees
apart and crown rows 15 degrees.

Sources of the defaults: F. Cuellar, "Classes of Cut" (diamondcuttersintl.com), classes I and II of emerald
cuts: table 53 to 65 %, crown height 11.2 to 16.2 % at 32 to 35 deg, pavilion depth 47.1 to 53.1 % at 43.3 to
46.8 deg, across the width. Length to width: 1.38 to 1.52 (pobjoydiamonds.com, "Anatomy of an emerald cut
diamond"). Bulges and girdle are inferred, so that stones weigh what reports of the market say; corners from
pictures.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.steps import profile, rectangle, step_cut
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.heights import CROWN_ANGLE, PAVILION_ANGLE
from gemrender.cuts.families.parameters import Alternative, choice, culet, girdle_thickness, parameter
from gemrender.cuts.marks import Mark, corner_mark, step_marks, usual_marks

__all__ = ["FAMILY", "Parameters"]

FAMILY = "emerald"


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(Family):
    """An emerald cut.

    Parameters
    ----------
    length_to_width : float
        Length of the outline over its width, 1 to 2.5.
    corner : float
        What a cut corner takes from each of its sides [% of the width].
    table : float
        Width of the table [% of the width]; it is as far from the outline at the ends as at the sides.
    crown_height, pavilion_depth : float
        Heights of crown and pavilion [% of the width]; `crown_angle` and `pavilion_angle`, of the straight
        line from the girdle to the table or the keel, across the width [deg], stand for them.
    crown_bulge, pavilion_bulge : float
        How far the steps stand out of that line, in height [% of the width].
    girdle_thickness : float
        Height of the girdle [% of the width].
    culet : float
        Width of the culet [% of the width], or a laboratory's words; 0 for a keel.
    pavilion_steps : {3, 4, 5}
        Rows of facets of the pavilion.

    Raises
    ------
    InputError
        A value out of range.
    """

    ALTERNATIVES: ClassVar[tuple[Alternative, ...]] = (CROWN_ANGLE, PAVILION_ANGLE)

    length_to_width: float = parameter(1.0, 2.5, default=1.4, unit="")
    corner: float = parameter(4.0, 30.0, default=12.0, why="as in pictures")
    table: float = parameter(40.0, 80.0, default=65.0)
    crown_height: float = parameter(6.0, 25.0, default=12.0)
    crown_bulge: float = parameter(0.2, 3.0, default=2.0, why="steps of 46, 34 and 19 deg")
    girdle_thickness: float = girdle_thickness(4.5)
    pavilion_depth: float = parameter(35.0, 65.0, default=50.0)
    pavilion_bulge: float = parameter(0.5, 8.0, default=5.5, why="steps of 53, 45 and 34 deg")
    culet: float = culet()
    pavilion_steps: int = choice(3, 4, 5, default=3, why="the commonest")

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        half_width = 1.0 / values["length_to_width"]
        percent = 2.0 * half_width / 100.0
        return step_cut(
            rectangle(half_width, 1.0, percent * values["corner"]),
            crown=profile(
                3,
                1.0 - values["table"] / 100.0,
                percent * values["crown_height"],
                percent * values["crown_bulge"],
            ),
            thickness=percent * values["girdle_thickness"],
            pavilion=profile(
                values["pavilion_steps"],
                1.0 - values["culet"] / 100.0,
                percent * values["pavilion_depth"],
                percent * values["pavilion_bulge"],
            ),
        )

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows; the ends are as steep as the sides, and have the steps."""
        made = self.construction()
        without = ("crown angle at the ends", "pavilion angle at the ends")
        return (*usual_marks(made, without=without), *step_marks(made), corner_mark(made))

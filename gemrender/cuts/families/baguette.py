"""The baguette: a rectangle without cut corners, straight or tapered, in steps.

"Unbeveled corners, usually only two rows of facets": bijandiamonds.com, "Baguette"; three on the crown of a
classical one: mgc-labs.ru, "Baguette cut". Length to width 3 is common (Kenan & Dana Design, "Baguette cut
diamonds"), side stones are shorter. No source states heights: they are inferred from emerald cuts, somewhat
flatter and with less bulge, so that it weighs 0.0096 carat/mm3 x length x width x depth, 5 % above the
0.00915 of the trade's formula for plain stones (3dbook.octonus.com, "Mounting diamonds weight
determination").
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.steps import profile, step_cut, trapezoid
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.heights import CROWN_ANGLE, PAVILION_ANGLE
from gemrender.cuts.families.parameters import Alternative, choice, girdle_thickness, parameter
from gemrender.cuts.marks import Length, Mark, step_marks, usual_marks

__all__ = ["FAMILY", "Parameters"]

FAMILY = "baguette"


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(Family):
    """A baguette.

    Parameters
    ----------
    length_to_width : float
        Length of the outline over its width, 1 to 5.
    taper : float
        Width of the narrow end [% of the width]; 100 for a straight baguette. The keel of a tapered one rises
        to its narrow end.
    table : float
        Width of the table [% of the width], at the wide end; it is as far from the outline at the ends as at
        the sides.
    crown_height, pavilion_depth : float
        Heights of crown and pavilion [% of the width]; `crown_angle` and `pavilion_angle`, of the straight
        line from the girdle to the table or the keel, across the width [deg], stand for them.
    crown_bulge, pavilion_bulge : float
        How far the steps stand out of that line, in height [% of the width].
    girdle_thickness : float
        Height of the girdle [% of the width].
    steps : {2, 3}
        Rows of facets of the crown, and of the pavilion.

    Raises
    ------
    InputError
        A value out of range.
    """

    ALTERNATIVES: ClassVar[tuple[Alternative, ...]] = (CROWN_ANGLE, PAVILION_ANGLE)

    length_to_width: float = parameter(1.0, 5.0, default=2.0, unit="")
    taper: float = parameter(60.0, 100.0, default=100.0, why="straight")
    table: float = parameter(50.0, 80.0, default=65.0)
    crown_height: float = parameter(5.0, 20.0, default=11.0)
    crown_bulge: float = parameter(0.2, 3.0, default=1.5, why="steps of 39 and 25 deg")
    girdle_thickness: float = girdle_thickness(3.5)
    pavilion_depth: float = parameter(30.0, 60.0, default=46.0)
    pavilion_bulge: float = parameter(0.5, 7.0, default=3.5, why="steps of 47 and 38 deg")
    steps: int = choice(2, 3, default=2, why="the commonest")

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        half_width = 1.0 / values["length_to_width"]
        percent = 2.0 * half_width / 100.0
        plan = trapezoid(half_width, 1.0, values["taper"] / 100.0)
        return step_cut(
            plan,
            crown=profile(
                values["steps"],
                1.0 - values["table"] / 100.0,
                percent * values["crown_height"],
                percent * values["crown_bulge"],
            ),
            thickness=percent * values["girdle_thickness"],
            pavilion=profile(
                values["steps"],
                1.0,
                percent * values["pavilion_depth"],
                percent * values["pavilion_bulge"],
                plan.reach,
            ),
        )

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows; its narrow end is at -y."""
        made = self.construction()
        without = [f"{part} angle at the ends" for part in ("crown", "pavilion")]
        edge = made.points.real[made.rings["pavilion_0"]]
        narrow = edge[edge[:, 1] < 0]
        start, end = narrow[narrow[:, 0].argsort()]
        taper = Length(name="narrow end", view="pavilion", start=start, end=end, axis=0,
                       whole=2.0 / self.length_to_width, parameter="taper")  # fmt: skip
        return (*usual_marks(made, without=without), *step_marks(made), taper)

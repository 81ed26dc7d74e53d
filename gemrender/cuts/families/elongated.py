"""What ovals, marquises and pears have in common: a round brilliant's facets on a longer outline.

Sources of the defaults: Adamas Studio, "Gabrielle's Ideals" for oval, marquise and pear (adamas.studio,
diamond-education): table 59 to 61 %, depth 58 to 63 %, crown 12.5 to 15 % at 33.7 to 35.8 deg, pavilion 41 to
44 % at 40.2 to 41.25 deg, girdle 2.5 to 4.5 %. Older and shallower: F. Cuellar, "Classes of Cut"
(diamondcuttersintl.com), class I of marquise, pear and oval: table 53 to 60 %, crown 13.5 to 16.2 %, pavilion
39.25 to 40.75 deg. Diamond Screener, "Oval Cut Diamond Guide" (diamondscreener.com): depth 60 to 63 %,
table 56 to 60 %. All are measured across the width, as reports do. 58 facets with the culet, of which
4 to 8 are pavilion mains: Lathiya Gems, "Pear" (lathiyagems.com).

Outlines are a little fuller than ellipses and arcs of circles, so that stones of the common lengths weigh
what the trade's formulas say within 3 %: 0.0062 of mean diameter^2 and depth of an oval, 0.00570 to 0.00585
of length, width and depth of a marquise, 0.00615 to 0.00575 of a pear [carat, mm] (Gemgate, "Diamond Weight
Estimate", gemgate.com; Esslinger, "Stone Weight Estimation Formula", blog.esslinger.com).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.brilliant import Girdle, brilliant, widths
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.heights import CROWN_ANGLE, PAVILION_ANGLE
from gemrender.cuts.families.parameters import Alternative, choice, culet, girdle_thickness, parameter
from gemrender.cuts.marks import Mark, Place, Share

__all__ = ["ElongatedBrilliant", "shoulder_mark", "tips", "wing_marks"]

#: Girdle points of pavilion mains by their number; the first girdle point is an end of the length. With six
#: the mains at both ends are left out ("to only 56 facets when the pavilion facets at the head and tail are
#: eliminated", yourjewel.com, "Loose Diamonds"). With four also those at the belly: what is left is an X.
#: No source was found for which four: of those that leave both mirror planes it is the set without the belly.
_MAINS = {4: (2, 6, 10, 14), 6: (2, 4, 6, 10, 12, 14), 8: tuple(range(0, 16, 2))}

#: The table's length follows the stated width of the table, and may be stated itself.
_TABLE_LENGTH = Alternative(
    "table_length", "table_elongation", 20.0, 95.0,
    lambda length, values: length / values["table"],
    lambda values: values["table"] * values["table_elongation"],
    0.5,
)  # fmt: skip


def tips() -> Any:
    """Return the field of how a crown ends at its points."""
    return choice("bezel", "french", default="bezel", why="the commonest")


@dataclass(frozen=True, slots=True, kw_only=True)
class ElongatedBrilliant(Family):
    """A brilliant on a longer outline; of its parameters those that all have.

    Parameters
    ----------
    length_to_width : float
        Length of the outline over its width.
    table : float
        Width of the table [% of the width].
    table_elongation : float
        Length to width of the table over that of the outline; at 1 the bezels at the ends are as many times
        less steep than those at the belly as they are longer. `table_length`, the length of the table [% of
        the length], stands for it.
    crown_height, pavilion_depth : float
        Heights of crown and pavilion [% of the width]; `crown_angle` and `pavilion_angle`, measured across
        the width [deg], stand for them.
    girdle_thickness : float
        Height of the girdle at its thick places, where the mains meet it [% of the width].
    star, lower_half : float
        Lengths of stars and lower halves, as of round brilliants [%].
    culet : float
        Width of the culet [% of the width], or a laboratory's words; 0 for a point.
    mains : {4, 6, 8}
        Number of pavilion mains: all; none at the ends; none at ends and belly.
    """

    ALTERNATIVES: ClassVar[tuple[Alternative, ...]] = (CROWN_ANGLE, PAVILION_ANGLE, _TABLE_LENGTH)

    length_to_width: float = parameter(1.0, 3.0, default=1.5, unit="")
    table: float = parameter(30.0, 80.0, default=59.0)
    table_elongation: float = parameter(
        0.85, 1.2, default=1.05, unit="", why="bezels somewhat less flat at the ends"
    )
    crown_height: float = parameter(5.0, 30.0, default=14.0)
    girdle_thickness: float = girdle_thickness(3.5)
    pavilion_depth: float = parameter(25.0, 65.0, default=43.8)
    star: float = parameter(20.0, 80.0, default=50.0)
    lower_half: float = parameter(30.0, 95.0, default=75.0)
    culet: float = culet()
    mains: int = choice(4, 6, 8, default=8, why="the commonest")

    @staticmethod
    def on_outline(
        girdle: Girdle,
        values: dict[str, Any],
        *,
        belly: Any = 0.0,
        culet_at: Any = 0.0,
        french: Sequence[int] = (),
    ) -> Construction:
        """Return meet points and facets on an outline; the table lies about the middle of the belly.

        Parameters
        ----------
        girdle : Girdle
            The outline, with 16 girdle points.
        values : dict of str to number
            The parameters above, real or complex.
        belly, culet_at : number
            Where belly and culet lie along the length.
        french : sequence of int
            Table corners at French tips.
        """
        width = 2.0 / values["length_to_width"]
        middle = np.array([0.0, belly])
        share = values["table"] / 100.0
        shares = np.array([share, share * values["table_elongation"]])
        percent = width / 100.0
        mains = _MAINS[values["mains"]]
        return brilliant(
            girdle,
            table=middle + (girdle.feet[::2] - middle) * shares,
            star=values["star"] / 100.0,
            crown_height=percent * values["crown_height"],
            thickness=percent * values["girdle_thickness"],
            pavilion_depth=percent * values["pavilion_depth"],
            lower_half=values["lower_half"] / 100.0,
            culet=values["culet"] / 100.0 * widths(girdle, mains),
            mains=mains,
            axis=(0.0, culet_at),
            french=french,
        )


def shoulder_mark(
    made: Construction, half_width: float, height: float, *, belly: float = 0.0, below: bool = False
) -> Mark:
    """Return how far the left shoulder of a round end is beyond that of half an ellipse.

    Parameters
    ----------
    made : Construction
        The meet points.
    half_width, height : float
        Half the width, and the height of the end above the belly [stone's unit].
    belly : float
        Where the belly lies along the length.
    below : bool
        Whether the end is the one below the belly.
    """
    edge = made.points.real[made.rings["girdle_upper"]]
    at = edge[len(edge) * (3 if below else 1) // 8]
    middle = np.array([0.0, belly, at[2]])
    way = np.sqrt(0.5) * np.array([-half_width, -height if below else height, 0.0])
    return Share(name="shoulder", view="crown", start=middle, end=middle + way, at=at, is_beyond=True,
                 parameter="shoulder")  # fmt: skip


def wing_marks(made: Construction) -> tuple[Mark, ...]:
    """Return the names of places of an outline whose upper end is a point: point, wing and belly."""
    edge = made.points.real[made.rings["girdle_upper"]]
    belly = edge[edge[:, 0].argmin()]
    return (
        Place(name="point", view="crown", at=edge[0]),
        Place(name="wing", view="crown", at=edge[len(edge) * 3 // 32], parameter="wing"),
        Place(name="belly", view="crown", at=belly),
    )

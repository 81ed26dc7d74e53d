"""The round brilliant: the paper's proportions, and a culet, painted and dug out girdle facets.

Painting and digging out are as GIA has them (Rapaport Diamond Report, June 2005; quoted with drawings and
measured girdles at goodoldgold.com/painting-digging-dug): halves are dug out where they lean towards each
other, so that they are steeper, the angle to the main beside them is larger and the girdle thinner where
halves meet, and painted where they lean towards the main. Reports say no more than how strongly (GIA
Facetware). Here it is by how much the azimuth of a half is turned from that of the standard cut, 11.25 deg
from its main, while it still passes through the main's girdle point and the star's tip, or the point where
lower halves meet; turned towards the main is positive. Upper and lower halves have each their own.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np

from gemrender.cuts.construction import Construction
from gemrender.cuts.construction.brilliant import brilliant
from gemrender.cuts.construction.outlines import circle
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.heights import CROWN_ANGLE, PAVILION_ANGLE
from gemrender.cuts.families.parameters import Alternative, girdle_thickness, parameter
from gemrender.cuts.girdle_words import CULET_RANGE, read_culet
from gemrender.cuts.marks import Mark, Place, usual_marks
from gemrender.cuts.round_brilliant.proportions import RANGES, RoundBrilliant
from gemrender.errors import InputError
from gemrender.stone import Stone

__all__ = ["FAMILY", "MOST_PAINTING", "Parameters", "with_culet"]

FAMILY = "round brilliant"

#: Halves of the standard cut lie 11.25 deg beside their main, and as far beside where they meet. Turned by so
#: much they are still well apart from both [deg].
MOST_PAINTING = 8.0

_REFERENCE = "GIA's reference stone"
#: Of an eighth of a turn, half: from a main to where halves meet.
_COS = np.cos(np.pi / 8)
#: Pavilion mains keep this share of their least width beside the culet.
_MARGIN = 0.98

#: Lower halves as the paper has them: from the axis, not from the girdle.
_CONTACT = Alternative(
    "lower_girdle_contact", "lower_half", 1.0, 99.0,
    lambda contact, _: 100.0 - contact,
    lambda values: 100.0 - values["lower_half"],
    0.0,
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(Family):
    """A round brilliant.

    Without a culet, painting and digging out it is the stone of the paper's proportions.
    The first mains stand at +x, and z is 0 at the lower edge of the girdle below the mains.

    Parameters
    ----------
    table : float
        Distance between opposite corners of the table [% of the diameter].
    crown_height, pavilion_depth : float
        Heights of crown and pavilion, down to the culet [% of the diameter]; `crown_angle` and
        `pavilion_angle`, those of the mains [deg], stand for them.
    girdle_thickness : float
        Height of the girdle at its thick places, where the mains meet it [% of the diameter].
    star : float
        Star length: of the way from the middle of a table edge to the girdle [%].
    lower_half : float
        Lower-half length: of the way from the girdle to the axis [%]; `lower_girdle_contact`, 100 less it,
        stands for it.
    culet : float
        Width of the culet, from main to main [% of the diameter], or a laboratory's words; 0 for a point.
    crown_painting, pavilion_painting : float
        By how much upper and lower girdle facets are turned towards the mains [deg]: painted where positive,
        dug out where negative.

    Raises
    ------
    InputError
        A value out of range, stars that would rise above the table, a culet that reaches the lower halves.
    """

    ALTERNATIVES: ClassVar[tuple[Alternative, ...]] = (CROWN_ANGLE, PAVILION_ANGLE, _CONTACT)
    IS_ROUND: ClassVar[bool] = True

    table: float = parameter(*RANGES["table"], default=57.0, why=_REFERENCE)
    crown_height: float = parameter(*RANGES["crown_height"], default=14.5, why=_REFERENCE)
    girdle_thickness: float = girdle_thickness(2.5, *RANGES["girdle_thickness"])
    pavilion_depth: float = parameter(*RANGES["pavilion_depth"], default=43.0, why=_REFERENCE)
    star: float = parameter(*RANGES["star"], default=50.0, why=_REFERENCE)
    lower_half: float = parameter(*RANGES["lower_girdle_contact"], default=80.0, why=_REFERENCE)
    culet: float = parameter(*CULET_RANGE, default=0.0, or_zero=True, words=read_culet)
    crown_painting: float = parameter(-MOST_PAINTING, MOST_PAINTING, default=0.0, unit="deg")
    pavilion_painting: float = parameter(-MOST_PAINTING, MOST_PAINTING, default=0.0, unit="deg")

    def __post_init__(self) -> None:
        Family.__post_init__(self)
        self.proportions()
        most = _MARGIN * _COS * (100.0 - self.lower_half)
        if self.culet > most:
            raise InputError(
                f"would reach the lower halves: for lower_half = {self.lower_half:g} % it must be at most "
                f"{most:.3g} %",
                key="culet",
                value=self.culet,
            )

    @property
    def is_painted(self) -> bool:
        """Whether girdle facets are painted or dug out."""
        return bool(self.crown_painting or self.pavilion_painting)

    def proportions(self) -> RoundBrilliant:
        """Return the paper's proportions: all but culet, painting and digging out.

        Raises
        ------
        InputError
            The star tips would lie above the table.
        """
        return RoundBrilliant(
            table=self.table,
            star=self.star,
            lower_girdle_contact=100.0 - self.lower_half,
            crown_height=self.crown_height,
            pavilion_depth=self.pavilion_depth,
            girdle_thickness=self.girdle_thickness,
        )

    @classmethod
    def construct(cls, **values: Any) -> Construction:
        """Return meet points and facets; complex values give complex points."""
        girdle = circle()
        return brilliant(
            girdle,
            table=girdle.feet[::2] * values["table"] / 100.0,
            star=values["star"] / 100.0,
            crown_height=values["crown_height"] / 50.0,
            thickness=values["girdle_thickness"] / 50.0,
            pavilion_depth=values["pavilion_depth"] / 50.0,
            lower_half=values["lower_half"] / 100.0,
            culet=values["culet"] / 100.0,
            crown_painting=values["crown_painting"] * (np.pi / 180.0),
            pavilion_painting=values["pavilion_painting"] * (np.pi / 180.0),
        )

    def marks(self) -> tuple[Mark, ...]:
        """Return what its drawing says at arrows."""
        made = self.construction()
        turned = []
        for view, kind, name, by in (
            ("crown", "upper_girdle", "upper halves", "crown_painting"),
            ("pavilion", "lower_girdle", "lower halves", "pavilion_painting"),
        ):
            angle = getattr(self, by)
            if angle:
                words = f"{name} {'painted' if angle > 0 else 'dug out'} {abs(angle):.1f}°"
                halves = [
                    made.points.real[list(ring)].mean(axis=0)
                    for other, ring in zip(made.kinds, made.corners, strict=True)
                    if other == kind
                ]
                left = min(halves, key=lambda at: float(at[0]))
                turned.append(Place(name=words, view=view, at=left, parameter=by))
        return (*usual_marks(made, is_round=True), *turned)

    def stone(self, **facts: Any) -> Stone:
        """Make the stone; `facts` are fields of `Stone` such as its name.

        Raises
        ------
        InputError
            Painted or dug out facets make no convex stone, or leave no girdle where they meet.
        """
        if not self.culet and not self.is_painted:
            return Stone.from_proportions(self.proportions(), **facts)
        made = self.construction()
        if not self.is_painted:  # its own checks are enough, as for the paper's proportions
            return self.stone_of(made, **facts)
        rings, heights = made.rings, made.points[:, 2]
        left = float((heights[rings["girdle_upper"]] - heights[rings["girdle_lower"]])[1]) * 50.0
        if left < 0:
            raise InputError(
                f"is too thin for girdle facets that are dug out so far: it must be at least "
                f"{self.girdle_thickness - left:.3g} %",
                key="girdle_thickness",
                value=self.girdle_thickness,
            )
        made.check()
        return self.stone_of(made, **facts)


def with_culet(proportions: RoundBrilliant, culet: float) -> RoundBrilliant | Parameters:
    """Return the cut of the paper's proportions and a culet [% of the diameter]; its depth is down to that.

    Raises
    ------
    InputError
        As for `Parameters`.
    """
    if not culet:
        return proportions
    values = asdict(proportions)
    return Parameters(lower_half=100.0 - values.pop("lower_girdle_contact"), culet=culet, **values)

"""The old European cut: the round brilliant of about 1890 to 1930, facet by facet the same.

GIA calls a stone so where three of four hold: table at most 53 %, crown angle at least 40 deg, lower halves
at most 60 %, culet slightly large or larger ("Describing round unmodified brilliant cut diamonds at GIA
Laboratory", October 2013). All four do here by default.
"""

from __future__ import annotations

from dataclasses import dataclass

from gemrender.cuts.families import round_brilliant
from gemrender.cuts.families.parameters import girdle_thickness, parameter
from gemrender.cuts.girdle_words import CULET_RANGE, CULET_WORDS, read_culet
from gemrender.cuts.round_brilliant.proportions import RANGES

__all__ = ["FAMILY", "Parameters"]

FAMILY = "old european"

_GIA = "within what GIA calls old European"


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters(round_brilliant.Parameters):
    """An old European cut; all as in a round brilliant, and without a culet the same stone.

    Parameters
    ----------
    table : float
        Distance between opposite corners of the table [% of the diameter].
    crown_height, pavilion_depth : float
        Heights of crown and pavilion, down to the culet [% of the diameter]; `crown_angle` and
        `pavilion_angle`, those of the mains [deg], stand for them.
    girdle_thickness : float
        Height of the girdle at its thick places, where the mains meet it [% of the diameter].
    star, lower_half : float
        Star length and lower-half length [%]; `lower_girdle_contact`, 100 less the latter, stands for it.
    culet : float
        Width of the culet, from main to main [% of the diameter], or a laboratory's words; 0 for a point.
    crown_painting, pavilion_painting : float
        By how much upper and lower girdle facets are turned towards the mains [deg].

    Raises
    ------
    InputError
        As of a round brilliant.
    """

    table: float = parameter(*RANGES["table"], default=48.0, why=_GIA)
    crown_height: float = parameter(*RANGES["crown_height"], default=22.0, why=f"40 deg, {_GIA}")
    girdle_thickness: float = girdle_thickness(2.0, *RANGES["girdle_thickness"])
    pavilion_depth: float = parameter(*RANGES["pavilion_depth"], default=40.6, why="41 deg")
    star: float = parameter(*RANGES["star"], default=45.0, why="short as those of old cuts")
    lower_half: float = parameter(*RANGES["lower_girdle_contact"], default=50.0, why=_GIA)
    culet: float = parameter(
        *CULET_RANGE, default=CULET_WORDS["large"], or_zero=True, words=read_culet, why=_GIA
    )

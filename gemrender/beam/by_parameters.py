"""Derivatives of a family's scores by each of its parameters, and by the angles that stand for heights.

A girdle of plane facets leaves nothing but polygons, so that all is exact; near a round girdle the light is
followed as for round brilliants (`slopes`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import fields
from itertools import compress
from typing import NamedTuple

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.compiled import STEP
from gemrender.beam.derivatives import Sensitivity, are_wanted, derivative, result
from gemrender.beam.slopes import exact_slopes, has_room, slopes_within
from gemrender.beam.solid import beam_stone
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.parameters import unit_of
from gemrender.errors import InputError
from gemrender.measures.measure import Measure
from gemrender.measures.tally import Tally
from gemrender.stone import Stone

__all__ = ["Change", "by_parameters", "changes_of"]


class Change(NamedTuple):
    """One parameter, or an alternative to one, that changes while all others stay.

    Parameters
    ----------
    parameter : str
        Its name.
    kept : {"proportions", "angles"}
        Whether the other parameters stay, or where angles stand for heights the angles.
    value : float
        What it is.
    held : dict of str to float
        Angles that stay, by name: the heights follow.
    """

    parameter: str
    kept: str
    value: float
    held: dict[str, float]

    def planes(self, cut: Family) -> np.ndarray:
        """Return the cut's planes, (p, 4) complex128, with their derivatives by it [1/unit]."""
        return cut.planes(**self.held, **{self.parameter: complex(self.value, STEP)})

    def moved(self, stone: Stone, by: float) -> Stone:
        """Return the stone with it changed.

        Raises
        ------
        InputError
            It is out of its range, or makes no stone.
        """
        assert isinstance(stone.cut, Family)
        changed = stone.cut.changed(**self.held, **{self.parameter: self.value + by})
        return changed.stone(name=stone.name, material=stone.material)


def changes_of(cut: Family) -> Iterator[Change]:
    """Yield what a cut is differentiated by: its numbers, its angles, and its numbers with angles kept."""
    numbers = {part.name: getattr(cut, part.name) for part in fields(cut) if "range" in part.metadata}  # type: ignore[arg-type]
    angles = {other.name: float(value) for other, value in zip(
        cut.ALTERNATIVES, cut.alternatives().values(), strict=True)}  # fmt: skip
    for name, value in numbers.items():
        yield Change(name, "proportions", value, {})
    for name, value in angles.items():
        yield Change(name, "angles", value, {})
    heights = {other.stands_for for other in cut.ALTERNATIVES}
    for name, value in numbers.items():
        if name in heights:
            continue
        moved = cut.values(**{name: complex(value, STEP)})
        held = {
            other.name: angles[other.name]
            for other in cut.ALTERNATIVES
            if complex(other.from_parameter(moved)).imag
        }
        if held:  # an angle that would change with it
            yield Change(name, "angles", value, held)


def by_parameters(
    stone: Stone,
    cut: Family,
    tally: Tally,
    over_views: Sequence[Measure],
    wanted: float,
    seed: int,
    budget: Budget,
    progress: Callable[[float], None] | None,
    start: float,
    parameters: Collection[str | tuple[str, str]] | None = None,
) -> Sensitivity:
    """Differentiate by a family's parameters; see `gemrender.beam.sensitivity.sensitivity`."""
    changes = list(changes_of(cut))
    wanted_ones = are_wanted(parameters, [(change.parameter, change.kept) for change in changes])
    changes = list(compress(changes, wanted_ones))
    if stone.is_round:
        # Near the girdle light is told by differences: of a culet that there is none of there is no such.
        changes = [change for change in changes if has_room(stone, change.moved)]
        if not changes:
            raise InputError("leaves no room for a difference on either side", source=stone.name)
        base, slopes = slopes_within(
            stone,
            [(change.planes(cut), change.moved) for change in changes],
            tally, wanted, seed, budget, progress, over_views,
        )  # fmt: skip
        scores, girdle = base.scores().mean(axis=0), base.girdle
    else:
        moving = [(change.planes(cut), 1.0) for change in changes]
        scores, slopes = exact_slopes(
            beam_stone(stone), moving, tally, wanted, seed, budget, progress, over_views, whole=False
        )  # fmt: skip
        girdle = 0.0
    measures = [*tally.measures, *over_views]
    derivatives = [
        derivative(change.parameter, change.kept, unit_of(cut, change.parameter), measures, slope)
        for change, slope in zip(changes, slopes, strict=True)
    ]
    return result(stone, tally, scores, derivatives, girdle, start)

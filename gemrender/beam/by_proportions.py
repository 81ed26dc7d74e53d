"""Derivatives of a round brilliant's scores by each of its proportions and angles."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import asdict
from functools import partial
from itertools import compress

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.compiled import STEP
from gemrender.beam.derivatives import Sensitivity, are_wanted, derivative, result
from gemrender.beam.slopes import slopes_within
from gemrender.cuts.round_brilliant import RoundBrilliant
from gemrender.cuts.round_brilliant.planes import facet_planes
from gemrender.cuts.round_brilliant.proportions import brilliant_vertices
from gemrender.measures.measure import Measure
from gemrender.measures.tally import Tally
from gemrender.stone import Stone

__all__ = ["PROPORTIONS", "by_angles", "by_proportions", "proportion_planes"]

#: The proportions that a stone is differentiated by, as `RoundBrilliant` names them.
PROPORTIONS = (
    "table", "star", "lower_girdle_contact", "crown_height", "pavilion_depth", "girdle_thickness"
)  # fmt: skip


def proportion_planes(proportions: RoundBrilliant, parameter: str) -> np.ndarray:
    """Return a brilliant's planes, (57, 4) complex128, with their derivatives by a proportion [1/%]."""
    numbers: dict[str, complex] = asdict(proportions)
    numbers[parameter] = complex(numbers[parameter], STEP)
    return facet_planes(brilliant_vertices(**numbers))


def by_proportions(
    stone: Stone,
    tally: Tally,
    over_views: Sequence[Measure],
    wanted: float,
    seed: int,
    budget: Budget,
    progress: Callable[[float], None] | None,
    start: float,
    parameters: Collection[str | tuple[str, str]] | None = None,
) -> Sensitivity:
    """Differentiate by proportions and angles; see `gemrender.beam.sensitivity.sensitivity`."""
    proportions = stone.proportions
    assert proportions is not None
    # Of each its unit, and the derivatives of proportions by it: those by angles follow by the chain rule.
    rows: dict[tuple[str, str], tuple[str, dict[str, float]]] = {
        **{(name, "proportions"): ("%", {name: 1.0}) for name in PROPORTIONS},
        **{(name, "angles"): of for name, of in by_angles(proportions).items()},
    }
    rows = dict(compress(rows.items(), are_wanted(parameters, list(rows))))
    needed = [name for name in PROPORTIONS if any(name in chain for _, chain in rows.values())]
    changes = [(proportion_planes(proportions, name), partial(_moved, name)) for name in needed]
    base, found = slopes_within(stone, changes, tally, wanted, seed, budget, progress, over_views)
    slopes = dict(zip(needed, found, strict=True))
    measures = [*tally.measures, *over_views]
    derivatives = [
        derivative(name, kept, unit, measures, np.sum([by * slopes[of] for of, by in chain.items()], axis=0))
        for (name, kept), (unit, chain) in rows.items()
    ]
    return result(stone, tally, base.values().mean(axis=0), derivatives, base.girdle, start)


def _moved(parameter: str, stone: Stone, by: float) -> Stone:
    """Return a stone with one proportion changed [%]."""
    numbers = asdict(stone.proportions)
    numbers[parameter] += by
    return Stone.from_proportions(RoundBrilliant(**numbers), material=stone.material)


def by_angles(proportions: RoundBrilliant) -> dict[str, tuple[str, dict[str, float]]]:
    """Return what a laboratory report prints: of each its unit, and the derivatives of proportions by it.

    crown height = (100 - table) / 2 tan(crown angle), pavilion depth = 50 tan(pavilion angle).
    """
    crown, pavilion = (math.radians(a) for a in (proportions.crown_angle_deg, proportions.pavilion_angle_deg))
    degree, half = math.radians(1.0), (100.0 - proportions.table) / 2
    return {
        "table": ("%", {"table": 1.0, "crown_height": -0.5 * math.tan(crown)}),
        "crown_angle": ("deg", {"crown_height": degree * half / math.cos(crown) ** 2}),
        "pavilion_angle": ("deg", {"pavilion_depth": degree * 50.0 / math.cos(pavilion) ** 2}),
        "lower_half": ("%", {"lower_girdle_contact": -1.0}),
    }

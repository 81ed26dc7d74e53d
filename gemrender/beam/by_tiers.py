"""Derivatives of a design's scores by angle and distance of each tier: everything is polygons, so exact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.compiled import STEP
from gemrender.beam.derivatives import Sensitivity, derivative, result
from gemrender.beam.slopes import exact_slopes
from gemrender.beam.solid import beam_stone
from gemrender.cuts.design import Design
from gemrender.measures.measure import Measure
from gemrender.measures.tally import Tally
from gemrender.stone import Stone

__all__ = ["by_tiers", "design_unit", "tier_parameters", "tier_planes"]


def tier_planes(stone: Stone, design: Design, tier: int, quantity: str) -> np.ndarray:
    """Return a design's planes, (p, 4) complex128, with their derivatives by a tier's angle or distance.

    Parameters
    ----------
    stone : Stone
        The stone of the design.
    design : Design
        The design.
    tier : int
        Number of the tier, from 0.
    quantity : {"angle_deg", "distance"}
        By the angle [1/deg], or by the distance [1 per unit of the design].

    Notes
    -----
    The frame stays where it is: scores do not depend on it.
    """
    value = complex(getattr(design.tiers[tier], quantity), STEP)
    moved = _facet_planes(stone, design.with_tier(tier, **{quantity: value}))
    origin, unit = _frame(stone, moved.real)
    return np.column_stack([moved[:, :3], (moved[:, 3] - moved[:, :3] @ origin) / unit])


def by_tiers(
    stone: Stone,
    design: Design,
    tally: Tally,
    over_views: Sequence[Measure],
    wanted: float,
    seed: int,
    budget: Budget,
    progress: Callable[[float], None] | None,
    start: float,
) -> Sensitivity:
    """Differentiate by angle and distance of each tier that has facets on the stone."""
    if tally.model.rear == "position":
        # The same, where the girdle's lower edge is level; it does not stay so when one tier moves.
        tally = tally.of_model(replace(tally.model, rear="facet"))
    parameters = tier_parameters(stone, design)
    names, unit = design.tier_names(), design_unit(stone, design)
    # A distance counts in per cent of the stone's unit.
    changes = [
        (tier_planes(stone, design, tier, quantity), 1.0 if quantity == "angle_deg" else 0.01 * unit)
        for tier, quantity in parameters
    ]
    scores, slopes = exact_slopes(
        beam_stone(stone), changes, tally, wanted, seed, budget, progress, over_views, whole=True
    )  # fmt: skip
    derivatives, measures = [], [*tally.measures, *over_views]
    for (tier, quantity), slope in zip(parameters, slopes, strict=True):
        words, of = ("angle", "deg") if quantity == "angle_deg" else ("distance", "%")
        derivatives.append(derivative(f"{names[tier]} {words}", "tiers", of, measures, slope))
    return result(stone, tally, scores, derivatives, 0.0, start)


def tier_parameters(stone: Stone, design: Design) -> list[tuple[int, str]]:
    """Return tiers with facets on the stone, and "angle_deg" or "distance": what can be changed of each."""
    number = {name: k for k, name in enumerate(design.facet_names())}
    of_tier = design.facet_tiers
    tiers = sorted({int(of_tier[number[facet.name]]) for facet in stone.facets})
    parameters = []
    for tier in tiers:
        angle = abs(complex(design.tiers[tier].angle_deg).real)
        if 0.0 < angle < 90.0:  # tables and girdle facets are level, or stand upright
            parameters.append((tier, "angle_deg"))
        parameters.append((tier, "distance"))
    return parameters


def design_unit(stone: Stone, design: Design) -> float:
    """Return the stone's unit of length in that of its design."""
    return _frame(stone, _facet_planes(stone, design))[1]


def _facet_planes(stone: Stone, design: Design) -> np.ndarray:
    """Return the design's planes of the stone's facets, in their order, (p, 4)."""
    number = {name: k for k, name in enumerate(design.facet_names())}
    return design.planes()[[number[facet.name] for facet in stone.facets]]


def _frame(stone: Stone, planes: np.ndarray) -> tuple[np.ndarray, float]:
    """Return origin (3,) and unit of the stone's frame in its design's, from the design's planes (p, 4).

    What takes these to the stone's: offset = (distance - normal . origin) / unit.
    """
    system = np.column_stack([planes[:, :3], stone.solid.planes[:, 3]])
    *origin, unit = np.linalg.lstsq(system, planes[:, 3], rcond=None)[0]
    return np.array(origin), float(unit)

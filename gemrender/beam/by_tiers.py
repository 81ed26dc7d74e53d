"""Derivatives of a design's scores by angle and distance of each tier: everything is polygons, so exact."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from itertools import compress

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.compiled import STEP
from gemrender.beam.derivatives import Sensitivity, are_wanted, derivative, result
from gemrender.beam.slopes import exact_slopes
from gemrender.beam.solid import beam_stone
from gemrender.cuts.design import Design
from gemrender.cuts.meets import changeable
from gemrender.cuts.turning import Quantity, parameter_name, tier_parameters, values_of, with_tiers
from gemrender.errors import InputError
from gemrender.measures.measure import Measure
from gemrender.measures.tally import Tally
from gemrender.stone import Stone

__all__ = ["KEPT_BY_WAY", "by_tiers", "design_unit", "parameters_of_stone", "tier_planes"]

#: What `Derivative.kept` says where meets are free, loose and kept.
KEPT_BY_WAY = {"free": "tiers", "loose": "middles", "kept": "meets"}


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
    return _in_stone(stone, design.with_tier(tier, **{quantity: value}))


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
    parameters: Collection[str | tuple[str, str]] | None = None,
    meets: str = "free",
) -> Sensitivity:
    """Differentiate by angle and distance of each tier that has facets on the stone.

    With meets "kept" or "loose" (`gemrender.cuts.meets.WAYS`) other tiers follow, or the tier's own distance
    its angle. What cannot be changed with meets kept is left out.
    """
    if tally.model.rear == "position":
        # The same, where the girdle's lower edge is level; it does not stay so when one tier moves.
        tally = tally.of_model(replace(tally.model, rear="facet"))
    ways = changeable(design, meets)
    if ways.design is not design:  # its meets were closed
        design = ways.design
        stone = design.stone(
            name=stone.name,
            material=stone.material,
            source=stone.source,
            size_mm=stone.size_mm,
            crystal=stone.crystal,
        )
    unit = design_unit(stone, design)
    angles, distances = values_of(design)
    names, changes = [], []
    known = parameters_of_stone(stone, design)
    wanted_ones = are_wanted(parameters, [(parameter_name(design, *of), KEPT_BY_WAY[meets]) for of in known])
    for tier, quantity in compress(known, wanted_ones):
        with contextlib.suppress(InputError):
            by_angle, by_distance = ways.slopes(tier, quantity)
            moving = with_tiers(
                design,
                (angles + 1j * STEP * by_angle).tolist(),
                (distances + 1j * STEP * by_distance).tolist(),
            )
            is_angle = quantity == "angle_deg"
            # A distance counts in per cent of the stone's unit.
            changes.append((_in_stone(stone, moving), 1.0 if is_angle else 0.01 * unit))
            names.append((parameter_name(design, tier, quantity), "deg" if is_angle else "%"))
    scores, slopes = exact_slopes(
        beam_stone(stone), changes, tally, wanted, seed, budget, progress, over_views, whole=True
    )  # fmt: skip
    measures = [*tally.measures, *over_views]
    derivatives = [
        derivative(name, KEPT_BY_WAY[meets], of, measures, slope)
        for (name, of), slope in zip(names, slopes, strict=True)
    ]
    return result(stone, tally, scores, derivatives, 0.0, start)


def parameters_of_stone(stone: Stone, design: Design) -> list[tuple[int, Quantity]]:
    """Return tiers with facets on the stone, and "angle_deg" or "distance": what can be changed of each."""
    number = {name: k for k, name in enumerate(design.facet_names())}
    return tier_parameters(design, (number[facet.name] for facet in stone.facets))


def design_unit(stone: Stone, design: Design) -> float:
    """Return the stone's unit of length in that of its design."""
    return _frame(stone, _facet_planes(stone, design))[1]


def _in_stone(stone: Stone, design: Design) -> np.ndarray:
    """Return a design's planes of the stone's facets in the stone's frame, (p, 4); complex as they are."""
    moved = _facet_planes(stone, design)
    origin, unit = _frame(stone, moved.real)
    return np.column_stack([moved[:, :3], (moved[:, 3] - moved[:, :3] @ origin) / unit])


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

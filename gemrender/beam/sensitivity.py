"""Derivatives of a stone's scores by its proportions or tiers, moving edges included.

Areas and intensities of the virtual facets are smooth functions of the planes, and so are their edges: the
derivative of a sum over them is exact, by the complex step (`compiled`). No sampled image gives that: a pixel
does not move.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from typing import Unpack

from gemrender.beam.budget import Budget
from gemrender.beam.by_parameters import by_parameters
from gemrender.beam.by_proportions import PROPORTIONS, by_proportions, proportion_planes
from gemrender.beam.by_tiers import by_tiers, tier_planes
from gemrender.beam.derivatives import Derivative, Sensitivity, ValueSlope
from gemrender.beam.measure import check_bound
from gemrender.beam.totals import facet_totals
from gemrender.cuts import StoneLike, as_stone
from gemrender.cuts.design import Design
from gemrender.cuts.families.family import Family
from gemrender.errors import InputError
from gemrender.measures.measure import HEAD_DEG, Measure
from gemrender.measures.registry import chosen_measures
from gemrender.measures.registry import measures as all_measures
from gemrender.measures.tally import Tally
from gemrender.observation import Model, View
from gemrender.request import ShortForms, resolve, spelt_out
from gemrender.stone import Stone

__all__ = [
    "PROPORTIONS",
    "Derivative",
    "Sensitivity",
    "ValueSlope",
    "check_differentiable",
    "facet_totals",
    "proportion_planes",
    "sensitivity",
    "smooth_measures",
    "tier_planes",
]

#: What derivatives may take by default: time [s] and memory [GiB].
TIME_LIMIT, MEMORY_LIMIT = 30.0, 1.0


def check_differentiable(stone: Stone) -> None:
    """Refuse a stone that was neither made from proportions, nor of a family, nor from a design.

    Raises
    ------
    InputError
        It has none to differentiate by.
    """
    if stone.proportions is None and not isinstance(stone.cut, Design | Family):
        raise InputError(
            "has no proportions to differentiate by: it must be made from [proportions], [angles], "
            "[report] or [cut], or be a design of tiers",
            source=stone.source or stone.name,
        )


def smooth_measures(chosen: str | Measure | Iterable[str | Measure]) -> tuple[Measure, ...]:
    """Return the measures that were asked for, if they have values that can be differentiated.

    Parameters
    ----------
    chosen : str, Measure, or iterable of them
        As `gemrender.measures.chosen_measures` takes them; none at all, too; `all` is all that have some.

    Raises
    ------
    InputError
        An unknown name, or a measure that has none.
    """
    if not isinstance(chosen, str | Measure):
        chosen = list(chosen)
    if chosen in ("", []):
        return ()
    if chosen == "all" or chosen == ["all"]:
        return tuple(of for of in all_measures() if of.smooth_keys)
    found = chosen_measures(chosen)
    for of in found:
        if not of.smooth_keys:
            allowed = ", ".join(each.name for each in all_measures() if each.smooth_keys)
            why = (
                "its values are numbers and sizes of single virtual facets, which come and go"
                if not of.keys
                else "it does not say which of its values are analytic"
            )
            raise InputError(
                f"cannot be differentiated: {why}; must be among {allowed}",
                key="measures",
                value=of.name,
            )
    return found


@spelt_out()
def sensitivity(
    stone: StoneLike,
    *,
    view: View | None = None,
    model: Model | None = None,
    seed: int = 1,
    bound: float = 0.2,
    time_limit: float = TIME_LIMIT,
    memory_limit: float = MEMORY_LIMIT,
    progress: Callable[[float], None] | None = None,
    measures: str | Measure | Iterable[str | Measure] = (),
    head: float = HEAD_DEG,
    meets: str = "free",
    parameters: Collection[str | tuple[str, str]] | None = None,
    **short: Unpack[ShortForms],
) -> Sensitivity:
    """Differentiate a stone's Average and Rear by each of its proportions and angles, or of its tiers'.

    A faceter's design is differentiated by the angle and the distance of each tier, the cut of a family by
    each of its parameters, and by the angles that stand for heights.

    Where a whole virtual facet reaches the critical angle the scores jump; between such places the derivative
    is that of the scores.

    Parameters
    ----------
    stone : Stone, str or path
        A stone made from proportions or angles, from the parameters of a family, or from a design; or what
        `load_stone` takes.
    seed : int
        Seed of the rays near the girdle.
    bound : float
        Wanted bound of every derivative [% per unit]. Rays near the girdle are added until it is reached, but
        no more than 8192 of each of the sixteen sets, four times as many for light that has been reflected in
        part, and none that time is not left for.
    time_limit, memory_limit : float
        What it may take [s], [GiB].
    measures : str, Measure, or iterable of them
        Further measures (`smooth_measures`); `all` for all of them that can be differentiated. Of all light
        polygons tell the derivative exactly down to a least share of the view (1e-8 for most stones), and
        rays that of the rest, with its bound (`later`); measures over all views are difference quotients of
        rays, with theirs (`hemisphere_slopes`).
    meets : {"free", "loose", "kept"}
        Of designs, what becomes of meet points where a tier changes: its other number and all other tiers
        stay; or it turns about the middle of its facets; or other tiers follow (`gemrender.cuts.meets`).
    parameters : collection of str or (str, str), optional
        What to differentiate by, where it is not to be all: names, or names and what is kept, as of
        `Derivative`. Others take no time.
    **short
        As of `ShortForms`.

    Returns
    -------
    Sensitivity
        The scores [%], and their derivatives [% per % or % per deg], each with its bound.

    Raises
    ------
    InputError
        The stone was made from none of them, it has no such parameter, a measure cannot be differentiated,
        the bound or a limit is out of range, or the stone falls into more virtual facets than can be
        differentiated within the limits.
    """
    start = time.perf_counter()
    stone = as_stone(stone)
    check_differentiable(stone)
    wanted = check_bound(bound)
    view, model = resolve(stone, view, model, short)
    chosen = smooth_measures(measures)
    over_views = [of for of in chosen if of.views == "hemisphere"]
    tally = Tally(view, model, [of for of in chosen if of not in over_views], head)
    how = (tally, over_views, wanted, seed, Budget(time_limit, memory_limit), progress, start)
    if isinstance(stone.cut, Design):
        found = by_tiers(stone, stone.cut, *how, parameters, meets)
    elif meets != "free":
        raise InputError("only designs of tiers have meets", key="meets", value=meets)
    elif isinstance(stone.cut, Family):
        found = by_parameters(stone, stone.cut, *how, parameters)
    else:
        found = by_proportions(stone, *how, parameters)
    if not over_views:
        return found
    place = {of.name: k for k, of in enumerate(chosen)}  # in the order that was asked for
    return replace(found, derivatives=tuple(
        replace(of, measures=tuple(sorted(of.measures, key=lambda value: place[value.measure])))
        for of in found.derivatives
    ))  # fmt: skip

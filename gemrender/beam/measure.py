"""Exact scores: sums of areas, and what single rays find near the girdle, with a stated error."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.facets import VirtualFacets, trace_facets
from gemrender.beam.near_girdle import SETS, STUDENT_T, NearGirdle
from gemrender.beam.solid import BeamStone, beam_stone
from gemrender.errors import InputError
from gemrender.measures import inoue
from gemrender.measures.inoue import BANDS, INTENSITY, LOST, MET, REAR, TRAPPED
from gemrender.observation import LIGHT_LEVEL, Measurement, Model, View, bound_text
from gemrender.stone import Stone

__all__ = ["BOUND_RANGE", "check_bound", "facet_sums", "measure", "measure_facets"]

#: Allowed range of the error bound [%].
BOUND_RANGE = (1e-4, 10.0)

#: Rays of a set at first, and at the most.
_FIRST_RAYS, _MOST_RAYS = 64, 1 << 23


def check_bound(bound: float) -> float:
    """Return the bound if it is one.

    Raises
    ------
    InputError
        It is no number, or out of range.
    """
    low, high = BOUND_RANGE
    if isinstance(bound, bool) or not isinstance(bound, (int, float, np.number)) or not low <= bound <= high:
        raise InputError(f"must be from {low:g} to {high:g} [%]", key="bound", value=bound)
    return float(bound)


def measure(
    stone: Stone | BeamStone,
    *,
    view: View | None = None,
    model: Model | None = None,
    bound: float = 0.05,
    seed: int = 1,
    progress: Callable[[float], None] | None = None,
    budget: Budget | None = None,
) -> Measurement:
    """Score a convex stone by tracing polygons.

    Parameters
    ----------
    stone : Stone or BeamStone
        The stone.
    view : View, optional
        Where the eye is; by default straight above. Its resolution does not matter.
    model : Model, optional
        The optical model; by default that of the stone's material.
    bound : float
        Wanted error bound of every score [%].
    seed : int
        Seed of the rays near the girdle.
    progress : callable, optional
        Called with the share done, 0 to 1.
    budget : Budget, optional
        Time and memory to keep to. Past them the score has a larger bound than was wanted, and a note;
        without one there are no limits.

    Raises
    ------
    InputError
        The stone is not convex, or the bound out of range.
    """
    return measure_facets(
        stone, view=view, model=model, bound=bound, seed=seed, progress=progress, budget=budget
    )[0]


def measure_facets(
    stone: Stone | BeamStone,
    *,
    view: View | None,
    model: Model | None,
    bound: float,
    seed: int,
    progress: Callable[[float], None] | None,
    budget: Budget | None,
) -> tuple[Measurement, VirtualFacets]:
    """Score a stone as `measure` does; return its virtual facets too, of a symmetric one those of a part."""
    start = time.perf_counter()
    wanted = check_bound(bound)
    convex = stone if isinstance(stone, BeamStone) else beam_stone(stone)
    facets = trace_facets(convex, view=view, model=model, whole=False, budget=budget)
    resolved, near = facet_sums(facets), NearGirdle(convex, facets, seed)
    rays = _FIRST_RAYS
    while True:
        near.go_on(near.numbers(rays), progress, budget)
        sums = resolved + near.found()
        each = 100.0 * sums / sums[:, MET:]
        scores, error = each.mean(axis=0), each.std(axis=0, ddof=1) / np.sqrt(SETS)
        unsolved, scatter = float(scores[TRAPPED] + scores[LOST]), float(STUDENT_T * error.max())
        # No ray more makes less light trapped.
        allowed = max(wanted - unsolved, 0.5 * wanted)
        if scatter <= allowed or rays >= _MOST_RAYS or near.stopped:
            break
        # The error falls as the 3/4th power of the number of rays, and where they run about the girdle for
        # long, so that any two of them part, as its root: something between.
        rays = int(rays * min(max(1.2 * (scatter / allowed) ** 1.6, 1.5), 8.0))
    missed = _missed(scatter + unsolved, wanted, unsolved, budget if near.stopped else None)
    images, area = facets.images(), float(sums[:, MET].mean())
    counted = facets.is_counted
    measured = Measurement(
        average=float(scores[INTENSITY]),
        rear=float(scores[REAR]),
        bands=scores[BANDS : BANDS + 6],
        trapped=float(scores[TRAPPED]),
        lost=float(scores[LOST]),
        bound=scatter + unsolved,
        rays=near.rays,
        area=facets.parts * area,
        sizes=np.repeat((100.0 / area * facets.area / images)[counted], images[counted]),
        girdle=100.0 * (1.0 - resolved[MET] / area),
        seconds=time.perf_counter() - start,
        notes=(*_left_over(facets), *missed),
    )
    return measured, facets


def _left_over(facets: VirtualFacets) -> tuple[str, ...]:
    """Say what polygons had to leave to rays."""
    if not facets.left_over:
        return ()
    share = 100.0 * facets.left_over / float(facets.area.sum())
    return (f"virtual facets of {share:.2g} % of the view left to single rays: {facets.why_left_over}",)


def _missed(bound: float, wanted: float, unsolved: float, stopped: Budget | None) -> tuple[str, ...]:
    """Say why a bound was not reached, if it was not."""
    if bound <= wanted:
        return ()
    if stopped is not None:
        why = stopped.time_is_up
    elif unsolved > 0.5 * wanted:
        why = f"{unsolved:.2g} % of the light was still inside after all reflections that are followed"
    else:
        why = f"no more than {SETS * _MOST_RAYS} rays are followed"
    return (f"bound {bound_text(bound)} instead of {wanted:g}: {why}",)


def facet_sums(facets: VirtualFacets) -> np.ndarray:
    """Sum up the virtual facets whose whole path is known, (N_SUMS,) as `inoue` has it [girdle radius^2]."""
    sums = inoue.sum_up(facets.paths, facets.rear_mask, facets.primary_intensity / LIGHT_LEVEL)[0]
    sums[[TRAPPED, MET]] += facets.unaccounted
    return np.asarray(sums)

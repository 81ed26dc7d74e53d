"""Exact scores: sums of areas, and what single rays find near the girdle, with a stated error."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.facets import FacetStatus, VirtualFacets, trace_facets
from gemrender.beam.hemisphere import measure_hemisphere
from gemrender.beam.near_girdle import NearGirdle, more_rays
from gemrender.beam.solid import BeamStone, beam_stone
from gemrender.errors import InputError
from gemrender.measures.inoue import BANDS, INTENSITY, LOST, MET, REAR, TRAPPED
from gemrender.measures.measure import HEAD_DEG, Measure
from gemrender.measures.registry import measure_named
from gemrender.measures.tally import REST, SETS, Tally, bounds_of_sets
from gemrender.observation import Measurement, MeasureValues, Model, View, bound_text
from gemrender.paths import Paths
from gemrender.stone import Stone

__all__ = [
    "BOUND_RANGE",
    "MOST_RAYS",
    "PRINCIPAL_NORMALS",
    "Found",
    "check_bound",
    "facet_sums",
    "measure",
    "measure_facets",
    "polygon_sums",
    "trace_paths",
]

#: Allowed range of the error bound [%].
BOUND_RANGE = (1e-4, 10.0)

#: All light is followed by polygons down to this share of the view, area times weight; by rays from there.
_LEAST = 1e-5
#: Principal light alone, but with normals, which only paths of all light have: what has been reflected in
#: part is followed where it is all of the view, and so never.
PRINCIPAL_NORMALS = 1.0
#: Rays of a set at first, and at the most.
_FIRST_RAYS = 64
MOST_RAYS = 1 << 23


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
    measures: Sequence[Measure] = (),
    head_deg: float = HEAD_DEG,
    zenith: np.ndarray | None = None,
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
    measures : sequence of Measure
        What to measure besides the paper's score.
    head_deg : float
        Half the angle at which the viewer's head is seen from the stone [deg].
    zenith : (3,) float64, optional
        The viewer's zenith (`Light`); by default the direction to the eye.
    bound : float
        Wanted error bound of every score [%].
    seed : int
        Seed of the single rays.
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
        stone, view=view, model=model, measures=measures, head_deg=head_deg, zenith=zenith, bound=bound,
        seed=seed, progress=progress, budget=budget,
    )[0]  # fmt: skip


def measure_facets(
    stone: Stone | BeamStone,
    *,
    view: View | None,
    model: Model | None,
    bound: float,
    seed: int,
    progress: Callable[[float], None] | None,
    budget: Budget | None,
    measures: Sequence[Measure] = (),
    head_deg: float = HEAD_DEG,
    zenith: np.ndarray | None = None,
) -> tuple[Measurement, VirtualFacets]:
    """Score a stone as `measure` does; return its virtual facets too, of a symmetric one those of a part."""
    start = time.perf_counter()
    wanted = check_bound(bound)
    convex = stone if isinstance(stone, BeamStone) else beam_stone(stone)
    model = model or Model.of(convex.stone)
    over_views = [of for of in measures if of.views == "hemisphere"]
    of_one = [of for of in measures if of not in over_views]
    tally = Tally(view or View(resolution=1), model, of_one, head_deg, zenith)
    facets = trace_facets(
        convex, view=tally.view, model=tally.model, whole=not tally.is_axial,
        least=_LEAST if tally.follows_all else PRINCIPAL_NORMALS if tally.needs_normals else 0.0,
        budget=budget,
    )  # fmt: skip
    near = NearGirdle(convex, facets, seed, tally, later=tally.follows_all)
    resolved = polygon_sums(tally, facets)
    found = _settle(tally, resolved, near, wanted, progress, budget)
    reached = found.scatter + found.unsolved
    missed = _missed(reached, wanted, found.unsolved, budget if near.stopped else None)
    images, area = facets.images(), found.area
    values = {of.name: of for of in found.measures(facets, images)}
    if over_views:
        more = measure_hemisphere(
            convex, model, over_views, bound=wanted, seed=seed, progress=progress, budget=budget
        )
        values |= {of.name: of for of in more}
        missed += _missed_of_views(more, wanted, budget)
    counted, scores = facets.is_counted, found.scores
    measured = Measurement(
        average=float(scores[INTENSITY]),
        rear=float(scores[REAR]),
        bands=scores[BANDS : BANDS + 6],
        trapped=float(scores[TRAPPED]),
        lost=float(scores[LOST]),
        bound=found.bound,
        rays=near.rays,
        area=facets.parts * area,
        sizes=np.repeat((100.0 / area * facets.area / images)[counted], images[counted]),
        girdle=100.0 * (1.0 - resolved[MET] / area),
        seconds=time.perf_counter() - start,
        notes=(*_left_over(facets), *missed),
        measures=tuple(values[of.name] for of in measures),
    )
    return measured, facets


def trace_paths(
    stone: Stone | BeamStone, *, view: View, model: Model, follow: str, bound: float, seed: int
) -> Paths:
    """Return the paths of a view: virtual facets, and single rays in sets for what they do not tell.

    Parameters and errors as for `gemrender.trace_paths`.
    """
    convex, wanted = stone if isinstance(stone, BeamStone) else beam_stone(stone), check_bound(bound)
    of_all = follow == "all"
    tally = Tally(view, model, [measure_named("iso"), measure_named("aset")] if of_all else ())
    facets = trace_facets(convex, view=view, model=model, least=_LEAST if of_all else 0.0)
    near = NearGirdle(convex, facets, seed, tally)
    _settle(tally, polygon_sums(tally, facets), near, wanted, None, None)
    return Paths.joined([facets.paths.rows(facets.status != FacetStatus.GIRDLE), *near.paths()])


def _settle(
    tally: Tally,
    resolved: np.ndarray,
    near: NearGirdle,
    wanted: float,
    progress: Callable[[float], None] | None,
    budget: Budget | None,
) -> Found:
    """Follow rays until everything is known as closely as is wanted, as far as that can be."""
    rays = _FIRST_RAYS
    while True:
        near.go_on(near.numbers(rays), progress, budget)
        found = Found(tally, resolved + near.found(), near.unseen)
        # No ray more makes less light trapped.
        allowed = max(wanted - found.unsolved, 0.5 * wanted)
        if found.scatter <= allowed or rays >= MOST_RAYS or near.stopped:
            return found
        rays = more_rays(rays, found.scatter, allowed)


class Counted(Protocol):
    """What is known of virtual facets (`VirtualFacets`)."""

    @property
    def is_counted(self) -> np.ndarray: ...
    @property
    def paths(self) -> Paths: ...


class Found:
    """What sums of sets say: scores, and how far they scatter.

    Parameters
    ----------
    tally : Tally
        What was summed up.
    sums : (SETS, n_sums) float64
        What each set has found together with the polygons [girdle radius^2].
    unseen : (float, float)
        Areas of the view, of principal and of all light, that all rays may have missed [girdle radius^2].
    """

    def __init__(self, tally: Tally, sums: np.ndarray, unseen: tuple[float, float]) -> None:
        self._tally, self._mean = tally, sums.mean(axis=0)
        self.area = float(self._mean[MET])
        each = 100.0 * sums / sums[:, [MET]]
        self.scores = each.mean(axis=0)
        trapped = float(self.scores[TRAPPED] + self.scores[LOST])
        scatter = float(np.hypot(bounds_of_sets(each[:, :MET]).max(), 100.0 * unseen[0] / self.area))
        self.bound = scatter + trapped
        areas = [unseen[of.follow == "all"] for of in tally.measures]
        self._errors = [
            np.hypot(bounds_of_sets(values), missed)
            for values, missed in zip(tally.values(sums), tally.changes(self._mean, areas), strict=True)
        ]
        self.unsolved = trapped + (float(self.scores[REST]) if tally.follows_all else 0.0)
        steering = [errors for errors, of in zip(self._errors, tally.measures, strict=True) if of.unit == "%"]
        self.scatter = float(max([scatter, *(np.nanmax(errors, initial=0.0) for errors in steering)]))

    def measures(self, facets: Counted, images: np.ndarray) -> tuple[MeasureValues, ...]:
        """Return what each measure says, of virtual facets with so many images (n,) each."""
        if not self._tally.measures:
            return ()
        counted = np.flatnonzero(facets.is_counted | (facets.paths.partial_reflections > 0))
        paths = replace(facets.paths.rows(counted), images=images[counted])
        light = self._tally.light(paths)
        return tuple(
            MeasureValues(
                name=measure.name,
                version=measure.version,
                values=dict(zip(measure.keys, map(float, values), strict=True)),
                bound=float(np.nanmax(errors, initial=0.0)) + (measure.unit == "%") * self.unsolved,
                details=measure.details(light),
            )
            for measure, values, errors in zip(
                self._tally.measures, self._tally.values(self._mean), self._errors, strict=True
            )
        )


def polygon_sums(tally: Tally, facets: VirtualFacets) -> np.ndarray:
    """Sum up the virtual facets whose whole path is known, (n_sums,) [girdle radius^2]."""
    sums = tally.sum_up(facets.paths)[0]
    sums[[TRAPPED, MET]] += facets.unaccounted
    return np.asarray(sums)


def _left_over(facets: VirtualFacets) -> tuple[str, ...]:
    """Say what polygons had to leave to rays."""
    if not facets.left_over:
        return ()
    share = 100.0 * facets.left_over / float(facets.area.sum())
    return (f"virtual facets of {share:.2g} % of the view left to single rays: {facets.why_left_over}",)


def _missed_of_views(
    found: Sequence[MeasureValues], wanted: float, budget: Budget | None
) -> tuple[str, ...]:  # fmt: skip
    """Say which measures over all views have a larger bound than was wanted, and why."""
    is_late = budget is not None and budget.left <= 0.0
    why = budget.time_is_up if budget is not None and is_late else "no more rays are followed"
    return tuple(
        f"{of.name}: bound {bound_text(100.0 * of.bound)} % instead of {wanted:g}: {why}"
        for of in found
        if of.bound is not None and 100.0 * of.bound > wanted
    )


def _missed(bound: float, wanted: float, unsolved: float, stopped: Budget | None) -> tuple[str, ...]:
    """Say why a bound was not reached, if it was not."""
    if bound <= wanted:
        return ()
    if stopped is not None:
        why = stopped.time_is_up
    elif unsolved > 0.5 * wanted:
        why = f"{unsolved:.2g} % of the light was still inside after all reflections that are followed"
    else:
        why = f"no more than {SETS * MOST_RAYS} rays are followed"
    return (f"bound {bound_text(bound)} instead of {wanted:g}: {why}",)


def facet_sums(facets: VirtualFacets) -> np.ndarray:
    """Sum up the virtual facets whose whole path is known, (N_SUMS,) as `inoue` has it [girdle radius^2]."""
    return polygon_sums(Tally(facets.view, facets.model), facets)

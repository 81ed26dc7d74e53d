"""Scores of birefringent stones: sums over polygons with modes, and what single rays find, with a bound.

What the paper's score is for such a stone. Unpolarised light comes from the eye, followed back, to the crown.
Of what enters, T, each of the two modes has its share; each goes on as the principal ray of the paper: where
all of it is totally reflected it is shared out between the two modes that go on, without loss, and at the
first facet where some of it may leave it ends: here the light came in. The share of it that leaves there is T
of that crossing (by reciprocity the same for light that comes in, unpolarised), and the intensity of the path
is

    I = 100 T(eye) T(light) A(light) / A(view),

with A(light) the cross-section of its beam outside where it came in and A(view) that in the view: for an
isotropic stone this ratio is the paper's S S. At each place of the view the paths' shares make 1. Average is
the mean of share times I, rear light counted as 0; Rear and the bands are sums of shares, each path in the
band of its own intensity.

For equal indices it is the paper's model of polarised light: the modes remember how they were polarised at
the entry, which the product of two T of unpolarised light does not.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gemrender.beam.budget import Budget
from gemrender.beam.measure import Found, check_bound
from gemrender.beam.modes.crystal import Biaxial, Uniaxial, indices_text, optical_crystal
from gemrender.beam.modes.facets import LEAST, ModeFacets, trace_mode_facets
from gemrender.beam.modes.more_rays import LeftToRays
from gemrender.beam.near_girdle import more_rays
from gemrender.beam.solid import BeamStone, beam_stone
from gemrender.errors import InputError
from gemrender.measures.inoue import BANDS, INTENSITY, LOST, MET, REAR, TRAPPED
from gemrender.measures.measure import HEAD_DEG, Measure
from gemrender.measures.tally import Tally
from gemrender.observation import Measurement, Model, RayStatus, View, bound_text
from gemrender.stone import Stone

__all__ = ["measure_modes", "score_modes"]

#: Rays of a set at first, and at the most.
_FIRST_RAYS, _MOST_RAYS = 256, 1 << 20


def measure_modes(
    stone: Stone | BeamStone,
    crystal: Uniaxial | Biaxial,
    *,
    view: View | None = None,
    model: Model | None = None,
    measures: Sequence[Measure] = (),
    head_deg: float = HEAD_DEG,
    zenith: np.ndarray | None = None,
    bound: float = 0.05,
    least: float = LEAST,
    seed: int = 1,
    progress: Callable[[float], None] | None = None,
    budget: Budget | None = None,
) -> tuple[Measurement, ModeFacets]:
    """Score a birefringent convex stone by polygons with modes.

    Parameters
    ----------
    stone : Stone or BeamStone
        The stone.
    crystal : Uniaxial or Biaxial
        What it is made of, and how it lies in the stone (`optical_crystal`).
    view : View, optional
        Where the eye is; by default straight above.
    model : Model, optional
        The rules for rear light and intensity, by default those of the stone. Its index and its law of
        transmittance make no difference.
    measures, head_deg, zenith, bound, seed, progress, budget
        As of `gemrender.beam.measure`.
    least : float
        Polygons of a smaller area times share [share of the view] are left to single rays.

    Returns
    -------
    (Measurement, ModeFacets)
        The score, and the virtual facets; of a stone that is symmetric with its crystal those of a part.

    Raises
    ------
    InputError
        The stone is not convex, the bound out of range, or a measure over all views.
    """
    for of in measures:
        if of.views != "one":
            raise InputError(
                f"{of.name} is a sum over views, in which light of birefringent stones is not split",
                key="measures",
                value=of.name,
            )
    start, wanted = time.perf_counter(), check_bound(bound)
    convex = stone if isinstance(stone, BeamStone) else beam_stone(stone)
    tally = Tally(view or View(resolution=1), model or Model.of(convex.stone), measures, head_deg, zenith)
    facets = trace_mode_facets(
        convex, crystal, view=tally.view, model=tally.model, least=least, follows_all=tally.follows_all,
        whole=not tally.is_axial, needs_images=tally.needs_images, budget=budget,
    )  # fmt: skip
    resolved = tally.sum_up(facets.paths)[0]
    resolved[[TRAPPED, MET]] += facets.unaccounted
    left, rays = LeftToRays(convex, crystal, facets, seed, tally), _FIRST_RAYS
    while True:
        left.go_on(rays, budget)
        found = Found(tally, resolved + left.found(), (left.unseen, left.unseen))
        allowed = max(wanted - found.unsolved, 0.5 * wanted)
        if progress is not None:
            progress(min(allowed / max(found.scatter, allowed), 1.0))
        if found.scatter <= allowed or rays >= _MOST_RAYS or left.stopped:
            break
        rays = min(more_rays(rays, found.scatter, allowed), _MOST_RAYS)
    scores, counted = found.scores, facets.is_counted & (facets.paths.status == RayStatus.EXITED)
    reached = found.scatter + found.unsolved
    why = budget.time_is_up if budget is not None and left.stopped else "no more rays are followed"
    notes = [f"light is split: indices {indices_text(crystal)}"]
    if reached > wanted:
        notes.append(f"bound {bound_text(reached)} instead of {wanted:g}: {why}")
    measured = Measurement(
        average=float(scores[INTENSITY]),
        rear=float(scores[REAR]),
        bands=scores[BANDS : BANDS + 6],
        trapped=float(scores[TRAPPED]),
        lost=float(scores[LOST]),
        bound=found.bound,
        rays=left.rays,
        area=facets.parts * found.area,
        sizes=np.repeat((100.0 / found.area / facets.parts * facets.paths.area)[counted], facets.parts),
        girdle=100.0 * left.light,
        seconds=time.perf_counter() - start,
        notes=tuple(notes),
        measures=found.measures(facets, facets.images()),
    )
    return measured, facets


def score_modes(
    stone: Stone, *, principal: Any, axes: Any = None, **options: Any
) -> tuple[Measurement, ModeFacets]:
    """Score a birefringent stone, from principal indices and their axes.

    Parameters
    ----------
    stone : Stone
        A convex stone.
    principal : (3,) array_like
        Principal indices.
    axes : (3, 3) array_like, optional
        Rows are their axes in the stone's frame, unit vectors at right angles; by default x, y and z.
    **options
        As of `measure_modes`.

    Raises
    ------
    InputError
        As for `measure_modes` and `optical_crystal`.
    """
    return measure_modes(stone, optical_crystal(principal, np.eye(3) if axes is None else axes), **options)

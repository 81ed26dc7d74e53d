"""What a pair of eyes sees differently: the share of the view whose light comes from other zones."""

from __future__ import annotations

import numpy as np

from gemrender.beam.near_girdle import STEPS, by_sets, more_rays, next_points
from gemrender.beam.rays import (
    COS_ENTRY,
    DIRECTION,
    INSIDE,
    POINT,
    STATUS,
    empty_rays,
    enter_rays,
    follow_rays,
)
from gemrender.beam.solid import BeamStone
from gemrender.measures.aset import ZONE_LIMITS
from gemrender.measures.tally import SETS, bounds_of_sets
from gemrender.observation import Model, RayStatus, View

__all__ = ["disagreement"]

#: Places of a set at first, at a time, and at the most.
_FIRST, _BLOCK, _MOST = 256, 1 << 13, 1 << 20


def disagreement(
    convex: BeamStone,
    view: View,
    eyes: tuple[View, View],
    model: Model,
    *,
    head_deg: float,
    bound: float,
    seed: int,
) -> tuple[float, float]:
    """Return the share of a view that two eyes see lit from different zones, and its bound [%].

    The zones are those of `aset`, by the direction between the eyes as zenith, and the viewer's head: one eye
    sees green where the other sees red, or one the head's shadow. A place is a point of the stone's surface
    that the middle of the eyes sees, and both eyes look at it.

    Parameters
    ----------
    convex : BeamStone
        The stone.
    view : View
        From between the eyes.
    eyes : (View, View)
        From each eye.
    model : Model
        The optical model.
    head_deg : float
        Half the angle at which the viewer's head is seen from the stone [deg].
    bound : float
        Wanted error bound [%].
    seed : int
        Seed of the sets' shifts.
    """
    half = max(convex.stone.reach, 1.0) if convex.stone.is_round else convex.stone.reach
    zenith = view.basis()[2]
    limits = np.append(ZONE_LIMITS, np.cos(np.radians(head_deg)))
    shifts = np.random.default_rng(seed).random((SETS, 2))
    found, done, wanted = np.zeros((SETS, 2)), 0, _FIRST  # places that differ, and all
    while True:
        last = min(done + _BLOCK, wanted)
        unit = next_points(shifts, STEPS, done, last)

        def some_sets(part: slice, unit: np.ndarray = unit) -> np.ndarray:
            points = half * (2.0 * unit[part] - 1.0)
            n = points.shape[0] * points.shape[1]
            rays = empty_rays(n)
            basis = view.basis()
            enter_rays(points.reshape(-1, 2), basis, convex.solid, convex.facet, model.index, rays)
            met = rays.facts[STATUS, :n] == INSIDE
            places = rays.numbers[POINT:DIRECTION, :n][:, met].T
            left, right = (_zones(convex, eye, places, model, zenith, limits) for eye in eyes)
            of = np.repeat(np.arange(len(points)), points.shape[1])[met]
            differ = np.bincount(of, left != right, len(points))
            return np.column_stack([differ, np.bincount(of, minlength=len(points))])

        found += by_sets(some_sets, SETS)
        done = last
        if done < wanted:
            continue
        shares = 100.0 * found[:, 0] / np.maximum(found[:, 1], 1.0)
        error = float(bounds_of_sets(shares))
        if error <= bound or wanted >= _MOST:
            return float(100.0 * found[:, 0].sum() / max(found[:, 1].sum(), 1.0)), error
        wanted = more_rays(wanted, error, bound)


def _zones(
    convex: BeamStone, eye: View, places: np.ndarray, model: Model, zenith: np.ndarray, limits: np.ndarray
) -> np.ndarray:
    """Return the zone that principal light comes from to an eye at places (n, 3) of the surface, (n,)."""
    basis = eye.basis()
    rays, n = empty_rays(len(places)), len(places)
    at = np.ascontiguousarray(places @ basis[:2].T)
    enter_rays(at, basis, convex.solid, convex.facet, model.index, rays)
    follow_rays(convex.solid, convex.facet, model.index, model.max_reflections, rays)
    cosine = zenith @ rays.numbers[DIRECTION:COS_ENTRY, :n]
    return np.where(rays.facts[STATUS, :n] == RayStatus.EXITED, np.searchsorted(limits, cosine), -1)

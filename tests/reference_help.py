"""Stones and rays for the float64 tracer."""

from __future__ import annotations

import numpy as np
from physics_tolerances import PATH

from gemrender import RayStatus, RoundBrilliant, Stone
from gemrender.cuts import stone_from_vertices
from gemrender.cuts.round_brilliant.topology import GIRDLE, GIRDLE_LOWER, GIRDLE_UPPER, N_VERTICES

SAMPLES = ["inoue-1", "inoue-2", "inoue-3"]
DOWN = np.array([0.0, 0.0, -1.0])


def cut(pavilion_angle=40.75, **other):
    """Tolkowsky's cut, or with another pavilion."""
    angles = {"table": 53, "crown_angle": 34.5, "star": 50, "lower_half": 80, "girdle_thickness": 2.0}
    return RoundBrilliant.from_angles(**angles | other, pavilion_angle=pavilion_angle)


def sample(**other):
    proportions = {"table": 54.0, "star": 57.0, "lower_girdle_contact": 20.0, "crown_height": 15.7}
    proportions |= {"pavilion_depth": 43.08, "girdle_thickness": 2.5}
    return RoundBrilliant(**proportions | other)


def solid(proportions):
    return Stone.from_proportions(proportions)


def measured(rng, scale, **other):
    """The sample with every vertex moved at random, by so much in the mean [girdle radius]."""
    vertices = sample(**other).vertices() + rng.normal(scale=scale, size=(N_VERTICES, 3))
    return stone_from_vertices(vertices)


def from_above(xy):
    """Return origins and directions of vertical rays through points (n, 2) of the top view."""
    xy = np.atleast_2d(np.asarray(xy, dtype=float))
    return np.column_stack([xy, np.full(len(xy), 10.0)]), np.broadcast_to(DOWN, (len(xy), 3))


def over_the_top_view(rng, n):
    return from_above(rng.uniform(-1.05, 1.05, size=(n, 2)))


def from_all_around(rng, n):
    """Rays through uniform points of a cube around the stone, in uniform directions, from outside."""
    direction = rng.normal(size=(n, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return rng.uniform(-1, 1, size=(n, 3)) - 10 * direction, direction


def assert_none_lost(stone, record):
    """Every ray missed the stone or left it, and where it left is on the facet that it left through."""
    assert set(record.status) == {RayStatus.MISSED, RayStatus.EXITED}
    out = record.status == RayStatus.EXITED
    point, facet = record.exit_point[out], record.exit_facet[out]
    assert np.hypot(point[:, 0], point[:, 1]).max() <= np.hypot(*stone.solid.vertices[:, :2].T).max() + PATH
    low, high = stone.vertices[:, 2].min(), stone.vertices[:, 2].max()
    assert ((point[:, 2] >= low - PATH) & (point[:, 2] <= high + PATH)).all()
    wall = facet == GIRDLE
    heights = stone.vertices[[*GIRDLE_LOWER, *GIRDLE_UPPER], 2]
    assert ((point[wall, 2] >= heights.min() - PATH) & (point[wall, 2] <= heights.max() + PATH)).all()
    gaps = np.abs(point[~wall] @ stone.solid.planes[:, :3].T - stone.solid.planes[:, 3])
    gaps[facet[~wall, None] != stone.solid.facet] = np.inf
    assert gaps.min(axis=1).max() <= PATH

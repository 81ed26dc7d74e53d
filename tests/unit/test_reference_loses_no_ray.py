"""The float64 tracer where rays may get lost: edges, the rim, many reflections, measured stones."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from half_spaces import CYLINDER, half_spaces
from physics_tolerances import PATH, SINGLE
from reference_help import (
    DOWN,
    SAMPLES,
    assert_none_lost,
    from_above,
    from_all_around,
    measured,
    over_the_top_view,
    sample,
    solid,
)
from thorough import chosen

from gemrender import Model, RayStatus, View, load_stone
from gemrender.cuts import stone_from_vertices
from gemrender.cuts.round_brilliant.topology import CONTACT, FACET_POLYGONS, STAR_TIP, TRIANGLES
from gemrender.reference import observe, surfaces, trace
from gemrender.reference.surfaces import surfaces_of
from gemrender.scoring import score_observation


@pytest.mark.parametrize("name", SAMPLES)
def test_every_ray_is_accounted_for(name):
    stone = load_stone(name)
    seen = observe(stone, View.of(stone, 128))
    x, y = seen.view.cell_centres()
    in_the_disc = np.hypot(x[None, :], y[:, None]) <= 1
    np.testing.assert_array_equal(seen.coverage, in_the_disc)
    np.testing.assert_array_equal(seen.status != RayStatus.MISSED, in_the_disc)
    counts = Counter(seen.status.ravel().tolist())
    assert counts == {RayStatus.MISSED: (~in_the_disc).sum(), RayStatus.EXITED: in_the_disc.sum()}

    np.testing.assert_array_equal(seen.entry_facet >= 0, in_the_disc)
    np.testing.assert_array_equal(seen.exit_facet >= 0, in_the_disc)
    lit = in_the_disc & (seen.rear_mask == 0)
    np.testing.assert_array_equal(seen.primary_intensity > 0, lit)
    assert (seen.rear_mask[~in_the_disc] == 0).all()
    point, direction = seen.exit_point[in_the_disc], seen.exit_direction[in_the_disc]
    assert np.abs(half_spaces(stone.proportions).outside(point.astype(float))).max() < 4 * SINGLE
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1, rtol=0, atol=4 * SINGLE)

    result = score_observation(seen)
    shares = [band.share for band in result.bands]
    assert sum(shares) + result.rear + result.trapped + result.lost == pytest.approx(100)
    assert (result.trapped, result.lost) == (0, 0)


EDGES = sorted(
    {tuple(sorted(edge)) for p in FACET_POLYGONS for edge in zip(p, p[1:] + p[:1], strict=True)}
    | {tuple(sorted(edge)) for t in TRIANGLES.tolist() for edge in zip(t, t[1:] + t[:1], strict=True)}
)


@pytest.mark.parametrize("turn_deg", chosen([0, 11.25, 7.3], [0, 7.3]))
@pytest.mark.parametrize("name", SAMPLES)
def test_rays_through_edges_and_vertices_are_not_lost(name, turn_deg):
    # All edges of the 78 triangles, those of the pavilion under the table included, seen from above: table
    # corners, star tips, kite edges, the axis over the culet, girdle points.
    stone = load_stone(name).rotated(turn_deg)
    start, end = stone.vertices[np.array(EDGES).T, None, :2]
    xy = (start + np.linspace(0, 1, 9)[:, None] * (end - start)).reshape(-1, 2)
    through = trace(stone, *from_above(xy))
    assert (through.status == RayStatus.EXITED).all()
    # Either face will do: one that is met a hair's breadth away.
    inner = np.hypot(*xy.T) < 0.999
    azimuth = np.pi / 4 * np.arange(8) + 0.1
    hair = 1e-9 * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    beside = np.array([trace(stone, *from_above(xy[inner] + h)).entry_facet for h in hair])
    assert (beside == through.entry_facet[inner]).any(axis=0).all()


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("beyond", [-1e-9, -1e-13, 0.0, 1e-13, 1e-9])
def test_vertical_rays_at_the_girdles_very_edge(name, beyond):
    azimuth = np.linspace(0, 2 * np.pi, 721)
    xy = (1 + beyond) * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    status = set(trace(load_stone(name), *from_above(xy)).status)
    # Within rounding of the rim a ray may count as inside or as outside; it is not lost.
    allowed = {-1e-9: {RayStatus.EXITED}, 1e-9: {RayStatus.MISSED}}
    assert status <= allowed.get(beyond, {RayStatus.EXITED, RayStatus.MISSED})


def test_rays_along_surfaces_outside_them_miss():
    # Along the girdle's wall, downwards and across; over the table; under the culet.
    origin = np.array([[1.001, 0.0, 10.0], [-10.0, 1.001, 0.02], [-10.0, 0.0, 0.3641], [-10.0, 0.0, -0.87]])
    direction = np.array([DOWN, [1.0, 0, 0], [1.0, 0, 0], [1.0, 0, 0]])
    record = trace(solid(sample()), origin, direction)
    assert (record.status == RayStatus.MISSED).all()


@pytest.mark.parametrize("most", [1, 2, 5])
def test_trapped_rays_are_counted(most):
    stone = load_stone("inoue-2")
    view = View.of(stone, 64)
    free, capped = observe(stone, view), observe(stone, view, Model(max_reflections=most))
    trapped = free.reflections > most
    np.testing.assert_array_equal(
        capped.status, np.where(trapped, RayStatus.TRAPPED, free.status), err_msg="status"
    )
    np.testing.assert_array_equal(capped.reflections, np.minimum(free.reflections, most))
    np.testing.assert_array_equal(capped.primary_intensity, np.where(trapped, 0, free.primary_intensity))
    np.testing.assert_array_equal(capped.rear_mask, np.where(trapped, 0, free.rear_mask))
    np.testing.assert_array_equal(capped.exit_facet, np.where(trapped, -1, free.exit_facet))
    share = 100 * trapped.sum() / (free.coverage > 0).sum()
    assert share > 0
    assert score_observation(capped).trapped == pytest.approx(share)


@pytest.mark.parametrize("scale", chosen([1e-12, 1e-3, 3e-3], [1e-12, 3e-3]))
@pytest.mark.parametrize("other", [{}, {"girdle_thickness": 1.5}], ids=["sample", "thin"])
def test_measured_stone_loses_no_ray(scale, other, rng):
    stone = measured(rng, scale, **other)
    top = trace(stone, *over_the_top_view(rng, 1000))
    around = trace(stone, *from_all_around(rng, 1000))
    for record in (top, around):
        assert_none_lost(stone, record)


def test_ray_that_slips_between_two_surfaces_takes_the_nearest_plane(rng, monkeypatch):
    # As rounding might open a gap: triangles that are smaller all round than they should be.
    monkeypatch.setattr(surfaces, "EDGE_TOLERANCE", -1e-3)
    planes, p = half_spaces(sample()), rng.uniform(-1, 1, size=(4000, 3))
    p = p[planes.outside(p) < -0.01]
    direction = from_all_around(rng, len(p))[1]
    hit = surfaces_of(solid(sample())).nearest(p, direction, inside=True)
    _, _, t_out, facet = planes.clip(p, direction)
    assert (hit.facet >= 0).all()
    on_planes = facet != CYLINDER
    assert (~on_planes).any()
    np.testing.assert_allclose(hit.distance[on_planes], t_out[on_planes], rtol=0, atol=PATH)


def test_slightly_hollow_stone_loses_no_ray(rng):
    # Star tips raised and contacts lowered: kites are hollow along their long diagonals.
    vertices = sample().vertices()
    vertices[STAR_TIP, 2] += 0.01
    vertices[CONTACT, 2] -= 0.01
    stone = stone_from_vertices(vertices)
    assert not stone.is_convex
    for rays in (over_the_top_view(rng, 2000), from_all_around(rng, 2000)):
        assert_none_lost(stone, trace(stone, *rays))

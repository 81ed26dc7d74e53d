"""The float64 tracer: closed forms by hand, and an independent tracer of half-spaces."""

from __future__ import annotations

import numpy as np
import pytest
from half_spaces import follow, half_spaces
from physics_tolerances import (
    CRITICAL_MARGIN_DEG,
    FEW_REFLECTIONS,
    ONE_DECIMAL,
    ORBIT_96,
    PATH,
    PATH_PERCENT,
    ROUNDING,
    SINGLE,
    SINGLE_PERCENT,
    outline_error,
)
from reference_help import SAMPLES, cut, from_above, from_all_around, over_the_top_view, sample, solid
from thorough import chosen

from gemrender import Model, RayStatus, View, load_stone
from gemrender.cuts import stone_from_vertices
from gemrender.cuts.random import random_brilliant
from gemrender.cuts.round_brilliant.topology import FACET_KINDS
from gemrender.optics.fresnel import critical_angle_deg, transmittance
from gemrender.reference import observe, trace, tracer
from gemrender.reference.surfaces import surfaces_of
from gemrender.scoring import score_observation
from gemrender.stone import tessellate

INDEX = 2.4173
MODELS = [
    Model(fresnel=fresnel, intensity=intensity)
    for fresnel in ("gubelin", "exact")
    for intensity in ("primary", "radiance")
]
#: Girdle thicknesses [%] where the scallops cross (0.5 and below) and where they do not.
THICKNESSES = [0.0, 0.1, 0.5, 2.5, 10.0]


# ---- Closed forms --------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", MODELS, ids=str)
@pytest.mark.parametrize("x", [0.05, 0.1, -0.1])
def test_two_reflections_off_opposite_mains(x, model):
    # In the plane of two opposite pavilion mains, inclined by alpha, a vertical ray through the table turns
    # by pi - 2 alpha twice and comes back at 4 alpha - pi to the axis; for x < 0, mirrored about the axis.
    alpha, side, x_abs, y = np.radians(40.75), np.sign(x), abs(x), 0.003
    p = cut()
    depth, table = 2 * p.pavilion_depth / 100, 2 * (p.girdle_thickness + p.crown_height) / 100
    first = np.array([x_abs, -depth * (1 - x_abs)])  # x, z
    across = np.array([-np.sin(2 * alpha), np.cos(2 * alpha)])
    # On the opposite main z = -depth (1 + x).
    t = (-depth * (1 + first[0]) - first[1]) / (across[1] + depth * across[0])
    second = first + t * across
    up = np.array([-np.sin(4 * alpha), -np.cos(4 * alpha)])
    out = second + (table - second[1]) / up[1] * up
    in_stone = 4 * alpha - np.pi
    in_air = -np.arcsin(INDEX * np.sin(in_stone))

    record = trace(solid(p), *from_above([x, y]), model)
    assert record.status == RayStatus.EXITED
    assert (record.entry_facet, record.exit_facet, record.reflections) == (0, 0, 2)
    np.testing.assert_allclose(record.exit_point, [[side * out[0], y, table]], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(
        record.exit_direction, [[-side * np.sin(in_air), 0, np.cos(in_air)]], rtol=0, atol=ROUNDING
    )
    # Into the table and, at normal incidence, out of it to the eye: S(out) = 1.
    transmitted = transmittance([np.cos(in_air), 1.0], INDEX, model.fresnel).prod()
    beam = np.cos(in_air) / np.cos(in_stone) if model.intensity == "primary" else 1.0
    assert record.primary_intensity == pytest.approx(100 * transmitted * beam, abs=100 * ROUNDING)
    assert record.rear_mask == 0


def test_ray_through_a_bezel_main_is_refracted_by_snells_law():
    # The main turns a vertical ray towards the axis by the crown angle less the angle of refraction; a
    # pavilion of 3 deg then lets it out at once.
    p = cut(pavilion_angle=3.0)
    crown, pavilion, x = np.radians(34.5), np.radians(3.0), 0.8
    refracted = np.arcsin(np.sin(crown) / INDEX)
    in_stone = crown - refracted + pavilion
    in_air = np.arcsin(INDEX * np.sin(in_stone))
    z = 2 * (p.girdle_thickness / 100 + p.crown_height / 100 * (1 - x) / (1 - 0.53))
    d = np.array([-np.sin(crown - refracted), -np.cos(crown - refracted)])
    depth = 2 * p.pavilion_depth / 100
    t = (-depth * (1 - x) - z) / (d[1] - depth * d[0])

    record = trace(solid(p), *from_above([x, 0.001]))
    assert (FACET_KINDS[record.entry_facet[0]], FACET_KINDS[record.exit_facet[0]]) == (
        "bezel",
        "pavilion_main",
    )
    assert record.reflections == 0
    np.testing.assert_allclose(
        record.exit_point, [[x + t * d[0], 0.001, z + t * d[1]]], rtol=0, atol=ROUNDING
    )
    down = np.array([-np.sin(in_air - pavilion), 0.0, -np.cos(in_air - pavilion)])
    np.testing.assert_allclose(record.exit_direction, [down], rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("rear", ["position", "direction"])
def test_fish_eye_sees_through_its_pavilion(rear):
    # A pavilion flatter than the critical angle lets a vertical ray out below: rear light by either rule.
    alpha = np.radians(15.0)
    record = trace(solid(cut(pavilion_angle=15.0)), *from_above([0.1, 0.003]), Model(rear=rear))
    in_air = np.arcsin(INDEX * np.sin(alpha))
    np.testing.assert_allclose(
        record.exit_direction, [[np.sin(alpha - in_air), 0.0, -np.cos(alpha - in_air)]], rtol=0, atol=ROUNDING
    )
    assert (record.status, record.reflections, record.rear_mask) == (RayStatus.EXITED, 0, 1)
    assert record.primary_intensity == 0


@pytest.mark.parametrize("model", MODELS, ids=str)
def test_light_from_above_through_the_pavilion_is_rear_light_by_position_only(model):
    # At the second main of a pavilion of 52 deg the incidence is 180 - 3 * 52 = 24 deg, just below the
    # critical angle: the ray leaves 79.5 deg from the main's normal, which is 41.5 deg above the horizon.
    alpha = np.radians(52.0)
    in_stone = np.pi - 3 * alpha
    in_air = np.arcsin(INDEX * np.sin(in_stone))
    elevation = in_air - (np.pi / 2 - alpha)
    assert np.degrees(elevation) == pytest.approx(41.5, abs=ONE_DECIMAL)
    stone, ray = solid(cut(pavilion_angle=52.0)), from_above([0.1, 0.003])

    by_position = trace(stone, *ray, model)
    assert (by_position.status, by_position.reflections) == (RayStatus.EXITED, 1)
    assert FACET_KINDS[by_position.exit_facet[0]] == "pavilion_main"
    assert (by_position.exit_point[0, 2] < 0, by_position.rear_mask[0]) == (True, 1)
    assert by_position.primary_intensity == 0
    np.testing.assert_allclose(
        by_position.exit_direction, [[-np.cos(elevation), 0, np.sin(elevation)]], rtol=0, atol=100 * ROUNDING
    )

    by_direction = trace(
        stone, *ray, Model(fresnel=model.fresnel, intensity=model.intensity, rear="direction")
    )
    transmitted = transmittance([np.cos(in_air), 1.0], INDEX, model.fresnel).prod()
    beam = np.cos(in_air) / np.cos(in_stone) if model.intensity == "primary" else 1.0
    assert by_direction.rear_mask == 0
    assert by_direction.primary_intensity == pytest.approx(100 * transmitted * beam, abs=1e4 * ROUNDING)


@pytest.mark.parametrize(("beyond_deg", "reflections"), [(-CRITICAL_MARGIN_DEG, 0), (CRITICAL_MARGIN_DEG, 1)])
def test_total_reflection_sets_in_at_the_critical_angle(beyond_deg, reflections):
    p = cut(pavilion_angle=critical_angle_deg(INDEX) + beyond_deg)
    record = trace(solid(p), *from_above([0.1, 0.003]))
    assert min(record.reflections[0], 1) == reflections


def test_at_the_critical_angle_itself_no_ray_is_lost():
    stone = solid(cut(pavilion_angle=critical_angle_deg(INDEX)))
    record = trace(stone, *from_above(np.column_stack([np.linspace(-0.3, 0.3, 101), np.full(101, 0.003)])))
    assert set(record.status) <= {RayStatus.EXITED, RayStatus.TRAPPED}


# ---- Against half-spaces -------------------------------------------------------------------------------


def symmetric_stones():
    rng = np.random.default_rng(seed=7)
    stones = {name: load_stone(name).proportions for name in SAMPLES}
    stones |= {f"random {k}": random_brilliant(rng) for k in range(4)}
    return stones | {f"girdle {g:g} %": sample(girdle_thickness=g) for g in THICKNESSES}


SYMMETRIC = symmetric_stones()
symmetric = pytest.mark.parametrize("proportions", SYMMETRIC.values(), ids=SYMMETRIC.keys())


@symmetric
def test_planes_are_those_of_the_proportions(proportions):
    stone, planes = solid(proportions), half_spaces(proportions)
    np.testing.assert_allclose(stone.facet_normals, planes.normals, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(stone.facet_offsets, planes.offsets, rtol=0, atol=ROUNDING)


@symmetric
def test_first_surface_from_outside_is_where_the_half_spaces_begin(proportions, rng):
    planes = half_spaces(proportions)
    for origin, direction in (over_the_top_view(rng, 1500), from_all_around(rng, 1500)):
        t_in, facet, t_out, _ = planes.clip(origin, direction)
        hit = surfaces_of(solid(proportions)).nearest(origin, direction, inside=False)
        met = t_in < t_out
        np.testing.assert_array_equal(hit.facet, np.where(met, facet, -1))
        np.testing.assert_allclose(hit.distance[met], t_in[met], rtol=0, atol=PATH)
        assert np.isinf(hit.distance[~met]).all()
        point = origin[met] + hit.distance[met, None] * direction[met]
        np.testing.assert_allclose(hit.normal[met], planes.normal(facet[met], point), rtol=0, atol=PATH)


@symmetric
def test_next_surface_from_inside_is_where_the_half_spaces_end(proportions, rng):
    planes = half_spaces(proportions)
    p = rng.uniform(-1, 1, size=(8000, 3))
    p = p[planes.outside(p) < 0]
    assert len(p) > 500
    direction = from_all_around(rng, len(p))[1]
    hit = surfaces_of(solid(proportions)).nearest(p, direction, inside=True)
    _, _, t_out, facet = planes.clip(p, direction)
    np.testing.assert_array_equal(hit.facet, facet)
    np.testing.assert_allclose(hit.distance, t_out, rtol=0, atol=PATH)


@symmetric
@pytest.mark.parametrize("rays", [over_the_top_view, from_all_around])
def test_paths_are_those_of_the_half_spaces(proportions, rays, rng):
    origin, direction = rays(rng, 1500)
    record = trace(solid(proportions), origin, direction)
    paths = follow(half_spaces(proportions), origin, direction, INDEX)
    # Off the girdle rounding errors grow exponentially: two float64 tracers part after a hundred reflections.
    short = paths.reflections <= FEW_REFLECTIONS
    assert short.mean() > 0.9
    for name in ("status", "reflections", "entry_facet", "exit_facet"):
        np.testing.assert_array_equal(getattr(record, name)[short], getattr(paths, name)[short], err_msg=name)
    for name in ("exit_point", "exit_direction"):
        np.testing.assert_allclose(
            getattr(record, name)[short], getattr(paths, name)[short], rtol=0, atol=PATH, err_msg=name
        )


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("model", MODELS, ids=str)
def test_intensity_is_t_s_t_s_and_radiance_t_t(name, model, rng):
    proportions = load_stone(name).proportions
    origin, direction = over_the_top_view(rng, 1500)
    record = trace(solid(proportions), origin, direction, model)
    paths = follow(half_spaces(proportions), origin, direction, INDEX)
    lit = (paths.status == RayStatus.EXITED) & (paths.reflections <= FEW_REFLECTIONS)
    lit &= paths.exit_point[:, 2] > 0
    assert lit.sum() > 800
    (air_eye, stone_eye), (air_light, stone_light) = paths.eye_side[lit].T, paths.light_side[lit].T
    expected = 100 * transmittance(air_eye, INDEX, model.fresnel)
    expected *= transmittance(air_light, INDEX, model.fresnel)
    if model.intensity == "primary":
        expected *= (air_light / stone_light) * (stone_eye / air_eye)
    np.testing.assert_allclose(record.primary_intensity[lit], expected, rtol=0, atol=PATH_PERCENT)


# ---- Light goes both ways ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SAMPLES)
def test_light_sent_back_comes_out_at_the_eye(name, rng):
    stone, model = load_stone(name), Model(fresnel="exact", intensity="radiance", rear="direction")
    origin, direction = over_the_top_view(rng, 1500)
    there = trace(stone, origin, direction, model)
    kept = (there.status == RayStatus.EXITED) & (there.reflections <= FEW_REFLECTIONS)
    assert kept.sum() > 1000
    start = there.exit_point[kept] + 3 * there.exit_direction[kept]
    back = trace(stone, start, -there.exit_direction[kept], model)
    np.testing.assert_array_equal(back.entry_facet, there.exit_facet[kept])
    np.testing.assert_array_equal(back.exit_facet, there.entry_facet[kept])
    np.testing.assert_array_equal(back.reflections, there.reflections[kept])
    np.testing.assert_allclose(back.exit_point[:, :2], origin[kept, :2], rtol=0, atol=PATH)
    np.testing.assert_allclose(back.exit_direction, -direction[kept], rtol=0, atol=PATH)
    # T T is the same both ways, wherever it is not rear light.
    lit = there.rear_mask[kept] == 0
    np.testing.assert_allclose(
        back.primary_intensity[lit], there.primary_intensity[kept][lit], rtol=0, atol=PATH_PERCENT
    )


# ---- The two rules for rear light ----------------------------------------------------------------------


@pytest.mark.parametrize("rear", ["position", "direction"])
@pytest.mark.parametrize("name", SAMPLES)
def test_rear_mask_follows_its_rule(name, rear):
    stone = load_stone(name)
    seen = observe(stone, View.of(stone, 64), Model(rear=rear))
    height = seen.exit_point[..., 2] if rear == "position" else seen.exit_direction[..., 2]
    met = seen.coverage > 0
    np.testing.assert_array_equal(seen.rear_mask[met], height[met] <= 0)
    assert (seen.primary_intensity[seen.rear_mask > 0] == 0).all()


@pytest.mark.parametrize("height", [-1e-4, 1e-4])
@pytest.mark.parametrize("name", SAMPLES)
def test_rear_light_begins_at_the_girdles_lower_edge(name, height, rng):
    # Light that comes in a little above the lower edge of the girdle, or below it: sent in to there, and then
    # followed back from where it comes out. Beside a girdle vertex the edge is at z = 0, within 2e-5.
    proportions = load_stone(name).proportions
    azimuth = np.pi / 8 * rng.integers(16, size=400) + 1e-4
    if height > 0:
        normal = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(400)], axis=-1)
        radius = np.ones(400)
    else:
        planes = half_spaces(proportions)
        sector = 33 + np.floor(azimuth / (np.pi / 8)).astype(int)  # lower girdle facets are 33 to 48
        normal = planes.normals[sector]
        outwards = normal[:, 0] * np.cos(azimuth) + normal[:, 1] * np.sin(azimuth)
        radius = (planes.offsets[sector] - height * normal[:, 2]) / outwards
    place = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.full(400, height)], axis=-1)
    towards = from_all_around(rng, 400)[1]
    towards[(towards * normal).sum(axis=1) > 0] *= -1

    stone, model = solid(proportions), Model(fresnel="exact")
    sent = trace(stone, place - 3 * towards, towards, model)
    came_out = (sent.status == RayStatus.EXITED) & (sent.reflections <= FEW_REFLECTIONS)
    assert came_out.sum() > 100
    start, back = sent.exit_point[came_out], sent.exit_direction[came_out]
    followed = trace(stone, start + 3 * back, -back, model)
    np.testing.assert_allclose(followed.exit_point, place[came_out], rtol=0, atol=PATH)
    assert (followed.rear_mask == (height < 0)).all()


# ---- The same stone, given otherwise -------------------------------------------------------------------


@pytest.mark.parametrize("name", SAMPLES)
def test_stone_given_by_its_vertices_scores_the_same(name):
    made = load_stone(name)
    given = stone_from_vertices(3.7 * made.vertices + [10.0, -20.0, 5.0])
    assert given.is_round
    a, b = (score_observation(observe(stone, View.of(made, 96))) for stone in (made, given))
    assert b.average == pytest.approx(a.average, abs=ORBIT_96)
    assert b.rear == pytest.approx(a.rear, abs=ORBIT_96)


# ---- Tilted views --------------------------------------------------------------------------------------


@pytest.mark.parametrize("tilt_deg", chosen([0, 15, 45, 80, 89.9], [15, 80, 89.9]))
@pytest.mark.parametrize("azimuth_deg", [0, 100])
def test_outline_of_a_tilted_stone_has_the_area_of_its_shadow(tilt_deg, azimuth_deg):
    # The shadow of a convex body is the sum of the areas of the faces that see the eye, foreshortened.
    stone = load_stone("inoue-3")
    view = View.of(stone, 128, tilt_deg=tilt_deg, tilt_azimuth_deg=azimuth_deg)
    seen = observe(stone, view)
    a, b, c = tessellate(stone).vertices[tessellate(stone).faces].transpose(1, 0, 2)
    shadow = np.maximum(np.cross(b - a, c - a) / 2 @ view.basis()[2], 0).sum()
    pixel = (2 * view.half_width / 128) ** 2
    assert seen.coverage.sum() * pixel == pytest.approx(
        shadow, abs=outline_error(view.half_width, view.resolution)
    )
    assert set(np.unique(seen.status)) == {RayStatus.MISSED, RayStatus.EXITED}


def test_from_the_side_the_outline_is_that_of_the_profile():
    # An eye at azimuth -90 deg has x to its right, and almost from the side z up.
    stone = solid(sample())
    view = View.of(stone, 256, tilt_deg=89.999, tilt_azimuth_deg=-90)
    covered = observe(stone, view).coverage > 0
    x, y = view.cell_centres()
    step = x[1] - x[0]
    rows = y[covered.any(axis=1)]
    np.testing.assert_allclose(rows.max(), 2 * 0.182, rtol=0, atol=step)
    np.testing.assert_allclose(rows.min(), -2 * 0.4308, rtol=0, atol=step)
    for height, half in ((0.025, 1.0), (2 * 0.182 - step, 0.54 + step), (-0.4308, 0.5)):
        row = np.abs(y - height).argmin()
        np.testing.assert_allclose(np.abs(x[covered[row]]).max(), half, rtol=0, atol=2 * step)


def test_tilt_is_a_turn_of_the_stone():
    # A stone turned by 45 deg looks the same; so does the view tilted to an azimuth 45 deg further on, with
    # the map turned by 45 deg: scores agree as well as two samplings of one image do.
    stone = load_stone("inoue-3")
    at_0, at_90 = (observe(stone, View.of(stone, 96, tilt_deg=20, tilt_azimuth_deg=a)) for a in (0, 90))
    turned = np.rot90(at_0.primary_intensity)
    met = turned > 0
    assert np.isclose(turned, at_90.primary_intensity, rtol=0, atol=1e-3)[met].mean() > 0.999


# ---- Observing -----------------------------------------------------------------------------------------


def test_map_is_the_trace_of_its_cells(monkeypatch):
    stone = load_stone("inoue-1")
    view = View.of(stone, 24)
    monkeypatch.setattr(tracer, "BLOCK", 100)  # not a divisor of the number of pixels
    told = []
    seen = observe(stone, view, threads=2, progress=told.append)
    x, y = view.cell_centres()
    record = trace(stone, *from_above(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)))
    for name in ("status", "reflections", "entry_facet", "exit_facet", "path_code"):
        np.testing.assert_array_equal(getattr(seen, name).ravel(), getattr(record, name), err_msg=name)
    np.testing.assert_allclose(
        seen.primary_intensity.ravel(), record.primary_intensity, rtol=0, atol=SINGLE_PERCENT
    )
    np.testing.assert_allclose(seen.exit_point.reshape(-1, 3), record.exit_point, rtol=0, atol=SINGLE)
    assert told == sorted(told)
    assert told[-1] == 1


def test_path_code_spells_the_facet_sequence(rng):
    # Up to four facets fit into 24 bits: the digits of the code to the base 61 are the facets' numbers + 1.
    proportions = load_stone("inoue-3").proportions
    origin, direction = over_the_top_view(rng, 1500)
    code = trace(solid(proportions), origin, direction).path_code
    paths = follow(half_spaces(proportions), origin, direction, INDEX)
    for facets in (2, 3, 4):
        with_so_many = (paths.status == RayStatus.EXITED) & (paths.reflections == facets - 2)
        digits = code[with_so_many, None] // 61 ** np.arange(4) % 61
        expected = np.zeros_like(digits)
        expected[:, :facets] = paths.first_facets[with_so_many, :facets][:, ::-1] + 1
        np.testing.assert_array_equal(digits, expected)
    assert code[paths.status == RayStatus.MISSED].max() == 0
    assert 0 < code.max() < 2**24

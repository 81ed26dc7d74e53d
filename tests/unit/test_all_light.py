"""All light by the reference tracer: closed forms, energy, agreement with the principal tracer."""

from __future__ import annotations

import numpy as np
import pytest
from any_stones import design, hollow_stone
from designs_help import level, ring, stone_of
from light_help import light_of, spread_points

from gemrender import Model, RayStatus, View, load_stone
from gemrender.measures.dispersion import exit_directions
from gemrender.optics.fresnel import reflectance, transmittance
from gemrender.reference import observe, paths, paths_by_ray, trace

INDEX = 1.54
#: Sums and products of some hundred float64 numbers of order 1.
ROUNDING = 1e-12
#: Directions after up to hundreds of reflections, cosines near grazing: rounding times some thousands.
LONG_PATH = 1e-9


def slab(half_height: float = 0.05):
    """Return a wide flat slab: facets above, below, and four far away."""
    return stone_of(np.vstack([level(half_height), level(half_height, down=True), ring(4, 90, 5.0)]))


def through_the_middle(stone, tilt=0.0, **other):
    view = View(resolution=1, half_width=0.5, tilt_deg=tilt, tilt_azimuth_deg=90.0)
    return paths(stone, view, follow="all", points=[(0.01, 0.02)], **other)


@pytest.mark.parametrize("tilt", [0.0, 20.0])
def test_light_in_a_slab_is_a_geometric_series(tilt):
    # R is the same at every crossing: the k-th leaves T R^k, below and above in turn, along the ray or its
    # mirror image.
    found = through_the_middle(slab(), tilt, least=1e-9)
    cos = np.cos(np.radians(tilt))
    r = reflectance(cos, INDEX)
    out, rest = found.rows(slice(0, -1)), found.rows(slice(-1, None))
    k = np.arange(len(out))
    assert (out.status == RayStatus.EXITED).all()
    np.testing.assert_allclose(out.weight, r**k, rtol=ROUNDING)
    np.testing.assert_array_equal(out.reflections, k)
    np.testing.assert_array_equal(out.partial_reflections, k)
    np.testing.assert_allclose(out.cos_entry, cos, rtol=ROUNDING)
    np.testing.assert_allclose(out.cos_exit, cos, rtol=ROUNDING)
    np.testing.assert_array_equal(out.entry_facet, 0)
    np.testing.assert_array_equal(out.exit_facet, (k + 1) % 2)
    np.testing.assert_allclose(out.exit_direction[:, 2], np.where(k % 2, cos, -cos), rtol=ROUNDING)
    np.testing.assert_allclose(out.exit_direction[:, 1], -np.sin(np.radians(tilt)), atol=ROUNDING)
    # Unfolded, a slab is a slab as often as high.
    np.testing.assert_allclose(out.entry_normal, np.broadcast_to([0, 0, 1], (len(out), 3)), atol=ROUNDING)
    np.testing.assert_allclose(
        out.unfolded_exit_normal, np.broadcast_to([0, 0, -1], (len(out), 3)), atol=ROUNDING
    )
    assert rest.status == RayStatus.TRAPPED
    np.testing.assert_allclose(rest.weight, r ** len(out), rtol=ROUNDING)
    assert rest.weight * (1 - r) < 1e-9 <= out.weight[-1] * (1 - r)
    assert rest.partial_reflections == rest.reflections == len(out)
    assert rest.exit_facet == -1


def test_light_caught_by_total_reflection_has_no_partial_one():
    # A cube of index 2, whose critical angle is 30 deg: light at 45 deg in air runs at 20.7 deg from the
    # vertical, so it leaves by top and bottom in part, and walls reflect all of it.
    cube = stone_of(np.vstack([level(1.0), level(1.0, down=True), ring(4, 90, 1.0)]), material=2.0)
    view = View(resolution=1, tilt_deg=45.0, tilt_azimuth_deg=0.0)
    found = paths(cube, view, follow="all", points=spread_points(5, View(resolution=1, half_width=0.1)))
    exits = found.rows(found.status == RayStatus.EXITED)
    assert set(exits.exit_facet) == {0, 1}
    r = reflectance(np.cos(np.radians(45)), 2.0)
    np.testing.assert_allclose(exits.weight, r**exits.partial_reflections, rtol=ROUNDING)
    assert (exits.reflections > exits.partial_reflections).any()


@pytest.mark.parametrize("name", ["inoue-3", "pear", "slab-chiral", "hollow"])
@pytest.mark.parametrize("tilt", [0.0, 25.0])
def test_no_light_is_gained_or_lost_along_a_ray(name, tilt):
    # What the surface reflects, what leaves, and what is still inside make one, for every ray.
    stone = (
        load_stone(name) if name.startswith("inoue") else hollow_stone() if name == "hollow" else design(name)
    )
    view = View.of(stone, 16, tilt_deg=tilt, tilt_azimuth_deg=40.0)
    found, ray = paths_by_ray(stone, view, follow="all", least=1e-4)
    index = Model.of(stone).index
    arriving = transmittance(found.cos_entry, index) * found.weight
    exits = found.status == RayStatus.EXITED
    share = np.where(exits, arriving * transmittance(found.cos_exit, index), arriving)
    surface = np.where(found.partial_reflections == 0, reflectance(found.cos_entry, index), 0.0)
    number = np.bincount(ray)
    total = np.bincount(ray, share + surface)[number > 0]
    np.testing.assert_allclose(total, 1.0, atol=ROUNDING)
    assert (np.bincount(ray, found.partial_reflections == 0)[number > 0] == 1).all()
    rest = found.rows(~exits & (found.partial_reflections > 0))
    assert (transmittance(rest.cos_entry, index) * rest.weight)[rest.status == RayStatus.TRAPPED].max() < 1e-4


@pytest.mark.parametrize("name", ["inoue-3", "pear"])
def test_principal_paths_are_those_of_the_maps(name):
    stone = load_stone(name) if name == "inoue-3" else design(name)
    view = View.of(stone, 24, tilt_deg=15.0, tilt_azimuth_deg=30.0)
    maps = observe(stone, view)
    met = np.flatnonzero(maps.coverage)
    for follow in ("principal", "all"):
        found, ray = paths_by_ray(stone, view, follow=follow)
        first = found.rows(found.partial_reflections == 0)
        np.testing.assert_array_equal(ray[found.partial_reflections == 0], met)
        assert first.area.sum() == pytest.approx(len(met) * (2 * view.half_width / 24) ** 2, rel=ROUNDING)
        for key in ("status", "reflections", "entry_facet", "exit_facet"):
            np.testing.assert_array_equal(getattr(first, key), getattr(maps, key).ravel()[met], err_msg=key)
        for key in ("exit_point", "exit_direction"):
            expected = getattr(maps, key).reshape(-1, 3)[met]
            np.testing.assert_array_equal(getattr(first, key).astype(np.float32), expected, err_msg=key)
    assert len(found) > len(first)


def test_trapped_light_is_counted_as_the_maps_count_it():
    stone = load_stone("inoue-3")
    view, model = View.of(stone, 24), Model(max_reflections=2)
    maps, found = observe(stone, view, model), paths(stone, view, model)
    trapped = found.rows(found.status == RayStatus.TRAPPED)
    assert len(trapped) == (maps.status == RayStatus.TRAPPED).sum() > 0
    np.testing.assert_array_equal(trapped.reflections, 2)
    np.testing.assert_array_equal(trapped.weight, 1.0)


@pytest.mark.parametrize("name", ["inoue-3", "pear"])
def test_the_unfolded_stone_refracts_as_the_folded_one(name):
    # Straight through the unfolded stone a ray leaves at the same angle as on its folded path.
    stone = load_stone(name) if name == "inoue-3" else design(name)
    light = light_of(stone, 20, least=1e-3, tilt=15.0)
    exits = light.paths.rows(light.paths.status == RayStatus.EXITED)
    out = exit_directions(
        -light.view.basis()[2], exits.entry_normal, exits.unfolded_exit_normal, light.model.index
    )
    cos = np.einsum("ij,ij->i", out, exits.unfolded_exit_normal)
    np.testing.assert_allclose(cos**2, exits.cos_exit**2, atol=LONG_PATH)
    np.testing.assert_allclose(np.linalg.norm(exits.unfolded_exit_normal, axis=1), 1.0, atol=ROUNDING)


def test_colours_part_as_the_tracer_parts_them():
    # Two indices followed by themselves: where they meet the same facets, the angle between them is that of
    # the unfolded stone.
    from gemrender.measures.dispersion import fan_angle

    stone, blue, red = load_stone("inoue-3"), 2.4354, 2.4100
    view = View.of(stone, 20, tilt_deg=5.0)
    points, basis = spread_points(20, view), view.basis()
    found, ray = paths_by_ray(stone, view, Model.of(stone), points=points)
    origin = points @ basis[:2] + 10 * basis[2]
    records = [
        trace(stone, origin, np.broadcast_to(-basis[2], origin.shape), Model(index=n, fresnel="exact"))
        for n in (blue, red, Model.of(stone).index)
    ]
    codes = np.array([record.path_code for record in records])[:, ray]
    same = (codes == codes[-1]).all(axis=0) & (found.status == RayStatus.EXITED)
    assert same.sum() > 100
    traced = fan_angle(*(record.exit_direction[ray][same] for record in records[:2]))
    some = found.rows(same)
    unfolded = fan_angle(
        *(exit_directions(-basis[2], some.entry_normal, some.unfolded_exit_normal, n) for n in (blue, red))
    )
    # On the cylinder the normal moves with the point; facets are flat.
    flat = [side != "girdle" for side in stone.facet_sides]
    keep = np.array(flat)[some.entry_facet] & np.array(flat)[some.exit_facet]
    close = np.abs(traced - unfolded) < LONG_PATH
    assert close[keep].mean() > 0.99  # paths over the cylinder are the others
    assert traced[keep].max() > 1.0


def test_another_way_to_follow_light_is_refused():
    with pytest.raises(ValueError, match="follow must be one of principal, all, got 'some'"):
        paths(slab(), View(resolution=2), follow="some")

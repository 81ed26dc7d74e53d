"""All light by Mitsuba: energy, closed forms, every exit along a ray, and the numbers of `truth.json`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from any_stones import design, hollow_stone
from designs_help import level, ring, stone_of
from physics_tolerances import FEW_REFLECTIONS, OTHER_WAY, PATH, ROUNDING, SINGLE, Z
from solids import cleft_heart
from thorough import chosen

from gemrender import Model, RayStatus, View, load_stone
from gemrender.errors import InputError
from gemrender.measures.measure import Light
from gemrender.optics.fresnel import reflectance
from gemrender.reference.all_light import paths_by_ray
from gemrender.render import paths as engine
from gemrender.render.observe import observe, sensor_rays
from gemrender.render.paths import trace_paths

TRUTH = json.loads(
    (Path(__file__).parents[1] / "cases" / "stones" / "truth.json").read_text(encoding="utf-8")
)
STONES = {
    "round": lambda: load_stone("inoue-1"),
    "pear": lambda: design("pear"),
    "hollow": hollow_stone,
    "cleft heart": cleft_heart,
}
SIZE = 32
TILTED = {"tilt_deg": 20.0, "tilt_azimuth_deg": 50.0}
#: A sum of weights and shares along a ray of a few hundred surfaces.
SUM = 1000 * ROUNDING

pytestmark = pytest.mark.usefixtures("variant_llvm_ad_mono")


def traced(stone, *, resolution=SIZE, model=None, tilt=TILTED, **options):
    """Trace; return the paths with what measures need."""
    model = model or Model.of(stone, fresnel="exact")
    view = View.of(stone, resolution, **tilt)
    return Light(paths=trace_paths(stone, view, model, **options), view=view, model=model)


# ---- Energy --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("most", [1000, 3])
@pytest.mark.parametrize("name", STONES)
def test_light_is_mirrored_leaves_or_is_still_inside(name, most):
    # Of each ray by itself: the later exit stands for all that its first one reflects.
    stone = STONES[name]()
    light = traced(stone, model=Model.of(stone, fresnel="exact", max_reflections=most))
    area, principal = light.paths.area, light.is_principal
    inside = np.where(light.is_exit, 0.0, light.arriving)
    found = area @ (light.share + inside) / area[principal].sum()
    mirrored = light.surface_reflectance[principal].mean()
    assert found + mirrored == pytest.approx(1.0, abs=SUM)
    assert (light.paths.status == RayStatus.TRAPPED).any() == (most == 3)
    assert light.paths.reflections.max() <= most
    later = light.paths.partial_reflections > 0
    assert np.count_nonzero(later) == np.count_nonzero(principal & light.is_exit)


# ---- Closed form: a cube -------------------------------------------------------------------------------


def test_cube_lets_light_out_at_the_angle_at_which_it_came_in():
    # Of an index above sqrt 2, the faces across that of the entry reflect all light. R is the same at each
    # exit: after k partial reflections R^k arrives, and k is drawn with the probability R^(k-1) (1 - R).
    index = 1.6
    cube = stone_of(np.vstack([ring(4, 90, 1.0), level(1.0), level(1.0, down=True)]), material=index)
    light = traced(cube, resolution=128, tilt={"tilt_deg": 35.0, "tilt_azimuth_deg": 20.0})
    paths, back = light.paths, reflectance(light.paths.cos_entry, index)
    assert light.is_exit.all()
    np.testing.assert_allclose(paths.cos_exit, paths.cos_entry, rtol=0, atol=PATH)
    partial = paths.partial_reflections
    np.testing.assert_allclose(paths.weight, back**partial, rtol=PATH)
    later, back, partial = partial > 0, back[partial > 0], partial[partial > 0]
    pixel = paths.area[~later][0]
    np.testing.assert_allclose(pixel / paths.area[later], back ** (partial - 1) * (1 - back), rtol=PATH)
    # Their mean number, beside its standard error
    off = (partial - 1 / (1 - back)).sum() / np.sqrt((back / (1 - back) ** 2).sum())
    assert abs(off) < Z
    # Out through the face of the entry, and through the one across, by turns
    across = paths.exit_facet != paths.entry_facet
    np.testing.assert_array_equal(across, paths.partial_reflections % 2 == 0)


# ---- Every exit along a ray ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["round", "pear", "hollow"])
def test_later_exit_is_one_of_those_that_there_are(name):
    # The reference follows the very same rays through every exit; the row of each is told by its ray and the
    # number of its partial reflections.
    stone = STONES[name]()
    light = traced(stone, tilt={})
    paths, later = light.paths, light.paths.partial_reflections > 0
    met = observe(stone, light.view, light.model).coverage.ravel() > 0
    origin, _ = sensor_rays(light.view, variant="llvm_ad_mono")
    points = origin.reshape(-1, 3)[met, :2]
    every, ray_of = paths_by_ray(stone, light.view, light.model, follow="all", points=points)
    principal = np.flatnonzero(~later)
    assert len(points) == len(principal)
    ray = np.empty(len(paths), dtype=int)
    ray[principal] = np.arange(len(principal))
    ray[later] = ray[principal[light.is_exit[principal]]]
    assert paths.partial_reflections[later].max() > 1

    row_of = {key: row for row, key in enumerate(zip(ray_of, every.partial_reflections, strict=True))}
    row = np.array([row_of.get(key, -1) for key in zip(ray, paths.partial_reflections, strict=True)])
    few = light.is_exit & (paths.reflections <= FEW_REFLECTIONS)
    same = (row >= 0) & (every.exit_facet[row] == paths.exit_facet)
    same &= every.reflections[row] == paths.reflections
    assert np.mean(~same[few]) <= OTHER_WAY
    chosen = few & same
    assert (chosen & later).any()
    for column in ("weight", "cos_entry", "cos_exit", "exit_point", "exit_direction", "entry_normal"):
        np.testing.assert_allclose(
            getattr(paths, column)[chosen],
            getattr(every, column)[row[chosen]],
            rtol=0,
            atol=PATH,
            err_msg=column,
        )


def test_principal_paths_are_those_of_the_maps():
    stone = load_stone("inoue-3")
    light = traced(stone, model=Model.of(stone))
    alone = traced(stone, model=Model.of(stone), follow="principal").paths
    paths, seen = light.paths, observe(stone, light.view, light.model)
    assert (alone.partial_reflections == 0).all()
    assert (alone.weight == 1).all()
    met = seen.coverage > 0
    maps = ("status", "reflections", "entry_facet", "exit_facet", "exit_point", "exit_direction")
    for name in (*maps, "area", "weight", "cos_entry", "cos_exit", "entry_normal"):
        of_all = getattr(paths, name)[light.is_principal]
        np.testing.assert_array_equal(of_all, getattr(alone, name), err_msg=name)
        if name in maps:
            np.testing.assert_allclose(of_all, getattr(seen, name)[met], rtol=0, atol=SINGLE, err_msg=name)
    eye = light.view.basis()[2]
    np.testing.assert_allclose(paths.entry_normal @ eye, paths.cos_entry, rtol=0, atol=SINGLE)


# ---- Against truth -------------------------------------------------------------------------------------

#: 65 536 rays in independent sets, whose scatter is the noise.
PIXELS, SETS = 64, 16
#: Truth's own bound [%].
TRUTHS_BOUND = 0.01
#: A larger noise would hide a wrong definition: those of ISO differ by 1 and more [%].
LEAST_TELLING = 0.25


def zones(light):
    """ISO, and the weighted zones of ASET, of each set by itself [%]; by the definitions (docs/model.md)."""
    z = light.zenith_cosine
    blue, red = np.cos(np.radians([15.0, 45.0]))
    parts = [(z > 0) & (z < red), (z >= red) & (z < blue), z >= blue, z <= 0]
    return np.array([iso(light), *(means(light, light.share * part) for part in parts)])


def iso(light):
    head = np.cos(np.radians(10.0))
    from_sky, mirrored = ((z > 0) & (z < head) for z in (light.zenith_cosine, light.mirror_cosine))
    return means(light, light.share * from_sky + light.surface_reflectance * (mirrored & light.is_principal))


def means(light, values):
    """Return the means over the view of each set [%]."""
    sets, area = light.paths.set_number, light.paths.area
    return 100 * np.bincount(sets, area * values) / np.bincount(sets, area * light.is_principal)


def assert_within_noise(found, expected):
    error = found.std(axis=-1, ddof=1) / SETS**0.5
    assert error.max() < LEAST_TELLING
    np.testing.assert_array_less(abs(found.mean(axis=-1) - expected), Z * error + TRUTHS_BOUND)


@pytest.mark.parametrize("name", chosen(TRUTH, ["emerald", "pear", "heart", "checkerboard-round"]))
def test_measures_of_designs(name):
    truth = TRUTH[name]
    expected = [truth["all_light_head_10"]["iso"], *truth["aset_weighted_internal_green_red_blue_leak"]]
    light = traced(design(name), resolution=PIXELS, spp=SETS, tilt={})
    assert_within_noise(zones(light), expected)


@pytest.mark.parametrize("name", ["emerald", "pear"])
def test_measure_of_a_tilted_design(name):
    # As GemRay has it: of at most nine hits, until a thousandth of the light is left.
    light = traced(
        design(name), resolution=PIXELS, spp=SETS, tilt={"tilt_deg": 15.0, "tilt_azimuth_deg": 90.0}
    )
    light.share[(light.paths.reflections >= 9) | (light.arriving < 0.001)] = 0
    assert_within_noise(iso(light), TRUTH[name]["tilt_15_deg_about_x"]["iso_gemray"])


# ---- Sets, seeds, passes -------------------------------------------------------------------------------


def test_sets_share_the_view():
    stone, resolution = design("pear"), 32
    light = traced(stone, resolution=resolution, spp=4, tilt={})
    paths = light.paths
    np.testing.assert_array_equal(np.unique(paths.set_number), np.arange(4))
    seen = paths.area[light.is_principal]
    pixel = (2 * light.view.half_width / resolution) ** 2
    assert (seen == pixel / 4).all()
    outline = np.maximum(stone.solid.polyhedron.crosses[:, 2], 0).sum()
    # Random places within the pixels along the outline: some 3 x 32 of them, each of variance 1/4 at most
    assert seen.sum() == pytest.approx(outline, abs=Z * pixel * (3 * resolution / 4 / 4) ** 0.5)
    assert len(np.unique(paths.exit_point[light.is_principal & light.is_exit], axis=0)) > 0.99 * len(seen)


def test_seed_draws_the_later_exits_only(monkeypatch):
    first, again, other = (traced(design("pear"), seed=seed).paths for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.area, again.area)
    np.testing.assert_array_equal(first.exit_point, again.exit_point)
    principal = first.partial_reflections == 0
    np.testing.assert_array_equal(other.partial_reflections == 0, principal)
    np.testing.assert_array_equal(other.exit_point[principal], first.exit_point[principal])
    assert (other.partial_reflections != first.partial_reflections)[~principal].any()
    monkeypatch.setattr(engine, "PASS_RAYS", SIZE * SIZE // 4)
    done = []
    in_passes = traced(design("pear"), seed=1, progress=done.append).paths
    assert done == [0.25, 0.5, 0.75, 1.0]
    np.testing.assert_array_equal(in_passes.entry_facet, first.entry_facet)
    np.testing.assert_array_equal(in_passes.exit_facet[principal], first.exit_facet[principal])
    # Each pass has random numbers of its own.
    assert (in_passes.partial_reflections != first.partial_reflections)[~principal].any()


def test_every_variant_finds_the_same_paths(variants_all):
    light = traced(design("pear"), variant=variants_all)
    mono = traced(design("pear"), variant="llvm_ad_mono").paths
    for column in ("exit_point", "weight", "area", "cos_exit"):
        np.testing.assert_array_equal(getattr(light.paths, column), getattr(mono, column), err_msg=column)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"follow": "some"}, "follow = 'some': must be one of principal, all"),
        ({"seed": -1}, "seed = -1: must be a whole number, at least 0"),
        ({"spp": 0}, "spp = 0: must be a whole number, at least 1"),
        ({"spp": 1.5}, r"spp = 1\.5: must be a whole number, at least 1"),
    ],
)
def test_bad_value_is_refused_in_one_line(options, message):
    with pytest.raises(InputError, match=message):
        traced(design("pear"), **options)

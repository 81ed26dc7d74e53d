"""Known physics of birefringent stones through `gem_path`: furnaces, plates, prisms, pleochroism."""

from __future__ import annotations

import math

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from physics_tolerances import SLAB, THREE_SIGMA
from solids import bent_stone
from thorough import chosen

from gemrender import load_stone
from gemrender.optics import load_material
from gemrender.optics.fresnel import reflectance
from gemrender.render.passes import Passes
from gemrender.scene.mesh import placed_mesh
from gemrender.scene.placing import Placed
from gemrender.stone import ConvexSolid, Facet, Stone, side_of, tessellate

#: Light of radiance 1 from everywhere.
FURNACE = {"type": "constant", "radiance": {"type": "uniform", "value": 1.0}}
STONES = {
    "inoue-3": load_stone("inoue-3"),
    # The first is not convex, and left to Embree.
    "hollow": bent_stone(0.003, name="hollow"),
    "oval": bent_stone(0, name="oval", stretched=1.05),
}
#: Axes of crystals: the view's, across it, and neither.
ALONG, ACROSS, ASKEW = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.3, -0.5, 0.8)
#: Where a ray leaves a plate [its thickness]: directions in single precision, and a start off the facet.
PLACE = 1e-5
#: Shares of light after a few facets, in single precision.
SINGLE_SHARE = 2e-6
#: Angles between directions in single precision, from arccos [rad].
ANGLE = 5e-4
#: Where a ray along the axis leaves a plate, as kernels take the axis to be 2e-3 off: less than that.
OFF_AXIS = 2e-3
#: A share of a half of 16 384 rays, whose modes are drawn by chance: four times its scatter.
BY_CHANCE = 4 * 0.5 / 128


def convex(planes):
    """A stone of planes (n, 4)."""
    facets = tuple(Facet(f"f_{k}", "f", side_of(plane[2])) for k, plane in enumerate(planes))
    return Stone(
        solid=ConvexSolid(planes=np.array(planes, dtype=float), facet=np.arange(len(planes))), facets=facets
    )


def random_solid(seed):
    """A stone of 40 planes that touch an ellipsoid."""
    normals = np.random.default_rng(seed).normal(size=(40, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return convex(np.column_stack([normals, np.linalg.norm(normals * [1.0, 0.8, 0.6], axis=1)]))


def mesh(stone, **surface):
    placed = Placed(name="stone", mesh=tessellate(stone), rotation=np.eye(3), scale=1.0, shift=np.zeros(3))
    return placed_mesh(placed, {"type": "gem_dielectric", **surface})


def scene_of(stone, half_width=0.6, filters=None, **surface):
    film = {"type": "hdrfilm", "width": 32, "height": 32, "rfilter": {"type": "box"}}
    to_world = mi.ScalarTransform4f().look_at([0, 0, 10], [0, 0, 0], [0, 1, 0])
    camera = {"type": "orthographic", "to_world": to_world.scale([half_width, half_width, 1]), "film": film}
    integrator = {"type": "gem_path", **(filters or {})}
    parts = {"type": "scene", "integrator": integrator, "light": FURNACE, "sensor": camera}
    return mi.load_dict({**parts, "stone": mesh(stone, **surface)})


def error_of_mean(error):
    """Standard error of the mean over all pixels."""
    return math.sqrt(float((error.astype(float) ** 2).sum())) / np.size(error)


def off_by(mean, error, expected=1.0):
    """How far the mean over all pixels is off, in its standard errors; also what these are."""
    of_mean = error_of_mean(error)
    return (float(np.mean(mean)) - expected) / of_mean, of_mean


# ---- Furnaces ------------------------------------------------------------------------------------------


#: Samples a pixel of furnaces of 32 x 32: a million, and a quarter of that.
MILLION, QUARTER = 1024, 256
FURNACES = [
    *[("inoue-3", of, axis) for of in ("moissanite", "rutile", "calcite") for axis in (ALONG, ACROSS, ASKEW)],
    *[("inoue-3", "topaz", axis) for axis in (ALONG, ASKEW)],
    *[(stone, of, ASKEW) for stone in ("hollow", "oval", "random") for of in ("calcite", "topaz")],
]


@pytest.mark.parametrize(
    ("stone", "material", "c_axis", "samples"),
    [
        *chosen([(*of, MILLION) for of in FURNACES], [("inoue-3", "calcite", ACROSS, MILLION)]),
        ("inoue-3", "moissanite", ALONG, QUARTER),
        *[("hollow", "calcite", ASKEW, QUARTER), ("random", "topaz", ASKEW, QUARTER)],
    ],
)
def test_a_birefringent_stone_cannot_be_seen_in_a_furnace(
    variant_llvm_ad_spectral, stone, material, c_axis, samples
):
    # Its only noise is Russian roulette
    solid = random_solid(5) if stone == "random" else STONES[stone]
    passes = Passes(scene_of(solid, material=material, c_axis=list(c_axis)), seed=1)
    off, of_mean = off_by(*passes.radiance_at(550.0, samples))
    assert of_mean < 1e-4 * math.sqrt(MILLION / samples)
    assert abs(off) <= THREE_SIGMA


def test_wavelengths_that_part_in_two_modes_lose_no_light(variant_llvm_ad_spectral):
    passes = Passes(scene_of(STONES["inoue-3"], material="rutile", c_axis=list(ASKEW)), seed=2)
    passes.add(128)
    passes.add(128)
    y = passes.xyz[..., 1].astype(float)
    assert y.mean() == pytest.approx(1, abs=THREE_SIGMA * y.std() / 32)


def test_a_ground_girdle_of_a_birefringent_stone_loses_no_light(variant_llvm_ad_spectral):
    stone = load_stone("baguette-three")
    scene = scene_of(stone, half_width=0.3, material="calcite", c_axis=list(ASKEW), girdle_alpha=0.4)
    off, of_mean = off_by(*Passes(scene, seed=3).radiance_at(550.0, 256))
    assert of_mean < 1e-3
    assert abs(off) <= THREE_SIGMA


def walked(scene, n, *, origin=None, direction=(0.0, 0.0, -1.0), nm=589.3, segments=0xFFFFFFFF):
    """Send n rays into a stone, of which chance draws the modes: from a point, or from a square above.

    Returns where they start and where they leave it, in which direction (n, 3 each), and which did.
    """
    from gemrender.plugins.modes import walk_modes
    from gemrender.plugins.stones import Stones

    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(1, n)
    stones, ray, place = Stones(scene, sampler), dr.zeros(mi.Ray3f, n), sampler.next_2d() - 0.5
    ray.o = mi.Point3f(place.x, place.y, 5) if origin is None else mi.Point3f(*map(float, origin))
    ray.d, ray.maxt, ray.wavelengths = (
        mi.Vector3f(*map(float, direction)),
        dr.largest(mi.Float),
        mi.Spectrum(nm),
    )
    si = scene.ray_intersect(ray)
    chance = mi.PCG32(n, 1, 2)
    o, d, _, _, left = walk_modes(
        stones, mi.UInt32(1), si.p, ray.d, si.n, mi.Spectrum(1), mi.Float(nm), ray.wavelengths, chance,
        mi.UInt32(0), mi.UInt32(segments), si.is_valid(),
    )  # fmt: skip
    assert np.array(si.is_valid()).all()
    return *(np.broadcast_to(np.array(x).T, (n, 3)) for x in (ray.o, o, d)), np.array(left)


def of_calcite():
    """Ordinary and extraordinary index at the sodium line."""
    n_o, n_e = load_material("calcite").crystal.principal_indices(589.3)
    return float(n_o), float(n_e)


def test_light_walks_through_a_birefringent_stone_and_comes_out(variant_llvm_ad_spectral):
    # All but what total reflection has caught so long that roulette ended it
    *_, left = walked(scene_of(STONES["inoue-3"], material="calcite", c_axis=list(ASKEW)), 1 << 14)
    assert left.mean() > 0.999


# ---- Plates: two images, and two colours ---------------------------------------------------------------


def plate(half_width=10.0):
    """A plate between z = 0 and -1."""
    sides = [[*n, half_width] for n in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0))]
    return convex([[0, 0, 1, 0.0], [0, 0, -1, 1.0], *sides])


def test_calcite_shows_a_point_twice_where_the_closed_form_says(variant_llvm_ad_spectral):
    # Straight on, with the axis at 45 degrees: the extraordinary ray walks off by tan ρ = (n_e^2 - n_o^2) /
    # (n_e^2 + n_o^2), away from the axis where n_e < n_o
    scene = scene_of(plate(), material="calcite", c_axis=[1.0, 0.0, 1.0])
    begin, end, direction, left = walked(scene, 1 << 14, segments=3)
    through = left & (end[:, 2] < -0.5)
    moved = (end - begin)[through, 0]
    ordinary = np.abs(moved) < 1e-3
    n_o, n_e = of_calcite()
    walk_off = (n_e**2 - n_o**2) / (n_e**2 + n_o**2)
    # Down through the plate, the axis leans to -x
    np.testing.assert_allclose(moved[~ordinary], -walk_off, atol=PLACE)
    np.testing.assert_allclose(direction[through], [[0, 0, -1]] * int(through.sum()), atol=PLACE)
    # Of unpolarised light each is half, but for what is reflected
    T = [(1 - float(reflectance(1.0, n))) ** 2 for n in (n_o, 2**0.5 / math.hypot(1 / n_o, 1 / n_e))]
    assert ordinary.mean() == pytest.approx(T[0] / sum(T), abs=BY_CHANCE)


def test_a_prism_of_calcite_deviates_its_two_rays_by_their_indices(variant_llvm_ad_spectral):
    # With the axis along its edge each has one index, and Snell's law holds twice
    apex, incidence = math.radians(60), math.radians(55)
    first, second = ((s * math.cos(apex / 2), 0.0, math.sin(apex / 2)) for s in (1, -1))
    prism = convex([[*first, 1.0], [*second, 1.0], [0, 0, -1, 1.0], [0, 1, 0, 5.0], [0, -1, 0, 5.0]])
    scene = scene_of(prism, material="calcite", c_axis=[0.0, 1.0, 0.0])
    normal = np.array(first)
    along = np.array([-normal[2], 0.0, normal[0]])  # up the face, to the edge
    direction = -math.cos(incidence) * normal + math.sin(incidence) * along
    _, _, out, left = walked(scene, 1 << 12, origin=normal - 2 * direction, direction=direction, segments=3)
    turned = np.arccos(np.clip(out[left] @ direction, -1, 1))
    for index in of_calcite():
        inner = math.asin(math.sin(incidence) / index)
        deviation = incidence + math.asin(index * math.sin(apex - inner)) - apex
        assert (np.abs(turned - deviation) < ANGLE).mean() > 0.2, index


def test_a_dichroic_plate_absorbs_each_mode_by_its_own_law(variant_llvm_ad_spectral, tmp_path):
    # Axis in the plate, light straight on: no mode becomes the other, and of each the slab's sum over all
    # reflections holds, R + (1 - R)^2 a / (1 - R a) with a = exp(-absorption)
    path = tmp_path / "polaroid.toml"
    path.write_text(
        "[index]\nformula = 'cauchy'\ncoefficients = [1.6]\nrange_nm = [380, 760]\n"
        "[index_e]\nformula = 'cauchy'\ncoefficients = [1.8]\nrange_nm = [380, 760]\n"
        "[absorption]\nwavelength_nm = [380, 760]\nper_mm = [0.1, 0.1]\n"
        "[absorption_e]\nwavelength_nm = [380, 760]\nper_mm = [2.0, 2.0]\n"
    )
    passes = Passes(scene_of(plate(), material=str(path), c_axis=[1.0, 0.0, 0.0]), seed=4)
    mean, error = passes.radiance_at(550.0, 256)
    expected = 0.0
    for index, absorption in ((1.6, 0.1), (1.8, 2.0)):
        R, a = float(reflectance(1.0, index)), math.exp(-absorption)
        expected += 0.5 * (R + (1 - R) ** 2 * a / (1 - R * a))
    off, of_mean = off_by(mean, error, expected)
    assert of_mean < 2e-3
    assert abs(off) <= THREE_SIGMA


def test_along_the_axis_there_is_one_image(variant_llvm_ad_spectral):
    begin, end, direction, left = walked(scene_of(plate(), material="calcite", c_axis=list(ALONG)), 1 << 12)
    assert left.all()
    np.testing.assert_allclose(end[:, 0], begin[:, 0], atol=OFF_AXIS)
    np.testing.assert_allclose(np.abs(direction[:, 2]), 1, atol=PLACE)


# ---- Polarising filters --------------------------------------------------------------------------------

CROSSED = {"analyser": [1.0, 0.0, 0.0], "polariser": [0.0, 1.0, 0.0]}


def seen(filters, nm=589.3, **surface):
    """Mean radiance of a plate under light of radiance 1, and its error."""
    mean, error = Passes(scene_of(plate(), filters=filters, **surface), seed=6).radiance_at(nm, 128)
    return float(np.mean(mean)), max(error_of_mean(error), SINGLE_SHARE)


def test_a_thick_plate_at_45_degrees_between_crossed_filters_passes_a_quarter(variant_llvm_ad_spectral):
    # Modes add as energies: of what the plate does not mirror at once, whichever way it leaves, each filter
    # takes half. What it mirrors stays polarised, and is stopped.
    mean, error = seen(CROSSED, material="calcite", c_axis=[1.0, 1.0, 0.0])
    mirrors = np.mean([float(reflectance(1.0, n)) for n in of_calcite()])
    assert abs(mean - 0.25 * (1 - mirrors)) <= THREE_SIGMA * error


@pytest.mark.parametrize("c_axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
def test_a_plate_along_the_filters_is_dark_between_crossed_ones(variant_llvm_ad_spectral, c_axis):
    mean, _ = seen(CROSSED, material="calcite", c_axis=list(c_axis))
    assert mean < SINGLE_SHARE


@pytest.mark.parametrize(("turn_deg", "share"), [(0, 0.5), (30, 0.375), (90, 0.0)])
def test_a_plate_of_one_index_leaves_light_polarised(variant_llvm_ad_spectral, turn_deg, share):
    # Malus's law, through glass and by it: it lets through and mirrors all that comes straight on
    turn = math.radians(turn_deg)
    filters = {"analyser": [1.0, 0.0, 0.0], "polariser": [math.cos(turn), math.sin(turn), 0.0]}
    mean, error = seen(filters, material="diamond")
    assert abs(mean - share) <= THREE_SIGMA * error


def test_a_filter_before_the_camera_alone_halves_light_from_all_around(variant_llvm_ad_spectral):
    for surface in ({"material": "diamond"}, {"material": "moissanite", "c_axis": list(ASKEW)}):
        scene = scene_of(STONES["inoue-3"], filters={"analyser": [1.0, 0.0, 0.0]}, **surface)
        off, of_mean = off_by(*Passes(scene, seed=7).radiance_at(550.0, 128), expected=0.5)
        assert of_mean < 1e-4
        assert abs(off) <= THREE_SIGMA


def test_between_crossed_and_along_filters_is_all_that_one_lets_through(variant_llvm_ad_spectral):
    # Filters at right angles before the lights share light from all around between them
    total = 0.0
    for polariser in ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]):
        filters = {"analyser": [0.6, 0.8, 0.0], "polariser": polariser}
        scene = scene_of(STONES["inoue-3"], filters=filters, material="moissanite", c_axis=list(ASKEW))
        mean, _ = Passes(scene, seed=8).radiance_at(550.0, 64)
        total += float(np.mean(mean))
    # Both are across the view; of light askew their directions are not quite at right angles
    assert total == pytest.approx(0.5, abs=0.01)


def test_each_window_of_a_dichroscope_shows_one_colour(variant_llvm_ad_spectral):
    # A filter along the axis passes the extraordinary ray alone, and one across it the ordinary one
    crystal = load_material("ruby").crystal
    absorptions = crystal.principal_absorption_per_mm(550.0)[[0, 2]]
    axes = ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
    for axis, index, absorption in zip(axes, crystal.principal_indices(550.0), absorptions, strict=True):
        mean, _ = seen({"analyser": axis}, 550.0, material="ruby", c_axis=[1.0, 0.0, 0.0])
        R, a = float(reflectance(1.0, index)), math.exp(-float(absorption))
        assert mean == pytest.approx(0.5 * (R + (1 - R) ** 2 * a / (1 - R * a)), rel=SLAB)


def test_two_windows_show_what_each_filter_does_by_itself(variant_llvm_ad_spectral):
    # Straight on, by one surface of each kind: no light is drawn by chance but the modes
    across = {"analyser": [1.0, 0.0, 0.0], "right_analyser": [0.0, 1.0, 0.0]}
    ruby = {"material": "ruby", "c_axis": [1.0, 0.0, 0.0]}
    both, _ = Passes(scene_of(plate(), filters=across, **ruby), seed=6).radiance_at(550.0, 64)
    assert both.shape == (32, 64)
    for window, axis in zip((both[:, :32], both[:, 32:]), ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]), strict=True):
        alone, _ = seen({"analyser": axis}, 550.0, **ruby)
        assert window.mean() == pytest.approx(alone, rel=SLAB)


def test_a_ground_girdle_loses_no_light_behind_a_filter(variant_llvm_ad_spectral):
    filters = {"analyser": [1.0, 0.0, 0.0]}
    scene = scene_of(load_stone("baguette-three"), half_width=0.3, filters=filters, girdle_alpha=0.4)
    off, of_mean = off_by(*Passes(scene, seed=9).radiance_at(550.0, 256), expected=0.5)
    assert of_mean < 1e-3
    assert abs(off) <= THREE_SIGMA

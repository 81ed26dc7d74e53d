"""Known physics through Mitsuba: its own `path` integrator on the same stone, closed forms, symmetry."""

from __future__ import annotations

import math

import mitsuba as mi
import numpy as np
import pytest
from physics_tolerances import (
    COORDINATE,
    FURNACE_DEFICIT,
    FURNACE_PIXELS,
    FURNACE_ROUNDING,
    ONE_DECIMAL,
    SAMPLING_512,
    SINGLE_INTENSITY,
    SINGLE_RADIANCE,
    SYMMETRIC_SHARE,
    Z,
)
from thorough import chosen

from gemrender import Model, RayStatus, View, load_stone
from gemrender import observe as observe_by
from gemrender.optics.fresnel import brewster_angle_deg, reflectance
from gemrender.scene import stone_scene
from gemrender.scene.generator import dielectric, film
from gemrender.scene.mesh import FACET_ATTRIBUTE, NORMAL_ATTRIBUTES, OFFSET_ATTRIBUTES
from gemrender.scoring import score_observation

SAMPLES = ["inoue-1", "inoue-2", "inoue-3"]
INDEX = 2.4173

#: Light of radiance 1 from everywhere (a plain number would be a multiple of daylight in spectral variants).
FURNACE = {"type": "constant", "radiance": {"type": "uniform", "value": 1.0}}

#: A path of so many segments is a trapped one (after a hundred, sample 2 still holds 0.2 % of the light).
#: Russian roulette, which would end paths at random and add noise, begins later than that: never.
MOST_SEGMENTS = 1000
PATH = {"type": "path", "max_depth": MOST_SEGMENTS, "rr_depth": MOST_SEGMENTS + 1}


def scene_of(stone, view, model=None, spp=1, **other):
    """Load the paper's scene of a stone, with some of its parts replaced."""
    scene = stone_scene(stone, view, model or Model(fresnel="exact", intensity="radiance")) | other
    if spp > 1:
        scene["sensor"]["sampler"] = {"type": "independent", "sample_count": spp}
    return mi.load_dict(scene)


def observe(stone, **options):
    return observe_by(stone, engine="mitsuba", **options)


def channels(scene):
    """Render; return the radiance (h, w), and a dictionary of the integrator's AOVs."""
    image = mi.render(scene).numpy()
    names = scene.integrator().aov_names()
    return image[..., 0], {name: image[..., -len(names) + i] for i, name in enumerate(names)}


# ---- A flat slab ---------------------------------------------------------------------------------------


def slab():
    """A slab of glass, 200 wide and 0.5 thick, over the plane z = 1, as `gem_primary` wants its stones."""
    to_world = mi.ScalarTransform4f().translate([0, 0, 1.25]).scale([100, 100, 0.25])
    shape = mi.load_dict({"type": "cube", "to_world": to_world, "bsdf": dielectric(INDEX)})
    params = mi.traverse(shape)
    corners = np.array(params["vertex_positions"]).reshape(-1, 3)[np.array(params["faces"]).reshape(-1, 3)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    offsets = (normals * corners[:, 0]).sum(axis=1)
    shape.add_attribute(FACET_ATTRIBUTE, 1, np.arange(12, dtype=np.float32))
    for names, values in ((NORMAL_ATTRIBUTES, normals), (OFFSET_ATTRIBUTES, offsets)):
        for name, part in zip(names, (values, np.zeros_like(values)), strict=True):
            shape.add_attribute(name, part[0].size, part.astype(np.float32).ravel())
    return shape


def looking_down(angle_deg, spp):
    return {
        "type": "gem_orthographic",
        "tilt": angle_deg,
        "film": film(1, 1),
        "sampler": {"type": "independent", "sample_count": spp},
    }


ANGLES = [0.0, 40.0, brewster_angle_deg(INDEX), 80.0]


@pytest.mark.parametrize("angle_deg", ANGLES)
def test_principal_ray_through_a_slab(variant_llvm_ad_mono, angle_deg):
    # Two parallel surfaces: T T, the beam's cross-section and direction are the same again, and the ray is
    # displaced by d sin(a - b) / cos(b).
    angle = math.radians(angle_deg)
    for intensity in ("primary", "radiance"):
        integrator = {"type": "gem_primary", "int_ior": INDEX, "fresnel": "exact", "intensity": intensity}
        radiance, aov = channels(
            mi.load_dict(
                {
                    "type": "scene",
                    "slab": slab(),
                    "light": FURNACE,
                    "sensor": looking_down(angle_deg, 1),
                    "integrator": integrator,
                }
            )
        )
        transmitted = (1 - reflectance(math.cos(angle), INDEX)) ** 2
        assert radiance[0, 0] == pytest.approx(transmitted, abs=SINGLE_RADIANCE)
        assert aov["primary.intensity"][0, 0] == pytest.approx(100 * transmitted, abs=SINGLE_INTENSITY)
        assert aov["status"][0, 0] == RayStatus.EXITED
        assert aov["reflections"][0, 0] == 0
        direction = [aov[f"exit.d{axis}"][0, 0] for axis in "xyz"]
        np.testing.assert_allclose(
            direction, [-math.sin(angle), 0, -math.cos(angle)], rtol=0, atol=COORDINATE
        )
        in_slab = math.asin(math.sin(angle) / INDEX)
        displaced = 0.5 * math.sin(angle - in_slab) / math.cos(in_slab)
        # Along the map's right (cos, 0, -sin); the ray itself goes through the map's middle.
        across = math.cos(angle) * aov["exit.x"][0, 0] - math.sin(angle) * aov["exit.z"][0, 0]
        assert across == pytest.approx(displaced, abs=10 * COORDINATE)


@pytest.mark.parametrize("angle_deg", ANGLES)
def test_reflectance_and_transmittance_of_a_slab(variant_llvm_ad_mono, angle_deg):
    # All orders of reflection between the two surfaces: R + T^2 R / (1 - R^2) = 2 R / (1 + R) from above,
    # where the hemisphere shines, and (1 - R)^2 / (1 - R^2) through the slab, from below. Each sample is 0
    # or 1: the mean of n is binomial.
    n = 1 << 16
    R = float(reflectance(math.cos(math.radians(angle_deg)), INDEX))
    from_above = looking_down(angle_deg, n)
    eye = np.array([math.sin(math.radians(angle_deg)), 0.0, -math.cos(math.radians(angle_deg))])
    from_below = {
        "type": "orthographic",
        "to_world": mi.ScalarTransform4f().look_at(origin=list(20 * eye), target=[0, 0, 0], up=[0, 1, 0]),
        "film": film(1, 1),
        "sampler": {"type": "independent", "sample_count": n},
    }
    for sensor, expected in (
        (from_above, 2 * R / (1 + R)),
        (from_below, (1 - R) ** 2 / (1 - R**2)),
    ):
        scene = {"type": "scene", "slab": slab(), "light": {"type": "gem_hemisphere"}, "sensor": sensor}
        measured = float(mi.render(mi.load_dict(scene | {"integrator": PATH}), seed=1).numpy()[0, 0, 0])
        assert abs(measured - expected) <= Z * math.sqrt(expected * (1 - expected) / n)


#: A view whose rows of pixels lie in none of the stone's planes of symmetry. There rays meet edges exactly,
#: and `path`, which takes the ray tracer's word, lets them out, or in, unrefracted.
BESIDE_EDGES = {"tilt_deg": 3.0, "tilt_azimuth_deg": 17.0}

# ---- White furnace -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", chosen(SAMPLES, SAMPLES[:1]))
def test_white_furnace(variant_llvm_ad_mono, name):
    # In light of radiance 1 from everywhere a stone that neither absorbs nor leaks cannot be seen: each path
    # ends in the light with a throughput of 1 (the factors n^2 in and out cancel), whichever way it was
    # split. So there is no noise, and nothing is missing but trapped paths and those that `path`, which
    # starts each segment 2e-4 off the surface, lets out through an edge unrefracted: with 1 / n^2 = 0.17.
    stone = load_stone(name)
    view = View.of(stone, 48, **BESIDE_EDGES)
    image = mi.render(scene_of(stone, view, spp=128, integrator=PATH, light=FURNACE), seed=1)
    radiance = image.numpy()[..., 0].astype(np.float64)
    assert radiance.max() <= 1 + FURNACE_ROUNDING
    assert (radiance < 1 - FURNACE_ROUNDING).mean() <= FURNACE_PIXELS
    assert 1 - radiance.mean() <= FURNACE_DEFICIT


@pytest.mark.parametrize("name", chosen(SAMPLES, SAMPLES[1:2]))
def test_principal_radiance_in_a_furnace_is_t_t(variant_llvm_ad_mono, name):
    # What gem_primary leaves out is what the furnace shows to be there: its radiance is T T < 1.
    stone = load_stone(name)
    radiance, aov = channels(scene_of(stone, View.of(stone, 64), light=FURNACE))
    lit = (aov["status"] == RayStatus.EXITED) & (aov["rear.mask"] == 0)
    np.testing.assert_allclose(
        100 * radiance[lit], aov["primary.intensity"][lit], rtol=0, atol=SINGLE_INTENSITY
    )
    most = (1 - float(reflectance(1.0, INDEX))) ** 2
    assert radiance.max() <= most + SINGLE_RADIANCE  # R is smallest at normal incidence
    assert (radiance[aov["status"] == RayStatus.MISSED] == 0).all()


# ---- The principal ray among all rays ------------------------------------------------------------------


def one_pixel(view, row, column):
    """The view's sensor, of which only one pixel is left."""
    x, y = view.cell_centres()
    half = view.half_width / view.resolution
    return {
        "type": "gem_orthographic",
        "x_min": x[column] - half, "x_max": x[column] + half,
        "y_min": y[row] - half, "y_max": y[row] + half,
        "film": film(1, 1),
    }  # fmt: skip


@pytest.mark.parametrize("name", chosen(SAMPLES, SAMPLES[2:]))
def test_all_rays_find_a_small_light_where_the_principal_ray_ends(variant_llvm_ad_mono, name, rng):
    # A small light, of radiance 1, far away where the principal ray comes from. Of all the rays that `path`
    # follows from that pixel, splitting them by Fresnel's equations, only the principal one meets it: the
    # share is binomial about T T.
    stone, n = load_stone(name), 1 << 15
    view = View.of(stone, 64)
    radiance, aov = channels(scene_of(stone, view, light=FURNACE))
    exited = (aov["status"] == RayStatus.EXITED) & (aov["reflections"] <= 3)
    places = np.argwhere(exited)
    for row, column in places[rng.choice(len(places), size=5, replace=False)]:
        point, direction = (
            np.array([aov[f"exit.{axis}"][row, column] for axis in axes], dtype=float)
            for axes in (("x", "y", "z"), ("dx", "dy", "dz"))
        )
        place = (point + 20 * direction).tolist()
        light = {
            "type": "disk",
            "to_world": mi.ScalarTransform4f()
            .look_at(origin=place, target=point.tolist(), up=np.roll(direction, 1).tolist())
            .scale(0.01),
            "emitter": {"type": "area", "radiance": {"type": "uniform", "value": 1.0}},
        }
        sensor = one_pixel(view, row, column) | {"sampler": {"type": "independent", "sample_count": n}}
        scene = scene_of(stone, view, integrator=PATH, sensor=sensor, light=light)
        measured = float(mi.render(scene, seed=1).numpy()[0, 0, 0])
        expected = float(radiance[row, column])
        assert abs(measured - expected) <= Z * math.sqrt(expected * (1 - expected) / n)


@pytest.mark.parametrize("name", chosen(SAMPLES, SAMPLES[:1]))
def test_principal_radiance_is_part_of_the_full_radiance(variant_llvm_ad_mono, name):
    # Per block of 8 x 8 pixels: the full radiance holds the principal ray's, and besides at most what all
    # other rays together can carry, 1 - T T. Each sample of `path` is 0 or 1 (or, trapped, 0).
    stone, size, spp = load_stone(name), 64, 64
    view = View.of(stone, size, **BESIDE_EDGES)
    principal, _ = channels(scene_of(stone, view))
    carried, aov = channels(scene_of(stone, view, light=FURNACE))
    covered = aov["coverage"] > 0
    full = mi.render(scene_of(stone, view, integrator=PATH, spp=spp), seed=1).numpy()[..., 0]

    def blocks(image):
        image = np.where(covered, image, 0.0)
        return image.reshape(size // 8, 8, size // 8, 8).sum(axis=(1, 3))

    n = blocks(np.ones_like(full))
    met = n > 32
    others = (blocks(full) - blocks(principal))[met] / n[met]
    most = 1 - blocks(carried)[met] / n[met]
    mean = (blocks(full) / np.maximum(n, 1))[met]
    error = Z * np.sqrt(mean * (1 - mean) / (n[met] * spp))
    assert met.sum() > 30
    assert (others >= -error).all()
    assert (others <= most + error).all()


def test_hemisphere_shows_rear_light_by_direction(variant_llvm_ad_mono):
    # Where the two rules for rear light differ, `path` under the hemisphere goes by the direction: a pixel
    # whose principal ray ends in the light has at least T T, one whose ray ends in the dark at most 1 - T T.
    stone, spp = load_stone("inoue-1"), 64
    view = View.of(stone, 64)
    carried, position = channels(
        scene_of(stone, view, Model(fresnel="exact", rear="position"), light=FURNACE)
    )
    seen, direction = channels(scene_of(stone, view, Model(fresnel="exact", rear="direction")))
    full = mi.render(scene_of(stone, view, integrator=PATH, spp=spp), seed=1).numpy()[..., 0]
    exited = direction["status"] == RayStatus.EXITED
    rear_by_position, rear_by_direction = position["rear.mask"] > 0, direction["rear.mask"] > 0

    # gem_primary's own colour: dark exactly where the light comes from below.
    np.testing.assert_array_equal(seen[exited] == 0, rear_by_direction[exited])

    from_above = exited & rear_by_position & ~rear_by_direction
    assert from_above.sum() > 100
    error = Z * math.sqrt(0.25 / (spp * from_above.sum()))
    assert full[from_above].mean() >= carried[from_above].mean() - error
    assert full[from_above].mean() > 1 - carried[from_above].mean() + error  # not rear light
    from_below = exited & rear_by_direction
    error = Z * math.sqrt(0.25 / (spp * from_below.sum()))
    assert full[from_below].mean() <= 1 - carried[from_below].mean() + error
    assert full[from_below].mean() < carried[from_below].mean() - error  # not lit


# ---- Symmetry ------------------------------------------------------------------------------------------


def differing(a, b):
    """Share of a stone's pixels in which two intensity maps differ."""
    met = (a > 0) | (b > 0)
    return float((np.abs(a - b) > SINGLE_INTENSITY)[met].mean())


@pytest.mark.parametrize("name", chosen(SAMPLES, SAMPLES[1:2]))
def test_image_has_the_symmetry_of_the_stone(variant_llvm_ad_mono, name):
    stone = load_stone(name)
    seen = observe(stone, resolution=128).primary_intensity
    for other in (np.rot90(seen), seen[::-1], seen[:, ::-1], seen.T):
        assert differing(seen, other) <= SYMMETRIC_SHARE
    # Eightfold: turned by 45 deg it is the same image; by 22.5 deg another one, the same to both sides.
    assert differing(seen, observe(stone.rotated(45), resolution=128).primary_intensity) <= SYMMETRIC_SHARE
    left, right = (observe(stone.rotated(a), resolution=128).primary_intensity for a in (-22.5, 22.5))
    assert differing(left, right) <= SYMMETRIC_SHARE
    assert differing(left, seen) > 0.5


@pytest.mark.parametrize("name", chosen(SAMPLES, SAMPLES[2:]))
def test_turning_the_stone_changes_its_scores_by_sampling_only(variant_llvm_ad_mono, name):
    stone = load_stone(name)
    still, turned = (score_observation(observe(s, resolution=512)) for s in (stone, stone.rotated(17.3)))
    assert turned.average == pytest.approx(still.average, abs=SAMPLING_512)
    assert turned.rear == pytest.approx(still.rear, abs=SAMPLING_512)
    eighth = score_observation(observe(stone.rotated(-45), resolution=512))
    assert eighth.average == pytest.approx(still.average, abs=SYMMETRIC_SHARE * 100)
    assert eighth.rear == pytest.approx(still.rear, abs=SYMMETRIC_SHARE * 100)


@pytest.mark.parametrize(
    ("name", "by_position", "by_direction"),  # docs/model.md, sections 4 and 6
    chosen([("inoue-1", 19.2, 8.0), ("inoue-2", 14.5, 8.4), ("inoue-3", 5.1, 5.1)], [("inoue-1", 19.2, 8.0)]),
)
def test_rear_by_position_and_by_direction(variant_llvm_ad_mono, name, by_position, by_direction):
    for rear, printed in (("position", by_position), ("direction", by_direction)):
        result = score_observation(observe(load_stone(name), resolution=512, rear=rear))
        assert result.rear == pytest.approx(printed, abs=ONE_DECIMAL + SAMPLING_512)

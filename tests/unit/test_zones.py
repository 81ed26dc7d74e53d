"""The emitter ``gem_zones``: radiance by the elevation above a viewer's horizon."""

from __future__ import annotations

import math

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

# Single precision: a few roundings.
SINGLE = 1e-6
# Significance of the chi-square test: by chance one seed in 10,000 would fail.
SIGNIFICANCE = 1e-4
# Means of random samples may lie this many standard errors off: by chance one test in 16,000 would fail.
STANDARD_ERRORS = 4

AXIS = np.array([2.0, -1.0, 0.5]) / math.sqrt(5.25)
#: Black in the middle; numbers are flat spectra.
ZONES = {"edges": "-30, 0, 45, 75", "radiance_1": 3.0, "radiance_2": 0.0, "radiance_3": 0.5}


def emitter(**properties):
    return mi.load_dict({"type": "gem_zones", **properties})


def tilted(**properties):
    return emitter(axis=[4.0, -2.0, 1.0], **properties)  # no unit vector, on purpose


def directions(rng, n=2000):
    d = rng.normal(size=(n, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


def interaction():
    si = dr.zeros(mi.SurfaceInteraction3f)
    if mi.is_spectral:
        si.wavelengths = mi.UnpolarizedSpectrum([400, 500, 600, 700])
    return si


def radiances(light, d):
    """Return what is found in directions (n, 3), of the first channel."""
    si = interaction()
    si.wi = -mi.Vector3f(d.T)
    found = light.eval(si)
    assert dr.all(found == found[0], axis=None)  # flat
    return np.array(found[0])


def test01_radiance_goes_by_the_elevation_above_the_axis_horizon(variants_all, rng):
    d = directions(rng)
    elevation = np.degrees(np.arcsin(d @ AXIS))
    expected = np.select([elevation < -30, elevation < 0, elevation < 45, elevation < 75], [0, 3, 0, 0.5], 0)
    np.testing.assert_array_equal(radiances(tilted(**ZONES), d), expected)


def test02_the_poles_belong_to_the_outermost_zones(variant_llvm_ad_mono):
    poles = np.array([AXIS, -AXIS, 1.0000003 * AXIS, -1.0000003 * AXIS])  # as long as rounding makes them
    light = tilted(edges="-90, 0, 90", radiance_1=2.0, radiance_2=5.0)
    np.testing.assert_array_equal(radiances(light, poles), [5, 2, 5, 2])


def test03_by_default_it_is_the_hemisphere(variants_all, rng):
    d = directions(rng)
    hemisphere = mi.load_dict({"type": "gem_hemisphere"})
    np.testing.assert_array_equal(radiances(emitter(), d), radiances(hemisphere, d))


def test04_directions_are_spread_evenly_over_what_is_lit(variant_llvm_ad_mono, rng):
    from scipy import stats

    light, n = tilted(**ZONES), 100_000
    ds, _ = light.sample_direction(interaction(), mi.Point2f(rng.random((2, n))))
    d = np.array(ds.d).T
    low, high = (math.sin(math.radians(edge)) for edge in (-30, 75))
    np.testing.assert_allclose(np.array(ds.pdf), 1 / (2 * math.pi * (high - low)), rtol=SINGLE)
    across = np.linalg.svd(AXIS[None])[2][1:]
    around = np.arctan2(*(across @ d.T))
    limits = [np.linspace(low, high, 13), np.linspace(-math.pi, math.pi, 9)]
    counts = np.histogram2d(d @ AXIS, around, bins=limits)[0].ravel()
    assert stats.chisquare(counts, np.full(len(counts), counts.mean())).pvalue > SIGNIFICANCE
    assert counts.sum() > 0.9999 * n  # but for rounding at the limits


def test05_sampled_direction_agrees_with_evaluation(variants_all, rng):
    light, si = tilted(**ZONES), interaction()
    si.p = mi.Point3f(1, 2, 3)
    ds, weight = light.sample_direction(si, mi.Point2f(rng.random((2, 1000))))
    assert dr.allclose(ds.pdf, light.pdf_direction(si, ds))
    assert dr.allclose(weight, light.eval_direction(si, ds) / ds.pdf)
    si.wi = -ds.d
    assert dr.allclose(weight, light.eval(si) / ds.pdf)


def test06_a_plane_across_the_axis_gets_the_zones_irradiance(variants_all):
    # Of a zone of radiance 1 it is pi (sin^2 high - sin^2 low) (Lambert), of which white reflects 1/pi.
    plane = {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().look_at([0, 0, 0], AXIS.tolist(), [0, 0, 1]),
        "bsdf": {"type": "diffuse", "reflectance": 1.0},
    }
    light = {"type": "gem_zones", "axis": AXIS.tolist(), "edges": "20, 50", "radiance_1": 2.0}
    sensor = {
        "type": "orthographic",
        "to_world": mi.ScalarTransform4f()
        .look_at((3 * AXIS).tolist(), [0, 0, 0], [0, 0, 1])
        .scale([0.5, 0.5, 1]),
        "film": {
            "type": "hdrfilm",
            "width": 32,
            "height": 32,
            "pixel_format": "luminance",
            "rfilter": {"type": "box"},
        },
    }
    scene = {"type": "scene", "plane": plane, "light": light, "sensor": sensor}
    image = mi.render(mi.load_dict({**scene, "integrator": {"type": "path"}}), spp=64, seed=1).numpy()
    expected = 2 * (math.sin(math.radians(50)) ** 2 - math.sin(math.radians(20)) ** 2)
    white = 106.857 / 106.750 if mi.is_spectral else 1  # what a film makes of 1, see test_hemisphere
    assert abs(image.mean() - white * expected) < STANDARD_ERRORS * image.std() / 32


def test07_emitted_rays_fill_the_scene_evenly(variants_all, rng):
    # A ball inside the radius is hit by the share (ball radius / radius)^2 of the rays from every direction.
    n, ratio = 50_000, 0.6
    ray, weight = tilted(**ZONES, radius=10).sample_ray(
        0.0, mi.Float(rng.random(n)), mi.Point2f(rng.random((2, n))), mi.Point2f(rng.random((2, n)))
    )
    ball = mi.load_dict({"type": "scene", "ball": {"type": "sphere", "radius": 10 * ratio}})
    hit = ball.ray_test(ray).numpy().astype(float)
    assert abs(hit.mean() - ratio**2) < STANDARD_ERRORS * hit.std() / math.sqrt(n)
    # What all rays carry: radiance times solid angle of each zone, times disc and range of wavelengths
    zones = 2 * math.pi * (3.0 * 0.5 + 0.5 * (math.sin(math.radians(75)) - math.sin(math.radians(45))))
    power = zones * math.pi * 10**2 * ((830 - 360) if mi.is_spectral else 1)
    carried = np.array(weight[0])
    assert abs(carried.mean() - power) < STANDARD_ERRORS * carried.std() / math.sqrt(n)


def test08_radiances_can_be_changed(variant_llvm_ad_mono):
    light = tilted(**ZONES)
    params = mi.traverse(light)
    params["radiance_1.value"] = 7.0
    params.update()
    across = np.linalg.svd(AXIS[None])[2][1]
    np.testing.assert_array_equal(radiances(light, (across - 0.1 * AXIS)[None]), [7.0])


_EDGES = "must be 2 to 33 increasing numbers from -90 to 90"
BAD = [
    ({"edges": "0"}, f"edges = '0': {_EDGES}"),
    ({"edges": "0, x"}, f"edges = '0, x': {_EDGES}"),
    ({"edges": "45, 0"}, f"edges = '45, 0': {_EDGES}"),
    ({"edges": "0, 45, 45"}, f"edges = '0, 45, 45': {_EDGES}"),
    ({"edges": "-91, 0"}, f"edges = '-91, 0': {_EDGES}"),
    ({"edges": "0, nan"}, f"edges = '0, nan': {_EDGES}"),
    ({"edges": 45.0}, f"edges = 45.0: {_EDGES}"),
    ({"axis": [0, 0, 0]}, r"axis = \[0.0, 0.0, 0.0\]: must be a direction"),
    ({"radiance_1": -1}, "radiance_1 = -1: must be a finite number of at least 0"),
    ({"radiance_1": {"type": "checkerboard"}}, "radiance_1: must be the same in all directions"),
    ({"radius": 0}, "radius = 0: must be a finite number above 0"),
    ({"to_world": "identity"}, "to_world: not allowed here, axis says where the zenith is"),
    ({"radiance_2": 1}, 'unreferenced property.*"radiance_2"'),
]


@pytest.mark.parametrize(("properties", "message"), BAD, ids=[message[:18] for _, message in BAD])
def test09_bad_value_is_refused_in_one_line(variant_llvm_ad_mono, properties, message):
    if "to_world" in properties:
        properties = {"to_world": mi.ScalarTransform4f()}
    with pytest.raises(RuntimeError, match=f"(?s){message}"):
        emitter(**properties)

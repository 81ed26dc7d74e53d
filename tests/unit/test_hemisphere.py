"""The emitter ``gem_hemisphere``: uniform radiance above the horizon, none below."""

from __future__ import annotations

import math

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

# Single precision: a few roundings.
SINGLE = 1e-6
# Significance of the chi-square tests. The seed is fixed, so a pass stays a pass.
SIGNIFICANCE = 0.01
# Means of random samples may lie this many standard errors off: by chance one test in 16,000 would fail.
STANDARD_ERRORS = 4

DIAMOND = 2.4173  # index at 589.3 nm, the paper's

# What a film makes of a flat spectrum of 1 in a spectral variant: Mitsuba's table of the CIE 1931 observer
# integrates to 106.857, as it should (Pharr, Jakob and Humphreys, Physically Based Rendering, section 4.6.1),
# and is divided by 106.750 (MI_CIE_Y_NORMALIZATION in mitsuba/core/spectrum.h).
FLAT_LUMINANCE = 106.856895 / 106.7502593994140625


def emitter(**properties):
    return mi.load_dict({"type": "gem_hemisphere", **properties})


def directions(rng, n=1000):
    """Return (3, n) directions all over the sphere, and the horizon itself among them."""
    d = rng.normal(size=(3, n))
    d[2, :10] = 0
    return mi.Vector3f(d / np.linalg.norm(d, axis=0))


def interaction(n=1):
    si = dr.zeros(mi.SurfaceInteraction3f, n)
    if mi.is_spectral:
        si.wavelengths = mi.UnpolarizedSpectrum([400, 500, 600, 700])
    return si


def lit_scene(shape, light=None, **sensor):
    return mi.load_dict(
        {
            "type": "scene",
            "light": light or {"type": "gem_hemisphere"},
            "shape": shape,
            "sensor": {
                "type": "gem_orthographic",
                "film": {
                    "type": "hdrfilm",
                    "width": 32,
                    "height": 32,
                    "pixel_format": "luminance",
                    "component_format": "float32",
                    "rfilter": {"type": "box"},
                },
                **sensor,
            },
            "integrator": {"type": "path", "max_depth": 24, "rr_depth": 1000},
        }
    )


def white():
    """Return the luminance of radiance 1 on the film of the active variant."""
    return FLAT_LUMINANCE if mi.is_spectral else 1


def assert_mean(values, expected):
    """The mean of independent random values is the expected one, as far as chance allows."""
    error = np.std(values) / math.sqrt(np.size(values))
    assert abs(np.mean(values) - expected) < STANDARD_ERRORS * error


# ---- Evaluation and sampling ---------------------------------------------------------------------------


def test01_is_an_environment(variants_all):
    light = emitter()
    assert light.is_environment()
    assert not light.bbox().valid()


def test02_radiance_is_uniform_above_and_zero_from_the_horizon_down(variants_all, rng):
    d = directions(rng)
    si = interaction()
    si.wi = -d
    radiance = emitter(radiance=2.5).eval(si)
    assert dr.all(radiance == dr.select(d.z > 0, 2.5, 0), axis=None)


def test03_density_is_uniform_above_and_zero_from_the_horizon_down(variant_llvm_ad_mono, rng):
    ds = dr.zeros(mi.DirectionSample3f)
    ds.d = directions(rng)
    pdf = emitter().pdf_direction(interaction(), ds)
    assert dr.allclose(pdf, dr.select(ds.d.z > 0, 1 / (2 * math.pi), 0), rtol=SINGLE, atol=0)


@pytest.mark.parametrize("radiance", [1.0, {"type": "d65", "scale": 3.0}], ids=["flat", "d65"])
def test04_directions_follow_the_density(variant_llvm_ad_spectral, radiance):
    light = {"type": "gem_hemisphere", "radiance": radiance}
    sample, pdf = mi.chi2.EmitterAdapter("gem_hemisphere", light)
    chi2 = mi.chi2.ChiSquareTest(
        domain=mi.chi2.SphericalDomain(), sample_func=sample, pdf_func=pdf, sample_dim=2
    )
    assert chi2.run(significance_level=SIGNIFICANCE, quiet=True), chi2.messages


def test05_sampled_direction_agrees_with_evaluation(variants_all, rng):
    light = emitter(radiance=2.5, radius=20)
    si = interaction()
    si.p = mi.Point3f(1, 2, 3)
    ds, weight = light.sample_direction(si, mi.Point2f(rng.random((2, 1000))))
    assert dr.all(ds.d.z > 0)
    assert dr.allclose(ds.pdf, light.pdf_direction(si, ds))
    assert dr.allclose(weight, light.eval_direction(si, ds) / ds.pdf)
    si.wi = -ds.d
    assert dr.allclose(weight, light.eval(si) / ds.pdf)
    assert dr.allclose(ds.p, si.p + ds.d * ds.dist)
    assert dr.allclose(ds.dist, 2 * 20)
    assert dr.all(ds.emitter == mi.EmitterPtr(light))


def test06_no_weight_is_ever_infinite_or_undefined(variant_llvm_ad_mono):
    # The corners and edges of the square land on the rim of the hemisphere, where nothing is emitted.
    edge = np.linspace(0, 1, 65)
    u, v = (axis.ravel() for axis in np.meshgrid(edge, edge))
    ds, weight = emitter().sample_direction(interaction(), mi.Point2f(u, v))
    assert dr.all(dr.isfinite(weight), axis=None)
    assert dr.all((weight.x > 0) == (ds.d.z > 0))


def test07_reference_point_outside_the_radius_still_sees_the_light_far_away(variant_llvm_ad_mono):
    si = interaction()
    si.p = mi.Point3f(0, 0, 50)
    ds, _ = emitter(radius=20).sample_direction(si, mi.Point2f(0.3, 0.6))
    assert dr.allclose(ds.dist, 2 * 50)


def test08_emitted_rays_fill_the_scene_evenly(variants_all, rng):
    # A ball inside the radius is hit by the share (ball radius / radius)^2 of the rays from every direction.
    n, ratio = 100_000, 0.6
    light = emitter(radiance=2.5, radius=10)
    ray, weight = light.sample_ray(
        0.0, mi.Float(rng.random(n)), mi.Point2f(rng.random((2, n))), mi.Point2f(rng.random((2, n)))
    )
    ball = mi.load_dict({"type": "scene", "ball": {"type": "sphere", "radius": 10 * ratio}})
    assert dr.all(ray.d.z < 0)
    assert_mean(ball.ray_test(ray).numpy().astype(float), ratio**2)
    # What all rays carry: radiance times the solid angle times the disc, times the range of wavelengths.
    power = 2.5 * 2 * math.pi * math.pi * 10**2 * ((830 - 360) if mi.is_spectral else 1)
    assert dr.allclose(weight, power, rtol=SINGLE, atol=0)


# ---- The spectrum --------------------------------------------------------------------------------------


def test09_number_is_a_flat_spectrum(variant_llvm_ad_spectral):
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = mi.Vector3f(0, 0, -1)
    si.wavelengths = mi.UnpolarizedSpectrum(dr.linspace(mi.Float, 361, 829, 50), 450.0, 550.0, 650.0)
    assert dr.all(emitter().eval(si) == 1, axis=None)
    assert dr.all(emitter(radiance=1).eval(si) == 1, axis=None)


def test10_spectrum_and_color_are_read_as_emission(variant_llvm_ad_spectral):
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = mi.Vector3f(0, 0, -1)
    si.wavelengths = mi.UnpolarizedSpectrum(400, 500, 600, 700)
    d65 = mi.load_dict({"type": "d65"}).eval(si)
    assert dr.all(emitter(radiance={"type": "d65"}).eval(si) == d65, axis=None)
    # The upsampled white of Mitsuba is flat to better than a thousandth.
    assert dr.allclose(emitter(radiance={"type": "rgb", "value": 1.0}).eval(si), d65, rtol=1e-3)


# ---- Light transport by Mitsuba's own path integrator --------------------------------------------------


@pytest.mark.parametrize("albedo", [1.0, 0.4])
def test11_horizontal_plane_reflects_its_albedo(variants_all, albedo):
    plane = {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": albedo}}
    image = mi.render(lit_scene(plane), spp=1024, seed=1).numpy()
    assert_mean(image, albedo * white())


def test12_vertical_plane_gets_half_the_light(variant_llvm_ad_mono):
    # Seen from a tilt of 45 degrees; a quarter of the sphere is above the horizon and before the plane.
    wall = {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], 90),
        "bsdf": {"type": "diffuse", "reflectance": 1.0},
    }
    view = {"tilt": 45, "x_min": -0.5, "x_max": 0.5, "y_min": -0.5, "y_max": 0.5}
    image = mi.render(lit_scene(wall, **view), spp=64, seed=1).numpy()
    assert_mean(image, 0.5)


def test13_eye_looking_down_past_the_scene_sees_black(variant_llvm_ad_mono):
    ball = {"type": "sphere", "radius": 0.1}
    image = mi.render(lit_scene(ball, x_min=0.5), spp=4).numpy()
    assert np.all(image == 0)


def test14_middle_of_a_glass_ball_returns_what_its_two_sides_reflect(variants_all):
    # Along the axis a ball is a slab. Light that goes back up was reflected 1, 3, 5, ... times: in all it is
    # R + (1 - R)^2 (R + R^3 + ...) = 2 R / (1 + R), and what passes through ends in the dark.
    ball = {"type": "sphere", "bsdf": {"type": "dielectric", "int_ior": DIAMOND, "ext_ior": 1.0}}
    middle = {"x_min": -0.001, "x_max": 0.001, "y_min": -0.001, "y_max": 0.001}
    image = mi.render(lit_scene(ball, **middle), spp=1024, seed=1).numpy()
    reflectance = ((DIAMOND - 1) / (DIAMOND + 1)) ** 2
    assert_mean(image, 2 * reflectance / (1 + reflectance) * white())


def test15_glass_ball_loses_and_gains_nothing(variant_llvm_ad_mono):
    # Light from all around comes back as it is: a ball of any index is invisible under `constant`. Of that
    # the upper hemisphere gives a part, for every pixel.
    ball = {"type": "sphere", "bsdf": {"type": "dielectric", "int_ior": DIAMOND, "ext_ior": 1.0}}
    around = mi.render(lit_scene(ball, light={"type": "constant"}), spp=256, seed=1).numpy()
    above = mi.render(lit_scene(ball), spp=256, seed=1).numpy()
    np.testing.assert_allclose(around, 1, rtol=0, atol=SINGLE)
    assert np.all((above >= 0) & (above <= 1))
    assert 0.2 < np.mean(above) < 0.8


# ---- Parameters ----------------------------------------------------------------------------------------


def test16_reflected_light_is_differentiable_by_the_radiance(variant_llvm_ad_mono):
    plane = {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": 0.4}}
    scene = lit_scene(plane)
    params = mi.traverse(scene)
    key = "light.radiance.value"
    params.keep(key)
    dr.enable_grad(params[key])
    params.update()
    image = mi.render(scene, params, integrator=mi.load_dict({"type": "prb", "max_depth": 2}), spp=64)
    mean = dr.mean(image, axis=None)
    dr.backward(mean)
    # The light is linear in the radiance, which is 1: the derivative is the light itself.
    assert dr.allclose(dr.grad(params[key]), mean.array, rtol=1e-4)


def test17_new_radiance_and_radius_compile_no_new_kernel(variant_llvm_ad_mono):
    scene = lit_scene({"type": "rectangle"})
    params = mi.traverse(scene)

    def compiled():
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            dr.eval(mi.render(scene, spp=4))
            kernels = [k for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT]
        assert kernels
        return sum(not k["cache_hit"] or bool(k["cache_disk"]) for k in kernels)

    compiled()
    compiled()
    params["light.radiance.value"] = 0.25
    params["light.radius"] = 7.0
    params.update()
    assert compiled() == 0


BAD = [
    ({"radiance": -1}, "radiance = -1: must be a finite number of at least 0"),
    ({"radiance": True}, "radiance = True: must be a finite number of at least 0"),
    ({"radiance": {"type": "checkerboard"}}, "radiance: must be the same in all directions"),
    ({"radius": 0}, "radius = 0: must be a finite number above 0"),
    ({"radius": "far"}, "radius = 'far': must be a finite number above 0"),
    ({"to_world": "identity"}, "to_world: not allowed here"),
    ({"up": 2}, 'unreferenced property.*"up"'),
]


@pytest.mark.parametrize(("properties", "message"), BAD, ids=[message[:14] for _, message in BAD])
def test18_bad_value_is_refused_in_one_line(variant_llvm_ad_mono, properties, message):
    if "to_world" in properties:
        properties = {"to_world": mi.ScalarTransform4f()}
    with pytest.raises(RuntimeError, match=f"(?s){message}"):
        emitter(**properties)

"""The sensor ``gem_orthographic``: which ray belongs to which pixel, and what may change for free."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

# A coordinate of about 1 comes out of two roundings to single precision (the cell's size, the product).
COORDINATE = 2 * 2.0**-24
# Tilted, or 10 away from the origin, sums of three such terms of up to 10 are rounded once more each.
FAR_COORDINATE = 4 * 10 * 2.0**-24

WINDOW = {"x_min": -1.25, "x_max": 0.75, "y_min": -0.5, "y_max": 1.0}


def film(width=8, height=6, **more):
    return {
        "type": "hdrfilm",
        "width": width,
        "height": height,
        "pixel_format": "luminance",
        "component_format": "float32",
        "rfilter": {"type": "box"},
        **more,
    }


def sensor(**properties):
    return mi.load_dict({"type": "gem_orthographic", "film": film(), **properties})


def rays(sensor, u, v):
    """Return origins (n, 3) and directions (n, 3) of the rays through (u, v) of the film, 0 to 1 each."""
    ray, _ = sensor.sample_ray(0.0, 0.0, mi.Point2f(np.ravel(u), np.ravel(v)), mi.Point2f(0.5))
    return np.array(ray.o).T, np.broadcast_to(np.array(ray.d).T, np.array(ray.o).T.shape)


def cells(x_min, x_max, y_min, y_max, width=8, height=6):
    """Return column, row, x and y of the cells' centres, (height, width) each, by the manual's formula."""
    row, column = np.mgrid[0:height, 0:width]
    x = x_min + (column + 0.5) * (x_max - x_min) / width
    y = y_max - (row + 0.5) * (y_max - y_min) / height
    return column, row, x, y


# ---- Pixels and cells ----------------------------------------------------------------------------------


def test01_ray_goes_through_the_centre_of_its_cell(variant_llvm_ad_mono, rng):
    column, row, x, y = cells(**WINDOW)
    u = (column + rng.uniform(0.01, 0.99, column.shape)) / 8
    v = (row + rng.uniform(0.01, 0.99, row.shape)) / 6
    origin, direction = rays(sensor(**WINDOW), u, v)
    np.testing.assert_allclose(origin[:, 0], x.ravel(), rtol=0, atol=COORDINATE)
    np.testing.assert_allclose(origin[:, 1], y.ravel(), rtol=0, atol=COORDINATE)
    np.testing.assert_array_equal(origin[:, 2], 10)
    np.testing.assert_array_equal(direction, np.broadcast_to([0, 0, -1], direction.shape))


def test02_symmetric_window_has_exactly_symmetric_cells(variant_llvm_ad_mono):
    column = np.arange(101)
    centres = sensor(film=film(101, 101), x_min=-1.1, x_max=1.1)
    x = rays(centres, (column + 0.5) / 101, np.full(101, 0.5))[0][:, 0]
    np.testing.assert_array_equal(x, -x[::-1])
    assert x[50] == 0


def test03_sampling_area_takes_the_place_that_the_sampler_gives(variant_llvm_ad_mono, rng):
    u, v = rng.random((2, 100))
    origin, _ = rays(sensor(**WINDOW, sampling="area"), u, v)
    np.testing.assert_allclose(origin[:, 0], -1.25 + 2 * u, rtol=0, atol=COORDINATE)
    np.testing.assert_allclose(origin[:, 1], 1 - 1.5 * v, rtol=0, atol=COORDINATE)


def test04_pixel_of_a_rendered_map_shows_its_cell(variant_llvm_ad_mono):
    scene = mi.load_dict(
        {
            "type": "scene",
            "plane": {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(2)},
            "sensor": {
                "type": "gem_orthographic",
                "film": film(60, 50),
                "sampler": {"type": "stratified", "sample_count": 1, "jitter": False},
                **WINDOW,
            },
            "integrator": {"type": "aov", "aovs": "point:position"},
        }
    )
    point = mi.render(scene).numpy()
    _, _, x, y = cells(**WINDOW, width=60, height=50)
    np.testing.assert_allclose(point[..., 0], x, rtol=0, atol=FAR_COORDINATE)
    np.testing.assert_allclose(point[..., 1], y, rtol=0, atol=FAR_COORDINATE)


def test05_crop_window_takes_its_part_of_the_window(variant_llvm_ad_mono):
    crop = film(crop_offset_x=3, crop_offset_y=1, crop_width=4, crop_height=2)
    column, row, x, y = cells(**WINDOW)
    part = np.s_[1:3, 3:7]
    u, v = (column[part] - 3 + 0.5) / 4, (row[part] - 1 + 0.5) / 2
    origin, _ = rays(sensor(film=crop, **WINDOW), u, v)
    np.testing.assert_allclose(origin[:, 0], x[part].ravel(), rtol=0, atol=COORDINATE)
    np.testing.assert_allclose(origin[:, 1], y[part].ravel(), rtol=0, atol=COORDINATE)


def test06_differentials_are_the_next_column_and_the_next_row(variant_llvm_ad_mono):
    tilted = sensor(**WINDOW, tilt=25, tilt_azimuth=70)
    ray, _ = tilted.sample_ray_differential(0.0, 0.0, mi.Point2f(2.5 / 8, 3.5 / 6), mi.Point2f(0.5))
    next_column, _ = tilted.sample_ray(0.0, 0.0, mi.Point2f(3.5 / 8, 3.5 / 6), mi.Point2f(0.5))
    next_row, _ = tilted.sample_ray(0.0, 0.0, mi.Point2f(2.5 / 8, 4.5 / 6), mi.Point2f(0.5))
    assert ray.has_differentials
    assert dr.allclose(ray.o_x, next_column.o, rtol=0, atol=FAR_COORDINATE)
    assert dr.allclose(ray.o_y, next_row.o, rtol=0, atol=FAR_COORDINATE)
    assert dr.all(ray.d_x == ray.d, axis=None)
    assert dr.all(ray.d_y == ray.d, axis=None)


# ---- The tilted view -----------------------------------------------------------------------------------


@pytest.mark.parametrize("azimuth", [0, 90, 200, -30])
@pytest.mark.parametrize("tilt", [0, 1, 30, 89])
def test07_tilt_turns_the_eye_and_the_image_by_one_rotation(variant_llvm_ad_mono, tilt, azimuth):
    def about(axis, degrees):
        sin, cos = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        rotation = np.eye(3)
        rotation[[i, j, i, j], [i, j, j, i]] = cos, cos, -sin, sin
        return rotation

    # The azimuth to the x axis, the tilt about the y axis, the azimuth back.
    right, up, eye = (about(2, azimuth) @ about(1, tilt) @ about(2, -azimuth)).T
    column, row, x, y = cells(**WINDOW)
    origin, direction = rays(
        sensor(**WINDOW, tilt=tilt, tilt_azimuth=azimuth), (column + 0.5) / 8, (row + 0.5) / 6
    )
    expected = x.reshape(-1, 1) * right + y.reshape(-1, 1) * up + 10 * eye
    np.testing.assert_allclose(origin, expected, rtol=0, atol=FAR_COORDINATE)
    np.testing.assert_allclose(direction, np.broadcast_to(-eye, direction.shape), rtol=0, atol=COORDINATE)


def test08_rays_start_at_the_distance(variant_llvm_ad_mono):
    origin, _ = rays(sensor(film=film(1, 1), distance=4, tilt=40, tilt_azimuth=10), [0.5], [0.5])
    assert np.linalg.norm(origin[0]) == pytest.approx(4, abs=FAR_COORDINATE)


# ---- Mitsuba's side ------------------------------------------------------------------------------------


def test09_agrees_with_the_orthographic_sensor_of_mitsuba(variants_all, rng):
    theirs = mi.load_dict(
        {
            "type": "orthographic",
            "to_world": mi.ScalarTransform4f().look_at(origin=[0, 0, 5], target=[0, 0, 0], up=[0, 1, 0]),
            "near_clip": 1e-6,
            "film": film(6, 6),
        }
    )
    ours = sensor(film=film(6, 6), distance=5, sampling="area")
    wavelength_sample = mi.Float(rng.random(100))
    place = mi.Point2f(rng.random((2, 100)))
    a, weight_a = ours.sample_ray_differential(0.0, wavelength_sample, place, mi.Point2f(0.5))
    b, weight_b = theirs.sample_ray_differential(0.0, wavelength_sample, place, mi.Point2f(0.5))
    for name in ("o", "d", "o_x", "o_y", "d_x", "d_y"):
        assert dr.allclose(getattr(a, name), getattr(b, name), rtol=0, atol=FAR_COORDINATE), name
    assert dr.all(a.wavelengths == b.wavelengths, axis=None)
    assert dr.all(weight_a == weight_b, axis=None)


def test10_spectral_weights_integrate_to_the_range_of_wavelengths(variant_llvm_ad_spectral):
    # Importance sampling: the mean of f(wavelength) times the weight is the integral of f, here of 1, over
    # 360 to 830 nm. A midpoint rule in the sample, so the tolerance is that of the rule at the steep ends.
    n = 100_000
    sample = (dr.arange(mi.Float, n) + 0.5) / n
    _, weight = sensor().sample_ray(0.0, sample, mi.Point2f(0.5), mi.Point2f(0.5))
    assert dr.mean(weight, axis=None)[0] == pytest.approx(830 - 360, rel=1e-3)


def test11_draws_no_sample_for_an_aperture(variant_llvm_ad_mono):
    assert not sensor().needs_aperture_sample()


def test12_moved_view_compiles_no_new_kernel(variants_all):
    scene = mi.load_dict(
        {
            "type": "scene",
            "light": {"type": "constant"},
            "ball": {"type": "sphere"},
            "sensor": {"type": "gem_orthographic", "film": film()},
            "integrator": {"type": "direct"},
        }
    )
    params = mi.traverse(scene)

    def compiled():
        """Render, and return how many kernels had to be compiled for it, or read from the disk."""
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            dr.kernel_history_clear()
            dr.eval(mi.render(scene, spp=4))
            kernels = [k for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT]
        assert kernels
        return sum(not k["cache_hit"] or bool(k["cache_disk"]) for k in kernels)

    compiled()  # the first time, or the second, when the scene has settled
    compiled()
    moves = {"x_min": -0.5, "x_max": 0.25, "y_min": 0.125, "y_max": 0.5}
    turns = {"tilt": 20.0, "tilt_azimuth": 75.0, "distance": 3.0}
    for changes in (moves, turns):
        for key, value in changes.items():
            params[f"sensor.{key}"] = value
        params.update()
        assert compiled() == 0


def test13_parameters_are_exposed_and_take_effect(variant_llvm_ad_mono):
    moved = sensor()
    params = mi.traverse(moved)
    for key, value in WINDOW.items():
        params[key] = value
    params.update()
    column, row, _, _ = cells(**WINDOW)
    u, v = (column + 0.5) / 8, (row + 0.5) / 6
    np.testing.assert_array_equal(rays(moved, u, v)[0], rays(sensor(**WINDOW), u, v)[0])


# ---- Bad values ----------------------------------------------------------------------------------------

BAD = [
    ({"x_min": 1}, "x_min = 1.0: must be below x_max = 1"),
    ({"y_min": 0.5, "y_max": -0.5}, "y_min = 0.5: must be below y_max = -0.5"),
    ({"tilt": 90}, "tilt = 90.0: must be at least 0 and below 90 degrees"),
    ({"tilt": -1}, "tilt = -1.0: must be at least 0 and below 90 degrees"),
    ({"tilt": "steep"}, "tilt = 'steep': must be a finite number"),
    ({"tilt_azimuth": float("nan")}, "tilt_azimuth = nan: must be a finite number"),
    ({"x_max": float("inf")}, "x_max = inf: must be a finite number"),
    ({"distance": 1}, "distance = 1.0: must be more than 1"),
    ({"sampling": "random"}, "sampling = 'random': must be one of centre, area"),
    ({"to_world": "identity"}, "to_world: not allowed here"),
    ({"zoom": 2}, 'unreferenced property.*"zoom"'),
]


@pytest.mark.parametrize(("properties", "message"), BAD, ids=[" ".join(bad) for bad, _ in BAD])
def test14_bad_value_is_refused_in_one_line(variant_llvm_ad_mono, properties, message):
    if "to_world" in properties:
        properties = {"to_world": mi.ScalarTransform4f()}
    with pytest.raises(RuntimeError, match=f"(?s){message}"):
        sensor(**properties)


def test15_bad_update_is_refused(variant_llvm_ad_mono):
    params = mi.traverse(sensor())
    params["x_min"] = 2.0
    with pytest.raises(ValueError, match=r"x_min = 2\.0: must be below x_max = 1"):
        params.update()

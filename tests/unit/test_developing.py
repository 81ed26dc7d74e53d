"""How pictures are developed: encoding, gamut and curve, exposure, and all of it."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from refusals import refused

from gemrender.colorimetry import (
    adapt,
    colour_matching,
    colour_science,
    luminance_weights,
    white_xyz,
    xyz_to_linear_srgb,
)
from gemrender.render.develop import (
    CURVES,
    MID_GREY,
    auto_exposure,
    develop,
    encode_srgb,
    filmic_gain,
    fit_gamut,
)

colour = colour_science()
D65_XYZ = (0.9505, 1.0, 1.0891)


def spectral_colours():
    """Return XYZ of single wavelengths, 1 nm apart (331, 3), the strongest fire there can be."""
    return colour_matching(np.arange(390.0, 721.0))


# ---- Encoding, gamut and curve -------------------------------------------------------------------------


def test_encoding_is_that_of_colour_science():
    linear = np.linspace(0, 1, 1001)
    encoded = encode_srgb(linear)
    np.testing.assert_allclose(encoded, colour.cctf_encoding(linear, function="sRGB"), atol=1e-12)
    # The standard's two branches meet to 1e-7 or so only.
    np.testing.assert_allclose(colour.cctf_decoding(encoded, function="sRGB"), linear, atol=1e-6)
    np.testing.assert_allclose(encode_srgb([-1, 2]), [0, 1], atol=1e-15)


@pytest.mark.parametrize("scale", [0.01, 0.3, 1, 3, 100])
@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_gamut_keeps_luminance_and_hue(scale, kind):
    spectral = scale * xyz_to_linear_srgb(spectral_colours()).astype(kind)
    assert spectral.min() < 0
    fitted = fit_gamut(spectral)
    assert fitted.min() >= 0
    assert fitted.max() <= 1
    weights = luminance_weights()
    before, after = spectral @ weights, fitted @ weights
    np.testing.assert_allclose(after, np.clip(before, 0, 1), atol=2e-6)
    # Hue: the chroma after is the chroma before times one positive number.
    chroma, left = spectral - before[:, None], fitted - after[:, None]
    shown = (before > 1e-3) & (before < 0.99)
    kept = np.sum(left * chroma, axis=1) / np.sum(chroma**2, axis=1)
    assert kept[shown].min(initial=1) > 0
    np.testing.assert_allclose(left[shown], (kept[:, None] * chroma)[shown], atol=2e-5)


def test_gamut_takes_no_more_than_it_needs():
    spectral = 0.3 * xyz_to_linear_srgb(spectral_colours())
    fitted = fit_gamut(spectral)
    at_edge = np.minimum(np.abs(fitted).min(axis=1), np.abs(1 - fitted).min(axis=1))
    np.testing.assert_allclose(at_edge, 0, atol=1e-12)
    inside = np.array([[0.2, 0.5, 0.9], [0, 0, 0], [1, 1, 1], [1, 0, 0]])
    np.testing.assert_allclose(fit_gamut(inside), inside, atol=1e-15)


def test_gamut_blows_out_to_white():
    blue = np.array([0.1, 0.1, 1.0]) * 2.0 ** np.arange(-1, 12)[:, None]
    fitted = fit_gamut(blue)
    assert (np.diff(fitted[:, 0]) >= 0).all()
    np.testing.assert_array_equal(fitted[:, 0], fitted[:, 1])
    np.testing.assert_array_equal(fitted[-1], 1)
    np.testing.assert_array_equal(fit_gamut([1e30, -1e29, 3e30]), 1)
    np.testing.assert_array_equal(fit_gamut([0.1, -1, 0.1]), 0)


def test_filmic_curve_is_narkowiczs_scaled_to_keep_mid_grey():
    """x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14): what reaches a level is a quadratic's root."""

    def reached_from(level):
        return np.roots([2.51 - 2.43 * level, 0.03 - 0.59 * level, -0.14 * level]).max()

    scale = reached_from(MID_GREY) / MID_GREY
    for level in (0.05, 0.5, 0.7, 1.0):
        luminance = reached_from(level) / scale
        assert luminance * filmic_gain(luminance) == pytest.approx(level, rel=1e-12)


def test_filmic_curve_keeps_mid_grey_and_rises():
    luminance = np.geomspace(1e-6, 9, 500)
    curve = luminance * filmic_gain(luminance)
    assert MID_GREY * filmic_gain(MID_GREY) == pytest.approx(MID_GREY, rel=1e-12)
    assert (np.diff(curve) > 0).all()
    assert np.isfinite(filmic_gain([0, -1, 1e30])).all()


# ---- Exposure ------------------------------------------------------------------------------------------


def stone_on_black(rng, size=200, rim=0):
    """Return luminances of a stone, and the mask of it, on a black background."""
    mask = np.zeros((size + 2 * rim, size + 2 * rim), dtype=bool)
    mask[rim : rim + size, rim : rim + size] = True
    luminance = np.zeros(mask.shape)
    luminance[mask] = rng.beta(1, 3, mask.sum())
    return luminance, mask


def test_exposure_brings_the_lights_to_just_below_one(rng):
    luminance, mask = stone_on_black(rng)
    factor = auto_exposure(luminance, mask)
    assert 0.97 < np.mean(factor * luminance[mask] < 1) < 1
    assert auto_exposure(10 * luminance, mask) == pytest.approx(factor / 10)
    assert auto_exposure(np.ones((9, 9))) == pytest.approx(0.9)


def test_exposure_ignores_fireflies(rng):
    luminance, mask = stone_on_black(rng)
    factor = auto_exposure(luminance, mask)
    flies = rng.choice(luminance.size, luminance.size // 1000, replace=False)
    for value in (1e3, 1e30, np.inf, np.nan):
        spotted = luminance.copy()
        spotted.flat[flies] = value
        assert auto_exposure(spotted, mask) == pytest.approx(factor, rel=0.02)
        assert auto_exposure(spotted) == pytest.approx(factor, rel=0.02)


def test_exposure_ignores_the_background():
    small = stone_on_black(np.random.default_rng(1))
    large = stone_on_black(np.random.default_rng(1), rim=400)
    assert auto_exposure(*large) == auto_exposure(*small)
    assert auto_exposure(large[0]) == auto_exposure(small[0])
    assert auto_exposure(large[0] + 5 * ~large[1], large[1]) == auto_exposure(*small)


def test_exposure_is_corrected_in_stops(rng):
    luminance, mask = stone_on_black(rng)
    assert auto_exposure(luminance, mask, ev=-1.5) == pytest.approx(auto_exposure(luminance, mask) * 2**-1.5)


def test_exposure_of_a_black_picture_is_one():
    black = np.zeros((4, 4))
    assert auto_exposure(black) == auto_exposure(black, black == 0) == auto_exposure(black, black > 0) == 1
    spot = np.zeros((20, 20))
    spot[3, 3] = 2
    assert auto_exposure(spot, spot >= 0) == pytest.approx(0.45)


def test_bad_exposures_are_refused():
    for ev in (np.nan, 21, "1", None, True):
        refused(lambda ev=ev: auto_exposure(np.ones((2, 2)), ev=ev), "ev = ", "-20 to 20 [EV]")
    refused(lambda: auto_exposure(np.ones((2, 2)), np.ones((3, 2))), "mask.shape = (3, 2)", "(2, 2)")


# ---- The whole chain -----------------------------------------------------------------------------------


@pytest.mark.parametrize("light", ["d65", "a", "led-b3", 2000])
@pytest.mark.parametrize("curve", CURVES)
def test_greys_under_any_light_come_out_grey(light, curve):
    white = white_xyz(light)
    greys = np.geomspace(1e-3, 20, 64)
    picture = develop(greys.reshape(8, 8, 1) * white, white_xyz=white, exposure=1.0, curve=curve)
    assert picture.dtype == np.uint8
    assert picture.shape == (8, 8, 3)
    np.testing.assert_array_equal(picture, picture[..., :1].repeat(3, axis=2))
    assert (np.diff(picture[..., 0].ravel().astype(int)) >= 0).all()
    assert picture[-1, -1, 0] == 255


def test_mid_grey_is_developed_alike_by_all_curves_but_neutral():
    white = white_xyz("d50")
    for curve in set(CURVES) - {"neutral"}:
        picture = develop([[0.09 * white]], white_xyz=white, exposure=2.0, curve=curve)
        np.testing.assert_array_equal(picture, round(255 * float(encode_srgb(MID_GREY))))


def test_developing_is_the_chain_of_its_steps(rng):
    white = white_xyz("a")
    xyz = rng.uniform(0, 1, (300, 500, 3)).astype(np.float32)  # more than one block
    linear = 1.7 * xyz_to_linear_srgb(adapt(xyz.astype(float), white))
    np.testing.assert_array_equal(
        develop(xyz, white_xyz=white, exposure=1.7, curve="linear"),
        np.rint(255 * encode_srgb(fit_gamut(linear))),
    )


def test_pixels_that_are_not_finite_come_out_black():
    xyz = np.full((2, 2, 3), np.float32(0.5))
    xyz[0, 0, 1], xyz[0, 1, 2], xyz[1, 0, 0] = np.nan, np.inf, 3e38
    picture = develop(xyz, white_xyz=D65_XYZ, exposure=1.0, curve="filmic")
    np.testing.assert_array_equal(picture[0], 0)
    assert picture[1, 1].min() > 0


def test_developing_needs_little_memory():
    xyz = np.ones((512, 1024, 3), dtype=np.float32)
    develop(xyz[:1], white_xyz=D65_XYZ, exposure=1.0)
    tracemalloc.start()
    try:
        develop(xyz, white_xyz=D65_XYZ, exposure=1.0, curve="filmic")
        assert tracemalloc.get_traced_memory()[1] < 40e6
    finally:
        tracemalloc.stop()


def test_bad_developing_is_refused():
    xyz = np.ones((2, 2, 3))

    def call(image=xyz, **changed):
        settings = {"white_xyz": D65_XYZ, "exposure": 1.0, "curve": "linear"} | changed
        return lambda: develop(image, **settings)

    refused(call(curve="log"), "curve = 'log'", "linear, filmic, contrast, neutral, agx")
    refused(call(white_xyz=(0, 0, 0)), "white = (0, 0, 0)")
    for exposure in (0, -1, np.nan, np.inf, "1"):
        refused(call(exposure=exposure), "exposure = ", "must be a number")
    refused(call(np.ones((2, 3))), "xyz.shape = (2, 3)", "(h, w, 3)")
    refused(call(np.ones((2, 3, 4))), "xyz.shape = (2, 3, 4)")

"""Colours of photoreal pictures: closed forms of colorimetry."""

from __future__ import annotations

import numpy as np
import pytest
from observations import run_python
from refusals import refused

from gemrender.colorimetry import (
    VISIBLE_NM,
    adapt,
    adaptation_matrix,
    colour_matching,
    colour_science,
    colour_spectrum,
    colour_xyz,
    illuminant_names,
    illuminant_spectrum,
    white_xyz,
    xyz_to_linear_srgb,
    y_integral_nm,
)
from gemrender.render.develop import (
    fit_gamut,
)

colour = colour_science()

#: Rows of the observer's table [nm].
ROWS_NM = np.arange(360.0, 831.0)

D65_XY = (0.3127, 0.3290)
D65_XYZ = (0.9505, 1.0, 1.0891)


def xy(xyz):
    return np.asarray(xyz)[:2] / np.sum(xyz)


# ---- Spectra -------------------------------------------------------------------------------------------


def test_matching_functions_are_those_of_the_table():
    table = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    np.testing.assert_array_equal(colour_matching(ROWS_NM), table.values)
    assert colour_matching(555)[1] == 1.0
    assert colour_matching(np.zeros((2, 4)) + 500).shape == (2, 4, 3)


def test_matching_functions_are_linear_between_rows_and_zero_outside():
    between = colour_matching([500.25])
    np.testing.assert_allclose(between, 0.75 * colour_matching([500]) + 0.25 * colour_matching([501]))
    np.testing.assert_array_equal(colour_matching([359.99, 830.01, 1, 1e6]), 0)


@pytest.mark.parametrize("light", [*illuminant_names(), 1000, 6504, 25000.0])
def test_every_light_has_the_luminance_of_radiance_one(light):
    spectrum = illuminant_spectrum(light, ROWS_NM)
    assert spectrum.min() >= 0
    assert spectrum @ colour_matching(ROWS_NM)[:, 1] == pytest.approx(y_integral_nm(), rel=1e-12)
    assert white_xyz(light)[1] == 1


def test_equal_energy_is_one_everywhere():
    np.testing.assert_allclose(illuminant_spectrum("e", [1, 300, 555.5, 1000]), 1, rtol=1e-12)
    np.testing.assert_allclose(xy(white_xyz("e")), 1 / 3, atol=1e-4)  # the table's three sums differ
    assert y_integral_nm() == pytest.approx(106.857, abs=1e-3)


@pytest.mark.parametrize("light", ["d65", "d50", "a", "f2", "f11", "led-b3", "hp1"])
def test_white_points_are_the_published_ones(light):
    name = light.upper().replace("F", "FL")
    published = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"][name]
    np.testing.assert_allclose(xy(white_xyz(light)), published, atol=2e-3)


def test_blackbody_of_6504_kelvin_is_near_d65():
    np.testing.assert_allclose(xy(white_xyz(6504)), D65_XY, atol=0.01)


def test_blackbody_of_2856_kelvin_is_illuminant_a():
    """CIE defines A as Planck's law at 2848 K with c2 of 1.435e-2 m K, 2855.5 K with that of today."""
    np.testing.assert_allclose(
        illuminant_spectrum(2855.5, ROWS_NM[:421:5]), illuminant_spectrum("a", ROWS_NM[:421:5]), rtol=2e-3
    )


def test_blackbody_is_plancks_law():
    ours, planck = illuminant_spectrum(4000, ROWS_NM), colour.colorimetry.planck_law(ROWS_NM * 1e-9, 4000)
    # colour-science rounds the second radiation constant to 1.4388e-2.
    np.testing.assert_allclose(ours / ours[200], planck / planck[200], rtol=1e-4)


def test_blackbody_dies_out_in_the_ultraviolet():
    np.testing.assert_array_equal(illuminant_spectrum(1000, [1.0, 5.0]), 0)


def test_lights_have_many_spellings():
    for one, other in [("d65", " D65 "), ("f2", "FL2"), ("f3.1", "fl3.1"), (5500, "5500"), (5500, "5500 K")]:
        np.testing.assert_array_equal(white_xyz(one), white_xyz(other))


@pytest.mark.parametrize("light", ["d64", "", "999", 999, 25001, np.nan, "nan", np.inf, True, None, [5000]])
def test_unknown_lights_are_refused(light):
    refused(lambda: illuminant_spectrum(light, [500]), "spectrum = ", "1000 to 25000 [K]", "d65", "led-b3")
    refused(lambda: white_xyz(light), "spectrum = ")


@pytest.mark.parametrize("wavelength", [0, -1, np.nan, [500, np.inf]])
def test_bad_wavelengths_are_refused(wavelength):
    refused(lambda: colour_matching(wavelength), "wavelength = ", "above 0 [nm]")
    refused(lambda: illuminant_spectrum("d65", wavelength), "wavelength = ")


def picture_of_spectrum(rgb):
    """Linear sRGB of a picture of a colour's spectrum: the integral over visible light, in fine steps."""
    nm = np.linspace(*VISIBLE_NM, 380 * 64 + 1)
    values = colour_spectrum(rgb, nm)[:, None] * colour_matching(nm)
    xyz = 0.5 * (values[1:] + values[:-1]).sum(axis=0) / 64 / y_integral_nm()
    return xyz_to_linear_srgb(adapt(xyz, white_xyz("d65")))


#: Trapezia of 1/64 nm under a picture of a spectrum.
FINE_STEPS = 1e-6


@pytest.mark.parametrize(
    "rgb",
    [
        (1, 0, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 1, 0),
        (1, 0, 1),
        (0, 1, 1),
        (1, 1, 1),
        (1, 0.25, 0.4),
        (0, 1e-9, 0),
    ],
)
def test_a_colour_has_a_positive_spectrum_that_is_that_colour(rgb):
    """Though red, green and blue of sRGB are near the edge of what light can be."""
    np.testing.assert_allclose(picture_of_spectrum(rgb), rgb, atol=FINE_STEPS * max(rgb), rtol=0)
    assert colour_spectrum(rgb, np.linspace(*VISIBLE_NM)).min() > 0


def test_random_colours_have_spectra(rng):
    for rgb in rng.random((20, 3)) ** rng.integers(1, 12):
        np.testing.assert_allclose(picture_of_spectrum(rgb), rgb, atol=FINE_STEPS * max(rgb), rtol=0)


def test_a_spectrum_of_a_colour_is_smooth_and_goes_with_its_brightness():
    nm = np.arange(380.0, 761.0, 5.0)
    rise = np.diff(np.log(colour_spectrum((0, 1, 0), nm)))
    assert ((rise[1:] < 0) & (rise[:-1] > 0)).sum() == 1  # one maximum
    assert np.abs(np.diff(rise)).max() < 0.1
    np.testing.assert_allclose(colour_spectrum((0, 7, 0), nm), 7 * colour_spectrum((0, 1, 0), nm))
    np.testing.assert_array_equal(colour_spectrum((0, 1, 0), [360.0, 379.9, 760.1, 830.0]), 0)


def test_xyz_of_a_colour_is_its_picture():
    rgb = np.array([0.2, 0.5, 0.9])
    np.testing.assert_allclose(xyz_to_linear_srgb(adapt(colour_xyz(rgb), white_xyz("d65"))), rgb, atol=1e-12)
    np.testing.assert_allclose(colour_xyz([1, 1, 1]), white_xyz("d65"), atol=1e-12)


@pytest.mark.parametrize("rgb", [(0, 0, 0), (1, -1e-9, 0), (1, np.nan, 0), (1, 1), 1.0])
def test_what_is_no_colour_has_no_spectrum(rgb):
    refused(lambda: colour_spectrum(rgb, 500), "colour = ", "three numbers of at least 0, not all 0")


# ---- Tristimulus values --------------------------------------------------------------------------------


def test_d65_is_srgb_white():
    np.testing.assert_allclose(xyz_to_linear_srgb(D65_XYZ), 1, atol=1e-3)
    np.testing.assert_allclose(xyz_to_linear_srgb(white_xyz("d65")), 1, atol=1e-3)


def test_linear_srgb_is_that_of_colour_science(rng):
    xyz = rng.uniform(0, 1, (50, 3))
    theirs = colour.XYZ_to_RGB(xyz, "sRGB", apply_cctf_encoding=False)
    np.testing.assert_allclose(xyz_to_linear_srgb(xyz), theirs, atol=1e-3)  # their matrix is rounded


@pytest.mark.parametrize("light", [*illuminant_names(), 1000, 25000])
def test_every_white_becomes_white(light):
    white = white_xyz(light)
    np.testing.assert_allclose(xyz_to_linear_srgb(adapt(white, white)), 1, atol=1e-9)
    np.testing.assert_allclose(xyz_to_linear_srgb(adapt(0.3 * white, 7 * white)), 0.3, atol=1e-9)


def test_adaptation_of_d65_changes_nothing():
    np.testing.assert_allclose(
        adaptation_matrix(adapt(white_xyz("a"), white_xyz("a"))), np.eye(3), atol=1e-12
    )


@pytest.mark.parametrize("white", ["a", "d50", 3000, 10000])
@pytest.mark.parametrize("wavelength", [430, 450, 550, 660])
def test_adaptation_leaves_the_luminance_of_spectral_colours(white, wavelength):
    """Bradford makes violet 13 times as bright under illuminant A, and negative under 10000 K."""
    spectral = colour_matching(wavelength)
    assert adapt(spectral, white_xyz(white))[1] == pytest.approx(spectral[1], rel=0.08)


def test_images_stay_float32_and_in_shape(rng):
    image = rng.uniform(0, 1, (5, 7, 3)).astype(np.float32)
    for result in (adapt(image, white_xyz("a")), xyz_to_linear_srgb(image), fit_gamut(image)):
        assert result.dtype == np.float32
        assert result.shape == image.shape
    one = xyz_to_linear_srgb(adapt(image[2, 3], white_xyz("a")))
    np.testing.assert_allclose(xyz_to_linear_srgb(adapt(image, white_xyz("a")))[2, 3], one, atol=1e-6)


@pytest.mark.parametrize("white", [[1, 1], [0, 1, 1], [1, 0, 1], [1, 1, -1], [1, np.nan, 1]])
def test_whites_that_no_light_has_are_refused(white):
    refused(lambda: adapt(np.ones(3), white), "white = ", "X, Y, Z")


@pytest.mark.parametrize("image", [1.0, np.ones((4, 4)), np.ones((4, 3), dtype=complex), np.array(["a"] * 3)])
def test_no_images_are_refused(image):
    refused(lambda: xyz_to_linear_srgb(image), "xyz.")


# ---- colour-science ------------------------------------------------------------------------------------


def test_it_comes_without_its_plotting_until_that_is_used():
    code = (
        "import sys; from gemrender.colorimetry import white_xyz; white_xyz('d65'); import colour; "
        "print('matplotlib' in sys.modules, colour.plotting.plot_single_sd.__name__); "
        "from colour.plotting import plot_multi_sds as two; print('matplotlib' in sys.modules, two.__name__)"
    )
    done = run_python("-W", "ignore", "-c", code)
    assert done.stdout.splitlines() == ["False plot_single_sd", "True plot_multi_sds"], done.stderr

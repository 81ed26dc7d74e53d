"""Colours of photoreal pictures: closed forms of colorimetry first, then exposure, gamut and files."""

from __future__ import annotations

import tracemalloc

import colour
import numpy as np
import OpenEXR
import pytest
from matplotlib.image import imread

import gemrender
from gemrender.colorimetry import (
    VISIBLE_NM,
    adapt,
    adaptation_matrix,
    colour_matching,
    colour_spectrum,
    colour_xyz,
    illuminant_names,
    illuminant_spectrum,
    luminance_weights,
    white_xyz,
    xyz_to_linear_srgb,
    y_integral_nm,
)
from gemrender.errors import InputError
from gemrender.render.develop import (
    CURVES,
    MID_GREY,
    auto_exposure,
    develop,
    encode_srgb,
    filmic_gain,
    fit_gamut,
)
from gemrender.render.picture_files import SPECTRAL_ATTRIBUTES, spectral_channel, write_exr, write_png

#: Rows of the observer's table [nm].
ROWS_NM = np.arange(360.0, 831.0)

D65_XY = (0.3127, 0.3290)
D65_XYZ = (0.9505, 1.0, 1.0891)


def xy(xyz):
    return np.asarray(xyz)[:2] / np.sum(xyz)


def spectral_colours():
    """Return XYZ of single wavelengths, 1 nm apart (331, 3), the strongest fire there can be."""
    return colour_matching(np.arange(390.0, 721.0))


def refused(call, *parts):
    """See that a call is refused in one line that has these parts."""
    with pytest.raises(InputError) as caught:
        call()
    line = str(caught.value)
    assert "\n" not in line
    for part in parts:
        assert part in line


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


def test_filmic_curve_keeps_mid_grey_and_rises():
    luminance = np.geomspace(1e-6, 9, 500)
    curve = luminance * filmic_gain(luminance)
    assert MID_GREY * filmic_gain(MID_GREY) == pytest.approx(MID_GREY, rel=1e-12)
    assert (np.diff(curve) > 0).all()
    assert 10 * filmic_gain(10) < 1 < 10.02 * filmic_gain(10.02)
    assert filmic_gain(1.0) == pytest.approx(0.726, abs=1e-3)
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


# ---- Files ---------------------------------------------------------------------------------------------


def test_exr_reads_back_bit_equal(rng, tmp_path):
    names = ["R", "G", "B", "X", "Y", "Z", "albedo.R", "normal.X", *map(spectral_channel, (450, 512.5))]
    written = {name: rng.normal(size=(5, 9)).astype(np.float32) for name in names}
    written["R"][0, :3] = np.nan, np.inf, -0.0
    attributes = {"stone": "Größe", "exposure": 1.5, "samples": 64, **SPECTRAL_ATTRIBUTES}
    assert write_exr(tmp_path / "a.exr", written, attributes) == tmp_path / "a.exr"
    file = OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True)
    assert set(file.channels()) == set(names)
    for name, values in written.items():
        pixels = file.channels()[name].pixels
        assert pixels.dtype == np.float32
        np.testing.assert_array_equal(pixels.view(np.uint32), values.view(np.uint32))
    header = file.header()
    assert {name: header[name] for name in attributes} == attributes
    assert header["gemrender.version"] == gemrender.__version__


def test_exr_takes_views_and_other_types(tmp_path):
    image = np.arange(24.0).reshape(2, 4, 3)
    write_exr(tmp_path / "a.exr", {"R": image[..., 0], "hit": image[..., 1] > 7, "big": image[..., 2] * 1e40})
    read = OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True).channels()
    np.testing.assert_array_equal(read["R"].pixels, image[..., 0])
    np.testing.assert_array_equal(read["hit"].pixels, image[..., 1] > 7)
    np.testing.assert_array_equal(read["big"].pixels, np.inf)


def test_spectral_channels_are_named_by_the_layout():
    assert spectral_channel(550) == "S0.550,000000nm"
    assert spectral_channel(412.5) == "S0.412,500000nm"


@pytest.mark.parametrize("shape", [(6, 5, 3), (1, 1, 3), (3, 1, 3), (1, 4, 3)])
def test_png_reads_back_equal(rng, tmp_path, shape):
    picture = rng.integers(0, 256, shape, dtype=np.uint8)
    assert write_png(tmp_path / "a.png", picture) == tmp_path / "a.png"
    np.testing.assert_array_equal(np.rint(255 * imread(tmp_path / "a.png")), picture)


def test_png_tells_what_it_is(tmp_path):
    image = pytest.importorskip("PIL.Image")
    texts = {"Title": "Größe 3 日本", "Comment": ""}
    write_png(tmp_path / "a.png", np.zeros((2, 2, 3), np.uint8)[:, ::-1], texts)
    with image.open(tmp_path / "a.png") as opened:
        opened.load()
        assert opened.text == {"Software": f"gemrender {gemrender.__version__}"} | texts
        assert opened.info["srgb"] == 0
        assert opened.mode == "RGB"


def test_bad_channels_are_refused(tmp_path):
    plane = np.zeros((2, 3))
    for channels, part in [
        ({}, "channels = {}"),
        ({"": plane}, "channel = ''"),
        ({"a\0": plane}, "channel"),
        ({"R": plane, "G": plane.T}, "G.shape = (3, 2)"),
        ({"R": plane[0]}, "R.shape = (3,)"),
        ({"R": plane[:0]}, "R.shape = (0, 3)"),
        ({"R": plane * 1j}, "R.dtype = 'complex128'"),
    ]:
        refused(lambda channels=channels: write_exr(tmp_path / "a.exr", channels), "a.exr: ", part)
    for attributes, part in [
        ({"version": "1"}, "attribute = 'version'"),
        ({"": "1"}, "attribute = ''"),
        ({"x": [1]}, "x = [1]"),
        ({"x": None}, "x = None"),
    ]:
        refused(lambda attributes=attributes: write_exr(tmp_path / "a.exr", {"R": plane}, attributes), part)
    assert not list(tmp_path.iterdir())


def test_bad_pictures_are_refused(tmp_path):
    picture = np.zeros((2, 2, 3), np.uint8)
    for bad in (picture.astype(float), picture[0], picture[..., :2], picture[:0]):
        refused(lambda bad=bad: write_png(tmp_path / "a.png", bad), "rgb8 = ", "(h, w, 3) of uint8")
    for keyword in ("", " a", "a ", "a  b", "x" * 80, "日本", "a\nb"):
        refused(lambda keyword=keyword: write_png(tmp_path / "a.png", picture, {keyword: "a"}), "text = ")
    for text in ("a\0b", "\ud800", 1):
        refused(lambda text=text: write_png(tmp_path / "a.png", picture, {"Title": text}), "Title = ")
    assert not list(tmp_path.iterdir())


WRITERS = [
    ("a.exr", lambda path: write_exr(path, {"R": np.zeros((2, 2))})),
    ("a.png", lambda path: write_png(path, np.zeros((2, 2, 3), np.uint8))),
]


@pytest.mark.parametrize(("name", "write"), WRITERS)
def test_places_that_cannot_be_written_are_refused(tmp_path, name, write):
    refused(lambda: write(tmp_path / "none" / name), "none: cannot be written: No such file")
    refused(lambda: write(""), "path = ''", "name of a file")
    (tmp_path / name).mkdir()
    refused(lambda: write(tmp_path / name), f"{name}: cannot be written: Is a directory")
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize(("name", "write"), WRITERS)
def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch, name, write):
    (tmp_path / name).write_bytes(b"before")

    def full(self, *_, **__):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr("PIL.Image.Image.save", full)
        patched.setattr("OpenEXR.File.write", full)
        refused(lambda: write(tmp_path / name), f"{name}: cannot be written: No space left on device")
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"before"]

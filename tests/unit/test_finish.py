"""From linear values to exposure and files: the picture's own part of it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from PIL import Image

from gemrender.colorimetry import white_xyz
from gemrender.errors import InputError
from gemrender.render.develop import CURVES, EXPOSED_TO
from gemrender.render.finish import (
    PAPER,
    WHITE_PAPER,
    denoised,
    developed,
    exposure_of,
    white_of,
    write_picture,
)
from gemrender.render.fireflies import BRIGHTER, FEWEST_SAMPLES, firefly_scale, without_fireflies
from gemrender.render.first_seen import Seen
from gemrender.render.photoreal import Foreground, Picture
from gemrender.scene.setup import Setup, Sky

#: What the denoiser may change where all is brighter or darker: rounding in single precision.
DENOISED = 1e-4
SETUP = Setup(name="A", sky=Sky(radiance=1.0))


def picture(stone=0.5, ground=0.2):
    """Stone on the left, ground in the middle, nothing on the right."""
    xyz, albedo = np.zeros((4, 9, 3), np.float32), np.zeros((4, 9, 3), np.float32)
    coverage = np.zeros((4, 9), np.float32)
    xyz[:, :3], xyz[:, 3:6] = stone, ground
    albedo[:, :3], albedo[:, 3:6] = 1.0, 0.6
    coverage[:, :6] = 1.0
    shows = np.zeros((4, 9), np.uint8)
    shows[:, :3], shows[:, 3:6] = Seen.STONE, Seen.GROUND
    return Picture(
        xyz=xyz,
        albedo=albedo,
        normal=np.zeros_like(xyz),
        coverage=coverage,
        shows=shows,
        spectrum=np.zeros((4, 9, 0), np.float32),
        bins_nm=None,
        samples=1,
        noise=0.1,
        seconds=1.0,
        stopped="samples",
    )


@pytest.mark.parametrize("ground", [0.01, 0.2, 50.0])
def test_the_exposure_goes_by_the_stones(ground):
    assert exposure_of(picture(0.5, ground), SETUP) == pytest.approx(EXPOSED_TO / 0.5)


@pytest.mark.parametrize("stone", [0.01, 0.5, 50.0])
def test_or_by_the_ground(stone):
    setup = dataclasses.replace(SETUP, expose_for="ground")
    assert exposure_of(picture(stone, 0.2), setup) == pytest.approx(PAPER / 0.2)


@pytest.mark.parametrize("curve", CURVES)
def test_or_so_that_the_ground_is_white_through_the_curve(curve):
    setup = dataclasses.replace(SETUP, expose_for="white", curve=curve)
    warm = picture(0.5, 0.2)
    warm.xyz[:, 3:6] = 0.2 * white_xyz(4000)
    shown = developed(warm, setup, exposure=exposure_of(warm, setup), curve=curve)
    assert (shown[:, 3:6] == WHITE_PAPER).all()  # neutral, whatever the light
    two_stops = exposure_of(warm, setup, ev=2.0)
    assert two_stops == pytest.approx(4 * exposure_of(warm, setup))


@pytest.mark.parametrize("expose_for", ["ground", "white"])
def test_metal_and_things_are_no_ground(expose_for):
    """Most of what is beside the stone is a bright red thing; the paper is what it was."""
    setup = dataclasses.replace(SETUP, expose_for=expose_for)
    plain, beside = picture(0.5, 0.2), picture(0.5, 0.2)
    beside.shows[:, 4:6], beside.xyz[:, 4:6] = Seen.BESIDE, [9.0, 5.0, 1.0]
    assert exposure_of(beside, setup) == exposure_of(plain, setup)
    np.testing.assert_array_equal(white_of(beside, setup), white_of(plain, setup))


def test_neither_are_they_stones_nor_is_glass():
    beside = picture(0.5, 50.0)
    beside.shows[:, 3:6], beside.albedo[:, 3:6] = Seen.BESIDE, 1.0
    assert exposure_of(beside, SETUP) == pytest.approx(EXPOSED_TO / 0.5)


def test_a_ground_that_reflects_all_is_one():
    white = picture(0.5, 0.2)
    white.albedo[:, 3:6] = 1.0
    setup = dataclasses.replace(SETUP, expose_for="ground")
    assert exposure_of(white, setup) == pytest.approx(PAPER / 0.2)
    assert exposure_of(white, SETUP) == pytest.approx(EXPOSED_TO / 0.5)


def test_a_white_ground_that_is_black_leaves_white_and_exposure_to_the_stones():
    setup = dataclasses.replace(SETUP, expose_for="white", white=4000)
    assert exposure_of(picture(0.5, 0.0), setup) == pytest.approx(EXPOSED_TO / 0.5)
    np.testing.assert_array_equal(white_of(picture(0.5, 0.0), setup), white_xyz(4000))


def test_the_set_up_says_what_is_white_where_the_ground_need_not_be():
    np.testing.assert_array_equal(
        white_of(picture(), dataclasses.replace(SETUP, white=4000)), white_xyz(4000)
    )


def test_without_a_ground_by_the_stones_after_all():
    setup = dataclasses.replace(SETUP, expose_for="ground")
    assert exposure_of(picture(0.5, 0.0), setup) == pytest.approx(EXPOSED_TO / 0.5)


@pytest.mark.parametrize("light", [0.01, 0.5, 30.0])
def test_exposed_for_the_light_a_radiance_of_1_is_white_whatever_is_seen(light):
    setup = dataclasses.replace(SETUP, expose_for="light")
    assert exposure_of(picture(light, light), setup) == 1.0
    assert exposure_of(picture(light, light), dataclasses.replace(setup, exposure=1.0), ev=1.0) == 4.0


def test_stops_of_the_set_up_and_the_user_add_up():
    setup = dataclasses.replace(SETUP, exposure=1.0)
    assert exposure_of(picture(), setup, ev=2.0) == pytest.approx(8 * exposure_of(picture(), SETUP))


def test_exr_keeps_values_that_no_screen_shows(tmp_path):
    import OpenEXR

    path = write_picture(tmp_path / "a.exr", picture(stone=70.0), SETUP, exposure=0.01)
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    assert channels["Y"].pixels[0, 0] == 70.0
    assert channels["albedo.R"].pixels[0, 4] == np.float32(0.6)


# ---- A transparent background --------------------------------------------------------------------------

#: What 8 bits lose.
EIGHT_BITS = 0.5 / 255


def cut_out(light=0.4):
    """Stones on the left, an edge in column 3, ground and nothing to the right of it."""
    whole = picture(light, 0.2)
    alpha = np.zeros((4, 9), np.float32)
    alpha[:, :3], alpha[:, 3] = 1.0, 0.25
    own = np.array([light, light, 0.6 * light], np.float32)
    white = np.repeat(alpha[..., None], 3, axis=2)
    front = Foreground(xyz=white * own, albedo=white, normal=np.zeros_like(whole.normal), alpha=alpha)
    return dataclasses.replace(whole, foreground=front), own


def read_exr(path):
    import OpenEXR

    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return {name: channel.pixels for name, channel in channels.items()}


def linear(encoded):
    """Undo sRGB's encoding (IEC 61966-2-1)."""
    values = np.asarray(encoded, float) / 255
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def test_an_edge_has_the_stones_own_colour():
    """Neither the ground's nor, multiplied by alpha, a dark one: no halo on any background."""
    shown = developed(cut_out()[0], SETUP, exposure=1.0, curve="filmic")
    assert shown.shape == (4, 9, 4)
    np.testing.assert_array_equal(shown[:, 3, :3], shown[:, 2, :3])
    np.testing.assert_array_equal(shown[0, :, 3], [255, 255, 255, 64, 0, 0, 0, 0, 0])
    assert shown[:, 4:].max() == 0


def test_laid_over_black_it_is_the_light_of_the_stones():
    whole, _ = cut_out()
    shown = developed(whole, SETUP, exposure=1.0)
    over_black = linear(shown[..., :3]) * shown[..., 3:] / 255
    there = linear(
        developed(dataclasses.replace(whole, xyz=whole.foreground.xyz, foreground=None), SETUP, exposure=1.0)
    )
    np.testing.assert_allclose(over_black, there, atol=4 * EIGHT_BITS)  # a step of sRGB is up to 2.3 of light


def test_the_exposure_is_that_of_the_whole_picture():
    for setup in (SETUP, dataclasses.replace(SETUP, expose_for="ground")):
        whole, _ = cut_out()
        assert exposure_of(whole, setup) == exposure_of(dataclasses.replace(whole, foreground=None), setup)


def test_an_exr_has_alpha_that_all_is_multiplied_by(tmp_path):
    whole, own = cut_out()
    channels = read_exr(write_picture(tmp_path / "a.exr", whole, SETUP, exposure=1.0))
    alpha = whole.foreground.alpha
    np.testing.assert_array_equal(channels["A"], alpha)
    np.testing.assert_array_equal(channels["coverage"], alpha)
    np.testing.assert_array_equal(channels["albedo.R"], alpha)
    np.testing.assert_allclose(channels["Y"], alpha * own[1], rtol=1e-6)
    np.testing.assert_allclose(channels["R"][:, 3], 0.25 * channels["R"][:, 0], rtol=1e-5)
    assert channels["R"][:, 4:].max() == 0
    assert "A" not in read_exr(write_picture(tmp_path / "b.exr", picture(), SETUP, exposure=1.0))


@pytest.mark.parametrize("name", ["a.png", "a.webp"])
def test_pictures_for_the_screen_have_alpha(tmp_path, name):
    whole, _ = cut_out()
    write_picture(tmp_path / name, whole, SETUP, exposure=1.0)
    with Image.open(tmp_path / name) as image:
        assert image.mode == "RGBA"
        np.testing.assert_array_equal(image, developed(whole, SETUP, exposure=1.0))


def test_the_ending_tells_the_kind(tmp_path):
    for name, kind in (("a.jpg", "JPEG"), ("a.jpeg", "JPEG"), ("a.WEBP", "WEBP"), ("a.png", "PNG")):
        with Image.open(write_picture(tmp_path / name, picture(), SETUP, exposure=1.0)) as image:
            assert (image.format, image.mode, image.size) == (kind, "RGB", (9, 4))
    with pytest.raises(InputError, match=r"must end in .png, .jpg, .jpeg, .webp, .exr$"):
        write_picture(tmp_path / "a.gif", picture(), SETUP, exposure=1.0)


def test_the_denoiser_leaves_nothing_beside_the_stones():
    pytest.importorskip("mitsuba_oidn")
    after = denoised(cut_out()[0]).foreground
    assert np.abs(after.xyz[:, 4:]).max() == 0
    assert after.xyz[:, :3, 1].mean() == pytest.approx(0.4, rel=0.1)
    np.testing.assert_array_equal(after.alpha, cut_out()[0].foreground.alpha)


@pytest.mark.parametrize("radiance", [1e-12, 1e-6, 1e6])
def test_the_denoiser_takes_the_dark_as_it_takes_the_light(radiance):
    pytest.importorskip("mitsuba_oidn")
    picture = cut_out()[0]
    dim = dataclasses.replace(picture, xyz=(radiance * picture.xyz).astype(np.float32), foreground=None)
    expected = denoised(dataclasses.replace(picture, foreground=None)).xyz
    assert np.abs(denoised(dim).xyz / radiance - expected).max() < DENOISED


# ---- Fireflies -----------------------------------------------------------------------------------------


def two_halves(stone=0.5):
    """A picture of even light, with a sparkle, which both halves saw, and a firefly, which one did."""
    halves = np.full((2, 4, 9), stone, np.float32)
    halves[:, 1, 1] = 40 * stone
    halves[0, 2, 6] = 90 * stone
    whole = picture(stone, stone)
    xyz = np.repeat(halves.mean(axis=0)[..., None], 3, axis=2)
    return dataclasses.replace(whole, xyz=xyz, halves=halves, samples=FEWEST_SAMPLES)


def test_what_one_half_of_the_samples_saw_is_clamped_to_twice_what_both_did():
    clamped = without_fireflies(two_halves())
    assert clamped.clamped == 1
    assert clamped.xyz[2, 6] == pytest.approx(BRIGHTER * 0.5)
    others = np.ones((4, 9), bool)
    others[2, 6] = False
    np.testing.assert_array_equal(clamped.xyz[others], two_halves().xyz[others])


def test_a_firefly_keeps_its_colour():
    coloured = two_halves()
    coloured.xyz[2, 6] *= np.array([0.5, 1.0, 0.25], np.float32)
    np.testing.assert_allclose(without_fireflies(coloured).xyz[2, 6], [0.5, 1.0, 0.25], rtol=1e-6)


def test_light_that_comes_evenly_is_left_alone(rng):
    light = rng.uniform(0, 1e4, (30, 40)).astype(np.float32)
    np.testing.assert_array_equal(firefly_scale(np.stack([light, light])), 1)
    np.testing.assert_array_equal(firefly_scale(np.zeros((2, 3, 3), np.float32)), 1)


@pytest.mark.parametrize("changed", [{"halves": None}, {"samples": FEWEST_SAMPLES - 1}])
def test_where_chance_cannot_be_told_from_light_nothing_is_clamped(changed):
    whole = dataclasses.replace(two_halves(), **changed)
    assert without_fireflies(whole) is whole


def test_png_is_clamped_and_says_so_and_exr_is_not(tmp_path):
    whole = two_halves()
    path = write_picture(tmp_path / "a.png", whole, SETUP, exposure=1.0, about={"Description": "A stone"})
    with Image.open(path) as image:
        assert image.text["Description"] == "A stone, fireflies clamped in 1 of 36 pixels"
        np.testing.assert_array_equal(image, developed(without_fireflies(whole), SETUP, exposure=1.0))
    even = dataclasses.replace(whole, halves=np.stack([whole.xyz[..., 1]] * 2))
    with Image.open(write_picture(tmp_path / "b.png", even, SETUP, exposure=1.0)) as image:
        assert "Description" not in image.text
    assert read_exr(write_picture(tmp_path / "a.exr", whole, SETUP, exposure=1.0))["Y"][2, 6] == 45.5 * 0.5


@pytest.mark.parametrize("clamp", [False, True])
def test_the_denoiser_takes_no_light_of_what_is_seen(clamp, rng):
    """Of stones, ground and the rest each: light of lonely pixels too, which it would take away."""
    pytest.importorskip("mitsuba_oidn")
    noisy = picture(0.5, 0.2)
    noisy = dataclasses.replace(noisy, **{
        name: np.kron(getattr(noisy, name), np.ones((8, 8, 1) if getattr(noisy, name).ndim == 3 else (8, 8)))
        .astype(getattr(noisy, name).dtype) for name in ("xyz", "albedo", "normal", "coverage", "shows")
    })  # fmt: skip
    halves = noisy.xyz[..., 1] * rng.uniform(0.5, 1.5, (2, *noisy.shows.shape)).astype(np.float32)
    halves[0, 5:30:7, 3:70:7] *= 300
    xyz = np.repeat(halves.mean(axis=0)[..., None], 3, axis=2)
    noisy = dataclasses.replace(noisy, xyz=xyz, halves=halves, samples=FEWEST_SAMPLES)
    given = without_fireflies(noisy) if clamp else noisy
    assert (given is noisy) != clamp
    after = denoised(noisy, clamp=clamp)
    for kind in (Seen.STONE, Seen.GROUND):
        here = noisy.shows == kind
        assert after.xyz[here, 1].mean() == pytest.approx(given.xyz[here, 1].mean(), rel=DENOISED)
        assert after.xyz[here, 1].std() < 0.7 * given.xyz[here, 1].std()


def test_the_denoiser_gets_fireflies_unless_they_are_to_be_clamped():
    pytest.importorskip("mitsuba_oidn")
    whole = two_halves()
    assert denoised(whole).clamped == 0
    assert denoised(whole, clamp=True).clamped == 1
    assert denoised(whole).halves is None

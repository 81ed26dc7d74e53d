"""From linear values to exposure and files: the picture's own part of it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from PIL import Image

from gemrender.errors import InputError
from gemrender.render.develop import EXPOSED_TO
from gemrender.render.finish import PAPER, denoised, developed, exposure_of, write_picture
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
    return Picture(
        xyz=xyz,
        albedo=albedo,
        normal=np.zeros_like(xyz),
        coverage=coverage,
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
    front = Foreground(xyz=alpha[..., None] * own, normal=np.zeros_like(whole.normal), alpha=alpha)
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

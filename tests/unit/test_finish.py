"""From linear values to exposure and files: the picture's own part of it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gemrender.render.develop import EXPOSED_TO
from gemrender.render.finish import PAPER, exposure_of, write_picture
from gemrender.render.photoreal import Picture
from gemrender.scene.setup import Setup, Sky

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


def test_stops_of_the_set_up_and_the_user_add_up():
    setup = dataclasses.replace(SETUP, exposure=1.0)
    assert exposure_of(picture(), setup, ev=2.0) == pytest.approx(8 * exposure_of(picture(), SETUP))


def test_exr_keeps_values_that_no_screen_shows(tmp_path):
    import OpenEXR

    path = write_picture(tmp_path / "a.exr", picture(stone=70.0), SETUP, exposure=0.01)
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    assert channels["Y"].pixels[0, 0] == 70.0
    assert channels["albedo.R"].pixels[0, 4] == np.float32(0.6)

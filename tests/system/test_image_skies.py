"""Skies that are images: their light, their place, and the files of a scene with one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from render_help import read_exr
from thorough import chosen

import gemrender
from gemrender.colorimetry import adapt, white_xyz, xyz_to_linear_srgb
from gemrender.cuts import load_stone
from gemrender.render.photoreal import make_gems, render
from gemrender.scene.bitmaps import another_thread, write_bitmap
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.placing import towards
from gemrender.scene.setup import Box, Camera, Setup, Sky
from gemrender.scene.sky_image import environment
from gemrender.scene.xml import write_photoreal

#: Standard errors that are allowed: so many are passed once in 370 cases, and the seeds are fixed.
STANDARD_ERRORS = 3.0
#: How far Mitsuba's spectra of colours are from the colours, and white's from D65.
UPSAMPLED, WHITE = 4e-3, 2e-4
#: What wavelengths that are drawn evenly leave of chance in the mean of a small picture.
DRAWN = 2e-3
#: What is between even pixels and a sky that goes evenly from one row to the next, of 64 rows.
GRID = 1e-3
#: Degrees that single precision leaves.
ROUNDED = 1e-3

SMALL = {"width": 24, "height": 24, "spp": 64}
STONE = make_gems([load_stone("inoue-3")], material=1.54)


@pytest.fixture
def _spectral(variant_llvm_ad_spectral):
    """Scenes are made for a spectral variant."""


def write(path, pixels):
    import mitsuba as mi

    write_bitmap(mi.Bitmap(np.ascontiguousarray(pixels, dtype=np.float32)), path)
    return str(path)


def around(path, **keys):
    return Setup(
        name="image",
        camera=Camera(type="orthographic", elevation=60),
        sky=Sky(type="image", image=path, **keys),
    )


@pytest.mark.usefixtures("_spectral")
def test_a_white_image_is_the_uniform_sky(tmp_path):
    """A stone in white light all around, seen in an image of it and in the uniform sky: a furnace."""
    image = around(write(tmp_path / "a.exr", np.full((16, 32, 3), 0.25)), scale=4.0)
    uniform = replace(image, sky=Sky(radiance=1.0))
    made = [render(STONE, setup, seed=1, **SMALL).xyz.astype(np.float64) for setup in (image, uniform)]
    assert made[0][..., 1].mean() == pytest.approx(1, abs=DRAWN)
    # The same paths of the same wavelengths: what differs is the spectrum of white alone
    np.testing.assert_allclose(made[0], made[1], atol=5 * WHITE)


@pytest.mark.usefixtures("_spectral")
def test_colours_of_an_image_are_colours_of_the_picture(tmp_path):
    for colour in ([0.9, 0.2, 0.1], [0.1, 0.4, 0.9], [40.0, 35.0, 20.0]):
        image = around(write(tmp_path / "a.exr", np.ones((16, 32, 3)) * colour))
        seen = render(STONE, image, seed=2, **SMALL).xyz.mean(axis=(0, 1), dtype=np.float64)
        rgb = xyz_to_linear_srgb(adapt(seen, white_xyz("d65")))
        np.testing.assert_allclose(rgb, colour, atol=2 * UPSAMPLED * max(colour))


def irradiance_over_pi(pixels):
    """Integral of radiance times the cosine over the upper half, by pi: (3,), of an image's pixels.

    Of a row it is the difference of the squared sines of its elevations, times its mean.
    """
    edges = np.sin(np.radians(90 - 180 * np.arange(len(pixels) // 2 + 1) / len(pixels)))
    share = edges[:-1] ** 2 - edges[1:] ** 2
    return share @ pixels[: len(share)].mean(axis=1, dtype=np.float64)


@pytest.mark.usefixtures("_spectral")
def test_the_ground_gets_the_cosine_integral_of_the_image(rng):
    """A small bright patch, which only sampling by brightness finds, and a dim gradient."""
    import mitsuba as mi

    from gemrender.scene.loading import load_scene

    pixels = np.zeros((64, 128, 3), np.float32)
    pixels[:, :] = np.linspace(0.3, 0.1, 64)[:, None, None]
    pixels[14:16, 40:42] += 900.0
    lit = environment(pixels, azimuth_deg=33.0, scale=1.0, stock=False)
    camera = {
        "type": "orthographic",
        "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]),
        "film": {"type": "hdrfilm", "width": 8, "height": 8},
    }
    paper = {"type": "diffuse", "reflectance": {"type": "uniform", "value": 1.0}}
    scene = load_scene(
        {
            "type": "scene",
            "sky": lit,
            "sensor": camera,
            "ground": {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(9.0), "bsdf": paper},
            "integrator": {"type": "gem_path", "max_depth": 2},
        }
    )
    from gemrender.render.passes import Passes

    found = []
    for seed in range(8):
        passes = Passes(scene, seed=seed)
        passes.add(64)
        found.append(passes.xyz[..., 1].mean(dtype=np.float64))
    error = np.std(found, ddof=1) / math.sqrt(len(found))
    expected = irradiance_over_pi(pixels)[1]
    assert error < 0.01 * expected  # by chance alone the patch would be found once in some 1000 paths
    assert np.mean(found) == pytest.approx(expected, abs=STANDARD_ERRORS * error + GRID * expected)


@pytest.mark.usefixtures("_spectral")
def test_an_image_that_is_turned_turns_the_light():
    """Of one bright pixel the middle of its light is the pixel's, wherever the image's own middle is put."""
    import drjit as dr
    import mitsuba as mi

    pixels = np.zeros((18, 36, 3), np.float32)
    pixels[4, 10] = 1.0  # 10 degrees a pixel: 45 above the horizon, 75 to the left of the middle
    for turn in (0.0, 90.0, -140.0):
        emitter = mi.load_dict(environment(pixels, azimuth_deg=turn, scale=1.0, stock=False))
        azimuth, elevation = (
            a.ravel() for a in np.meshgrid(np.arange(-180, 180, 1.0), np.arange(20, 75, 1.0))
        )
        d = np.stack([towards(e, a) for e, a in zip(elevation, azimuth, strict=True)]).T.astype(np.float32)
        si = dr.zeros(mi.SurfaceInteraction3f, len(azimuth))
        si.wi = -mi.Vector3f(*(mi.Float(row) for row in d))
        si.wavelengths = mi.Spectrum(550.0)
        seen = np.asarray(emitter.eval(si)[0], dtype=np.float64)
        away = (azimuth - 75 - turn + 180) % 360 - 180
        assert (seen * away).sum() / seen.sum() == pytest.approx(0, abs=ROUNDED)
        assert (seen * elevation).sum() / seen.sum() == pytest.approx(45, abs=ROUNDED)
        assert np.abs(away[seen > 1e-6]).max() < 10


@pytest.mark.usefixtures("_spectral")
def test_stone_camera_and_image_turned_together_make_the_same_picture(tmp_path):
    pixels = np.random.default_rng(7).uniform(0, 1, (8, 16, 3)).repeat(4, 0).repeat(4, 1)
    first = around(write(tmp_path / "a.exr", pixels))
    camera = replace(first.camera, azimuth=0.0)
    turned = replace(first, camera=camera, sky=replace(first.sky, azimuth=90.0))
    image_left = replace(first, camera=camera)
    options = {"seed": 3, "width": 12, "height": 12, "spp": 100}
    before = render(STONE, first, **options).xyz
    with_all = render(STONE, turned, turn_deg=90.0, **options).xyz
    without = render(STONE, image_left, turn_deg=90.0, **options).xyz
    away, apart = (np.abs(other - before).mean() for other in (with_all, without))
    assert away < 0.1 * apart


@pytest.mark.parametrize("stock", chosen([False, True], [False]))
def test_a_scene_with_an_image_is_written_whole(tmp_path, stock):
    variant = "llvm_ad_rgb" if stock else "llvm_ad_spectral"
    mi = gemrender.mitsuba(variant)
    box = Box(elevation=60, size=50, radiance=3.0, spectrum=3000)
    setup = Setup(name="x", white=3000, sky=Sky(type="studio", boxes=(box,), radiance=0.2, spectrum=3000))
    scene = photoreal_scene(STONE, setup, width=8, height=8, stock=stock, samples=16)
    path = write_photoreal(tmp_path, "made", scene, about="x", stock=stock)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["made.ply", "made.xml", "made_sky.exr"]
    rgb, _ = read_exr(tmp_path / "made_sky.exr")
    lit = np.stack([rgb[name] for name in "RGB"], axis=2).max(axis=(0, 1))
    if stock:  # white is the set-up's
        np.testing.assert_allclose(lit, 3.0, rtol=1e-3)
    with another_thread():
        loaded = mi.load_file(str(path), optimize=False, parallel=False)
    image = np.asarray(mi.render(loaded, spp=4))
    np.testing.assert_allclose(
        image, np.asarray(mi.render(mi.load_dict(scene.to_dict(), parallel=False), spp=4)), atol=1e-2
    )

"""Skies by zones in pictures: colours that can be counted, zones that stay with the camera, files."""

from __future__ import annotations

import json
import math
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from render_help import MITSUBA, read_exr
from thorough import chosen

import gemrender
from gemrender.colorimetry import adapt, white_xyz, xyz_to_linear_srgb
from gemrender.cuts import load_stone
from gemrender.optics.fresnel import reflectance
from gemrender.render.photoreal import make_gems, render
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.placing import towards
from gemrender.scene.setup import Camera, Setup, Sky, Zone, load_setup
from gemrender.scene.xml import write_photoreal

STONES = Path(__file__).parents[1] / "cases" / "stones"
TRUTH = json.loads((STONES / "truth.json").read_text(encoding="utf-8"))

#: Pictures that a share is the mean of, and how many standard errors of it are allowed: Student's t with so
#: few pictures goes beyond it once in 1500 cases.
PICTURES, STANDARD_ERRORS = 8, 5.5
#: Colours by some hundred thousand wavelengths that are drawn evenly: what there is of them, and is not.
DRAWN, PURE = 5e-4, 2e-5

#: A stone without dispersion, and a picture of an instant.
STONE = make_gems([load_stone("inoue-3")], material=1.54)
SMALL = {"width": 32, "height": 32, "spp": 256}

#: Limits of the zones of an ASET, green, red and blue, as cosines with the viewer's zenith.
LIMITS = [math.sin(math.radians(elevation)) for elevation in (0, 45, 75)]


def rgb_of(picture):
    """Linear sRGB as an EXR has it, (h, w, 3)."""
    return xyz_to_linear_srgb(adapt(picture.xyz, white_xyz("d65"))).astype(np.float64)


def under(*zones, camera=None):
    """Return a set-up of zones, (low, high, colour) each."""
    made = tuple(Zone(elevation=(low, high), colour=colour) for low, high, colour in zones)
    camera = camera or Camera(type="orthographic", elevation=90)
    return Setup(name="test set-up", camera=camera, sky=Sky(type="zones", zones=made))


def seen_shares(stone, index, setup, pictures=PICTURES):
    """Return red, green and blue of the stone's light by its area [%], and their standard errors."""
    shares = []
    for seed in range(pictures):
        gems = make_gems([stone], material=index)
        picture = render(gems, setup, width=48, height=48, spp=64, seed=seed)
        shares.append(100 * rgb_of(picture).sum(axis=(0, 1)) / picture.coverage.sum(dtype=np.float64))
    return np.mean(shares, axis=0), np.std(shares, axis=0, ddof=1) / math.sqrt(pictures)


def mirrored_shares(stone, index, eye=(0.0, 0.0, 1.0)):
    """Return what the surface mirrors to the eye from the zones red, green and blue [%]: closed form.

    A facet shows by its area times the cosine c between its normal and the direction to the eye, mirrors the
    share R(c) of the light, and from a direction whose cosine with the viewer's zenith is 2 c^2 - 1.
    """
    cosine = stone.solid.polyhedron.planes[:, :3] @ eye
    seen = cosine > 0
    cosine, area = cosine[seen], stone.solid.polyhedron.areas[seen] * cosine[seen]
    share = 100 * area * reflectance(cosine, index) / area.sum()
    zone = np.searchsorted(LIMITS, 2 * cosine**2 - 1, side="right")  # 0 is below the horizon
    return np.array([share[zone == k].sum() for k in (2, 1, 3)])


@pytest.mark.parametrize("name", chosen(["emerald", "pear", "round"], ["emerald", "round"]))
def test_zone_shares_of_a_picture_are_those_of_the_weighted_aset(name):
    """The independent values of truth.json for what comes from inside, and the surface's part beside it."""
    truth = TRUTH[name]
    stone, index = load_stone(STONES / truth["file"]), truth["refractive_index"]
    green, red, blue, _ = truth["aset_weighted_internal_green_red_blue_leak"]
    expected = np.add([red, green, blue], mirrored_shares(stone, index))
    found, error = seen_shares(stone, index, load_setup("aset"))
    allowed = STANDARD_ERRORS * error + truth["bounds"]["all_light"]
    assert error.max() < 0.05
    np.testing.assert_array_less(np.abs(found - expected), allowed)


def test_zone_shares_under_a_tilted_camera_are_those_of_the_measure():
    """Zones stay with the viewer, who sees a pear from the side: the measure `aset`, by the exact engine."""
    stone, index = load_stone(STONES / "pear.asc"), TRUTH["pear"]["refractive_index"]
    camera = Camera(type="orthographic", elevation=66, azimuth=130)
    found, error = seen_shares(stone, index, replace(load_setup("aset"), camera=camera))

    score = gemrender.score(
        stone, measures=["aset"], tilt=24, tilt_azimuth=130, index=index, fresnel="exact", bound=0.1
    )
    (aset,) = score.measures
    inside = [aset.values[f"weighted_{colour}"] for colour in ("red", "green", "blue")]
    expected = np.add(inside, mirrored_shares(stone, index, towards(66, 130)))
    np.testing.assert_array_less(np.abs(found - expected), STANDARD_ERRORS * error + aset.bound)
    # Of the view from above they differ by points: the tilt counts
    assert np.abs(found - seen_shares(stone, index, load_setup("aset"), pictures=2)[0]).min() > 1


@pytest.mark.parametrize("colour", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0.25, 0.4)])
def test_light_of_a_colour_from_everywhere_is_that_colour(colour):
    """A stone under it is invisible: what comes out is the light, in the picture's own channels."""
    picture = render(STONE, under((-90, 0, colour), (0, 45, colour), (45, 90, colour)), **SMALL)
    found = rgb_of(picture).mean(axis=(0, 1))
    np.testing.assert_allclose(found, colour, rtol=DRAWN, atol=PURE)


@pytest.mark.parametrize(
    ("elevation", "azimuth"), chosen([(90, -90), (35, 20), (-20, 200)], [(35, 20), (-20, 200)])
)
def test_the_zenith_is_where_the_camera_is(elevation, azimuth):
    """An orthographic camera looks down its own vertical: beside the stone there is the lowest zone alone."""
    camera = Camera(type="orthographic", elevation=elevation, azimuth=azimuth, margin=1.5)
    around = under((-90, -89.9, (0, 1, 0)), (-89.9, 0, (1, 0, 0)), (0, 90, (0, 0, 1)), camera=camera)
    picture = render(STONE, around, **SMALL)
    beside = picture.coverage == 0
    assert beside.sum() > 100
    np.testing.assert_allclose(rgb_of(picture)[beside].mean(axis=0), (0, 1, 0), rtol=DRAWN, atol=PURE)


def test_one_seed_makes_one_picture():
    small = SMALL | {"spp": 8}
    first, again, other = (render(STONE, load_setup("aset"), **small, seed=seed).xyz for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


# ---- Scenes as files -----------------------------------------------------------------------------------


def test_a_scene_of_zones_is_read_back(tmp_path, variant_llvm_ad_spectral):
    import mitsuba as mi

    setup = replace(load_setup("ideal-scope"), camera=Camera(type="orthographic", elevation=60, azimuth=20))
    scene = photoreal_scene(STONE, setup, width=24, height=24)
    read = mi.load_file(str(write_photoreal(tmp_path, "a", scene, about="a", stock=False)))
    (sky,) = read.emitters()
    assert str(sky) == str(mi.load_dict(scene.plain["sky"]))
    assert "edges = [-90, -30, 0, 75]" in str(sky)
    found, given = (dict(mi.traverse(one)) for one in (sky, mi.load_dict(scene.plain["sky"])))
    assert "radiance_3.values" in found
    assert found.keys() == given.keys()
    for key, value in given.items():
        np.testing.assert_array_equal(np.array(found[key]), np.array(value))


RED, GREEN, BLUE = (1, 0, 0), (0, 1, 0), (0, 0, 1)


@pytest.mark.skipif(not MITSUBA.exists(), reason="needs Mitsuba's program")
@pytest.mark.parametrize(
    ("zones", "elevation"),
    [
        ([(-90, 0, GREEN), (0, 60, RED), (60, 90, BLUE)], 55),
        ([(-90, -40, BLUE), (-20, 50, RED), (50, 80, GREEN)], 75),
        ([(-90, -30, BLUE), (-30, 0, RED), (0, 90, GREEN)], 90),
    ],
    ids=["horizon between zones", "horizon within one", "wide ends"],
)
def test_mitsubas_own_plugins_show_the_same_zones(zones, elevation, tmp_path):
    """A far can in place of zones: parallaxes of 1e-4, and the same picture."""
    setup = under(*zones, camera=Camera(type="orthographic", elevation=elevation, azimuth=-60))
    expected = rgb_of(render(STONE, setup, **SMALL))
    scene = photoreal_scene(STONE, setup, width=32, height=32, samples=36, stock=True)
    path = write_photoreal(tmp_path, "a", scene, about="a", stock=True)
    assert "gem_" not in path.read_text(encoding="utf-8")
    command = [str(MITSUBA), "-m", "scalar_rgb", path.name, "-o", "x.exr"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=True, timeout=60)
    channels, _ = read_exr(tmp_path / "x.exr")
    image = np.stack([channels[c] for c in "RGB"], axis=-1)
    np.testing.assert_allclose(image.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), atol=0.01)
    # Pixel by pixel, but for noise, and other filters at edges: nothing is upside down
    assert np.abs(image - expected).mean() < 0.1
    assert np.abs(image[::-1] - expected).mean() > 0.15 or elevation == 90

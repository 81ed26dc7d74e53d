"""Skies that are images or studios: read, drawn, refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gemrender.colorimetry import white_xyz
from gemrender.errors import InputError
from gemrender.scene.setup import Box, Setup, Sky, load_setup
from gemrender.scene.sky_boxes import draw_studio
from gemrender.scene.sky_image import read_sky_image

#: Rows of drawn studios here: half a degree each; and what single precision, and edges of a pixel, come to.
ROWS, SINGLE = 360, 1e-5
EDGE = 0.02


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    """Each test runs in an empty folder of its own."""
    monkeypatch.chdir(tmp_path)


def write_exr(name, pixels, channels="RGB"):
    import OpenEXR

    planes = {c: np.ascontiguousarray(pixels[..., k], dtype=np.float32) for k, c in enumerate(channels)}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, planes).write(name)
    return name


def solid_angles(rows=ROWS):
    """Solid angle of the pixels of each row [sr]."""
    edges = np.cos(np.pi * np.arange(rows + 1) / rows)
    return (edges[:-1] - edges[1:])[:, None] * np.pi / rows


def drawn(*boxes, radiance=0.0, spectrum="d65"):
    return draw_studio(boxes, radiance=radiance, spectrum=spectrum, rows=ROWS)


# ---- Images --------------------------------------------------------------------------------------------


@pytest.fixture(autouse=True)
def _variant(variant_llvm_ad_spectral):
    """Images are read by Mitsuba."""


def test_an_exr_image_is_read_as_it_is(rng):
    pixels = rng.uniform(0, 1e4, (8, 16, 3)).astype(np.float32)
    np.testing.assert_array_equal(read_sky_image(write_exr("a.exr", pixels)), pixels)


def test_a_radiance_file_is_read_to_its_eight_bits(rng):
    import mitsuba as mi

    pixels = rng.uniform(0.5, 1, (8, 16, 3)).astype(np.float32) * np.float32(1e3)
    mi.Bitmap(pixels).write("a.hdr")
    np.testing.assert_allclose(read_sky_image("a.hdr"), pixels, rtol=2**-7)


def test_of_many_channels_red_green_and_blue_count(rng):
    pixels = rng.uniform(0, 1, (8, 16, 7)).astype(np.float32)
    read = read_sky_image(write_exr("a.exr", pixels, "ABXRGZY"))
    np.testing.assert_array_equal(read, pixels[..., [3, 4, 1]])


def test_negative_values_are_black(rng):
    pixels = rng.uniform(-1, 1, (8, 16, 3)).astype(np.float32)
    np.testing.assert_array_equal(read_sky_image(write_exr("a.exr", pixels)), np.maximum(pixels, 0))


def test_a_large_image_is_averaged_down_and_keeps_its_light(monkeypatch):
    kept = 256
    monkeypatch.setattr("gemrender.scene.sky_image.KEPT_COLUMNS", kept)
    pixels = np.zeros((kept, 2 * kept, 3), np.float32)
    pixels[100, 101] = 400.0
    small = read_sky_image(write_exr("a.exr", pixels))
    assert small.shape == (kept // 2, kept, 3)
    assert small[50, 50, 0] == 100.0
    assert small.sum() == 300.0


BAD = np.ones((8, 16, 3), np.float32)
SPOILT = np.where(np.arange(16)[None, :, None] == 3, np.float32(np.nan), BAD)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: "no.exr", "no.exr': cannot be read: No such file"),
        (lambda: str(Path("x").mkdir() or "x"), "'x': cannot be read: Is a directory"),
        (lambda: Path("a.exr").write_bytes(b"no image") and "a.exr", "a.exr': is no image that can be read"),
        (lambda: Path("a.hdr").write_bytes(b"no image") and "a.hdr", "a.hdr': is no image that can be read"),
        (lambda: Path("a.png").write_bytes(b"x") and "a.png", "a.png': must end in .exr or .hdr"),
        (lambda: write_exr("a.exr", BAD[:, :9]), "(9 x 8)': must be twice as wide as high"),
        (lambda: write_exr("a.exr", BAD[:2, :4]), "(4 x 2)': must be twice as wide as high, 8 to "),
        (lambda: write_exr("a.exr", BAD[..., :2], "RG"), "has no channel B"),
        (lambda: write_exr("a.exr", SPOILT), "must hold finite values only"),
        (lambda: write_exr("a.exr", 0 * BAD), "must not be black all over"),
    ],
)
def test_what_is_no_image_of_a_sky_is_refused_in_one_line(make, told):
    with pytest.raises(InputError) as caught:
        read_sky_image(make())
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("sky.image = ")
    assert told in str(caught.value)


def test_a_broken_exr_that_begins_well_is_refused(rng):
    write_exr("a.exr", rng.uniform(0, 1, (64, 128, 3)))
    data = Path("a.exr").read_bytes()
    Path("a.exr").write_bytes(data[: len(data) // 2])
    with pytest.raises(InputError, match="is no image that can be read"):
        read_sky_image("a.exr")


def test_the_image_lies_beside_its_set_up_file():
    Path("sub").mkdir()
    write_exr("sub/a.exr", BAD)
    Path("sub/x.toml").write_text('[sky]\ntype = "image"\nimage = "a.exr"\nazimuth = 30\nscale = 2')
    sky = load_setup("sub/x.toml").sky
    assert sky == Sky(type="image", image=str(Path("sub/a.exr")), azimuth=30, scale=2)
    Path("sub/x.toml").write_text('[sky]\ntype = "image"\nimage = "b.exr"')
    with pytest.raises(InputError) as caught:
        load_setup("sub/x.toml")
    assert str(caught.value) == f"{Path('sub/x.toml')}: sky.image = 'b.exr': no such file"


# ---- Studios -------------------------------------------------------------------------------------------


def test_an_empty_room_is_even_and_of_its_light():
    image = drawn(Box(radiance=0.0, gradient=(0, 0), size=0.1), radiance=0.7, spectrum=4000)
    np.testing.assert_allclose(np.median(image, axis=(0, 1)), 0.7 * white_xyz(4000), rtol=SINGLE)


def test_a_hard_box_covers_the_solid_angle_of_its_sides():
    """Of a rectangle on the plane with half sides a and b: 4 asin(sin a sin b), from its middle."""
    image = drawn(Box(elevation=20, azimuth=70, size=(60, 40), soft=0))
    expected = 4 * np.arcsin(np.sin(np.radians(30)) * np.sin(np.radians(20)))
    # Angles are taken along both sides: the box is that on the plane
    assert (image[..., 1] * solid_angles()).sum() == pytest.approx(expected, rel=EDGE)


def test_a_disc_covers_its_cap_and_lies_where_it_is_said_to():
    image = drawn(Box(shape="disc", elevation=50, azimuth=-110, size=20, soft=0))
    cap = 2 * np.pi * (1 - np.cos(np.radians(10)))
    assert (image[..., 1] * solid_angles()).sum() == pytest.approx(cap, rel=2 * EDGE)
    row, column = np.argwhere(image[..., 1] > 0.5).mean(axis=0)
    assert 90 - (row + 0.5) * 180 / ROWS == pytest.approx(50, abs=0.5)
    assert 180 - (column + 0.5) * 180 / ROWS == pytest.approx(-110, abs=0.5)


def test_a_gradient_runs_from_the_lower_edge_to_the_upper():
    image = drawn(Box(elevation=0, azimuth=0, size=(20, 40), soft=0, gradient=(0.25, 1.0), radiance=4.0))
    column = image[:, ROWS, 1]
    lit = column[column > 0.9]
    assert lit[0] == pytest.approx(4.0, rel=EDGE)
    assert lit[-1] == pytest.approx(1.0, rel=4 * EDGE)
    assert (np.diff(lit[1:-1]) < 0).all()


def test_a_soft_edge_fades_within_its_width():
    image = drawn(Box(elevation=0, azimuth=0, size=40, soft=10))[:, ROWS, 1]
    elevation = 90 - (np.arange(ROWS) + 0.5) * 180 / ROWS
    np.testing.assert_allclose(image[np.abs(elevation) < 9.9], 1, rtol=SINGLE)
    at = image[np.argmin(np.abs(elevation - 15))]
    assert at == pytest.approx(0.5, abs=0.05)
    assert not image[np.abs(elevation) > 20.1].any()


def test_a_later_box_hides_an_earlier_one():
    lit, flag = Box(size=60, radiance=5.0), Box(size=20, radiance=0.0)
    assert drawn(lit, flag)[ROWS // 4, ROWS, 1] == 0
    assert drawn(flag, lit)[ROWS // 4, ROWS, 1] == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("sky", "told"),
    [
        ('type = "studio"', "sky.boxes: missing; must be 1 to 64 tables"),
        ('type = "studio"\nboxes = 3', "sky.boxes = 3: must be 1 to 64 tables"),
        ('type = "studio"\nboxes = [{ size = 200 }]', "boxes 1.size = 200: must be one or two numbers"),
        ('type = "studio"\nboxes = [{ gradient = 1 }]', "boxes 1.gradient = 1: must be two numbers"),
        ('type = "studio"\nboxes = [{ sise = 2 }]', "boxes 1.sise = 2: unknown key"),
        ('type = "image"', "sky.image: missing; must be the path of an image"),
        ('type = "image"\nimage = "a.exr"\nradiance = 2', "sky.radiance = 2: is for type = "),
        ('radiance = 1\nscale = 2', 'sky.scale = 2: is for type = "image" or "studio"'),
        ('radiance = 1\nboxes = [{ size = 2 }]', 'are for type = "studio"'),
        ('type = "image"\nimage = 3', "sky.image = 3: must be text, in one line"),
        ('type = "image"\nimage = "a.exr"\nscale = nan', "sky.scale = nan: must be a number from 0 to 1e+06"),
    ],
)  # fmt: skip
def test_a_sky_that_is_none_is_refused(sky, told):
    write_exr("a.exr", BAD)
    Path("x.toml").write_text(f"[sky]\n{sky}\n")
    with pytest.raises(InputError) as caught:
        load_setup("x.toml")
    assert told in str(caught.value)


@pytest.mark.parametrize(
    "sky",
    [
        Sky(type="image", image="a.exr", scale=0),
        Sky(type="studio", boxes=(Box(radiance=0.0),)),
        Sky(type="studio", boxes=(Box(),), radiance=1.0, scale=0),
    ],
)
def test_a_sky_without_light_needs_another(sky):
    assert sky.is_dark
    with pytest.raises(InputError, match="needs a light or a sky"):
        Setup(name="dark", sky=sky)
    assert not Sky(type="studio", boxes=(Box(radiance=0.0),), radiance=0.1).is_dark

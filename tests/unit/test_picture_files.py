"""Files of pictures: what is written reads back, and what cannot be written is refused."""

from __future__ import annotations

import numpy as np
import OpenEXR
import pytest
from matplotlib.image import imread
from refusals import refused

import gemrender
from gemrender.render.picture_files import SPECTRAL_ATTRIBUTES, spectral_channel, write_exr, write_png


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

"""Files of an observation: the EXR holds every map exactly, the PNG shows every pixel, both come whole."""

from __future__ import annotations

import itertools
import json
import os
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from displays_help import assert_within
from matplotlib.image import imread
from observations import STONE, observation

import gemrender
from gemrender.colorimetry import colour_science
from gemrender.cuts import stone_from_vertices
from gemrender.cuts.files import LONGEST_NAME
from gemrender.errors import InputError
from gemrender.observation import MAP_CHANNELS, MAP_TYPES, PATH_CODE_MASK, RayStatus
from gemrender.report import figures
from gemrender.report.files import file_stems, prepare_folder, write_exr, write_observation
from gemrender.scene.bitmaps import read_bitmap
from gemrender.scoring import BAND_EDGES, score_observation

colour = colour_science()

#: Least difference of two colours of the picture (CIEDE2000), for eyes with and without colour blindness:
#: about ten just noticeable differences, told apart without looking twice.
LEAST_COLOUR_DIFFERENCE = 10

N = 16


def random_observation(rng):
    """Return an observation with all statuses, and maps that reach the limits of their types."""
    status = rng.integers(0, 4, (N, N))
    maps = {
        "primary_intensity": rng.uniform(0, 100, (N, N)),
        "rear_mask": rng.integers(0, 2, (N, N)),
        "reflections": rng.integers(0, 1001, (N, N)),
        "exit_point": rng.normal(size=(N, N, 3)),
        "exit_direction": rng.normal(size=(N, N, 3)),
        "entry_facet": rng.integers(-1, 58, (N, N)),
        "exit_facet": rng.integers(-1, 58, (N, N)),
        "path_code": rng.integers(PATH_CODE_MASK - 99, PATH_CODE_MASK + 1, (N, N)),
    }
    return observation(status, **maps)


def channels(observed):
    """Each channel's name, and what it should hold."""
    for name, names in MAP_CHANNELS.items():
        parts = np.moveaxis(np.atleast_3d(getattr(observed, name)), -1, 0)
        yield from zip(names, parts, strict=True)


# ---- EXR -----------------------------------------------------------------------------------------------


def test_every_map_has_a_channel():
    assert list(MAP_CHANNELS) == list(MAP_TYPES)


def test_openexr_reads_every_map_back_exactly(rng, tmp_path):
    observed = random_observation(rng)
    write_exr(observed, tmp_path / "map.exr")
    read = OpenEXR.File(str(tmp_path / "map.exr"), separate_channels=True).channels()
    assert {"primary.intensity", "rear.mask", "coverage"} < set(read)
    assert len(read) == sum(len(names) for names in MAP_CHANNELS.values())
    for name, values in channels(observed):
        assert read[name].pixels.dtype == np.float32
        np.testing.assert_array_equal(read[name].pixels, values, err_msg=name)


def test_mitsuba_reads_every_map_back_exactly(rng, tmp_path, variant_llvm_ad_mono):
    observed = random_observation(rng)
    write_exr(observed, tmp_path / "map.exr")
    bitmap = read_bitmap(tmp_path / "map.exr")
    names = [field.name for field in bitmap.struct_()]
    pixels = np.asarray(bitmap)
    assert pixels.dtype == np.float32
    for name, values in channels(observed):
        np.testing.assert_array_equal(pixels[..., names.index(name)], values, err_msg=name)


def test_attributes_say_what_the_maps_are(tmp_path):
    observed = observation(resolution=4)
    write_exr(observed, tmp_path / "map.exr")
    header = OpenEXR.File(str(tmp_path / "map.exr")).header()
    assert header["stone"] == "Inoue sample 3"
    assert json.loads(header["proportions"])["crown_height"] == 15.7
    assert (header["engine"], header["gemrender.version"]) == ("reference", gemrender.__version__)
    known = json.loads(header["gemrender"])
    np.testing.assert_array_equal(known["vertices"], STONE.vertices)
    assert known["model"]["fresnel"] == "gubelin"
    assert known["view"]["resolution"] == 4
    assert known["score"] == score_observation(observed).to_dict()
    np.testing.assert_array_equal(known["planes"], STONE.solid.planes)
    assert [facet["name"] for facet in known["facets"]] == list(STONE.facet_names)
    assert (known["plane_facet"], known["is_round"]) == (list(range(57)), True)


def test_a_measured_stone_has_no_proportions(tmp_path):
    stone = stone_from_vertices(STONE.vertices, name="石 «measured»")
    write_exr(observation(resolution=2, stone=stone), tmp_path / "map.exr")
    header = OpenEXR.File(str(tmp_path / "map.exr")).header()
    assert (header["stone"], header["proportions"]) == ("石 «measured»", "null")


# ---- PNG -----------------------------------------------------------------------------------------------

COLOURS = {
    **dict(zip(BAND_EDGES, figures.BAND_COLOURS, strict=True)),
    "rear": figures.REAR_COLOUR,
    "unsolved": figures.UNSOLVED_COLOUR,
    "outside": figures.OUTSIDE_COLOUR,
}


def rgb(colour_name):
    return list(bytes.fromhex(COLOURS[colour_name][1:]))


def drawn(observed):
    """Return the picture's one pixel."""
    return figures.map_picture(observed)[0, 0].tolist()


@pytest.mark.parametrize("edge", BAND_EDGES)
def test_a_pixel_has_the_colour_of_its_band(edge):
    assert drawn(observation(resolution=1, primary_intensity=edge)) == rgb(edge)


@pytest.mark.parametrize(
    ("maps", "name"),
    [
        ({"rear_mask": 1}, "rear"),
        ({"status": RayStatus.TRAPPED}, "unsolved"),
        ({"status": RayStatus.LOST}, "unsolved"),
        ({"status": RayStatus.MISSED}, "outside"),
    ],
)
def test_what_is_not_lit_has_a_colour_of_its_own(maps, name):
    assert drawn(observation(resolution=1, **maps)) == rgb(name)


@pytest.mark.parametrize(("resolution", "side"), [(1, 8), (5, 10), (8, 8), (16, 16), (17, 9), (40, 14)])
def test_the_picture_is_of_a_size_to_look_at(resolution, side, monkeypatch):
    monkeypatch.setattr(figures, "MAP_PIXELS", (8, 16))
    assert figures.map_picture(observation(resolution=resolution)).shape == (side, side, 3)


def test_a_small_map_is_enlarged_without_a_blur(monkeypatch):
    monkeypatch.setattr(figures, "MAP_PIXELS", (6, 12))
    picture = figures.map_picture(observation(resolution=2, primary_intensity=[[80, 10], [50, 20]]))
    expected = np.array([[rgb(75), rgb(0)], [rgb(45), rgb(15)]])
    np.testing.assert_array_equal(picture, expected.repeat(3, axis=0).repeat(3, axis=1))


def test_a_large_map_is_reduced_to_the_mean_colour(monkeypatch):
    """Three pixels in each direction make one; what the last ones lack is outside."""
    monkeypatch.setattr(figures, "MAP_PIXELS", (1, 2))
    picture = figures.map_picture(observation(resolution=5, primary_intensity=80))
    whole, bright = np.array(rgb("outside")), np.array(rgb(75))
    covered = np.outer([1, 2 / 3], [1, 2 / 3])[..., None]
    np.testing.assert_array_equal(picture, np.rint(covered * bright + (1 - covered) * whole))


def test_the_png_shows_the_map_pixel_by_pixel(tmp_path):
    """Saved and read again, the picture is in the file to the last bit: nothing resampled it."""
    side = 801
    column, row = np.meshgrid(np.arange(side), np.arange(side))
    observed = observation(resolution=side, primary_intensity=(column * 7 + row * 13) % 100)
    figures.write_map_figure(observed, tmp_path / "map.png")
    page = np.rint(255 * imread(tmp_path / "map.png")[..., :3]).astype(int)
    # Where the map's scales are drawn around it
    box = figures.map_figure(observed).axes[0].get_window_extent()
    left, bottom = round(box.x0), len(page) - round(box.y0)
    np.testing.assert_array_equal(
        page[bottom - side : bottom, left : left + side], figures.map_picture(observed)
    )


@pytest.mark.filterwarnings("ignore:.*simulation of tritanomaly")
@pytest.mark.parametrize("anomaly", [None, "Protanomaly", "Deuteranomaly", "Tritanomaly"])
def test_colours_are_apart_for_every_eye(anomaly):
    """By the simulation of Machado, Oliveira and Fernandes (2009), at full severity."""
    linear = colour.cctf_decoding(np.array([rgb(name) for name in COLOURS]) / 255)
    if anomaly:
        linear = np.clip(linear @ colour.blindness.matrix_cvd_Machado2009(anomaly, 1.0).T, 0, 1)
    lab = colour.XYZ_to_Lab(colour.RGB_to_XYZ(linear, "sRGB"))
    differences = [colour.delta_E(a, b, method="CIE 2000") for a, b in itertools.combinations(lab, 2)]
    assert min(differences) > LEAST_COLOUR_DIFFERENCE


@pytest.mark.parametrize(
    "name",
    ["W" * LONGEST_NAME, "石" * LONGEST_NAME, "a word " * 14, r"$\frac$ [/] {0} % <b>", "a\nb"],
    ids=["long", "wide", "words", "markup", "lines"],
)
def test_any_name_stays_on_the_page(name):
    stone = stone_from_vertices(STONE.vertices, name=name)
    assert_within(figures.map_figure(observation(resolution=2, stone=stone)))


def test_the_fullest_panel_stays_on_the_page_and_apart():
    status = np.full((N, N), RayStatus.TRAPPED)
    status[0, :2] = RayStatus.LOST, RayStatus.EXITED
    figure = figures.map_figure(observation(status, rear_mask=status == RayStatus.EXITED))
    assert_within(figure)
    panel = figure.axes[1]
    renderer = figure.canvas.get_renderer()
    boxes = [text.get_window_extent(renderer) for text in panel.texts]
    for first, second in itertools.combinations(boxes, 2):
        assert not first.overlaps(second)


# ---- Files and folders ---------------------------------------------------------------------------------


def test_both_files_are_written_and_nothing_else(tmp_path):
    written = write_observation(observation(resolution=4), tmp_path, "stone")
    assert written == [tmp_path / "stone.exr", tmp_path / "stone.png"]
    assert sorted(tmp_path.iterdir()) == written


def test_files_have_the_rights_that_the_user_gives_to_files(tmp_path):
    mask = os.umask(0o027)
    try:
        written = write_observation(observation(resolution=4), tmp_path, "stone")
    finally:
        os.umask(mask)
    assert [path.stat().st_mode & 0o777 for path in written] == [0o640, 0o640]


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), RuntimeError("disk full")])
def test_a_failure_leaves_what_was_there(error, tmp_path, monkeypatch):
    def fail(observed: object, path: Path) -> None:
        path.write_bytes(b"half")
        raise error

    (tmp_path / "stone.exr").write_text("old")
    monkeypatch.setattr(figures, "write_map_figure", fail)
    with pytest.raises(InputError, match=r"stone\.png: cannot be written: (No space left|disk full)"):
        write_observation(observation(resolution=4), tmp_path, "stone")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("stone.exr", "old")]


def test_an_interruption_leaves_nothing(tmp_path, monkeypatch):
    def interrupt(observed: object, path: Path) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(figures, "write_map_figure", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_observation(observation(resolution=4), tmp_path, "stone")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_the_place_of_a_file_is_told(tmp_path):
    (tmp_path / "stone.exr").mkdir()
    with pytest.raises(InputError, match=r"stone\.exr: cannot be written: Is a directory"):
        write_observation(observation(resolution=4), tmp_path, "stone")
    assert [path.name for path in tmp_path.iterdir()] == ["stone.exr"]


def test_a_link_to_a_folder_that_is_not_there_has_it_made(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "far" / "away")
    assert prepare_folder(tmp_path / "link") == tmp_path / "link"
    assert (tmp_path / "far" / "away").is_dir()


def test_a_folder_is_made_with_its_parents(tmp_path):
    folder = prepare_folder(tmp_path / "a" / "ü 石")
    assert folder.is_dir()
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("folder", "reason"),
    [
        ("", "has no name"),
        (" ", "has no name"),
        ("file", "is a file"),
        ("file/below", "Not a directory"),
        ("/proc/gemrender", "No such file or directory"),
        ("a\0b", "embedded null"),
        ("\udcff", "its name is not valid Unicode"),
        ("x" * 300, "File name too long"),
    ],
)
def test_no_folder_is_told_by_its_reason(folder, reason, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("")
    with pytest.raises(InputError, match=f"^out = .*: must be a folder that can be written: {reason}"):
        prepare_folder(folder)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize(
    ("names", "stems"),
    [
        (["inoue-1", "inoue-1", "inoue-1"], ["inoue-1", "inoue-1-2", "inoue-1-3"]),
        (["a.toml", "b/a.csv", "a-2"], ["a", "a-2", "a-2-2"]),
        (["pear.asc", "pear.GEM", "pear.gcs", "x.stl"], ["pear", "pear-2", "pear-3", "x"]),
        (["A.TOML", "a.toml"], ["a", "a-2"]),  # one file where capitals do not count
        (["../../etc/pass wd.toml"], ["pass-wd"]),
        (["cut v1.2.toml"], ["cut-v1.2"]),
        ([".hidden", "-x", "...", "", "/"], ["hidden", "x", "stone", "stone-2", "stone-3"]),
        (["石 №1.toml"], ["石-1"]),
        (["e\u0301.toml", "\u00e9.toml"], ["\u00e9", "\u00e9-2"]),  # one file where accents are normalised
        (["石" * 100], ["石" * 66]),  # 3 bytes each
        (["a\udcffb"], ["a-b"]),
    ],
)
def test_stems_are_safe_and_unique(names, stems):
    assert file_stems(names) == stems

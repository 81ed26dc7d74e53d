"""Maps of measures: every pixel has all of its light, by every engine, and files tell what it is."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from displays_help import assert_within
from exact_tolerances import SAME_PATH
from matplotlib.image import imread
from observations import STONE

import gemrender
from gemrender import cli
from gemrender.cuts.files import LONGEST_NAME
from gemrender.errors import InputError
from gemrender.mapping import score_with_maps
from gemrender.measures import Light, Measure, evaluate
from gemrender.observation import View
from gemrender.report.figures import colour_numbers
from gemrender.report.measure_maps import (
    ZONE_COLOURS,
    measure_map_figure,
    measure_map_picture,
    write_measure_maps,
)

PEAR = gemrender.load_stone(Path(__file__).parents[1] / "cases" / "stones" / "pear.asc")
#: Channels of `aset` that make all light, and those that make all of the principal light.
ALL = ("weighted_green", "weighted_red", "weighted_blue", "weighted_leak", "surface", "rest")
PRINCIPAL = ("green", "red", "blue", "leak", "trapped")
#: Light of a pixel beside the whole, of maps in single precision: their rounding, of six numbers of a hundred
#: and less [%].
WHOLE_SINGLE = 6 * 100.0 * 2.0**-24
#: Values of maps of 96 x 96 beside exact ones [%]: `exact_tolerances.SAMPLING_256`, of steps 2.7 times as
#: wide: 2.7^1.5 = 4.4 times.
SAMPLING_96 = 4.4 * 0.25
#: Light of a pixel by the exact engine beside the reference's, where polygons end at 1e-5 of the view and one
#: random ray goes on [%]: of all but a few pixels.
RANDOM_REST, FEW = 5.0, 0.03


class Everything(Measure):
    """A measure of one's own: all of the light that comes from the stone's inside."""

    name, definition, source = "everything", "all light", "this test"

    def contributions(self, light):
        return light.share


def maps_of(stone, measures="aset,iso", **options):
    return gemrender.measure_maps(stone, measures=measures, **{"resolution": 64, **options})


def total(maps, names):
    """Sum channels of `aset` at each pixel that met the stone [%]."""
    channels = maps.channels()
    return sum(channels[f"aset.{name}"].astype(float) for name in names)[maps.coverage > 0]


# ---- Light ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("tilt", [0.0, 30.0])
@pytest.mark.parametrize("stone", [STONE, PEAR], ids=["round", "pear"])
def test_every_pixel_has_all_of_its_light(stone, tilt):
    view = View.of(stone, 48, tilt_deg=tilt, tilt_azimuth_deg=20.0)
    maps = gemrender.measure_maps(stone, measures="aset", view=view)
    for names in (ALL, PRINCIPAL):
        np.testing.assert_allclose(total(maps, names), 100.0, rtol=0, atol=WHOLE_SINGLE)
    observed = gemrender.observe(stone, view=view, engine="reference")
    np.testing.assert_array_equal(maps.coverage > 0, observed.coverage > 0)


@pytest.mark.parametrize("engine", ["exact", "reference", "mitsuba"])
def test_all_engines_make_whole_maps(engine, variant_llvm_ad_mono):
    maps = maps_of(STONE, engine=engine, tilt=20.0)
    assert (maps.engine, maps["aset"].shape, maps["aset"].dtype) == (engine, (64, 64, 13), np.float32)
    for names in (ALL, PRINCIPAL):
        np.testing.assert_allclose(total(maps, names), 100.0, rtol=0, atol=WHOLE_SINGLE)
    assert not maps["aset"][maps.coverage == 0].any()


def test_each_pixel_is_the_reference_s():
    exact, reference = maps_of(PEAR), maps_of(PEAR, engine="reference")
    met = reference.coverage > 0
    same = (exact["aset"][met, :5] == reference["aset"][met, :5]).all(axis=-1)
    assert 100.0 * same.mean() >= SAME_PATH
    apart = np.abs(exact["iso"] - reference["iso"])[met]
    assert (apart > RANDOM_REST).mean() <= FEW


@pytest.mark.parametrize("stone", [STONE, PEAR], ids=["round", "pear"])
def test_the_mean_over_the_pixels_is_the_exact_value(stone):
    maps = maps_of(stone, "aset,iso,inoue,window,extinction", resolution=96)
    for of in gemrender.score(stone, measures=maps.measures).measures:
        for key, value in of.values.items():
            assert maps.values[of.name][key] == pytest.approx(value, abs=SAMPLING_96), (of.name, key)
    mean = maps["iso"][maps.coverage > 0][:, 0].mean(dtype=float)
    assert mean == pytest.approx(maps.values["iso"]["value"], rel=1e-6)


@pytest.mark.parametrize("engine", ["reference", "mitsuba"])
def test_values_are_those_of_the_pixels_paths(engine, variant_llvm_ad_mono):
    maps = maps_of(STONE, "aset,gemray-iso,dispersion", engine=engine, resolution=24)
    paths = gemrender.trace_paths(STONE, follow="all", view=maps.view, engine=engine)
    values = evaluate([Light(paths=paths, view=maps.view, model=maps.model)], maps.measures)
    for name, expected in values.items():
        assert maps.values[name] == pytest.approx(expected, rel=1e-9, nan_ok=True)


def test_a_score_by_pixels_is_the_same_with_maps():
    options = {"measures": "iso,facets", "engine": "reference", "resolution": 16}
    scored = gemrender.score(STONE, **options)
    with_maps, _, maps = score_with_maps(STONE, **options)
    assert [of.to_dict() for of in with_maps.measures] == [of.to_dict() for of in scored.measures]
    assert (with_maps.average, list(maps.maps)) == (scored.average, ["iso"])


def test_the_exact_score_is_the_same_with_maps():
    options = {"measures": "all", "bound": 1.0, "engine": "exact"}
    scored = gemrender.score(STONE, **options)
    with_maps, observation, maps = score_with_maps(STONE, resolution=24, **options)
    assert [of.to_dict() for of in with_maps.measures] == [of.to_dict() for of in scored.measures]
    assert (with_maps.average, with_maps.bound) == (scored.average, scored.bound)
    assert {"wlr-like", "facets"}.isdisjoint(maps.maps)
    plain = gemrender.observe(STONE, resolution=24, bound=1.0)
    np.testing.assert_array_equal(observation.path_code, plain.path_code)


def test_principal_light_needs_no_random_ray():
    first, second = (maps_of(STONE, "window,extinction,inoue", seed=seed) for seed in (1, 2))
    for name in first.maps:
        np.testing.assert_array_equal(first[name], second[name])


def test_the_seed_says_where_single_rays_go():
    first, again, other = (maps_of(STONE, "iso", seed=seed)["iso"] for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_a_measure_of_ones_own_has_a_map():
    maps = maps_of(PEAR, [Everything(), "aset"])
    inside = total(maps, ALL) - total(maps, ("surface", "rest"))
    np.testing.assert_allclose(maps["everything"][maps.coverage > 0][:, 0], inside, atol=2 * WHOLE_SINGLE)


@pytest.mark.parametrize(
    ("measures", "words"),
    [
        ("wlr-like", "measures = 'wlr-like': has no map: it is a sum over views"),
        ("iso,facets", "measures = 'facets': has no map: it counts virtual facets"),
        ("asset", "measures = 'asset': must be one of inoue, iso, "),
    ],
)
def test_no_map_is_one_line(measures, words):
    with pytest.raises(InputError) as caught:
        maps_of(STONE, measures)
    assert str(caught.value).startswith(words)


def test_a_map_without_the_stone_is_refused():
    with pytest.raises(InputError, match="must be larger, no ray met the stone"):
        maps_of(STONE, resolution=2, tilt=85.0)


# ---- Files ---------------------------------------------------------------------------------------------


def test_the_exr_has_every_channel_and_says_what_it_is(tmp_path):
    maps = maps_of(PEAR, "aset,iso,dispersion", resolution=16, head=12.0)
    write_measure_maps(maps, tmp_path, "pear", formats=())
    with OpenEXR.File(str(tmp_path / "pear-measures.exr"), separate_channels=True) as file:
        header, channels = file.header(), file.channels()
        assert set(channels) == {"coverage", *maps.channels()}
        assert {"aset.green", "aset.weighted_red", "iso.surface", "dispersion.angle"} <= set(channels)
        for name, values in maps.channels().items():
            np.testing.assert_array_equal(channels[name].pixels, values)
        known = json.loads(header["gemrender"])
        assert header["stone"] == "pear"
        assert header["engine"] == "exact"
        assert header["cut"] == type(PEAR.cut).__name__
        assert header["gemrender.version"] == gemrender.__version__
        assert json.loads(header["measures"]) == {"aset": 1, "iso": 1, "dispersion": 1}
    assert known["head_deg"] == 12.0
    assert known["measures"]["iso"]["values"] == maps.values["iso"]
    assert known["measures"]["dispersion"]["values"] == {"value": None, "weighted": None}  # no JSON has NaN


def test_pixels_have_the_colours_of_their_zones():
    maps = maps_of(PEAR)
    principal, _ = measure_map_picture(maps, "aset")
    step = len(principal) // 64
    picture, colours = principal[::step, ::step], colour_numbers(*ZONE_COLOURS.values())
    for name, colour in zip(ZONE_COLOURS, colours, strict=True):
        is_zone = (picture == colour).all(axis=-1)
        np.testing.assert_array_equal(is_zone, maps.channels()[f"aset.{name}"] > 0)
    assert (picture[maps.coverage == 0] == 255).all()


def test_light_is_on_a_scale_from_black_to_white():
    maps = maps_of(PEAR, "iso")
    (picture,) = measure_map_picture(maps, "iso")
    step = len(picture) // 64
    met = maps.coverage > 0
    expected = np.clip(maps["iso"][met][:, 0] / 100.0, 0.0, 1.0) * 255.0
    assert np.abs(picture[::step, ::step][met][:, 0] - expected).max() <= 1.0


def test_what_has_no_value_is_on_no_scale():
    """The index 1.54 is no material's whose dispersion is known."""
    maps = maps_of(PEAR, "dispersion", resolution=16)
    (picture,) = measure_map_picture(maps, "dispersion")
    colours = picture.astype(int) @ [1 << 16, 1 << 8, 1]
    assert len(np.unique(colours)) == 2  # within the outline, and outside


def test_every_kind_of_measure_has_a_picture(tmp_path):
    maps = maps_of(STONE, ["inoue", "aset", Everything()], resolution=16)
    written = write_measure_maps(maps, tmp_path, "round")
    assert [path.name for path in written] == [
        *(f"round-map-{measure.name}.png" for measure in maps.measures), "round-measures.exr",
    ]  # fmt: skip
    for path in written[:-1]:
        assert imread(path).shape[0] > 800


@cache
def maps_of_all():
    return maps_of(PEAR, "all", resolution=4, tilt=12.5, engine="mitsuba")


@pytest.mark.parametrize("name", ["pear", "W" * LONGEST_NAME])
def test_everything_stays_on_the_page(name, variant_llvm_ad_mono):
    maps = replace(maps_of_all(), stone=replace(PEAR, name=name))
    for measure in ("aset", "gemray-sc2", "dispersion") if name == "pear" else ("aset",):
        assert_within(measure_map_figure(maps, measure))


def test_a_name_of_ones_own_is_safe_in_a_file_s(tmp_path):
    measure = Everything()
    measure.name = "all/inside"
    written = write_measure_maps(maps_of(PEAR, [measure], resolution=8), tmp_path, "pear")
    assert written[0].name == "pear-map-inside.png"


def test_the_same_picture_is_the_same_file(tmp_path):
    maps = maps_of(STONE, "iso", resolution=16)
    files = [write_measure_maps(maps, tmp_path, stem)[0].read_bytes() for stem in ("a", "b")]
    assert files[0] == files[1]


# ---- The command line ----------------------------------------------------------------------------------


def run(*arguments):
    with pytest.raises(SystemExit) as caught:
        cli.main(list(arguments))
    return caught.value.code


def test_show_writes_the_maps_of_measures(tmp_path):
    options = ["--measure", "aset", "--measure", "iso", "--resolution", "16", "--head", "8"]
    assert run("show", "inoue-3", "--what", "map", *options, "-o", str(tmp_path)) == 0
    assert {path.name for path in tmp_path.iterdir()} == {
        "inoue-3-map-aset.png", "inoue-3-map-iso.png", "inoue-3-measures.exr",
    }  # fmt: skip
    with OpenEXR.File(str(tmp_path / "inoue-3-measures.exr")) as file:
        assert json.loads(file.header()["gemrender"])["head_deg"] == 8.0


def test_score_writes_the_maps_of_measures_beside_the_paper_s(tmp_path, capsys):
    command = ["score", "inoue-3", "--measures", "iso,facets", "--resolution", "16", "--json"]
    assert run(*command) == 0
    (plain,) = json.loads(capsys.readouterr().out)
    assert run(*command, "-o", str(tmp_path)) == 0
    (with_maps,) = json.loads(capsys.readouterr().out)
    assert {path.name for path in tmp_path.iterdir()} == {
        "inoue-3.exr", "inoue-3.png", "inoue-3-map-iso.png", "inoue-3-measures.exr",
    }  # fmt: skip
    assert plain | {"seconds": 0} == with_maps | {"seconds": 0}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("--what map --measure asset", "--measure = 'asset': must be one of inoue, iso, "),
        ("--what map --measure wlr-like", "--measure = 'wlr-like': has no map: it is a sum over views"),
        ("--what outline --measure iso", "--measure = 'iso': is for the map: --what map"),
        ("--what map --measure iso --head 90", "--head = 90.0: must be from 0 to below 90 [deg]"),
    ],
)
def test_bad_input_is_one_line(arguments, words, tmp_path, capsys):
    assert run("show", "inoue-3", *arguments.split(), "-o", str(tmp_path / "maps")) == 2
    err = capsys.readouterr().err
    assert err.startswith(f"gemrender: {words}")
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())

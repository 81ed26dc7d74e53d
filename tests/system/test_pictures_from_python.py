"""`gemrender.render`: the picture of the command, bit for bit, as arrays, files and in notebooks."""

from __future__ import annotations

import inspect
import json
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest
from render_help import CHANNELS, read_exr, read_png

import gemrender
from gemrender.render import photoreal
from gemrender.render.shots import picture_size
from gemrender.scene.setup import Setup, Sky

SETUP, OPTIONS = "hemisphere", {"size": 32, "spp": 8}


@pytest.fixture(scope="module")
def picture():
    return gemrender.render("inoue-3", SETUP, **OPTIONS, bins=4, seed=3, material="ruby", curve="linear")


def test_it_is_what_the_command_writes(picture, render):
    words = ["--setup", SETUP, "--size", 32, "--spp", 8, "--seed", 3, "--material", "ruby"]
    render("inoue-3", "-o", "command.exr", *words, "--bins", 4)
    render("inoue-3", "-o", "command.png", *words, "--curve", "linear")
    for suffix in (".exr", ".png"):
        saved = picture.save(f"python{suffix}")
        assert saved == Path(f"python{suffix}")
        assert saved.read_bytes() == Path(f"command{suffix}").read_bytes()


def test_it_takes_what_the_command_takes():
    """All options by their names, but those that are of films and of files alone."""
    from typer.main import get_command

    from gemrender.cli.program import app

    command = get_command(app).commands["render"]
    of_others = {"out", "frames", "fps", "move", "to", "help"}
    named = {max(option.opts, key=len).removeprefix("--").replace("-", "_") for option in command.params}
    options = named - of_others - {"stones"} | {"stone"}
    taken = set(inspect.signature(gemrender.render).parameters)
    assert taken == options | {"on_pass", "progress"}
    assert of_others - {"out", "help"} < set(inspect.signature(gemrender.render_film).parameters)


def test_a_setting_is_that_of_the_command(folder, render):
    # Under an even sky: without what is traced from lights
    Path("sky.toml").write_text("[sky]\nradiance = 1\n")
    words = {"setting": "bezel", "metal": "gold", "girdle": "bruted"}
    shown = gemrender.render("inoue-3", "sky.toml", **OPTIONS, **words)
    render("inoue-3", "-o", "command.png", "--setup", "sky.toml", "--size", 32, "--spp", 8,
           *(text for key, word in words.items() for text in (f"--{key}", word)))  # fmt: skip
    assert shown.save("python.png").read_bytes() == Path("command.png").read_bytes()
    assert (shown.setup.setting.type, shown.setup.setting.metal, shown.setup.girdle) == (*words.values(),)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"metal": "gold"}, "metal = 'gold': is for a setting; give one too, as solitaire"),
        (
            {"metal": "gold", "setting": "none"},
            "metal = 'gold': is for a setting; give one too, as solitaire",
        ),
        ({"setting": "bezel", "setup": "hemisphere"}, "setting = 'bezel': must be none in a cup"),
        (
            {"setting": "bezel", "setup": "down"},
            "setting = 'bezel': must be none where stones lie table-down",
        ),
    ],
    ids=str,
)
def test_settings_that_cannot_be_are_refused_before_any_work(options, told, monkeypatch, folder):
    monkeypatch.setattr(photoreal, "render", lambda *_, **__: pytest.fail("told before any work"))
    if options.get("setup") == "down":
        options = options | {"setup": Setup(name="down", pose="table-down", sky=Sky(radiance=1.0))}
    with pytest.raises(gemrender.InputError) as caught:
        gemrender.render("inoue-3", **options)
    assert str(caught.value) == told
    with pytest.raises(gemrender.InputError) as caught:
        gemrender.render_film("inoue-3", "a.webp", frames=2, **options)
    assert str(caught.value) == told


def test_its_arrays_are_what_its_file_holds(picture, folder):
    channels, header = read_exr(picture.save("a.exr"))
    for k, name in enumerate("XYZ"):
        np.testing.assert_array_equal(channels[name], picture.xyz[..., k])
        np.testing.assert_array_equal(channels[f"normal.{name}"], picture.normal[..., k])
    np.testing.assert_array_equal(channels["coverage"], picture.coverage)
    assert picture.spectrum.shape == (32, 32, 4)
    bins = [name for name in channels if name not in CHANNELS]
    np.testing.assert_array_equal(np.dstack([channels[b] for b in sorted(bins)]), picture.spectrum)
    assert header["Title"] == picture.title == "Inoue sample 3 (ruby)"


def test_a_notebook_shows_what_is_saved(picture, folder):
    shown = picture._repr_png_()
    assert shown == picture.save("a.png").read_bytes()
    pixels, texts = read_png("a.png")
    np.testing.assert_array_equal(pixels, picture.rgb8())
    assert texts["Description"] == "set-up Face-up under a hemisphere, 8 samples a pixel"
    assert repr(picture).startswith("<Picture of Inoue sample 3 (ruby), set-up Face-up under a hemisphere: ")


def test_what_it_is_goes_into_json(picture):
    told = json.loads(json.dumps(picture.metadata))
    assert (told["stones"], told["materials"], told["diameters_mm"]) == (["Inoue sample 3"], ["ruby"], [6.5])
    assert (told["seed"], told["samples"], told["stopped"]) == (3, 8, "samples")
    assert told["exposure"] == picture.exposure


def test_xarray_holds_the_same_arrays(picture):
    pytest.importorskip("xarray")
    found = picture.to_xarray()
    for name in ("xyz", "albedo", "normal", "coverage", "spectrum"):
        np.testing.assert_array_equal(found[name], getattr(picture, name))
    assert found.xyz.dims == ("y", "x", "tristimulus")
    np.testing.assert_allclose(found.wavelength, [427.5, 522.5, 617.5, 712.5])
    assert found.attrs == picture.metadata


def test_without_xarray_one_line_names_the_cure(picture, monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(gemrender.BackendError, match="xarray is needed for this; to get it: pip install"):
        picture.to_xarray()


def test_denoised_it_is_what_the_command_writes(render):
    """In an EXR as it is, on the screen with fireflies clamped before."""
    pytest.importorskip("mitsuba_oidn")
    smooth = gemrender.render("inoue-3", "velvet", size=24, spp=16, denoise=True)
    words = ["--setup", "velvet", "--size", 24, "--spp", 16, "--denoise"]
    for name in ("command.exr", "command.png"):
        render("inoue-3", "-o", name, *words)
        assert smooth.save("python" + name[-4:]).read_bytes() == Path(name).read_bytes()
    assert smooth._repr_png_() == Path("python.png").read_bytes()
    noisy = gemrender.render("inoue-3", "velvet", size=24, spp=16)
    np.testing.assert_array_equal(smooth.noisy.xyz, noisy.xyz)
    assert (smooth.xyz != noisy.xyz).any()


def test_a_transparent_background_is_alpha_and_a_foreground(folder):
    cut = gemrender.render("inoue-3", "white", **OPTIONS, background="transparent")
    assert cut.rgb8().shape == (32, 32, 4)
    with pytest.raises(gemrender.InputError, match=r"^background = 'transparent': has no place in a \.jpg"):
        cut.save("a.jpg")
    found = pytest.importorskip("xarray") and cut.to_xarray()
    np.testing.assert_array_equal(found.foreground_alpha, cut.foreground.alpha)


def test_several_stones_and_a_loaded_setup():
    stones = [gemrender.load_stone("inoue-1"), "inoue-3"]
    setup = gemrender.load_setup(SETUP)
    pair = gemrender.render(stones, setup, size=(24, 16), spp=2)
    assert pair.xyz.shape == (16, 24, 3)
    assert pair.title == "Inoue sample 1 (diamond), Inoue sample 3 (diamond)"
    assert pair.setup is setup


# ---- Passes --------------------------------------------------------------------------------------------


def test_each_pass_is_shown(short_passes):
    seen = []
    options = {**OPTIONS, "size": 16, "spp": 12}
    whole = gemrender.render("inoue-3", SETUP, **options, on_pass=lambda *of: seen.append(of))
    assert [(so_far.samples, share) for so_far, share in seen] == [(4, 4 / 12), (8, 8 / 12), (12, 1.0)]
    last, _ = seen[-1]
    np.testing.assert_array_equal(last.xyz, whole.xyz)
    assert (last.stopped, seen[0][0].stopped) == ("samples", "interrupted")
    assert last.rgb8().shape == (16, 16, 3)


def interrupt(so_far, _):
    if so_far.samples == 8:
        raise KeyboardInterrupt


@pytest.mark.parametrize(
    "answer",
    [lambda so_far, _: so_far.samples < 8, lambda so_far, _: np.bool_(so_far.samples < 8), interrupt],
)
def test_who_is_shown_a_pass_may_end_the_work_and_keeps_it(answer, short_passes):
    ended = gemrender.render("inoue-3", SETUP, size=16, spp=4096, on_pass=answer)
    assert (ended.samples, ended.stopped) == (8, "interrupted")
    np.testing.assert_array_equal(ended.xyz, gemrender.render("inoue-3", SETUP, size=16, spp=8).xyz)


def test_previews_have_the_look_that_is_asked_for(short_passes):
    seen = []
    gemrender.render("inoue-3", SETUP, size=16, spp=4, exposure=-1.0, curve="linear",
                     on_pass=lambda so_far, _: seen.append(so_far))  # fmt: skip
    assert {(so_far.ev, so_far.curve) for so_far in seen} == {(-1.0, "linear")}


def test_an_error_of_who_is_shown_a_pass_is_his(short_passes):
    with pytest.raises(ZeroDivisionError):
        gemrender.render("inoue-3", SETUP, size=16, spp=4, on_pass=lambda *_: 1 / 0)


# ---- Options -------------------------------------------------------------------------------------------

BAD_OPTIONS = {
    "size": (["x", 0, [3, 4, 5], None, "12x", 1.5, True, 70000], "must be a number of pixels or two, as "),
    "aspect": (["4:0", 7, "a:b", (1, 2, 3), "1:99", float("nan")], "must be width to height, as 4:5 or "),
    "quality": (["fine", 3], "must be one of draft, good, best"),
    "background": (["black", None], "must be one of setup, transparent"),
    "curve": (["log", 3], "must be one of linear, "),
    "spp": (["3", 2.5, True], "must be a whole number"),
    "seed": (["3", None, 2.5], "must be a whole number"),
    "noise": (["low", float("nan"), True], "must be a finite number"),
    "time": (["long", float("inf")], "must be a finite number"),
    "turn": (["round", float("nan"), None], "must be a finite number"),
    "exposure": (["bright", None], "must be a finite number"),
    "carat": (["heavy", True], "must be a finite number"),
    "diameter": (["wide", float("inf")], "must be a finite number"),
    "setting": (["bezl", 3], "must be one of none, solitaire, bezel, pendant"),
    "metal": (["lead", 3], "must be one of gold, silver, platinum"),
    "girdle": (["rough", 3], "must be one of polished, faceted, bruted"),
    "bins": ([0, 201], "must be from 1 to 200"),
    "range": (["380", 5, None, (1, 2, 3)], "must be two wavelengths, as 380,760 [nm]"),
    "setup": ([3, None], "must be a name or a file"),
    "stone": ([3, None], "must be a stone, a name or a file, or several"),
    "variant": (["llvm_ad_mono", None], "must be a spectral variant, as llvm_ad_spectral"),
}


@pytest.mark.parametrize(
    ("key", "value"), [(key, value) for key, (bad, _) in BAD_OPTIONS.items() for value in bad]
)
def test_bad_options_are_refused_before_any_work(key, value, monkeypatch):
    monkeypatch.setattr(photoreal, "render", lambda *_, **__: pytest.fail("told before any work"))
    with pytest.raises(gemrender.InputError) as caught:
        gemrender.render(**{"stone": "inoue-3", key: value})
    assert caught.value.key == key
    assert caught.value.allowed.startswith(BAD_OPTIONS[key][1])


@pytest.mark.parametrize(
    ("size", "aspect", "sides"),
    [
        (1024, None, (1024, 1024)),
        ("1600x900", None, (1600, 900)),
        ((30, 20), None, (30, 20)),
        (1080, "4:5", (1080, 1350)),
        ("1080", "9:16", (1080, 1920)),
        (1080, (16, 9), (1920, 1080)),
        (1024, "9:16", (1024, 1820)),  # the nearest even number, for films
        (33, "1:1", (33, 33)),
    ],
)
def test_sizes_and_aspects(size, aspect, sides):
    assert picture_size(size, aspect) == sides


def test_an_aspect_beside_two_sides_is_refused():
    with pytest.raises(gemrender.InputError, match="aspect = '4:5': goes with one side"):
        picture_size("30x20", "4:5")
    with pytest.raises(
        gemrender.InputError, match=r"size = 16000: must be such that the longer side is up to"
    ):
        picture_size(16000, "4:5")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"path": "a.png"}, "frames = 3: go with a film, a file that ends in .mp4, .gif, .webp"),
        ({"frames": 1}, "frames = 1: must be from 2 to 100000"),
        ({"frames": "3"}, "frames = '3': must be a whole number"),
        ({"fps": "fast"}, "fps = 'fast': must be a finite number"),
        ({"fps": 100, "path": "a.gif"}, "fps = 100.0: must be from 1 to 50 "),
        ({"move": "spin"}, "move = 'spin': must be one of turntable, rock, tilt"),
        ({"to": 20}, "to = 20: is of rock and tilt; "),
        ({"move": "rock", "to": 0}, "to = 0: must be above 0 and up to 90"),
        ({"move": "rock", "setup": "hemisphere"}, "move = 'rock': must be turntable where "),
        ({"turn": 5}, "turn = 5.0: is for still pictures only, and to rock and tilt"),
        ({"bins": 4}, "bins = 4: go into EXR pictures only"),
        ({"spp": 0}, "spp = 0: must be from 1 to "),
    ],
    ids=str,
)
def test_films_that_cannot_be_are_refused_before_any_work(options, words, folder, monkeypatch):
    monkeypatch.setattr(photoreal, "render", lambda *_, **__: pytest.fail("told before any work"))
    with pytest.raises(gemrender.InputError) as caught:
        gemrender.render_film(**{"stone": "inoue-3", "path": "a.webp", "frames": 3, **options})
    assert str(caught.value).startswith(words)
    assert not list(folder.iterdir())


def test_a_picture_can_be_kept(picture):
    kept = pickle.loads(pickle.dumps(picture))
    np.testing.assert_array_equal(kept.xyz, picture.xyz)
    assert kept.metadata == picture.metadata

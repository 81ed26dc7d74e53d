"""All the mistakes of a file are told in its one line; and what is no file is refused without waiting."""

from __future__ import annotations

import os
import pickle
import signal
import socket
from pathlib import Path

import pytest

from gemrender.cuts import RoundBrilliant, load_stone
from gemrender.errors import InputError
from gemrender.mistakes import LONGEST_LISTED, MOST_LISTED, Mistakes, MistakesError
from gemrender.optics import load_material
from gemrender.reading import located_at, read_lines
from gemrender.scene.setup import Camera, load_setup


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    """Each test runs in an empty folder of its own."""
    monkeypatch.chdir(tmp_path)


def refusal(load, text, name="x.toml"):
    Path(name).write_text(text)
    with pytest.raises(InputError) as caught:
        load(name)
    assert caught.value.exit_status == 2
    line = str(caught.value)
    assert line.startswith(f"{name}: ")
    assert "\n" not in line
    return line.removeprefix(f"{name}: ")


# ---- Several mistakes ----------------------------------------------------------------------------------


def wrong(key, allowed="must be 1", value=2):
    raise InputError(allowed, key=key, value=value)


def told(*keys, **options):
    with pytest.raises(InputError) as caught:
        gather(*keys, **options)
    return caught.value


def gather(*keys, end=None, **options):
    with located_at("x.toml"), Mistakes() as mistakes:
        for key in keys:
            mistakes.of(wrong, key, **options)
        if end is not None:
            raise end


def test_without_mistakes_values_come_back():
    with Mistakes() as mistakes:
        assert mistakes.of(max, 1, 2) == 2


def test_one_is_raised_as_it_is():
    error = told("a")
    assert type(error) is InputError
    assert str(error) == "x.toml: a = 2: must be 1"


def test_several_are_told_in_one_line():
    error = told("a", "b", "c")
    assert str(error) == "x.toml: a = 2: must be 1; b = 2: must be 1; c = 2: must be 1"
    assert (error.source, error.key, error.value, error.allowed) == ("x.toml", "a", 2, "must be 1")
    assert [e.key for e in error.errors] == ["a", "b", "c"]
    assert str(pickle.loads(pickle.dumps(error))) == str(error), "as from another process"


def test_sections_are_put_before_each_of_them():
    def check():
        with located_at("x.toml", "top"), located_at(None, "part"), Mistakes() as mistakes:
            mistakes.of(wrong, "a")
            mistakes.add(InputError("needs more"))
            mistakes.of(read_lines, Path("none.csv"), kind="x")  # another file's

    with pytest.raises(MistakesError) as caught:
        check()
    said = "x.toml: top.part.a = 2: must be 1; top.part: needs more; none.csv: no such file"
    assert str(caught.value) == said


def test_so_many_are_told_and_the_others_counted():
    line = str(told(*(f"k{n}" for n in range(MOST_LISTED + 5))))
    assert line.count("must be 1") == MOST_LISTED
    assert line.endswith(f"; k{MOST_LISTED - 1} = 2: must be 1; and 5 more")
    assert str(told(*(f"k{n}" for n in range(MOST_LISTED)))).endswith("must be 1")


def test_a_line_is_no_longer_than_can_be_read():
    line = str(told("a", "b", "c", "d", allowed="x" * 600))
    assert len(line) < LONGEST_LISTED + 50
    assert line.endswith("xxx; and 2 more")


def test_what_ends_the_checks_is_told_with_what_was_found():
    assert str(told("a", end=InputError("last"))) == "x.toml: a = 2: must be 1; last"
    with pytest.raises(KeyError):
        gather("a", end=KeyError())  # an error of our own is not hidden


# ---- Files ---------------------------------------------------------------------------------------------

_STONE = """\
nam = "x"
[angles]
table = "57"
crown_angle = 99
pavilion_angle = 40.7
star = true
lower_half = 80
girdle_thickness = 2.5
[material]
index = 0
"""


def test_stone_files():
    keys = "name, proportions, angles, report, cut, vertices, design, mesh, material, size, crystal"
    assert refusal(load_stone, _STONE) == (
        f"nam = 'x': unknown key; must be one of {keys}; did you mean name?; "
        "material.index = 0: must be a finite number above 1; "
        "angles.table = '57': must be a number from 5 to 92 [%]; "
        "angles.crown_angle = 99: must be from 1 to 75 [deg]; "
        "angles.star = True: must be a number from 1 to 99 [%]"
    )


def test_a_misspelt_key_is_not_told_as_missing_too_and_the_others_are_checked():
    keys = "table, crown_angle, pavilion_angle, star, lower_half, girdle_thickness"
    text = _STONE.replace("nam ", "name ").replace("star =", "stra =").replace("index", "idx")
    assert refusal(load_stone, text) == (
        "material.idx = 0: unknown key; must be one of name, index; did you mean index?; "
        f"angles.stra = True: unknown key; must be one of {keys}; did you mean star?; "
        "angles.table = '57': must be a number from 5 to 92 [%]; "
        "angles.crown_angle = 99: must be from 1 to 75 [deg]"
    )


def test_a_missing_key_is_told_with_what_is_wrong_with_the_others():
    text = _STONE.replace("nam ", "name ").replace("index = 0", "index = 2")
    keys = "table, crown_angle, pavilion_angle, star, lower_half, girdle_thickness"
    assert refusal(load_stone, text.replace("girdle_thickness = 2.5\n", "")) == (
        "angles.table = '57': must be a number from 5 to 92 [%]; "
        "angles.crown_angle = 99: must be from 1 to 75 [deg]; "
        "angles.star = True: must be a number from 1 to 99 [%]; "
        f"[angles]: missing girdle_thickness; needs {keys}"
    )


def test_all_mistakes_of_a_report_are_told():
    text = _STONE.replace("nam ", "name ").replace("star = true\n", "").replace("index = 0", "index = 2")
    assert refusal(load_stone, text) == (
        "angles.table = '57': must be a number from 5 to 92 [%]; "
        "angles.crown_angle = 99: must be from 1 to 75 [deg]"
    )


def test_set_ups():
    text = """\
pose = "standing"
gap = -1
[camera]
elevation = 91
focus = "near"
zoom = 2
[[light]]
shape = "disc"
radiance = -1
[[light]]
sise = 1
size = 0
[sky]
radiance = "bright"
"""
    line = refusal(load_setup, text)
    keys = "type, elevation, azimuth, distance, margin, aperture, focus"
    assert line.startswith(f"camera.zoom = 2: unknown key; must be one of {keys}; ")
    told = [part for part in line.split("; ") if " = " in part or "missing" in part]
    assert told == [
        "camera.zoom = 2: unknown key",
        "camera.elevation = 91: must be a number from -90 to 90",
        "camera.focus = 'near': must be a number from -1000 to 1000",
        "sky.radiance = 'bright': must be a number from 0 to 1e+09",
        "light 1.radiance = -1: must be a number from 0 to 1e+09",
        "light 2.sise = 1: unknown key",
        "light 2.shape: missing",
        "light 2.size = 0: must be one or two numbers above 0 [girdle radius]",
    ]
    assert line.endswith("; and 2 more")  # pose and gap


def test_the_top_of_a_set_up_is_checked_although_its_parts_are_wrong():
    line = refusal(load_setup, 'pose = "standing"\ngap = -1\nwhite = 3\n[ground]\ntype = "x"\n')
    assert "ground.type = 'x'" in line
    assert "pose = 'standing'" in line
    assert "gap = -1" in line
    assert "white = 3" in line
    assert "needs a light" not in line, "that is told of whole parts only"


def test_materials():
    text = """\
naem = "x"
density = 99
note = 3
[index]
formula = "magic"
coefficients = [1.5]
range_nm = [700, 400]
[absorption]
wavelength_nm = [380, 760]
per_mm = [0.1]
"""
    assert refusal(load_material, text) == (
        "naem = 'x': unknown key; must be one of name, density, source, note, index, index_e, "
        "index_alpha, index_beta, index_gamma, absorption, absorption_e, absorption_alpha, absorption_beta, "
        "absorption_gamma; "
        "did you mean name?; note = 3: must be one line of at most 1000 characters; "
        "density = 99: must be a number from 0.5 to 25 g/cm3; "
        "absorption.per_mm: must be as many as wavelength_nm: 2, not 1; "
        "index.formula = 'magic': must be one of sellmeier, sellmeier-2, pole, cauchy; "
        "index.range_nm = [700.0, 400.0]: must be two wavelengths from 100 to 100000 nm, the lower one first"
    )


def test_both_columns_of_a_table_are_checked_and_both_tables_of_a_material():
    text = "[index]\nwavelength_nm = [380, nan]\nn = [1.5, '2']\n"
    assert refusal(load_material, text) == (
        "index.wavelength_nm[1] = nan: must be a finite number; index.n[1] = '2': must be a finite number"
    )
    text = "[index]\nwavelength_nm = [380, 760]\nn = [9, 9]\n[absorption]\nwavelength_nm = [380, 760]\n"
    line = refusal(load_material, f"{text}per_mm = [0, -1]\n")
    assert line.startswith("index at 380 nm = 9.0: must be from 1.05 to 4")
    assert line.endswith("; absorption.per_mm[1] = -1.0: must be at least 0 [1/mm]")


def test_objects_made_by_hand_tell_all_too():
    with pytest.raises(MistakesError, match=r"^elevation = 91: .*; margin = 0: "):
        Camera(elevation=91, margin=0)
    with pytest.raises(MistakesError, match=r"^table = 0: .*; star = 100: "):
        RoundBrilliant.from_angles(
            table=0, crown_angle=34, pavilion_angle=41, star=100, lower_half=80, girdle_thickness=3
        )


def test_the_command_prints_one_line_with_status_2(gemrender):
    Path("x.toml").write_text(_STONE)
    status, out, err = gemrender("score", "x.toml")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("gemrender: x.toml: nam = 'x': ")
    assert err.count(": must be") == 4


# ---- What is no file -----------------------------------------------------------------------------------

_KINDS = {
    "stone": (load_stone, "x.toml"),
    "vertices": (load_stone, "x.csv"),
    "set-up": (load_setup, "x.toml"),
    "material": (load_material, "x.toml"),
}


@pytest.fixture
def _no_waiting():
    """Fail, not wait, where a pipe is opened that nobody writes to."""

    def fail(*_):
        pytest.fail("waits")

    before = signal.signal(signal.SIGALRM, fail)
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def pipe(name):
    os.mkfifo(name)


def a_socket(name):
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(name)


def device(name):
    Path(name).symlink_to(os.devnull)


@pytest.mark.usefixtures("_no_waiting")
@pytest.mark.parametrize("kind", _KINDS)
@pytest.mark.parametrize(
    ("make", "said"),
    [
        (pipe, "must be a file, not a pipe"),
        (a_socket, "must be a file, not a socket"),
        (device, "must be a file, not a device"),
        (os.mkdir, "cannot be read (Is a directory)"),
    ],
)
def test_what_is_no_file_is_refused_at_once(make, said, kind):
    load, name = _KINDS[kind]
    make(name)
    with pytest.raises(InputError) as caught:
        load(name)
    assert str(caught.value) == f"{name}: {said}"


@pytest.mark.usefixtures("_no_waiting")
def test_a_pipe_of_vertices_is_refused_at_once():
    os.mkfifo("v.csv")
    Path("x.toml").write_text('vertices = "v.csv"\n')
    with pytest.raises(InputError, match=r"^v\.csv: must be a file, not a pipe$"):
        load_stone("x.toml")

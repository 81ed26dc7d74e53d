"""Stone files: what loads, and the one line that each bad file gets."""

from __future__ import annotations

import importlib.resources
import itertools
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tolerances import ROUNDING

import gemrender
from gemrender.cuts import RoundBrilliant, bundled_stones, load_stone, stone_from_vertices
from gemrender.cuts.files import LONGEST_LINE, MOST_BYTES, save_vertices
from gemrender.cuts.round_brilliant.topology import VERTEX_LABELS
from gemrender.errors import InputError
from gemrender.stone import Stone

SCENES = Path(gemrender.__file__).parent.parent / "scenes"
BUNDLED = sorted(path.stem for path in SCENES.glob("*.toml"))
#: Of the paper, of laboratories and of what goes wrong: the first ones.
FIRST = {"fish-eye", "gia-excellent", "inoue-1", "inoue-2", "inoue-3", "nail-head", "tolkowsky"}

PROPORTIONS = """\
name = "A stone"

[proportions]
table = 54.00
star = 57.0
lower_girdle_contact = 20.0
crown_height = 15.70
pavilion_depth = 43.08
girdle_thickness = 2.50
"""
ANGLES = """\
[angles]
table = 57
crown_angle = 34.0
pavilion_angle = 40.7
star = 50
lower_half = 80
girdle_thickness = 2.5
"""


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    """Each test runs in an empty folder of its own."""
    monkeypatch.chdir(tmp_path)


def write(text: str | bytes, name: str = "stone.toml") -> str:
    Path(name).write_bytes(text.encode() if isinstance(text, str) else text)
    return name


def refusal(stone: str) -> str:
    """The one line that a stone is refused with."""
    with pytest.raises(InputError) as caught:
        load_stone(stone)
    line = str(caught.value)
    assert "\n" not in line
    return line


def csv_lines(stone: Stone | None = None) -> list[str]:
    """The header and the 57 rows of a stone's CSV."""
    save_vertices(stone or load_stone("inoue-3"), "saved.csv")
    return Path("saved.csv").read_text(encoding="utf-8").splitlines()


# ---- Bundled stones ------------------------------------------------------------------------------------


def test_bundled_stones_are_named_in_order():
    assert bundled_stones() == BUNDLED
    assert set(BUNDLED) > FIRST


@pytest.mark.parametrize("name", BUNDLED)
def test_bundled_stone_loads_and_names_its_source(name):
    stone = load_stone(name)
    assert stone.source == str(SCENES / f"{name}.toml")
    of_other_materials = name.startswith(("corundum-", "garnet-", "quartz-"))
    assert (stone.material is None) != of_other_materials
    assert stone.proportions is not None or name not in FIRST
    assert any(line.startswith("# Source: ") for line in (SCENES / f"{name}.toml").read_text().splitlines())


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("inoue-1", (62.48, 56.0, 10.40, 12.89, 46.86, 4.55)),
        ("inoue-2", (62.72, 56.0, 19.67, 14.09, 44.89, 5.56)),
        ("inoue-3", (54.00, 57.0, 20.00, 15.70, 43.08, 2.50)),
    ],
)
def test_samples_have_the_papers_proportions(name, values):
    keys = (
        "table", "star", "lower_girdle_contact", "crown_height", "pavilion_depth", "girdle_thickness",
    )  # fmt: skip
    assert load_stone(name).proportions == RoundBrilliant(**dict(zip(keys, values, strict=True)))


@pytest.mark.parametrize(
    ("name", "crown", "pavilion"),
    [
        ("gia-excellent", 34.0, 40.7),
        ("tolkowsky", 34.5, 40.75),
        ("fish-eye", 34, 37.5),
        ("nail-head", 34, 44.5),
    ],
)
def test_known_cuts_have_their_angles(name, crown, pavilion):
    proportions = load_stone(name).proportions
    assert proportions is not None
    assert proportions.crown_angle_deg == pytest.approx(crown, abs=100 * ROUNDING)
    assert proportions.pavilion_angle_deg == pytest.approx(pavilion, abs=100 * ROUNDING)


def test_bundled_stones_are_found_in_an_installed_package(tmp_path):
    """As the wheel lays them out: gemrender/scenes, and no folder scenes beside the package."""
    ignore = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(gemrender.__file__).parent, "site/gemrender", ignore=ignore)
    shutil.copytree(SCENES, "site/gemrender/scenes", ignore=ignore)
    code = "from gemrender.cuts import *; print(len(bundled_stones()), load_stone('inoue-3').source)"
    run = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(tmp_path / "site")},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.split() == [str(len(BUNDLED)), str(tmp_path / "site/gemrender/scenes/inoue-3.toml")]


def test_package_without_scenes_has_no_bundled_stones(monkeypatch, tmp_path):
    monkeypatch.setattr(importlib.resources, "files", lambda package: tmp_path / "gemrender")
    assert bundled_stones() == []
    assert "no such file" in refusal("inoue-3")


def test_file_wins_over_a_bundled_stone():
    write(PROPORTIONS, "inoue-3")
    assert load_stone("inoue-3").name == "A stone"


def test_folder_does_not_win_over_a_bundled_stone():
    Path("inoue-3").mkdir()
    assert load_stone("inoue-3").name == "Inoue sample 3"


def test_path_with_a_separator_is_never_a_bundled_stone():
    assert refusal("./inoue-3").startswith("inoue-3: no such file")
    assert refusal("elsewhere/inoue-3") == f"{Path('elsewhere/inoue-3')}: no such file"


# ---- Good files ----------------------------------------------------------------------------------------


def test_proportions():
    stone = load_stone(write(PROPORTIONS))
    assert (stone.name, stone.source, stone.material) == ("A stone", "stone.toml", None)
    assert stone.proportions == load_stone("inoue-3").proportions


def test_angles_and_whole_numbers():
    assert load_stone(write(ANGLES)).proportions == load_stone("gia-excellent").proportions


def test_path_like():
    assert load_stone(Path(write(PROPORTIONS))).name == "A stone"


def test_name_is_the_files_where_it_has_none():
    assert load_stone(write(ANGLES, "ring 7.toml")).name == "ring 7"


@pytest.mark.skipif(os.name == "nt", reason="names are text on Windows")
def test_name_from_a_file_that_is_no_text_can_be_printed():
    name = os.fsdecode(b"zo\xeb.toml")
    assert load_stone(write(ANGLES, name)).name == "zo?"


@pytest.mark.parametrize(
    "encode",
    [
        lambda text: b"\xef\xbb\xbf" + text.encode(),
        lambda text: text.replace("\n", "\r\n").encode(),
        lambda text: text.replace("\n", "\r").encode(),
        lambda text: text.rstrip("\n").encode(),
    ],
    ids=["BOM", "CRLF", "CR", "no last newline"],
)
def test_ways_to_write_text(encode):
    assert load_stone(write(encode(PROPORTIONS))).name == "A stone"
    text = "\n".join(csv_lines()) + "\n"
    assert load_stone(write(encode(text), "measured.csv")).is_round


@pytest.mark.parametrize(
    ("line", "material"), [('name = "Sapphire"', "Sapphire"), ("index = 1.76", 1.76), ("index = 2", 2.0)]
)
def test_material(line, material):
    stone = load_stone(write(f"{PROPORTIONS}\n[material]\n{line}\n"))
    assert stone.material == material
    assert type(stone.material) is type(material)


def test_vertices_come_back_to_the_last_bit(rng):
    stone = stone_from_vertices(load_stone("inoue-2").vertices + rng.normal(scale=1e-3, size=(57, 3)))
    lines = csv_lines(stone)
    assert lines[0] == "label,x,y,z"
    assert [line.split(",")[0] for line in lines[1:]] == list(VERTEX_LABELS)
    again = load_stone("saved.csv")
    assert again.vertices.tobytes() == stone.vertices.tobytes()
    assert again.facet_normals.tobytes() == stone.facet_normals.tobytes()
    assert (again.name, again.source, again.proportions) == ("saved", "saved.csv", None)


def test_vertices_named_by_a_stone_file_lie_beside_it():
    Path("folder").mkdir()
    save_vertices(load_stone("inoue-3"), "folder/measured.csv")
    write('name = "Measured"\nvertices = "measured.csv"\n[material]\nindex = 2.4\n', "folder/stone.toml")
    stone = load_stone("folder/stone.toml")
    assert (stone.name, stone.material) == ("Measured", 2.4)
    assert stone.source == str(Path("folder/stone.toml"))


@pytest.mark.parametrize(
    "change",
    [
        lambda rows: rows,
        lambda rows: ["Point, X [mm], Y [mm], Z [mm]", *rows],
        lambda rows: ["# measured", "", " # twice", *rows, ",,,", ""],
        lambda rows: [row.replace(",", " , ") for row in rows],
        lambda rows: [f'"p, {i}",' + row.split(",", 1)[1] for i, row in enumerate(rows)],
        lambda rows: ["1," + row.split(",", 1)[1] for row in rows],
    ],
    ids=["no header", "units in the header", "comments and blanks", "spaces", "quotes", "labels all alike"],
)
def test_ways_to_write_vertices(change):
    rows = csv_lines()[1:]
    stone = load_stone(write("\n".join(change(rows)), "measured.csv"))
    assert (stone.vertices == load_stone("inoue-3").vertices).all()


def test_vertices_in_millimetres_from_a_corner():
    rows = (load_stone("inoue-3").vertices * 3.2 + (5, 6, 7)).tolist()
    text = "\n".join(",".join(["v", *map(repr, row)]) for row in rows)
    stone = load_stone(write(text, "measured.csv"))
    np.testing.assert_allclose(stone.vertices, load_stone("inoue-3").vertices, rtol=0, atol=10 * ROUNDING)


def test_vertices_that_cannot_be_written():
    with pytest.raises(InputError, match=r"^absent.v\.csv: cannot be written: No such file or directory$"):
        save_vertices(load_stone("inoue-3"), "absent/v.csv")


# ---- Bad TOML ------------------------------------------------------------------------------------------

_KEYS = "table, star, lower_girdle_contact, crown_height, pavilion_depth, girdle_thickness"

REFUSED = {
    "no shape": (
        'name = "x"',
        "needs exactly one of [proportions], [angles], [report], [cut], vertices, design and mesh; has none",
    ),
    "two shapes": (
        PROPORTIONS + ANGLES,
        "needs exactly one of [proportions], [angles], [report], [cut], vertices, design and mesh; "
        "has proportions and angles",
    ),
    "unknown section": (
        PROPORTIONS.replace("[proportions]", "[proportion]\nx = 1"),
        "proportion = {'x': 1, 'table': 54.0, 'star': 57.0, 'lower_girdle_contact…: unknown key; "
        "must be one of name, proportions, angles, report, cut, vertices, design, mesh, material, size; "
        "did you mean proportions?",
    ),
    "unknown key": (
        PROPORTIONS.replace("crown_height", "crown_hight"),
        f"proportions.crown_hight = 15.7: unknown key; must be one of {_KEYS}; did you mean crown_height?",
    ),
    "key without its section": (
        "table = 54\n" + PROPORTIONS,
        "table = 54: unknown key; must be one of name, proportions, angles, report, cut, vertices, design, "
        "mesh, material, size; "
        "it belongs in [proportions] or [angles] or [report]",
    ),
    "key of another section": (
        PROPORTIONS + "lower_half = 80",
        f"proportions.lower_half = 80: unknown key; must be one of {_KEYS}; "
        "it belongs in [angles] or [report]",
    ),
    "missing keys": (
        "[proportions]\ntable = 54\nstar = 57\ncrown_height = 15",
        f"[proportions]: missing lower_girdle_contact, pavilion_depth, girdle_thickness; needs {_KEYS}",
    ),
    "number for a section": (
        "proportions = 3",
        f"proportions = 3: must be a section: a line [proportions], and below it {_KEYS}",
    ),
    "list of sections": (
        "[[proportions]]\ntable = 54",
        f"proportions = [{{'table': 54}}]: must be a section: a line [proportions], and below it {_KEYS}",
    ),
    "text": (
        PROPORTIONS.replace("54.00", '"54"'),
        "proportions.table = '54': must be a number from 5 to 92 [%]",
    ),
    "boolean": (
        PROPORTIONS.replace("54.00", "true"),
        "proportions.table = True: must be a number from 5 to 92 [%]",
    ),
    "list": (
        PROPORTIONS.replace("54.00", "[54,\n55]"),
        "proportions.table = [54, 55]: must be a number from 5 to 92 [%]",
    ),
    "not a number": (
        PROPORTIONS.replace("54.00", "nan"),
        "proportions.table = nan: must be from 5 to 92 [%]",
    ),
    "infinity": (
        PROPORTIONS.replace("15.70", "-inf"),
        "proportions.crown_height = -inf: must be from 0.5 to 60 [%]",
    ),
    "no crown": (
        PROPORTIONS.replace("15.70", "0"),
        "proportions.crown_height = 0: must be from 0.5 to 60 [%]",
    ),
    "contact beyond the girdle": (
        PROPORTIONS.replace("20.0", "101"),
        "proportions.lower_girdle_contact = 101: must be from 1 to 99 [%]",
    ),
    "star tip above the table": (
        PROPORTIONS.replace("57.0", "10.0"),
        "proportions.star = 10.0: the star tips would lie above the table: for table = 54 % the star must be "
        "at least 17.18 %",
    ),
    "angle": (
        ANGLES.replace("40.7", "90"),
        "angles.pavilion_angle = 90: must be from 3 to 63 [deg]",
    ),
    "crown too high": (
        ANGLES.replace("34.0", "75").replace("57", "50"),
        "angles.crown_angle = 75.0: gives a crown height of 93.3 %; must be from 0.5 to 60 %",
    ),
    "name that is no text": ("name = 3\n" + ANGLES, "name = 3: must be one line of 1 to 100 characters"),
    "name of two lines": (
        'name = "a\\nb"\n' + ANGLES,
        "name = 'a\\nb': must be one line of 1 to 100 characters",
    ),
    "empty name": ('name = " "\n' + ANGLES, "name = ' ': must be one line of 1 to 100 characters"),
    "empty material": (ANGLES + "[material]", "[material]: needs exactly one of name and index; has none"),
    "two materials": (
        ANGLES + '[material]\nname = "ruby"\nindex = 1.76',
        "[material]: needs exactly one of name and index; has both",
    ),
    "material that is no section": (
        'material = "diamond"\n' + ANGLES,
        "material = 'diamond': must be a section: a line [material], and below it name, index",
    ),
    "unknown key of the material": (
        ANGLES + "[material]\nindx = 2",
        "material.indx = 2: unknown key; must be one of name, index; did you mean index?",
    ),
    "material's name that is no text": (
        ANGLES + "[material]\nname = 2.4",
        "material.name = 2.4: must be the name of a material, in quotes",
    ),
    "index of a vacuum": (
        ANGLES + "[material]\nindex = 1",
        "material.index = 1: must be a finite number above 1",
    ),
    "index that is no number": (
        ANGLES + '[material]\nindex = "2.4"',
        "material.index = '2.4': must be a finite number above 1",
    ),
    "index that is not finite": (
        ANGLES + "[material]\nindex = inf",
        "material.index = inf: must be a finite number above 1",
    ),
    "not TOML": (
        PROPORTIONS.replace("57.0", "57,0"),
        "is not TOML: Expected newline or end of document after a statement (at line 5, column 10)",
    ),
    "vertices that are no text": (
        "vertices = [1, 2]",
        "vertices = [1, 2]: must be the name of a CSV file with 57 rows label, x, y, z",
    ),
    "empty": ("", "is empty"),
    "blank": ("\n \t\n", "is empty"),
    "Latin-1": ('name = "zoë"'.encode("latin-1"), "must be text in UTF-8; byte 11 is not"),
    "UTF-16": (PROPORTIONS.encode("utf-16"), "must be text in UTF-8; byte 1 is not"),
    "long line": (
        "#" * (LONGEST_LINE + 1),
        f"line 1: is {LONGEST_LINE + 1} characters long; at most {LONGEST_LINE} are allowed",
    ),
    "huge": ("#\n" * MOST_BYTES, f"is no stone file: larger than {MOST_BYTES} bytes"),
    "nested": ("a = " + "[\n" * 100_000, "is not TOML that makes a stone: nested too deeply"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_file_is_told_in_one_line(case):
    text, line = REFUSED[case]
    assert refusal(write(text)) == f"stone.toml: {line}"


@pytest.mark.parametrize("number", ["0x" + "f" * 900, "9" * 900, "1e999"])
def test_number_beyond_every_float_is_refused(number):
    assert "must be from 5 to 92" in refusal(write(PROPORTIONS.replace("54.00", number)))
    assert "must be a finite number" in refusal(write(f"{ANGLES}[material]\nindex = {number}"))


# ---- Bad paths -----------------------------------------------------------------------------------------


def test_unknown_name_guesses_at_bundled_stones():
    assert refusal("inoue-4") == (
        "inoue-4: no such file, and no bundled stone (see: gemrender stones); did you mean "
        "inoue-3, inoue-2 or inoue-1?"
    )
    assert refusal("gia") == (
        "gia: no such file, and no bundled stone (see: gemrender stones); did you mean gia-excellent?"
    )
    assert refusal("xyz") == "xyz: no such file, and no bundled stone (see: gemrender stones)"


@pytest.mark.parametrize("name", ["", " "])
def test_empty_name(name):
    said = "must be a stone file or a bundled stone (see: gemrender stones)"
    assert refusal(name) == f"stone = {name!r}: {said}"


def test_folder():
    Path("folder.toml").mkdir()
    assert refusal("folder.toml").startswith("folder.toml: cannot be read (")


@pytest.mark.parametrize("name", ["\0", "a\0.toml", "a" * 5000, "x/" * 3000])
def test_path_that_no_file_can_have(name):
    assert refusal(name)


def test_file_that_may_not_be_read(monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    write(PROPORTIONS)
    monkeypatch.setattr(os, "open", refuse)
    assert refusal("stone.toml") == "stone.toml: cannot be read (Permission denied)"


def test_vertices_that_are_not_there_name_the_file_that_names_them():
    assert refusal(write('vertices = "absent.csv"')) == (
        "absent.csv: no such file; named by vertices in stone.toml"
    )


# ---- Bad CSV -------------------------------------------------------------------------------------------

_COLUMNS = "must have the 4 columns label, x, y, z, with commas between them and points in decimals"
_COUNT = (
    "must be 57: 8 table corners, 8 star tips, 16 upper and 16 lower girdle vertices, 8 contacts, the culet"
)

DAMAGED = {
    "56 rows": (lambda lines: lines[:-1], f"56 rows: {_COUNT}"),
    "58 rows": (lambda lines: [*lines, lines[-1]], f"58 rows: {_COUNT}"),
    "only a header": (lambda lines: lines[:1], f"0 rows: {_COUNT}"),
    "wrong order": (
        lambda lines: [*lines[:3], lines[4], lines[3], *lines[5:]],
        "row 3 (line 4): expected table_2, got table_3",
    ),
    "wrong order after a comment": (
        lambda lines: ["# comment", *lines[:3], lines[4], lines[3], *lines[5:]],
        "row 3 (line 5): expected table_2, got table_3",
    ),
    "another column": (
        lambda lines: ["label,x,y,z,comment", *(f"{line},a" for line in lines[1:])],
        f"row 1 (line 1): {_COLUMNS}; has 5",
    ),
    "semicolons": (
        lambda lines: [line.replace(",", ";") for line in lines],
        f"row 1 (line 1): {_COLUMNS}; has 1",
    ),
    "decimal commas": (
        lambda lines: [line.replace(".", ",") for line in lines],
        f"row 1 (line 2): {_COLUMNS}; has 7",
    ),
    "decimal commas in quotes": (
        lambda lines: [lines[0], 'table_0,"0,54",0,0', *lines[2:]],
        "row 1 (line 2), x = '0,54': must be a number, with a point in decimals",
    ),
    "other names in the header": (
        lambda lines: ["label,a,b,c", *lines[1:]],
        "row 1 (line 1), x = 'a': must be a number, with a point in decimals",
    ),
    "text": (
        lambda lines: [*lines[:57], "culet,0,0,deep"],
        "row 57 (line 58), z = 'deep': must be a number, with a point in decimals",
    ),
    "missing number": (
        lambda lines: [*lines[:57], "culet,0,,1"],
        "row 57 (line 58), y = '': must be a number, with a point in decimals",
    ),
    "Python's underscores": (
        lambda lines: [*lines[:57], "culet,0,0,1_0"],
        "row 57 (line 58), z = '1_0': must be a number, with a point in decimals",
    ),
    "NaN": (
        lambda lines: [*lines[:57], "culet,0,nan,1"],
        "row 57 (line 58), y = 'nan': must be a finite number",
    ),
    "infinity": (
        lambda lines: [*lines[:57], "culet,0,0,-1e999"],
        "row 57 (line 58), z = '-1e999': must be a finite number",
    ),
    "open quotes": (
        lambda lines: [lines[0], '"table_0,1,2,3', *lines[2:]],
        "row 1 (line 2): is not CSV: unexpected end of data",
    ),
    "far away": (
        lambda lines: [*lines[:57], "culet,0,0,-6"],
        "vertex 57 (culet): must lie within 5 girdle radii of the girdle's centre",
    ),
}


@pytest.mark.parametrize("case", DAMAGED)
def test_bad_vertices_are_told_in_one_line(case):
    change, line = DAMAGED[case]
    assert refusal(write("\n".join(change(csv_lines())), "bad.csv")) == f"bad.csv: {line}"
    write('vertices = "bad.csv"')
    assert refusal("stone.toml") == f"bad.csv: {line}"


SHAPES = {
    "inside out": (lambda v: v * (1, -1, 1), "the table vertices run clockwise: the stone is inside out"),
    "upside down": (lambda v: v * (1, -1, -1), "the stone is upside down: the table must lie above"),
    "table too low": (lambda v: np.where(np.arange(57)[:, None] < 8, v * (1, 1, 0), v), "above the girdle"),
    "reversed": (lambda v: v[::-1], "upside down"),
    "star tips turned on by one": (
        lambda v: np.concatenate([v[:8], np.roll(v[8:16], 1, axis=0), v[16:]]),
        "(star_0): out of order: lies 45 deg beside its girdle vertex",
    ),
    "girdle turned on by one": (
        lambda v: np.concatenate([v[:32], np.roll(v[32:48], 1, axis=0), v[48:]]),
        "out of order: lies 22.5 deg beside its girdle vertex",
    ),
    "girdle rings exchanged": (
        lambda v: np.concatenate([v[:16], v[32:48], v[16:32], v[48:]]),
        "must not lie below its lower girdle vertex",
    ),
    "oval": (lambda v: v * (1.6, 1, 1), "radius must be from 0.8 to 1.25 of the mean girdle radius"),
    "a point": (lambda v: v * 0, "all girdle vertices lie on the axis"),
    "nearly a point": (lambda v: v * 1e-320, "all girdle vertices lie on the axis"),
    "too large": (lambda v: v * 1e300, "must be finite numbers of at most 1e+50"),
    "too far to tell the vertices apart": (lambda v: v + 1e17, "all girdle vertices lie on the axis"),
    "two vertices in one place": (lambda v: np.where(np.arange(57)[:, None] == 1, v[0], v), "out of order"),
    "hollow": (lambda v: np.where(np.arange(57)[:, None] == 0, v * (1, 1, 0.7), v), "hollow by"),
    "no area": (
        lambda v: np.where(np.arange(57)[:, None] == 8, v[[0, 1]].mean(axis=0), v),
        "star_1 has no area",
    ),
}


@pytest.mark.parametrize("case", SHAPES)
def test_vertices_that_make_no_stone_say_why(case):
    change, words = SHAPES[case]
    rows = change(load_stone("inoue-3").vertices).tolist()
    line = refusal(write("\n".join(",".join(["v", *map(repr, row)]) for row in rows), "bad.csv"))
    assert line.startswith("bad.csv: vert")
    assert words in line


def test_any_two_vertices_exchanged_are_refused():
    vertices = load_stone("inoue-3").vertices
    for i, j in itertools.combinations(range(57), 2):
        order = np.arange(57)
        order[[i, j]] = j, i
        with pytest.raises(InputError):
            stone_from_vertices(vertices[order])


def test_vertices_measured_to_a_tenth_of_a_per_cent_are_a_stone(rng):
    """Of the diameter, standard deviation: such a stone's narrow facets are a little hollow."""
    for _ in range(10):
        jitter = rng.normal(scale=0.002, size=(57, 3))
        stone_from_vertices(load_stone("inoue-3").vertices + jitter)

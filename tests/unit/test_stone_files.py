"""Stone files: what loads, and where it is looked for."""

from __future__ import annotations

import importlib.resources
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from stone_files_help import ANGLES, PROPORTIONS, csv_lines, refusal, write
from tolerances import ROUNDING

import gemrender
from gemrender.cuts import RoundBrilliant, bundled_stones, load_stone, stone_from_vertices
from gemrender.cuts.files import save_vertices
from gemrender.cuts.round_brilliant.topology import VERTEX_LABELS
from gemrender.errors import InputError

SCENES = Path(gemrender.__file__).parent.parent / "scenes"
BUNDLED = sorted(path.stem for path in SCENES.glob("*.toml"))
#: Of the paper, of laboratories and of what goes wrong: the first ones.
FIRST = {"fish-eye", "gia-excellent", "inoue-1", "inoue-2", "inoue-3", "nail-head", "tolkowsky"}

#: Each test runs in an empty folder of its own.
pytestmark = pytest.mark.usefixtures("folder")


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


@pytest.mark.parametrize("name", ["inoue-3", "princess-ideal"])
def test_nobody_writes_to_a_bundled_stone(name):
    """It is the one that the next who loads it gets."""
    stone = load_stone(name)
    assert load_stone(name) is stone
    solid, body = stone.solid, stone.solid.polyhedron
    arrays = [
        stone.vertices,
        stone.facet_normals,
        stone.facet_offsets,
        solid.planes,
        solid.facet,
        solid.areas,
    ]
    arrays += [body.planes, body.vertices, body.corners, body.starts, body.edges, body.areas, body.middles]
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


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

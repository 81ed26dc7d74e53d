"""How a crystal lies in a stone: the section [crystal] of stone files, and what becomes of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from physics_tolerances import ROUNDING

from gemrender.cuts import load_stone, orientation, vary
from gemrender.cuts.crystal_axes import parse_c_axis
from gemrender.cuts.stone_file import save_stone_file, stone_file_text
from gemrender.errors import InputError
from gemrender.optics.crystals import frame_of_angles
from gemrender.render.photoreal import make_gems
from gemrender.report.inspection import inspect_stone
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.setup import load_setup
from gemrender.sweep.improve.varied import remaker

STONE = """
[angles]
table = 57
crown_angle = 34.5
pavilion_angle = 40.75
girdle_thickness = 3
[material]
name = "{}"
"""


@pytest.fixture
def load(tmp_path):
    def load_text(crystal="", material="tanzanite"):
        path = tmp_path / "stone.toml"
        path.write_text(STONE.format(material) + crystal)
        return load_stone(path)

    return load_text


# ---- Files ---------------------------------------------------------------------------------------------


def test_a_file_without_the_section_has_the_optic_axis_along_the_stones(load):
    stone = load()
    assert stone.crystal is None
    np.testing.assert_array_equal(stone.crystal_axes, np.eye(3))


def test_the_word_table_is_along_the_stones_axis(load):
    np.testing.assert_array_equal(load('[crystal]\nc_axis = "table"').crystal_axes, np.eye(3))


@pytest.mark.parametrize("c_axis", [[1, 0, 0], [0.0, -3.0, 4.0], [1e-3, 2, 0.5]])
def test_the_last_axis_is_the_c_axis(load, c_axis):
    axes = load(f"[crystal]\nc_axis = {c_axis}").crystal_axes
    np.testing.assert_allclose(axes[2], np.array(c_axis) / np.linalg.norm(c_axis), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), rtol=0, atol=ROUNDING)


def test_angles_are_bunges(load):
    axes = load("[crystal]\nangles = [10, 20, 30]").crystal_axes
    np.testing.assert_array_equal(axes, frame_of_angles([10, 20, 30]))


@pytest.mark.parametrize(
    "told", ['c_axis = "table"', "c_axis = [0.1, -0.2, 0.7]", "angles = [10.5, 90.0, -33.25]"]
)
def test_a_stone_file_is_written_back_to_the_last_bit(load, tmp_path, told):
    stone = load(f"[crystal]\n{told}")
    assert told in stone_file_text(stone)
    save_stone_file(stone, tmp_path / "again.toml")
    assert load_stone(tmp_path / "again.toml").crystal == stone.crystal


def test_a_stone_that_says_nothing_writes_nothing(load):
    assert "crystal" not in stone_file_text(load())


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[crystal]", "[crystal]: needs exactly one of c_axis and angles; has none"),
        ('[crystal]\nc_axis = "table"\nangles = [0, 0, 0]', "[crystal]: needs exactly one of c_axis and ang"),
        (
            "[crystal]\nc_axes = [0, 0, 1]",
            "crystal.c_axes = [0, 0, 1]: unknown key; must be one of c_axis, ang",
        ),
        ("[crystal]\nc_axis = [0, 0, 0]", "crystal.c_axis = [0.0, 0.0, 0.0]: must be a direction"),
        ("[crystal]\nc_axis = [0, 1]", "crystal.c_axis = [0.0, 1.0]: must be three numbers"),
        ('[crystal]\nc_axis = "girdle"', "crystal.c_axis = 'girdle': must be [x, y, z]"),
        ("[crystal]\nc_axis = 3", "crystal.c_axis = 3: must be a list of numbers"),
        ("[crystal]\nangles = [0, 0, nan]", "crystal.angles[2] = nan: must be a finite number"),
        ('[crystal]\nangles = "table"', "crystal.angles = 'table': must be a list of numbers"),
    ],
)
def test_a_wrong_section_is_refused_in_one_line(load, tmp_path, text, told):
    with pytest.raises(InputError) as refused:
        load(text)
    line = str(refused.value)
    assert line.startswith(f"{tmp_path / 'stone.toml'}: ")
    assert told in line
    assert "\n" not in line


def test_a_crystal_that_is_no_section_is_refused(tmp_path):
    path = tmp_path / "stone.toml"
    path.write_text("crystal = 3\n" + STONE.format("ruby"))
    with pytest.raises(InputError, match=r"crystal = 3: must be a section: a line \[crystal\]"):
        load_stone(path)


# ---- What becomes of it --------------------------------------------------------------------------------


def test_the_crystal_turns_with_the_stone(load):
    turned = load("[crystal]\nc_axis = [1, 0, 0]").rotated(90.0)
    np.testing.assert_allclose(turned.crystal_axes[2], [0, 1, 0], rtol=0, atol=ROUNDING)
    for told in ("", "[crystal]\nangles = [10, 20, 30]"):
        stone = load(told)
        corner = stone.vertices[0]
        along = stone.crystal_axes @ corner
        turned = stone.rotated(37.0)
        corner = turned.solid.vertices[0] if turned.labelled_vertices is None else turned.vertices[0]
        np.testing.assert_allclose(turned.crystal_axes @ corner, along, rtol=0, atol=10 * ROUNDING)


def test_a_turned_crystal_is_told_by_its_angles(load):
    stone = load("[crystal]\nc_axis = [1, 2, 3]")
    turned = replace(stone, crystal=stone.rotated(37.0).crystal)
    again = load(stone_file_text(turned).partition("\n\n[material]")[2].partition("\n\n")[2])
    np.testing.assert_allclose(again.crystal_axes, turned.crystal_axes, rtol=0, atol=10 * ROUNDING)


@pytest.mark.parametrize("name", ["inoue-3", "corundum-oval"])
def test_stones_that_are_changed_keep_it(name):
    stone = replace(load_stone(name), crystal=orientation(c_axis=[1, 0, 0]))
    key, value = ("table", 56.0)
    assert vary(stone, [(key, (value,))])[0].crystal == stone.crystal
    assert remaker(stone)({key: value}).crystal == stone.crystal


def test_inspections_tell_it_of_birefringent_stones(load):
    told = {
        "": "optic axis along the stone's axis",
        "[crystal]\nc_axis = [1, 0, 0.5]": "optic axis along (1, 0, 0.5)",
        "[crystal]\nangles = [10, 20, 30]": "Euler's angles 10, 20, 30 degrees",
    }
    for text, words in told.items():
        assert inspect_stone(load(text, "moissanite")).crystal == words
    assert inspect_stone(load()).crystal == "axis gamma along the stone's axis"
    assert inspect_stone(load("[crystal]\nc_axis = [1, 0, 0]", "diamond")).crystal is None


# ---- Python and the command line -----------------------------------------------------------------------


def test_one_of_both_is_asked_for():
    for given in ({}, {"c_axis": "table", "angles": [0, 0, 0]}):
        with pytest.raises(InputError, match="needs exactly one of c_axis and angles"):
            orientation(**given)


@pytest.mark.parametrize(
    ("text", "value"), [("table", "table"), ("1,0,0", (1, 0, 0)), (" 0.5, -1,2 ", (0.5, -1, 2))]
)
def test_an_options_text_is_read(text, value):
    assert parse_c_axis(text) == value


@pytest.mark.parametrize("text", ["", "1,0", "1,0,0,0", "x", "0,0,0", "1,nan,0", "Table"])
def test_a_wrong_option_is_refused(text):
    with pytest.raises(InputError, match="must be"):
        parse_c_axis(text)


# ---- Pictures ------------------------------------------------------------------------------------------


def surfaces(stone, *, setup="studio", turn_deg=0.0, c_axis=None, birefringence=True):
    gems = make_gems([stone], c_axis=c_axis)
    scene = photoreal_scene(
        gems, load_setup(setup), width=8, height=8, turn_deg=turn_deg, birefringence=birefringence
    )
    return scene.surfaces[0], scene.stones[0]


@pytest.mark.parametrize("setup", ["studio", "hemisphere"])
def test_a_picture_has_the_crystal_where_the_stone_is(variant_llvm_ad_spectral, load, setup):
    stone = load("[crystal]\nangles = [10, 20, 30]")
    surface, placed = surfaces(stone, setup=setup, turn_deg=37.0)
    axes = stone.crystal_axes @ placed.rotation.T
    np.testing.assert_array_equal(surface["c_axis"], axes[2])
    np.testing.assert_array_equal(surface["a_axis"], axes[0])


def test_an_option_stands_in_place_of_the_file(variant_llvm_ad_spectral, load):
    surface, placed = surfaces(load('[crystal]\nc_axis = "table"'), c_axis=(1, 0, 0))
    np.testing.assert_allclose(surface["c_axis"], placed.rotation[:, 0], rtol=0, atol=ROUNDING)


def test_the_twin_of_a_birefringent_stone_is_asked_for(variant_llvm_ad_spectral, load):
    surface, _ = surfaces(load(), birefringence=False)
    assert surface["birefringence"] is False
    assert "c_axis" not in surface


def test_isotropic_stones_say_nothing_of_crystals(variant_llvm_ad_spectral, load):
    surface, _ = surfaces(load("[crystal]\nc_axis = [1, 0, 0]", material="spinel"))
    assert not {"c_axis", "a_axis", "birefringence"} & set(surface)

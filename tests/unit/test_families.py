"""Families of cuts: parameters in, stones out."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from gemrender.cuts import RoundBrilliant, load_stone
from gemrender.cuts import families as folder
from gemrender.cuts.families import families, step
from gemrender.cuts.girdle_words import CULET_WORDS
from gemrender.errors import InputError
from gemrender.scoring import score
from gemrender.stone import tessellate
from tests.solids import assert_closed

#: Lengths after a few operations on numbers of order 1.
ROUNDING = 1e-12
NAMES = ", ".join(f'"{name}"' for name in families())
HEAD = 'name = "x"\n[cut]\n'


@pytest.fixture
def stone_of(tmp_path):
    def load(text: str):
        path = tmp_path / "stone.toml"
        path.write_text(HEAD + text, encoding="utf-8")
        return load_stone(path)

    return load


def test_every_file_of_the_folder_is_a_family():
    texts = {
        path.stem: path.read_text(encoding="utf-8") for path in Path(folder.__file__).parent.glob("*.py")
    }
    files = {stem for stem, text in texts.items() if "\nFAMILY = " in text}
    assert {name.replace(" ", "_") for name in families()} == files


def test_a_round_brilliant_is_that_of_its_proportions(stone_of):
    numbers = {"table": 57.0, "star": 50.0, "lower_girdle_contact": 20.0, "crown_height": 14.5,
               "pavilion_depth": 43.0, "girdle_thickness": 3.0}  # fmt: skip
    lines = "\n".join(f"{key} = {value}" for key, value in numbers.items())
    stone = stone_of(f'family = "round brilliant"\n{lines}')
    assert stone.cut == RoundBrilliant(**numbers)


@pytest.mark.parametrize("length", [100.0, 135.0, 300.0])
@pytest.mark.parametrize("corner", [0.0, 15.0, 30.0])
def test_a_step_cut_has_its_outline_and_its_angles(length, corner):
    rows = {"crown_angles": (50, 40), "pavilion_angles": (45, 40)}
    cut = step.Parameters(length=length, corner=corner, table=50, **rows)
    stone = cut.stone(material=1.77)
    assert_closed(tessellate(stone))
    vertices = stone.solid.vertices
    width, long = np.ptp(vertices[:, 0]), np.ptp(vertices[:, 1])
    assert (long, long / width) == pytest.approx((2.0, length / 100), abs=ROUNDING)
    rise = stone.facet_normals[:, 2]
    angles = {round(math.degrees(math.acos(min(abs(z), 1.0))), 6) for z in rise}
    assert angles <= {0.0, 40.0, 45.0, 50.0, 90.0}
    table = np.flatnonzero(rise > 1 - ROUNDING)
    on_table = vertices[np.abs(vertices[:, 2] - vertices[:, 2].max()) < ROUNDING]
    assert len(table) == 1
    assert np.ptp(on_table[:, 0]) / width == pytest.approx(0.5, abs=ROUNDING)
    assert stone.symmetry.fold == (4 if length == 100 else 2)
    assert stone.rear_rule == "position"


def test_a_step_cut_of_one_row_in_closed_form():
    # A square frustum over a square pyramid: heights are half-widths by tangents.
    cut = step.Parameters(
        length=100, corner=0, table=50, girdle_thickness=5, crown_angles=(45,), pavilion_angles=(45,)
    )
    stone = cut.stone()
    crown = 0.5 / 3 * (4 + 1 + 2)  # height 1/2, squares of side 2 and 1
    assert stone.solid.volume == pytest.approx(crown + 4 * 0.1 + 4 * 1 / 3, abs=ROUNDING)


def test_a_step_cut_scores(stone_of):
    found = score(stone_of('family = "Step"\nlength = 135\n[material]\nname = "sapphire"'))
    assert found.engine == "exact"
    assert found.bound < 1e-3
    assert 0 < found.average < 100


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("table = 50", f"cut.family: missing; must be one of {NAMES}"),
        ('family = "stp"', f"cut.family = 'stp': must be one of {NAMES}; did you "),
        ('family = "step"\nlenght = 120', "cut.lenght: unknown key; must be one of length, corner, "),
        ('family = "step"\nlength = 3', "cut.length = 3: must be from 100 to 400 [%]"),
        ('family = "step"\ncrown_angles = 40', "cut.crown_angles = 40: must be a list of 1 to 12 numbers"),
        ('family = "step"\ncrown_angles = [40, "x"]', "cut.crown_angles = 'x': must be a number from "),
        ('family = "step"\ncrown_angles = [30, 40]', "cut.crown_angles = [30.0, 40.0]: must fall "),
        ('family = "round brilliant"\nculet = "tiny"', "cut.culet = 'tiny': must be 0 or from 0.1 to 20 "),
    ],
)  # fmt: skip
def test_what_makes_no_cut_is_told(stone_of, text, said):
    with pytest.raises(InputError) as caught:
        stone_of(text)
    assert f": {said}" in str(caught.value)


@pytest.mark.parametrize("family", families().values())
def test_every_parameter_is_in_the_docstring(family):
    """In its own, or in that of what it has in common with others."""
    said = " ".join(kind.__doc__ or "" for kind in family.__mro__)
    for part in fields(family):
        assert f"{part.name} : " in said or f"{part.name}, " in said or f", {part.name}" in said


def test_a_familys_own_parameters_are_no_brilliants_proportions():
    """A family may keep itself as the stone's cut, and call a parameter what brilliants do."""
    cut = step.Parameters()
    assert replace(cut.stone(), cut=cut).proportions is None


@pytest.mark.parametrize(
    "family", [kind for kind in families().values() if "culet" in kind.__dataclass_fields__]
)
def test_every_culet_is_stated_in_words_too(family):
    assert family(culet="none").culet == 0.0
    assert family(culet="small").culet == CULET_WORDS["small"]

"""Settings and grids: the values that are meant, what stays, and what cannot be set."""

from __future__ import annotations

import math
from dataclasses import asdict

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tolerances import ROUNDING

from gemrender.cuts import RoundBrilliant, load_stone, stone_from_vertices, vary
from gemrender.cuts.round_brilliant.proportions import RANGES, smallest_star
from gemrender.cuts.variations import MOST_VARIATIONS, SETTINGS, parse_setting
from gemrender.errors import InputError
from gemrender.stone import Stone

#: Proportions of order 100 [%] after a tangent and its inverse.
THERE_AND_BACK = 100 * 10 * ROUNDING


def refusal(*settings: str, stone: str | Stone = "inoue-3") -> str:
    with pytest.raises(InputError) as caught:
        vary(stone, settings)
    line = str(caught.value)
    assert "\n" not in line
    return line


# ---- Values --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "key", "values"),
    [
        ("pavilion_angle=40.7", "pavilion_angle", (40.7,)),
        ("pavilion_angle=39:42:0.1", "pavilion_angle", tuple(i / 10 for i in range(390, 421))),
        ("star=45:60:5", "star", (45.0, 50.0, 55.0, 60.0)),
        ("star=45:59:5", "star", (45.0, 50.0, 55.0)),
        ("star=60:45:-5", "star", (60.0, 55.0, 50.0, 45.0)),
        ("star=50:50:1", "star", (50.0,)),
        ("table = 53, 57 ,60", "table", (53.0, 57.0, 60.0)),
        ("table=53,56:58:1", "table", (53.0, 56.0, 57.0, 58.0)),
        ("Crown-Angle=34", "crown_angle", (34.0,)),
        ("material=diamond, cubic zirconia", "material", ("diamond", "cubic zirconia")),
        ("index=1.5:1.7:0.1", "index", (1.5, 1.6, 1.7)),
    ],
)
def test_setting(text, key, values):
    assert parse_setting(text) == (key, values)


@settings(max_examples=100, derandomize=True, deadline=None)
@given(
    first=st.integers(0, 10_000), steps=st.integers(0, 300), step=st.integers(1, 50), digits=st.integers(0, 6)
)
def test_values_are_the_numbers_that_are_written_so(first, steps, step, digits):
    def written(number: int) -> str:
        return f"{number // 10**digits}.{number % 10**digits:0{digits}d}" if digits else str(number)

    text = ":".join(map(written, (first, first + steps * step, step)))
    expected = tuple(float(written(first + i * step)) for i in range(steps + 1))
    assert parse_setting(f"table={text}") == ("table", expected)


# ---- Grids ---------------------------------------------------------------------------------------------


def test_grid_is_every_combination_the_last_varying_fastest():
    stones = vary("inoue-3", ["pavilion_angle=40:41:0.5", "material=diamond,sapphire"])
    assert len(stones) == 6
    assert stones.keys == ("pavilion_angle", "material")
    assert list(stones.settings) == [
        {"pavilion_angle": angle, "material": material}
        for angle in (40.0, 40.5, 41.0)
        for material in ("diamond", "sapphire")
    ]
    assert [stone.name for stone in stones][2:4] == [
        "Inoue sample 3 pavilion_angle=40.5 material=diamond",
        "Inoue sample 3 pavilion_angle=40.5 material=sapphire",
    ]
    assert list(stones.materials) == ["diamond", "sapphire"]
    for stone, setting in zip(stones, stones.settings, strict=True):
        assert stone.material == setting["material"]
        assert stone.proportions is not None
        assert abs(stone.proportions.pavilion_angle_deg - setting["pavilion_angle"]) < THERE_AND_BACK


def test_large_grid_is_made_of_nothing_until_asked(monkeypatch):
    stones = vary("inoue-3", ["pavilion_angle=39:41:0.01", "crown_angle=33:35:0.01"])
    assert len(stones) == 201 * 201
    monkeypatch.setattr(
        Stone, "from_proportions", classmethod(lambda cls, proportions, **named: named["name"])
    )
    assert stones[-1] == "Inoue sample 3 pavilion_angle=41 crown_angle=35"


def test_no_settings_are_the_stone():
    (stone,) = vary("inoue-3", [])
    assert stone.name == "Inoue sample 3"
    assert stone.proportions == load_stone("inoue-3").proportions


@pytest.mark.parametrize("key", [*RANGES])
def test_proportion_that_is_set_is_the_only_one_that_changes(key):
    base = load_stone("inoue-3").proportions
    assert base is not None
    value = 0.98 * asdict(base)[key]
    (stone,) = vary("inoue-3", [(key, (value,))])
    assert asdict(stone.proportions) == asdict(base) | {key: value}


def test_stone_of_the_papers_proportions_by_its_angles():
    base = load_stone("inoue-3").proportions
    assert base is not None
    (stone,) = vary("inoue-3", ["crown_angle=34", "pavilion_angle=41", "lower_half=75"])
    assert asdict(stone.proportions) == asdict(base) | {
        "crown_height": 23.0 * math.tan(math.radians(34.0)),
        "pavilion_depth": 50.0 * math.tan(math.radians(41.0)),
        "lower_girdle_contact": 25.0,
    }


def test_own_angles_make_the_same_stone():
    base = load_stone("gia-excellent")
    assert base.description == "angles"
    for setting in ("table=57", "crown_angle=34", "pavilion_angle=40.7", "lower_half=80"):
        assert vary(base, [setting])[0].proportions == base.proportions


def test_another_table_keeps_the_crown_as_it_was_described():
    angles = RoundBrilliant.from_angles(
        table=57, crown_angle=34, pavilion_angle=40.7, star=50, lower_half=80, girdle_thickness=2.5
    )
    by_angle = Stone.from_proportions(angles, description="angles")
    by_height = Stone.from_proportions(angles, description="proportions")
    (one,), (other,) = (vary(stone, ["table=60"]) for stone in (by_angle, by_height))
    assert abs(one.proportions.crown_angle_deg - 34) < THERE_AND_BACK
    assert other.proportions.crown_height == angles.crown_height


def test_what_is_set_is_no_longer_assumed():
    base = Stone.from_proportions(
        load_stone("inoue-3").proportions,
        assumed=("girdle 2.75 of 'thin - medium'", "star 50 (not in the report)"),
    )
    stones = vary(base, ["star=50,55"])
    assert stones[0].assumed == ("girdle 2.75 of 'thin - medium'",)
    assert stones.notes == ("stone: girdle 2.75 of 'thin - medium'",)


def test_material_of_a_measured_stone():
    base = load_stone("inoue-3")
    measured = stone_from_vertices(base.vertices, name="measured")
    stones = vary(measured, ["index=1.5,2.4"])
    assert [stone.material for stone in stones] == [1.5, 2.4]
    assert (stones[0].vertices == base.vertices).all()
    assert refusal("table=55", stone=measured) == (
        "measured: table: cannot be set: the stone is not made from proportions"
    )


# ---- What cannot be ------------------------------------------------------------------------------------

_FORMS = "must be a value, values with commas between them, or first:last:step, such as 39:42:0.1"
_STEP = "must have a step that leads from the first value to the last"


@pytest.mark.parametrize(
    ("given", "line"),
    [
        (
            ["pavilion_angel=40"],
            f"pavilion_angel: unknown key; must be one of {', '.join(SETTINGS)}; "
            "did you mean pavilion_angle?",
        ),
        (["40"], "'40': must be KEY=VALUE, such as pavilion_angle=39:42:0.1"),
        (["table="], f"table = '': {_FORMS}"),
        (["table=50:60"], f"table = '50:60': {_FORMS}"),
        (["table=nan"], f"table = 'nan': {_FORMS}"),
        (["table=1e999"], f"table = '1e999': {_FORMS}"),
        (["table=5_5"], f"table = '5_5': {_FORMS}"),
        (["table=50:60:0"], f"table = '50:60:0': {_STEP}"),
        (["table=60:50:1"], f"table = '60:50:1': {_STEP}"),
        (["table=50:60:1e-9"], f"table = '50:60:1e-9': makes more than {MOST_VARIATIONS} values"),
        (
            ["material=diamond,"],
            "material = 'diamond,': must be names of materials, with commas between them",
        ),
        (["table=95"], "table = 95.0: must be from 5 to 92 [%]"),
        (["table=50:95:1"], "table = 93.0: must be from 5 to 92 [%]"),
        (["pavilion_angle=70"], "pavilion_angle = 70.0: must be from 3 to 63 [deg]"),
        (["index=1"], "index = 1.0: must be a finite number above 1"),
        (["table=55", "table=56"], "table: is set twice"),
        (
            ["crown_height=15", "crown_angle=34"],
            "crown_height: crown_angle and crown_height are one thing; set only one of them",
        ),
        (["index=2", "material=diamond"], "material: index and material are one thing; set only one of them"),
        (
            ["table=50:60:0.01", "star=50:60:0.01"],
            "settings: make 1001 x 1001 = 1002001 stones; at most 1000000 are allowed",
        ),
        (
            ["crown_angle=30:75:1", "table=20:60:1"],
            "crown_angle = 75.0: gives a crown height of 149 %; must be from 0.5 to 60 %",
        ),
    ],
)
def test_setting_that_is_refused(given, line):
    assert refusal(*given) == line


@settings(max_examples=200, derandomize=True, deadline=None)
@given(st.text(max_size=30).map(lambda text: f"table={text}") | st.text(max_size=30))
def test_settings_of_any_text(text):
    try:
        key, values = parse_setting(text)
    except InputError as error:
        line = str(error)
        assert len(line.splitlines()) == 1
    else:
        assert key in SETTINGS
        assert values


def test_smallest_star_grows_with_the_table():
    """So that the corners of a grid tell of all of it."""
    low, high = RANGES["table"]
    stars = [smallest_star(low + (high - low) * i / 500) for i in range(501)]
    assert stars == sorted(stars)

"""Laboratory reports: what counts, what must agree, and what is assumed."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tolerances import PRINTED_PERCENT, ROUNDING

from gemrender.cuts import RoundBrilliant, load_stone, load_stones
from gemrender.cuts.girdle_words import CULET_WORDS, GIRDLE_WORDS, read_culet, read_girdle
from gemrender.cuts.laboratory import REPORT_KEYS, read_report
from gemrender.errors import InputError

#: GIA's reference stone, as a report prints it (Reinitz, Gilbertson & Geurts, "Weight ratio").
REFERENCE = {
    "shape": "Round Brilliant",
    "table": 57,
    "depth": 60.0,
    "crown_angle": 34.0,
    "crown_height": 14.5,
    "pavilion_angle": 40.7,
    "pavilion_depth": 43.0,
    "girdle": "Thin to Medium (Faceted), 2.5%",
    "star": 50,
    "lower_half": 80,
    "culet": "None",
}
FROM_ANGLES = RoundBrilliant.from_angles(
    table=57, crown_angle=34.0, pavilion_angle=40.7, star=50, lower_half=80, girdle_thickness=2.5
)

#: Sums of numbers of order 100 [%].
SUM = 100 * ROUNDING


#: The rounding of a report [%] where crown and pavilion are as steep as they may be (4), and half of the
#: widest range of a girdle (4).
LARGEST_ROUNDING = 8.0


def without(*keys: str, **others: object) -> dict[str, object]:
    return {key: value for key, value in (REFERENCE | others).items() if key not in keys}


def assumed(values: dict[str, object]) -> list[str]:
    return [str(one) for one in read_report(values).assumed]


def refusal(values: dict[str, object]) -> str:
    with pytest.raises(InputError) as caught:
        read_report(values)
    line = str(caught.value)
    assert "\n" not in line
    return line


# ---- What counts ---------------------------------------------------------------------------------------


def test_gias_reference_report_is_the_stone_of_its_angles():
    report = read_report(REFERENCE)
    assert report.proportions == FROM_ANGLES
    assert report.assumed == ()
    assert abs(report.proportions.crown_height - 14.5) < PRINTED_PERCENT
    assert abs(report.proportions.pavilion_depth - 43.0) < PRINTED_PERCENT


def test_heights_alone_are_the_papers_proportions():
    values = {
        "table": 54.0,
        "star": 57.0,
        "lower_girdle_contact": 20.0,
        "crown_height": 15.7,
        "pavilion_depth": 43.08,
        "girdle_thickness": 2.5,
    }
    assert read_report(values).proportions == RoundBrilliant(**values)


@pytest.mark.parametrize(
    ("left_out", "field", "expected"),
    [
        (("crown_angle", "crown_height"), "crown_height", 60.0 - 2.5 - 50 * math.tan(math.radians(40.7))),
        (
            ("pavilion_angle", "pavilion_depth"),
            "pavilion_depth",
            60.0 - 2.5 - 21.5 * math.tan(math.radians(34)),
        ),
        (
            ("girdle",),
            "girdle_thickness",
            60.0 - 21.5 * math.tan(math.radians(34)) - 50 * math.tan(math.radians(40.7)),
        ),
    ],
    ids=["crown", "pavilion", "girdle"],
)
def test_depth_gives_the_part_that_is_missing(left_out, field, expected):
    report = read_report(without(*left_out))
    assert abs(getattr(report.proportions, field) - expected) < SUM
    (one,) = report.assumed
    assert one.what == {"girdle_thickness": "girdle"}.get(field, field.replace("_", " "))
    assert "depth less" in one.why


def test_depth_counts_more_than_words_of_the_girdle():
    report = read_report(without(girdle="medium", depth=60.4))
    total = sum(
        (
            report.proportions.crown_height,
            report.proportions.girdle_thickness,
            report.proportions.pavilion_depth,
        )
    )
    assert abs(total - 60.4) < SUM
    assert assumed(without(girdle="medium", depth=60.4)) == ["girdle 2.89 (depth less crown and pavilion)"]


def test_per_cent_of_the_girdle_counts_more_than_the_depth():
    report = read_report(without(girdle=3.0, depth=60.6))
    assert report.proportions.girdle_thickness == 3.0
    assert report.assumed == ()


def test_thickness_counts_more_than_words():
    report = read_report(without("girdle", girdle="medium", girdle_thickness=2.5))
    assert report.proportions.girdle_thickness == 2.5
    assert report.assumed == ()


def test_words_count_where_the_depth_leaves_nothing():
    """A knife edge in figures that are rounded: never a negative thickness."""
    report = read_report(without("girdle", girdle="extremely thin", depth=57.4))
    assert report.proportions.girdle_thickness == 0.0


# ---- What is assumed -----------------------------------------------------------------------------------


def test_missing_star_and_lower_half_are_those_of_the_reference_stone():
    values = without("star", "lower_half")
    assert read_report(values).proportions == FROM_ANGLES
    assert assumed(values) == ["star 50 (not in the report)", "lower half 80 (not in the report)"]


def test_words_of_the_girdle_are_told():
    values = without("depth", girdle="Thin - Medium")
    assert read_report(values).proportions.girdle_thickness == 2.75
    assert assumed(values) == ["girdle 2.75 of 'thin - medium'"]


def test_a_range_in_per_cent_is_told():
    assert assumed(without("depth", girdle="2.5-4.0 %")) == ["girdle 3.25 of 2.5 to 4"]


# ---- What must agree -----------------------------------------------------------------------------------


def test_depth_that_does_not_agree():
    assert refusal(without(depth=62.0)) == (
        "depth = 62.0: crown 14.5 + pavilion 43.0 + girdle 2.5 make 60.0 %; the rounding of a report allows "
        "a difference of 0.76 %"
    )


def test_depth_tolerance_is_the_sum_of_half_steps():
    """Table 1 %, crown 0.5 deg, pavilion 0.2 deg, girdle 0.5 %, depth 0.1 %: what each moves the sum by."""
    crown, pavilion = math.radians(34), math.radians(40.7)
    allowed = 0.05 + 0.25 + 0.5 / 2 * math.tan(crown)
    allowed += 21.5 / math.cos(crown) ** 2 * math.radians(0.25)
    allowed += 50 / math.cos(pavilion) ** 2 * math.radians(0.1)
    total = FROM_ANGLES.crown_height + FROM_ANGLES.girdle_thickness + FROM_ANGLES.pavilion_depth
    for sign in (-1, 1):
        read_report(without(depth=total + sign * (allowed - 1e-6)))
        refusal(without(depth=total + sign * (allowed + 1e-6)))


@pytest.mark.parametrize(
    ("values", "line"),
    [
        (
            without(crown_height=16.0),
            "crown_height = 16.0: crown_angle = 34 with table = 57 makes it 14.5 %; the rounding of a report "
            "allows a difference of 0.56 %",
        ),
        (
            without(pavilion_depth=44.0),
            "pavilion_depth = 44.0: pavilion_angle = 40.7 makes it 43.0 %; the rounding of a report allows a "
            "difference of 0.4 %",
        ),
        (
            without(lower_girdle_contact=30),
            "lower_girdle_contact = 30.0: lower_half = 80 makes it 20 %; the rounding of a report allows a "
            "difference of 2.5 %",
        ),
        (
            without(girdle="very thick", depth=60.0),
            "depth = 60.0: with crown 14.5 + pavilion 43.0 % leaves a girdle of 2.5 %, which does not fit "
            "'very thick'; the rounding of a report allows a difference of 0.51 %",
        ),
        (
            without("girdle", depth=55.0),
            "depth = 55.0: with crown 14.5 + pavilion 43.0 % leaves a girdle of -2.5 %; the rounding of a "
            "report allows a difference of 0.51 %",
        ),
        (
            without("crown_angle", "crown_height", depth=45.0),
            "depth = 45.0: less girdle and pavilion depth (45.5 %) leaves a crown height of -0.5 %, which "
            "must be from 0.5 to 60 [%]",
        ),
        (without(depth=3.9), "depth = 3.9: must be from 20 to 160 [%]"),
        (without(shape="Oval"), "shape = 'Oval': must be round: this is for round brilliants"),
        (
            without(culet="tiny"),
            "culet = 'tiny': must be 0 or from 0.1 to 20 [% of the diameter], or one of none, very small, "
            "small, medium, slightly large, large, very large, extremely large",
        ),
        (
            without(culet="very large", lower_half=95),
            "culet = 9.0: would reach the lower halves: for lower_half = 95 % it must be at most 4.53 %",
        ),
        (
            without("depth", culet=4.0),
            "pavilion_depth = 43.0: pavilion_angle = 40.7 with a culet of 4 makes it 41.3 %; the rounding of "
            "a report allows a difference of 0.42 %",
        ),
        (
            {"table": 55, "depth": 61.5},
            "needs the crown (crown_angle or crown_height), the pavilion (pavilion_angle or pavilion_depth), "
            "the girdle (girdle or girdle_thickness); the depth stands for one of these only",
        ),
        (without("table", "depth", "girdle"), "needs the table, the girdle (girdle or girdle_thickness)"),
        (without(crown_angle="34"), "crown_angle = '34': must be a number from 1 to 75 [deg]"),
        (
            without(crown_angle=75, crown_height=14.5),
            "crown_angle = 75.0: gives a crown height of 80.2 %; must be from 0.5 to 60 %",
        ),
    ],
)
def test_report_that_is_refused(values, line):
    assert refusal(values) == line


# ---- Words ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "thickness"),
    [
        *GIRDLE_WORDS.items(),
        *zip(("ETN", "VTN", "THN", "MED", "STK", "THK", "VTK", "ETK"), GIRDLE_WORDS.values(), strict=True),
        ("Medium, Faceted", 3.0),
        ("medium to slightly thick", 3.5),
        ("Med - Slt Thick", 3.5),
        ("THN-STK (faceted)", 3.25),
        ("Thick to Thin", 3.75),
        ("Extremely thin to very thick", 4.25),
        ("2.5-4.0 %", 3.25),
        ("3,5 %", 3.5),
        ("Medium to Slightly Thick (Faceted) 3.5%", 3.5),
    ],
)
def test_girdle(text, thickness):
    assert read_girdle(text).thickness == thickness


@pytest.mark.parametrize(
    "text", ["", "T", "slightly thin", "very medium", "0.2 mm", "1 2 3", "thinnish", "nan", "-"]
)
def test_girdle_that_says_nothing(text):
    with pytest.raises(InputError, match="must be per cent of the diameter"):
        read_girdle(text)


@pytest.mark.parametrize(
    ("culet", "width"),
    [
        *CULET_WORDS.items(),
        *zip(("NON", "VSM", "SML", "MED", "SLG", "LGE", "VLG", "ELG"), CULET_WORDS.values(), strict=True),
        *((text, 0.0) for text in ("None", "pointed", "Pointed (None)", "N", "0 %", "no culet", 0, 0.0)),
        ("S", CULET_WORDS["small"]),
        ("v. small", CULET_WORDS["very small"]),
        ("Small (1.2 %)", 1.2),
        ("1,2 %", 1.2),
        (3, 3.0),
    ],
)
def test_culet(culet, width):
    assert read_culet(culet) == width


@pytest.mark.parametrize(
    "culet",
    [
        "",
        True,
        "none, abraded",
        "0.5 mm",
        "none 1 %",
        "small 0",
        "slightly small",
        "1 2",
        -1,
        "-0.5",
        25,
        math.nan,
    ],
)
def test_culet_that_says_nothing(culet):
    with pytest.raises(InputError, match=r"must be 0 or from 0\.1 to 20"):
        read_culet(culet)


# ---- Culets --------------------------------------------------------------------------------------------


def test_depth_of_a_stone_with_a_culet_is_down_to_it():
    """A pavilion of the same angle ends where the culet cuts it off."""
    report = read_report(without("pavilion_depth", "depth", culet=4.0))
    assert report.cut.culet == 4.0
    expected = (100 - 4.0) / 2 * math.tan(math.radians(40.7))
    assert abs(report.cut.pavilion_depth - expected) < SUM
    assert abs(report.cut.alternatives()["pavilion_angle"] - 40.7) < SUM


def test_a_culet_in_words_is_told_and_leaves_the_depth_some_room():
    values = without(culet="Small")
    report = read_report(values)
    assert report.cut.culet == CULET_WORDS["small"]
    assert assumed(values) == ["culet 1.5 of 'small'"]


def test_without_a_culet_the_cut_is_the_proportions():
    report = read_report(REFERENCE)
    assert report.cut is report.proportions


def test_a_table_has_stones_with_culets(tmp_path):
    path = tmp_path / "stones.csv"
    path.write_text(
        "table,crown angle,pavilion angle,girdle,culet\n"
        "57,34,40.8,3,none\n57,34,40.8,3,medium\n57,34,40.8,3,5.5\n",
        encoding="utf-8",
    )
    stones = load_stones(path)
    assert [stone.facet_kinds.count("culet") for stone in stones] == [0, 1, 1]
    assert [getattr(stone.cut, "culet", 0.0) for stone in stones] == [0.0, CULET_WORDS["medium"], 5.5]
    assert isinstance(stones[0].cut, RoundBrilliant)


# ---- Values of any kind --------------------------------------------------------------------------------

ANYTHING = st.one_of(
    st.floats(),
    st.integers(),
    st.text(max_size=12),
    st.sampled_from([*GIRDLE_WORDS, "none", "round", 10**400, True, [1], {}, 57, 34.0, 40.7, 60, "2.5 %"]),
)


@settings(max_examples=300, derandomize=True, deadline=None)
@given(
    others=st.dictionaries(st.sampled_from(REPORT_KEYS), ANYTHING, max_size=3),
    left_out=st.sets(st.sampled_from([*REFERENCE]), max_size=5),
)
def test_values_of_any_kind(others, left_out):
    """Proportions that the depth agrees with, or one line."""
    values = {key: value for key, value in (REFERENCE | others).items() if key not in left_out}
    try:
        proportions = read_report(values).proportions
    except InputError as error:
        line = str(error)
        assert len(line.splitlines()) == 1
        return
    if "depth" in values:
        total = proportions.crown_height + proportions.girdle_thickness + proportions.pavilion_depth
        assert abs(total - values["depth"]) < LARGEST_ROUNDING


# ---- Stone files ---------------------------------------------------------------------------------------


def test_stone_file_with_a_report(tmp_path):
    path = Path(tmp_path / "report.toml")
    path.write_text(
        '[report]\ntable = 57\ncrown_angle = 34\npavilion_angle = 40.7\ngirdle = "Thin - Medium"\n'
    )
    stone = load_stone(path)
    assert stone.proportions is not None
    assert stone.proportions.girdle_thickness == 2.75
    assert stone.description == "report"
    assert stone.assumed == (
        "girdle 2.75 of 'thin - medium'",
        "star 50 (not in the report)",
        "lower half 80 (not in the report)",
    )
    assert stone.rotated(10).assumed == stone.assumed


def test_stone_file_with_a_bad_report(tmp_path):
    path = Path(tmp_path / "report.toml")
    path.write_text('[report]\ntable = 57\ncrown_angle = 34\npavilion_angle = 40.7\ngirdle = "huge"\n')
    with pytest.raises(InputError) as caught:
        load_stone(path)
    assert str(caught.value).startswith(f"{path}: report.girdle = 'huge': must be per cent of the diameter")
    path.write_text("[report]\ntable = 57\ncrown_angle = 34\n")
    with pytest.raises(InputError) as caught:
        load_stone(path)
    assert str(caught.value) == (
        f"{path}: [report]: needs the pavilion (pavilion_angle or pavilion_depth), the girdle (girdle or "
        "girdle_thickness)"
    )


@pytest.mark.parametrize(
    ("more", "assumed"),
    [
        ('girdle_thickness = "Thin - Medium"\nstar = 50\nlower_half = 80', ("girdle",)),
        ("girdle_thickness = 3\nlower_half = 80", ("star 50",)),
        ("girdle_thickness = 3", ("star 50", "lower half 80")),
        ('depth = 61.5\nculet = "none"', ("girdle", "star 50", "lower half 80")),
    ],
)
def test_angles_may_go_on_as_a_report_does(more, assumed, tmp_path):
    for section in ("angles", "report"):
        text = f"[{section}]\ntable = 57\ncrown_angle = 34.5\npavilion_angle = 40.8\n{more}\n"
        (tmp_path / f"{section}.toml").write_text(text)
    stone, report = (load_stone(tmp_path / f"{name}.toml") for name in ("angles", "report"))
    assert stone.proportions == report.proportions
    assert [words.startswith(start) for words, start in zip(stone.assumed, assumed, strict=True)] == [
        True
    ] * len(assumed)


def test_whole_angles_assume_nothing(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text(
        "[angles]\ntable = 57\ncrown_angle = 34.5\npavilion_angle = 40.8\nstar = 50\nlower_half = 80\n"
        "girdle_thickness = 3\n"
    )
    assert load_stone(path).assumed == ()

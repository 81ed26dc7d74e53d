"""Reports of shapes that are not round: words, millimetres and per cent make cuts of families."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from tolerances import ROUNDING

from gemrender.cuts import load_stone, load_stones
from gemrender.cuts.families import families
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.stated import stated_keys
from gemrender.cuts.fancy_rows import FancyRow, FancyRows
from gemrender.cuts.girdle_words import GIRDLE_WORDS
from gemrender.cuts.shape_words import ROUND, read_shape, shape_words
from gemrender.cuts.size import StatedSize
from gemrender.errors import InputError
from gemrender.report.inspection import inspect_stone
from gemrender.stone import Stone

FAMILIES = {name: kind for name, kind in families().items() if issubclass(kind, Family) and name != ROUND}
#: Proportions [%] and lengths [mm] after a few hundred operations.
SUM = 1e4 * ROUNDING
#: What a row states is kept in a dozen numbers [bytes].
MOST_BYTES_A_ROW = 250

#: The report of the project's issue, and one of another shape in another shop's words.
HEADER = "Report No,Shape,Carat,Measurements,Table %,Depth %,Girdle,Culet,Star,Crown Angle,Pavilion Angle"
OVAL = "A1,Oval Brilliant,1.08,8.10 x 5.95 x 3.70 mm,57,62.2,Medium,None,,,"
EMERALD = "B2,EM,1.52,7.50-5.40x3.55,65,65.7,Slightly Thick,None,,,"
BRILLIANT = "C3,Round Brilliant,1.01,6.43 - 6.46 x 3.96 mm,57,61.5,Medium,None,50,34.5,40.8"


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    """Each test runs in an empty folder of its own."""
    monkeypatch.chdir(tmp_path)


def table(*rows: str, header: str = HEADER):
    Path("r.csv").write_text("\n".join((header, *rows)) + "\n")
    return load_stones("r.csv")


def report(text: str) -> Stone:
    Path("x.toml").write_text(f"[report]\n{text}")
    return load_stone("x.toml")


def refusal(load, *arguments: str, **options: str) -> str:
    with pytest.raises(InputError) as caught:
        load(*arguments, **options)
    line = str(caught.value)
    assert "\n" not in line
    return line.partition(": ")[2]


# ---- Words ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "family"),
    [
        ("Oval Brilliant", "oval"), ("oval modified brilliant", "oval"), ("OV", "oval"), ("oval-cut", "oval"),
        ("Pear Modified Brilliant", "pear"), ("PS", "pear"), ("Pear Shape", "pear"),
        ("Marquise Brilliant", "marquise"), ("MQ", "marquise"), ("navette", "marquise"),
        ("Emerald Cut", "emerald"), ("EM", "emerald"), ("Emerald", "emerald"),
        ("Square Emerald Cut", "asscher"), ("AS", "asscher"), ("Asscher", "asscher"),
        ("Baguette", "baguette"), ("Rectangular Step Cut", "baguette"),
        ("Square Modified Brilliant", "princess"), ("PR", "princess"), ("Princess", "princess"),
        ("Cut-Cornered Rectangular Modified Brilliant", "radiant"), ("RAD", "radiant"),
        ("Cut-Cornered Square Modified Brilliant", "radiant"), ("CRB", "radiant"),
        ("Cushion Modified Brilliant", "cushion"), ("Cushion Brilliant", "cushion"), ("CU", "cushion"),
        ("Triangular Brilliant", "trilliant"), ("TR", "trilliant"), ("Trillion", "trilliant"),
        ("Old European Brilliant", "old european"), ("OEC", "old european"), ("Single Cut", "single cut"),
        ("Round Brilliant", ROUND), ("Round", ROUND), ("BR", ROUND), ("RB", ROUND), ("R", ROUND),
    ],
)  # fmt: skip
def test_shapes_as_laboratories_and_shops_write_them(words, family):
    if family not in families():
        pytest.skip("the family is not there")
    shape = read_shape(words)
    assert shape.family == family
    assert shape.kind is families()[family]


def test_every_family_is_known_by_its_own_name_and_by_others():
    for name in FAMILIES:
        assert read_shape(name).family == name
        assert sum(family == name for family in shape_words().values()) >= 4, name


def test_the_style_of_a_cushion_is_in_its_name():
    styles = [
        read_shape(words).fixed["style"] for words in ("Cushion Brilliant", "CB", "Cushion Modified", "CMB")
    ]
    assert styles == ["brilliant", "brilliant", "modified brilliant", "modified brilliant"]
    assert "style" not in read_shape("Cushion").fixed


def test_what_a_word_fixes_gives_way_to_what_is_measured():
    text = 'shape = "Square Radiant"\ntable = 66\ndepth = 67\n'
    assert report(text).cut.length_to_width == 1.0
    assert report(f'{text}[size]\nmeasurements = "5.60 x 5.50 x 3.685"\n').cut.length_to_width > 1.01


def test_an_unknown_shape_is_told_with_what_is_known():
    line = refusal(report, 'shape = "Heart Brilliant"\ntable = 57\ndepth = 60\n')
    known = ", ".join([ROUND, *FAMILIES])
    told = f"report.shape = 'Heart Brilliant': must be one of {known}, as laboratories or shops write them"
    assert line == told, "nothing is guessed at where the shape is one that cannot be made"
    assert refusal(report, 'shape = "Marqise"\n').endswith("; did you mean marquise?")
    assert refusal(report, "shape = 7\n").startswith("report.shape = '7': must be one of ")


# ---- Stone files ---------------------------------------------------------------------------------------


def test_a_report_makes_the_stone_of_its_family():
    stone = report(
        'shape = "Oval Brilliant"\ntable = 57\ndepth = 62.2\ngirdle = "medium"\nculet = "none"\n'
        '[size]\nmeasurements = "8.10 x 5.95 x 3.70 mm"\n'
    )
    cut = stone.cut
    assert (cut.family(), cut.table, cut.culet, cut.girdle_thickness) == (
        "oval",
        57,
        0,
        GIRDLE_WORDS["medium"],
    )
    assert cut.length_to_width == pytest.approx(8.10 / 5.95, rel=SUM)
    assert cut.crown_height + cut.girdle_thickness + cut.pavilion_depth == pytest.approx(62.2, rel=SUM)
    assert stone.size_mm == 8.10
    assert stone.description == "report"
    rest = f"pavilion depth {cut.pavilion_depth:.3g} (depth less the other parts)"
    assert stone.assumed[:2] == ("girdle 3 of 'medium'", rest)
    found = inspect_stone(stone)
    assert found.dimensions["table"].value == pytest.approx(57, rel=1e-9)
    assert found.dimensions["total_depth"].value == pytest.approx(62.2, rel=1e-9)


@pytest.mark.parametrize("name", FAMILIES)
def test_every_family_can_be_stated_by_its_report(name):
    """What a report of the family's own example would say makes that example again."""
    own = FAMILIES[name]()
    parts = (own.crown_height, own.girdle_thickness, own.pavilion_depth)
    cut = report(f'shape = "{name}"\ntable = {own.table!r}\ndepth = {sum(parts)!r}\n').cut
    assert type(cut) is type(own)
    found, expected = cut.values(), own.values()
    assert found.pop("pavilion_depth") == pytest.approx(expected.pop("pavilion_depth"), rel=SUM)
    assert found == expected


@pytest.mark.parametrize("name", FAMILIES)
def test_every_family_has_the_size_that_its_measurements_say(name):
    """In the row of a table, rounded as a report does, the box of the stone is the measurements."""
    stone = FAMILIES[name]().stone()
    found = inspect_stone(stone, size_mm=7.0)
    length, width, depth = found.length_mm, found.width_mm, found.depth_mm
    sides = np.ptp(stone.solid.vertices[:, :2], axis=0)
    if sides[0] > sides[1]:  # wider than long
        length, width = width, length
    box = sorted([length, width], reverse=True)
    row = f"A,{name},,{box[0]:.2f} x {box[1]:.2f} x {depth:.2f},{stone.cut.table!r},,,,,,"
    (again,) = table(row)
    rounded = [round(side, 2) for side in box]
    if "length_to_width" not in stated_keys(type(stone.cut)):  # as wide as long
        rounded = [sum(rounded) / 2] * 2
    assert again.size_mm == pytest.approx(rounded[0])
    again_found = inspect_stone(again)
    made = sorted([again_found.length_mm, again_found.width_mm], reverse=True)
    assert made == pytest.approx(rounded, abs=0.005)
    assert again_found.depth_mm == pytest.approx(round(depth, 2), abs=0.005)


def test_words_of_a_culet_are_widths_that_are_told():
    stone = report('shape = "oval"\ntable = 57\ndepth = 62\nculet = "Very Small"\n')
    assert stone.cut.culet == 0.6
    assert "culet 0.6 of 'very small'" in stone.assumed
    assert report('shape = "oval"\ntable = 57\ndepth = 62\nculet = "1.2 %"\n').cut.culet == 1.2


def test_per_cent_of_the_girdle_counts_more_than_words_and_than_the_depth():
    text = 'shape = "oval"\ntable = 57\ndepth = 62\ngirdle = "3.8 %"\n'
    assert report(text).cut.girdle_thickness == 3.8
    both = 'shape = "oval"\ntable = 57\ndepth = 62\ngirdle = "medium"\ngirdle_thickness = 3.8\n'
    assert report(both).cut.girdle_thickness == 3.8


def test_a_girdle_in_words_is_as_thick_as_the_cut_needs():
    """A cushion of a thin girdle would have none between its mains: so it is thicker at these."""
    stone = report('shape = "cushion"\ntable = 60\ndepth = 66.9\ngirdle = "thin"\nlength_to_width = 1.03\n')
    thickness = stone.cut.girdle_thickness
    assert GIRDLE_WORDS["thin"] < thickness < GIRDLE_WORDS["slightly thick"] + 1
    assert stone.assumed[0] == f"girdle {thickness:.3g} of 'thin', as thin as the cut can be"
    with pytest.raises(InputError, match="make no convex stone"):
        report('shape = "cushion"\ntable = 60\ndepth = 66.9\ngirdle = 2.5\nlength_to_width = 1.03\n')


REFUSED = {
    "no depth": (
        'shape = "oval"\ntable = 57\n',
        "report: needs the depth (depth, millimetres, pavilion_depth or pavilion_angle)",
    ),
    "no table": ('shape = "oval"\ndepth = 60\n', "report: needs the table"),
    "a key of another family": (
        'shape = "emerald"\ntable = 65\ndepth = 65\nstar = 50\n',
        "report.star = 50: unknown key; must be one of table, depth, ",
    ),
    "out of range": ('shape = "oval"\ntable = 95\ndepth = 62\n', "report.table = 95: must be from "),
    "girdle": ('shape = "oval"\ntable = 57\ndepth = 62\ngirdle = "fat"\n', "report.girdle = 'fat': must be "),
    "culet": ('shape = "oval"\ntable = 57\ndepth = 62\nculet = "red"\n', "report.culet = 'red': must be "),
    "culet of a family without one": (
        'shape = "baguette"\ntable = 65\ndepth = 62\nculet = "large"\n',
        "report.culet = 'large': must be none: cuts of this shape have none",
    ),
    "millimetres and per cent": (
        'shape = "oval"\ntable = 57\ndepth = 60\n[size]\nmeasurements = "8.10 x 5.95 x 3.70"\n',
        "size.measurements = '8.10 x 5.95 x 3.70': makes the depth 62.18 %, and it is stated as 60 %",
    ),
    "millimetres out of range": (
        'shape = "oval"\ntable = 57\n[size]\nmeasurements = "8.10 x 2.95 x 1.80"\n',
        "size.measurements = '8.10 x 2.95 x 1.80': makes the length to width 2.746: must be from 1 to 2.5",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_reports_that_are_refused(case):
    text, line = REFUSED[case]
    assert refusal(report, text).startswith(line)


# ---- Tables --------------------------------------------------------------------------------------------


def test_rows_of_all_shapes():
    stones = table(OVAL, EMERALD, BRILLIANT)
    assert [stone.name for stone in stones] == ["A1", "B2", "C3"]
    assert [type(stone.cut) for stone in stones][:2] == [families()["oval"], families()["emerald"]]
    assert [stone.size_mm for stone in stones] == [8.10, 7.50, pytest.approx(6.445)]
    assert stones[0].cut.length_to_width == pytest.approx(8.10 / 5.95, rel=SUM)
    assert stones[0].source == "r.csv, row 1 (line 2)"
    assert stones.proportions(0) == stones[0].cut
    assert stones.proportions(2) == stones[2].proportions


def test_a_row_is_the_stone_of_its_report():
    (of_row,) = table(OVAL)
    of_file = report(
        'shape = "Oval Brilliant"\ntable = 57\ndepth = 62.2\ngirdle = "Medium"\nculet = "None"\n'
        '[size]\nmeasurements = "8.10 x 5.95 x 3.70 mm"\ncarat = 1.08\n'
    )
    assert of_row.cut == of_file.cut
    assert of_row.assumed == of_file.assumed
    assert of_row.size_mm == of_file.size_mm
    assert of_row.notes == of_file.notes


def test_round_rows_are_as_in_a_table_of_their_own():
    mixed, own = table(OVAL, BRILLIANT)[1], table(BRILLIANT)[0]
    assert mixed.proportions == own.proportions
    assert (mixed.vertices == own.vertices).all()
    assert mixed.assumed == own.assumed


def test_few_lines_are_told_of_many_rows():
    stones = table(*[OVAL] * 20, *[OVAL.replace("None,,", "None,52,")] * 10, *[EMERALD] * 5, BRILLIANT)
    notes = stones.notes
    assert len([words for words in notes if "the family's own" in words]) == 2
    assert any(words.startswith("assumed in 30 of 36 rows: oval: ") and "star 50 in 20 of them" in words
               for words in notes)  # fmt: skip
    assert "assumed in 35 of 36 rows: pavilion depth (depth less the other parts)" in notes
    assert not any("columns not used" in words for words in notes)


def test_what_a_shape_has_no_part_for_is_told():
    (notes,) = [table(EMERALD.replace("None,,", "None,50,"), OVAL).notes]
    assert "not used in 1 of 2 rows, whose shapes have no such part: star" in notes


def test_weights_that_differ_are_counted():
    heavy = OVAL.replace(",1.08,", ",1.50,")
    told = (
        "weights differ by more than 3 % from what shape and millimetres make in 2 of 3 rows, first in row 2"
    )
    stones = table(OVAL, heavy, heavy)
    assert told in stones.notes
    assert stones[1].notes[0].endswith("beyond 3 %")


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("shape,table,depth,length,width", "oval,57,62.2,8.10,5.95"),
        ("Shape,Table,Depth %,Length (mm),Width (mm),Depth (mm)", "oval,57,62.2,8.10 mm,5.95,3.70"),
        ("Shape,Table %,Depth %,Meas Length,Meas Width,Meas Depth", "oval,57,62.2,5.95,8.10,3.70"),
        ("Shape,Table %,Depth %,Length,Width,Depth", "oval,57,62.2,8.10,5.95,3.70"),
        ("Shape,Table %,Depth,Length,Width", "oval,57,3.70,8.10,5.95"),  # millimetres, as the number says
        ("Shape,Table %,Dimensions", "oval,57,8.10*5.95*3.70"),
        ("Shape,Table %,Depth %,L/W,Weight (ct)", "oval,57,62.2,1.36 : 1,1.2 ct"),
        ("Shape,Table %,Depth %,Ratio", "oval,57,62.2,1.36"),
        ("shape,table,depth,length_to_width,mains", "oval,57,62.2,1.36,8"),
        ("Shape,Table %,Depth %,Ratio,Style,Mains", "oval,57,62.2,1.36,Modern,"),
    ],
)
def test_ways_to_state_measurements(header, row):
    (stone,) = table(row, header=header)
    assert stone.cut.length_to_width == pytest.approx(1.36, abs=0.002)
    cut = stone.cut
    assert cut.crown_height + cut.girdle_thickness + cut.pavilion_depth == pytest.approx(62.2, abs=0.05)
    assert stone.cut.mains == 8


def test_a_family_s_own_column():
    (stone,) = table("oval,57,62.2,6", header="shape,table,depth,mains")
    assert stone.cut.mains == 6


def test_a_weight_alone_gives_the_size_where_the_density_is_known():
    header = "shape,table,depth,carat,index"
    diamond, glass = table("oval,57,62,1.2,", "oval,57,62,1.2,1.6", header=header)
    assert inspect_stone(diamond).carat == pytest.approx(1.2)
    assert glass.size_mm is None


BAD = {
    "shape": ("D,Star Cut,,,57,62,,,,,", "row 2 (line 3), Shape = 'Star Cut': must be one of "),
    "measurements": (
        "D,Oval,,8.10,57,62,,,,,",
        "row 2 (line 3), Measurements = '8.10': must be as reports print it: ",
    ),
    "millimetres that do not agree": (
        "D,Oval,,8.10 x 5.95 x 3.70,57,65,,,,,",
        "row 2 (line 3), Measurements = '8.10 x 5.95 x 3.70': makes the depth 62.18 %, and it is stated ",
    ),
    "per cent": ("D,Oval,,,97,62,,,,,", "row 2 (line 3), Table % = '97': must be from "),
    "nothing": ("D,Oval,,,,,,,,,", "row 2 (line 3): needs the table, the depth "),
    "a stone that cannot be made": (
        "D,Cushion,,,60,66.9,2 %,,,,",
        "row 2 (line 3): these make no convex stone: ",
    ),
    "text": ("D,Oval,heavy,,57,62,,,,,", "row 2 (line 3), Carat = 'heavy': must be a number"),
    "culet": ("D,Oval,,,57,62,,blue,,,", "row 2 (line 3), Culet = 'blue': must be 0 or from "),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_rows_are_told_by_the_columns_own_titles(case):
    row, line = BAD[case]
    assert refusal(table, OVAL, row).startswith(line)


def test_a_round_row_needs_more_columns():
    line = refusal(table, "oval,57,62", "round,57,62", header="shape,table,depth")
    told = "is round, and needs columns for the crown (crown_angle or crown_height), the pavilion "
    assert line.startswith(f"row 2 (line 3), shape = 'round': {told}")


def test_rows_are_kept_small():
    shape, values = read_shape("oval"), {"table": 57.0, "girdle": "medium", "culet": "none", "star": 50.0}
    tracemalloc.start()
    try:
        rows = FancyRows()
        for k in range(1000):
            size = StatedSize(length_mm=8.0 + k / 1000, width_mm=5.95, depth_mm=3.7, carat=1.1)
            rows.append(FancyRow(shape, dict(values), size))
        kept, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(rows) == 1000
    assert kept < MOST_BYTES_A_ROW * 1000


def test_a_row_is_kept_to_the_last_bit():
    size = StatedSize(length_mm=8.1, width_mm=5.95, carat=1.1)
    rows = FancyRows()
    for k in range(3):
        rows.append(
            FancyRow(read_shape("oval"), {"table": 57 + k / 3, "girdle": "medium", "depth": 62.1}, size)
        )
    rows.append(FancyRow(read_shape("emerald"), {"table": 60.0, "depth": 66.0}))
    assert len(rows) == 4
    for k in range(3):
        again = rows[k]
        assert again.values == {"table": 57 + k / 3, "girdle": "medium", "depth": 62.1}
        assert (again.shape.family, again.size) == ("oval", size)
    assert (rows[3].shape.family, rows[3].size) == ("emerald", None)

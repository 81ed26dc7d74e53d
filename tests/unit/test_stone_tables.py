"""Tables of stones: the ways to write them, what is told of them, and the line that a bad one gets."""

from __future__ import annotations

import contextlib
import os
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given
from hypothesis import strategies as st
from thorough import examples

from gemrender.cuts import RoundBrilliant, load_stone, load_stones
from gemrender.cuts.columns import ALIASES, known_column
from gemrender.cuts.files import save_vertices
from gemrender.cuts.shape_words import shape_words
from gemrender.cuts.stones import Stones
from gemrender.cuts.table import StoneTable, open_table
from gemrender.errors import InputError
from gemrender.stone import Stone

ANGLES = ("table", "crown_angle", "pavilion_angle", "star", "lower_half", "girdle_thickness")
ROW = (57, 34.0, 40.7, 50, 80, 2.5)
REFERENCE = RoundBrilliant.from_angles(**dict(zip(ANGLES, ROW, strict=True)))

#: A row is kept in six numbers, a name and references [bytes], whatever its text holds.
MOST_BYTES_A_ROW = 400

#: Columns of the trade's lists (RapNet) and of a laboratory's data, with a row of GIA's reference stone.
TRADE = {
    "Stock #": "A-17", "Shape": "Round", "Weight": "1.01", "Color": "F", "Clarity": "VS1", "Cut Grade": "EX",
    "Measurements": "6.43-6.46x3.87", "Lab": "GIA", "Report #": "2141438172", "Depth %": "60.0",
    "Table %": "57",
    "Girdle Thin": "Thin", "Girdle Thick": "Medium", "Girdle %": "2.5", "Girdle Condition": "Faceted",
    "Culet Size": "None", "Culet Condition": "", "Crown Height": "14.5", "Crown Angle": "34.0",
    "Pavilion Depth": "43.0", "Pavilion Angle": "40.7", "Shade": "None", "Star Length": "50",
}  # fmt: skip


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    """Each test runs in an empty folder of its own."""
    monkeypatch.chdir(tmp_path)


def write(text: str | bytes, name: str = "stones.csv") -> str:
    Path(name).write_bytes(text.encode() if isinstance(text, str) else text)
    return name


def lines(*rows: object, header: tuple[str, ...] = ANGLES, delimiter: str = ",") -> str:
    return "".join(delimiter.join(map(str, row)) + "\n" for row in (header, *rows))


def refusal(text: str | bytes, name: str = "stones.csv") -> str:
    """The one line that a table is refused with, without the file's name."""
    with pytest.raises(InputError) as caught:
        load_stones(write(text, name))
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{name}: ")
    return line.removeprefix(f"{name}: ")


def only(text: str | bytes, name: str = "stones.csv") -> Stone:
    (stone,) = load_stones(write(text, name))
    return stone


# ---- Rows ----------------------------------------------------------------------------------------------


def test_table_is_a_sequence_of_stones():
    stones = load_stones(write(lines(("a", *ROW), ("", 55, *ROW[1:]), header=("name", *ANGLES))))
    assert isinstance(stones, StoneTable)
    assert [stone.name for stone in stones] == ["a", "stones 2"]
    assert stones[0].proportions == REFERENCE
    assert stones[-1].proportions == stones.proportions(1)
    assert stones[1].source == "stones.csv, row 2 (line 3)"
    assert [stone.name for stone in stones[1:]] == ["stones 2"]
    assert list(stones.settings) == [{}, {}]
    assert stones.notes == ()
    with pytest.raises(IndexError):
        stones[2]


def test_stones_are_made_when_asked_for(monkeypatch):
    stones = load_stones(write(lines(ROW, ROW, ROW)))
    made = []
    monkeypatch.setattr(
        Stone, "from_proportions", classmethod(lambda cls, proportions, **_: made.append(proportions))
    )
    stones[1]
    assert made == [REFERENCE]


def test_papers_proportions_are_kept_to_the_last_bit():
    header = ("table", "star", "lower_girdle_contact", "crown_height", "pavilion_depth", "girdle_thickness")
    values = (54.00, 57.0, 20.00, 15.70, 43.08, 2.50)
    stone = only(lines(values, header=header))
    assert stone.proportions == load_stone("inoue-3").proportions
    assert stone.description == "proportions"


def test_list_of_the_trade():
    stones = load_stones(write(lines(tuple(TRADE.values()), header=tuple(TRADE))))
    assert stones[0].proportions == REFERENCE
    assert stones[0].name == "2141438172"
    assert stones[0].assumed == ("lower half 80 (not in the report)",)
    assert stones.notes[0].startswith("columns not used: Stock #, Weight, Color, Clarity, ")
    assert stones.notes[1:] == ("assumed in 1 of 1 rows: lower half 80 (not in the report)",)


#: What else such lists have.
OTHERS = (
    "Availability", "Cut Grade", "Fluorescence Color", "Girdle Condition", "Girdle Open", "Table Open",
    "Crown Open", "Table Inclusion", "Culet Condition", "Shade", "Tinge", "State", "Pair Stock #",
    "Parcel Stones", "Lab Location", "Total Depth (mm)", "Crown Height mm", "crown_angle_min",
    "Pavilion Angle Max", "Measurements Depth", "Measurements Width", "Certificate Url", "Depth mm",
    "Star Ratio", "cut", "x", "y", "z",
)  # fmt: skip


@pytest.mark.parametrize("left_out", [*ANGLES[3:], None])
def test_other_columns_of_the_trade_are_passed_over(left_out):
    """None is taken for a slip in the name of a column that is not there."""
    header = [key for key in ANGLES if key != left_out]
    row = [value for key, value in zip(ANGLES, ROW, strict=True) if key != left_out]
    if left_out == "girdle_thickness":
        header, row = [*header, "depth"], [*row, 60]
    stones = load_stones(write(lines((*row, *OTHERS), header=(*header, *OTHERS))))
    assert stones.notes[0] == f"columns not used: {', '.join(OTHERS)}"


def test_girdle_in_two_columns():
    header = ("table", "crown angle", "pavilion angle", "girdle min", "girdle max")
    assert only(lines((57, 34, 40.7, "THN", "STK"), header=header)).proportions.girdle_thickness == 3.25
    assert only(lines((57, 34, 40.7, "THN", ""), header=header)).proportions.girdle_thickness == 2.5


def test_materials():
    header = (*ANGLES, "material", "index")
    stones = load_stones(
        write(
            lines(
                (*ROW, "", ""), (*ROW, "sapphire", ""), (*ROW, "", 1.5), (*ROW, "sapphire", ""), header=header
            )
        )
    )
    assert [stone.material for stone in stones] == [None, "sapphire", 1.5, "sapphire"]
    assert {material: source.rpartition(", ")[2] for material, source in stones.materials.items()} == {
        None: "row 1 (line 2)",
        "sapphire": "row 2 (line 3)",
        1.5: "row 3 (line 4)",
    }


def test_many_kinds_of_assumptions_are_one_note():
    header = ("table", "crown_angle", "pavilion_angle", "girdle", "star", "lower_half")
    rows = [(57, 34, 40.7, girdle, 50, 80) for girdle in ("thin", "medium", "thick", "very thin", "3.0")]
    assert load_stones(write(lines(*rows, header=header))).notes == (
        "assumed in 4 of 5 rows: girdle of words",
    )


# ---- Ways to write a table -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        lines(ROW),
        lines(ROW, delimiter=";"),
        lines(ROW, delimiter=";").replace(".", ","),
        lines(ROW, delimiter="\t"),
        "sep=;\n" + lines(ROW, delimiter=";"),
        "# a list\n\n" + lines(ROW),
        lines(ROW).replace("\n", "\r\n"),
        lines(ROW).replace("\n", "\r"),
        lines(ROW).rstrip("\n"),
        lines(ROW) + ",,,,,\n\n",
        lines([f'"{value}"' for value in ROW]),
        lines([f" {value} " for value in ROW]),
        lines(("57 %", "34.0°", "40.7 deg", "50%", "80 pct", "2.5\u00a0%")),
        b"\xef\xbb\xbf" + lines(ROW).encode(),
        lines(ROW, delimiter="\t").encode("utf-16"),
    ],
)
def test_ways_to_write_a_table(text):
    assert only(text).proportions == REFERENCE


def test_windows_1252():
    text = lines(("Zoë", 57, "34.0°", 40.7, 50, 80, 2.5), header=("name", *ANGLES))
    stone = only(text.encode("cp1252"))
    assert (stone.name, stone.proportions) == ("Zoë", REFERENCE)


def test_tabs_by_the_ending():
    assert only(lines(ROW, delimiter="\t"), "stones.tsv").proportions == REFERENCE


def test_name_of_two_lines_and_delimiters_in_quotes():
    text = lines(('"a, b; c"', *ROW), header=("name", *ANGLES))
    assert only(text).name == "a, b; c"


@pytest.mark.parametrize(
    ("title", "key"),
    [
        ("Table %", "table"), ("TABLE_PCT", "table"), ("table (%)", "table"), ("Depth %", "depth"),
        ("Total Depth %", "depth"), ("depth", "depth"), ("Depth (mm)", None), ("Meas Depth", None),
        ("CrownAngle", "crown_angle"), ("Crown Angle (°)", "crown_angle"), ("crown_angle_deg", "crown_angle"),
        ("Pav Angle", "pavilion_angle"), ("Pavilion Depth %", "pavilion_depth"), ("Girdle", "girdle"),
        ("Girdle %", "girdle_thickness"), ("Girdle Thickness", "girdle_thickness"), ("LGF %", "lower_half"),
        ("Lower Half Length", "lower_half"), ("Star Length", "star"), ("Report No.", "name"),
        ("Report #", "name"),
        ("Culet Size", "culet"), ("Refractive index", "index"), ("price", None), ("cut", None), ("x", None),
        ("Shade", None), ("", None),
    ],
)  # fmt: skip
def test_titles(title, key):
    assert known_column(title) == key


def test_every_name_is_of_one_column():
    names = [name for aliases in ALIASES.values() for name in aliases]
    assert len(names) == len(set(names))
    assert all(known_column(key) == key for key in ALIASES)


# ---- pandas --------------------------------------------------------------------------------------------


def thousand(rng: np.random.Generator):
    n = 1000
    return pytest.importorskip("pandas").DataFrame(
        {
            "name": [f"stone {i}" for i in range(n)],
            "table": rng.uniform(52, 62, n),
            "crown_angle": rng.uniform(32, 37, n),
            "pavilion_angle": rng.uniform(40, 42, n),
            "star": rng.uniform(45, 60, n),
            "lower_half": rng.uniform(70, 85, n),
            "girdle_thickness": rng.uniform(1.5, 5, n),
            "carat": rng.uniform(0.3, 3, n),
        }
    )


def test_what_pandas_writes_is_read_to_the_last_bit(rng):
    frame = thousand(rng)
    # With its unnamed index; all digits, whatever another library has told numpy to print.
    frame.to_csv("stones.csv", float_format="%.17g")
    stones = load_stones("stones.csv")
    assert stones.notes == ("columns not used: carat",)
    for i in range(0, 1000, 100):
        row = frame.iloc[i]
        assert stones[i].name == row["name"]
        assert stones[i].proportions == RoundBrilliant.from_angles(**{key: float(row[key]) for key in ANGLES})


def test_rows_are_kept_small(rng):
    frame = thousand(rng)
    frame["comment"] = "x" * 2000
    frame.to_csv("stones.csv")
    load_stones("stones.csv")  # what is made once
    tracemalloc.start()
    try:
        stones = load_stones("stones.csv")
        kept, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(stones) == 1000
    assert kept < MOST_BYTES_A_ROW * 1000
    assert most < Path("stones.csv").stat().st_size / 2


# ---- One stone -----------------------------------------------------------------------------------------


def test_one_stone_is_a_sequence_too():
    stones = load_stones("inoue-3")
    assert isinstance(stones, Stones)
    assert [stone.name for stone in stones] == ["Inoue sample 3"]
    assert stones.materials == {None: stones[0].source}


def test_vertices_are_one_stone():
    save_vertices(load_stone("inoue-3"), "measured.csv")
    (stone,) = load_stones("measured.csv")
    assert (stone.vertices == load_stone("inoue-3").vertices).all()


def test_table_of_one_row_is_a_stone():
    assert load_stone(write(lines(ROW))).proportions == REFERENCE


def test_table_where_one_stone_is_needed():
    with pytest.raises(InputError) as caught:
        load_stone(write(lines(ROW, ROW)))
    assert str(caught.value) == "stones.csv: is a table of 2 stones, a row a stone; one stone is needed here"


# ---- Bad tables ----------------------------------------------------------------------------------------

SHAPES = ", ".join(dict.fromkeys(shape_words().values()))
_NEEDS = "the depth stands for one of these only"

REFUSED = {
    "the public diamonds data": (
        '"carat","cut","color","clarity","depth","table","price","x","y","z"\n'
        '0.23,"Ideal","E","SI2",61.5,55,326,3.95,3.98,2.43\n',
        "needs columns for the crown (crown_angle or crown_height), the pavilion (pavilion_angle or "
        f"pavilion_depth), the girdle (girdle or girdle_thickness); {_NEEDS}",
    ),
    "no column of a stone": (
        lines((1, "x", 3, 4, 5), header=("carat", "cut", "price", "weight", "colour")),
        "has no column of a stone; must have some named as in stone files: table, depth, crown_angle, "
        "crown_height, pavilion_angle, pavilion_depth, girdle, star, lower_half",
    ),
    "misspelt column": (
        lines(ROW, header=("table", "crown_angel", *ANGLES[2:])),
        "crown_angel: unknown column; did you mean crown_angle?",
    ),
    "exchanged letters": (
        lines(ROW, header=(*ANGLES[:3], "stra", *ANGLES[4:])),
        "stra: unknown column; did you mean star?",
    ),
    "two columns for one thing": (
        lines((*ROW, 57), header=(*ANGLES, "Table size")),
        "header: columns 'table' and 'Table size' are both the table; keep one",
    ),
    "only a header": (lines(), "has a header, and no rows"),
    "empty": ("", "is empty"),
    "text for a number": (
        lines(("a", *ROW[1:])),
        "row 1 (line 2), table = 'a': must be a number, with a point in decimals",
    ),
    "decimal comma between commas": (
        lines(('"57,5"', *ROW[1:])),
        "row 1 (line 2), table = '57,5': must be a number, with a point in decimals",
    ),
    "out of range, by the file's own title": (
        lines(ROW, (57, 95, *ROW[2:]), header=("Table %", "Crown Angle", *ANGLES[2:])),
        "row 2 (line 3), Crown Angle = '95': must be from 1 to 75 [deg]",
    ),
    "columns exchanged": (
        lines(("34°", "57%", *ROW[2:])),
        "row 1 (line 2), table = '34°': must be in per cent",
    ),
    "0 for what is not known": (
        lines((57, 0, *ROW[2:])),
        "row 1 (line 2), crown_angle = '0': must be from 1 to 75 [deg]; leave it empty where it is not known",
    ),
    "empty cell that is needed": (
        lines((57, "", *ROW[2:])),
        "row 1 (line 2): needs the crown (crown_angle or crown_height)",
    ),
    "many bad rows": (
        lines(*[(57, 95, *ROW[2:])] * 9, ROW),
        "row 1 (line 2), crown_angle = '95': must be from 1 to 75 [deg]; bad, too: rows 2, 3, 4, 5, 6 and "
        "3 more",
    ),
    "missing cell": (lines(ROW[:5]), "row 1 (line 2): has 5 columns, the header 6, with commas between them"),
    "no shape that can be made": (
        lines((*ROW, "Round"), (*ROW, "Heart"), header=(*ANGLES, "Shape")),
        f"row 2 (line 3), Shape = 'Heart': must be one of {SHAPES}, as laboratories or shops write them",
    ),
    "culet in no words": (
        lines((*ROW, "Tiny"), header=(*ANGLES, "Culet")),
        "row 1 (line 2), Culet = 'Tiny': must be 0 or from 0.1 to 20 [% of the diameter], or one of none, "
        "very small, small, medium, slightly large, large, very large, extremely large",
    ),
    "row numbers for an index": (
        lines((*ROW, 1), header=(*ANGLES, "index")),
        "row 1 (line 2), index = '1': must be a refractive index, above 1",
    ),
    "name that cannot be printed": (
        lines(("a\x07", *ROW), header=("name", *ANGLES)),
        "row 1 (line 2), name = 'a\\x07': must be one line of 1 to 100 characters",
    ),
    "depth that does not agree": (
        lines((*ROW, 65), header=(*ANGLES, "Depth %")),
        "row 1 (line 2), Depth % = '65': crown 14.5 + pavilion 43.0 + girdle 2.5 make 60.0 %; the rounding "
        "of a report allows a difference of 0.76 %",
    ),
    "open quotes": (lines(('"57', *ROW[1:])), "line 2: is not CSV: unexpected end of data"),
    "null character": (
        lines(("a\0", *ROW), header=("name", *ANGLES)),
        "row 1 (line 2), name = 'a\\x00': must be one line of 1 to 100 characters",
    ),
    "neither UTF-8 nor Windows-1252": (
        lines(("\x81", *ROW), header=("name", *ANGLES)).encode("latin-1"),
        "row 1 (line 2), name = '\\udc81': must be one line of 1 to 100 characters",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_table_is_told_in_one_line(case):
    text, line = REFUSED[case]
    assert refusal(text) == line


def test_blank_table():
    assert refusal("\n , \n", "stones.tsv") == "is empty"


def test_titles_that_cannot_be_printed():
    text = lines((*ROW, 1), header=(*ANGLES, "a\x1b[2J"))
    assert load_stones(write(text)).notes == ("columns not used: a\ufffd[2J",)


def test_table_that_is_not_there():
    with pytest.raises(InputError, match=r"^absent\.tsv: no such file"):
        load_stones("absent.tsv")


def test_pipe_is_refused():
    os.mkfifo("pipe.tsv")
    with pytest.raises(InputError, match=r"^pipe\.tsv: must be a file, not a folder, pipe or device$"):
        open_table(Path("pipe.tsv"))


# ---- Damaged tables ------------------------------------------------------------------------------------

TOKENS = [
    b"nan", b"inf", b"-1", b"0", b"1e400", b"9" * 500, b'"', b'""', b",", b";", b"\t", b"\n", b"\r", b"\0",
    b"\xff", b"\xef\xbb\xbf", b"\xe2\x80\xa8", b"%", b"\xb0", b"sep=;\n", b"#", b"mm", b"table", b"=1+1",
]  # fmt: skip
TEXTS = [
    lines(ROW, ROW).encode(),
    lines(tuple(TRADE.values()), header=tuple(TRADE)).encode(),
    lines(("a", *ROW), header=("name", *ANGLES), delimiter=";").replace(".", ",").encode(),
    lines(
        ("oval", "8.10 x 5.95 x 3.70 mm", 57, 62.2, "medium", "none", "1.36", 1.08, 8),
        ("EM", "7.50-5.40x3.55", 65, "", "thin", "", "", "", ""),
        header=("shape", "measurements", "table", "depth", "girdle", "culet", "L/W", "carat", "mains"),
    ).encode(),
]


@contextlib.contextmanager
def one_line():
    """Let an InputError of one line pass; anything else fails."""
    try:
        yield
    except InputError as error:
        line = str(error)
        assert len(line.splitlines()) == 1


@st.composite
def damaged(draw: st.DrawFn) -> bytes:
    """A good table with a few places overwritten, cut out or filled in."""
    text = draw(st.sampled_from(TEXTS))
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, 12)))
        text = text[:start] + draw(st.one_of(st.sampled_from(TOKENS), st.binary(max_size=4))) + text[end:]
    return text


@examples(
    60,
    200,
    given(
        text=st.one_of(damaged(), st.binary(max_size=200)), name=st.sampled_from(["stones.csv", "stones.tsv"])
    ),
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
def test_damaged_table_is_a_table_or_one_line(text, name):
    write(text, name)
    with one_line():
        assert all(isinstance(stone, Stone) for stone in load_stones(name)[:2])

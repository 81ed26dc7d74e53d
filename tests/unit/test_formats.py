"""One table, four forms: what fits, what is escaped, what keeps its digits."""

from __future__ import annotations

import csv
import io
import json

import numpy as np
import pytest
from rich.console import Console

from gemrender.report.formats import (
    FORMATS,
    Column,
    TextTable,
    csv_lines,
    format_csv,
    format_json,
    format_markdown,
    print_tables,
)

NAME = "A name that is to stay whole"


def table(*, wraps: bool = False) -> TextTable:
    columns = [
        Column("Stone", is_text=True, wraps=wraps),
        Column("Average"),
        Column("Rear", 1),
        Column("Band", 2),
    ]
    return TextTable(columns, [[NAME, "60.40", "5.10", "27.1"], ["b", "1.00", "2.00", "3.0"]])


def printed(made: TextTable, width: int) -> list[str]:
    out = io.StringIO()
    print_tables([made], Console(file=out, width=width))
    return out.getvalue().splitlines()


@pytest.mark.parametrize(
    ("width", "left_out"),
    [(200, []), (60, []), (50, ["Band"]), (45, ["Rear", "Band"]), (30, ["Rear", "Band"])],
)
def test_columns_that_do_not_fit_are_left_out_and_named(width, left_out):
    lines = printed(table(), width)
    head = next(line for line in lines if "Stone" in line)
    assert [name for name in ("Average", "Rear", "Band") if name not in head] == left_out
    assert all(len(line) <= width for line in lines)
    assert ("Left out" in " ".join(lines)) == bool(left_out)
    assert all(name in " ".join(lines) for name in left_out)
    if width >= 45:
        assert any(NAME in line for line in lines)


def test_a_note_on_a_column_goes_with_it():
    made = table()
    made.note("Band: what it is.", of="Band")
    assert "Band: what it is." in printed(made, 100)
    assert "Band: what it is." not in printed(made, 50)


def test_the_command_line_offers_the_forms_that_there_are(gemrender):
    allowed = ", ".join(FORMATS)
    assert gemrender("score", "inoue-3", "--format", "?") == (
        2, "", f"gemrender: --format = '?': must be one of {allowed}\n"
    )  # fmt: skip


def test_numbers_are_never_cut():
    lines = printed(table(), 30)
    assert any("60.40" in line for line in lines)


NUMBERS = [0.1, 1 / 3, 5e-324, 1.7976931348623157e308, -2.5, 0, 10**20, np.float64(1) / 3, np.int64(7)]


@pytest.mark.parametrize("number", NUMBERS)
def test_machines_get_every_digit(number):
    (row,) = csv.DictReader(io.StringIO(format_csv([{"x": number}])))
    assert float(row["x"]) == number
    if not isinstance(number, np.integer):
        assert json.loads(format_json([{"x": number}]))[0]["x"] == number


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf"), None])
def test_what_is_no_number_is_nothing(number):
    assert format_csv([{"x": number, "y": 1}]).splitlines()[1] == ",1"
    assert json.loads(format_json({"x": [number]})) == {"x": [None]}


@pytest.mark.parametrize("text", ["=1+1", "+1", "-1", "@SUM(A1)", "\tx", "\r=x"])
def test_a_spreadsheet_runs_no_cell(text):
    cell = next(csv.reader(io.StringIO(format_csv([{"name": text}]).partition("\n")[2], newline="")))[0]
    assert cell == f"'{text}"


@pytest.mark.parametrize("text", ["a, b", 'say "x"', "two\nlines", "a=b", "3-4"])
def test_other_text_comes_back_as_it_is(text):
    (row,) = csv.DictReader(io.StringIO(format_csv([{"name": text}]), newline=""))
    assert row["name"] == text


def test_lines_come_one_by_one():
    def records():
        yield {"x": 1}
        raise KeyboardInterrupt

    lines = csv_lines(records())
    assert [next(lines), next(lines)] == ["x", "1"]


@pytest.mark.parametrize(
    "text", ["<b>x</b>", "a|b", "*a* _b_ `c`", "[a](http://b)", "a\nb | c", "&lt;", "# x", "$x$"]
)
def test_nothing_in_markdown_is_markup(text):
    line = format_markdown([TextTable([Column("Stone", is_text=True)], [[text]])]).splitlines()[2]
    cell = line.removeprefix("| ").removesuffix(" |")
    for sign in "<>":
        assert sign not in cell
    bare = cell.replace("\\\\", "")
    for sign in "|*_`[]#$":
        assert bare.count(sign) == bare.count(f"\\{sign}")
    assert "://" not in bare.replace("\\://", "")


def test_markdown_has_all_columns():
    head, rule, *rows = format_markdown([table()]).splitlines()
    assert head == "| Stone | Average | Rear | Band |"
    assert rule == "| --- | ---: | ---: | ---: |"
    assert len(rows) == 2

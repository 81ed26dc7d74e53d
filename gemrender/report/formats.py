"""One table, four forms: for a terminal, as Markdown, as CSV and as JSON.

People get cells that are rounded and explained; machines get records with every digit. `format_tables` is the
one place that chooses between them.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

__all__ = [
    "FORMATS",
    "Cell",
    "Column",
    "Note",
    "TextTable",
    "csv_lines",
    "format_csv",
    "format_json",
    "format_markdown",
    "print_tables",
]

#: Forms of a printed table.
FORMATS = ("table", "json", "csv", "markdown")

#: What makes a formula of a cell's text in a spreadsheet.
_FORMULA = re.compile(r"[=+@\t\r-]")
#: What Markdown, or the HTML in it, would take for markup.
_MARKUP = re.compile(r"([\\`*_{}\[\]<>#|~$&])")
#: The narrowest column of text, where a terminal is narrower than the names in it [characters].
_NARROWEST = 16
#: Wider than any table [characters].
_UNLIMITED = 1_000_000


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table for people.

    Attributes
    ----------
    name : str
        Its heading.
    rank : int
        Columns of rank 0 are always there; where a terminal is too narrow, the highest rank goes first.
    is_text : bool
        Whether it holds text, not numbers.
    style : str
        Style of its cells in a terminal.
    wraps : bool
        Whether its text runs over several lines.
    """

    name: str
    rank: int = 0
    is_text: bool = False
    style: str = ""
    wraps: bool = False


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell with a style of its own."""

    text: str
    style: str


@dataclass(frozen=True, slots=True)
class Note:
    """A line beneath a table; one that explains a column goes with it."""

    text: str
    style: str = "dim"
    of: str | None = None


@dataclass(slots=True)
class TextTable:
    """A table for people: headings, cells, what is to be said beneath."""

    columns: Sequence[Column]
    rows: list[Sequence[str | Cell]] = field(default_factory=list)
    notes: list[Note] = field(default_factory=list)
    ruled: bool = False  #: whether a line goes before each row that names something

    def note(self, text: str, style: str = "dim", of: str | None = None) -> None:
        """Add a line beneath; `of` names the column that it explains."""
        self.notes.append(Note(text, style, of))


# ---- For people ----------------------------------------------------------------------------------------


def print_tables(tables: Iterable[TextTable], console: Console) -> None:
    """Print tables, then their notes.

    Where a terminal is too narrow for all columns, names stay whole, and the columns that matter least are
    left out and named.
    """
    notes: list[Note] = []
    for table in tables:
        shown = list(range(len(table.columns)))
        made = _rich_table(table, shown)
        while _needed(made, console) > console.width:
            last = max(shown, key=lambda k: (table.columns[k].rank, k))
            if table.columns[last].rank == 0:
                made = _rich_table(table, shown, fold=True)
                break
            shown.remove(last)
            made = _rich_table(table, shown)
        console.print(made)
        left_out = [c.name for k, c in enumerate(table.columns) if k not in shown]
        if left_out:
            words = "Left out, the terminal is too narrow for them"
            notes.append(Note(f"{words}: {', '.join(left_out)} (see --format)."))
        notes += [line for line in table.notes if line.of not in left_out]
    for line in notes:
        # As Text: a stone's name may hold what would be markup.
        console.print(Text(line.text, style=line.style))


def _rich_table(table: TextTable, shown: Sequence[int], fold: bool = False) -> Table:
    made = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for k in shown:
        column = table.columns[k]
        folds = column.wraps or (column.is_text and fold)
        made.add_column(
            Text(column.name),
            justify="left" if column.is_text else "right",
            no_wrap=not folds,
            overflow="fold",
            min_width=_NARROWEST if folds else _widest(table, k),
            style=column.style,
        )
    for number, row in enumerate(table.rows):
        follows = _text(table.rows[number + 1][0]) if number + 1 < len(table.rows) else ""
        cells = (row[k] for k in shown)
        texts = (Text(c.text, style=c.style) if isinstance(c, Cell) else Text(c) for c in cells)
        made.add_row(*texts, end_section=table.ruled and follows != "")
    return made


def _widest(table: TextTable, k: int) -> int:
    """Width of a column that does not wrap [characters]."""
    return max(cell_len(text) for text in (table.columns[k].name, *(_text(row[k]) for row in table.rows)))


def _text(cell: str | Cell) -> str:
    return cell.text if isinstance(cell, Cell) else cell


def _needed(made: Table, console: Console) -> int:
    """Width that a table needs at least [characters]."""
    return console.measure(made, options=console.options.update(width=_UNLIMITED)).minimum


def format_markdown(tables: Iterable[TextTable]) -> str:
    """Return tables in Markdown, with all columns; nothing in a cell is taken for markup or HTML."""
    blocks = []
    for table in tables:
        rule = ["---" if column.is_text else "---:" for column in table.columns]
        rows = [[column.name for column in table.columns], *table.rows]
        lines = [[_plain_markdown(_text(cell)) for cell in row] for row in rows]
        lines.insert(1, rule)
        blocks.append("\n".join(f"| {' | '.join(line)} |" for line in lines))
        if table.notes:
            blocks.append("\n".join(f"{_plain_markdown(line.text)}  " for line in table.notes).rstrip())
    return "\n\n".join(blocks)


def _plain_markdown(text: str) -> str:
    flat = " ".join(text.split())
    escaped = _MARKUP.sub(r"\\\1", flat).replace("\\<", "&lt;").replace("\\>", "&gt;").replace("\\&", "&amp;")
    # Addresses become links by themselves in some dialects; a zero-width space would spoil a copy.
    return escaped.replace("://", "\\://")


# ---- For machines --------------------------------------------------------------------------------------


def format_json(values: Any) -> str:
    """Return values as JSON, in ASCII for any encoding of stdout; what is not finite is null."""
    return json.dumps(_finite(values), indent=2, allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return value


def format_csv(records: Sequence[Mapping[str, Any]]) -> str:
    """Return records as CSV: a head, then a line each; numbers in full, nothing for None."""
    return "\n".join(csv_lines(records))


def csv_lines(records: Iterable[Mapping[str, Any]]) -> Iterable[str]:
    """Yield the lines of `format_csv` one by one, as the records come."""
    names: list[str] | None = None
    for record in records:
        if names is None:
            names = list(record)
            yield _csv_line(names)
        yield _csv_line([_csv_cell(record.get(name)) for name in names])


def _csv_line(cells: Sequence[str]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\r\n").writerow(cells)  # what ends a line is quoted in cells
    return text.getvalue().removesuffix("\r\n")


def _csv_cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):  # numpy's among them
        return repr(float(value)) if math.isfinite(value) else ""
    text = "; ".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)
    # A spreadsheet would run it: an apostrophe makes it text.
    return f"'{text}" if _FORMULA.match(text) else text

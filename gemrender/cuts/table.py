"""Tables of stones: a CSV file with a row a stone, checked whole and kept small.

Columns are called as in stone files, or as laboratories and shops call them (`columns.ALIASES`). A row is
read as a laboratory report (`laboratory`, of other shapes than round `fancy_reports`): what it leaves out is
assumed and told, what it has too much of must agree.
"""

from __future__ import annotations

from array import array
from dataclasses import fields
from operator import attrgetter
from pathlib import Path
from typing import Any

from gemrender.cuts.columns import Columns, match_columns
from gemrender.cuts.delimited import Dialect, open_rows, sniff
from gemrender.cuts.families.round_brilliant import with_culet
from gemrender.cuts.fancy_rows import FancyRows
from gemrender.cuts.laboratory import Report, missing_parts
from gemrender.cuts.round_brilliant.proportions import RoundBrilliant
from gemrender.cuts.stones import LONGEST_NAME, Stones
from gemrender.cuts.table_notes import TableNotes
from gemrender.cuts.table_rows import NUMBER, TableRow
from gemrender.errors import InputError
from gemrender.reading import located_at, stem
from gemrender.stone import Stone

__all__ = ["MOST_ROWS", "StoneTable", "is_table", "open_table"]

#: Most rows of a table.
MOST_ROWS = 1_000_000
#: Bad rows that are named in the refusal, besides the first.
_BAD_ROWS_LISTED = 5
_FIELDS = tuple(field.name for field in fields(RoundBrilliant))
_numbers_of = attrgetter(*_FIELDS)


class StoneTable(Stones):
    """The stones of a table, each made when it is asked for.

    Every row has been checked. A row takes some hundred bytes, whatever its columns.

    Attributes
    ----------
    path : Path
        The file.
    columns : Columns
        Which columns are used for what.
    notes : tuple of str
        Columns that are not used, and what was assumed in how many rows.
    """

    def __init__(self, path: Path, dialect: Dialect, columns: Columns) -> None:
        self.path, self.columns = path, columns
        self._numbers = array("d")
        self._fancy = FancyRows()
        # Of each row its place among the round ones, or that among the others, counted from -1 down.
        self._place = array("q")
        self._sizes = array("d")
        self._culets = array("d")
        self._lines = array("q")
        self._names: list[str] = []
        self._materials: list[str | float | None] = []
        self._assumed: list[tuple[str, ...]] = []
        told = TableNotes()
        self._read(dialect, told)
        self.notes = tuple(told.notes(columns, len(self)))

    def __len__(self) -> int:
        return len(self._names)

    @property
    def materials(self) -> dict[str | float | None, str]:
        """Every material of the rows, and the source of the first row that has it."""
        found: dict[str | float | None, int] = {}
        for i, material in enumerate(self._materials):
            found.setdefault(material, i)
        return {material: self._source(i) for material, i in found.items()}

    def proportions(self, i: int) -> Any:
        """Return the proportions of row i, from 0, but for a culet; of a stone that is not round its cut."""
        place = self._place[i]
        if place < 0:
            return self._stone(i).cut
        size = len(_FIELDS)
        values = self._numbers[size * place : size * (place + 1)]
        return RoundBrilliant(**dict(zip(_FIELDS, values, strict=True)))

    def _stone(self, i: int) -> Stone:
        facts: dict[str, Any] = {
            "name": self._names[i],
            "material": self._materials[i],
            "source": self._source(i),
        }
        place = self._place[i]
        if place < 0:
            return self._fancy[-1 - place].stone(description="report", **facts)[0]
        return Stone.from_proportions(
            with_culet(self.proportions(i), self._culets[place]),
            description="report" if "crown_angle" in self.columns.place else "proportions",
            assumed=self._assumed[i],
            size_mm=self._sizes[i] or None,
            **facts,
        )

    def _source(self, i: int) -> str:
        return f"{self.path}, row {i + 1} (line {self._lines[i]})"

    # ---- Reading ---------------------------------------------------------------------------------------

    def _read(self, dialect: Dialect, told: TableNotes) -> None:
        """Read and check all rows; refuse them by the first bad one, naming some of the others."""
        first: InputError | None = None
        bad: list[int] = []
        same: dict[object, Any] = {}  # one object for equal names of materials and assumptions
        lacks = missing_parts(_known(self.columns))
        with open_rows(self.path, dialect) as rows:
            for number, (line, cells) in enumerate(rows, start=1):
                if number > MOST_ROWS:
                    raise InputError(f"has more than {MOST_ROWS} rows")
                try:
                    row = TableRow(self.columns, cells, dialect)
                    name = self._name(row.values.pop("name", ""), number)
                    made = row.read(lacks, suggests=first is None)
                except InputError as error:
                    bad.append(number)
                    if first is None:
                        key = f"row {number} (line {line})" + (f", {error.key}" if error.key else "")
                        first = InputError(error.allowed, key=key, value=error.value)
                    continue
                if first is not None:
                    continue
                self._lines.append(line)
                self._names.append(name)
                self._materials.append(same.setdefault(row.material, row.material))
                assumed: tuple[str, ...] = ()
                if isinstance(made, Report):
                    self._place.append(len(self._numbers) // len(_FIELDS))
                    self._numbers.extend(_numbers_of(made.proportions))
                    self._culets.append(made.culet)
                    assumed = tuple(map(str, made.assumed))
                    told.count(made.assumed)
                else:
                    self._fancy.append(made)
                    self._place.append(-len(self._fancy))
                    told.of_fancy(number, made.shape.family, row)
                self._sizes.append(row.size_mm)
                self._assumed.append(same.setdefault(assumed, assumed))
                told.used |= row.used
        if first is not None:
            first.allowed += _others(bad[1:])
            raise first
        if not self._names:
            raise InputError("has a header, and no rows")

    def _name(self, name: str, number: int) -> str:
        if not name:
            return f"{stem(self.path, 'stone')[: LONGEST_NAME - 10]} {number}"
        if not name.isprintable() or len(name) > LONGEST_NAME:
            raise InputError(f"must be one line of 1 to {LONGEST_NAME} characters", key="name", value=name)
        return name


def open_table(path: Path, missing: str = "no such file") -> StoneTable:
    """Read and check a table of stones, a row a stone.

    Parameters
    ----------
    path : Path
        Text in UTF-8, UTF-16 or Windows-1252, with commas, semicolons or tabs between the columns. The first
        row names the columns: see `columns.ALIASES`; others are passed over, and told in `notes`.
    missing : str
        What to say where there is no such file.

    Returns
    -------
    StoneTable
        Its stones, each made when asked for.

    Raises
    ------
    InputError
        It cannot be read, lacks a column that a round brilliant needs, or has a bad row: the first is told,
        with its number, column and value.
    """
    with located_at(str(path)):
        dialect = sniff(path, missing)
        columns = match_columns(dialect.header)
        if columns is None:
            raise InputError(
                "has no column of a stone; must have some named as in stone files: table, depth, "
                "crown_angle, crown_height, pavilion_angle, pavilion_depth, girdle, star, lower_half"
            )
        missing_columns = missing_parts(_known(columns))
        if missing_columns and "shape" not in columns.place:  # rows of other shapes need fewer
            raise InputError(f"needs columns for {missing_columns}")
        return StoneTable(path, dialect, columns)


def is_table(path: Path) -> bool:
    """Whether a CSV file is a table of stones, not of one stone's vertices; False if it cannot be read."""
    try:
        header = sniff(path).header
    except InputError:
        return False
    if any(NUMBER.fullmatch(cell) for cell in header):
        return False
    try:
        if match_columns(header) is not None:
            return True
    except InputError:  # it has columns of stones, though not good ones
        return True
    # Titles of other than four columns, without coordinates, are those of no vertices.
    titles = {cell.casefold() for cell in header}
    return (
        len(header) not in (1, 4)
        and not {"x", "y", "z"} <= titles
        and all(t[:1].isalpha() for t in titles if t)
    )


def _known(columns: Columns) -> dict[str, int]:
    known = dict(columns.place)
    if "girdle_thin" in known or "girdle_thick" in known:
        known.setdefault("girdle", -1)
    return known


def _others(rows: list[int]) -> str:
    if not rows:
        return ""
    listed = ", ".join(map(str, rows[:_BAD_ROWS_LISTED]))
    more = f" and {len(rows) - _BAD_ROWS_LISTED} more" if len(rows) > _BAD_ROWS_LISTED else ""
    return f"; bad, too: row{'s' if len(rows) > 1 else ''} {listed}{more}"

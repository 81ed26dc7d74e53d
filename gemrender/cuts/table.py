"""Tables of stones: a CSV file with a row a stone, checked whole and kept small.

Columns are called as in stone files, or as laboratories and shops call them (`columns.ALIASES`). A row is
read as a laboratory report (`laboratory`): what it leaves out is assumed and told, what it has too much of
must agree.
"""

from __future__ import annotations

import re
import sys
from array import array
from collections import Counter
from collections.abc import Iterator
from dataclasses import fields
from operator import attrgetter
from pathlib import Path
from typing import Any

from gemrender.cuts.columns import Columns, match_columns
from gemrender.cuts.delimited import Dialect, open_rows, sniff
from gemrender.cuts.families.round_brilliant import with_culet
from gemrender.cuts.laboratory import Assumed, Report, missing_parts, read_report
from gemrender.cuts.round_brilliant.proportions import RoundBrilliant
from gemrender.cuts.stones import LONGEST_NAME, Stones
from gemrender.errors import InputError
from gemrender.reading import located_at, stem
from gemrender.stone import Stone

__all__ = ["MOST_ROWS", "StoneTable", "is_table", "open_table"]

#: Most rows of a table.
MOST_ROWS = 1_000_000
#: Bad rows that are named in the refusal, besides the first.
_BAD_ROWS_LISTED = 5
#: Different girdles and the like that a note tells apart.
_KINDS_LISTED = 3

_WORDS = ("girdle", "girdle_thickness")
#: Read as they are; all other columns hold numbers.
_TEXT = {"name", "material", "shape", "culet", "girdle_thin", "girdle_thick", *_WORDS}
_EMPTY = {"", "-", "--", "\u2013", "\u2014", ".", "n/a", "na", "#n/a", "nan", "null", "unknown", "?"}
_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(%|pct|percent|[°º˚]|deg|degrees)?")
_PER_CENT, _DEGREES = {"%", "pct", "percent"}, {"°", "º", "˚", "deg", "degrees"}
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
        self._culets = array("d")
        self._lines = array("q")
        self._names: list[str] = []
        self._materials: list[str | float | None] = []
        self._assumed: list[tuple[str, ...]] = []
        counts: Counter[tuple[str, str, str]] = Counter()
        self._read(dialect, counts)
        self.notes = (*_unused(columns), *_assumed(counts, len(self)))

    def __len__(self) -> int:
        return len(self._names)

    @property
    def materials(self) -> dict[str | float | None, str]:
        """Every material of the rows, and the source of the first row that has it."""
        found: dict[str | float | None, int] = {}
        for i, material in enumerate(self._materials):
            found.setdefault(material, i)
        return {material: self._source(i) for material, i in found.items()}

    def proportions(self, i: int) -> RoundBrilliant:
        """Return the proportions of row i, from 0; of a stone with a culet, all but that."""
        size = len(_FIELDS)
        values = self._numbers[size * i : size * (i + 1)]
        return RoundBrilliant(**dict(zip(_FIELDS, values, strict=True)))

    def _stone(self, i: int) -> Stone:
        return Stone.from_proportions(
            with_culet(self.proportions(i), self._culets[i]),
            name=self._names[i],
            material=self._materials[i],
            source=self._source(i),
            description="report" if "crown_angle" in self.columns.place else "proportions",
            assumed=self._assumed[i],
        )

    def _source(self, i: int) -> str:
        return f"{self.path}, row {i + 1} (line {self._lines[i]})"

    # ---- Reading ---------------------------------------------------------------------------------------

    def _read(self, dialect: Dialect, counts: Counter[tuple[str, str, str]]) -> None:
        """Read and check all rows; refuse them by the first bad one, naming some of the others."""
        first: InputError | None = None
        bad: list[int] = []
        same: dict[object, Any] = {}  # one object for equal names of materials and assumptions
        with open_rows(self.path, dialect) as rows:
            for number, (line, cells) in enumerate(rows, start=1):
                if number > MOST_ROWS:
                    raise InputError(f"has more than {MOST_ROWS} rows")
                try:
                    name, material, report = self._row(number, cells, dialect)
                except InputError as error:
                    bad.append(number)
                    if first is None:
                        key = f"row {number} (line {line})" + (f", {error.key}" if error.key else "")
                        first = InputError(error.allowed, key=key, value=error.value)
                    continue
                if first is not None:
                    continue
                self._numbers.extend(_numbers_of(report.proportions))
                self._culets.append(report.culet)
                self._lines.append(line)
                self._names.append(name)
                self._materials.append(same.setdefault(material, material))
                assumed = tuple(map(str, report.assumed))
                self._assumed.append(same.setdefault(assumed, assumed))
                counts.update(map(_kind, report.assumed))
        if first is not None:
            first.allowed += _others(bad[1:])
            raise first
        if not self._names:
            raise InputError("has a header, and no rows")

    def _row(self, number: int, cells: list[str], dialect: Dialect) -> tuple[str, str | float | None, Report]:
        if len(cells) != len(dialect.header):
            columns = f"{len(cells)} columns, the header {len(dialect.header)}"
            raise InputError(f"has {columns}, with {dialect.separated_by} between them")
        raw = {key: cells[i] for key, i in self.columns.place.items()}
        values: dict[str, Any] = {}
        try:
            for key, cell in raw.items():
                value = _value(key, cell, dialect)
                if value is not None:
                    values[key] = value
            name = self._name(values.pop("name", ""), number)
            material = _material(values)
            _join_girdle(values)
            return name, material, read_report(values)
        except InputError as error:
            told = InputError(error.allowed, key=error.key, value=error.value)
            if error.key in raw:
                told.key, told.value = self.columns.title[error.key], raw[error.key]
                if raw[error.key] in ("0", "0.0", "0.00"):
                    told.allowed += "; leave it empty where it is not known"
            raise told from error

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
        if missing_columns := missing_parts(_known(columns)):
            raise InputError(f"needs columns for {missing_columns}")
        return StoneTable(path, dialect, columns)


def is_table(path: Path) -> bool:
    """Whether a CSV file is a table of stones, not of one stone's vertices; False if it cannot be read."""
    try:
        header = sniff(path).header
    except InputError:
        return False
    if any(_NUMBER.fullmatch(cell) for cell in header):
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


# ---- Cells ---------------------------------------------------------------------------------------------


def _value(key: str, cell: str, dialect: Dialect) -> str | float | None:
    """Return what a cell holds; None for nothing."""
    if cell.casefold() in _EMPTY:
        return None
    if key in _TEXT and key not in _WORDS:
        return cell
    text = cell.replace("\u00a0", " ").replace("\u202f", " ")
    if dialect.decimal_comma and "." not in text:
        text = text.replace(",", ".")
    number = _NUMBER.fullmatch(text)
    if number is None:
        if key in _WORDS:
            return text
        raise InputError("must be a number, with a point in decimals", key=key, value=cell)
    unit = (number[2] or "").lower()
    wrong = _PER_CENT if key.endswith("angle") else _DEGREES
    if unit in wrong or (unit and key == "index"):
        must = (
            "in degrees" if key.endswith("angle") else "without a unit" if key == "index" else "in per cent"
        )
        raise InputError(f"must be {must}", key=key, value=cell)
    return float(number[1])


def _material(values: dict[str, Any]) -> str | float | None:
    """Take the material's name or index from a row; whether there is such a one is for the optics to say."""
    material: str | None
    material, index = values.pop("material", None), values.pop("index", None)
    if index is None:
        return material
    if material is not None:
        raise InputError("must be empty where the material is named", key="index", value=index)
    if not 1 < index <= sys.float_info.max:
        raise InputError("must be a refractive index, above 1", key="index", value=index)
    return float(index)


def _join_girdle(values: dict[str, Any]) -> None:
    """Make one girdle of its thinnest and thickest, where it is in two columns."""
    ends = [values.pop(key, None) for key in ("girdle_thin", "girdle_thick")]
    if any(ends) and "girdle" not in values:
        values["girdle"] = " to ".join(end for end in ends if end)


# ---- Notes ---------------------------------------------------------------------------------------------


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


def _unused(columns: Columns) -> Iterator[str]:
    if columns.unused:
        yield f"columns not used: {', '.join(columns.unused)}"


def _kind(assumed: Assumed) -> tuple[str, str, str]:
    """Return an assumption's name, its value where that is the same in every row, and the reason."""
    derived = assumed.why.startswith("(depth")
    return assumed.what, "" if derived else f"{assumed.value:.3g}", assumed.why


def _assumed(counts: Counter[tuple[str, str, str]], rows: int) -> Iterator[str]:
    """Say what was assumed in how many rows: a note a kind, unless there are many."""
    by_name: dict[str, list[tuple[str, int]]] = {}
    for (what, value, why), number in counts.most_common():
        words = " ".join(part for part in (what, value, why) if part)
        by_name.setdefault(f"{what} {'of words' if why.startswith('of') else why}", []).append(
            (words, number)
        )
    for together, kinds in by_name.items():
        if len(kinds) <= _KINDS_LISTED:
            yield from (f"assumed in {number} of {rows} rows: {words}" for words, number in kinds)
        else:
            yield f"assumed in {sum(number for _, number in kinds)} of {rows} rows: {together}"

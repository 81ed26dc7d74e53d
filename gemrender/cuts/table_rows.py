"""A row of a table of stones, from its cells to what a report states."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from gemrender.cuts.columns import SIZE_ALIASES, Columns
from gemrender.cuts.delimited import Dialect
from gemrender.cuts.fancy_reports import FancyReport
from gemrender.cuts.fancy_rows import FancyRow
from gemrender.cuts.laboratory import DEPTH_RANGE, Report, read_report
from gemrender.cuts.measurements import SIZE_KEYS, read_measurements, read_size
from gemrender.cuts.shape_words import Shape, read_shape
from gemrender.cuts.size import SQUARE
from gemrender.errors import InputError

__all__ = ["NUMBER", "TableRow"]

_WORDS = ("girdle", "girdle_thickness")
#: Read as they are; all other columns hold numbers.
_TEXT = {"name", "material", "shape", "culet", "girdle_thin", "girdle_thick", *_WORDS}
_EMPTY = {"", "-", "--", "\u2013", "\u2014", ".", "n/a", "na", "#n/a", "nan", "null", "unknown", "?"}
NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(%|pct|percent|[°º˚]|deg|degrees)?")
#: Units of sizes, and the 1 of "1.36 : 1".
_SIZE_UNIT = re.compile(r"\s*(?:mm|cts?|carats?|:\s*1(?:\.0+)?)\.?$", re.IGNORECASE)
_PER_CENT, _DEGREES = {"%", "pct", "percent"}, {"°", "º", "˚", "deg", "degrees"}


class TableRow:
    """A row being read.

    Attributes
    ----------
    values : dict
        What it states, by key of `ALIASES`.
    material : str, float or None
        Its material or index.
    size_mm : float
        Its size [mm]; 0 where that is not known.
    used : set of str
        Keys of the columns that it has used of those that round brilliants do without.
    report : FancyReport or None
        What was read of a stone that is not round.
    notes : tuple of str
        What is to be told of it: a weight that differs.
    """

    def __init__(self, columns: Columns, cells: list[str], dialect: Dialect) -> None:
        if len(cells) != len(dialect.header):
            found = f"{len(cells)} columns, the header {len(dialect.header)}"
            raise InputError(f"has {found}, with {dialect.separated_by} between them")
        self._dialect, self._title = dialect, columns.title
        self._raw = {key: cells[i] for key, i in columns.place.items()}
        self._others = {key: cells[i] for key, i in columns.others.items()}
        self.size_mm = 0.0
        self.used: set[str] = set()
        self.report: FancyReport | None = None
        self.notes: tuple[str, ...] = ()
        with self._told():
            self.values: dict[str, Any] = {
                key: value
                for key, cell in self._raw.items()
                if (value := _value(key, cell, dialect)) is not None
            }
            self.material = _material(self.values)

    def read(self, lacks: str, *, suggests: bool = True) -> Report | FancyRow:
        """Read the report of the row.

        Parameters
        ----------
        lacks : str
            Which columns there are none of that a round stone needs.
        suggests : bool
            As of `fancy_stone`.

        Raises
        ------
        InputError
            By the column's own title.
        """
        with self._told():
            _join_girdle(self.values)
            shape = read_shape(self.values["shape"]) if "shape" in self.values else None
            if shape is not None and not shape.is_round_brilliant:
                return self._fancy(shape, suggests)
            if lacks:
                word = self.values.get("shape", ...)
                raise InputError(f"is round, and needs columns for {lacks}", key="shape", value=word)
            report = read_report(self.values)
            self._find_diameter()
            return report

    def _fancy(self, shape: Shape, suggests: bool) -> FancyRow:
        sizes: dict[str, Any] = {}
        for key, cell in self._others.items():
            value = _other(key, cell, self._dialect)
            if value is None or not _may_be(shape.kind, key, value):
                continue
            (sizes if key in SIZE_KEYS else self.values)[key] = value
            self.used.add(key)
        depth = self.values.get("depth")
        in_mm = isinstance(depth, float) and depth < DEPTH_RANGE[0]
        if in_mm and sizes.keys() - {"carat", "depth_mm"}:
            sizes.setdefault("depth_mm", self.values.pop("depth"))
        row = FancyRow(shape, self.values, read_size(sizes) if sizes else None)
        stone, self.report = row.stone(suggests=suggests, material=self.material)
        self.size_mm, self.notes = stone.size_mm or 0.0, stone.notes
        self.used -= set(self.report.passed_over)
        return row

    def _find_diameter(self) -> None:
        """Find the diameter of a round stone, if the row has measurements that make one."""
        cell = self._others.get("measurements")
        if not cell:
            return
        try:
            numbers, _ = read_measurements(cell)
        except InputError:  # as ever: of no use for the proportions
            return
        if max(numbers[:2]) <= SQUARE * min(numbers[:2]):
            self.size_mm = 0.5 * sum(numbers[:2])
            self.used.add("measurements")

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Tell errors by the titles of the columns."""
        try:
            yield
        except InputError as error:
            told = InputError(error.allowed, key=error.key, value=error.value)
            raw = self._others | self._raw
            if error.key in raw:
                told.key, told.value = self._title[error.key], raw[error.key]
                if raw[error.key] in ("0", "0.0", "0.00"):
                    told.allowed += "; leave it empty where it is not known"
            raise told from error


# ---- Cells ---------------------------------------------------------------------------------------------


def _may_be(kind: Any, key: str, value: str | float) -> bool:
    """Whether a word may be meant for a choice of a family: lists have columns such as Style of their own."""
    part = getattr(kind, "__dataclass_fields__", {}).get(key)
    words = part.metadata.get("allowed", ()) if part is not None else ()
    return key in SIZE_ALIASES or not isinstance(value, str) or value.strip().casefold() in words


def _other(key: str, cell: str, dialect: Dialect) -> str | float | None:
    """Return what a cell of a size, or of a family's own key, holds; None for nothing."""
    if cell.casefold() in _EMPTY:
        return None
    if key == "measurements":
        return cell
    if key in SIZE_ALIASES:
        return _value(key, _SIZE_UNIT.sub("", cell), dialect)
    try:
        return _value(key, cell, dialect)
    except InputError:
        return cell  # a word, if it is one of the family's


def _value(key: str, cell: str, dialect: Dialect) -> str | float | None:
    """Return what a cell holds; None for nothing."""
    if cell.casefold() in _EMPTY:
        return None
    if key in _TEXT and key not in _WORDS:
        return cell
    text = cell.replace("\u00a0", " ").replace("\u202f", " ")
    if dialect.decimal_comma and "." not in text:
        text = text.replace(",", ".")
    number = NUMBER.fullmatch(text)
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

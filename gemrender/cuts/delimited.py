"""Delimited text, as spreadsheets and shops write it, read a row at a time."""

from __future__ import annotations

import codecs
import csv
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from gemrender.errors import InputError
from gemrender.reading import reason

__all__ = ["MOST_COLUMNS", "MOST_TABLE_BYTES", "Dialect", "open_rows", "sniff"]

#: Largest table [bytes]: 100,000 rows of 60 columns take 60 MB.
MOST_TABLE_BYTES = 1_000_000_000
#: Most columns of a table; those of the trade have about 100.
MOST_COLUMNS = 500
#: Longest line [characters].
LONGEST_LINE = 1_000_000

_CHUNK = 1 << 16
_DELIMITERS = (",", ";", "\t")
_NAMES = {",": "commas", ";": "semicolons", "\t": "tabs"}


@dataclass(frozen=True, slots=True)
class Dialect:
    """How a table is written.

    Parameters
    ----------
    encoding : str
        Its encoding, as Python calls it.
    delimiter : str
        A comma, a semicolon or a tab.
    header : list of str
        The cells of its first row.
    header_line : int
        The line that the header ends on.
    """

    encoding: str
    delimiter: str
    header: list[str]
    header_line: int

    @property
    def decimal_comma(self) -> bool:
        """Whether numbers may have a comma for the point: where columns are not separated by commas."""
        return self.delimiter != ","

    @property
    def separated_by(self) -> str:
        """What stands between the columns, in words."""
        return _NAMES[self.delimiter]


def sniff(path: Path, missing: str = "no such file") -> Dialect:
    """Find out how a table is written: UTF-8, UTF-16 with a mark, or Windows-1252; and its delimiter.

    Lines before the header that are blank or begin with # are passed over, and Excel's line "sep=;" obeyed.
    The delimiter is the one that the header has most of, outside quotes.

    Raises
    ------
    InputError
        No such file, no row, too many columns, or too large. It has no source.
    """
    encoding = _encoding(path, missing)
    with _text(path, encoding) as file:
        forced, before = "", 0
        for line in _lines(file):
            bare = line.strip(" \t\r\n,;\ufeff")
            if bare.lower().startswith("sep="):
                forced = line.lstrip("\ufeff")[4:5]
            elif bare and not (bare.startswith("#") and not _has_delimiter(bare)):
                break
            before += 1
        else:
            raise InputError("is empty")
    delimiter = forced if forced in _DELIMITERS else _delimiter(line)
    with open_rows(path, Dialect(encoding, delimiter, [], before)) as rows:
        try:
            end, header = next(rows)
        except StopIteration:
            raise InputError("is empty") from None
    if len(header) > MOST_COLUMNS:
        raise InputError(f"has {len(header)} columns; at most {MOST_COLUMNS} are allowed", key="header")
    return Dialect(encoding, delimiter, header, end)


@contextmanager
def open_rows(path: Path, dialect: Dialect) -> Iterator[Iterator[tuple[int, list[str]]]]:
    """Open the rows after a table's header: the line that each ends on, and its cells without blanks around.

    Raises
    ------
    InputError
        The text is not what it was when `sniff` read it, or no CSV. It has no source.
    """
    with _text(path, dialect.encoding) as file:
        yield _rows(file, dialect)


def _rows(file: TextIO, dialect: Dialect) -> Iterator[tuple[int, list[str]]]:
    lines = _lines(file)
    for _ in range(dialect.header_line):
        next(lines, None)
    reader = csv.reader(lines, delimiter=dialect.delimiter, skipinitialspace=True, strict=True)
    while True:
        try:
            cells = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            raise InputError(
                f"is not CSV: {error}", key=f"line {dialect.header_line + reader.line_num}"
            ) from error
        cells = [cell.strip() for cell in cells]
        if any(cells):
            yield dialect.header_line + reader.line_num, cells


def _lines(file: TextIO) -> Iterator[str]:
    """Yield the lines, however they end; none is too long to be kept."""
    number = 0
    while True:
        number += 1
        try:
            line = file.readline(LONGEST_LINE + 1)
        except UnicodeError as error:
            raise InputError(
                "is not the text that the file's first bytes say", key=f"line {number}"
            ) from error
        except OSError as error:
            raise InputError(f"cannot be read ({reason(error)})") from error
        if not line:
            return
        if len(line) > LONGEST_LINE:
            raise InputError(f"is longer than {LONGEST_LINE} characters", key=f"line {number}")
        yield line


@contextmanager
def _text(path: Path, encoding: str) -> Iterator[TextIO]:
    try:
        # Universal newlines: old Macs' ends of lines, too. Bytes that are no text come through as what cannot
        # be printed: they are refused in the columns that are used.
        errors = "surrogateescape" if encoding == "cp1252" else "strict"
        file = path.open(encoding=encoding, errors=errors, newline=None)
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read ({reason(error)})") from error
    with file:
        yield file


def _encoding(path: Path, missing: str) -> str:
    """Return the encoding of a file, read once from end to end."""
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise InputError("must be a file, not a folder, pipe or device")
        if status.st_size > MOST_TABLE_BYTES:
            raise InputError(f"is no table of stones: larger than {MOST_TABLE_BYTES} bytes")
        with path.open("rb") as file:
            start = file.read(4)
            if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
                return "utf-16"
            file.seek(0)
            decoder = codecs.getincrementaldecoder("utf-8")()
            while chunk := file.read(_CHUNK):
                decoder.decode(chunk)
            decoder.decode(b"", final=True)
    except InputError:
        raise
    except UnicodeDecodeError:
        return "cp1252"
    except FileNotFoundError as error:
        raise InputError(missing) from error
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        raise InputError(f"cannot be read ({reason(error)})") from error
    return "utf-8-sig"


def _delimiter(line: str) -> str:
    outside = "".join(line.split('"')[::2])
    return max(_DELIMITERS, key=outside.count)


def _has_delimiter(line: str) -> bool:
    return any(delimiter in line for delimiter in _DELIMITERS)

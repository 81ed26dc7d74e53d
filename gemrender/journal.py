"""Journals: what a long work has found, kept as it is found, so that the work can be stopped and go on."""

from __future__ import annotations

import contextlib
import io
import json
import logging
import os
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from gemrender.errors import InputError
from gemrender.reading import open_file, reason
from gemrender.writing import write_whole

__all__ = ["MOST_BYTES", "Journal", "OtherWorkError"]

#: Largest journal [bytes]: 100,000 entries of a study take 5 MB, those of a film 10 MB.
MOST_BYTES = 256_000_000

_log = logging.getLogger("gemrender")


class OtherWorkError(InputError):
    """A journal is of another work than the one that it is opened for."""


class Journal:
    """A file of JSON lines: first what the work is, then an entry for each result, as it came.

    It is safe against what can happen to such a file. Lines that are no entries, as the last one where the
    work was killed, are left out, and told by the logger `gemrender`; what they held is missing in `known`,
    and so done again. A file that ends within its first line is begun anew, since it holds nothing. While it
    is open, no other process can open it.

    Parameters
    ----------
    path : Path
        The file, in a folder that is there; begun where it is missing.
    head : dict
        All that the results depend on, of JSON's types. A journal with another head is refused.
    entry : callable
        Given what a line holds (of JSON's types; numbers are finite), returns the entry's key and its value;
        raises ValueError or TypeError if it is none. Of two entries with one key, the later one counts.
    work : str
        What the journal is of, as in "is the journal of another study".

    Attributes
    ----------
    known : dict
        Value by key.

    Raises
    ------
    OtherWorkError
        It is of another work.
    InputError
        It is no journal, in use, or cannot be read or written.
    """

    def __init__(
        self, path: Path, head: dict[str, Any], entry: Callable[[Any], tuple[Any, Any]], *, work: str
    ) -> None:
        self.path, self._work = path, work
        self.known: dict[Any, Any] = {}
        self._file = self._opened()
        try:
            self._read(json.dumps(head), entry)
        except BaseException:
            self.close()
            raise

    def add(self, *line: Any) -> None:
        """Add an entry, written as a list; it is in the file when this returns.

        Raises
        ------
        InputError
            It cannot be written.
        """
        data = (json.dumps(line, allow_nan=False) + "\n").encode()
        try:
            while data:
                data = data[self._file.write(data) :]
        except OSError as error:
            raise self._refused(f"cannot be written ({reason(error)})") from error

    def remove(self) -> None:
        """Remove the file, at the end of a work that has its results elsewhere."""
        if sys.platform == "win32":  # which removes no open file
            self.close()
        self.path.unlink(missing_ok=True)
        self.close()

    def close(self) -> None:
        """Let others open it."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # ---- Reading ----

    def _read(self, head: str, entry: Callable[[Any], tuple[Any, Any]]) -> None:
        """Take up what is there; where that is not as it should be, write it anew without what is wrong."""
        data = self._data()
        first, end, rest = data.partition(b"\n")
        try:
            is_same = _parsed(first) == json.loads(head)
        except (ValueError, RecursionError):
            if not _holds_nothing(data, head):
                raise self._refused(self._damage(rest, entry)) from None
            self._write_anew([head])
            return
        if not is_same:
            allowed = f"is the journal of another {self._work}; remove it, or name another folder"
            raise OtherWorkError(allowed, source=str(self.path))
        good, bad = [head], 0
        for line in rest.split(b"\n"):
            if not line.strip():
                continue
            try:
                key, value = entry(_parsed(line))
            except (ValueError, TypeError, RecursionError):
                bad += 1
                continue
            self.known[key] = value
            good.append(line.decode())
        if bad:
            lines = "a line that is no entry is" if bad == 1 else f"{bad} lines that are no entries are"
            _log.warning("%s: %s left out; what was there is done again", self.path, lines)
        if bad or not end or (rest and not rest.endswith(b"\n")):
            self._write_anew(good)

    def _data(self) -> bytes:
        if os.fstat(self._file.fileno()).st_size > MOST_BYTES:
            raise self._refused(f"is not the journal of a {self._work}: larger than {MOST_BYTES} bytes")
        try:
            return self._file.readall()
        except OSError as error:
            raise self._refused(f"cannot be read ({reason(error)})") from error

    def _damage(self, rest: bytes, entry: Callable[[Any], tuple[Any, Any]]) -> str:
        """Say what is wrong with a file of which the first line cannot be read."""
        for line in rest.split(b"\n"):
            with contextlib.suppress(ValueError, TypeError, RecursionError):
                entry(_parsed(line))
                return (
                    f"has entries of a {self._work}, but the first line, which says of which, is damaged; "
                    "mend that, or remove the file"
                )
        return f"is not the journal of a {self._work}"

    # ---- The file ----

    def _opened(self) -> io.FileIO:
        """Open the file for reading and appending, for this process alone."""
        while True:
            try:
                file = open_file(self.path, os.O_RDWR | os.O_APPEND | os.O_CREAT)
            except InputError:
                raise
            except (OSError, ValueError) as error:  # ValueError: a path with a null character
                raise self._refused(f"cannot be written ({reason(error)})") from error
            try:
                if not _locked(file.fileno()):
                    raise self._refused("is in use: another gemrender is at the same work")
                if _is_at(file.fileno(), self.path):
                    return file
            except BaseException:
                file.close()
                raise
            file.close()  # replaced between opening and locking

    def _write_anew(self, lines: Iterable[str]) -> None:
        """Replace the file, whole."""
        text = "".join(line + "\n" for line in lines)
        if sys.platform == "win32":  # which replaces no open file
            self.close()
        write_whole(
            self.path.parent,
            {self.path.name: lambda path: path.write_text(text, encoding="utf-8", newline="\n")},
        )
        # Kept locked until here; who locks the new one first goes on with all that was known.
        self.close()
        self._file = self._opened()
        self._file.seek(0, os.SEEK_END)

    def _refused(self, allowed: str) -> InputError:
        return InputError(allowed, source=str(self.path))


def _parsed(line: bytes) -> Any:
    """Return what a line of JSON holds; ValueError for one that is none, or has NaN or infinite numbers."""

    def number(text: str) -> float:
        if (value := float(text)) - value != 0:
            raise ValueError("is not finite")
        return value

    return json.loads(line.decode(), parse_constant=number, parse_float=number)


def _holds_nothing(data: bytes, head: str) -> bool:
    """Whether a file is blank (a crash of the machine leaves zeros) or one line that was to be a head."""
    begun = data.strip(b"\0 \r\n")
    name = head[: head.index(":")].encode()  # of the first key: heads of other works of this kind begin alike
    return b"\n" not in begun and (name.startswith(begun) or begun.startswith(name))


def _is_at(descriptor: int, path: Path) -> bool:
    """Whether an open file is still the one of that name."""
    try:
        there = path.stat()
    except OSError:
        return False
    return os.path.samestat(os.fstat(descriptor), there)


def _locked(descriptor: int) -> bool:
    """Lock an open file for this process; False where another one has it. It is freed when it is closed."""
    if sys.platform == "win32":
        import msvcrt

        # A byte far beyond its end: on Windows, locked bytes cannot be read by others.
        os.lseek(descriptor, 2 * MOST_BYTES, os.SEEK_SET)
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        finally:
            os.lseek(descriptor, 0, os.SEEK_SET)
        return True
    import fcntl

    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True

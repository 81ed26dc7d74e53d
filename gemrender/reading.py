"""Files of user input: read as text and TOML, and refused in one line that says what is allowed."""

from __future__ import annotations

import contextlib
import difflib
import io
import os
import stat
import tomllib
from collections.abc import Callable, Collection, Iterator
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from gemrender.errors import InputError
from gemrender.mistakes import Mistakes

__all__ = [
    "LONGEST_LINE",
    "MOST_BYTES",
    "bundled_files",
    "did_you_mean",
    "located_at",
    "open_file",
    "parse_toml",
    "read_bytes",
    "read_lines",
    "reason",
    "refuse_missing",
    "refuse_unknown",
    "section",
    "stem",
    "text_line",
]

#: Largest file [bytes]; 57 vertices with all their digits take less than 5000, a spectrum of 1000 rows 20000.
MOST_BYTES = 1_000_000
#: Longest line unless a kind of file needs longer ones [characters]. It also keeps numbers printable: Python
#: refuses to print integers of more than 4300 digits, and TOML's hexadecimal ones may have any number. (A
#: line of 3500 characters is still short enough for that.)
LONGEST_LINE = 1000


# ---- Text ----------------------------------------------------------------------------------------------


def read_lines(
    path: Path, *, kind: str, missing: str = "no such file", longest_line: int = LONGEST_LINE
) -> list[str]:
    """Read the lines of a text file in UTF-8, with or without a byte order mark, however they end.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        What it is a file of, as in "is no stone file".
    missing : str
        What to say where there is no such file.
    longest_line : int
        Longest line that is allowed [characters].

    Returns
    -------
    list of str
        The lines, without their ends.

    Raises
    ------
    InputError
        No such file, one that cannot be read, larger than `MOST_BYTES`, no UTF-8, blank, or with a line that
        is too long. Its source is the file.
    """
    source = str(path)
    data = read_bytes(path, kind=kind, missing=missing)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"must be text in UTF-8; byte {error.start + 1} is not", source=source) from error
    if not text.strip():
        raise InputError("is empty", source=source)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    for number, line in enumerate(lines, start=1):
        if len(line) > longest_line:
            raise InputError(
                f"is {len(line)} characters long; at most {longest_line} are allowed",
                source=source,
                key=f"line {number}",
            )
    return lines


def read_bytes(
    path: Path, *, kind: str, missing: str = "no such file", most_bytes: int = MOST_BYTES
) -> bytes:
    """Read a file whole.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        What it is a file of, as in "is no stone file".
    missing : str
        What to say where there is no such file.
    most_bytes : int
        Largest file that is allowed [bytes].

    Raises
    ------
    InputError
        No such file, one that cannot be read, or larger than `most_bytes`. Its source is the file.
    """
    source = str(path)
    try:
        with open_file(path) as file:
            data = _whole(file, most_bytes + 1)
    except FileNotFoundError as error:
        raise InputError(missing, source=source) from error
    except InputError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        raise InputError(f"cannot be read ({reason(error)})", source=source) from error
    if len(data) > most_bytes:
        raise InputError(f"is no {kind} file: larger than {most_bytes} bytes", source=source)
    return data


def _whole(file: io.FileIO, most: int) -> bytes:
    """Read up to so many bytes; one call of an unbuffered file may return fewer than there are."""
    parts = []
    while most > 0 and (part := file.read(most)):
        parts.append(part)
        most -= len(part)
    return b"".join(parts)


def open_file(path: Path, flags: int = os.O_RDONLY) -> io.FileIO:
    """Open a file, unbuffered; refuse what is none, such as a pipe, without ever waiting for its other end.

    Parameters
    ----------
    path : Path
        The file.
    flags : int
        As `os.open` takes them.

    Raises
    ------
    InputError
        It is a pipe, a socket or a device.
    OSError, ValueError
        As `open` raises them.
    """
    with contextlib.suppress(OSError):  # told by what follows
        _refuse_special(path.stat().st_mode, path)

    def opener(name: str, _: int) -> int:
        # Should it have become a pipe meanwhile, no waiting.
        return os.open(name, flags | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_NONBLOCK", 0), 0o666)

    writes = flags & (os.O_WRONLY | os.O_RDWR)
    file = io.FileIO(path, "r+" if writes else "r", opener=opener)
    try:
        _refuse_special(os.fstat(file.fileno()).st_mode, path)
    except InputError:
        file.close()
        raise
    return file


def _refuse_special(mode: int, path: Path) -> None:
    for is_it, what in (
        (stat.S_ISFIFO, "pipe"),
        (stat.S_ISSOCK, "socket"),
        (stat.S_ISCHR, "device"),
        (stat.S_ISBLK, "device"),
    ):
        if is_it(mode):
            raise InputError(f"must be a file, not a {what}", source=str(path))


def reason(error: Exception) -> str:
    """Return why a file could not be read or written, without the path that the error may name."""
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def stem(path: Path, default: str) -> str:
    """Name something after its file, without what cannot be printed (as file names may have).

    Parameters
    ----------
    path : Path
        The file.
    default : str
        The name where nothing is left of the file's.
    """
    return "".join(c if c.isprintable() else "?" for c in path.stem).strip() or default


# ---- TOML ----------------------------------------------------------------------------------------------


def parse_toml(lines: list[str], *, kind: str) -> dict[str, Any]:
    """Return the top table of a TOML file.

    Parameters
    ----------
    lines : list of str
        The file's lines, as `read_lines` returns them.
    kind : str
        What it is a file of, as in "is not TOML that makes a stone".

    Raises
    ------
    InputError
        It is not TOML, or nested too deeply. It has no source: see `located_at`.
    """
    try:
        return tomllib.loads("\n".join(lines))
    except ValueError as error:  # TOMLDecodeError is one; so is the refusal of an integer with 4300 digits
        raise InputError(f"is not TOML: {error}") from error
    except RecursionError as error:
        raise InputError(f"is not TOML that makes a {kind}: nested too deeply") from error


@contextlib.contextmanager
def located_at(source: str | None, section: str | None = None) -> Iterator[None]:
    """Tell input errors as coming from a file, and a section of it, unless they know their own source.

    Parameters
    ----------
    source : str or None
        The file; None leaves it to a `located_at` around this one.
    section : str, optional
        Name of the section, put before the error's key.

    Raises
    ------
    InputError
        Whatever one is raised within.
    """
    try:
        yield
    except InputError as error:
        if error.source is not None:
            raise
        told = error.at("", section)
        told.source = source
        raise told from error


def section(
    top: dict[str, Any],
    name: str,
    keys: Collection[str],
    hint: Callable[[str], str] | None = None,
    mistakes: Mistakes | None = None,
) -> dict[str, Any]:
    """Return a section that is there, with none but known keys.

    Parameters
    ----------
    top : dict
        The table that has the section.
    name : str
        Name of the section.
    keys : collection of str
        Its keys, in the order to tell them in.
    hint : callable, optional
        As `refuse_unknown` takes it.
    mistakes : Mistakes, optional
        What keeps unknown keys, which are then left out, for the others to be checked too; without it they
        are refused at once.

    Raises
    ------
    InputError
        It is no table, or has unknown keys.
    """
    values = top[name]
    if not isinstance(values, dict):
        raise InputError(
            f"must be a section: a line [{name}], and below it {', '.join(keys)}", key=name, value=values
        )
    if mistakes is None:
        refuse_unknown(values, keys, name, hint)
        return values
    mistakes.of(refuse_unknown, values, keys, name, hint)
    return {key: value for key, value in values.items() if key in keys}


def refuse_unknown(
    values: dict[str, Any],
    known: Collection[str],
    section: str = "",
    hint: Callable[[str], str] | None = None,
) -> None:
    """Refuse a table with a key that is not known.

    Parameters
    ----------
    values : dict
        The table.
    known : collection of str
        The known keys, in the order to tell them in.
    section : str
        Name of the table; none for the file's top.
    hint : callable, optional
        What to add to the message for an unknown key, as in "; it belongs in [angles]". Where it returns
        nothing, and without it, the message ends with the known key that is most like it.

    Raises
    ------
    InputError
        For each unknown key.
    """
    with Mistakes() as mistakes:
        for key, value in values.items():
            if key not in known:
                ending = (hint(key) if hint else "") or did_you_mean(key, known)
                # What is allowed is said once.
                must = "" if mistakes.errors else f"; must be one of {', '.join(known)}"
                name = f"{section}.{key}" if section else key
                mistakes.add(InputError(f"unknown key{must}{ending}", key=name, value=value))


def refuse_missing(values: dict[str, Any], needed: Collection[str], section: str) -> None:
    """Refuse a section without all the keys that it needs.

    Parameters
    ----------
    values : dict
        The section.
    needed : collection of str
        The keys, in the order to tell them in.
    section : str
        Name of the section.

    Raises
    ------
    InputError
        Says all that are missing.
    """
    if missing := [key for key in needed if key not in values]:
        raise InputError(f"missing {', '.join(missing)}; needs {', '.join(needed)}", key=f"[{section}]")


def text_line(values: dict[str, Any], key: str, default: str, most: int, *, empty: bool = False) -> str:
    """Return a text of one line, without the blanks around it.

    Parameters
    ----------
    values : dict
        The table that may have the text.
    key : str
        Its key.
    default : str
        The text where there is none; it has to be such a line too.
    most : int
        Longest text that is allowed [characters].
    empty : bool
        Whether it may be blank.

    Raises
    ------
    InputError
        It is no text, not printable on one line, too long, or blank where it may not be.
    """
    text = values.get(key, default)
    good = isinstance(text, str) and text.isprintable() and len(text) <= most and (empty or text.strip())
    if not good:
        length = f"at most {most}" if empty else f"1 to {most}"
        raise InputError(f"must be one line of {length} characters", key=key, value=text)
    return str(text).strip()


def did_you_mean(word: str, known: Collection[str], most: int = 1) -> str:
    """Return the ending of a message that guesses at what was meant, or nothing.

    Parameters
    ----------
    word : str
        What was written.
    known : collection of str
        What could be meant.
    most : int
        Most guesses; where there are several, names that begin with the word count, too.
    """
    close = difflib.get_close_matches(word, known, n=most)
    if most > 1 and word:
        close += [name for name in sorted(known) if name.startswith(word) and name not in close]
    *others, last = close[:most] or [""]
    return f"; did you mean {', '.join(others)}{' or ' if others else ''}{last}?" if last else ""


# ---- Bundled files -------------------------------------------------------------------------------------


def bundled_files(folder: str) -> dict[str, Path]:
    """Return the TOML files that come with gemrender: in the package when installed, beside it in a checkout.

    Parameters
    ----------
    folder : str
        Folder within `scenes`; "" is `scenes` itself, where the stones are.

    Returns
    -------
    dict of str to Path
        File by its name without .toml, in alphabetical order; none where there is no such folder.
    """
    scenes = bundled_folder(folder)
    return dict(_by_name(scenes)) if scenes else {}


@cache  # half of the time that a bundled stone takes to load
def _by_name(folder: Path) -> dict[str, Path]:
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def bundled_folder(folder: str) -> Path | None:
    """Return a folder within `scenes` ("" is `scenes` itself); None where there is no `scenes`."""
    package = Path(str(resources.files("gemrender")))
    scenes = next((f for f in (package / "scenes", package.parent / "scenes") if f.is_dir()), None)
    return scenes / folder if scenes else None

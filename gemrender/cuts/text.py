"""Text as other programs write it: encodings, numbers, lines."""

from __future__ import annotations

import re

from gemrender.errors import InputError

__all__ = ["decoded", "number_of", "number_text", "one_line"]

_NUMBER = re.compile(r"[-+]?(\d+([.,]\d*)?|[.,]\d+)([eE][-+]?\d{1,3})?")


def decoded(data: bytes) -> str:
    """Return the text of a file in UTF-8, UTF-16 with a byte order mark, or Windows-1252.

    Line ends become LF.

    Raises
    ------
    InputError
        It is no text: it has null characters.
    """
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        text = data.decode("utf-16", errors="replace")
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("cp1252", errors="replace")
    if "\0" in text:
        raise InputError("is no text: it has null characters")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def number_of(token: str) -> float | None:
    """Return the finite number that a word is, or None; a decimal comma and a long minus are read too.

    Parameters
    ----------
    token : str
        The word. "nan", "inf" and "1_000", which `float` takes, are none.
    """
    token = token.replace("\u2212", "-")
    if len(token) > 60 or not token.isascii() or not _NUMBER.fullmatch(token):
        return None
    number = float(token.replace(",", "."))
    return number if abs(number) < float("inf") else None


def number_text(number: float | complex, decimals: int = 0) -> str:
    """Return a number with so many decimals, or with all that it needs to be read again to the last bit."""
    value = float(number.real)
    text = f"{value:.{decimals}f}"
    return text if float(text) == value else repr(value)


def one_line(text: str) -> str:
    """Return a text without line ends and other characters that cannot be printed."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())

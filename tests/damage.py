"""Files damaged at random: bytes flipped, cut short, parts lost, doubled and swapped, numbers changed."""

from __future__ import annotations

import re
import struct

from hypothesis import strategies as st

_NUMBER = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
#: What a number is replaced by in text, and in binary files.
WORDS = [
    b"nan",
    b"inf",
    b"-1e400",
    b"1e308",
    b"-0",
    b"0",
    b"",
    b"1e-320",
    b"99999999999999",
    b"\xb0",
    b"n",
    b"G",
]
PATTERNS = [struct.pack("<d", x) for x in (float("nan"), float("inf"), -1e308, 0.0, -99999.0, 5e-324)] + [
    struct.pack("<i", n) for n in (-1, 0, 1, 2**31 - 1, -(2**31), 65536)
]


@st.composite
def damaged(draw: st.DrawFn, whole: bytes) -> bytes:
    """Draw damaged contents of a file; `whole` are the right ones."""
    data = whole
    for _ in range(draw(st.integers(1, 3))):
        data = draw(st.sampled_from(_WAYS))(draw, data)
    return data


def _place(draw: st.DrawFn, data: bytes) -> int:
    return draw(st.integers(0, max(len(data) - 1, 0)))


def _flip(draw: st.DrawFn, data: bytes) -> bytes:
    out = bytearray(data)
    for _ in range(draw(st.integers(1, 5))):
        if out:
            out[_place(draw, data)] ^= draw(st.integers(1, 255))
    return bytes(out)


def _cut_short(draw: st.DrawFn, data: bytes) -> bytes:
    return data[: _place(draw, data)]


def _part(draw: st.DrawFn, data: bytes) -> tuple[int, int]:
    begin = _place(draw, data)
    return begin, min(len(data), begin + draw(st.sampled_from([1, 4, 8, 28, 50, 300])))


def _lose(draw: st.DrawFn, data: bytes) -> bytes:
    begin, end = _part(draw, data)
    return data[:begin] + data[end:]


def _double(draw: st.DrawFn, data: bytes) -> bytes:
    begin, end = _part(draw, data)
    return data[:end] + data[begin:end] + data[end:]


def _lines(draw: st.DrawFn, data: bytes) -> bytes:
    lines = data.split(b"\n")
    a, b = (draw(st.integers(0, len(lines) - 1)) for _ in range(2))
    way = draw(st.sampled_from(["lose", "double", "swap"]))
    if way == "lose":
        del lines[a]
    elif way == "double":
        lines.insert(b, lines[a])
    else:
        lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


def _numbers(draw: st.DrawFn, data: bytes) -> bytes:
    found = list(_NUMBER.finditer(data))
    if not found:
        return data
    one, other = (found[draw(st.integers(0, len(found) - 1))] for _ in range(2))
    new = draw(st.sampled_from([other.group(), b"-" + one.group(), one.group() + b"0", *WORDS]))
    return data[: one.start()] + new + data[one.end() :]


def _pattern(draw: st.DrawFn, data: bytes) -> bytes:
    begin = _place(draw, data)
    new = draw(st.sampled_from(PATTERNS))
    return data[:begin] + new + data[begin + len(new) :]


_WAYS = [_flip, _cut_short, _lose, _double, _lines, _numbers, _pattern]

"""Messages between server and page: a header in JSON, and behind it arrays as they are in memory.

    4 bytes       length of the header [bytes], little-endian
    header        JSON; its `arrays` tell of each array name, type, shape, and where behind the header it is
    arrays        each beginning at a multiple of 8 bytes, little-endian

What a page sends is the same, or, without arrays, JSON as text.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

from gemrender.errors import InputError

__all__ = ["MOST_HEADER", "MOST_MESSAGE", "packed", "unpacked"]

#: Longest header that a page may send, and longest message of all, with a dropped file in it [bytes].
MOST_HEADER, MOST_MESSAGE = 1 << 20, 33 * 1024 * 1024
_ALIGNED = 8


def packed(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray] | None = None) -> bytes:
    """Return a message.

    Parameters
    ----------
    header : mapping
        For JSON; numbers that are none become null.
    arrays : mapping of str to array, optional
        Of numbers.
    """
    told, parts, place = [], [], 0
    for name, values in (arrays or {}).items():
        data = np.ascontiguousarray(values)
        data = data.astype(data.dtype.newbyteorder("<"), copy=False)
        told.append({"name": name, "type": data.dtype.name, "shape": data.shape, "at": place})
        parts.append(data.tobytes() + b"\0" * (-data.nbytes % _ALIGNED))
        place += len(parts[-1])
    text = json.dumps(_finite({**header, "arrays": told}), allow_nan=False, separators=(",", ":")).encode()
    text += b" " * (-(len(text) + 4) % _ALIGNED)
    return b"".join([struct.pack("<I", len(text)), text, *parts])


def unpacked(message: str | bytes) -> tuple[dict[str, Any], bytes]:
    """Return the header of what a page sent, and the bytes behind it.

    Raises
    ------
    InputError
        It is no such message, or too long.
    """
    if len(message) > MOST_MESSAGE:
        raise InputError("is longer than allowed", key="message")
    behind = b""
    text: str | bytes = message
    if isinstance(message, bytes):
        length = struct.unpack_from("<I", message)[0] if len(message) >= 4 else -1
        if not 0 < length <= len(message) - 4:
            raise InputError("has no header", key="message")
        text, behind = message[4 : 4 + length], message[4 + length :]
    if len(text) > MOST_HEADER:
        raise InputError("has a header that is longer than allowed", key="message")
    try:
        header = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError("is no JSON", key="message") from error
    if not isinstance(header, dict) or not isinstance(header.get("type"), str):
        raise InputError("has no type", key="message")
    return header, behind


def _finite(value: Any) -> Any:
    """Return what JSON can hold: null for NaN and infinities, numpy's numbers as Python's."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): _finite(of) for key, of in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(of) for of in value]
    return value

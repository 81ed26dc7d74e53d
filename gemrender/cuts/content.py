"""What kind a stone file is: told by its content, then by what its name ends in."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

from gemrender.cuts.gem import looks_like_gem
from gemrender.errors import InputError
from gemrender.reading import open_file

__all__ = ["DESIGN_KINDS", "READ_KINDS", "SOLID_KINDS", "kind_of", "kind_of_file"]

#: Kinds that hold a faceter's design, and kinds that hold a surface.
DESIGN_KINDS = ("asc", "gem", "gcs")
SOLID_KINDS = ("stl", "obj", "ply", "glb", "srn")
#: Kinds that are read.
READ_KINDS = ("toml", "csv", "tsv", *DESIGN_KINDS, *SOLID_KINDS)
#: So much of a file is looked at [bytes].
HEAD = 65536

_TIER = re.compile(rb"^\s*a\s+[-+]?\d+(\.\d*)?\s+[-+]?\d*\.?\d+(\s|$)", re.MULTILINE)
_GEAR = re.compile(rb"^\s*g\s*-?\d+(\.\d*)?(\s+-?\d+(\.\d*)?)?\s*$", re.MULTILINE)
_OBJ = re.compile(rb"^v\s+[-+.\deE]+\s+[-+.\deE]+\s+[-+.\deE]+", re.MULTILINE)
_TOML = re.compile(rb"^\s*(\[[\w.\" -]+\]|[\w\"-]+\s*=)", re.MULTILINE)


def kind_of_file(path: Path) -> str | None:
    """Return the kind of a file, or None for one that cannot be read, which its reader tells better.

    Raises
    ------
    InputError
        No reader knows it.
    """
    try:
        with open_file(path) as file:
            head = file.read(HEAD) or b""
        size = path.stat().st_size
    except (OSError, ValueError):
        return None
    if not head.strip():
        return None
    kind = kind_of(head, size, path.suffix)
    if kind is None:
        kinds = ", ".join(f".{kind}" for kind in READ_KINDS)
        raise InputError(f"is none of the kinds of stone file that are read: {kinds}", source=str(path))
    return kind


def kind_of(head: bytes, size: int, suffix: str) -> str | None:
    """Return the kind of a file, or None if no reader knows it.

    Parameters
    ----------
    head : bytes
        Its beginning.
    size : int
        Its length [bytes].
    suffix : str
        What its name ends in, such as ".asc".
    """
    said = suffix.lower().lstrip(".")
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    for kind, is_it in _MARKS.items():
        if is_it(head, text, size):
            return kind
    if said in READ_KINDS:
        return said
    # Files of gemrender's own may be called anything.
    return "toml" if b"\0" not in head and _TOML.search(text) else None


def _is_stl(head: bytes, text: bytes, size: int) -> bool:
    if text[:5].lower() == b"solid" and b"facet" in text[:1000].lower():
        return True
    return len(head) >= 84 and size == 84 + 50 * int.from_bytes(head[80:84], "little") and size > 84


def _is_asc(head: bytes, text: bytes, size: int) -> bool:
    if head[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return b"GemCad".lower() in head[:200].replace(b"\0", b"").lower()
    return text[:6].lower() == b"gemcad" or bool(_TIER.search(text) and _GEAR.search(text))


#: Marks of each kind in a file's beginning, without and with the blanks before it, and in its length.
_MARKS: dict[str, Callable[[bytes, bytes, int], bool]] = {
    "glb": lambda head, text, size: head[:4] == b"glTF",
    "srn": lambda head, text, size: head[:4] == b"SPF ",
    "ply": lambda head, text, size: text[:3] == b"ply" and b"element vertex" in text[:10000],
    "gcs": lambda head, text, size: text[:1] == b"<" and b"<GemCutStudio" in text[:5000],
    "asc": _is_asc,
    "stl": _is_stl,
    "obj": lambda head, text, size: b"\0" not in head and len(_OBJ.findall(text)) >= 3,
    "gem": lambda head, text, size: looks_like_gem(head),
}

"""GemCad's .gem: a solved design, binary, little endian, without a mark at its beginning.

::

    facet*   f64 px, py, pz           p = normal / distance, so the plane is p . x = 1
             i32 tier ; u8 length, bytes "name TAB instruction"
             { i32 1, f64 x, y, z }*  the facet's corners ; i32 0
    f64 -99999.0
    i32 folds, i32 mirror, i32 gear (signed), f64 refractive index, u32 0x7FFF, f64 gear offset,
    8 x (u8 length, bytes)            four headers and four footnotes
    [ u8 7 "preform" and a complete list of facets ]

The planes are what counts: in some files the corners are scaled by 0.81. At the girdle, the sign of pz
(6e-17) says which side the tier is cut on.
"""

from __future__ import annotations

import math
import os
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gemrender.cuts.design import MOST_FACETS, Design
from gemrender.cuts.text import decoded, one_line
from gemrender.cuts.tiers import tiers_of
from gemrender.errors import InputError
from gemrender.reading import located_at, read_bytes
from gemrender.writing import write_whole

__all__ = ["looks_like_gem", "parse_gem", "read_gem", "write_gem"]

#: What stands in the place of px after the last facet.
END_OF_FACETS = -99999.0
#: What the program writes before the offset of the gear.
MARK = 0x7FFF
#: Headers, then as many footnotes.
N_HEADERS = 4
#: Most corners of a facet, and most teeth of a gear: more is no design.
MOST_CORNERS, MOST_TEETH = 10_000, 100_000
_NO_GEMCAD = "is no GemCad .gem file (OctoNus has another .gem, which is not read)"


def read_gem(path: str | os.PathLike[str]) -> Design:
    """Read a GemCad .gem file.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    Design
        The planes as they stand in the file; its `notes` say what was mended.

    Raises
    ------
    InputError
        The file cannot be read, or is none of GemCad's.
    """
    file = Path(path)
    with located_at(str(file)):
        return parse_gem(read_bytes(file, kind="GemCad .gem", most_bytes=10_000_000))


def looks_like_gem(data: bytes) -> bool:
    """Whether the first facet of a .gem file can be read from these bytes, the file's beginning."""
    try:
        _Bytes(data).facet(most_corners=1)
    except InputError:
        return False
    return True


def parse_gem(data: bytes) -> Design:
    """Return the design in the bytes of a .gem file.

    Raises
    ------
    InputError
        They are none of GemCad's. It has no source: see `located_at`.
    """
    file = _Bytes(data)
    facets = file.facets()
    if not facets:
        raise InputError("has no facets")
    folds, mirror, gear = file.take("<iii")
    (index,) = file.take("<d")
    (mark,) = file.take("<I")
    (offset,) = file.take("<d")
    if mark != MARK or not 0 < abs(gear) <= MOST_TEETH or not abs(offset) <= MOST_TEETH:
        raise InputError(_NO_GEMCAD, key=f"byte {file.at}")
    texts = [file.text() for _ in range(2 * N_HEADERS)]
    notes = []
    if file.at < len(data):
        notes.append("what stands behind the design (a preform) is left out")
    if not 1 < index < MOST_TEETH:
        notes.append(f"{index:g} is no refractive index above 1; it is left out")
    planes = np.array([facet.plane for facet in facets])
    names = [facet.name for facet in facets]
    return Design(
        tiers=tiers_of(
            planes,
            gear=gear,
            offset=offset,
            keys=[facet.tier for facet in facets],
            names=names,
            instructions=[facet.instruction for facet in facets],
        ),
        gear=gear,
        offset=offset,
        index=index if 1 < index < MOST_TEETH else None,
        folds=max(int(folds), 1),
        is_mirrored=bool(mirror),
        headers=_without_blank_end(texts[:N_HEADERS]),
        footnotes=_without_blank_end(texts[N_HEADERS:]),
        notes=tuple(notes),
    )


def write_gem(design: Design, path: str | os.PathLike[str]) -> None:
    """Write a design as a GemCad .gem file.

    Parameters
    ----------
    design : Design
        The design; of a stone, `convert.design_of` makes one.
    path : str or path-like
        File to write, whole or not at all; a file that is there is replaced.

    Raises
    ------
    InputError
        The facets do not close, one passes through the origin, or the file cannot be written.
    """
    planes = design.planes().real
    if (planes[:, 3] <= 0).any():
        raise InputError("a facet passes through the origin, which .gem files cannot say; .asc files can")
    of_tier = design.facet_tiers
    corners = design.corners()
    out = bytearray()
    names = [
        name
        for tier in design.tiers
        for name in (*tier.names, *[""] * len(tier.indices))[: len(tier.indices)]
    ]
    for number, (plane, name) in enumerate(zip(planes, names, strict=True)):
        tier = design.tiers[of_tier[number]]
        p = plane[:3] / plane[3]
        if p[2] == 0:  # the side that the tier is cut on
            p[2] = math.cos(math.pi / 2) / plane[3] * (1 if tier.is_crown else -1)
        out += struct.pack("<3di", *p, of_tier[number] + 1)
        out += _packed(f"{one_line(name)}\t{one_line(tier.instructions)}")
        for corner in corners[number]:
            out += struct.pack("<i3d", 1, *corner)
        out += struct.pack("<i", 0)
    out += struct.pack("<d", END_OF_FACETS)
    gear = round(design.gear)
    out += struct.pack("<iii", design.folds, design.is_mirrored, gear)
    out += struct.pack("<dId", design.index or 0.0, MARK, design.offset)
    for texts in (design.headers, design.footnotes):
        for text in [*texts[:N_HEADERS], *[""] * (N_HEADERS - len(texts))]:
            out += _packed(one_line(text))
    file = Path(path)
    write_whole(file.parent, {file.name: lambda made: made.write_bytes(bytes(out))})


def _packed(text: str) -> bytes:
    data = text.encode("cp1252", errors="replace")[:255]
    return bytes([len(data)]) + data


def _without_blank_end(texts: list[str]) -> tuple[str, ...]:
    while texts and not texts[-1].strip():
        texts = texts[:-1]
    return tuple(texts)


# ---- Reading -------------------------------------------------------------------------------------------


@dataclass(slots=True)
class _Facet:
    plane: np.ndarray
    tier: int
    name: str
    instruction: str


class _Bytes:
    """Bytes, and how far they were read."""

    def __init__(self, data: bytes) -> None:
        self.data, self.at = data, 0

    def take(self, layout: str) -> tuple[float, ...]:
        """Read numbers."""
        try:
            numbers = struct.unpack_from(layout, self.data, self.at)
        except struct.error as error:
            raise InputError(_NO_GEMCAD + ", or is cut short", key=f"byte {self.at}") from error
        self.at += struct.calcsize(layout)
        return numbers

    def text(self) -> str:
        """Read a text after its length."""
        (length,) = self.take("<B")
        length = int(length)
        data = self.data[self.at : self.at + length]
        if len(data) < length:
            raise InputError(_NO_GEMCAD + ", or is cut short", key=f"byte {self.at}")
        self.at += length
        return decoded(data.replace(b"\0", b" "))

    def facets(self) -> list[_Facet]:
        """Read facets up to the end of their list."""
        facets = []
        while self.peek() != END_OF_FACETS:
            facets.append(self.facet())
            if len(facets) > MOST_FACETS:
                raise InputError(f"more than {MOST_FACETS} facets", key=f"byte {self.at}")
        self.take("<d")
        return facets

    def peek(self) -> float:
        """Return the next number without going on."""
        at = self.at
        (number,) = self.take("<d")
        self.at = at
        return number

    def facet(self, most_corners: int = MOST_CORNERS) -> _Facet:
        """Read a facet, of its corners so many; they are not used."""
        begin = self.at
        p = np.array(self.take("<3d"))
        length = math.hypot(*p)
        if not 1e-50 < length < 1e50:  # false for NaN too
            raise InputError(_NO_GEMCAD, key=f"byte {begin}")
        (tier,) = self.take("<i")
        name, _, instruction = self.text().partition("\t")
        for _ in range(most_corners):
            (more,) = self.take("<i")
            if more == 0:
                break
            if more != 1:
                raise InputError(_NO_GEMCAD, key=f"byte {self.at - 4}")
            self.take("<3d")
        else:
            if most_corners == MOST_CORNERS:
                raise InputError(f"more than {MOST_CORNERS} corners", key=f"byte {begin}")
        return _Facet(np.append(p / length, 1 / length), int(tier), name.strip(), instruction.strip())

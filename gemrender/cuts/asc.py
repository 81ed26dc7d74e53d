"""GemCad's .asc: a design as text, one record a line.

::

    file      = "GemCad" version EOL { record }
    gear      = "g" teeth offset            symmetry = "y" folds ("y"|"n")      index = "I" n
    header    = "H" text                    footnote = "F" text
    tier      = "a" angle distance { index [ "n" name ] } [ "G" instruction to the end of the line ]

Lines that begin with an index, "n" or "G" go on with the tier above. Angles are in degrees from the girdle
plane, negative on the pavilion; a culet facet is at 0 with a negative distance, or at "-0".
"""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass, field
from pathlib import Path

from gemrender.cuts.design import LARGEST_ANGLE, MOST_FACETS, Design, Tier
from gemrender.cuts.text import decoded, number_of, number_text, one_line
from gemrender.errors import InputError
from gemrender.reading import located_at, read_bytes
from gemrender.writing import write_whole

__all__ = ["parse_asc", "read_asc", "write_asc"]

#: A record's letter that stands at its first number, as in "g96 0.0".
_GLUED = re.compile(r"^([gyIa])(?=[-+\u2212.\d])")
#: Largest number of teeth; the largest index wheels have 360.
MOST_TEETH = 100_000
#: Largest index [teeth]: any number that a person may have meant.
LARGEST_INDEX = 1e6
#: Largest distance: its square is finite, and so is what the distances make.
LARGEST_DISTANCE = 1e50


def read_asc(path: str | os.PathLike[str]) -> Design:
    """Read a GemCad .asc file.

    Parameters
    ----------
    path : str or path-like
        The file: UTF-8, with or without a byte order mark, or Windows-1252; lines end in LF or CRLF.

    Returns
    -------
    Design
        Its `notes` say what was mended.

    Raises
    ------
    InputError
        The file cannot be read, or a line is none of a design.
    """
    file = Path(path)
    with located_at(str(file)):
        return parse_asc(read_bytes(file, kind="GemCad .asc"))


def parse_asc(data: bytes) -> Design:
    """Return the design that the bytes of an .asc file describe.

    Raises
    ------
    InputError
        A line is none of a design; its key is the line. It has no source: see `located_at`.
    """
    reader = _Reader()
    for number, line in enumerate(decoded(data).split("\n"), start=1):
        reader.line(number, line.strip())
    return reader.design()


def write_asc(design: Design, path: str | os.PathLike[str]) -> None:
    """Write a design as a GemCad .asc file, with all the digits of its numbers.

    Parameters
    ----------
    design : Design
        The design; of a stone, `convert.design_of` makes one.
    path : str or path-like
        File to write, whole or not at all; a file that is there is replaced.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    lines = [
        "GemCad 5.0",
        f"g {number_text(design.gear)} {number_text(design.offset, 1)}",
        f"y {design.folds} {'y' if design.is_mirrored else 'n'}",
        *([] if design.index is None else [f"I {number_text(design.index, 2)}"]),
        *[f"H {one_line(header)}" for header in design.headers],
        *map(_tier_line, design.tiers),
        *[f"F {one_line(footnote)}" for footnote in design.footnotes],
    ]
    text = "".join(line.rstrip() + "\r\n" for line in lines)  # GemCad is a Windows program
    try:
        data = text.encode("cp1252")
    except UnicodeEncodeError:
        data = text.encode("utf-8-sig")
    file = Path(path)
    write_whole(file.parent, {file.name: lambda made: made.write_bytes(data)})


def _tier_line(tier: Tier) -> str:
    angle, distance = float(tier.angle_deg.real), float(tier.distance.real)
    if angle == 0 and not tier.is_crown:  # a culet facet: every reader knows it by its negative distance
        angle, distance = 0.0, -distance
    items = [f"a {number_text(angle, 6)} {number_text(distance, 8)}"]
    before = ""
    for index, name in zip(tier.indices, tier.facet_names(), strict=True):
        items.append(number_text(index))
        if name != before:
            items.append(f"n {'_'.join(name.split())}")
            before = name
    if instructions := one_line(tier.instructions):
        items.append(f"G {instructions}")
    return " ".join(items)


# ---- Reading -------------------------------------------------------------------------------------------


@dataclass(slots=True)
class _OpenTier:
    """A tier that later lines may go on with."""

    line: int
    angle_deg: float
    distance: float
    indices: list[float] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    instructions: list[str] = field(default_factory=list)
    #: A name that stands before any index.
    first_name: str = ""
    wants_name: bool = False


class _Reader:
    """What the lines so far have told."""

    def __init__(self) -> None:
        self.tiers: list[_OpenTier] = []
        self.is_open = False
        self.n_facets = 0
        self.begun = False
        self.gear: tuple[float, float] | None = None
        self.index: float | None = None
        self.symmetry = (1, False)
        self.headers: list[str] = []
        self.footnotes: list[str] = []
        self.notes: list[str] = []
        self.left_out: list[int] = []
        self.bare: list[str] = []

    def line(self, number: int, line: str) -> None:
        """Take a line without the blanks around it."""
        if not line or line[0] in ";#":
            return
        if not self.begun:
            self.begun = True
            if line.lower().startswith("gemcad"):
                return
            self.notes.append("has no first line GemCad")
        first, _, rest = _GLUED.sub(r"\1 ", line, count=1).replace("\t", " ").partition(" ")
        key = f"line {number}"
        if first == "a":
            self._tier(number, rest.split())
        elif first == "g":
            self._gear(key, rest.split())
        elif first == "I":
            self._index(key, rest.strip())
        elif first == "y":
            self._symmetry(rest.split())
        elif first == "H":
            self.headers.append(rest.strip())
        elif first == "F":
            self.footnotes.append(rest.strip())
        elif self.is_open and (
            first in ("n", "G") or number_of(first) is not None or self.tiers[-1].wants_name
        ):
            self._items(key, line.split())
            return
        elif self.gear is None and not self.tiers and _is_gear(line.split()):
            self._gear(key, line.split())
        elif first.lower() == "gemcad":
            return
        else:
            self.left_out.append(number)
            return
        self.is_open = first == "a"

    def _tier(self, number: int, tokens: list[str]) -> None:
        key = f"line {number}"
        if len(tokens) < 2:
            raise InputError("a tier needs an angle and a distance", key=key)
        angle = _number(tokens[0], key, "an angle")
        distance = _number(tokens[1], key, "a distance")
        if not abs(angle) <= LARGEST_ANGLE:
            raise InputError("an angle must be -90 to 90 degrees", key=key, value=tokens[0])
        if not abs(distance) <= LARGEST_DISTANCE:
            raise InputError(f"a distance must be at most {LARGEST_DISTANCE:g}", key=key, value=tokens[1])
        if angle == 0 and math.copysign(1, distance) < 0:
            angle = -0.0
        self.tiers.append(_OpenTier(number, angle, abs(distance)))
        self.is_open = True
        self._items(key, tokens[2:])

    def _items(self, key: str, tokens: list[str]) -> None:
        """Take what follows a tier's angle and distance, on its line or the next ones."""
        tier = self.tiers[-1]
        for at, token in enumerate(tokens):
            if tier.wants_name:
                tier.wants_name = False
                if tier.indices:
                    tier.names[-1] = token
                else:
                    tier.first_name = tier.first_name or token
            elif token == "n":
                tier.wants_name = True
            elif token == "G":
                tier.instructions.append(" ".join(tokens[at + 1 :]))
                break
            elif (index := number_of(token)) is not None:
                if not abs(index) <= LARGEST_INDEX:
                    raise InputError(f"an index must be at most {LARGEST_INDEX:g}", key=key, value=token)
                tier.names.append("" if tier.indices else tier.first_name)
                tier.indices.append(index)
                self.n_facets += 1
                if self.n_facets > MOST_FACETS:
                    raise InputError(f"more than {MOST_FACETS} facets", key=key)
            else:
                self.bare.append(token)

    def _gear(self, key: str, tokens: list[str]) -> None:
        if not tokens:
            raise InputError("needs the number of teeth of the index wheel and its offset", key=key)
        teeth = _number(tokens[0], key, "the number of teeth")
        offset = _number(tokens[1], key, "the offset") if len(tokens) > 1 else 0.0
        if not 1 <= abs(teeth) <= MOST_TEETH:
            raise InputError(
                f"the number of teeth must be 1 to {MOST_TEETH}, or negative", key=key, value=tokens[0]
            )
        if not abs(offset) <= LARGEST_INDEX:
            raise InputError(f"the offset must be at most {LARGEST_INDEX:g}", key=key, value=tokens[1])
        if self.gear not in (None, (teeth, offset)):
            self.notes.append(f"has several lines g; the last, {key}, is used")
        self.gear = teeth, offset

    def _index(self, key: str, text: str) -> None:
        index = number_of(text.split()[0]) if text else None
        if index is None or not 1 < index < LARGEST_INDEX:
            self.notes.append(f"{key}: {text or 'nothing'} is no refractive index above 1; it is left out")
        else:
            self.index = index

    def _symmetry(self, tokens: list[str]) -> None:
        """Keep what the dialogue said when the file was saved: to be written again, used for nothing else."""
        folds = number_of(tokens[0]) if tokens else None
        if folds is not None and 1 <= folds <= MOST_TEETH:
            self.symmetry = int(folds), tokens[1:2] == ["y"]

    def design(self) -> Design:
        """Return what all the lines tell."""
        if not self.tiers:
            raise InputError('has no facets: no line "a angle distance index ..."')
        if self.gear is None:
            raise InputError('has no line "g teeth offset" for the index wheel')
        notes = list(self.notes)
        if self.left_out:
            lines = ", ".join(map(str, self.left_out[:4])) + (" ..." if len(self.left_out) > 4 else "")
            notes.append(f"no record of a design, left out: line {lines}")
        if self.bare:
            notes.append(f"words that are no index, left out: {one_line(' '.join(self.bare[:4]))[:60]}")
        tiers = []
        for tier in self.tiers:
            indices, names = tuple(tier.indices), tuple(tier.names)
            if not indices and tier.angle_deg == 0:  # a table needs no index
                indices, names = (self.gear[0],), (tier.first_name,)
            elif not indices:
                notes.append(f"line {tier.line}: no index, so no facet")
                continue
            tiers.append(
                Tier(
                    angle_deg=tier.angle_deg,
                    distance=tier.distance,
                    indices=indices,
                    names=names,
                    instructions=" ".join(filter(None, tier.instructions)),
                )
            )
        if not tiers:
            raise InputError("has no facets: no tier has an index")
        return Design(
            tiers=tuple(tiers),
            gear=self.gear[0],
            offset=self.gear[1],
            index=self.index,
            folds=self.symmetry[0],
            is_mirrored=self.symmetry[1],
            headers=tuple(self.headers),
            footnotes=tuple(self.footnotes),
            notes=tuple(notes),
        )


def _is_gear(tokens: list[str]) -> bool:
    """Whether a line without a letter is the gear's: teeth and an offset."""
    return len(tokens) == 2 and all(number_of(token) is not None for token in tokens)


def _number(token: str, key: str, what: str) -> float:
    number = number_of(token)
    if number is None:
        raise InputError(f"{what} must be a number", key=key, value=token)
    return number

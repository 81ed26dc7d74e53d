"""Shapes as laboratories and shops write them, and the families of cuts that they are.

Laboratories name outline and style of cutting ("Cut-Cornered Rectangular Modified Brilliant"), shops use the
trade's names and codes. Names: GIA's reports. Codes: the values that RapNet takes in the field Shape (as
listed in "Cutwise Import format", Octonus, octonus-teams.com), but for R alone, which is a round here.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from gemrender.cuts.families import families
from gemrender.errors import InputError
from gemrender.reading import did_you_mean

__all__ = ["ROUND", "Shape", "read_shape", "shape_words"]

ROUND = "round brilliant"

#: Words of each family, as `_folded` leaves them: without case, hyphens, "cut", "shape" and "diamond".
_WORDS: dict[str, str] = {
    ROUND: (
        "round, rounds, rd, rnd, rb, rbc, br, r, b, round brilliant, brilliant round, brilliant, "
        "standard round brilliant"
    ),
    "old European": (
        "old european, old european brilliant, european, circular brilliant, old euro, oec, oe, oeb"
    ),
    "single cut": "single, single brilliant, round single, eight, 8 8, full single",
    "oval": "oval, oval brilliant, oval modified brilliant, oval modified, ovals, o, ov, ovl, ob, omb",
    "pear": (
        "pear, pear brilliant, pear modified brilliant, pear modified, pears, teardrop, tear drop, drop, "
        "pendeloque, p, ps, psh, pe, pb, pmb"
    ),
    "marquise": (
        "marquise, marquise brilliant, marquise modified brilliant, marquise modified, marquises, navette, "
        "m, mq, mqb, mar, marq, mb, mmb"
    ),
    "emerald": (
        "emerald, emerald step, rectangular emerald, cut cornered rectangular step, octagon step, e, em, ec, "
        "eme, emr"
    ),
    "Asscher": (
        "asscher, square emerald, square emerald step, sq emerald, cut cornered square step, "
        "square octagon step, a, as, ac, ass, se, sem, sqe, css, cssc"
    ),
    "baguette": (
        "baguette, straight baguette, baguettes, rectangular step, square step, carre, bg, bag, bgt, baq"
    ),
    "cushion": (
        "cushion, cushion brilliant, cushion modified brilliant, cushion modified, cushions, square cushion, "
        "sq cushion, square cushion brilliant, square cushion modified brilliant, square cushion modified, "
        "rectangular cushion, rectangular cushion brilliant, rectangular cushion modified brilliant, "
        "long cushion, antique cushion, pillow, c, cu, cus, cush, cb, cmb, cux, cx, crc, csc, rcrmb, rcsb, "
        "scmb, scx"
    ),
    "princess": (
        "princess, square modified brilliant, square brilliant, rectangular modified brilliant, "
        "rectangular princess, quadrillion, pr, prn, prin, pri, pn, pc, smb, rmb, mdsqb"
    ),
    "radiant": (
        "radiant, radiant brilliant, square radiant, sq radiant, rectangular radiant, long radiant, "
        "cornered rectangular modified brilliant, cornered square modified brilliant, "
        "cornered rectangular brilliant, cornered square brilliant, rad, ra, rc, rdn, crb, rcrb, "
        "ccrmb, ccsmb, crmb, csmb, sr, sqr"
    ),
    "trilliant": (
        "trilliant, trillion, trielle, trillian, triangular brilliant, triangular modified brilliant, "
        "triangle, triangular, t, tr, tri, trl, trill, tb, tmb"
    ),
}  # fmt: skip

_SQUARE = {"length_to_width": 1.0}
_BRILLIANT, _MODIFIED = {"style": "brilliant"}, {"style": "modified brilliant"}
#: What a word in a shape's name says of a parameter of its family, where that is not stated; the later ones
#: count more.
_SAYS: dict[str, dict[str, dict[str, Any]]] = {
    "cushion": {
        "square": _SQUARE, "sq": _SQUARE, "scmb": _SQUARE | _MODIFIED, "rcsb": _SQUARE | _BRILLIANT,
        "brilliant": _BRILLIANT, "cb": _BRILLIANT,
        "modified": _MODIFIED, "cmb": _MODIFIED, "rcrmb": _MODIFIED,
    },
    "radiant": {"square": _SQUARE, "sq": _SQUARE, "sr": _SQUARE, "sqr": _SQUARE},
}  # fmt: skip
#: Words of shapes that no family has: nothing else is guessed at.
_OTHERS = {
    "heart", "hs", "ht", "h", "mine", "tapered", "rose", "briolette", "shield", "kite", "lozenge",
    "hexagonal", "pentagonal", "octagonal", "trapezoid", "moon", "bullet", "calf", "star",
    "flanders", "ashoka",
}  # fmt: skip
#: Words that say nothing.
_SILENT = {"cut", "shape", "shaped", "diamond"}


@dataclass(frozen=True, slots=True)
class Shape:
    """A shape by a report's word.

    Parameters
    ----------
    family : str
        The family's name, as of `families`.
    fixed : mapping
        Parameters that the word tells, such as the style of a cushion.
    """

    family: str
    fixed: Mapping[str, Any] = field(default_factory=dict, hash=False)

    @property
    def kind(self) -> Any:
        """The class of the family's parameters."""
        return families()[self.family]

    @property
    def is_round_brilliant(self) -> bool:
        """Whether it is the round brilliant, whose reports have rules of their own."""
        return self.family == ROUND


def _folded(text: str) -> str:
    words = re.findall(r"[^\W_]+", text.casefold())
    return " ".join([word for word in words if word not in _SILENT] or words)


@lru_cache(maxsize=1)
def shape_words() -> dict[str, str]:
    """Return the name of the family of each word; of those only that can be made."""
    from gemrender.cuts.families.family import Family

    known = {_folded(ROUND): ROUND}
    known |= {_folded(name): name for name, kind in families().items() if issubclass(kind, Family)}
    words = {
        _folded(word): known[_folded(name)]
        for name, listed in _WORDS.items()
        if _folded(name) in known
        for word in listed.split(", ")
    }
    return known | words


@lru_cache(maxsize=1000)  # tables have the same few in every row
def read_shape(text: str) -> Shape:
    """Read a shape such as "Oval Brilliant", "Cut-Cornered Square Modified Brilliant" or "MQ".

    Parameters
    ----------
    text : str
        The word.

    Raises
    ------
    InputError
        It is no shape that can be made.
    """
    words = shape_words()
    folded = _folded(text)
    if folded not in words:
        names = list(dict.fromkeys(words.values()))
        guess = "" if _OTHERS & set(folded.split()) else did_you_mean(folded, list(words))
        raise InputError(
            f"must be one of {', '.join(names)}, as laboratories or shops write them{guess}",
            key="shape",
            value=text,
        )
    family = words[folded]
    fixed: dict[str, Any] = {}
    for word, says in _SAYS.get(family, {}).items():
        if word in folded.split():
            fixed |= says
    return Shape(family, fixed)

"""Girdle thickness and culet as laboratory reports word them.

GIA judges the words at the thin places between the mains, the "valleys", and prints the per cent of the thick
places, where mains meet the girdle (Lanzl, Yantzer, Geurts & de Jong, Rapaport Diamond Report, 6 January
2006). The model's girdle thickness is the latter, so that words have to be turned into it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

from gemrender.errors import InputError

__all__ = ["GIRDLE_WORDS", "StatedGirdle", "check_culet", "read_girdle"]

#: Girdle thickness at the thick places for each word [% of the girdle diameter]. The first three are the
#: guidelines of GIA's course (Diamonds & Diamond Grading, "Girdle thickness percentage guidelines"); 3.0 is
#: what GIA's cut charts (diamondcut.gia.edu, 2006) take for thin to slightly thick, of which medium is the
#: middle. The thicker ones are inferred: they go on from there to the very thick and extremely thick of
#: HRD Antwerp's chart (2025: 6.5 to 7.5, and 8 and more). A word covers about half a per cent either way.
GIRDLE_WORDS: dict[str, float] = {
    "extremely thin": 1.5,
    "very thin": 2.0,
    "thin": 2.5,
    "medium": 3.0,
    "slightly thick": 4.0,
    "thick": 5.0,
    "very thick": 7.0,
    "extremely thick": 9.0,
}

_HOW_MUCH = {
    **dict.fromkeys(("extremely", "extreme", "extr", "ext", "ex", "x", "e"), "extremely"),
    **dict.fromkeys(("very", "v"), "very"),
    **dict.fromkeys(("slightly", "slight", "slt", "sli", "sl", "s"), "slightly"),
}
_THICKNESS = {
    **dict.fromkeys(("thin", "thn", "tn"), "thin"),
    **dict.fromkeys(("medium", "med", "md", "m"), "medium"),
    **dict.fromkeys(("thick", "thk", "tk"), "thick"),
}
_WORD = re.compile(
    rf"(?<![a-z])(?:({'|'.join(_HOW_MUCH)})[ .-]*)?({'|'.join(_THICKNESS)})(?![a-z])",
)
_NUMBER = re.compile(r"\d+(?:[.,]\d+)?")
#: What may stand beside the words: how the girdle is finished, and what separates words and numbers.
_BESIDE = re.compile(
    r"\b(?:faceted|facetted|facet|fac|fct|polished|pol|bruted|brt|smooth|to|and)\b|per ?cent|pct"
    r"|[\s,;:./%()&~–—-]",
)
_POINTED = {"none", "non", "no", "n", "pointed", "point", "pnt", "ptd", "0"}


@dataclass(frozen=True, slots=True)
class StatedGirdle:
    """A girdle as a report words it.

    Parameters
    ----------
    thickness : float
        At the thick places [% of the girdle diameter]; the middle of a range.
    low, high : float
        The ends of the range [%].
    words : str
        The words, where it is known by words only.
    """

    thickness: float
    low: float
    high: float
    words: str = ""


@lru_cache(maxsize=1000)  # tables have the same few in every row
def read_girdle(text: str) -> StatedGirdle:
    """Read a girdle such as "Medium", "thin to slightly thick (faceted)", "STK - THK", "2.5-4.0 %", "3.5%".

    A per cent counts more than words that stand beside it; of a range, the middle is taken.

    Parameters
    ----------
    text : str
        The words, or one or two numbers [% of the girdle diameter].

    Raises
    ------
    InputError
        It is neither; without a key.
    """
    folded = " ".join(text.casefold().split())
    numbers = [float(number.replace(",", ".")) for number in _NUMBER.findall(folded)]
    words = [_word(*found) for found in _WORD.findall(folded)]
    rest = _BESIDE.sub("", _NUMBER.sub("", _WORD.sub("", folded)))
    if rest or None in words or len(numbers) > 2 or not (numbers or words):
        raise InputError(
            f"must be per cent of the diameter, such as 3.5, or words such as thin to medium: "
            f"{', '.join(GIRDLE_WORDS)}",
            value=text,
        )
    values = numbers or [GIRDLE_WORDS[word] for word in words if word]
    low, high = min(values), max(values)
    return StatedGirdle(thickness=(low + high) / 2, low=low, high=high, words="" if numbers else folded)


def _word(how_much: str, thickness: str) -> str | None:
    """Return the word that an abbreviation stands for, if there is one."""
    word = " ".join(part for part in (_HOW_MUCH.get(how_much, ""), _THICKNESS[thickness]) if part)
    return word if word in GIRDLE_WORDS else None


def check_culet(value: object) -> None:
    """Refuse a culet that has a size: the model's stones end in a point.

    Parameters
    ----------
    value : str or number
        "none" and "pointed", in any spelling, or 0.

    Raises
    ------
    InputError
        Anything else.
    """
    words = set(re.findall(r"[a-z]+|\d+(?:\.\d+)?", str(value).casefold()))
    zero = {word for word in words if word[0].isdigit() and float(word) == 0}
    if isinstance(value, bool) or not words or not words - zero <= _POINTED:
        raise InputError(
            "must be none or pointed: stones with a culet facet cannot be made yet", key="culet", value=value
        )

"""Girdle thickness and culet as laboratory reports word them.

GIA judges the words at the thin places between the mains, the "valleys", and prints the per cent of the thick
places, where mains meet the girdle (Lanzl, Yantzer, Geurts & de Jong, Rapaport Diamond Report, 6 January
2006). The model's girdle thickness is the latter, so that words have to be turned into it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from gemrender.errors import InputError

__all__ = ["CULET_RANGE", "CULET_WORDS", "GIRDLE_WORDS", "StatedGirdle", "read_culet", "read_girdle"]

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

#: Width of the culet for each of GIA's words [% of the girdle diameter]. Its graders judge the words by eye
#: (Lanzl et al., see above), and it publishes no per cent for them. These are inferred: up to medium a culet
#: is not seen without a loupe (what AGS allows in its best grade), and 0.3 mm on a stone of 6.5 mm, 4.5 %, is
#: about where that ends; that of old brilliants, an octahedron with 1/18 of its height cut off (McCarthy,
#: Fire in the Earth, 1942, p. 236), a ninth of the width, is among the largest.
CULET_WORDS: dict[str, float] = {
    "none": 0.0,
    "very small": 0.6,
    "small": 1.5,
    "medium": 3.0,
    "slightly large": 4.5,
    "large": 6.5,
    "very large": 9.0,
    "extremely large": 12.0,
}
#: Widths of a culet that can be made, besides 0 [% of the girdle diameter].
CULET_RANGE = (0.1, 20.0)

#: No culet: a point, or a keel, which IGI calls a long culet.
_POINTED = {"none", "non", "no", "n", "pointed", "point", "pnt", "ptd", "long"}
_SIZES = {
    "small": ("small", "sml", "sm", "s"),
    "medium": ("medium", "med", "md", "m"),
    "large": ("large", "lge", "lrg", "lg", "l"),
}
#: Every way to write a word, without blanks, such as "vsm".
_CULETS = {
    how + short: width
    for word, width in CULET_WORDS.items()
    for much, _, size in (word.rpartition(" "),)
    for how in ("", *_HOW_MUCH)
    for short in _SIZES.get(size, ())
    if _HOW_MUCH.get(how, "") == much
}
_BESIDE_CULET = {"culet", "facet", "per", "cent", "percent", "pct"}
_OF_CULETS = re.compile(r"(?!.*-\s*\d)[a-z0-9 .,;:%()/&-]+")


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


def read_culet(value: Any) -> float:
    """Read the culet of a report: words such as "none", "Very Small" or "SLG", or its width, "1.2 %".

    Parameters
    ----------
    value : str or number
        The words, the width [% of the girdle diameter], or both, of which the width counts.

    Returns
    -------
    float
        The width [%]; 0 for a point.

    Raises
    ------
    InputError
        It is neither; without a key.
    """
    low, high = CULET_RANGE
    width: Any = _stated_width(value.casefold()) if isinstance(value, str) else value
    is_number = isinstance(width, (int, float, np.integer, np.floating)) and not isinstance(width, bool)
    if not is_number or not (width == 0 or low <= width <= high):  # true for NaN too
        raise InputError(
            f"must be 0 or from {low:g} to {high:g} [% of the diameter], or one of {', '.join(CULET_WORDS)}",
            value=value,
        )
    return float(width)


@lru_cache(maxsize=1000)
def _stated_width(folded: str) -> float | None:
    """Return the width [%] that a culet's words or number say, if they say one."""
    widths = [float(number.replace(",", ".")) for number in _NUMBER.findall(folded)]
    words = [word for word in re.findall(r"[a-z]+", folded) if word not in _BESIDE_CULET]
    named = 0.0 if words and _POINTED.issuperset(words) else _CULETS.get("".join(words))
    if not _OF_CULETS.fullmatch(folded) or len(widths) > 1 or (words and named is None):
        return None
    if widths and named is not None and (widths[0] == 0) != (named == 0):
        return None
    return widths[0] if widths else named

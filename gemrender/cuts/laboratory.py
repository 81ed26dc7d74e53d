"""Laboratory reports: the proportions that they print, more or fewer than needed, make a round brilliant.

A report rounds every figure, prints heights as well as angles, and leaves some figures out. Here it is
settled which of them count, that the others agree with them as far as rounding allows, and what is assumed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from gemrender.cuts.girdle_words import StatedGirdle, read_culet, read_girdle
from gemrender.cuts.round_brilliant.proportions import (
    RoundBrilliant,
    crown_height_from_angle,
    number_within,
    pavilion_depth_from_angle,
)
from gemrender.cuts.shape_words import read_shape
from gemrender.errors import InputError

__all__ = ["DEFAULTS", "OWN", "REPORT_KEYS", "Assumed", "Report", "missing_parts", "read_report"]

#: What a report may state, in the order that it is told in.
REPORT_KEYS = (
    "table", "depth", "crown_angle", "crown_height", "pavilion_angle", "pavilion_depth", "girdle",
    "girdle_thickness", "star", "lower_half", "lower_girdle_contact", "culet", "shape",
)  # fmt: skip

#: What is taken where a report has none [%]: the star and lower-half lengths of GIA's reference stone
#: (Reinitz, Gilbertson & Geurts, "Weight ratio within the GIA Diamond Cut Grading System"). GIA's cut charts
#: (diamondcut.gia.edu, 2006) take a star of 55 and the same lower halves.
DEFAULTS = {"star": 50.0, "lower_half": 80.0}

#: Half of the steps that GIA rounds its reports to: 1 % of table, 0.5 deg of crown, 0.2 deg of pavilion,
#: 0.5 % of girdle, 5 % of lower half (the increments of GIA Facetware); 0.5 % of heights, 0.1 % of depth
#: and culet. A culet in words may be anything from a point to twice as wide.
ROUNDING = {
    "table": 0.5, "crown_angle": 0.25, "pavilion_angle": 0.1, "crown_height": 0.25, "pavilion_depth": 0.25,
    "girdle_thickness": 0.25, "depth": 0.05, "lower_half": 2.5, "culet": 0.05,
}  # fmt: skip
#: What a thickness in words may be beside the middle or the ends of its words [%].
WORDS_TOLERANCE = 1.5
#: Why a parameter of a family is what it is that is not stated, unless reports always leave it open.
OWN = "(the family's own)"
#: A total depth that can be meant [%]; one in millimetres is below.
DEPTH_RANGE = (20.0, 160.0)


class Assumed(NamedTuple):
    """Something that a report does not state: what was taken for it, and why."""

    what: str
    value: float | str
    why: str

    @property
    def told(self) -> str:
        """The value in words."""
        return self.value if isinstance(self.value, str) else f"{self.value:.3g}"

    def __str__(self) -> str:
        return f"{self.what} {self.told} {self.why}"


@dataclass(frozen=True, slots=True)
class Report:
    """What was read from a report.

    Parameters
    ----------
    proportions : RoundBrilliant
        The stone, but for its culet.
    assumed : tuple of Assumed
        What was assumed or inferred.
    culet : float
        Width of the culet [% of the girdle diameter]; the pavilion depth is down to it.
    """

    proportions: RoundBrilliant
    assumed: tuple[Assumed, ...]
    culet: float = 0.0

    @property
    def cut(self) -> Any:
        """The cut: the proportions, or with a culet the family's parameters."""
        from gemrender.cuts.families.round_brilliant import with_culet

        return with_culet(self.proportions, self.culet)


class _Culet(NamedTuple):
    """The width of a culet [%], how far it may be from the stone's, and the words where it has only these."""

    width: float
    rounding: float
    words: str


@dataclass(frozen=True, slots=True)
class _Height:
    """A part of the depth [%], and how far it may be from the stone's since figures are rounded."""

    value: float
    rounding: float


def missing_parts(known: Mapping[str, object]) -> str:
    """Say what a round brilliant needs besides the keys that are known; nothing if they are enough."""
    parts = {
        "the crown (crown_angle or crown_height)": ("crown_angle", "crown_height"),
        "the pavilion (pavilion_angle or pavilion_depth)": ("pavilion_angle", "pavilion_depth"),
        "the girdle (girdle or girdle_thickness)": ("girdle", "girdle_thickness"),
    }
    without = [part for part, keys in parts.items() if not any(key in known for key in keys)]
    table = [] if "table" in known else ["the table"]
    if "depth" in known:
        # The depth stands for one of them.
        if len(without) <= 1:
            return ", ".join(table)
        return f"{', '.join([*table, *without])}; the depth stands for one of these only"
    return ", ".join([*table, *without])


def read_report(values: Mapping[str, object]) -> Report:
    """Make the round brilliant of a laboratory report.

    Of the crown's angle and height, and of the pavilion's angle and depth, the angle counts where both are
    stated. The total depth is crown height + girdle + pavilion depth and gives the one that is missing. A
    girdle thickness in per cent counts more than the depth, and the depth more than one in words.

    Parameters
    ----------
    values : dict
        By key of `REPORT_KEYS`: numbers [%, deg]; `girdle` and `culet` a number or words; `shape` words.
        `girdle_thickness` may be words too. Keys may be missing.

    Returns
    -------
    Report
        The proportions and what was assumed.

    Raises
    ------
    InputError
        A value that is not allowed, too few of them, or some that contradict each other by more than the
        rounding of a report.
    """
    if "shape" in values:
        _check_shape(values["shape"])
    culet = _culet(values)
    if missing := missing_parts(values):
        raise InputError(f"needs {missing}")
    table = number_within("table", values["table"])
    assumed: list[Assumed] = []
    crown, pavilion = _crown(values, table), _pavilion(values, culet)
    girdle = _girdle(values)
    if "depth" in values:
        depth = number_within("depth", values["depth"], DEPTH_RANGE)
        crown, pavilion, girdle = _by_depth(depth, crown, pavilion, girdle, assumed)
    assert crown is not None
    assert pavilion is not None
    assert girdle is not None
    if girdle.words:
        assumed.insert(0, Assumed("girdle", girdle.thickness, f"of '{girdle.words}'"))
    elif girdle.low < girdle.high:
        assumed.insert(0, Assumed("girdle", girdle.thickness, f"of {girdle.low:g} to {girdle.high:g}"))
    star = values.get("star")
    if star is None:
        star = DEFAULTS["star"]
        assumed.append(Assumed("star", star, "(not in the report)"))
    proportions = RoundBrilliant(
        table=table,
        star=star,  # type: ignore[arg-type]  # checked there
        lower_girdle_contact=_contact(values, assumed),
        crown_height=crown.value,
        pavilion_depth=pavilion.value,
        girdle_thickness=girdle.thickness,
    )
    if culet.words:
        assumed.append(Assumed("culet", culet.width, f"of '{culet.words}'"))
    report = Report(proportions, tuple(assumed), culet.width)
    assert report.cut is not None  # refuses a culet that is too large for the lower halves
    return report


# ---- Parts of the stone --------------------------------------------------------------------------------


def _crown(values: Mapping[str, object], table: float) -> _Height | None:
    stated = number_within("crown_height", values["crown_height"]) if "crown_height" in values else None
    if "crown_angle" not in values:
        return None if stated is None else _Height(stated, ROUNDING["crown_height"])
    angle = number_within("crown_angle", values["crown_angle"])
    tangent = math.tan(math.radians(angle))
    # By how much the height changes where table and angle are rounded.
    rounding = ROUNDING["table"] / 2 * tangent
    rounding += (100 - table) / 2 * (1 + tangent**2) * math.radians(ROUNDING["crown_angle"])
    height = _Height(crown_height_from_angle(table, angle), rounding)
    _check_height("crown_height", stated, height, f"crown_angle = {angle:g} with table = {table:g} makes it")
    return height


def _culet(values: Mapping[str, object]) -> _Culet:
    value = values.get("culet", 0.0)
    try:
        width = read_culet(value)
    except InputError as error:
        raise InputError(error.allowed, key="culet", value=value) from error
    if isinstance(value, str) and width and not re.search(r"\d", value):
        return _Culet(width, width, " ".join(value.casefold().split()))
    return _Culet(width, ROUNDING["culet"], "")


def _pavilion(values: Mapping[str, object], culet: _Culet) -> _Height | None:
    stated = number_within("pavilion_depth", values["pavilion_depth"]) if "pavilion_depth" in values else None
    if "pavilion_angle" not in values:
        return None if stated is None else _Height(stated, ROUNDING["pavilion_depth"])
    angle = number_within("pavilion_angle", values["pavilion_angle"])
    share = 1 - culet.width / 100
    tangent = math.tan(math.radians(angle))
    rounding = share * 50 * (1 + tangent**2) * math.radians(ROUNDING["pavilion_angle"])
    if culet.width:
        rounding += culet.rounding / 2 * tangent
    height = _Height(share * pavilion_depth_from_angle(angle), rounding)
    beside = f" with a culet of {culet.width:g}" if culet.width else ""
    _check_height("pavilion_depth", stated, height, f"pavilion_angle = {angle:g}{beside} makes it")
    return height


def _check_height(key: str, stated: float | None, height: _Height, words: str) -> None:
    if stated is None:
        return
    allowed = height.rounding + ROUNDING[key]
    if abs(stated - height.value) > allowed:
        raise InputError(
            f"{words} {height.value:.1f} %; the rounding of a report allows a difference of {allowed:.2g} %",
            key=key,
            value=stated,
        )


def _girdle(values: Mapping[str, object]) -> StatedGirdle | None:
    """Return the girdle: of thickness and words, the one that is in per cent."""
    found = None
    for key in ("girdle_thickness", "girdle"):
        if key not in values:
            continue
        value = values[key]
        if isinstance(value, str):
            try:
                girdle = read_girdle(value)
            except InputError as error:
                if found is not None:
                    continue
                raise InputError(error.allowed, key=key, value=value) from error
        else:
            number = number_within("girdle_thickness", value)
            girdle = StatedGirdle(thickness=number, low=number, high=number)
        if found is None or (found.words and not girdle.words):
            found = girdle
    return found


def _by_depth(
    depth: float,
    crown: _Height | None,
    pavilion: _Height | None,
    girdle: StatedGirdle | None,
    assumed: list[Assumed],
) -> tuple[_Height, _Height, StatedGirdle]:
    """Fill in what is missing by the total depth, or check that it agrees."""
    if crown is None:
        assert pavilion is not None
        assert girdle is not None
        value = _rest("crown_height", depth, girdle.thickness + pavilion.value, "girdle and pavilion depth")
        assumed.append(Assumed("crown height", value, "(depth less girdle and pavilion)"))
        return _Height(value, 0.0), pavilion, girdle
    if pavilion is None:
        assert girdle is not None
        value = _rest("pavilion_depth", depth, girdle.thickness + crown.value, "crown height and girdle")
        assumed.append(Assumed("pavilion depth", value, "(depth less crown and girdle)"))
        return crown, _Height(value, 0.0), girdle
    rest = depth - crown.value - pavilion.value
    rounding = ROUNDING["depth"] + crown.rounding + pavilion.rounding
    sum_of = f"crown {crown.value:.1f} + pavilion {pavilion.value:.1f}"
    if girdle is None or girdle.words:
        low, high = (girdle.low - WORDS_TOLERANCE, girdle.high + WORDS_TOLERANCE) if girdle else (0.0, 50.0)
        if not max(low, 0.0) - rounding <= rest <= high + rounding:
            words = f", which does not fit '{girdle.words}'" if girdle else ""
            raise InputError(
                f"with {sum_of} % leaves a girdle of {rest:.1f} %{words}; the rounding of a report allows a "
                f"difference of {rounding:.2g} %",
                key="depth",
                value=depth,
            )
        thickness = max(rest, 0.0)
        assumed.append(Assumed("girdle", thickness, "(depth less crown and pavilion)"))
        return crown, pavilion, StatedGirdle(thickness=thickness, low=thickness, high=thickness)
    low, high = girdle.low - ROUNDING["girdle_thickness"], girdle.high + ROUNDING["girdle_thickness"]
    if not low - rounding <= rest <= high + rounding:
        total = crown.value + girdle.thickness + pavilion.value
        allowed = rounding + ROUNDING["girdle_thickness"]
        raise InputError(
            f"{sum_of} + girdle {girdle.thickness:.3g} make {total:.1f} %; the rounding of a report allows a "
            f"difference of {allowed:.2g} %",
            key="depth",
            value=depth,
        )
    return crown, pavilion, girdle


def _rest(key: str, depth: float, others: float, words: str) -> float:
    """Return what the depth leaves for a part, which has to be within the part's range."""
    try:
        return number_within(key, depth - others)
    except InputError as error:
        name = key.replace("_", " ")
        raise InputError(
            f"less {words} ({others:.1f} %) leaves a {name} of {depth - others:.1f} %, which {error.allowed}",
            key="depth",
            value=depth,
        ) from error


def _contact(values: Mapping[str, object], assumed: list[Assumed]) -> float:
    """Return the lower-girdle contact [%]: 100 less the lower-half length."""
    lower = number_within("lower_half", values["lower_half"]) if "lower_half" in values else None
    if "lower_girdle_contact" in values:
        contact = number_within("lower_girdle_contact", values["lower_girdle_contact"])
        if lower is not None and abs(100 - lower - contact) > ROUNDING["lower_half"]:
            raise InputError(
                f"lower_half = {lower:g} makes it {100 - lower:g} %; the rounding of a report allows a "
                f"difference of {ROUNDING['lower_half']:g} %",
                key="lower_girdle_contact",
                value=contact,
            )
        return contact
    if lower is None:
        lower = DEFAULTS["lower_half"]
        assumed.append(Assumed("lower half", lower, "(not in the report)"))
    return 100.0 - lower


def _check_shape(shape: object) -> None:
    if not read_shape(str(shape)).is_round_brilliant:
        raise InputError("must be round: this is for round brilliants", key="shape", value=shape)

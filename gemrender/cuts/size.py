"""The size of a stone, from the millimetres and the weight that a file or a report states.

Millimetres also give proportions: length over width, and the depth in per cent of the width. What is given
twice must agree as far as a report's rounding allows.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gemrender.cuts.families.family import Family
from gemrender.cuts.families.stated import stated_keys
from gemrender.cuts.laboratory import ROUNDING as PERCENT_ROUNDING
from gemrender.cuts.round_brilliant.proportions import number_within
from gemrender.errors import InputError
from gemrender.mistakes import Mistakes, MistakesError
from gemrender.optics import carat_to_girdle_diameter_mm, load_material
from gemrender.optics.material import CARAT_RANGE, DIAMETER_RANGE_MM
from gemrender.stone import Stone

__all__ = ["SIZE_KEYS", "SQUARE", "WEIGHT_TOLERANCE", "StatedSize", "read_measurements", "read_size"]

#: What may be stated of a stone's size.
SIZE_KEYS = ("measurements", "length_mm", "width_mm", "depth_mm", "diameter_mm", "carat")
#: Half of the step that reports round millimetres to [mm]; those with fewer decimals are rounded more.
ROUNDING_MM = 0.005
#: Half of the step that length over width is rounded to.
RATIO_ROUNDING = 0.005
#: Length over width up to which a round or square stone is called so; trade guides take 1.00 to 1.05.
SQUARE = 1.05
#: By how much a weight may differ from that by volume and density before it is told [share]. Reports round
#: crown and pavilion by 0.25 % of the width each, which is up to 1 % of the volume, and do not state how
#: much facets bulge between the mains, nor painting and digging: one or two more.
WEIGHT_TOLERANCE = 0.03
#: Half of the step that weights are rounded to [carat].
CARAT_ROUNDING = 0.005
#: What the heights of a round brilliant in per cent, rounded as reports do, leave of its depth [%].
_HEIGHTS = PERCENT_ROUNDING["depth"] + 3 * PERCENT_ROUNDING["crown_height"]
_CARAT_MG = 200.0

_NUMBER = r"(\d+(?:[.,]\d+)?)\s*(?:mm\.?)?"
_BY = r"\s*(?:[x\u00d7\u2715*/\u2013\u2014-]|by)\s*"
_MEASUREMENTS = re.compile(rf"{_NUMBER}{_BY}{_NUMBER}(?:{_BY}{_NUMBER})?")
_AS_PRINTED = 'must be as reports print it: "8.10 x 5.95 x 3.70", of rounds "6.52 - 6.55 x 4.01" [mm]'
_LENGTHS = ("length_mm", "width_mm", "depth_mm")


@dataclass(frozen=True, slots=True, kw_only=True)
class StatedSize:
    """What is stated of a stone's size.

    Parameters
    ----------
    length_mm, width_mm, depth_mm : float or None
        Its box [mm]; of a round stone its largest and smallest diameter, and the depth.
    carat : float or None
        Its weight [carat].
    rounding_mm : float
        Half of the step that the millimetres are rounded to [mm].
    told : dict of str to (str, object)
        The key that stated each of these, and the value that it stated.
    """

    length_mm: float | None = None
    width_mm: float | None = None
    depth_mm: float | None = None
    carat: float | None = None
    rounding_mm: float = ROUNDING_MM
    told: Mapping[str, tuple[str, object]] = field(default_factory=dict, repr=False)

    # ---- From millimetres to proportions ----

    def proportions(self, kind: Any, values: Mapping[str, Any]) -> dict[str, float]:
        """Return what the millimetres make of a cut of a family where the file does not state it.

        Parameters
        ----------
        kind : type
            The class of the family's parameters.
        values : mapping
            What is stated of the cut, by key of `stated_keys`.

        Returns
        -------
        dict
            `length_to_width` and `depth`, those of them that the family has.

        Raises
        ------
        InputError
            What is stated twice does not agree.
        """
        made: dict[str, float] = {}
        known = stated_keys(kind)
        length, width = self.sides(kind)
        ratio = _number(values.get("length_to_width"))
        if "length_to_width" in known:
            if length and width:
                by_mm = length / width
                self._agree("length_to_width", by_mm, ratio, RATIO_ROUNDING + self._rounding(length, width))
                if "length_to_width" not in values:
                    made["length_to_width"] = by_mm
            if ratio is None:
                ratio = made.get("length_to_width", kind.__dataclass_fields__["length_to_width"].default)
        if width is None and length and ratio:
            width = length / ratio
        if self.is_even(kind) and length and width:
            width = 0.5 * (length + width)
        if "depth" in known and self.depth_mm and width:
            made |= self.depth_of(width, values)
        return made

    def depth_of(self, width: float, values: Mapping[str, Any]) -> dict[str, float]:
        """Return the depth [% of the width] that the millimetres make where it is not stated."""
        assert self.depth_mm is not None
        by_mm = 100.0 * self.depth_mm / width
        rounding = PERCENT_ROUNDING["depth"] + 100.0 * self._rounding(self.depth_mm, width)
        self._agree("depth", by_mm, _number(values.get("depth")), rounding)
        return {} if "depth" in values else {"depth": by_mm}

    def sides(self, kind: Any = None) -> tuple[float | None, float | None]:
        """Return length and width [mm]; the longer one first, unless the family knows wider ones."""
        length, width = self.length_mm, self.width_mm
        part = getattr(kind, "__dataclass_fields__", {}).get("length_to_width")
        if length and width and not (part is not None and part.metadata["range"][0] < 1.0):
            return max(length, width), min(length, width)
        return length, width

    @staticmethod
    def is_even(kind: Any) -> bool:
        """Whether a family's length is its width: round, or square."""
        known = getattr(kind, "__dataclass_fields__", {})
        return not any(key in known for key in ("length_to_width", "length"))

    def _rounding(self, one: float, other: float) -> float:
        """By how much one length over another may be off, since both are rounded."""
        return self.rounding_mm / other * (1.0 + one / other)

    def _agree(self, key: str, by_mm: float, stated: float | None, allowed: float) -> None:
        if stated is None or abs(stated - by_mm) <= allowed:
            return
        unit = " %" if key == "depth" else ""
        told, value = self.told["depth_mm" if key == "depth" else "length_mm"]
        raise InputError(
            f"makes the {_label(key)} {by_mm:.4g}{unit}, and it is stated as {stated:g}{unit}; the rounding "
            f"of a report allows a difference of {allowed:.2g}{unit}",
            key=told,
            value=value,
        )

    @contextmanager
    def blamed(self, made: Mapping[str, float], source: str | None = None) -> Iterator[None]:
        """Tell errors of proportions that the millimetres made as errors of these.

        Parameters
        ----------
        made : mapping
            As `proportions` returns it.
        source : str, optional
            The file whose section [size] states them.
        """
        try:
            yield
        except InputError as error:
            errors = error.errors if isinstance(error, MistakesError) else (error,)
            if not any(one.key in made for one in errors):
                raise
            told = [self._of_millimetres(one, made, source) for one in errors]
            raise (told[0] if len(told) == 1 else MistakesError(told)) from error

    def _of_millimetres(self, error: InputError, made: Mapping[str, float], source: str | None) -> InputError:
        if error.key is None or error.key not in made:
            return error
        key, value = self.told["depth_mm" if error.key == "depth" else "length_mm"]
        unit = " %" if error.key == "depth" else ""
        words = f"makes the {_label(error.key)} {made[error.key]:.4g}{unit}; it {error.allowed}"
        told = InputError(words, key=key, value=value)
        return told if source is None else told.at(source, "size")

    # ---- From millimetres to the stone's size ----

    def sized(self, stone: Stone, agreed: Mapping[str, Any] | None = None) -> Stone:
        """Return the stone with its size, and a note where its weight is another than the stated one.

        Parameters
        ----------
        stone : Stone
            The stone.
        agreed : mapping or None
            Keys of proportions that are known to agree with the millimetres.

        Raises
        ------
        InputError
            The stone's shape does not agree with the millimetres, or its weight cannot be known.
        """
        agreed = agreed or {}
        own = _box(stone)
        kind = type(stone.cut) if isinstance(stone.cut, Family) else None
        stated = dict(zip(_LENGTHS, (*self.sides(kind), self.depth_mm), strict=True))
        even = own["length_mm"] / own["width_mm"] <= SQUARE
        if even and (kind is None or self.is_even(kind)):
            stated |= self._evened(stated)
        scales = {key: value / own[key] for key, value in stated.items() if value}
        size: float | None = None
        if scales:
            key, scale = next(iter(scales.items()))
            size = 2.0 * scale
            self._check_box(stone, own, stated, key, agreed)
        if self.carat is not None:
            density = self._density(stone, size)
            if size is None:
                assert density is not None
                size = carat_to_girdle_diameter_mm(self.carat, stone.solid.volume, density)
            elif density is not None:
                stone = self._weighed(stone, size, density)
        if size is None:
            return stone
        low, high = DIAMETER_RANGE_MM
        if not low <= size <= high:
            told, value = self.told[next(iter(scales))]
            words = f"must make a stone of {low:g} to {high:g} mm; this makes {size:.3g} mm"
            raise InputError(words, key=told, value=value)
        return replace(stone, size_mm=size)

    def _evened(self, stated: Mapping[str, float | None]) -> dict[str, float | None]:
        """Return the mean diameter of a round or square stone in place of length and width."""
        length, width = stated["length_mm"], stated["width_mm"]
        if not length or not width:
            return {"length_mm": length or width, "width_mm": None}
        if max(length, width) / min(length, width) > SQUARE:
            key, value = self.told["length_mm"]
            raise InputError(
                f"must be at most {SQUARE:g} times the width: the cut is as wide as long",
                key=key,
                value=value,
            )
        return {"length_mm": 0.5 * (length + width), "width_mm": None}

    def _check_box(
        self,
        stone: Stone,
        own: Mapping[str, float],
        stated: Mapping[str, float | None],
        first: str,
        agreed: Mapping[str, Any],
    ) -> None:
        """Refuse millimetres that are not those of the stone's own shape."""
        scale = (stated[first] or 0.0) / own[first]
        of = {"width_mm": "length_to_width", "depth_mm": "depth"}
        for key, value in stated.items():
            if key == first or not value or of[key] in agreed:
                continue
            made = own[key] * scale
            allowed = self.rounding_mm * (1.0 + own[key] / own[first])
            if key == "depth_mm":
                percent = _HEIGHTS if stone.proportions is not None else PERCENT_ROUNDING["depth"]
                allowed += percent / 100.0 * own["width_mm"] * scale
            if abs(made - value) > allowed:
                told, written = self.told[key]
                raise InputError(
                    f"the stone's shape makes the {key[:-3]} {made:.2f} mm where the {first[:-3]} is "
                    f"{stated[first]:.2f} mm; rounding allows a difference of {allowed:.2g} mm",
                    key=told,
                    value=written,
                )

    def _density(self, stone: Stone, size: float | None) -> float | None:
        """Return the density of the stone's material [g/cm^3]; None where it is not known and not needed."""
        try:
            material = load_material("diamond" if stone.material is None else stone.material)
        except InputError:
            if size is not None:  # what is wrong with the material is told by who needs it
                return None
            raise
        if material.density is None and size is None:
            key, value = self.told["carat"]
            words = "needs the material's density, which is not known; state millimetres instead"
            raise InputError(words, key=key, value=value)
        return material.density

    def _weighed(self, stone: Stone, size: float, density: float) -> Stone:
        assert self.carat is not None
        made = stone.solid.volume * (size / 2.0) ** 3 * density / _CARAT_MG
        if abs(made - self.carat) <= WEIGHT_TOLERANCE * self.carat + CARAT_ROUNDING:
            return stone
        note = (
            f"the millimetres make {made:.3g} ct, {self.carat:g} ct are stated: {made / self.carat - 1:+.1%}, "
            f"beyond {WEIGHT_TOLERANCE:.0%}: the shape is not quite that of the stone"
        )
        return replace(stone, notes=(*stone.notes, note.replace("%", " %")))


def read_size(values: Mapping[str, object]) -> StatedSize:
    """Read what is stated of a size.

    Parameters
    ----------
    values : mapping
        By key of `SIZE_KEYS`: numbers [mm, carat], and the measurements as one text.

    Raises
    ------
    InputError
        Nothing is stated, a value that no stone has, or two for one thing that differ.
    """
    found: dict[str, float] = {}
    told: dict[str, tuple[str, object]] = {}
    rounding = ROUNDING_MM
    with Mistakes() as mistakes:

        def add(part: str, number: float, key: str) -> None:
            if part in found and abs(found[part] - number) > rounding + ROUNDING_MM:
                other, value = told[part]
                raise InputError(
                    f"{other} = {value!r} makes it {found[part]:g}; state only one", key=key, value=number
                )
            if part not in found:
                found[part], told[part] = number, (key, values[key])

        if "measurements" in values:
            read = mistakes.of(read_measurements, values["measurements"])
            if read is not None:
                numbers, rounding = read
                for part, number in zip(_LENGTHS, numbers, strict=False):
                    add(part, number, "measurements")
        for key in ("length_mm", "width_mm", "depth_mm", "diameter_mm"):
            if key not in values:
                continue
            value = mistakes.of(number_within, key, values[key], DIAMETER_RANGE_MM, "mm")
            for part in _LENGTHS[:2] if key == "diameter_mm" else (key,):
                if value is not None:
                    mistakes.of(add, part, value, key)
        if "carat" in values:
            weight = mistakes.of(number_within, "carat", values["carat"], CARAT_RANGE, "carat")
            if weight is not None:
                add("carat", weight, "carat")
        if not values:
            raise InputError(f"needs one or more of {', '.join(SIZE_KEYS)}")
    return StatedSize(**found, rounding_mm=rounding, told=told)


def read_measurements(text: object) -> tuple[tuple[float, ...], float]:
    """Read measurements as reports print them.

    Parameters
    ----------
    text : str
        "8.10 x 5.95 x 3.70 mm": length, width and depth, or the first two alone; of rounds the smallest and
        the largest diameter and the depth, "6.52 - 6.55 x 4.01".

    Returns
    -------
    (tuple of float, float)
        Length, width and depth, the longer side first [mm], and half of the step that they are rounded to.

    Raises
    ------
    InputError
        It is no such text.
    """
    found = _MEASUREMENTS.fullmatch(" ".join(text.casefold().split())) if isinstance(text, str) else None
    if found is None:
        raise InputError(_AS_PRINTED, key="measurements", value=text)
    parts = [part.replace(",", ".") for part in found.groups() if part is not None]
    numbers = [number_within("measurements", float(part), DIAMETER_RANGE_MM, "mm") for part in parts]
    decimals = max(len(part.partition(".")[2]) for part in parts)
    return tuple(numbers), 0.5 * 10.0 ** -min(decimals, 2)


def _box(stone: Stone) -> dict[str, float]:
    """Return length, width and depth of a stone in its own unit."""
    if stone.is_round:
        width = length = 2.0
    else:
        width, length = np.ptp(stone.solid.vertices[:, :2], axis=0).tolist()
        if not isinstance(stone.cut, Family):
            width, length = min(width, length), max(width, length)
    return {
        "length_mm": length,
        "width_mm": width,
        "depth_mm": float(np.ptp(stone.solid.vertices[:, 2])),
    }


def _number(value: object) -> float | None:
    """Return a stated number; None for what is none, which is told by who checks it."""
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None


def _label(key: str) -> str:
    return key.replace("_", " ")

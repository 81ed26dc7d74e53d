"""The size of a stone, by the millimetres and the weight that are stated of it.

Millimetres also give proportions: length over width, and the depth in per cent of the width. What is given
twice must agree as far as a report's rounding allows.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from gemrender.cuts.families.family import Family
from gemrender.cuts.families.stated import stated_keys
from gemrender.cuts.laboratory import ROUNDING as PERCENT_ROUNDING
from gemrender.errors import InputError
from gemrender.mistakes import MistakesError
from gemrender.optics import carat_to_girdle_diameter_mm, load_material
from gemrender.optics.material import DIAMETER_RANGE_MM
from gemrender.stone import Stone

__all__ = ["LENGTHS", "ROUNDING_MM", "SQUARE", "WEIGHT_TOLERANCE", "StatedSize"]

#: The three lengths of a stone's box.
LENGTHS = ("length_mm", "width_mm", "depth_mm")

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
#: What the depth of a cut of a family is the sum of [% of the width].
_PARTS = ("crown_height", "girdle_thickness", "pavilion_depth")
#: Rounding of a stone's corners [stone's unit].
_SAME = 1e-9


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
        if self.is_even(kind):
            length = width = self._evened(length, width)
        if "depth" in known and self.depth_mm and width:
            shorter = min(width, length or width)  # what per cent are of
            made |= self._depth_of(shorter, values)
        return made

    def depth_of_round(self, values: Mapping[str, Any]) -> dict[str, float]:
        """Return the depth [% of the mean diameter] that the millimetres of a round stone make."""
        diameter = self._evened(*self.sides())
        return self._depth_of(diameter, values) if diameter and self.depth_mm else {}

    def _depth_of(self, width: float, values: Mapping[str, Any]) -> dict[str, float]:
        """Return the depth [% of the width] that the millimetres make where it is not stated."""
        assert self.depth_mm is not None
        by_mm = 100.0 * self.depth_mm / width
        rounding = PERCENT_ROUNDING["depth"] + 100.0 * self._rounding(self.depth_mm, width)
        self._agree("depth", by_mm, _number(values.get("depth")), rounding)
        return {} if "depth" in values else {"depth": by_mm}

    def sides(self, kind: Any = None) -> tuple[float | None, float | None]:
        """Return length and width [mm], in whichever order they are stated: the longer one first.

        Of a family that may be wider than long, as triangles are, the order is that which is more like the
        family's own example: reports do not say which side they measure.
        """
        length, width = self.length_mm, self.width_mm
        if not length or not width:
            return length, width
        longer, shorter = max(length, width), min(length, width)
        part = getattr(kind, "__dataclass_fields__", {}).get("length_to_width")
        if part is not None and part.metadata["range"][0] < 1.0 and _own_ratio(kind) < 1.0:
            return shorter, longer
        return longer, shorter

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
        words = f"makes the {_label(error.key)} {made[error.key]:.4g}{unit}: {error.allowed}"
        told = InputError(words, key=key, value=value)
        return told if source is None else told.at(source, "size")

    # ---- From millimetres to the stone's size ----

    def sized(self, stone: Stone, agreed: Collection[str] = (), *, needs_density: bool = True) -> Stone:
        """Return the stone with its size, and a note where its weight is another than the stated one.

        Parameters
        ----------
        stone : Stone
            The stone.
        agreed : collection of str
            Keys of proportions that are known to agree with the millimetres.
        needs_density : bool
            Whether a weight alone must give the size; without, it may stay unknown with the density.

        Raises
        ------
        InputError
            The stone's shape does not agree with the millimetres, or its weight cannot be known.
        """
        own = _box(stone)
        kind = type(stone.cut) if isinstance(stone.cut, Family) else None
        stated = dict(zip(LENGTHS, (*self.sides(kind), self.depth_mm), strict=True))
        even = own["length_mm"] / own["width_mm"] <= SQUARE
        if even and (kind is None or self.is_even(kind)):
            stated |= {"length_mm": self._evened(*self.sides()), "width_mm": None}
        scales = {key: value / own[key] for key, value in stated.items() if value}
        size: float | None = None
        if scales:
            key, scale = next(iter(scales.items()))
            size = 2.0 * scale
            self._check_box(stone, own, stated, key, agreed)
        if self.carat is not None:
            density = self._density(stone, needs_density and size is None)
            if size is not None and density is not None:
                stone = self._weighed(stone, size, density)
            elif density is not None:
                size = carat_to_girdle_diameter_mm(self.carat, stone.solid.volume, density)
        if size is None:
            return stone
        low, high = DIAMETER_RANGE_MM
        if not low <= size <= high:
            told, value = self.told[next(iter(scales))]
            words = f"must make a stone of {low:g} to {high:g} mm; this makes {size:.3g} mm"
            raise InputError(words, key=told, value=value)
        return replace(stone, size_mm=size)

    def _evened(self, length: float | None, width: float | None) -> float | None:
        """Return the mean diameter of a round or square stone."""
        if not length or not width:
            return length or width
        if max(length, width) > SQUARE * min(length, width):
            key, value = self.told["length_mm"]
            raise InputError(
                f"must be at most {SQUARE:g} times the width: the cut is as wide as long",
                key=key,
                value=value,
            )
        return 0.5 * (length + width)

    def _check_box(
        self,
        stone: Stone,
        own: Mapping[str, float],
        stated: Mapping[str, float | None],
        first: str,
        agreed: Collection[str],
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

    def _density(self, stone: Stone, needed: bool) -> float | None:
        """Return the density of the stone's material [g/cm^3]; None where it is not known and not needed."""
        try:
            density = load_material("diamond" if stone.material is None else stone.material).density
        except InputError:
            if needed:
                raise
            return None  # what is wrong with the material is told by who needs it
        if density is None and needed:
            key, value = self.told["carat"]
            words = "needs the material's density, which is not known; state millimetres instead"
            raise InputError(words, key=key, value=value)
        return density

    def _weighed(self, stone: Stone, size: float, density: float) -> Stone:
        assert self.carat is not None
        made = stone.solid.volume * (size / 2.0) ** 3 * density / _CARAT_MG
        if abs(made - self.carat) <= WEIGHT_TOLERANCE * self.carat + CARAT_ROUNDING:
            return stone
        note = (
            f"its millimetres make {made:.3g} ct, and {self.carat:g} ct are stated: "
            f"{made / self.carat - 1:+.1%}, beyond {WEIGHT_TOLERANCE:.0%}"
        )
        return replace(stone, notes=(*stone.notes, note.replace("%", " %")))


@cache
def _own_ratio(kind: Any) -> float:
    """Return the length over the width of a family's own example."""
    width, length = np.ptp(kind().construction().points[:, :2], axis=0).tolist()
    return float(length / width)


def _box(stone: Stone) -> dict[str, float]:
    """Return length, width and depth of a stone in its own unit."""
    cut = stone.cut
    ratio = getattr(cut, "length_to_width", 0.0)
    if isinstance(cut, Family) and ratio and all(hasattr(cut, part) for part in _PARTS):
        # Without the stone's corners, which take longer: the longer side is two units.
        length, width = (2.0, 2.0 / ratio) if ratio >= 1.0 else (2.0 * ratio, 2.0)
        depth = sum(getattr(cut, part) for part in _PARTS) / 100.0 * min(length, width)
        return dict(zip(LENGTHS, (length, width, depth), strict=True))
    if stone.is_round:
        width = length = 2.0
    else:
        width, length = np.ptp(stone.solid.vertices[:, :2], axis=0).tolist()
        if not isinstance(cut, Family):
            width, length = min(width, length), max(width, length)
        # The longer side is two units by definition, but for rounding, and for stones that are turned.
        width, length = (2.0 if abs(side - 2.0) <= _SAME else side for side in (width, length))
    depth = float(np.ptp(stone.solid.vertices[:, 2]))
    return dict(zip(LENGTHS, (length, width, depth), strict=True))


def _number(value: object) -> float | None:
    """Return a stated number; None for what is none, which is told by who checks it."""
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None


def _label(key: str) -> str:
    return key.replace("_", " ")

"""Variations of one stone: values set for some of its proportions, on a grid."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import fields, replace
from decimal import Decimal, InvalidOperation
from functools import cache
from typing import Any

import numpy as np

from gemrender.cuts.families import families
from gemrender.cuts.families.family import Family
from gemrender.cuts.given import StoneLike, as_stone
from gemrender.cuts.round_brilliant.proportions import (
    RANGES,
    RoundBrilliant,
    crown_height_from_angle,
    number_within,
    pavilion_depth_from_angle,
)
from gemrender.cuts.stones import Lazy, Stones, taken_lines
from gemrender.errors import InputError
from gemrender.reading import did_you_mean
from gemrender.stone import Stone

__all__ = [
    "MOST_VARIATIONS",
    "SETTINGS",
    "Variations",
    "all_settings",
    "check_keys",
    "parse_setting",
    "settings_of",
    "varied",
    "vary",
]

#: Most stones of a grid: days of work.
MOST_VARIATIONS = 1_000_000

#: So many stones of a family's grid are checked beforehand, in a few seconds; of more the grid's corners.
MOST_CHECKED = 1000

_MATERIAL = ("index", "material")
#: What can be set of round brilliants: the keys of a stone file's [proportions] and [angles], and its
#: material.
SETTINGS = (
    *dict.fromkeys(("table", "crown_angle", "pavilion_angle", "star", "lower_half", *RANGES)),
    *_MATERIAL,
)

#: Keys for one and the same thing.
_SAME = (
    ("crown_angle", "crown_height"),
    ("pavilion_angle", "pavilion_depth"),
    ("lower_half", "lower_girdle_contact"),
    ("index", "material"),
)

#: What `Stone.assumed` calls what a key sets.
_ASSUMED_AS = {
    "crown_angle": "crown height",
    "crown_height": "crown height",
    "pavilion_angle": "pavilion depth",
    "pavilion_depth": "pavilion depth",
    "lower_half": "lower half",
    "lower_girdle_contact": "lower half",
    "girdle_thickness": "girdle",
    "star": "star",
}

_FORMS = "must be a value, values with commas between them, or first:last:step, such as 39:42:0.1"

Value = float | str


def settings_of(stone: Stone) -> tuple[str, ...]:
    """Return the keys that can be set of a stone: proportions or parameters, and its material."""
    return _settings_of(type(stone.cut)) if isinstance(stone.cut, Family) else SETTINGS


def all_settings() -> tuple[str, ...]:
    """Return the keys that can be set of stones of any kind."""
    own = (_settings_of(kind) for kind in families().values() if issubclass(kind, Family))
    return tuple(dict.fromkeys(itertools.chain(SETTINGS, *own)))


def _settings_of(kind: type[Family]) -> tuple[str, ...]:
    """Return the keys that can be set of the cuts of a family."""
    own = (part.name for part in fields(kind))  # type: ignore[arg-type]
    return (*own, *(other.name for other in kind.ALTERNATIVES), *_MATERIAL)


def parse_setting(text: str, keys: Sequence[str] = SETTINGS) -> tuple[str, tuple[Value, ...]]:
    """Read a setting such as "pavilion_angle=39:42:0.1".

    Parameters
    ----------
    text : str
        A key, "=", and a value, values with commas between them, or first:last:step. Steps are counted in
        decimals: 39:42:0.1 is 39, 39.1 ... 42, each the number that is written so.
    keys : sequence of str
        The keys that can be set.

    Returns
    -------
    tuple of str and tuple
        The key and its values: numbers, or words such as names of materials.

    Raises
    ------
    InputError
        Unknown key, or no such values.
    """
    key, equals, values = text.partition("=")
    name = key.strip().replace("-", "_").lower()
    if not equals:
        raise InputError("must be KEY=VALUE, such as pavilion_angle=39:42:0.1", value=text)
    _check_key(name, key.strip(), keys)
    parts = [part.strip() for part in values.split(",")]
    if name == "material":
        if not all(parts):
            raise InputError("must be names of materials, with commas between them", key=name, value=values)
        return name, tuple(parts)
    found: list[Value] = []
    for part in parts:
        found += [part] if part.isalpha() and name in _words() else _grid(name, part)
        if len(found) > MOST_VARIATIONS:
            raise InputError(f"makes more than {MOST_VARIATIONS} values", key=name, value=values)
    return name, tuple(found)


def _check_key(name: str, written: str, keys: Sequence[str]) -> None:
    if name not in keys:
        raise InputError(
            f"unknown key; must be one of {', '.join(keys)}{did_you_mean(name, keys)}",
            key=written or "''",
        )


@cache
def _words() -> frozenset[str]:
    """Return the keys that words can be set for: choices, and numbers that have words such as "medium"."""
    return frozenset(
        part.name
        for kind in families().values()
        if issubclass(kind, Family)
        for part in fields(kind)
        if "allowed" in part.metadata or part.metadata["words"] is not None
    )


def _grid(key: str, text: str) -> list[float]:
    """Read a number, or first:last:step."""
    cells = text.split(":")
    try:
        # Decimal takes more than a number should be written as.
        if len(cells) not in (1, 3) or any("_" in cell or not cell.strip() for cell in cells):
            raise InvalidOperation
        numbers = [Decimal(cell.strip()) for cell in cells]
        if not all(number.is_finite() and abs(number.adjusted()) <= 300 for number in numbers if number):
            raise InvalidOperation
    except InvalidOperation:
        raise InputError(_FORMS, key=key, value=text) from None
    if len(numbers) == 1:
        return [float(numbers[0])]
    first, last, step = numbers
    if not step or (last - first) / step < 0:
        raise InputError("must have a step that leads from the first value to the last", key=key, value=text)
    steps = (last - first) / step
    if steps >= MOST_VARIATIONS:
        raise InputError(f"makes more than {MOST_VARIATIONS} values", key=key, value=text)
    return [float(first + i * step) for i in range(math.floor(steps) + 1)]


class Variations(Stones):
    """The stones of a grid of settings, the last key varying fastest, each made when it is asked for.

    Attributes
    ----------
    keys : tuple of str
        The keys that are set, in the order given.
    settings : sequence of dict
        For each stone, the values that were set for it, by key.
    """

    def __init__(self, stone: Stone, axes: Mapping[str, Sequence[Value]]) -> None:
        self._base, self._axes = stone, dict(axes)
        self.keys = tuple(axes)
        self._length = math.prod(len(values) for values in axes.values())
        left = [words for words in stone.assumed if not _is_set(words, axes)]
        self.notes = tuple(f"{stone.name}: {words}" for words in taken_lines(left))

    def __len__(self) -> int:
        return self._length

    @property
    def name(self) -> str:
        """The name of the stone that is varied."""
        return self._base.name

    @property
    def settings(self) -> Sequence[dict[str, Value]]:
        """For each stone, the values that were set for it, by key."""
        return Lazy(len(self), self._setting)

    @property
    def materials(self) -> dict[str | float | None, str]:
        """Every material of the stones, and where it comes from."""
        for key in _MATERIAL:
            if key in self._axes:
                return dict.fromkeys(self._axes[key], f"{self._base.name}, {key}")
        return {self._base.material: self._base.source or self._base.name}

    def _setting(self, i: int) -> dict[str, Value]:
        setting: dict[str, Value] = {}
        for key in reversed(self.keys):
            i, place = divmod(i, len(self._axes[key]))
            setting[key] = self._axes[key][place]
        return {key: setting[key] for key in self.keys}

    def _stone(self, i: int) -> Stone:
        return varied(self._base, self._setting(i))


def vary(stone: StoneLike, settings: Iterable[str | tuple[str, Sequence[Value]]]) -> Variations:
    """Return a stone with every combination of the values that are set.

    What is not set stays as the stone file has it: where its crown is given by the angle ([angles],
    [report]), another table keeps the angle; where by the height ([proportions], [cut]), the height.

    Parameters
    ----------
    stone : Stone, str or path-like
        The stone, or what `load_stone` takes.
    settings : iterable of str or pair
        Settings as `parse_setting` reads them, or as it returns them.

    Returns
    -------
    Variations
        The stones, checked: each is made when it is asked for, and is called by the stone's name and its
        settings, as in "Inoue sample 3 pavilion_angle=39.1".

    Raises
    ------
    InputError
        A setting that cannot be, two for one thing, more than `MOST_VARIATIONS` stones, a value that makes no
        stone, or proportions set for a measured stone.
    """
    base = as_stone(stone)
    keys = settings_of(base)
    axes: dict[str, Sequence[Value]] = {}
    for setting in settings:
        key, values = parse_setting(setting, keys) if isinstance(setting, str) else setting
        _check_key(key, key, keys)
        if key in axes:
            raise InputError("is set twice", key=key)
        if not len(values):
            raise InputError("has no value", key=key)
        axes[key] = tuple(values)
    check_keys(base, axes)
    count = math.prod(len(values) for values in axes.values())
    if count > MOST_VARIATIONS:
        numbers = " x ".join(str(len(values)) for values in axes.values())
        raise InputError(
            f"make {numbers} = {count} stones; at most {MOST_VARIATIONS} are allowed", key="settings"
        )
    _check(base, axes)
    made = Variations(base, axes)
    if isinstance(base.cut, Family):
        _check_made(made, axes)
    return made


def check_keys(stone: Stone, keys: Collection[str]) -> None:
    """See that these keys can be set of a stone, all of them together.

    Raises
    ------
    InputError
        Unknown key, two for one thing, or proportions of a measured stone.
    """
    for key in keys:
        _check_key(key, key, settings_of(stone))
    for one, other in _SAME:
        if one in keys and other in keys:
            raise InputError(f"{one} and {other} are one thing; set only one of them", key=other)
    is_made = stone.proportions is not None or isinstance(stone.cut, Family)
    if not is_made and (measured := [key for key in keys if key not in _MATERIAL]):
        raise InputError(
            "cannot be set: the stone is not made from proportions",
            source=stone.source or stone.name,
            key=measured[0],
        )


def _check(base: Stone, axes: Mapping[str, Sequence[Value]]) -> None:
    """Refuse values that make no stone.

    What has to hold is monotonic in every value: crown height and pavilion depth in angles and table, the
    smallest star in the table. So the grid's corners tell of all of it.
    """
    ends: list[list[Value]] = []
    for key, values in axes.items():
        if key == "material":
            ends.append(list(values[:1]))
        elif key == "index":
            for value in values:
                if isinstance(value, (str, bool)) or not 1 < value < math.inf:
                    raise InputError("must be a finite number above 1", key=key, value=value)
            ends.append(list(values[:1]))
        elif isinstance(base.cut, Family):  # told when they are made
            continue
        else:
            numbers = [number_within(key, value) for value in values]
            ends.append([min(numbers), max(numbers)])
    if base.proportions is not None:
        for corner in itertools.product(*ends):
            _proportions(base, base.proportions, dict(zip(axes, corner, strict=True)))


def _check_made(stones: Variations, axes: Mapping[str, Sequence[Value]]) -> None:
    """Refuse a grid of a family's stones some of which cannot be made; of a large grid its corners."""
    numbers: Iterable[int] = range(len(stones))
    if len(stones) > MOST_CHECKED:
        sizes = [len(values) for values in axes.values()]
        corners = itertools.product(*([0, size - 1] for size in sizes))
        numbers = (int(np.ravel_multi_index(corner, sizes)) for corner in corners)
    for number in numbers:
        try:
            stones[number]
        except InputError as error:
            setting = " ".join(f"{key}={_shown(value)}" for key, value in stones.settings[number].items())
            raise InputError(
                error.allowed, source=f"{stones.name} with {setting}", key=error.key, value=error.value
            ) from error


def varied(base: Stone, setting: Mapping[str, Value]) -> Stone:
    """Return a stone with values set, by keys that `check_keys` allows.

    Raises
    ------
    InputError
        The values make no stone.
    """
    words = " ".join(f"{key}={_shown(value)}" for key, value in setting.items())
    made: dict[str, Any] = {
        "name": f"{base.name} {words}".strip(),
        "material": setting.get("material", setting.get("index", base.material)),
        "assumed": tuple(text for text in base.assumed if not _is_set(text, setting)),
    }
    own = {key: value for key, value in setting.items() if key not in _MATERIAL}
    if not own:
        return replace(base, **made)
    if isinstance(base.cut, Family):
        stone: Stone = base.cut.changed(**own).stone(
            source=base.source,
            description=base.description,
            size_mm=base.size_mm,
            crystal=base.crystal,
            **made,
        )
        return stone
    return Stone.from_proportions(
        _proportions(base, base.proportions, setting),
        source=base.source,
        description=base.description,
        size_mm=base.size_mm,
        crystal=base.crystal,
        **made,
    )


def _proportions(base: Stone, proportions: RoundBrilliant, setting: Mapping[str, Value]) -> RoundBrilliant:
    values: dict[str, Any] = proportions.values()
    values |= {key: value for key, value in setting.items() if key in RANGES}
    crown_angle = setting.get("crown_angle")
    if crown_angle is None and "crown_height" not in setting and values["table"] != proportions.table:
        by_angle = base.description in ("angles", "report")
        crown_angle = proportions.crown_angle_deg if by_angle else None
    if crown_angle is not None:
        table = number_within("table", values["table"])
        values["crown_height"] = crown_height_from_angle(table, number_within("crown_angle", crown_angle))
    if "pavilion_angle" in setting:
        angle = number_within("pavilion_angle", setting["pavilion_angle"])
        values["pavilion_depth"] = pavilion_depth_from_angle(angle)
    if "lower_half" in setting:
        values["lower_girdle_contact"] = 100.0 - number_within("lower_half", setting["lower_half"])
    return RoundBrilliant(**values)


def _shown(value: Value) -> str:
    return value if isinstance(value, str) else f"{value:.15g}"


def _is_set(assumed: str, keys: Iterable[str]) -> bool:
    """Whether something assumed of the base stone has been set after all."""
    return any(assumed.startswith(f"{_ASSUMED_AS.get(key, key.replace('_', ' '))} ") for key in keys)

"""Rows of tables whose stones are not round, kept small: numbers in one array, words and keys once."""

from __future__ import annotations

from array import array
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gemrender.cuts.families.stated import stated_keys
from gemrender.cuts.fancy_reports import FancyReport, fancy_stone
from gemrender.cuts.shape_words import Shape
from gemrender.cuts.size import StatedSize
from gemrender.stone import Stone

__all__ = ["FancyRow", "FancyRows"]

_SIZES = ("length_mm", "width_mm", "depth_mm", "carat", "rounding_mm")


@dataclass(frozen=True, slots=True)
class FancyRow:
    """What a row states.

    Parameters
    ----------
    shape : Shape
        The shape.
    values : mapping
        As `fancy_stone` takes them.
    size : StatedSize or None
        Millimetres and weight.
    """

    shape: Shape
    values: Mapping[str, Any]
    size: StatedSize | None = None

    def stone(self, **facts: Any) -> tuple[Stone, FancyReport]:
        """Make the stone, and say what was read; `facts` are fields of `Stone` such as its name.

        Raises
        ------
        InputError
            As `fancy_stone`, or it is not of the size.
        """
        stone, report = fancy_stone(self.shape, self.values, self.size, passes_over=True, **facts)
        if self.size is not None:
            stone = self.size.sized(stone, stated_keys(self.shape.kind), needs_density=False)
        return stone, report


class FancyRows:
    """A list of rows, each made anew when it is asked for."""

    def __init__(self) -> None:
        self._numbers = array("d")
        self._first = array("q")
        self._layout = array("q")
        # Shape, keys, and which of these have words; and the words: few of each in any table.
        self._layouts: dict[tuple[Shape, tuple[str, ...], tuple[bool, ...]], int] = {}
        self._words: dict[str, int] = {}
        self._listed: tuple[list[Any], list[str]] = ([], [])

    def __len__(self) -> int:
        return len(self._first)

    def append(self, row: FancyRow) -> None:
        """Add a row."""
        values = dict(row.values)
        if row.size is not None:
            sizes = {key: getattr(row.size, key) for key in _SIZES}
            values |= {f"size {key}": size for key, size in sizes.items() if size is not None}
        worded = tuple(isinstance(value, str) for value in values.values())
        layouts, words = self._listed
        layout = (row.shape, tuple(values), worded)
        if layout not in self._layouts:
            self._layouts[layout] = len(layouts)
            layouts.append(layout)
        self._first.append(len(self._numbers))
        self._layout.append(self._layouts[layout])
        for value in values.values():
            if isinstance(value, str) and value not in self._words:
                self._words[value] = len(words)
                words.append(value)
            self._numbers.append(self._words[value] if isinstance(value, str) else value)

    def __getitem__(self, i: int) -> FancyRow:
        layouts, words = self._listed
        shape, keys, worded = layouts[self._layout[i]]
        numbers = self._numbers[self._first[i] : self._first[i] + len(keys)]
        values: dict[str, Any] = {}
        sizes: dict[str, Any] = {}
        for key, number, is_word in zip(keys, numbers, worded, strict=True):
            if key.startswith("size "):
                sizes[key.removeprefix("size ")] = number
            else:
                values[key] = words[int(number)] if is_word else number
        return FancyRow(shape, values, StatedSize(**sizes) if sizes else None)

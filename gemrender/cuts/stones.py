"""Many stones: a sequence that makes each of them when it is asked for."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Generic, TypeVar, overload

from gemrender.cuts.laboratory import OWN
from gemrender.stone import Stone

__all__ = ["LONGEST_NAME", "NO_MATERIAL", "Lazy", "OfMaterial", "OneStone", "Stones", "taken_lines"]

#: What ends the words for a material that was taken since a file has none.
NO_MATERIAL = "(no material in the file)"
#: Longest name of a stone [characters]: it has to fit into tables and file names.
LONGEST_NAME = 100

_T = TypeVar("_T")


def taken_lines(assumed: Sequence[str]) -> list[str]:
    """Return what was assumed of a stone in lines: one each, of a member of a family one in all.

    Parameters
    ----------
    assumed : sequence of str
        As of the stone.
    """
    own = [words.removesuffix(OWN).strip() for words in assumed if words.endswith(OWN)]
    if not own:
        return list(assumed)
    return ["; ".join([*(words for words in assumed if not words.endswith(OWN)), f"{', '.join(own)} {OWN}"])]


class Lazy(Sequence[_T], Generic[_T]):
    """A sequence whose items are made when asked for, and not kept.

    Parameters
    ----------
    length : int
        Number of items.
    make : callable
        Makes item i, from 0.
    """

    def __init__(self, length: int, make: Callable[[int], _T]) -> None:
        self._length, self._make = length, make

    def __len__(self) -> int:
        return self._length

    @overload
    def __getitem__(self, i: int) -> _T: ...
    @overload
    def __getitem__(self, i: slice) -> Lazy[_T]: ...
    def __getitem__(self, i: int | slice) -> _T | Lazy[_T]:
        numbers = range(self._length)[i]
        if isinstance(numbers, range):
            return Lazy(len(numbers), lambda k: self._make(numbers[k]))
        return self._make(numbers)


class Stones(Sequence[Stone]):
    """Stones of one source, made one at a time: a few bytes each until then.

    Attributes
    ----------
    notes : tuple of str
        What a user should be told of the source: columns that are not used, what was assumed.
    settings : sequence of dict
        For each stone, the values that were set for it (`vary`), by key; empty where none were.
    """

    notes: tuple[str, ...] = ()

    @property
    def settings(self) -> Sequence[dict[str, float | str]]:
        """For each stone, the values that were set for it, by key."""
        return Lazy(len(self), lambda _: {})

    @property
    def materials(self) -> dict[str | float | None, str]:
        """Every material of the stones, and the source of the first that has it: to check beforehand."""
        found: dict[str | float | None, str] = {}
        for stone in self:
            found.setdefault(stone.material, stone.source or stone.name)
        return found

    @abstractmethod
    def __len__(self) -> int: ...

    @abstractmethod
    def _stone(self, i: int) -> Stone:
        """Make stone i, from 0."""

    @overload
    def __getitem__(self, i: int) -> Stone: ...
    @overload
    def __getitem__(self, i: slice) -> Sequence[Stone]: ...
    def __getitem__(self, i: int | slice) -> Stone | Sequence[Stone]:
        return Lazy(len(self), self._stone)[i]


class OneStone(Stones):
    """A single stone, as a sequence.

    Parameters
    ----------
    stone : Stone
        The stone.
    """

    def __init__(self, stone: Stone) -> None:
        self._only = stone

    def __len__(self) -> int:
        return 1

    def _stone(self, i: int) -> Stone:
        return self._only


class OfMaterial(Stones):
    """The same stones, all of one material.

    Parameters
    ----------
    stones : Stones
        The stones.
    material : str or float
        Name of their material, or its refractive index.
    """

    def __init__(self, stones: Stones, material: str | float) -> None:
        self._stones, self._material = stones, material
        self.notes = stones.notes

    @property
    def settings(self) -> Sequence[dict[str, float | str]]:
        """As of the stones themselves."""
        return self._stones.settings

    @property
    def materials(self) -> dict[str | float | None, str]:
        """The one material."""
        first = self._stones[0]
        return {self._material: first.source or first.name}

    def __len__(self) -> int:
        return len(self._stones)

    def _stone(self, i: int) -> Stone:
        stone = self._stones[i]
        assumed = tuple(words for words in stone.assumed if not words.endswith(NO_MATERIAL))
        return replace(stone, material=self._material, assumed=assumed)

"""Results of functions of arrays, kept by what is in the arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, wraps
from typing import TypeVar

import numpy as np

__all__ = ["LARGEST", "cached_by_content"]

R = TypeVar("R")

#: Results that are kept of a function, and how large its arguments may be for it [bytes].
_KEPT, LARGEST = 16, 1 << 22


@dataclass(frozen=True, slots=True)
class _Content:
    """What is in an array."""

    dtype: str
    shape: tuple[int, ...]
    data: bytes

    def array(self) -> np.ndarray:
        """Return the array, which cannot be written to."""
        return np.frombuffer(self.data, self.dtype).reshape(self.shape)


def cached_by_content(function: Callable[..., R]) -> Callable[..., R]:
    """Keep the last results of a function of arrays, for arguments with the same numbers in them.

    Scenes of one stone are made again and again, and each time it is checked that it is a solid, which takes
    a good part of a small picture's time. What comes from large arrays, of which there are few, is not kept.

    Parameters
    ----------
    function : callable
        Takes arrays only, writes to none of them, and returns what nobody changes.
    """

    @lru_cache(maxsize=_KEPT)
    def kept(*contents: _Content) -> R:
        return function(*(content.array() for content in contents))

    @wraps(function)
    def call(*given: np.ndarray) -> R:
        arrays = [np.asarray(one) for one in given]
        if sum(array.nbytes for array in arrays) > LARGEST:
            return function(*arrays)
        return kept(*(_Content(array.dtype.str, array.shape, array.tobytes()) for array in arrays))

    return call

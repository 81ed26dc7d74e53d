"""Parts of an atlas's chunks, which are handed to workers, and what comes back of them."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from gemrender.sweep.atlas.plan import AtlasPlan

__all__ = ["Measured", "Part", "Parts", "chunk_arrays", "chunk_size"]

#: A chunk is shared out in parts of so much work [s], and of so many stones at the most: there is little to
#: tell of each, and what has been done is told often.
_PART_S, _MOST_OF_PART = 0.25, 64


class Part(NamedTuple):
    """Some stones of a chunk: from a first to before a last one, in the order of `AtlasPlan.settings`."""

    chunk: int
    first: int
    last: int


class Measured(NamedTuple):
    """What has been measured of a part.

    part : Part
        Which one.
    values : (n, views, variables) float32
        Of each stone, NaN where there are none.
    status : (n,) int8
        Of each stone, as the store has it.
    """

    part: Part
    values: np.ndarray
    status: np.ndarray


def chunk_size(plan: AtlasPlan, chunk: int) -> int:
    """Return the number of stones of a chunk."""
    return math.prod(part.stop - part.start for part in plan.place(chunk))


class Parts(Iterator[Part]):
    """The parts of chunks, one after the other, as large as the time says that their stones take.

    Attributes
    ----------
    rate : float
        Stones a second, of all workers together.
    """

    def __init__(self, plan: AtlasPlan, chunks: Iterable[int], workers: int) -> None:
        self._plan, self._chunks, self._workers = plan, iter(chunks), workers
        self._chunk, self._first, self._end = 0, 0, 0
        self._since, self._stones, self.rate = time.monotonic(), 0, 0.0

    def __next__(self) -> Part:
        if self._first == self._end:
            self._chunk = next(self._chunks)
            self._first, self._end = 0, chunk_size(self._plan, self._chunk)
        size = int(np.clip(_PART_S * self.rate / self._workers, 1, _MOST_OF_PART))
        first, self._first = self._first, min(self._first + size, self._end)
        return Part(self._chunk, first, self._first)

    def came(self, measured: Measured) -> int:
        """Take it into account that a part is done; return its number of stones."""
        number = len(measured.status)
        self._stones += number
        self.rate = self._stones / max(time.monotonic() - self._since, 1e-9)
        return number


def chunk_arrays(
    plan: AtlasPlan, chunk: int, values: np.ndarray, status: np.ndarray
) -> dict[str, np.ndarray]:
    """Return what was measured of all of a chunk's stones as the store has it.

    Parameters
    ----------
    plan, chunk
        The plan, and which chunk.
    values, status
        As of `Measured`.

    Returns
    -------
    dict of str to array
        `status`, each of the plan's variables, and parameters of a Sobol design.
    """
    place = plan.place(chunk)
    shape = tuple(part.stop - part.start for part in place)
    views = (len(plan.tilts),) if plan.tilts else ()
    out = {variable.name: values[:, :, k].reshape(shape + views) for k, variable in enumerate(plan.variables)}
    if plan.ranges:
        points = plan.points(place[0])
        out |= {key: points[:, k] for k, key in enumerate(plan.ranges)}
    return out | {"status": status.reshape(shape)}

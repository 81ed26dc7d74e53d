"""What an exact score may take: time and memory, past which polygons are left to rays, and rays end."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from gemrender.errors import InputError

__all__ = ["MEMORY_RANGE", "PAUSED", "TIME_RANGE", "Budget", "MemoryBudget", "check_limits", "no_limits"]

#: Allowed ranges of the limits [s], [GiB].
TIME_RANGE = (0.1, 86_400.0)
MEMORY_RANGE = (0.125, 1024.0)

#: Shares of the time at which smaller polygons, and at which all of them, are left to rays.
_COARSER, _END = 0.4, 0.6
#: The smallest polygons that are followed on: from the one moment to the other ten times as large thrice
#: [share of what is traced].
_SMALL, _LARGE = 1e-7, 1e-4
#: The smallest ones once half of the memory is taken.
_HALF_FULL = 1e-6
#: Lists of polygons grow by doubling, and are copied once: so many times what is in them is taken in all.
_COPIES = 6
#: How often the time is looked at [s].
_TICK = 0.01

_GIB = 2.0**30


def no_limits() -> np.ndarray:
    """Return what lets `trace_polygons` follow everything to its end."""
    return np.array(
        [0.0, np.inf, 0.0]
    )  # a fresh one: to numba an array that cannot be written is another type


def check_limits(time_limit: float, memory_limit: float) -> tuple[float, float]:
    """Return the limits of an exact score [s], [GiB], if they are such.

    Raises
    ------
    InputError
        One is no number, or out of range.
    """
    for key, value, (low, high), unit in (
        ("time", time_limit, TIME_RANGE, "s"),
        ("memory", memory_limit, MEMORY_RANGE, "GiB"),
    ):
        is_number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
        if not is_number or not low <= value <= high:
            raise InputError(f"must be from {low:g} to {high:g} [{unit}]", key=key, value=value)
    return float(time_limit), float(memory_limit)


class _Paused:
    """Time in which kernels were compiled, which happens once: it is no score's."""

    def __init__(self) -> None:
        self._total, self._depth = (0.0, 0.0), 0
        self._since = (0.0, 0.0)

    @contextmanager
    def compiling(self) -> Iterator[None]:
        """Let the time that passes within count for no budget; may be nested, in one thread."""
        if not self._depth:
            self._since = _now()
        self._depth += 1
        try:
            yield
        finally:
            if self._depth == 1:  # first the sum: who asks in between is told too much, not too little
                self._total = self.total
            self._depth -= 1

    @property
    def total(self) -> tuple[float, float]:
        """So much it was up to now, by the clock and of the processors [s]."""
        if not self._depth:
            return self._total
        sums = (a + now - since for a, now, since in zip(self._total, _now(), self._since, strict=True))
        wall, processors = sums
        return wall, processors


def _now() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()


PAUSED = _Paused()


class Budget:
    """The time and memory that one exact score may take, running from when it is made.

    Time that other programs take does not count: of the time that has passed and the processors' time that
    this process has used the smaller one does. So a score is the same on a busy machine. Nor does the time
    that kernels are compiled in.

    Parameters
    ----------
    time_limit : float
        Time [s].
    memory_limit : float
        Memory of the process, but for what Python and its libraries take [GiB].

    Attributes
    ----------
    time_is_up, memory_is_full : str
        Words for that.

    Raises
    ------
    InputError
        A limit out of range.
    """

    def __init__(self, time_limit: float, memory_limit: float) -> None:
        self.time_limit, self.memory_limit = check_limits(time_limit, memory_limit)
        self._start = self._now()
        self.time_is_up = f"the time limit of {self.time_limit:g} s was reached"
        self.memory_is_full = f"the memory limit of {self.memory_limit:g} GiB was reached"

    @staticmethod
    def _now() -> tuple[float, float]:
        wall, processors = (now - paused for now, paused in zip(_now(), PAUSED.total, strict=True))
        return wall, processors

    @property
    def seconds(self) -> float:
        """Time that has been taken [s]."""
        return min(now - start for now, start in zip(self._now(), self._start, strict=True))

    @property
    def left(self) -> float:
        """Time that is left [s]; less than 0 if none is."""
        return self.time_limit - self.seconds

    def anew(self) -> Budget:
        """Return the same limits, running from now."""
        return Budget(self.time_limit, self.memory_limit)

    def _limits(self) -> np.ndarray:
        return np.array([0.0, self.memory_limit * _GIB / _COPIES, _HALF_FULL])

    @contextmanager
    def polygon_limits(self) -> Iterator[np.ndarray]:
        """Give `trace_polygons` its limits, and raise them while it runs and time passes."""
        limits = self._limits()
        ended = threading.Event()

        def watch() -> None:
            while not ended.wait(_TICK):
                share = (self.seconds / self.time_limit - _COARSER) / (_END - _COARSER)
                if share >= 1.0:
                    limits[0] = np.inf
                elif share > 0.0:
                    limits[0] = _SMALL * (_LARGE / _SMALL) ** share

        watcher = threading.Thread(target=watch, name="gemrender budget", daemon=True)
        watcher.start()
        try:
            yield limits
        finally:
            ended.set()
            watcher.join()


class MemoryBudget(Budget):
    """A budget of memory alone: what it leaves to rays is the same on every machine, however fast it is.

    Parameters
    ----------
    memory_limit : float
        As of `Budget` [GiB].
    """

    def __init__(self, memory_limit: float) -> None:
        super().__init__(TIME_RANGE[1], memory_limit)

    @property
    def seconds(self) -> float:
        """Time that counts [s]: none."""
        return 0.0

    def anew(self) -> MemoryBudget:
        """Return the same limit."""
        return MemoryBudget(self.memory_limit)

    @contextmanager
    def polygon_limits(self) -> Iterator[np.ndarray]:
        """Give `trace_polygons` its limits, which stay as they are."""
        yield self._limits()

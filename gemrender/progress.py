"""How long work goes on: estimated from the share that is done, and said in a line every half minute."""

from __future__ import annotations

import bisect
import threading
import time
from collections.abc import Callable
from types import TracebackType

__all__ = ["EVERY_S", "ProgressLines", "TimeLeft", "duration_words"]

#: How often a line is said [s]; of work that is done sooner none is.
EVERY_S = 30.0

#: The first line comes no sooner [s]: before, much of the time is what starts and compiles.
_FIRST_S = 5.0
#: A pace that so many times differs from that of the whole is that of other work, and no scatter.
_OTHER_PACE = 2.0
#: Most shares that are kept, to tell the pace of the latest half of the time.
_KEPT = 512

_MINUTE, _HOUR, _DAY = 60, 3600, 86400


class TimeLeft:
    """Estimates how long work goes on, from the shares of it that are done.

    A share may be of samples, of time, or of items. Towards a noise, share is (noise wanted / noise now)^2:
    noise falls as the root of the samples, so that grows evenly with time. The first share that is told is
    where the work begins: what was there before took no time of it. The first step often takes longer than
    all others, as there is much to compile; once as much again is done, it is left out. Work of several kinds
    has several paces: where that of the latest half of the time is twice that of the whole, or half of it,
    it is what counts. While a step takes longer than those before it, no pace that it has disproved is held.

    Parameters
    ----------
    clock : callable
        Returns the time [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._begin: tuple[float, float] | None = None  # time [s] and share
        self._first_step: tuple[float, float] | None = None
        self._now: tuple[float, float] | None = None
        #: From the first step on; every other one where there are many.
        self._told: list[tuple[float, float]] = []
        self._step = 0.0  # share of the last step

    @property
    def share(self) -> float:
        """Share that is done, 0 to 1, as last told."""
        return self._now[1] if self._now else 0.0

    def update(self, share: float) -> None:
        """Take note of the share that is done, 0 to 1."""
        before, self._now = self.share, (self._clock(), min(max(share, 0.0), 1.0))
        if self._now[1] > before:
            self._step = self._now[1] - before
        if self._begin is None:
            self._begin, self._step = self._now, 0.0
        elif self._first_step is None and self._now[1] > self._begin[1]:
            self._first_step = self._now
        if self._first_step is not None:
            self._told.append(self._now)
            if len(self._told) > _KEPT:
                del self._told[1::2]

    def seconds(self) -> float | None:
        """Return about how long the work goes on [s]; None where nothing tells, and once it is overdue."""
        left = self._foretold()
        return None if left is None or self.is_overdue else max(left, 0.0)

    @property
    def is_overdue(self) -> bool:
        """Whether the last step takes longer than all that was known foretold."""
        left = self._foretold()
        return left is not None and left <= 0.0 and self.share < 1.0

    def _foretold(self) -> float | None:
        if self._begin is None or self._first_step is None or self._now is None:
            return None
        since = self._begin
        if self._now[1] - self._first_step[1] >= self._first_step[1] - self._begin[1]:
            since = self._first_step
            middle = self._told[bisect.bisect(self._told, ((since[0] + self._now[0]) / 2.0, 2.0)) - 1]
            whole, latest = _pace(since, self._now), _pace(middle, self._now)
            if whole > 0.0 and not whole / _OTHER_PACE <= latest <= whole * _OTHER_PACE:
                since = middle
        done, took = self._now[1] - since[1], self._now[0] - since[0]
        if done <= 0:  # a noise that grew
            return None
        waited = self._clock() - self._now[0]
        by_pace = (1.0 - self._now[1]) * took / done - waited
        # At the least what is left behind this step, as if it ended now.
        by_step = (1.0 - self._now[1] - self._step) * (took + waited) / (done + self._step)
        return max(by_pace, by_step)


def _pace(since: tuple[float, float], until: tuple[float, float]) -> float:
    """Return the share of a second between two times; 0 where there is none."""
    took = until[0] - since[0]
    return (until[1] - since[1]) / took if took > 0.0 else 0.0


class ProgressLines:
    """Says how long work goes on: after its first step, then every half minute.

    Work that is done within half a minute passes without a word. As a context it also speaks up while a
    step takes longer than that.

    ::

        with ProgressLines(say) as lines:
            for k, item in enumerate(items):
                lines.update(k / len(items), f"stone {k + 1} of {len(items)}")
                ...

    Parameters
    ----------
    say : callable
        Takes a line, without its end.
    every : float
        Time from line to line [s].
    clock : callable
        Returns the time [s].
    """

    def __init__(
        self,
        say: Callable[[str], object],
        *,
        every: float = EVERY_S,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._say, self._every, self._clock = say, every, clock
        self._left = TimeLeft(clock)
        self._began = self._spoke = clock()
        self._estimated = False
        self._label = ""
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    def update(self, share: float, label: str = "") -> None:
        """Take note of the share that is done, 0 to 1, and of what is being done; say a line if due."""
        with self._lock:
            self._left.update(share)
            self._label = label
            self._speak()

    def tick(self) -> None:
        """Say a line if due, without news."""
        with self._lock:
            self._speak()

    def __enter__(self) -> ProgressLines:
        # Waits more often than it speaks: a line of `update` in between puts the next one off
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()
        if self._thread is not None:
            self._thread.join()

    def _watch(self) -> None:
        while not self._ended.wait(self._every / 30):
            self.tick()

    def _speak(self) -> None:
        left, now = self._left.seconds(), self._clock()
        first = (
            not self._estimated
            and left is not None
            and left >= self._every
            and now - self._began >= min(_FIRST_S, self._every)
        )
        if not first and now - self._spoke < self._every:
            return
        if left is None and self._estimated and not self._left.is_overdue:  # it will be known again soon
            return
        self._spoke, was_estimated = now, self._estimated
        self._estimated = was_estimated or left is not None
        about = f"{self._label}: " if self._label else ""
        if left is None:
            so_far = f"{about}{duration_words(now - self._began)} so far"
            if was_estimated:
                self._say(f"{so_far}, longer than it seemed ({100 * self._left.share:.0f} % done)")
            else:
                self._say(f"{so_far}, how long it takes is not known yet")
        else:
            self._say(f"{about}about {duration_words(left)} left ({100 * self._left.share:.0f} % done)")


def duration_words(seconds: float) -> str:
    """Return a time as people say it, as `2 min 10 s`: to 5 s, 10 s from a minute on, a minute from ten on.

    Parameters
    ----------
    seconds : float
        Time [s], 0 and above.
    """
    if seconds < 2.5:
        return "a few seconds"
    if round(seconds / 5) * 5 < _MINUTE:
        return f"{max(round(seconds / 5), 1) * 5} s"
    step = 10 if seconds < 10 * _MINUTE else _MINUTE if seconds < 10 * _HOUR else _HOUR
    whole = round(seconds / step) * step
    units = ((_DAY, "d"), (_HOUR, "h"), (_MINUTE, "min"), (1, "s"))
    words = []
    for size, unit in units:
        if whole >= size:
            words.append(f"{whole // size} {unit}")
            whole %= size
    return " ".join(words[:2])

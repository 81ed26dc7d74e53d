"""Signals that end a command, answered as Ctrl-C is: what is done is kept, and nothing else is left."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator
from types import FrameType

__all__ = ["interrupted_by_signals", "interruptions_held"]

#: What `kill`, `timeout` and batch systems send, and what a terminal sends when it is closed.
_NAMES = ("SIGTERM", "SIGHUP")


@contextlib.contextmanager
def interrupted_by_signals() -> Iterator[Callable[[], int]]:
    """Have SIGTERM and SIGHUP raise KeyboardInterrupt within, so that everything ends as at Ctrl-C.

    Signals that are ignored, as SIGHUP under `nohup`, stay so. After the first, more of them are ignored:
    systems send them in pairs, and the second would interrupt the tidying up. It does nothing outside the
    main thread, where Python has no signals.

    Yields
    ------
    callable
        Returns the exit status of an interruption, by the shells' convention: 143 after SIGTERM, 129 after
        SIGHUP, else 130, that of Ctrl-C.
    """
    received: list[int] = []

    def interrupt(number: int, _: FrameType | None) -> None:
        for other in before:
            signal.signal(other, signal.SIG_IGN)
        received.append(number)
        raise KeyboardInterrupt

    before = {}
    if threading.current_thread() is threading.main_thread():
        for name in _NAMES:
            number = getattr(signal, name, None)  # Windows has no SIGHUP
            if number is not None and signal.getsignal(number) is signal.SIG_DFL:
                before[number] = signal.SIG_DFL
                signal.signal(number, interrupt)
    try:
        yield lambda: 128 + (received[0] if received else signal.SIGINT)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextlib.contextmanager
def interruptions_held() -> Iterator[None]:
    """Hold back Ctrl-C, and signals that are answered like it, until the end of what is within.

    For short work that cannot be broken off: libraries that are imported make an abort, or an error of
    another kind, of an interruption. Outside the main thread it does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[int] = []
    before = {}
    for name in ("SIGINT", *_NAMES):
        number = getattr(signal, name, None)
        handler = None if number is None else signal.getsignal(number)
        if number is not None and callable(handler):  # neither ignored, nor the system's own
            before[number] = handler
            signal.signal(number, lambda number, _: held.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if held:
            signal.raise_signal(held[0])

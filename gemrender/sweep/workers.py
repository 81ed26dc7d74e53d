"""Work shared among processes that end with the one that started them, and of which one may be lost."""

from __future__ import annotations

import contextlib
import logging
import multiprocessing
import os
import signal
import sys
import threading
import traceback
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any, TypeVar

from gemrender.errors import GemrenderError

__all__ = ["MOST_TRIES", "LostProcessError", "in_processes", "terminal_signals_blocked"]

Batch = TypeVar("Batch")
Result = TypeVar("Result")

#: So often a batch is tried whose process is lost (killed, as where memory runs out, or crashed).
MOST_TRIES = 3
#: Signals that a terminal sends to all processes before it: the first one answers them for all.
_TERMINAL_SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGHUP") if hasattr(signal, name))
#: So often a wait for processes looks for signals [s]: one that arrives right before its system call would
#: else be answered only when a process has something to say.
_TICK = 1.0

_log = logging.getLogger("gemrender")


class LostProcessError(GemrenderError):
    """Processes were lost at the same work again and again."""


def in_processes(
    function: Callable[[Batch], Result], batches: Iterable[Batch], processes: int
) -> Generator[Result, None, None]:
    """Call a function with each batch, in processes of their own; yield the results as they come.

    The processes are started by `spawn`, since Mitsuba does not survive a fork: the function, the batches
    and the results are pickled, and a script that calls this does so under ``if __name__ == "__main__":``.
    They end when the iterator is closed (`contextlib.closing`) or has come to its end, and with this process,
    however that ends.

    A process that is lost, as where memory runs out, is told by the logger `gemrender`, and its batch is done
    again; from then on there is one process less, since that is what helps where memory ran out.

    Parameters
    ----------
    function : callable
        What is called; it is sent once to each process.
    batches : iterable
        Its arguments, each taken when a process is free for it.
    processes : int
        Number of processes, at least 1.

    Yields
    ------
    object
        What the function returns, in any order.

    Raises
    ------
    LostProcessError
        A batch has lost `MOST_TRIES` processes.
    GemrenderError
        A process could not start.
    Exception
        Whatever the function raises.
    """
    fresh, again = iter(batches), deque[tuple[Batch, int]]()  # what has lost a process is done again at last
    workers: dict[Connection, _Worker] = {}

    def next_batch() -> tuple[Batch, int] | None:
        """Return a batch that waits, and how often it has been tried with that; None if there is none."""
        for batch in fresh:
            return batch, 1
        return again.popleft() if again else None

    try:
        while len(workers) < processes and (item := next_batch()) is not None:
            worker: _Worker = _start(function, *item)
            workers[worker.connection] = worker
        while workers:
            for connection in wait(list(workers), _TICK):
                worker = workers[connection]  # type: ignore[index]
                try:
                    good, value = worker.connection.recv()
                except (EOFError, OSError):
                    del workers[worker.connection]
                    again.append((worker.batch, worker.tried + 1))
                    _lost(worker, len(workers))
                    if not workers and (item := next_batch()) is not None:
                        worker = _start(function, *item)
                        workers[worker.connection] = worker
                    continue
                if not good:
                    raise value
                worker.has_served = True
                if (item := next_batch()) is not None:
                    worker.hand(*item)
                else:
                    del workers[worker.connection]
                    worker.end()
                yield value
    finally:
        for worker in workers.values():
            worker.end()


# ---- This side -----------------------------------------------------------------------------------------


@dataclass(slots=True)
class _Worker:
    """A process, and the batch that it is at."""

    process: SpawnProcess
    connection: Connection
    batch: Any
    tried: int
    has_served: bool = False

    def hand(self, batch: Any, tried: int) -> None:
        self.batch, self.tried = batch, tried
        with contextlib.suppress(OSError):  # lost meanwhile: seen when it is listened to
            self.connection.send(batch)

    def end(self) -> None:
        """End the process, whatever it is at."""
        self.process.kill()
        self.process.join()
        self.connection.close()


def _start(function: Callable[[Any], Any], batch: Any, tried: int) -> _Worker:
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(function, there, os.getpid()), daemon=True)
    with terminal_signals_blocked():  # and, as that is inherited, in the new process for good
        process.start()
    there.close()
    worker = _Worker(process, here, batch, tried)
    worker.hand(batch, tried)
    return worker


def _lost(worker: _Worker, left: int) -> None:
    """Tell of a process that has ended by itself; give up where that cannot help."""
    worker.process.join()
    status = worker.process.exitcode or 0
    worker.connection.close()
    if status >= 0 and not worker.has_served and sys.platform != "win32":
        raise GemrenderError(
            f"a process for the work could not start (exit status {status}); in a script, do such work under "
            'if __name__ == "__main__":'
        )
    how = f"was ended by signal {-status}" if status < 0 else f"ended with exit status {status}"
    cause = "; perhaps memory ran out" if -status == 9 else ""
    if worker.tried == MOST_TRIES:
        raise LostProcessError(f"a process {how}{cause}; this was attempt {MOST_TRIES} at the same work")
    _log.warning("a process %s%s; its work is done again, by %d at a time", how, cause, max(left, 1))


@contextlib.contextmanager
def terminal_signals_blocked() -> Iterator[None]:
    """Block what a terminal sends, in processes and threads that are started within for good."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # its start would unblock the signals again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _TERMINAL_SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


# ---- The other side ------------------------------------------------------------------------------------


def _serve(function: Callable[[Any], Any], connection: Connection, parent: int) -> None:
    """Do batches until there are no more, or nobody to do them for."""
    _end_with(parent)
    while True:
        try:
            batch = connection.recv()
        except (EOFError, OSError):
            return
        try:
            answer = (True, function(batch))
        except Exception as error:
            # The traceback stays here; what is shown of an unexpected error has it as a note.
            if not isinstance(error, GemrenderError):
                error.add_note("".join(traceback.format_exception(error)))
            answer = (False, error)
        try:
            connection.send(answer)
        except OSError:
            return
        except Exception:  # what cannot be pickled
            connection.send((False, GemrenderError(f"an answer cannot be sent: {answer[1]!r}")))


def _end_with(parent: int) -> None:
    """See to it that this process ends when its parent has, however that came about."""
    if not hasattr(signal, "pthread_sigmask"):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":
        # At once, even within compiled code that keeps Python's threads from running.
        import ctypes

        with contextlib.suppress(OSError, AttributeError):
            set_death_signal = 1  # PR_SET_PDEATHSIG of <linux/prctl.h>
            ctypes.CDLL(None).prctl(set_death_signal, signal.SIGKILL, 0, 0, 0)
        if os.getppid() != parent:  # it was gone before
            os._exit(1)

    def watch() -> None:
        if (process := multiprocessing.parent_process()) is not None:
            process.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()

"""Who measures the chunks of an atlas: threads of this process, processes of this machine, or a cluster."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from functools import partial

import numpy as np

from gemrender.errors import InputError
from gemrender.processors import usable_processors
from gemrender.sweep.atlas.parts import Measured, Part, Parts, chunk_arrays, chunk_size
from gemrender.sweep.atlas.plan import AtlasPlan
from gemrender.sweep.workers import in_processes

__all__ = ["TRIAL_S", "WORTH_S", "check_workers", "chunks_measured", "workers_of"]

#: So long threads of this process are at work before processes are started, and these only for so much
#: work of theirs: to start them takes some seconds [s].
TRIAL_S, WORTH_S = 2.0, 6.0


def check_workers(threads: int | None, processes: int | None, dask: str | None) -> None:
    """See that at most one kind of workers is asked for, and at least one of them.

    Raises
    ------
    InputError
        It is not so.
    """
    given = {"--threads": threads, "--processes": processes, "--dask": dask}
    given = {key: value for key, value in given.items() if value is not None}
    for key, value in given.items():
        if isinstance(value, int) and value < 1:
            raise InputError("must be at least 1", key=key, value=value)
    if len(given) > 1:
        first, other = list(given)[:2]
        raise InputError(f"cannot be given together with {other}", key=first, value=given[first])


def workers_of(threads: int | None, processes: int | None) -> int:
    """Return the number of threads or processes."""
    return threads or processes or usable_processors()


def chunks_measured(
    plan: AtlasPlan, chunks: Sequence[int], threads: int | None, processes: int | None, dask: str | None
) -> Generator[tuple[int, tuple[int, dict[str, np.ndarray]] | None], None, None]:
    """Measure chunks, in any order, few of them ahead.

    Parameters
    ----------
    plan : AtlasPlan
        The plan.
    chunks : sequence of int
        Which ones.
    threads, processes, dask
        As of `make_atlas`.

    Yields
    ------
    (int, (int, dict) or None)
        How many stones more are done; and where a chunk is done with them, which one, and what is found of
        it (`chunk_arrays`).
    """
    begun: dict[int, list[Measured]] = {}
    if dask is not None:
        from gemrender.sweep.atlas.cluster import in_dask

        results = in_dask(plan, chunks, dask)
    else:
        results = _on_this_machine(plan, chunks, threads, processes)
    with contextlib.closing(results):
        for measured in results:
            chunk = measured.part.chunk
            parts = begun.setdefault(chunk, [])
            parts.append(measured)
            done = None
            if sum(len(part.status) for part in parts) == chunk_size(plan, chunk):
                _, values, status = zip(*sorted(begun.pop(chunk), key=lambda each: each.part), strict=True)
                done = chunk, chunk_arrays(plan, chunk, np.concatenate(values), np.concatenate(status))
            yield len(measured.status), done


def _on_this_machine(
    plan: AtlasPlan, chunks: Sequence[int], threads: int | None, processes: int | None
) -> Generator[Measured, None, None]:
    """Measure chunks by threads, or by processes where that is asked for or sooner done.

    Of what is not compiled a process does one thing at a time, however many threads it has: processes are
    twice as fast and more, but for the time that it takes to start them.
    """
    from gemrender.beam import prepare
    from gemrender.sweep.atlas.chunk import measure_part

    prepare(rays=True)  # before any other process would compile the same
    count = workers_of(threads, processes)
    parts = Parts(plan, chunks, count)
    if processes is None or count == 1:
        left, started = sum(chunk_size(plan, chunk) for chunk in chunks), time.monotonic()
        may_change = threads is None and count > 1
        is_worth_it = False

        def at_first() -> Iterator[Part]:
            while not is_worth_it and (part := next(parts, None)) is not None:
                yield part

        with contextlib.closing(_in_threads(plan, at_first(), count)) as results:
            for measured in results:
                yield measured
                left -= parts.came(measured)
                if may_change and time.monotonic() - started > TRIAL_S:
                    is_worth_it = is_worth_it or left > WORTH_S * parts.rate
    with contextlib.closing(in_processes(partial(measure_part, plan), parts, count)) as found:
        for done in found:
            assert done is not None
            parts.came(done)
            yield done


def _in_threads(plan: AtlasPlan, parts: Iterable[Part], threads: int) -> Generator[Measured, None, None]:
    """Measure parts in threads, few of them ahead; closed, it ends after the stones that are under way."""
    from gemrender.sweep.atlas.chunk import measure_part

    stopped = threading.Event()
    running: set[Future[Measured | None]] = set()
    waiting = iter(parts)
    pool = ThreadPoolExecutor(threads)
    try:
        while True:
            while len(running) < 2 * threads and (part := next(waiting, None)) is not None:
                running.add(pool.submit(measure_part, plan, part, lambda: not stopped.is_set()))
            if not running:
                return
            finished, running = wait(running, return_when=FIRST_COMPLETED)
            for future in finished:
                if (measured := future.result()) is not None:
                    yield measured
    finally:
        stopped.set()
        pool.shutdown(cancel_futures=True)

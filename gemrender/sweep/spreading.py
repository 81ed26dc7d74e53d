"""Work on stones shared out to all processors: to threads or to processes, whichever is sooner done."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import partial
from typing import Any, TypeVar

from gemrender.engines import DEFAULT_ENGINE, DEFAULT_VARIANT, engine_for, require_engine
from gemrender.processors import usable_processors
from gemrender.stone import Stone
from gemrender.sweep.workers import in_processes

__all__ = ["FEW", "STUDY_RESOLUTION", "limit_threads", "spread"]

Item = TypeVar("Item")
Result = TypeVar("Result")

#: Up to so many exact scores are shared out to threads: processes take longer to start than that, though
#: Python's own part of the work is then done by one thread at a time.
FEW = 200
#: Pixels a side of the maps of studies, where nothing else is asked for.
STUDY_RESOLUTION = 256


def spread(
    work: Callable[[int | None, Item], Result],
    items: Sequence[Item],
    processes: int | None,
    *,
    by_threads: bool,
) -> Generator[Result, None, None]:
    """Do work on items, in any order: by threads, which the exact engine's kernels let run, or by processes.

    Parameters
    ----------
    work : callable
        Given the number of threads that it may use (None: it is not said) and an item, returns what is
        yielded. With processes it and the items are pickled.
    items : sequence
        The items, those that take longest first.
    processes : int or None
        Number of processes or threads; None is one a processor.
    by_threads : bool
        Whether to use threads.
    """
    count = min(processes or usable_processors(), len(items))
    if count <= 1:
        for item in items:
            yield work(None, item)
    elif by_threads:
        pool = ThreadPoolExecutor(count)
        try:
            for done in as_completed([pool.submit(work, None, item) for item in items]):
                yield done.result()
        finally:
            pool.shutdown(cancel_futures=True)
    else:
        threads = max(1, usable_processors() // count)  # each with its share of the processors
        with contextlib.closing(in_processes(partial(work, threads), items, count)) as results:
            yield from results


def limit_threads(threads: int | None, stone: Stone, options: dict[str, Any]) -> None:
    """Let Mitsuba use so many threads in this process, where it is what traces a stone."""
    if threads is not None and engine_for(options.get("engine", DEFAULT_ENGINE), stone) == "mitsuba":
        require_engine("mitsuba", options.get("variant", DEFAULT_VARIANT))
        import drjit as dr

        dr.set_thread_count(threads)

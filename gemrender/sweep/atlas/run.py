"""Atlases made: the chunks that a store does not have yet, measured and written."""

from __future__ import annotations

import contextlib
import math
import os
import threading
import time
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.sweep.atlas.plan import AtlasPlan
from gemrender.sweep.atlas.store import DONE, FAILED, NO_STONE, AtlasStore

__all__ = ["AtlasMade", "make_atlas"]

#: How often it is told how far chunks are [s].
_TICK_S = 1.0
#: So many stones without values are told by name.
_TOLD = 3

_Found = dict[str, np.ndarray]


@dataclass(frozen=True, slots=True, kw_only=True)
class AtlasMade:
    """What has become of an atlas.

    Attributes
    ----------
    stones, done, no_stone, failed : int
        Stones of the plan; those with values, those that cannot be made, and those whose measurement failed.
    measured : int
        Stones that were measured in this run.
    seconds : float
        Time that it took [s].
    refused : tuple of (str, str)
        The first few stones without values, as settings, and why.
    """

    stones: int
    done: int
    no_stone: int
    failed: int
    measured: int
    seconds: float
    refused: tuple[tuple[str, str], ...]


def make_atlas(
    plan: AtlasPlan,
    where: str,
    *,
    threads: int | None = None,
    dask: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> AtlasMade:
    """Measure all stones of a plan that its store does not have yet.

    Chunks are measured by the threads of this process, or by the workers of a Dask cluster, in any order; it
    is this process that writes them. Whoever measures them, and how often it was stopped, the bytes of the
    store are the same.

    Parameters
    ----------
    plan : AtlasPlan
        The plan (`read_plan`).
    where : str
        The store: a folder, or an address that fsspec knows.
    threads : int, optional
        Threads; by default one a processor.
    dask : str, optional
        Address of a Dask scheduler, or `local` or `local:N` for N processes on this machine.
    progress : callable, optional
        Called with the share done, 0 to 1, first with what was there.

    Raises
    ------
    InputError
        The store is of another plan or cannot be written; no scheduler answers.
    BackendError
        A package is missing, or the scheduler was lost; what is done is kept.
    """
    if threads is not None and threads < 1:
        raise InputError("must be at least 1", key="threads", value=threads)
    started = time.monotonic()
    store = AtlasStore(plan, where)
    waiting = store.to_do()
    there = plan.stones - sum(_size(plan, chunk) for chunk in waiting)
    measured = 0

    told = 0

    def tell(under_way: int = 0) -> None:
        nonlocal told
        told = max(told, there + measured + under_way)  # a chunk that is done is no more under way
        if progress is not None:
            progress(told / plan.stones)

    tell()
    if waiting:
        with contextlib.closing(_results(plan, waiting, threads, dask, tell)) as results:
            for chunk, found in results:
                store.write(chunk, found)
                measured += found["status"].size
                tell()
    store.tidy()
    return _made(store, measured, time.monotonic() - started)


def _size(plan: AtlasPlan, chunk: int) -> int:
    return math.prod(part.stop - part.start for part in plan.place(chunk))


def _results(
    plan: AtlasPlan,
    chunks: Sequence[int],
    threads: int | None,
    dask: str | None,
    tell: Callable[[int], None],
) -> Generator[tuple[int, _Found], None, None]:
    if dask is None:
        return _in_threads(plan, chunks, threads or os.cpu_count() or 1, tell)
    from gemrender.sweep.atlas.cluster import in_dask

    return in_dask(plan, chunks, dask)


def _in_threads(
    plan: AtlasPlan, chunks: Sequence[int], threads: int, tell: Callable[[int], None]
) -> Generator[tuple[int, _Found], None, None]:
    """Measure chunks in threads, few of them ahead; closed, it ends after the stones that are under way.

    Every second it tells how many stones of chunks that are not yielded have been begun.
    """
    from gemrender.sweep.atlas.chunk import measure_chunk

    stopped = threading.Event()
    begun: dict[int, int] = {}

    def work(chunk: int) -> _Found | None:
        def goes_on() -> bool:
            begun[chunk] = begun.get(chunk, -1) + 1
            return not stopped.is_set()

        return measure_chunk(plan, chunk, goes_on)

    running: dict[Future[_Found | None], int] = {}
    waiting = iter(chunks)
    pool = ThreadPoolExecutor(threads)
    try:
        while True:
            while len(running) < 2 * threads and (chunk := next(waiting, None)) is not None:
                running[pool.submit(work, chunk)] = chunk
            if not running:
                return
            finished = wait(running, timeout=_TICK_S, return_when=FIRST_COMPLETED).done
            if not finished:
                tell(sum(list(begun.values())))
            for future in finished:
                chunk = running.pop(future)
                begun.pop(chunk, None)
                if (found := future.result()) is not None:
                    yield chunk, found
    finally:
        stopped.set()
        pool.shutdown(cancel_futures=True)


def _made(store: AtlasStore, measured: int, seconds: float) -> AtlasMade:
    plan, status = store.plan, store.status()
    refused = []
    for number in np.flatnonzero((status == NO_STONE) | (status == FAILED))[:_TOLD]:
        cell = np.unravel_index(int(number), plan.shape)
        setting = next(plan.settings(tuple(slice(int(k), int(k) + 1) for k in cell)))
        words = " ".join(f"{key}={value}" for key, value in setting.items())
        refused.append((words, _reason(plan, setting)))
    return AtlasMade(
        stones=plan.stones,
        done=int((status == DONE).sum()),
        no_stone=int((status == NO_STONE).sum()),
        failed=int((status == FAILED).sum()),
        measured=measured,
        seconds=seconds,
        refused=tuple(refused),
    )


def _reason(plan: AtlasPlan, setting: dict[str, Any]) -> str:
    """Say why a stone has no values: by trying again."""
    from gemrender.sweep.atlas.chunk import chunk_values

    try:
        stone = plan.made(setting)
        for tilt in plan.views:
            chunk_values(plan, stone, tilt)
    except InputError as error:
        return error.allowed
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return "it failed when it was measured, and does so no more"

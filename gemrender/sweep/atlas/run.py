"""Atlases made: the chunks that a store does not have yet, measured and written."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.sweep.atlas.parts import chunk_size
from gemrender.sweep.atlas.plan import AtlasPlan
from gemrender.sweep.atlas.store import DONE, FAILED, NO_STONE, AtlasStore
from gemrender.sweep.atlas.work import check_workers, chunks_measured
from gemrender.sweep.workers import LostProcessError

__all__ = ["AtlasMade", "make_atlas"]

#: So many stones without values are told by name.
_TOLD = 3


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
    processes: int | None = None,
    dask: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> AtlasMade:
    """Measure all stones of a plan that its store does not have yet.

    Chunks are measured by processes of this machine, by threads of this one, or by the workers of a Dask
    cluster, in any order; it is this process that writes them. Whoever measures them, and how often it was
    stopped, the bytes of the store are the same.

    A process that is lost, as where memory runs out, is told by the logger `gemrender`, and its work is done
    again by the others. Processes are started by `spawn`: a script that calls this does so under
    ``if __name__ == "__main__":``.

    Parameters
    ----------
    plan : AtlasPlan
        The plan (`read_plan`).
    where : str
        The store: a folder, or an address that fsspec knows.
    threads : int, optional
        So many threads of this process alone.
    processes : int, optional
        So many processes of this machine, 1 for this one alone; by default one a processor, which are started
        only where there is work for more than a few seconds.
    dask : str, optional
        Address of a Dask scheduler, or `local` or `local:N` for N processes on this machine.
    progress : callable, optional
        Called with the share done, 0 to 1, first with what was there.

    Raises
    ------
    InputError
        The store is of another plan or cannot be written; no scheduler answers; or more than one of
        `threads`, `processes` and `dask` is given.
    BackendError
        A package is missing, or the scheduler was lost; what is done is kept.
    LostProcessError
        Processes were lost again and again at the same work; what is done is kept.
    """
    check_workers(threads, processes, dask)
    started = time.monotonic()
    store = AtlasStore(plan, where)
    waiting = store.to_do()
    told = plan.stones - sum(chunk_size(plan, chunk) for chunk in waiting)
    measured = 0
    if progress is not None:
        progress(told / plan.stones)
    try:
        with contextlib.closing(chunks_measured(plan, waiting, threads, processes, dask)) as results:
            for number, done in results:
                if done is not None:
                    chunk, found = done
                    store.write(chunk, found)
                    measured += found["status"].size
                told += number
                if progress is not None:
                    progress(told / plan.stones)
    except LostProcessError as error:
        raise LostProcessError(f"{error}; what is done is kept in {where}: run it again") from error
    store.tidy()
    return _made(store, measured, time.monotonic() - started)


def _made(store: AtlasStore, measured: int, seconds: float) -> AtlasMade:
    plan, status = store.plan, store.status()
    refused = []
    for number in np.flatnonzero(status >= NO_STONE)[:_TOLD]:
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

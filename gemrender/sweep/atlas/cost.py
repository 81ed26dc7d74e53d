"""What an atlas will cost, measured on a few of its stones."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from gemrender.errors import InputError
from gemrender.sweep.atlas.plan import AtlasPlan
from gemrender.sweep.atlas.work import check_workers, workers_of

__all__ = ["AtlasCost", "atlas_cost"]


@dataclass(frozen=True, slots=True, kw_only=True)
class AtlasCost:
    """What an atlas will cost, from a few of its stones.

    Attributes
    ----------
    stones, views, chunks : int
        Stones of the plan, views of each, and chunks.
    bytes : int
        Size before compression [bytes].
    tried : int
        Stones that were measured.
    made : int
        Those of them that can be made.
    workers : str
        What will measure them, such as "2 processes".
    rate : float
        Stones a second, of all threads or processes together.
    seconds : float
        Time of the whole plan [s].
    """

    stones: int
    views: int
    chunks: int
    bytes: int
    tried: int
    made: int
    workers: str
    rate: float
    seconds: float


def atlas_cost(
    plan: AtlasPlan, *, threads: int | None = None, processes: int | None = None, stones: int = 48
) -> AtlasCost:
    """Measure a few stones of a plan, spread evenly over it, in this process, and say what all will cost.

    Parameters
    ----------
    plan : AtlasPlan
        The plan.
    threads, processes : int, optional
        As of `make_atlas`: so many threads measure them; or one does, and all processes together are taken to
        be so many times as fast.
    stones : int
        How many.

    Raises
    ------
    InputError
        As of `make_atlas`.
    """
    from gemrender.beam import prepare
    from gemrender.sweep.atlas.chunk import chunk_values

    check_workers(threads, processes, None)
    sample = plan.sample(stones)
    prepare(rays=True)

    def measured(setting: dict[str, Any]) -> bool:
        try:
            stone = plan.made(setting)
        except InputError:
            return False
        for tilt in plan.views:
            chunk_values(plan, stone, tilt)
        return True

    measured(sample[len(sample) // 2])  # what is worked out once in a process
    started = time.monotonic()
    with ThreadPoolExecutor(threads or 1) as pool:
        made = sum(pool.map(measured, sample))
    rate = len(sample) / (time.monotonic() - started)
    count = workers_of(threads, processes)
    if threads is None:
        rate *= count
    one, more = ("process", "processes") if threads is None else ("thread", "threads")
    return AtlasCost(
        stones=plan.stones,
        views=len(plan.views),
        chunks=plan.chunks,
        bytes=plan.bytes,
        tried=len(sample),
        made=made,
        workers=f"{count} {one if count == 1 else more}",
        rate=rate,
        seconds=plan.stones / rate,
    )

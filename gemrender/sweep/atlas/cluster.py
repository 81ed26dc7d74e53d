"""Chunks of an atlas measured by the workers of a Dask cluster."""

from __future__ import annotations

import contextlib
import logging
import re
from collections.abc import Generator, Iterator, Sequence
from typing import TYPE_CHECKING

import gemrender
from gemrender.errors import BackendError, InputError
from gemrender.sweep.atlas.chunk import measure_part
from gemrender.sweep.atlas.parts import Measured, Part, chunk_size
from gemrender.sweep.atlas.plan import AtlasPlan
from gemrender.sweep.workers import MOST_TRIES, terminal_signals_blocked

if TYPE_CHECKING:
    import numpy as np
    from distributed import Client, LocalCluster

__all__ = ["ANSWER_S", "WORKERS_S", "in_dask"]

#: How long a scheduler may take to answer, and how long it may have no worker [s].
ANSWER_S, WORKERS_S = 10, 120
#: Of Dask, for clusters that are started here: workers are not looked at every 10 ms, and do not give back
#: the memory of every stone, which the next one takes again [bytes].
_SETTINGS = {
    "distributed.scheduler.allowed-failures": MOST_TRIES,
    "distributed.worker.profile.enabled": False,
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": 1 << 27,
}
#: Chunks in flight for each thread of the cluster: one under way and one that waits.
_AHEAD = 2


def in_dask(plan: AtlasPlan, chunks: Sequence[int], address: str) -> Generator[Measured, None, None]:
    """Measure chunks by the workers of a cluster, few of them ahead; yield them as they come.

    A worker that is lost has its chunk done again by another one, `MOST_TRIES` times. What comes back is
    small, so that the workers need no access to the store.

    Parameters
    ----------
    plan : AtlasPlan
        The plan, which is sent to the workers.
    chunks : sequence of int
        What is to be measured.
    address : str
        Of a scheduler, such as tcp://host:8786; or `local` or `local:N` for N processes on this machine.

    Raises
    ------
    InputError
        No scheduler answers there, or it has no worker.
    BackendError
        `distributed` is missing, gemrender is missing on a worker or is another one there, a chunk has lost
        its worker again and again, or the scheduler was lost.
    """
    with _client(address) as client, _told(address):
        from distributed import as_completed

        waiting = iter(chunks)
        # The plan goes with every chunk: what is scattered is lost with the worker that has it.
        # The chunk by its future's key, so that a future is forgotten, and its result freed, once it is done.
        running: dict[str, int] = {}
        futures = as_completed(loop=client.loop)

        def hand_out() -> None:
            threads = max(sum(client.nthreads().values()), 1)
            while len(running) < _AHEAD * threads and (chunk := next(waiting, None)) is not None:
                future = client.submit(
                    _on_worker,
                    plan,
                    chunk,
                    gemrender.__version__,
                    pure=False,
                    key=f"atlas-{id(plan)}-{chunk}",
                )
                running[future.key] = chunk
                futures.add(future)

        hand_out()
        _wait_for_worker(client, address)  # adaptive clusters start one once there is work
        for future in futures:
            found = future.result()
            chunk = running.pop(future.key)
            future.release()
            yield Measured(Part(chunk, 0, chunk_size(plan, chunk)), *found)
            hand_out()
        if running:
            raise BackendError(f"the scheduler {address} was lost; what is done is kept: run it again")


def _on_worker(plan: AtlasPlan, chunk: int, version: str) -> tuple[np.ndarray, np.ndarray]:
    if gemrender.__version__ != version:
        raise BackendError(
            f"a worker has gemrender {gemrender.__version__}, not {version}; to cure it: install that there"
        )
    measured = measure_part(plan, Part(chunk, 0, chunk_size(plan, chunk)))
    assert measured is not None  # nobody stops it
    return measured.values, measured.status


@contextlib.contextmanager
def _client(address: str) -> Iterator[Client]:
    """Connect to a scheduler, or start one with its workers on this machine."""
    try:
        import dask
        from distributed import Client
    except ImportError as error:
        raise BackendError(
            f"--dask needs distributed ({error}); to cure it: pip install 'gemrender[dask]'"
        ) from error
    local = re.fullmatch(r"local(?::(\d+))?", address)
    with contextlib.ExitStack() as stack:
        stack.enter_context(dask.config.set(_SETTINGS))
        stack.enter_context(_silent("distributed.client"))  # of a scheduler that is lost: a line tells it
        if local:
            number = None if local[1] is None else int(local[1])
            if number == 0:
                raise InputError("must be local, or local:N with N from 1", key="--dask", value=address)
            address = stack.enter_context(_local(number)).scheduler_address
        elif "://" not in address:
            raise InputError(
                "must be the address of a scheduler, such as tcp://host:8786, or local or local:N",
                key="--dask",
                value=address,
            )
        try:
            client = stack.enter_context(Client(address, timeout=ANSWER_S, set_as_default=False))
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError("no scheduler answers there", key="--dask", value=address) from error
        yield client


def _wait_for_worker(client: Client, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=WORKERS_S)
    except TimeoutError as error:
        raise InputError("the scheduler has no worker", key="--dask", value=address) from error


def _local(number: int | None) -> LocalCluster:
    """Start a scheduler and workers on this machine; Ctrl-C at the terminal is left to this process."""
    from distributed import LocalCluster

    with terminal_signals_blocked():
        return LocalCluster(
            n_workers=number, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL,
        )  # fmt: skip


@contextlib.contextmanager
def _silent(name: str) -> Iterator[None]:
    """Let a log say nothing for a while."""
    log = logging.getLogger(name)
    before = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        log.setLevel(before)


@contextlib.contextmanager
def _told(address: str) -> Iterator[None]:
    """Tell in a line what goes wrong on the cluster's side."""
    from concurrent.futures import CancelledError as OfThreads

    from distributed import CancelledError, KilledWorker

    try:
        yield
    except KilledWorker as error:
        raise BackendError(
            f"workers were lost {MOST_TRIES} times at the same chunk; what is done is kept: give workers "
            "more memory, and run it again"
        ) from error
    except (CancelledError, OfThreads, OSError) as error:  # of its connections, too
        raise BackendError(f"the scheduler {address} was lost; what is done is kept: run it again") from error
    except ModuleNotFoundError as error:
        raise BackendError(
            f"a worker lacks a package ({error}); to cure it: pip install gemrender there"
        ) from error

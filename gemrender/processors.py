"""How many processors there are for work that is shared among threads or processes."""

from __future__ import annotations

import os

__all__ = ["usable_processors"]


def usable_processors() -> int:
    """Return how many processors this process may use; the machine's where the system does not say.

    A job of a cluster has some of the machine's, as has a program under ``taskset``: more threads than these
    would wait for each other.
    """
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1

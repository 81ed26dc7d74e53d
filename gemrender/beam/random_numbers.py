"""Random numbers of single rays, compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.beam.compiled import jit_inner

__all__ = ["next_random"]


@jit_inner
def next_random(states: Any, k: int) -> float:
    """Return a random number from 0 to below 1 (Marsaglia's xorshift64, with Vigna's multiplier).

    Parameters
    ----------
    states : (n,) uint64
        State of each ray's random numbers, never 0; that of the ray is changed.
    k : int
        The ray.
    """
    x = states[k]
    x ^= x >> np.uint64(12)
    x ^= x << np.uint64(25)
    x ^= x >> np.uint64(27)
    states[k] = x
    return float((x * np.uint64(0x2545F4914F6CDD1D)) >> np.uint64(11)) * 2.0**-53

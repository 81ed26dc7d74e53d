"""Numbers that spread evenly over a cube, however many there are."""

from __future__ import annotations

__all__ = ["roberts_steps"]


def roberts_steps(dimensions: int) -> tuple[int, ...]:
    """Return the steps of Roberts' sequence R_d in units of 2^-32, one a dimension.

    They are the powers 1 to d of 1/g, where g^(d + 1) = g + 1. Whole multiples of them, modulo 2^32, are as
    even after a million numbers as at first. (M. Roberts, The unreasonable effectiveness of quasirandom
    sequences, 2018, extremelearning.com.au.)
    """
    g = 2.0
    for _ in range(64):  # contracts by more than 4 each time
        g = (1.0 + g) ** (1.0 / (dimensions + 1))
    return tuple(round((g**-k % 1.0) * 2**32) for k in range(1, dimensions + 1))

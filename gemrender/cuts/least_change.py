"""Conditions kept one after the other, each as well as those before allow: least squares in turn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

__all__ = ["solve_in_turn"]

#: Smaller singular values are none: conditions that others imply, as those of symmetric corners.
_RANK = 1e-6


def solve_in_turn(blocks: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, list[float]]:
    """Solve A u = b by least squares, block by block, each within what leaves those before as they are.

    Parameters
    ----------
    blocks : sequence of ((m, n) float64, (m,) float64)
        A and b of each; rows of A about 1 long.

    Returns
    -------
    ((n,) float64, list of float)
        The shortest of the solutions, and the largest of |A u - b| in each block.

    Notes
    -----
    Golub & Van Loan, Matrix Computations, 4th ed. (2013), 6.2: the null space method, by singular values.
    """
    width = blocks[0][0].shape[1]
    found, free = np.zeros(width), np.eye(width)
    for matrix, right in blocks:
        if not free.shape[1]:
            break
        reduced = matrix @ free
        if len(reduced) < free.shape[1]:  # so that the null space is told whole
            reduced = np.vstack([reduced, np.zeros((free.shape[1] - len(reduced), free.shape[1]))])
        left, values, basis = np.linalg.svd(reduced, full_matrices=False)
        rank = int((values > _RANK).sum())
        rest = (right - matrix @ found) @ left[: len(right), :rank]
        found = found + free @ (basis[:rank].T @ (rest / values[:rank]))
        free = free @ basis[rank:].T
    return found, [float(np.abs(right - matrix @ found).max(initial=0.0)) for matrix, right in blocks]

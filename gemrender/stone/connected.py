"""What is joined to what, by pairs."""

from __future__ import annotations

import numpy as np

__all__ = ["connected"]


def connected(n: int, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the least number of what each of n nodes is connected to.

    As `scipy.sparse.csgraph.connected_components` tells apart, whose matrix takes longer to make than the few
    hundred corners of a cut stone take to go through.

    Parameters
    ----------
    n : int
        How many nodes there are.
    a, b : (e,) int
        Both ends of each edge.

    Returns
    -------
    (n,) int64
    """
    label = np.arange(n)
    while True:
        low = np.minimum(label[a], label[b])
        new = label.copy()
        np.minimum.at(new, label[a], low)
        np.minimum.at(new, label[b], low)
        while not np.array_equal(new, new[new]):
            new = new[new]
        if np.array_equal(new, label):
            return label
        label = new

"""Closed surfaces in closed surfaces: which parts of a mesh are hollows in others."""

from __future__ import annotations

import numpy as np

from gemrender.errors import InputError
from gemrender.scene.inside import Inside, crosses, overlap

__all__ = ["nested"]


def nested(parts: list[np.ndarray], as_wound: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Return which parts of a mesh are hollows, (p,) bool, and the body that each part bounds, (p,) int.

    Parameters
    ----------
    parts : list of p arrays (n, 3, 3) float64
        Closed surfaces, anticlockwise seen from outside each.
    as_wound : (p,) float64
        Whether the mesh's own faces look out of each, 1, or into it, -1.
    depth : float
        How deep parts that touch may reach into each other [scene unit].

    Raises
    ------
    InputError
        Parts overlap, and are no hollow and what is around it.
    """
    n = len(parts)
    low, high = (np.array([extreme(p, axis=(0, 1)) for p in parts]) for extreme in (np.min, np.max))
    size = (high - low).max(axis=1)
    inside_of = np.zeros((n, n), dtype=bool)
    known: dict[int, Inside] = {}
    for i in range(n):
        meets = (np.minimum(high[i], high[:i]) - np.maximum(low[i], low[:i]) > depth).all(axis=1)
        for j in np.flatnonzero(meets).tolist():
            for k in {i, j} - known.keys():
                known[k] = Inside.of(parts[k])
            if not overlap(known[i], known[j], depth):
                continue
            if crosses(known[i], known[j]):
                raise InputError("must not overlap itself")
            inside_of[(i, j) if size[i] < size[j] else (j, i)] = True
    level = inside_of.sum(axis=1)
    body = np.arange(n)
    for k in np.flatnonzero(level).tolist():
        around = np.flatnonzero(inside_of[k])
        outermost, next_one = around[np.argmin(level[around])], around[np.argmax(level[around])]
        if as_wound[k] != as_wound[outermost] * (-1) ** level[k]:
            raise InputError(
                "must not overlap itself; a hollow is wound the other way than what is around it"
            )
        if level[k] % 2:
            body[k] = next_one
    return level % 2 == 1, np.unique(body, return_inverse=True)[1].ravel()

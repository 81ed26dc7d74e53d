"""What is gathered along paths, compiled: for each node of a tree of paths from all nodes before it."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.beam.compiled import jit

__all__ = ["in_common", "unfolding", "write_in_common"]


def unfolding(nodes: np.ndarray, planes: np.ndarray) -> np.ndarray:
    """Return what mirrors a direction at each node back through all reflections, (k, 3, 3) like `planes`.

    At a node where light enters that is the identity; at any other the product of the mirrors of all nodes
    from there to the node itself, which counts too.

    Parameters
    ----------
    nodes : (k, 2) int64
        Of each node its parent, -1 where light enters, and the plane that it meets; parents come first.
    planes : (p, 4) float64 or complex128
        Unit normals and offsets; with derivatives the result has them too.
    """
    out = np.empty((len(nodes), 3, 3), planes.dtype)
    _unfold(nodes, planes, out)
    return out


@jit
def _unfold(nodes: Any, planes: Any, out: Any) -> None:
    for k in range(nodes.shape[0]):
        parent, plane = nodes[k, 0], nodes[k, 1]
        nx, ny, nz = planes[plane, 0], planes[plane, 1], planes[plane, 2]
        for j in range(3):
            zero = nx * 0.0
            a, b, c = zero + (j == 0), zero + (j == 1), zero + (j == 2)
            if parent >= 0:
                a, b, c = out[parent, j, 0], out[parent, j, 1], out[parent, j, 2]
                twice = 2.0 * (a * nx + b * ny + c * nz)
                a, b, c = a - twice * nx, b - twice * ny, c - twice * nz
            out[k, j, 0], out[k, j, 1], out[k, j, 2] = a, b, c


def in_common(nodes: np.ndarray, bits: np.ndarray) -> np.ndarray:
    """Return the bits that all facets from the eye to each node have in common, (k,) int64.

    Parameters
    ----------
    nodes : (k, 2) int64
        As for `unfolding`.
    bits : (p,) int64
        Of each facet.
    """
    out = np.empty(len(nodes), np.int64)
    write_in_common(nodes, bits, out)
    return out


@jit
def write_in_common(nodes: Any, bits: Any, out: Any) -> None:
    """Write what `in_common` returns."""
    for k in range(nodes.shape[0]):
        parent, own = nodes[k, 0], bits[nodes[k, 1]]
        out[k] = own & out[parent] if parent >= 0 else own

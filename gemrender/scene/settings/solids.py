"""Closed meshes that settings are made of: wires with round ends, loops, and rings of a profile."""

from __future__ import annotations

import numpy as np

from gemrender.scene.smooth import PlainMesh, creased

__all__ = ["AROUND", "band", "loop", "profile_ring", "wire"]

#: Corners of a wire's cross-section.
AROUND = 16


def wire(path: np.ndarray, radii: np.ndarray, aside: np.ndarray) -> PlainMesh:
    """Return a wire along a path, closed at both ends; a radius of 0 at an end makes it round.

    All of it is within its radius of the path: each cross-section has its corners that far from a point of
    the path, and between two of them it is straight.

    Parameters
    ----------
    path : (n, 3) float64
        The middle of the wire.
    radii : (n,) float64
        Its radius there.
    aside : (3,) float64
        A direction across the path; corners of the cross-sections lie a quarter turn from it.
    """
    across, other = _frames(path, aside)
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    rings = path[:, None] + radii[:, None, None] * (
        np.cos(turn)[None, :, None] * across[:, None] + np.sin(turn)[None, :, None] * other[:, None]
    )
    n = len(path)
    ends = np.stack([path[0], path[-1]])
    k = np.arange(AROUND)
    first, last = n * AROUND, n * AROUND + 1
    caps = [
        np.column_stack([np.full(AROUND, first), (k + 1) % AROUND, k]),
        np.column_stack([np.full(AROUND, last), (n - 1) * AROUND + k, (n - 1) * AROUND + (k + 1) % AROUND]),
    ]
    faces = np.concatenate([_grid(n, AROUND, closed_along=False), *caps])
    return creased(np.concatenate([rings.reshape(-1, 3), ends]), faces)


def loop(path: np.ndarray, radius: float, aside: np.ndarray) -> PlainMesh:
    """Return a wire along a closed path (n, 3), of one radius; `aside` is a direction across all of it."""
    across, other = _frames(path, aside, closed=True)
    turn = 2 * np.pi * np.arange(AROUND) / AROUND
    rings = path[:, None] + radius * (
        np.cos(turn)[None, :, None] * across[:, None] + np.sin(turn)[None, :, None] * other[:, None]
    )
    return creased(rings.reshape(-1, 3), _grid(len(path), AROUND, closed_along=True))


def profile_ring(rows: np.ndarray) -> PlainMesh:
    """Return the ring that a closed profile makes, all around.

    Parameters
    ----------
    rows : (n, m, 3) float64
        For each of n places around, anticlockwise seen from above, the m corners of the profile: up along its
        inside, down along its outside.
    """
    n, m, _ = rows.shape
    return creased(rows.reshape(-1, 3), _grid(n, m, closed_along=True))


def band(radius: float, width: float, thickness: float, along: np.ndarray, middle: np.ndarray) -> PlainMesh:
    """Return the band of a ring, rounded outside and slightly inside.

    Parameters
    ----------
    radius, width, thickness : float
        Inner radius, width along the finger, and thickness.
    along, middle : (3,) float64
        Direction of the finger, level; and the middle of the ring.
    """
    turn = 2 * np.pi * np.arange(28) / 28
    cos, sin = np.cos(turn), np.sin(turn)
    # A superellipse of exponent 3: flat sides, round shoulders
    w = 0.5 * width * np.sign(cos) * np.abs(cos) ** (2 / 3)
    t = radius + 0.5 * thickness * (1 + np.sign(sin) * np.abs(sin) ** (2 / 3))
    around = 2 * np.pi * np.arange(180) / 180
    side = np.cross(along, [0.0, 0.0, 1.0])
    out = np.cos(around)[:, None] * side + np.sin(around)[:, None] * np.array([0.0, 0.0, 1.0])
    rows = middle + t[None, :, None] * out[:, None] + w[None, :, None] * along
    return creased(rows.reshape(-1, 3), _grid(180, 28, closed_along=True)[:, ::-1])


def _frames(path: np.ndarray, aside: np.ndarray, closed: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return two directions across a path at each point, (n, 3) each: towards `aside`, and a turn from it."""
    if closed:
        along = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    else:
        along = np.gradient(path, axis=0)
        step = np.diff(path, axis=0)
        unit = step / np.linalg.norm(step, axis=1, keepdims=True)
        along[1:-1] = unit[1:] + unit[:-1]
        along[0], along[-1] = unit[0], unit[-1]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = aside - (along @ aside)[:, None] * along
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return across, np.cross(along, across)


def _grid(n: int, m: int, *, closed_along: bool) -> np.ndarray:
    """Return the faces between n rows of m points each, closed around, (f, 3)."""
    i = np.arange(n if closed_along else n - 1)[:, None]
    k = np.arange(m)[None]
    a, b = i * m + k, i * m + (k + 1) % m
    c, d = (i + 1) % n * m + k, (i + 1) % n * m + (k + 1) % m
    one, other = (np.stack(np.broadcast_arrays(*t), axis=-1).reshape(-1, 3) for t in ((a, b, d), (a, d, c)))
    return np.concatenate([one, other])

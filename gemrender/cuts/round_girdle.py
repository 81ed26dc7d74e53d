"""A round girdle as level facets, for files that have no cylinders."""

from __future__ import annotations

import numpy as np

from gemrender.stone.facets import LEVEL
from gemrender.stone.solid import ConvexSolid

__all__ = ["girdle_planes"]

#: Azimuths that differ by less are one [degrees].
SAME_AZIMUTH = 1e-6


def girdle_planes(solid: ConvexSolid, pieces: int) -> np.ndarray:
    """Return level planes that touch a round girdle, (n, 4) float64, n of `pieces` or one more.

    The stone inside them has the frame of the round one: they touch where the axes x and y pass through the
    cylinder, and at the lowest point of its lower edge. So all other planes come back from a file unchanged.

    Parameters
    ----------
    solid : ConvexSolid
        A solid with a round girdle.
    pieces : int
        Number of facets, a multiple of 4; the first touches at +y.
    """
    azimuths = np.arange(pieces) * (360.0 / pieces)
    lowest = _lowest(solid.planes)
    if lowest is not None:
        apart = np.abs((azimuths - lowest + 180.0) % 360.0 - 180.0)
        nearest = int(apart.argmin())
        if nearest % (pieces // 4):
            azimuths[nearest] = lowest
        elif apart[nearest] > SAME_AZIMUTH:  # on an axis, which is needed
            azimuths = np.sort(np.append(azimuths, lowest))
    # Exact on the axes, unlike sine and cosine of the angle itself.
    quarter, rest = np.divmod(azimuths, 90.0)
    sin, cos = np.sin(np.radians(rest)), np.cos(np.radians(rest))
    x = np.choose(quarter.astype(int), [sin, cos, -sin, -cos])
    y = np.choose(quarter.astype(int), [cos, -sin, -cos, sin])
    return np.column_stack([x, y, np.zeros(len(x)), np.ones(len(x))])


def _lowest(planes: np.ndarray) -> float | None:
    """Return the azimuth [deg] of the lowest point of a round girdle's lower edge; None: no pavilion."""
    pavilion = planes[planes[:, 2] < -LEVEL]
    if not len(pavilion):
        return None

    def height(azimuths: np.ndarray) -> np.ndarray:
        angle = np.radians(azimuths)
        along = np.outer(np.sin(angle), pavilion[:, 0]) + np.outer(np.cos(angle), pavilion[:, 1])
        return np.asarray(((along - pavilion[:, 3]) / -pavilion[:, 2]).max(axis=1))

    # Two facets meet there: between samples the height falls and then rises.
    samples = np.arange(4096) * (360.0 / 4096)
    middle = float(samples[height(samples).argmin()])
    low, high = middle - 0.1, middle + 0.1
    for _ in range(80):
        thirds = np.array([low + (high - low) / 3, high - (high - low) / 3])
        left, right = height(thirds)
        low, high = (low, float(thirds[1])) if left < right else (float(thirds[0]), high)
    return 0.5 * (low + high) % 360.0

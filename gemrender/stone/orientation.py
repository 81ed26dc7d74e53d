"""How a stone's crystal lies in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["Orientation"]

_UPRIGHT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Orientation:
    """How a stone's crystal lies in it: its optic frame, in the stone's frame.

    Attributes
    ----------
    axes : tuple of three rows of three floats
        Unit vectors, right-handed. Of a uniaxial crystal the last is the optic axis, of a biaxial one they
        are the axes alpha, beta and gamma.
    key, value : str, object
        How it was told: "c_axis" with "table" or a vector, "angles" with three of them [deg]; an empty key
        where it was turned since.
    """

    axes: tuple[tuple[float, ...], ...] = _UPRIGHT
    key: str = "c_axis"
    value: Any = "table"

    def array(self) -> np.ndarray:
        """Return the axes as an array, (3, 3) float64."""
        return np.array(self.axes)

    def turned(self, rotation: np.ndarray) -> Orientation:
        """Return that of the stone after a rotation (3, 3)."""
        axes = self.array() @ rotation.T
        return Orientation(axes=tuple(map(tuple, axes.tolist())), key="", value=None)

"""Light that leaves at its first hit: `window`, through which one sees what is behind the stone."""

from __future__ import annotations

import numpy as np

from gemrender.measures.measure import Light, Measure
from gemrender.stone.facets import PAVILION

__all__ = ["Window"]


class Window(Measure):
    """Share of the view through which one looks through the stone."""

    name, version = "window", 1
    definition = "share of the view whose principal light leaves through a pavilion facet at its first hit"
    source = "gemrender"
    follow = "principal"
    smooth_keys = ("value",)
    is_axial = True

    def contributions(self, light: Light) -> np.ndarray:
        """Return 1 for the window, (n,), else 0."""
        is_first = light.is_principal & (light.paths.reflections == 0)
        return np.asarray(is_first & light.leaves_by(PAVILION), dtype=np.float64)

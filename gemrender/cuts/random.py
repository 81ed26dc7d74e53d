"""Random stones for tests and cross-checks."""

from __future__ import annotations

import numpy as np

from gemrender.cuts.round_brilliant.proportions import RoundBrilliant

__all__ = ["SPREAD", "random_brilliant"]

#: Ranges of the proportions [%]: what is cut and sold, and somewhat beyond.
SPREAD: dict[str, tuple[float, float]] = {
    "table": (48.0, 70.0),
    "star": (40.0, 65.0),
    "lower_girdle_contact": (8.0, 40.0),
    "crown_height": (7.0, 18.0),
    "pavilion_depth": (38.0, 48.0),
    "girdle_thickness": (1.0, 6.0),
}


def random_brilliant(rng: np.random.Generator) -> RoundBrilliant:
    """Draw proportions uniformly from `SPREAD`, each by itself."""
    return RoundBrilliant(**{key: float(rng.uniform(low, high)) for key, (low, high) in SPREAD.items()})

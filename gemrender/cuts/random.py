"""Random stones for tests and cross-checks."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from gemrender.cuts.families.family import Family
from gemrender.cuts.round_brilliant.proportions import RoundBrilliant
from gemrender.errors import InputError

__all__ = ["SPREAD", "random_brilliant", "random_member"]

#: Ranges of the proportions [%]: what is cut and sold, and somewhat beyond.
SPREAD: dict[str, tuple[float, float]] = {
    "table": (48.0, 70.0),
    "star": (40.0, 65.0),
    "lower_girdle_contact": (8.0, 40.0),
    "crown_height": (7.0, 18.0),
    "pavilion_depth": (38.0, 48.0),
    "girdle_thickness": (1.0, 6.0),
}
#: Thickest girdle of a random member [%]: about thicker ones, that are not sold, light runs so long where
#: they are round that no two tracers agree.
_THICKEST_GIRDLE = 10.0


def random_brilliant(rng: np.random.Generator) -> RoundBrilliant:
    """Draw proportions uniformly from `SPREAD`, each by itself."""
    return RoundBrilliant(**{key: float(rng.uniform(low, high)) for key, (low, high) in SPREAD.items()})


def random_member(kind: type[Family], rng: np.random.Generator) -> Family:
    """Draw the parameters of a family uniformly from their ranges, again where they make no stone."""
    while True:
        values: dict[str, Any] = {}
        for part in fields(kind):  # type: ignore[arg-type]
            if "allowed" in part.metadata:
                values[part.name] = part.metadata["allowed"][rng.integers(len(part.metadata["allowed"]))]
            else:
                low, high = part.metadata["range"]
                if part.name == "girdle_thickness":
                    high = min(high, _THICKEST_GIRDLE)
                values[part.name] = float(rng.uniform(low, high))
                if part.metadata["or_zero"] and rng.random() < 0.5:
                    values[part.name] = 0.0
        try:
            cut = kind(**values)
            cut.stone()
        except InputError:
            continue
        return cut

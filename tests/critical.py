"""Stones whose pavilion mains stand at exactly the critical angle to light from straight above."""

from __future__ import annotations

import math

import numpy as np

from gemrender.cuts import RoundBrilliant
from gemrender.stone import Stone

#: Ten indices from glass to the largest that is allowed.
INDICES = tuple(float(n) for n in np.linspace(1.5, 4.0, 10))


def at_critical_angle(index: float, beyond_deg: float = 0.0) -> Stone:
    """Return a brilliant of an index whose pavilion angle is asin(1/index), or so much more [deg]."""
    pavilion = math.asin(1.0 / index) + math.radians(beyond_deg)
    proportions = RoundBrilliant(
        table=57, star=50, lower_girdle_contact=20, crown_height=21.5 * math.tan(math.radians(34.5)),
        pavilion_depth=50 * math.tan(pavilion), girdle_thickness=3,
    )  # fmt: skip
    return Stone.from_proportions(proportions, name=f"critical {index:g}", material=index)

"""Crown and pavilion by angle in place of height, as laboratories measure them: across the width."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gemrender.cuts.families.parameters import Alternative
from gemrender.cuts.laboratory import ROUNDING

__all__ = ["CROWN_ANGLE", "PAVILION_ANGLE"]

_DEGREE = np.pi / 180


def _crown_run(values: Mapping[str, Any]) -> Any:
    """Level distance from the girdle to the table, across the width [%]."""
    return (100.0 - values["table"]) / 2


def _pavilion_run(values: Mapping[str, Any]) -> Any:
    """Level distance from the girdle to the culet, across the width [%]."""
    return (100.0 - values.get("culet", 0.0)) / 2


#: Angle of the crown across the width: crown height = (100 - table)/2 tan(angle) [% of the width].
CROWN_ANGLE = Alternative(
    "crown_angle", "crown_height", 5.0, 70.0,
    lambda angle, values: _crown_run(values) * np.tan(angle * _DEGREE),
    lambda values: np.arctan(values["crown_height"] / _crown_run(values)) / _DEGREE,
    ROUNDING["crown_angle"],
)  # fmt: skip

#: Angle of the pavilion across the width: pavilion depth = (100 - culet)/2 tan(angle) [% of the width].
PAVILION_ANGLE = Alternative(
    "pavilion_angle", "pavilion_depth", 20.0, 70.0,
    lambda angle, values: _pavilion_run(values) * np.tan(angle * _DEGREE),
    lambda values: np.arctan(values["pavilion_depth"] / _pavilion_run(values)) / _DEGREE,
    ROUNDING["pavilion_angle"],
)  # fmt: skip

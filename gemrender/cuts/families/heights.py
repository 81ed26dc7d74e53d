"""Crown and pavilion by angle in place of height, as laboratories measure them: across the width."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gemrender.cuts.families.parameters import Alternative
from gemrender.cuts.laboratory import ROUNDING

__all__ = ["CROWN_ANGLE", "PAVILION_ANGLE", "by_angle"]

_DEGREE = np.pi / 180


def _crown_run(values: Mapping[str, Any]) -> Any:
    """Level distance from the girdle to the table, across the width [%]."""
    return (100.0 - values["table"]) / 2


def _pavilion_run(values: Mapping[str, Any]) -> Any:
    """Level distance from the girdle to the culet, across the width [%]."""
    return (100.0 - values.get("culet", 0.0)) / 2


def by_angle(
    name: str, height: str, run: Callable[[Mapping[str, Any]], Any], low: float, high: float, rounding: float
) -> Alternative:
    """Return an angle that stands for a height: height = run tan(angle).

    Parameters
    ----------
    name, height : str
        The angle's name, and the parameter that it stands for.
    run : callable
        From the values of all parameters, the level distance that the height rises over [% of the width].
    low, high, rounding : float
        Its range, and half of the step that laboratories round it to [deg].
    """
    return Alternative(
        name, height, low, high,
        lambda angle, values: run(values) * np.tan(angle * _DEGREE),
        lambda values: np.arctan(values[height] / run(values)) / _DEGREE,
        rounding,
    )  # fmt: skip


#: Angle of the crown across the width: crown height = (100 - table)/2 tan(angle) [% of the width].
CROWN_ANGLE = by_angle("crown_angle", "crown_height", _crown_run, 5.0, 70.0, ROUNDING["crown_angle"])

#: Angle of the pavilion across the width: pavilion depth = (100 - culet)/2 tan(angle) [% of the width].
PAVILION_ANGLE = by_angle(
    "pavilion_angle", "pavilion_depth", _pavilion_run, 20.0, 70.0, ROUNDING["pavilion_angle"]
)

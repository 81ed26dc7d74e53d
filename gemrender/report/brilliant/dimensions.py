"""The dimensions of a round brilliant: as entered, or what its vertices measure."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.cuts.round_brilliant.topology import (
    CONTACT,
    CULET,
    FACET_KINDS,
    GIRDLE_LOWER,
    GIRDLE_UPPER,
    STAR_TIP,
    TABLE_CORNER,
)
from gemrender.report.measured import Dimension
from gemrender.stone import Stone

__all__ = ["brilliant_dimensions"]

#: Key, symbol, name and unit of each dimension, in the order of the table.
_NAMES = (
    ("table", "TB", "table", "%"),
    ("star", "SU", "star : upper girdle", "%"),
    ("lower_girdle_contact", "LG", "lower-girdle contact", "%"),
    ("crown_height", "CH", "crown height", "%"),
    ("pavilion_depth", "PD", "pavilion depth", "%"),
    ("girdle_thickness", "GH", "girdle thickness", "%"),
    ("crown_angle", "α", "crown angle", "°"),
    ("pavilion_angle", "β", "pavilion angle", "°"),
    ("total_depth", "", "total depth", "%"),
)


def brilliant_dimensions(stone: Stone) -> dict[str, Dimension]:
    """Return a round brilliant's dimensions: its proportions as entered, or what its vertices measure.

    Angles are those of the mains to the girdle plane; heights and the table are per cent of the (mean) girdle
    diameter, the contact of the radius (`docs/model.md`, section 2).

    Parameters
    ----------
    stone : Stone
        One with labelled vertices.
    """
    p = stone.proportions
    values: dict[str, Any]
    if p is None:
        values = _measure(stone)
    else:
        values = {key: getattr(p, key) for key, *_ in _NAMES if hasattr(p, key)}
        values |= {"crown_angle": p.crown_angle_deg, "pavilion_angle": p.pavilion_angle_deg}
        values["total_depth"] = p.crown_height + p.girdle_thickness + p.pavilion_depth
    return {key: Dimension.of(symbol, name, unit, values[key]) for key, symbol, name, unit in _NAMES}


def _measure(stone: Stone) -> dict[str, np.ndarray]:
    """Measure each dimension wherever the stone has it [% and deg]."""
    v = stone.vertices
    table, star, upper, lower, contact = (
        v[rows] for rows in (TABLE_CORNER, STAR_TIP, GIRDLE_UPPER, GIRDLE_LOWER, CONTACT)
    )
    radius = float(np.hypot(*np.concatenate([upper, lower])[:, :2].T).mean())
    # Along the line from the middle of a table edge to the girdle vertex that the star tip points at.
    start = (table + np.roll(table, -1, axis=0))[:, :2] / 2
    along = upper[1::2, :2] - start
    length = np.hypot(*along.T)
    share = ((star[:, :2] - start) * along).sum(axis=1) / length**2
    tilt = np.degrees(np.arccos(np.clip(np.abs(stone.facet_normals[:, 2]), 0.0, 1.0)))
    kinds = np.array(FACET_KINDS[:-1])
    crown_height = table[:, 2] - upper[::2, 2]
    girdle = upper[:, 2] - lower[:, 2]
    depth = lower[::2, 2] - v[CULET, 2]
    percent = 100 / (2 * radius)
    return {
        "table": percent * np.hypot(*(table[:4] - table[4:])[:, :2].T),
        "star": 100 * share,
        "lower_girdle_contact": 100 / radius * np.hypot(*contact[:, :2].T),
        "crown_height": percent * crown_height,
        "pavilion_depth": percent * depth,
        "girdle_thickness": percent * girdle,
        "crown_angle": tilt[kinds == "bezel"],
        "pavilion_angle": tilt[kinds == "pavilion_main"],
        "total_depth": percent * (table[:, 2] - v[CULET, 2]),
    }

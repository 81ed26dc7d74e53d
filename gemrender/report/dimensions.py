"""The dimensions of a stone: as entered, or what its vertices measure."""

from __future__ import annotations

from dataclasses import dataclass
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
from gemrender.stone import Stone

__all__ = ["Dimension", "dimensions"]

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Dimension:
    """A dimension of a stone: of a measured one the mean of its values, and their spread.

    Attributes
    ----------
    symbol, name, unit : str
        The paper's symbol ("" if it has none), the field's name, "%" or "°".
    value, least, most : float
        Mean, smallest and largest value; all the same where the stone was made from proportions.
    """

    symbol: str
    name: str
    unit: str
    value: float
    least: float
    most: float

    @property
    def text(self) -> str:
        """The value as it is written."""
        if self.symbol == "SU":
            a = self.value if self.least == self.most else round(self.value, 1)
            return f"{_short(a)} : {_short(100 - a)}"
        return f"{self.value:.2f}{'°' if self.unit == '°' else ' %'}"

    @property
    def spread(self) -> str:
        """The range of a measured stone's values, as it is written; "" if there is none."""
        if self.least == self.most:
            return ""
        digits = 1 if self.symbol == "SU" else 2
        return f"{self.least:.{digits}f} – {self.most:.{digits}f}"


def dimensions(stone: Stone) -> dict[str, Dimension]:
    """Return a stone's dimensions: its proportions as entered, or what its vertices measure.

    Angles are those of the mains to the girdle plane; heights and the table are per cent of the (mean) girdle
    diameter, the contact of the radius (`docs/model.md`, section 2).
    """
    p = stone.proportions
    values: dict[str, Any]
    if p is None:
        values = _measure(stone)
    else:
        values = {key: getattr(p, key) for key, *_ in _NAMES if hasattr(p, key)}
        values |= {"crown_angle": p.crown_angle_deg, "pavilion_angle": p.pavilion_angle_deg}
        values["total_depth"] = p.crown_height + p.girdle_thickness + p.pavilion_depth
    out = {}
    for key, symbol, name, unit in _NAMES:
        all_values = np.atleast_1d(values[key])
        out[key] = Dimension(
            symbol=symbol, name=name, unit=unit, value=float(all_values.mean()),
            least=float(all_values.min()), most=float(all_values.max()),
        )  # fmt: skip
    return out


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


def _short(number: float) -> str:
    """Write a share without zeros that say nothing."""
    return f"{number:.2f}".rstrip("0").rstrip(".")

"""Proportions of a round brilliant, as the paper and as a laboratory report give them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.cuts.round_brilliant.topology import (
    CONTACT,
    GIRDLE_LOWER,
    GIRDLE_UPPER,
    N_VERTICES,
    STAR_TIP,
    TABLE_CORNER,
)
from gemrender.errors import InputError
from gemrender.mistakes import Mistakes

if TYPE_CHECKING:
    from gemrender.stone import Stone

__all__ = [
    "ANGLE_RANGES",
    "RANGES",
    "RoundBrilliant",
    "brilliant_vertices",
    "crown_height_from_angle",
    "number_within",
    "pavilion_depth_from_angle",
    "smallest_star",
]

#: Allowed range of each proportion [%]. They keep a margin to the degenerate stones (no table, no crown,
#: no pavilion, contact on the axis or beyond the girdle), where single precision cannot tell facets apart.
#: With a table above 92.3 %, which is cos(pi/8), no star tip within the girdle lies below the table.
RANGES: dict[str, tuple[float, float]] = {
    "table": (5.0, 92.0),
    "star": (1.0, 99.0),
    "lower_girdle_contact": (1.0, 99.0),
    "crown_height": (0.5, 60.0),
    "pavilion_depth": (2.0, 100.0),
    "girdle_thickness": (0.0, 50.0),
}

#: Allowed range of what only a laboratory report has: angles [deg] and the lower-half length [%].
ANGLE_RANGES: dict[str, tuple[float, float]] = {
    "crown_angle": (1.0, 75.0),
    "pavilion_angle": (3.0, 63.0),
    "lower_half": (1.0, 99.0),
}

_COS = math.cos(math.pi / 8)
#: Cosine and sine of every vertex's azimuth; how many have the same radius, and the same height.
_AZIMUTHS = np.zeros(N_VERTICES)
for _ring, _first, _step in (
    (TABLE_CORNER, 0, 2), (STAR_TIP, 1, 2), (GIRDLE_UPPER, 0, 1), (GIRDLE_LOWER, 0, 1), (CONTACT, 1, 2),
):  # fmt: skip
    _AZIMUTHS[_ring] = np.pi / 8 * (_first + _step * np.arange(len(_ring)))
_COSINES, _SINES = np.cos(_AZIMUTHS), np.sin(_AZIMUTHS)
_RADII, _HEIGHTS = (8, 8, 32, 8, 1), (8, 8, 16, 16, 8, 1)
#: Star tips must lie below the table by at least this share of the crown height.
_STAR_MARGIN = 1e-3
#: Least thickness of a girdle [%]: a thinner one is none, since its facets are lost among rounding.
_LEAST_GIRDLE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class RoundBrilliant:
    """The paper's proportions of a symmetric round brilliant [%].

    Heights and the table are per cent of the girdle diameter, the star length and the lower-girdle
    contact as below (`docs/model.md`, section 2). Checked when made.

    Parameters
    ----------
    table : float
        TB, distance between opposite table corners [% of the girdle diameter].
    star : float
        The a of the paper's SU a:b: projected length of the star facet, as a share of the way from the
        middle of a table edge to the girdle [%].
    lower_girdle_contact : float
        LG, radial distance of the point where two lower girdle facets meet two pavilion mains
        [% of the girdle radius]; the lower-half length is 100 - LG.
    crown_height, pavilion_depth, girdle_thickness : float
        CH, PD and GH [% of the girdle diameter].

    Raises
    ------
    InputError
        A value is not a finite number, or makes no stone.
    """

    table: float
    star: float
    lower_girdle_contact: float
    crown_height: float
    pavilion_depth: float
    girdle_thickness: float

    def __post_init__(self) -> None:
        for key, value in checked_values(self.values()).items():
            object.__setattr__(self, key, value)
        smallest = smallest_star(self.table)
        if self.star < smallest:
            raise InputError(
                f"the star tips would lie above the table: for table = {self.table:g} % "
                f"the star must be at least {smallest:.2f} %",
                key="star",
                value=self.star,
            )
        if self.girdle_thickness < _LEAST_GIRDLE:
            object.__setattr__(self, "girdle_thickness", 0.0)

    @classmethod
    def from_angles(
        cls,
        *,
        table: float,
        crown_angle: float,
        pavilion_angle: float,
        star: float,
        lower_half: float,
        girdle_thickness: float,
    ) -> RoundBrilliant:
        """Make the proportions from what a laboratory report prints.

        Angles are those of the mains to the girdle plane, measured in the axial plane through a main
        (GIA; `materials.md`): crown height = (100 - table)/2 tan(crown angle), pavilion depth =
        50 tan(pavilion angle), both in per cent of the girdle diameter.

        Parameters
        ----------
        table, star, girdle_thickness : float
            As in the paper [%]; the girdle at its thick places, where the mains meet it.
        crown_angle, pavilion_angle : float
            Angle between a main and the girdle plane [deg].
        lower_half : float
            Lower-half length, a horizontal projection: 100 - lower_girdle_contact [%].

        Raises
        ------
        InputError
            As for the class, told in the report's own terms.
        """
        given = {"table": table, "crown_angle": crown_angle, "pavilion_angle": pavilion_angle}
        given |= {"star": star, "lower_half": lower_half, "girdle_thickness": girdle_thickness}
        table, crown, pavilion, _, lower, _ = checked_values(given).values()
        return cls(
            table=table,
            star=star,
            lower_girdle_contact=100.0 - lower,
            crown_height=crown_height_from_angle(table, crown),
            pavilion_depth=pavilion_depth_from_angle(pavilion),
            girdle_thickness=girdle_thickness,
        )

    def values(self) -> dict[str, float]:
        """Return the proportions by their names."""
        return {key: getattr(self, key) for key in RANGES}

    @property
    def crown_angle_deg(self) -> float:
        """Angle between a bezel main and the girdle plane [deg]."""
        return math.degrees(math.atan2(2 * self.crown_height, 100.0 - self.table))

    @property
    def pavilion_angle_deg(self) -> float:
        """Angle between a pavilion main and the girdle plane [deg]."""
        return math.degrees(math.atan2(2 * self.pavilion_depth, 100.0))

    def stone(self, **facts: Any) -> Stone:
        """Make the perfectly symmetric stone; `facts` are fields of `Stone` such as its name."""
        from gemrender.cuts.round_brilliant.stones import perfect_stone

        return perfect_stone(self.vertices(), cut=self, **facts)

    def vertices(self) -> np.ndarray:
        """Return the 57 vertices in the paper's frame (`docs/model.md`, section 2).

        Returns
        -------
        (57, 3) float64
            x, y, z [girdle radius], in the order of `topology.VERTEX_LABELS`; z = 0 at the girdle's
            lower edge, table up, the first table corner at azimuth 0.
        """
        return brilliant_vertices(**self.values())


def brilliant_vertices(
    *,
    table: Any,
    star: Any,
    lower_girdle_contact: Any,
    crown_height: Any,
    pavilion_depth: Any,
    girdle_thickness: Any,
) -> np.ndarray:
    """Return the vertices of a brilliant, (57, 3), in the paper's frame, from its proportions [%].

    Nothing is checked. Complex numbers give complex vertices: analytic functions, for derivatives by the
    complex step.
    """
    r_table = table / 100
    crown, pavilion, girdle = (
        2 * height / 100 for height in (crown_height, pavilion_depth, girdle_thickness)
    )
    edge = r_table * _COS
    r_star = edge + star / 100 * (1 - edge)
    r_contact = lower_girdle_contact / 100
    z_star = girdle + crown * (1 - r_star * _COS) / (1 - r_table)
    z_contact = -pavilion * (1 - r_contact * _COS)

    # By ring: table corners, star tips, both edges of the girdle, contacts, and the culet.
    radius = np.repeat([r_table, r_star, 1.0, r_contact, 0.0], _RADII)
    height = np.repeat([girdle + crown, z_star, girdle, 0.0, z_contact, -pavilion], _HEIGHTS)
    return np.stack([radius * _COSINES, radius * _SINES, height], axis=-1)


def crown_height_from_angle(table: float, crown_angle: float) -> float:
    """Return the crown height [%] for a table [%] and the angle of the bezel mains to the girdle plane [deg].

    (100 - table)/2 tan(crown angle): table corners and mains lie in one axial plane (GIA; `materials.md`).

    Raises
    ------
    InputError
        The height is outside its range; told by the angle.
    """
    height = (100.0 - table) / 2.0 * math.tan(math.radians(crown_angle))
    return _height("crown_height", height, "crown_angle", crown_angle)


def pavilion_depth_from_angle(pavilion_angle: float) -> float:
    """Return the pavilion depth [%], 50 tan(angle), for the angle of the mains to the girdle plane [deg].

    Raises
    ------
    InputError
        The depth is outside its range; told by the angle.
    """
    depth = 50.0 * math.tan(math.radians(pavilion_angle))
    return _height("pavilion_depth", depth, "pavilion_angle", pavilion_angle)


def number_within(
    key: str, value: object, low_high: tuple[float, float] | None = None, unit: str | None = None
) -> float:
    """Return a value as a float, if it is a number within its range.

    Parameters
    ----------
    key : str
        One of `RANGES` or `ANGLE_RANGES`; keys that end in angle are in degrees, others in per cent.
    value : object
        What was given.
    low_high : pair of float, optional
        The range of a key that those do not have.
    unit : str, optional
        Its unit, where it is another; "" for none.

    Raises
    ------
    InputError
        It is no number, or outside the range.
    """
    low, high = low_high or (RANGES[key] if key in RANGES else ANGLE_RANGES[key])
    if unit is None:
        unit = "deg" if key.endswith("angle") else "%"
    unit = unit and f" [{unit}]"
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise InputError(f"must be a number from {low:g} to {high:g}{unit}", key=key, value=value)
    try:
        number = float(value)
    except OverflowError:  # an integer beyond the largest float
        number = math.inf
    if not low <= number <= high:  # false for NaN too
        raise InputError(f"must be from {low:g} to {high:g}{unit}", key=key, value=value)
    return number


def checked_values(values: Mapping[str, Any]) -> dict[str, float]:
    """Return proportions and angles as floats, each within its range alone.

    Parameters
    ----------
    values : mapping of str to object
        By the keys of `RANGES` and `ANGLE_RANGES`.

    Raises
    ------
    InputError
        For each that is no number, or out of its range.
    """
    numbers: dict[str, Any] = {}
    with Mistakes() as mistakes:
        for key, value in values.items():
            numbers[key] = mistakes.of(number_within, key, value)
    return numbers


def smallest_star(table: float) -> float:
    """Return the star length [%] below which the star tips rise to the table of this size [%].

    The tip lies on the bezel main's plane, which has left the table's height where
    r_s cos(pi/8) > r_t; a small share of the crown height is kept as margin.
    """
    r_table = table / 100
    edge = r_table * _COS
    r_star = (r_table + _STAR_MARGIN * (1 - r_table)) / _COS
    return 100 * (r_star - edge) / (1 - edge)


def _height(key: str, height: float, angle_key: str, angle: float) -> float:
    low, high = RANGES[key]
    if not low <= height <= high:
        raise InputError(
            f"gives a {key.replace('_', ' ')} of {height:.3g} %; must be from {low:g} to {high:g} %",
            key=angle_key,
            value=angle,
        )
    return height

"""Facet planes told as a faceter's tiers: angle, distance and index of each; for files that state planes."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field

import numpy as np

from gemrender.cuts.design import Tier

__all__ = ["DOUBLE_ROUNDING", "SINGLE_ROUNDING", "gear_of", "tiers_of"]

#: Largest error of a plane's normal and distance: numbers of 64 bits after some arithmetic, and of 32 bits.
DOUBLE_ROUNDING, SINGLE_ROUNDING = 1e-10, 3e-7
#: Index wheels that faceters have [teeth], the commonest first.
GEARS = (96, 64, 80, 72, 120, 77, 84, 88, 100, 50, 48, 32, 360)


@dataclass(slots=True)
class _Gathered:
    """Facets of one tier."""

    angles: list[float] = field(default_factory=list)
    distances: list[float] = field(default_factory=list)
    indices: list[float] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    instructions: str = ""
    is_crown: bool = True


def tiers_of(
    planes: np.ndarray,
    *,
    gear: float,
    offset: float = 0.0,
    rounding: float = DOUBLE_ROUNDING,
    keys: Sequence[Hashable] | None = None,
    names: Sequence[str] | None = None,
    instructions: Sequence[str] | None = None,
) -> tuple[Tier, ...]:
    """Return tiers that have these planes, up to rounding, and facets in the order of the tiers.

    Parameters
    ----------
    planes : (n, 4) float64
        Outward unit normal and distance from the origin, 0 or more.
    gear, offset : float
        Teeth of the index wheel, and the index at +y [teeth].
    rounding : float
        Errors that the planes may have: what differs by no more is one tier, and what comes as near to a
        tooth, to a table or to the girdle is there.
    keys : sequence, optional
        Of each plane; those in one tier have the same. Without it, planes of any order make one tier.
    names, instructions : sequence of str, optional
        Of each plane; a tier's instructions are its first facet's.
    """
    gathered: dict[Hashable, list[_Gathered]] = {}
    order: list[_Gathered] = []
    for number, (normal, distance) in enumerate(zip(planes[:, :3], planes[:, 3].tolist(), strict=True)):
        angle, is_crown, index = _angle_and_index(normal, gear, offset, rounding)
        key = (None if keys is None else keys[number], is_crown)
        for tier in gathered.setdefault(key, []):
            same_angle = abs(tier.angles[0] - angle) <= np.degrees(2 * rounding)
            if same_angle and abs(tier.distances[0] - distance) <= 2 * rounding * max(1.0, distance):
                break
        else:
            tier = _Gathered(is_crown=is_crown, instructions=instructions[number] if instructions else "")
            gathered[key].append(tier)
            order.append(tier)
        tier.angles.append(angle)
        tier.distances.append(distance)
        tier.indices.append(index)
        tier.names.append(names[number] if names else "")
    return tuple(
        Tier(
            angle_deg=_middle(tier.angles) * (1.0 if tier.is_crown else -1.0),
            distance=_middle(tier.distances),
            indices=tuple(tier.indices),
            names=tuple(tier.names),
            instructions=tier.instructions,
        )
        for tier in order
    )


def gear_of(planes: np.ndarray, rounding: float = DOUBLE_ROUNDING) -> int:
    """Return the commonest index wheel on which all the planes (n, 4) lie at whole teeth; else 96."""
    inclined = planes[np.hypot(planes[:, 0], planes[:, 1]) > rounding]
    turns = np.arctan2(inclined[:, 0], inclined[:, 1]) / (2 * np.pi)
    near = rounding + 1e-9  # of whole turns: 1e-7 of a tooth
    for gear in GEARS:
        if np.all(np.abs(turns * gear - np.round(turns * gear)) <= near * gear):
            return gear
    return GEARS[0]


def _angle_and_index(
    normal: np.ndarray, gear: float, offset: float, rounding: float
) -> tuple[float, bool, float]:
    """Return the angle from the girdle plane [deg], whether it is on the crown's side, and the index."""
    x, y, z = normal.tolist()
    level = float(np.hypot(x, y))
    if level <= rounding:
        return 0.0, z > 0, _on_wheel(offset, gear, 0.0)
    is_crown = not np.signbit(z)
    angle = 90.0 if abs(z) <= rounding else float(np.degrees(np.arctan2(level, abs(z))))
    azimuth = float(np.degrees(np.arctan2(x, y)))
    near = rounding / level * abs(gear) / (2 * np.pi)
    return angle, is_crown, _on_wheel(azimuth * gear / 360.0 + offset, gear, near)


def _on_wheel(index: float, gear: float, near: float) -> float:
    """Return an index between 0 and the number of teeth, 0 left out, as faceters write it."""
    whole = round(index)
    if abs(index - whole) <= near + 1e-12 * abs(gear):
        index = float(whole)
    return index % abs(gear) or abs(gear)


def _middle(values: list[float]) -> float:
    """Return the mean, to a millionth where it is one but for rounding, as people write angles."""
    mean = values[0] if min(values) == max(values) else float(np.mean(values))
    return round(mean, 6) if abs(mean - round(mean, 6)) < 1e-12 * max(1.0, abs(mean)) else mean

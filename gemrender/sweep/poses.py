"""Poses of a tilted stone: turns about an axis, or all tilts up to one; which of them symmetry makes one."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gemrender.errors import InputError
from gemrender.stone.symmetry import Symmetry

__all__ = ["AXES", "MOST_POSES", "Pose", "alike", "tilt_poses"]

#: What a stone can be tilted about, besides an axis of a given azimuth: an axis of its own, both of them one
#: after the other, or every level axis.
AXES = ("x", "y", "both", "surface")
#: Most poses of a study.
MOST_POSES = 100_000

#: Rings of a surface have so many times fewer poses than would make them as dense as the rings are.
_SPARSER = 2
#: Azimuths that differ by rounding are one [decimals of a degree].
_DECIMALS = 9


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """A stone turned about a level axis.

    Attributes
    ----------
    axis_deg : float
        Azimuth of the axis [deg]: 0 for x, 90 for y.
    turn_deg : float
        By how much it is turned about it, right-handed [deg].
    """

    axis_deg: float
    turn_deg: float

    @property
    def eye(self) -> tuple[float, float]:
        """The same as a tilt of the eye, and the azimuth that it is tilted to, as `View` has them [deg]."""
        if self.turn_deg == 0:
            return 0.0, 0.0
        towards = 90.0 if self.turn_deg > 0 else 270.0
        return abs(self.turn_deg), (self.axis_deg + towards) % 360.0


def tilt_poses(axis: str | float, to_deg: float, step_deg: float, symmetry: Symmetry) -> tuple[Pose, ...]:
    """Return the poses of a study.

    Parameters
    ----------
    axis : {"x", "y", "both", "surface"} or float
        What to turn about: an axis, given by its azimuth [deg] if it is neither x nor y, from -`to_deg` to
        `to_deg`; or every level axis, for a surface over all tilts up to `to_deg`: ring by ring.
    to_deg, step_deg : float
        Largest tilt, above 0 and below 90, and the step [deg]: tilts are its multiples up to the largest one.
    symmetry : Symmetry
        The stone's. A surface has as many poses a ring as make symmetric ones fall on each other.

    Raises
    ------
    InputError
        A value out of range, or more than `MOST_POSES`.
    """
    if not 0 < to_deg < 90:
        raise InputError("must be above 0 and below 90 [deg]", key="to", value=to_deg)
    if not 0 < step_deg <= to_deg:
        raise InputError(f"must be above 0, and {to_deg:g} at the most [deg]", key="step", value=step_deg)
    count = math.floor(to_deg / step_deg + 1e-9)
    azimuths = _ring(to_deg, step_deg, symmetry) if axis == "surface" else 1
    if 2 * count * azimuths > MOST_POSES:
        raise InputError(
            f"makes more than {MOST_POSES} poses; must be larger, or --to smaller", key="step", value=step_deg
        )
    if axis == "surface":
        rings = [_multiple(k, step_deg) for k in range(1, count + 1)]
        around = [_multiple(k, 360.0 / azimuths) for k in range(azimuths)]
        return (
            Pose(axis_deg=0.0, turn_deg=0.0),
            *(Pose(axis_deg=azimuth, turn_deg=ring) for ring in rings for azimuth in around),
        )
    turns = [_multiple(k, step_deg) for k in range(-count, count + 1)]
    return tuple(Pose(axis_deg=azimuth, turn_deg=turn) for azimuth in _axes(axis) for turn in turns)


def _axes(axis: str | float) -> tuple[float, ...]:
    named = {"x": (0.0,), "y": (90.0,), "both": (0.0, 90.0)}
    if isinstance(axis, str) and axis in named:
        return named[axis]
    is_number = isinstance(axis, (int, float)) and not isinstance(axis, bool)
    if not is_number or not math.isfinite(float(axis)):
        allowed = f"must be one of {', '.join(AXES)}, or the azimuth of an axis [deg]"
        raise InputError(allowed, key="axis", value=axis)
    return (float(axis),)


def _ring(to_deg: float, step_deg: float, symmetry: Symmetry) -> int:
    """Return the number of poses of a ring: a multiple of 4, and of what the symmetry makes alike."""
    images = symmetry.fold * (2 if len(symmetry.mirrors) else 1)
    unit = math.lcm(4, images)
    return unit * math.ceil(2.0 * math.pi * to_deg / (_SPARSER * step_deg) / unit)


def _multiple(k: int, step: float) -> float:
    return round(k * step, _DECIMALS) + 0.0  # no -0.0


def alike(symmetry: Symmetry, pose: Pose) -> tuple[float, float]:
    """Return what poses have in common that a symmetry of the stone makes one: tilt and azimuth [deg].

    The azimuth is that from the nearest mirror plane's, or, without one, within one part of the rotation.
    """
    tilt, azimuth = pose.eye
    if tilt == 0:
        return 0.0, 0.0
    part = 360.0 / symmetry.fold
    within = azimuth % part
    if len(symmetry.mirrors):
        within = (azimuth - math.degrees(symmetry.mirrors[0])) % part
        within = min(within, part - within)
    return tilt, round(within, _DECIMALS) % round(part, _DECIMALS)

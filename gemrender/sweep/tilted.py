"""What a study over tilts found: values of measures pose by pose, their curves, and where light is tied."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.measures import Measure
from gemrender.observation import MeasureValues
from gemrender.shown import Tabled, plots
from gemrender.sweep.poses import Pose

__all__ = ["Tie", "TiltStudy", "TiltedValues"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TiltedValues:
    """What measures say of one pose.

    Attributes
    ----------
    pose : Pose
        The pose.
    measures : tuple of MeasureValues
        Values and bound of each measure.
    notes : tuple of str
        What was asked for and not reached, in words.
    """

    pose: Pose
    measures: tuple[MeasureValues, ...]
    notes: tuple[str, ...] = ()

    def value(self, measure: str, key: str) -> float:
        """Return a value, or a detail that is a number; NaN where it is not defined or not known."""
        of = next(of for of in self.measures if of.name == measure)
        return float((of.values | of.details).get(key, math.nan))

    def bound(self, measure: str) -> float:
        """Return the bound of a measure's values; NaN where it is not known."""
        bound = next(of.bound for of in self.measures if of.name == measure)
        return math.nan if bound is None else bound


@dataclass(frozen=True, slots=True, kw_only=True)
class Tie:
    """Light that comes exactly from a limit of a measure's zones at a pose: there it jumps by as much.

    Attributes
    ----------
    pose : Pose
        The pose.
    measure, key : str
        The measure, and the value's name.
    amount : float
        How much is tied, in the measure's unit.
    """

    pose: Pose
    measure: str
    key: str
    amount: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class TiltStudy(Tabled):
    """Measures of a stone over its poses.

    Attributes
    ----------
    name : str
        The stone's name.
    axis : str or float
        What it was turned about, as `study_tilt` takes it.
    measures : tuple of Measure
        What was measured.
    head_deg : float
        Half the angle at which the viewer's head is seen from the stone [deg].
    engine : str
        What traced it.
    found : tuple of TiltedValues
        What was found, pose by pose; turns ascend about each axis.
    """

    name: str
    axis: str | float
    measures: tuple[Measure, ...]
    head_deg: float
    engine: str
    found: tuple[TiltedValues, ...]

    def __repr__(self) -> str:
        return f"<TiltStudy of {self.name!r}: {len(self.found)} poses>"

    @property
    def is_surface(self) -> bool:
        """Whether it is of all tilts up to one, and not of turns about axes."""
        return self.axis == "surface"

    def curves(self) -> dict[float, tuple[TiltedValues, ...]]:
        """Return the poses about each axis, by its azimuth [deg]."""
        curves: dict[float, list[TiltedValues]] = {}
        for found in self.found:
            curves.setdefault(found.pose.axis_deg, []).append(found)
        return {axis: tuple(along) for axis, along in curves.items()}

    def values(self, measure: str, key: str) -> np.ndarray:
        """Return a value over all poses, (n,) float64; NaN where it is not defined or not known."""
        return np.array([found.value(measure, key) for found in self.found])

    def ties(self) -> tuple[Tie, ...]:
        """Return where light is tied, pose by pose."""
        return tuple(
            Tie(pose=found.pose, measure=of.name, key=key, amount=value)
            for found in self.found
            for of in found.measures
            for key, value in of.values.items()
            if (key == "tied" or key.endswith("_tied")) and value > 0
        )

    def plot(self, ax: Any = None, *, measure: str | None = None, axis_deg: float | None = None) -> Any:
        """Draw the curves of a measure about one axis, each with its bound.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to; by default new axes in a figure of their own.
        measure : str, optional
            Its name; by default the first.
        axis_deg : float, optional
            Azimuth of the axis [deg]; by default the first.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            No such measure or axis, or the study is of a surface.
        """
        return plots().plot_tilt(self, ax, measure, axis_deg)

    def to_dict(self) -> dict[str, Any]:
        """Return the study for JSON: its poses, each with its measures, and its ties."""
        return {
            "name": self.name,
            "axis": self.axis,
            "head_deg": self.head_deg,
            "engine": self.engine,
            "poses": [
                {
                    **_pose_values(found.pose),
                    "measures": {of.name: of.to_dict() for of in found.measures},
                    "notes": list(found.notes),
                }
                for found in self.found
            ],
            "ties": [
                {**_pose_values(tie.pose), "measure": tie.measure, "key": tie.key, "amount": tie.amount}
                for tie in self.ties()
            ],
        }


def _pose_values(pose: Pose) -> dict[str, float]:
    tilt, azimuth = pose.eye
    return {
        "axis_deg": pose.axis_deg,
        "turn_deg": pose.turn_deg,
        "tilt_deg": tilt,
        "tilt_azimuth_deg": azimuth,
    }

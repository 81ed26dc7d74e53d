"""Outlines with three bowed sides and pointed or rounded corners; analytic.

Sides are not straight: the main at the middle of a straight side would hold all of it, and leave no halves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.cuts.construction.brilliant import Girdle

__all__ = ["Triangle"]

_COS, _SIN = 0.5, np.sqrt(3.0) / 2.0  # of 60 degrees, between the axes of a corner and of a side
_MIDDLE = 0.5 / np.sqrt(3.0)  # of a straight side, from the centre
_DEGREE = np.pi / 180


@dataclass(frozen=True, slots=True)
class Triangle:
    """A triangle with three equal sides; lengths in the side of the one with sharp corners, centre at 0.

    Parameters
    ----------
    bow : number
        Height of the sides' arcs over their chords, above 0 and up to 0.13.
    radius : number
        Radius of the rounded corners; 0 for pointed ones.
    """

    bow: Any
    radius: Any

    @property
    def is_pointed(self) -> bool:
        """Whether the corners are points."""
        return bool(np.real(self.radius) <= 0)

    @property
    def side(self) -> Any:
        """Distance of the middle of a side from the centre."""
        return _MIDDLE + self.bow

    @property
    def corner(self) -> Any:
        """Distance of a corner from the centre."""
        return self._corner_centre + self.radius

    @property
    def width(self) -> Any:
        """Distance of two corners' ends, along a side."""
        return 2.0 * (_SIN * self._corner_centre + self.radius)

    @property
    def length(self) -> Any:
        """Distance of a corner from the side opposite."""
        return self.corner + self.side

    def girdle(self) -> Girdle:
        """Return the outline with 12 girdle points: corners, middles of sides, and one between each two."""
        # Half a side, from the corner to the middle: along the corner's axis and towards the side.
        if self.is_pointed:
            half = self._side_at(1.0 - np.arange(8).reshape(2, 4) / 8)
        else:
            end = 60.0 * _DEGREE - self._side_end
            # With a point at 30 degrees, where a corner is farthest along a side: the end of the width.
            turns = np.array([0.0, 15.0 * _DEGREE, 30.0 * _DEGREE, end])
            arc = self._corner_centre * np.array([1.0, 0.0]) + self.radius * np.stack(
                [np.cos(turns), np.sin(turns)], axis=-1
            )
            side = self._side_at(np.array([0.75, 0.5, 0.4, 0.3, 0.2, 0.1]))
            half = np.concatenate([arc, side]).reshape(2, 5, 2)
        middle = self._side_at(np.array([0.0]))
        # The other half, from the middle to the next corner, is its mirror image in the axis of the side.
        path = np.concatenate([half.reshape(-1, 2), middle])
        axis = np.array([_COS, _SIN])
        mirrored = 2.0 * (path @ axis)[:, None] * axis - path
        third = np.concatenate([path[:-1], mirrored[:0:-1]]).reshape(4, half.shape[1], 2)
        # Towards the side is towards -x for the corner at +y: anticlockwise.
        turns = 120.0 * _DEGREE * np.arange(3)
        sin, cos = np.sin(turns)[:, None, None], np.cos(turns)[:, None, None]
        along, across = third[..., 0], third[..., 1]
        points = np.stack([-across * cos - along * sin, along * cos - across * sin], axis=-1)
        points = points.reshape(12, half.shape[1], 2)
        lean = 0.5 * self._side_end
        normals = np.array([0.0, 60.0 * _DEGREE - lean, 60.0 * _DEGREE, 60.0 * _DEGREE + lean])
        normals = (turns[:, None] + normals).reshape(-1)
        return Girdle(points, np.stack([-np.cos(normals), -np.sin(normals)], axis=-1))

    @property
    def _half_angle(self) -> Any:
        """Half the angle of a side's arc between sharp corners."""
        return 2.0 * np.arctan(2.0 * self.bow)

    @property
    def _corner_centre(self) -> Any:
        """Distance of a corner's rounding from the centre: it touches both sides from within."""
        arc = 0.5 / np.sin(self._half_angle)
        behind = _MIDDLE - arc * np.cos(self._half_angle)
        return _COS * behind + np.sqrt((arc - self.radius) ** 2 - (_SIN * behind) ** 2)

    @property
    def _side_end(self) -> Any:
        """Angle of a side's arc from its middle to its end."""
        return np.arcsin(_SIN * self._corner_centre / (0.5 / np.sin(self._half_angle) - self.radius))

    def _side_at(self, share: np.ndarray) -> np.ndarray:
        """Return points of half a side, at shares of the way from its middle (0) to its end (1)."""
        arc, turn = 0.5 / np.sin(self._half_angle), share * self._side_end
        level, out = arc * np.sin(turn), _MIDDLE + arc * (np.cos(turn) - np.cos(self._half_angle))
        # From the axes of the side to those of the corner.
        return np.stack([_COS * out + _SIN * level, _SIN * out - _COS * level], axis=-1)

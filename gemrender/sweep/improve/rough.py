"""Rough, and the largest stone of a shape that it holds: a box, or a girdle's diameter that is kept.

The stone stands upright in the rough: its axis along the rough's z, its table up. It may turn about its axis
and lie anywhere. Lengths of rough are in millimetres.

In a box, how far the stone reaches along each side is a cosine of how far it is turned, between the turns at
which a side of its outline lies along the box. So the largest scale is at such a turn, or where both sides of
the box bind: a few candidates are all there are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.cuts.round_girdle import girdle_planes
from gemrender.errors import InputError
from gemrender.stone import ConvexSolid, Stone
from gemrender.stone.polyhedron import intersect

__all__ = ["SIDE_RANGE_MM", "Box", "Diameter", "Fit", "Rough", "check_side"]

#: Shortest and longest side of rough [mm].
SIDE_RANGE_MM = (0.1, 10_000.0)
#: Level facets that stand for a round girdle, outside it: a stone that is found to fit does.
_PIECES = 512
#: Scales that differ by less are one: the smallest turn counts.
_ALIKE = 1e-12
#: Cubic millimetres times g/cm3 are milligrams; so many make a carat.
_CARAT_MG = 200.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """The largest stone that rough holds.

    Attributes
    ----------
    scale_mm : float
        Length of the stone's unit, half its length [mm].
    turn_deg : float
        How far it is turned about its axis, anticlockwise seen from above [deg].
    volume_mm3 : float
        Its volume [mm^3].
    yielded : float or None
        Its share of the rough's volume [%]; None where rough has none.
    """

    scale_mm: float
    turn_deg: float
    volume_mm3: float
    yielded: float | None

    def carat(self, density: float) -> float:
        """Return its weight [carat] at a density [g/cm^3]."""
        return self.volume_mm3 * density / _CARAT_MG


class Rough:
    """What a stone is cut from."""

    #: Its volume [mm^3], if it has any.
    volume_mm3: float | None = None
    #: What was taken of it, in a line, if that is not all of it.
    note = ""

    def largest(self, points: np.ndarray, fold: int) -> tuple[float, float]:
        """Return scale and turn [deg] of the largest copy of points (n, 3), alike after 1/fold of a turn."""
        raise NotImplementedError

    def fit(self, stone: Stone) -> Fit:
        """Return the largest stone of this shape that the rough holds."""
        fold = stone.symmetry.fold if stone.is_convex else 1
        scale, turn = self.largest(_corners(stone), fold)
        volume = float(stone.solid.volume) * scale**3
        share = None if self.volume_mm3 is None else 100.0 * volume / self.volume_mm3
        return Fit(scale_mm=scale, turn_deg=turn, volume_mm3=volume, yielded=share)

    def to_dict(self) -> dict[str, Any]:
        """Return what it is, of JSON's types."""
        raise NotImplementedError


@dataclass(frozen=True)
class Diameter(Rough):
    """Rough that leaves the girdle's diameter, of long stones the length, as it is and no volume to compare.

    Parameters
    ----------
    diameter_mm : float
        The diameter [mm].
    """

    diameter_mm: float

    def __post_init__(self) -> None:
        check_side(self.diameter_mm)

    def largest(self, points: np.ndarray, fold: int) -> tuple[float, float]:
        """Return half the diameter, and no turn."""
        return 0.5 * self.diameter_mm, 0.0

    def to_dict(self) -> dict[str, Any]:
        """Return what it is, of JSON's types."""
        return {"diameter_mm": self.diameter_mm}


@dataclass(frozen=True)
class Box(Rough):
    """A box, its last side along the stone's axis.

    Parameters
    ----------
    sides_mm : tuple of three float
        Its sides [mm].
    """

    sides_mm: tuple[float, float, float]

    def __post_init__(self) -> None:
        for side in self.sides_mm:
            check_side(side)

    @property
    def volume_mm3(self) -> float:  # type: ignore[override]
        """Its volume [mm^3]."""
        return float(np.prod(self.sides_mm))

    def largest(self, points: np.ndarray, fold: int) -> tuple[float, float]:
        """Return scale and turn [deg] of the largest copy of points (n, 3); exact."""
        long, wide, high = self.sides_mm
        outline = _outline(points[:, :2])
        sides = np.roll(outline, -1, axis=0) - outline
        flush = np.arctan2(sides[:, 1], sides[:, 0]) % (0.5 * np.pi)
        turns = np.unique(np.concatenate([[0.0], flush, flush + 0.5 * np.pi]))
        middles = 0.5 * (turns + np.append(turns[1:], np.pi))
        # Between two such turns the same corners bound the stone along x and along y.
        along, across = _spans(outline, middles), _spans(outline, middles + 0.5 * np.pi)
        both = wide * along - long * np.column_stack([across[:, 1], -across[:, 0]])
        binding = (np.arctan2(both[:, 1], both[:, 0]) + 0.5 * np.pi) % np.pi
        inside = (binding > turns) & (binding < np.append(turns[1:], np.pi))
        turns = np.concatenate([turns, binding[inside]])
        scales = np.minimum(long / _widths(outline, turns), wide / _widths(outline, turns + 0.5 * np.pi))
        best = int(np.flatnonzero(scales >= scales.max() * (1.0 - _ALIKE))[0])
        return min(float(scales[best]), high / float(np.ptp(points[:, 2]))), -float(np.degrees(turns[best]))

    def to_dict(self) -> dict[str, Any]:
        """Return what it is, of JSON's types."""
        return {"box_mm": list(self.sides_mm)}


def check_side(side: float) -> None:
    """Refuse a length that rough cannot have [mm]."""
    low, high = SIDE_RANGE_MM
    if not low <= side <= high:
        raise InputError(f"must be from {low:g} to {high:g} mm", key="rough", value=side)


def _corners(stone: Stone) -> np.ndarray:
    """Return the corners of a stone (n, 3); of a round girdle those of a prism about it."""
    solid = stone.solid
    if isinstance(solid, ConvexSolid) and solid.is_round:
        return intersect(np.concatenate([solid.planes, girdle_planes(solid, _PIECES)])).vertices
    return np.asarray(solid.vertices)


def _outline(points: np.ndarray) -> np.ndarray:
    """Return the corners of the convex hull of points (n, 2), anticlockwise."""
    from scipy.spatial import ConvexHull

    return np.asarray(points[ConvexHull(points).vertices])


def _directions(turns: np.ndarray) -> np.ndarray:
    return np.column_stack([np.cos(turns), np.sin(turns)])


def _widths(outline: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Return how wide an outline (n, 2) is in these directions [rad], (k,)."""
    return np.asarray(np.ptp(_directions(turns) @ outline.T, axis=1))


def _spans(outline: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Return from which to which corner an outline (n, 2) is wide in these directions, (k, 2)."""
    along = _directions(turns) @ outline.T
    return np.asarray(outline[along.argmax(axis=1)] - outline[along.argmin(axis=1)])

"""A stone by its meet points: rings of points, and facets that are bounded by them.

Everything is analytic: complex points give complex planes, for derivatives by the complex step.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np

from gemrender.cuts.design import Tier
from gemrender.errors import InputError
from gemrender.stone.facets import LEVEL, Facet, side_of

__all__ = ["LEAST_SHARE", "MEET", "Construction"]

#: Meet points meet to this distance [half the outline's longer side]; rounding leaves 1e-15.
MEET = 1e-9
#: Least area of a facet [share of the outline's area]; girdle facets and culets are as small as is said.
LEAST_SHARE = 1e-4
#: A facet of a smaller area, such as one of a girdle of next to no height, is lost among rounding where
#: planes are intersected [square of half the outline's longer side].
_NO_AREA = 1e-8
#: Angles [deg] and distances of one tier differ by no more: rounding.
_SAME = 1e-9
#: Teeth of the index wheel.
GEAR = 96


class Construction:
    """A stone under construction, in the frame of stones: z along the axis, table up, length along y.

    Attributes
    ----------
    rings : dict of str to (k,) int64
        The numbers of the points of each ring, by its name, such as "table" or "girdle_upper".
    kinds : list of str
        What each facet is one of, such as "bezel", in the order in which they were added.
    corners : list of tuple of int
        The points that bound each facet, in order round it.
    """

    def __init__(self) -> None:
        self.rings: dict[str, np.ndarray] = {}
        self.kinds: list[str] = []
        self.corners: list[tuple[int, ...]] = []
        self._rows: list[np.ndarray] = []
        self._count = 0

    def ring(self, name: str, points: np.ndarray) -> np.ndarray:
        """Add points (k, 3), or (3,) for one, float64 or complex128; return their numbers, (k,) int64."""
        rows = np.atleast_2d(points)
        self.rings[name] = numbers = np.arange(self._count, self._count + len(rows))
        self._rows.append(rows)
        self._count += len(rows)
        return numbers

    def facet(self, kind: str, corners: Iterable[int]) -> None:
        """Add a facet that is bounded by these points, three or more in one plane, in order round it."""
        self.kinds.append(kind)
        self.corners.append(tuple(int(corner) for corner in corners))

    @cached_property
    def points(self) -> np.ndarray:
        """(v, 3) float64 or complex128: all points."""
        return np.concatenate(self._rows)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """A name for each facet: its kind, with a number from 1 where there are several."""
        counts, seen = Counter(self.kinds), Counter[str]()
        names = []
        for kind in self.kinds:
            seen[kind] += 1
            names.append(kind if counts[kind] == 1 else f"{kind}_{seen[kind]}")
        return tuple(names)

    @cached_property
    def facets(self) -> tuple[Facet, ...]:
        """The facets with names, kinds and sides."""
        rise = self.planes[:, 2].real.tolist()
        return tuple(map(Facet, self.names, self.kinds, map(side_of, rise)))

    @cached_property
    def planes(self) -> np.ndarray:
        """(f, 4) float64 or complex128: outward unit normal and offset of each facet."""
        cross = self._crosses
        inside = self.points.real.mean(axis=0)
        first = self.points[self._padded[:, 0]]
        outward = np.sign(((first.real - inside) * cross.real).sum(axis=1))
        with np.errstate(invalid="ignore", divide="ignore"):  # of facets without area; `check` tells them
            normals = cross * (outward / np.sqrt((cross * cross).sum(axis=1)))[:, None]
        return np.column_stack([normals, (normals * first).sum(axis=1)])

    def tiers(self) -> tuple[Tier, ...]:
        """Return the facets as a faceter's tiers, for an index wheel of 96 teeth.

        Facets of one kind with the same angle and distance are one tier. Complex where the points are; then
        the facets of a tier also have the same derivatives.
        """
        planes = self.planes
        x, y, z = planes[:, 0], planes[:, 1], planes[:, 2]
        level = np.sqrt(x * x + y * y)
        leans = level.real > LEVEL
        angles = np.degrees(1.0) * _arctan2(np.where(leans, level, 0.0), np.sign(z.real) * z)
        angles = np.where(np.abs(z.real) <= LEVEL, -90.0, np.where(z.real > 0, angles, -angles))
        turns = np.where(leans, _arctan2(x, np.where(leans, y, 1.0)), 0.0) * (GEAR / (2 * np.pi))
        turns = np.where(turns.real <= _SAME, turns + GEAR, turns)
        if not np.iscomplexobj(planes):
            angles, turns = angles.real, turns.real
        # Derivatives that differ by less are the same: rounding.
        near = 1e-6 * float(np.abs(np.imag([angles, planes[:, 3]])).max())
        tiers: list[tuple[str, complex, complex, list[complex]]] = []
        for kind, angle, distance, turn in zip(
            self.kinds, angles.tolist(), planes[:, 3].tolist(), turns.tolist(), strict=True
        ):
            for other, its_angle, its_distance, indices in tiers:
                if other == kind and all(
                    abs(one.real - two.real) <= _SAME and abs(one.imag - two.imag) <= near
                    for one, two in ((its_angle, angle), (its_distance, distance))
                ):
                    indices.append(turn)
                    break
            else:
                tiers.append((kind, angle, distance, [turn]))
        return tuple(
            Tier(angle_deg=angle, distance=distance, indices=tuple(indices), names=(kind,))  # type: ignore[arg-type]
            for kind, angle, distance, indices in tiers
        )

    def check(self) -> None:
        """Refuse points that make no convex stone with all its facets.

        All points on or within all planes, and of each facet three and more not in one line, make the convex
        hull of the points the solid within the planes, each facet a face of it.

        Raises
        ------
        InputError
            One facet would cut off a corner of others, or a facet would vanish.
        """
        areas = 0.5 * np.linalg.norm(self._crosses.real, axis=1)
        if not (areas > _NO_AREA).all():  # false for NaN too
            number = int(np.argmin(areas > _NO_AREA))
            raise InputError(f"these make no stone: {self._kind(number)} would vanish")
        planes, points = self.planes.real, self.points.real
        above = planes[:, :3] @ points.T - planes[:, 3:]
        own = np.abs(np.take_along_axis(above, self._padded, axis=1)).max(axis=1)
        if not (own <= MEET).all():
            raise InputError(f"these make no stone: {self._kind(int(own.argmax()))} would not be flat")
        if not (above <= MEET).all():  # false for NaN too
            facet, point = np.unravel_index(int(np.nan_to_num(above, nan=np.inf).argmax()), above.shape)
            meeting = dict.fromkeys(
                self._kind(number) for number, corners in enumerate(self.corners) if point in corners
            )
            raise InputError(
                f"these make no convex stone: {self._kind(int(facet))} would cut off the corner where "
                f"{' and '.join(meeting)} meet"
            )
        outline = float(areas[planes[:, 2] > LEVEL] @ planes[planes[:, 2] > LEVEL, 2])
        free = [
            kind == "culet" or abs(rise) <= LEVEL for kind, rise in zip(self.kinds, planes[:, 2], strict=True)
        ]
        small = np.where(free, np.inf, areas).argmin()
        if not free[small] and areas[small] < LEAST_SHARE * outline:
            raise InputError(
                f"these make no stone: {self._kind(int(small))} would vanish (an area of "
                f"{100 * areas[small] / outline:.2g} % of the outline; at least {100 * LEAST_SHARE:g} %)"
            )

    def _kind(self, facet: int) -> str:
        kind, several = self.kinds[facet].replace("_", " "), self.kinds.count(self.kinds[facet]) > 1
        return f"the {kind}{' facets' if several else ''}"

    @cached_property
    def _padded(self) -> np.ndarray:
        """(f, k) int64: the corners of each facet, the last one repeated where it has fewer than others."""
        most = max(map(len, self.corners))
        return np.array([corners + corners[-1:] * (most - len(corners)) for corners in self.corners])

    @cached_property
    def _crosses(self) -> np.ndarray:
        """(f, 3): twice the area of each facet, along its normal on one side or the other (Newell)."""
        ring = self.points[self._padded]
        ring = ring - ring[:, :1]
        a, b = ring[:, 1:-1], ring[:, 2:]
        return np.asarray(_cross(a, b).sum(axis=1))


def _arctan2(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return arctan2 and, in the imaginary part, its derivative along those of y and x."""
    turn = (x.real * np.imag(y) - y.real * np.imag(x)) / (x.real**2 + y.real**2)
    return np.asarray(np.arctan2(y.real, x.real) + 1j * turn)


def _cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return cross products; faster than numpy's of few vectors."""
    return np.asarray(u[..., [1, 2, 0]] * v[..., [2, 0, 1]] - u[..., [2, 0, 1]] * v[..., [1, 2, 0]])


def plane_through(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return planes through three points each, (n, 4): normals, not of unit length, and offsets; analytic."""
    normals = _cross(b - a, c - a)
    return np.concatenate([normals, (normals * a).sum(axis=-1, keepdims=True)], axis=-1)


def height_of(planes: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Return the heights (n,) of planes (n, 4) above level points (n, 2); analytic."""
    return np.asarray((planes[..., 3] - (planes[..., :2] * flat).sum(axis=-1)) / planes[..., 2])


def points_at(flat: np.ndarray, heights: Sequence[complex] | np.ndarray | complex) -> np.ndarray:
    """Return points (n, 3) from level positions (n, 2) and heights, (n,) or one for all."""
    heights = np.broadcast_to(np.asarray(heights), flat.shape[:-1])
    return np.concatenate([flat, heights[..., None]], axis=-1)

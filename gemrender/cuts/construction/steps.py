"""Step cuts on any outline with a keel: rows of facets between edges parallel to the outline.

Each corner of the outline moves along a straight line, seen from above, to an end of the keel. So at every
share of that way the edges are parallel to the outline's, and a facet between two of them is flat, whatever
their heights. The table is such a level of the crown, the culet one of the pavilion, and the facets at the
outline's cut corners run to the very ends of the keel. On all sides a row takes the same share of the way, so
that the stone is convex where the angles of the rows fall from the girdle on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from gemrender.cuts.construction.meet_points import Construction, points_at
from gemrender.errors import InputError

__all__ = ["Plan", "StepConstruction", "profile", "rectangle", "step_cut"]


@dataclass(frozen=True, slots=True)
class Plan:
    """An outline and a keel, seen from above.

    Parameters
    ----------
    corners : (m, 2) float64 or complex128
        Corners of the outline, anticlockwise.
    keel : (2, 2) float64 or complex128
        Ends of the keel; the same point twice where there is none.
    ends : tuple of int
        For each corner, the end of the keel that it moves to.
    edges : tuple of str
        What the edge from each corner to the next is: "side", "end" or "corner".
    """

    corners: np.ndarray
    keel: np.ndarray
    ends: tuple[int, ...]
    edges: tuple[str, ...]

    def level(self, share: Any) -> np.ndarray:
        """Return the corners (m, 2) at a share of the way from the outline (0) to the keel (1)."""
        return np.asarray(self.corners + share * (self.keel[list(self.ends)] - self.corners))


def rectangle(half_width: Any, half_length: Any, corner: Any = 0.0) -> Plan:
    """Return a rectangle, its length along y, with the keel that makes sides and ends equally steep.

    Parameters
    ----------
    half_width, half_length : number
        Of the outline; the keel is as much shorter at each end as the sides are away from it.
    corner : number
        How much of a side each cut corner, at 45 degrees, takes away; 0 for none.
    """
    w, h, c = half_width, half_length, corner
    if np.real(corner) > 0:
        quarter = [((w, h - c), "corner"), ((w - c, h), "end")]
        mirrored = [((-w + c, h), "corner"), ((-w, h - c), "side")]
    else:
        quarter, mirrored = [((w, h), "end")], [((-w, h), "side")]
    upper = quarter + mirrored
    lower = [((-x, -y), edge) for (x, y), edge in upper]
    corners = np.array([point for point, _ in upper + lower])
    keel = np.array([(0.0 * h, h - w), (0.0 * h, w - h)])
    ends = (0,) * len(upper) + (1,) * len(lower)
    return Plan(corners, keel, ends, tuple(edge for _, edge in upper + lower))


def profile(steps: int, height: Any, bulge: Any) -> list[Any]:
    """Return how far from the girdle the levels lie in height, `steps` + 1 numbers from 0 on.

    The rows are equally wide, seen from above. The levels between the first and the last stand out of the
    straight line between these, as those of a parabola: at level i of n by b i (n - i)/(n//2 ((n + 1)//2)),
    where b is the bulge, so that the greatest is b. Of three rows the middle one is parallel to the line.
    """
    most = _most(steps)
    return [height * (i / steps) + bulge * (i * (steps - i) / most) for i in range(steps + 1)]


def _most(steps: int) -> int:
    return (steps // 2) * ((steps + 1) // 2)


def _hollow_at(steps: int) -> float:
    """Return the height over the bulge at which the row by the table or the keel would be level."""
    return steps * (steps - 1) / _most(steps)


class StepConstruction(Construction):
    """A step cut under construction, whose rows must not be hollow."""

    def check(self) -> None:
        """Refuse rows whose angles do not fall from the girdle on, and all that `Construction` refuses.

        Raises
        ------
        InputError
            The stone would be hollow, or a facet would vanish.
        """
        for part, last in (("crown", "table"), ("pavilion", "keel")):
            levels = [self.points[ring[0], 2].real for name, ring in self.rings.items() if part in name]
            # The rows are equally wide, so that their angles fall where their heights do.
            heights = np.abs(np.diff(levels)) * np.sign((levels[-1] - levels[0]) * np.diff(levels))
            if not ((heights > 0).all() and (np.diff(heights) < 0).all()):
                raise InputError(
                    f"the {part} would be hollow: the angles of its steps must fall from the girdle to the "
                    f"{last}; a bulge of less than height/{_hollow_at(len(heights)):.3g} lets them"
                )
        super().check()


def step_cut(
    plan: Plan,
    *,
    table: Any,
    crown: Sequence[Any],
    thickness: Any,
    pavilion: Sequence[Any],
    culet: Any = 0.0,
) -> StepConstruction:
    """Return a step cut; lengths in the stone's unit.

    Parameters
    ----------
    plan : Plan
        Outline and keel.
    table : number
        Width of the table [share of the outline's width].
    crown, pavilion : sequence of number
        Heights of the levels above the girdle's upper edge, and depths below its lower edge, from 0 on.
    thickness : number
        Height of the girdle.
    culet : number
        Width of the culet [share of the outline's width]; 0 for a keel.
    """
    stone = StepConstruction()
    upper = _add_rows(stone, plan, "crown", 1.0 - table, [thickness + height for height in crown])
    stone.facet("table", stone.rings[f"crown_{len(crown) - 1}"])
    lower = _add_rows(stone, plan, "pavilion", 1.0 - culet, [-depth for depth in pavilion])
    if np.real(culet) > 0:
        stone.facet("culet", stone.rings[f"pavilion_{len(pavilion) - 1}"])
    for j in range(len(upper)):
        after = (j + 1) % len(upper)
        stone.facet("girdle", (lower[j], lower[after], upper[after], upper[j]))
    return stone


def _add_rows(stone: Construction, plan: Plan, part: str, reach: Any, heights: Sequence[Any]) -> np.ndarray:
    """Add the rows of a crown or pavilion; return the numbers of its points at the girdle, (m,) int64."""
    steps = len(heights) - 1
    levels = []
    for row, height in enumerate(heights):
        share = reach * (row / steps)
        if np.real(share) < 1:
            levels.append(stone.ring(f"{part}_{row}", points_at(plan.level(share), height)))
        else:
            keel = stone.ring(f"{part}_{row}", points_at(plan.keel, height))
            levels.append(keel[list(plan.ends)])
    for row, (outer, inner) in enumerate(pairwise(levels), start=1):
        for j, edge in enumerate(plan.edges):
            after = (j + 1) % len(plan.edges)
            ring = (outer[j], outer[after], inner[after], inner[j])
            stone.facet(f"{part}_{edge}_{row}", dict.fromkeys(map(int, ring)))
    return levels[0]

"""Step cuts on any outline with a keel: rows of facets between edges parallel to the outline.

Seen from above, each corner of the outline moves along a straight line to an end of the keel. So at every
share of that way the edges are parallel to the outline's, and a facet between two of them is flat, whatever
their heights. The table is such a level of the crown, the culet one of the pavilion, and the facets at the
outline's cut corners run to the very ends of the keel. A row takes the same share of the way on all sides, so
that the stone is convex where the slopes of the rows fall from the girdle on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from gemrender.cuts.construction.meet_points import Construction, points_at
from gemrender.errors import InputError

__all__ = ["Plan", "Profile", "StepConstruction", "profile", "rectangle", "step_cut", "trapezoid"]


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
    reach : number
        Share of the way at which the corners of the second end are there; those of the first are at 1. Below
        1 the sides converge towards the second end, and the keel rises to it.
    """

    corners: np.ndarray
    keel: np.ndarray
    ends: tuple[int, ...]
    edges: tuple[str, ...]
    reach: Any = 1.0

    def level(self, share: Any) -> np.ndarray:
        """Return the corners (m, 2) at a share of the way from the outline (0) to the keel."""
        ends = list(self.ends)
        of_each = share / np.array([1.0, self.reach])[ends][:, None]
        return np.asarray(self.corners + of_each * (self.keel[ends] - self.corners))


def rectangle(half_width: Any, half_length: Any, corner: Any) -> Plan:
    """Return a rectangle with cut corners at 45 degrees, its length along y; sides and ends equally steep.

    Parameters
    ----------
    half_width, half_length : number
        Of the outline; the keel is as much shorter at each end as it is away from the sides.
    corner : number
        How much each cut corner takes from a side.
    """
    w, h, c = half_width, half_length, corner
    upper = [((w, h - c), "corner"), ((w - c, h), "end"), ((-w + c, h), "corner"), ((-w, h - c), "side")]
    return _plan(upper + [((-x, -y), edge) for (x, y), edge in upper], h - w, w - h, 1.0)


def trapezoid(half_width: Any, half_length: Any, taper: Any = 1.0) -> Plan:
    """Return a rectangle without cut corners, or one that is narrower at -y: `taper` of the width."""
    w, h = half_width, half_length
    # The ends move by w in all, and the sides so that their corners at the wide end meet on the axis then.
    reach = taper / (1.0 - (1.0 - taper) * w / h)
    corners = [((w, h), "end"), ((-w, h), "side"), ((-taper * w, -h), "end"), ((taper * w, -h), "side")]
    return _plan(corners, h - w, reach * w - h, reach)


def _plan(corners: Sequence[tuple[tuple[Any, Any], str]], top: Any, bottom: Any, reach: Any) -> Plan:
    points = np.array([point for point, _ in corners])
    ends = tuple(int(y < 0) for y in points[:, 1].real.tolist())
    keel = np.array([[0.0 * top, top], [0.0 * top, bottom]])
    return Plan(points, keel, ends, tuple(edge for _, edge in corners), reach)


@dataclass(frozen=True, slots=True)
class Profile:
    """The levels of a crown or pavilion: shares of the way to the keel, and heights away from the girdle."""

    shares: Sequence[Any]
    heights: Sequence[Any]


def profile(steps: int, reach: Any, height: Any, bulge: Any, narrow: Any = 1.0) -> Profile:
    """Return the levels of so many rows, from the girdle on.

    The rows are equally wide, seen from above. The levels between the first and the last stand out of the
    straight line between these, as those of a parabola: at level i of n by b i (n - i)/(n//2 ((n + 1)//2)),
    where b is the bulge, so that the greatest is b. Of three rows the middle one is parallel to the line.

    Parameters
    ----------
    steps : int
        How many rows, 2 or more.
    reach : number
        Share of the way to the keel at the last level: 1 at the keel itself.
    height, bulge : number
        Height of the last level, and the bulge.
    narrow : number
        `reach` of the plan, by which all levels but the last are nearer to the outline.
    """
    most = (steps // 2) * ((steps + 1) // 2)
    shares = [reach * narrow * (i / steps) for i in range(steps)]
    heights = [height * (t / reach) + bulge * (i * (steps - i) / most) for i, t in enumerate(shares)]
    return Profile([*shares, reach], [*heights, height])


class StepConstruction(Construction):
    """A step cut under construction, whose crown and pavilion must not be hollow.

    Attributes
    ----------
    profiles : dict of str to Profile
        That of the "crown" and of the "pavilion".
    """

    def __init__(self) -> None:
        super().__init__()
        self.profiles: dict[str, Profile] = {}

    def check(self) -> None:
        """Refuse rows whose angles do not fall from the girdle on, and all that `Construction` refuses.

        Raises
        ------
        InputError
            The stone would be hollow, or a facet would vanish.
        """
        for part, last in (("crown", "table"), ("pavilion", "keel")):
            levels = self.profiles[part]
            slopes = np.diff(np.real(levels.heights)) / np.diff(np.real(levels.shares))
            if not ((np.diff(slopes) < 0).all() and slopes[-1] > 0):
                raise InputError(
                    f"these make a hollow {part}: the angles of its steps must fall from the girdle to the "
                    f"{last}, as they do with less bulge"
                )
        super().check()


def step_cut(plan: Plan, *, crown: Profile, thickness: Any, pavilion: Profile) -> StepConstruction:
    """Return a step cut; lengths in the stone's unit.

    Parameters
    ----------
    plan : Plan
        Outline and keel.
    crown, pavilion : Profile
        Heights above the girdle's upper edge, and depths below its lower edge. A pavilion that reaches less
        than the keel ends in a culet.
    thickness : number
        Height of the girdle.
    """
    stone = StepConstruction()
    stone.profiles = {"crown": crown, "pavilion": pavilion}
    up = Profile(crown.shares, [thickness + height for height in crown.heights])
    upper, table = _add_rows(stone, plan, "crown", up)
    stone.facet("table", table)
    down = Profile(pavilion.shares, [-depth for depth in pavilion.heights])
    lower, last = _add_rows(stone, plan, "pavilion", down)
    if len(set(last.tolist())) > len(plan.keel):
        stone.facet("culet", last)
    for j in range(len(upper)):
        after = (j + 1) % len(upper)
        stone.facet("girdle", (lower[j], lower[after], upper[after], upper[j]))
    return stone


def _add_rows(stone: Construction, plan: Plan, part: str, levels: Profile) -> tuple[np.ndarray, np.ndarray]:
    """Add the rows of a crown or pavilion; return the numbers of its first and last points, (m,) int64."""
    shares, heights = levels.shares, levels.heights
    rings = []
    for row, (share, height) in enumerate(zip(shares, heights, strict=True)):
        if np.real(share) < 1:
            rings.append(stone.ring(f"{part}_{row}", points_at(plan.level(share), height)))
            continue
        # The last row goes on to the keel, whose second end it may meet earlier.
        met = heights[-2] + (height - heights[-2]) * (plan.reach - shares[-2]) / (share - shares[-2])
        keel = stone.ring("keel", points_at(plan.keel, np.array([height, met])))
        rings.append(keel[list(plan.ends)])
    for row, (outer, inner) in enumerate(pairwise(rings), start=1):
        for j, edge in enumerate(plan.edges):
            after = (j + 1) % len(plan.edges)
            ring = (outer[j], outer[after], inner[after], inner[j])
            stone.facet(f"{part}_{edge}_{row}", dict.fromkeys(map(int, ring)))
    return rings[0], rings[-1]

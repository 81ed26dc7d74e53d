"""Brilliants on any outline: table, stars, bezels and upper halves, lower halves and pavilion mains.

Meet points leave no facet a choice: a bezel passes through its girdle point, along the outline there, and
through its table corner; a star tip lies where two bezels meet, a contact where two pavilion mains do; halves
pass through their tip or contact and two girdle points. So facets meet on every outline, and only convexity
is left to be checked (`Construction.check`).

On a round outline halves may be painted or dug out: then they pass through one girdle point, that of a main,
and meet their neighbours above or below the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.cuts.construction.meet_points import Construction, height_of, plane_through, points_at

__all__ = ["Girdle", "add_crown", "add_girdle", "add_pavilion", "brilliant", "widths"]


@dataclass(frozen=True, slots=True)
class Girdle:
    """An outline with its girdle points, where halves begin and end; every other one is the foot of a bezel.

    Parameters
    ----------
    points : (2n, pieces, 2) float64 or complex128
        Points of the outline, anticlockwise seen from above, from the end of its length at +y on: the first
        of each row is a girdle point, the others lie between it and the next. With one in a row the girdle is
        round, or has one facet from girdle point to girdle point.
    tangents : (2n, 2) float64 or complex128
        Direction of the outline at each girdle point; at a tip a line that touches it only there.
    is_round : bool
        Whether the outline is the circle of radius 1, whose girdle is a cylinder and no facets here.
    """

    points: np.ndarray
    tangents: np.ndarray
    is_round: bool = False

    @property
    def feet(self) -> np.ndarray:
        """(2n, 2): the girdle points."""
        return np.asarray(self.points[:, 0])


def brilliant(
    girdle: Girdle,
    *,
    table: np.ndarray,
    star: Any,
    crown_height: Any,
    thickness: Any,
    pavilion_depth: Any,
    lower_half: Any,
    culet: Any = 0.0,
    mains: Sequence[int] | None = None,
    axis: Sequence[Any] = (0.0, 0.0),
    french: Sequence[int] = (),
    crown_painting: Any = None,
    pavilion_painting: Any = None,
) -> Construction:
    """Return a brilliant; lengths in the stone's unit, half the longer side of its outline.

    Parameters
    ----------
    girdle : Girdle
        The outline, with 2n girdle points.
    table : (n, 2)
        Corners of the table, the first above the first girdle point.
    star : number
        Star length: share of the way from the middle of a table edge to the girdle (0 to 1).
    crown_height, thickness, pavilion_depth : number
        Heights of crown, girdle (at the girdle points) and pavilion.
    lower_half : number
        Lower-half length: share of the way from the girdle to the axis (0 to 1).
    culet : number
        Size of the culet [share of the mains' level section at the girdle, which is as wide as the outline
        where mains stand at its widest places; else see `widths`]; 0 for a point.
    mains : sequence of int, optional
        Girdle points that pavilion mains stand at; by default every other one, below the bezels.
    axis : pair of number
        Where the culet lies.
    french : sequence of int
        Table corners without a bezel, on a mirror plane of the crown: French tips.
    crown_painting, pavilion_painting : number, optional
        By how much halves are turned towards the mains [rad]; negative where they are dug out. Of outlines
        that are alike on both sides of each girdle point, with mains at every other one: round ones.
    """
    stone = Construction()
    upper = add_crown(
        stone,
        girdle,
        table=table,
        star=star,
        height=crown_height,
        thickness=thickness,
        french=french,
        painting=crown_painting,
    )
    lower = add_pavilion(
        stone,
        girdle,
        depth=pavilion_depth,
        lower_half=lower_half,
        culet=culet,
        mains=range(0, len(girdle.points), 2) if mains is None else mains,
        axis=axis,
        painting=pavilion_painting,
    )
    add_girdle(stone, upper, lower, girdle)
    return stone


def add_crown(
    stone: Construction,
    girdle: Girdle,
    *,
    table: np.ndarray,
    star: Any,
    height: Any,
    thickness: Any,
    french: Sequence[int] = (),
    painting: Any = None,
) -> np.ndarray:
    """Add a crown; return the numbers of the points of the girdle's upper edge, (2n, pieces) int64.

    Where a bezel is left out, the stars and halves beside it are extended to the mirror plane, and meet there
    in a ridge from the table's corner to the girdle.
    """
    feet, count = girdle.feet, len(girdle.feet)
    foot = points_at(feet[::2], thickness)
    corners = points_at(table, thickness + height)
    along = points_at(girdle.tangents[::2], 0.0)
    bezels = plane_through(foot, foot + along, corners)
    after = np.roll(bezels, -1, axis=0)
    # The tip: on both bezels, and so far along the way from the middle of the table's edge to the girdle.
    middle, end = 0.5 * (table + np.roll(table, -1, axis=0)), feet[1::2]
    way = end - middle
    reach = ((middle + star * way) * way).sum(axis=1)
    across = np.concatenate([points_at(way, 0.0), reach[:, None]], axis=1)
    tips = _meet(bezels, after, across)

    edge = points_at(girdle.points, thickness)
    edge, halves = _halves(edge, np.repeat(tips, 2, axis=0), painting)
    edge = _risen(edge, halves)
    t, s = stone.ring("table", corners), stone.ring("star", tips)
    u = stone.ring("girdle_upper", edge.reshape(-1, 3)).reshape(edge.shape[:2])
    ends = np.roll(u[:, 0], -1)
    ridge: dict[int, tuple[int, ...]] = {}
    if french:
        at = np.array(french)
        stars = plane_through(corners, tips, np.roll(corners, -1, axis=0))
        bends = stone.ring("ridge", _meet(stars[at - 1], stars[at], halves[2 * at]))
        ridge = {int(k): (int(bend),) for k, bend in zip(french, bends, strict=True)}
    stone.facet("table", t)
    for k in range(len(t)):
        after_it = (k + 1) % len(t)
        stone.facet("star", (t[k], *ridge.get(k, ()), s[k], *ridge.get(after_it, ()), t[after_it]))
    for k in range(len(t)):
        if k not in ridge:
            stone.facet("bezel", (t[k], s[k - 1], u[2 * k, 0], s[k]))
    for j in range(count):
        # Of the two halves at a star's tip the first begins at a bezel's foot, and the second ends at one.
        first, second = ((), ridge.get((j + 1) // 2 % len(t), ())) if j % 2 else (ridge.get(j // 2, ()), ())
        stone.facet("upper_girdle", (s[j // 2], *first, *u[j], ends[j], *second))
    return u


def add_pavilion(
    stone: Construction,
    girdle: Girdle,
    *,
    depth: Any,
    lower_half: Any,
    culet: Any,
    mains: Sequence[int],
    axis: Sequence[Any],
    painting: Any = None,
    top: Any = 0.0,
    ring: str = "girdle_lower",
) -> np.ndarray:
    """Add a pavilion; return the numbers of the points of the girdle's lower edge, (2n, pieces) int64.

    One that begins below the girdle has another ring for its edge, at the height `top`, and its depth from
    there on.
    """
    feet, count = girdle.feet, len(girdle.feet)
    mains = list(mains)
    steps = np.diff([*mains, mains[0] + count])
    centre = np.array(axis)
    # Mains meet in one point, below the culet where there is one.
    apex = points_at(centre, top - depth / (1.0 - culet))
    foot = points_at(feet[mains], top)
    planes = plane_through(foot, foot + points_at(girdle.tangents[mains], 0.0), apex)
    after = np.roll(planes, -1, axis=0)
    half = np.array(mains) + steps / 2
    before = feet[np.floor(half).astype(int) % count]
    middle = 0.5 * (before + feet[np.ceil(half).astype(int) % count])
    way = middle - centre
    reach = ((centre + (1.0 - lower_half) * way) * way).sum(axis=1)
    contacts = _meet(planes, after, np.concatenate([points_at(way, 0.0), reach[:, None]], axis=1))

    edge = points_at(girdle.points, top)
    of_segment = np.repeat(np.arange(len(mains)), steps)
    first = (mains[0] + np.arange(count)) % count
    at = np.argsort(first)  # of each segment, its place from the first main on
    edge, halves = _halves(edge, contacts[of_segment[at]], painting)
    edge = _risen(edge, halves)
    low = stone.ring(ring, edge.reshape(-1, 3)).reshape(edge.shape[:2])
    c = stone.ring("contact", contacts)
    ends = np.roll(low[:, 0], -1)
    for j, k in zip(first.tolist(), of_segment.tolist(), strict=True):
        stone.facet("lower_girdle", (c[k], ends[j], *low[j, ::-1]))
    if np.real(culet) > 0:
        tips = stone.ring("culet", apex + (contacts - apex) * _share(contacts, apex, top - depth)[:, None])
    else:
        tips = np.repeat(stone.ring("culet", apex), len(mains))
    for k, main in enumerate(mains):
        # Seen from below: the culet's corner before, the contact before, the foot, and those after.
        corners = (tips[k - 1], c[k - 1], low[main, 0], c[k], tips[k])
        stone.facet("pavilion_main", dict.fromkeys(map(int, corners)))
    if np.real(culet) > 0:
        stone.facet("culet", tips)
    return low


def add_girdle(stone: Construction, upper: np.ndarray, lower: np.ndarray, girdle: Girdle) -> None:
    """Add the facets of the girdle between its edges, (2n, pieces) int64 each, unless it is round."""
    if girdle.is_round:
        return
    top, bottom = upper.reshape(-1), lower.reshape(-1)
    for k in range(len(top)):
        after = (k + 1) % len(top)
        stone.facet("girdle", (bottom[k], bottom[after], top[after], top[k]))


def widths(girdle: Girdle, mains: Sequence[int]) -> Any:
    """Return the width of the outline over that of the mains' level section at the girdle."""
    mains = list(mains)
    feet, along = girdle.feet[mains], girdle.tangents[mains]
    lines = np.stack([-along[:, 1], along[:, 0]], axis=1)
    offsets = (lines * feet).sum(axis=1)
    pairs = np.stack([lines, np.roll(lines, -1, axis=0)], axis=1)
    both = np.stack([offsets, np.roll(offsets, -1)], axis=1)
    x = np.linalg.solve(pairs, both[..., None])[:, 0, 0]
    across = girdle.feet[:, 0]
    return (across[across.real.argmax()] - across[across.real.argmin()]) / (
        x[x.real.argmax()] - x[x.real.argmin()]
    )


def _halves(edge: np.ndarray, tips: np.ndarray, painting: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return a girdle's edge (2n, pieces, 3) and the halves' planes (2n, 4), through these tips (2n, 3).

    A painted half is turned about the line from its tip to the main's girdle point, until its azimuth has
    changed by `painting` [rad], and the girdle point between mains lies where it meets the next one.
    """
    ends = np.roll(edge[:, 0], -1, axis=0)
    if painting is None:
        return edge, plane_through(tips, edge[:, 0], ends)
    begins = np.arange(len(edge)) % 2 == 0  # whether the main is where the half begins, or where it ends
    mains = np.where(begins[:, None], edge[:, 0], ends)
    cos, sin = np.cos(painting), np.where(begins, -1.0, 1.0) * np.sin(painting)
    x, y = (ends - edge[:, 0])[:, 1], -(ends - edge[:, 0])[:, 0]
    azimuth = np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)
    way = tips - mains
    level = (way[:, :2] * azimuth).sum(axis=1, keepdims=True)
    normals = np.concatenate([-way[:, 2:] * azimuth, level], axis=1)
    halves = np.concatenate([normals, (normals * mains).sum(axis=1, keepdims=True)], axis=1)
    edge = edge.astype(halves.dtype)
    edge[1::2, 0] = points_at(ends[::2, :2], height_of(halves[::2], ends[::2, :2]))
    return edge, halves


def _risen(edge: np.ndarray, halves: np.ndarray) -> np.ndarray:
    """Return a girdle's edge (2n, pieces, 3) with the points between girdle points on the halves (2n, 4)."""
    between = points_at(edge[:, 1:, :2], height_of(halves[:, None], edge[:, 1:, :2]))
    return np.concatenate([edge[:, :1], between], axis=1)


def _share(contacts: np.ndarray, apex: np.ndarray, height: Any) -> np.ndarray:
    """Return the share of the way from the apex to each contact at which the culet lies, (n,)."""
    return np.asarray((height - apex[2]) / (contacts[:, 2] - apex[2]))


def _meet(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return the points (n, 3) where three planes each, (n, 4), meet; analytic."""
    system = np.stack([a, b, c], axis=1)
    return np.asarray(np.linalg.solve(system[..., :3], system[..., 3:])[..., 0])

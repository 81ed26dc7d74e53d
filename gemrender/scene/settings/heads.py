"""The part of a setting that holds the stone: claws on a collar, or a rim around the girdle.

Claws and rims keep clear of the stone by construction. A wire of radius r runs at a distance r + gap from
planes that touch the stone's convex hull, each in the direction of the next piece of the way: no point
between is nearer. A rim stands beside the outline from above, and above all of the stone that its lip covers.
That holds for every stone; `refuse_cutting` checks it all the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.scene.settings.outline import Outline
from gemrender.scene.settings.solids import loop, profile_ring, wire
from gemrender.scene.smooth import PlainMesh

__all__ = ["GAP", "Head", "claws", "rim"]

#: How far metal is from the stone where it touches it [girdle radius]: 6 um of a stone of 6.5 mm, some ten
#: times what Mitsuba's rays are moved by off a surface.
GAP = 2e-3
#: Steps of a claw's bend [deg].
_STEP_DEG = 8.0
#: What a stone stands above the collar by [girdle radius].
_CLEAR = 0.04
#: What a rail's steps may cut off a corner [girdle radius].
_SAGITTA = 0.02
#: Share of the outline that the collar under a stone has.
_COLLAR = {"ring": 0.4, "pendant": 0.55}
#: How far a rim's lip reaches over the crown [share of the outline].
_LIP = 0.045


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Head:
    """A head.

    Attributes
    ----------
    parts : list of PlainMesh
        Its closed parts.
    base : float
        Height of the middle of its lower end [girdle radius].
    bottom : float
        Its lowest point.
    """

    parts: list[PlainMesh]
    base: float
    bottom: float


# ---- Claws ---------------------------------------------------------------------------------------------


def claws(outline: Outline, directions: list[float], radius: float, kind: str) -> Head:
    """Return claws that stand on a collar and bend over the girdle.

    Parameters
    ----------
    outline : Outline
        The stone.
    directions : list of float
        Where claws face [rad].
    radius : float
        Of their wire [girdle radius].
    kind : {"ring", "pendant"}
        What they are for.
    """
    low, _ = outline.girdle
    base = min(outline.bottom - 1.1 * radius - _CLEAR, low - 0.5)
    share = _COLLAR[kind]
    parts = [_claw(outline, angle, radius, base, share) for angle in directions]
    middle = outline.middle
    corners, _ = _rounded(outline, 0.0)
    collar = np.column_stack([middle + share * (corners - middle), np.full(len(corners), base)])
    parts.append(loop(_even(collar, 0.04), 1.1 * radius, np.array([0.0, 0.0, 1.0])))
    rail = _rail(outline, directions, radius, base, share)
    return Head(parts=[*parts, *([rail] if rail is not None else [])], base=base, bottom=base - 1.1 * radius)


def _claw(outline: Outline, angle: float, radius: float, base: float, share: float) -> PlainMesh:
    """Return a claw that faces a direction [rad]."""
    out = np.array([np.cos(angle), np.sin(angle)])
    aside = np.array([-out[1], out[0]])
    contact = outline.support(angle)
    foot = outline.middle + share * (contact - outline.middle)
    bend = _bend(outline, out, radius, np.array([foot @ out, base]), over=1.7 * radius)
    path = np.column_stack([bend[:, :1] * out + (contact @ aside) * aside, bend[:, 1]])
    path = np.concatenate([[[*foot, base]], path])
    # The last radius of the way narrows to a round tip
    length = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))]
    wanted = np.unique(np.r_[length, length[-1] - radius * (1 - np.sin(np.radians(np.arange(0, 91, 15))))])
    path = np.stack([np.interp(wanted, length, x) for x in path.T], axis=1)
    to_tip = np.clip((wanted[-1] - wanted) / radius, 0.0, 1.0)
    return wire(path, radius * np.sqrt(1 - (1 - to_tip) ** 2), np.array([*aside, 0.0]))


def _bend(outline: Outline, out: np.ndarray, radius: float, foot: np.ndarray, over: float) -> np.ndarray:
    """Return the way of a claw from where it leaves the straight line to its foot, (n, 2): outwards, height.

    It follows the stone's silhouette at a distance, from the side of the girdle to over the crown.
    """
    from scipy.spatial import ConvexHull

    seen = np.column_stack([outline.vertices[:, :2] @ out, outline.vertices[:, 2]])
    hull = seen[ConvexHull(seen).vertices]
    along = np.roll(hull, -1, axis=0) - hull
    after = np.arctan2(-along[:, 0], along[:, 1])
    before = np.roll(after, 1)
    turn = np.mod(after - before, 2 * np.pi)
    step = np.radians(_STEP_DEG)
    far = (radius + GAP) / np.cos(0.5 * step)  # so that what is straight between is no nearer
    way = []
    for k in np.roll(np.arange(len(hull)), -int(np.argmin(before))):  # from what faces in, below and up
        n = max(2, int(np.ceil(turn[k] / step)) + 1)
        for facing in before[k] + np.linspace(0.0, turn[k], n):
            way.append((facing, *(hull[k] + far * np.array([np.cos(facing), np.sin(facing)]))))
    facing, path = np.array(way)[:, 0], np.array(way)[:, 1:]
    # The straight part leaves where it runs along the plane that touches the stone there, or away from it
    clear = (foot[0] - path[:, 0]) * np.cos(facing) + (foot[1] - path[:, 1]) * np.sin(facing) >= 0
    first = int(np.flatnonzero(clear & (facing < 0))[-1])
    girdle = float(hull[:, 0].max())
    beyond = (path[:, 0] < girdle + far - over - radius) & (facing > 0)
    last = int(np.flatnonzero(beyond)[0]) if beyond.any() else len(path) - 1
    way_up = path[first : last + 1]
    if beyond.any():  # cut where it is far enough over the crown
        a, b = way_up[-2], way_up[-1]
        t = (girdle + far - over - radius - a[0]) / (b[0] - a[0])
        way_up[-1] = a + min(max(t, 0.0), 1.0) * (b - a)
    keep = np.r_[True, np.linalg.norm(np.diff(way_up, axis=0), axis=1) > 1e-9]
    return np.asarray(way_up[keep])


def _rail(
    outline: Outline, directions: list[float], radius: float, base: float, share: float
) -> PlainMesh | None:
    """Return a rail that joins the claws half way up, or None where the stone leaves no room for it."""
    low, _ = outline.girdle
    thin = 0.6 * radius
    height = base + 0.45 * (low - base)
    contacts = np.array([outline.support(angle) - outline.middle for angle in directions])
    size = np.linalg.norm(contacts, axis=1)
    scale = float((share + 0.45 * (1 + (radius + GAP) / size - share)).min())
    widest = 1 - outline.widest_slope() * (low - height - thin)
    if (scale - widest) * outline.inradius < thin + GAP + _SAGITTA:
        return None
    corners, _ = _rounded(outline, 0.0)
    path = np.column_stack(
        [outline.middle + scale * (corners - outline.middle), np.full(len(corners), height)]
    )
    return loop(_even(path, 0.04), thin, np.array([0.0, 0.0, 1.0]))


# ---- Rims ----------------------------------------------------------------------------------------------


def rim(outline: Outline, wall: float) -> Head:
    """Return a rim around the girdle, with a lip over the crown's edge, that narrows to its lower end.

    Parameters
    ----------
    outline : Outline
        The stone.
    wall : float
        Its thickness [girdle radius].
    """
    low, _ = outline.girdle
    base = min(outline.bottom - 0.5 * wall - _CLEAR, low - 0.5)
    slope = min(0.95 * outline.widest_slope(), 0.5 / (low - base))
    share = 1 - slope * (low - base)
    corners, facing = _rounded(outline, GAP)
    beside = corners - outline.middle
    out = np.column_stack([np.cos(facing), np.sin(facing)])
    lip = outline.height_beyond(1 - _LIP) + GAP

    def row(scale: float, off: float, height: float) -> np.ndarray:
        # At a corner the offset goes along the corner's bisector, so that all rows have the same corners
        flat = outline.middle + scale * beside + off * out
        return np.column_stack([flat, np.full(len(flat), height)])

    rows = [
        row(share, 0.0, base),
        row(1.0, 0.0, low),
        row(1.0, 0.0, lip),
        row(1 - _LIP, 0.0, lip),
        row(1 - _LIP, 0.15 * wall, lip + 0.22 * wall),
        row(1.0, 0.35 * wall, lip + 0.3 * wall),
        row(1.0, 0.75 * wall, lip + 0.12 * wall),
        row(1.0, wall, lip - 0.25 * wall),
        row(1.0, wall, low),
        row(share, wall, base),
    ]
    return Head(parts=[profile_ring(np.stack(rows, axis=1))], base=base, bottom=base)


# ---- Outlines as paths ---------------------------------------------------------------------------------


def _rounded(outline: Outline, off: float) -> tuple[np.ndarray, np.ndarray]:
    """Return an outline moved outwards, rounded at its corners: points (n, 2), where they face, (n,) [rad].

    No point of it, nor of the straight pieces between, is nearer to the outline than `off`.
    """
    points, faces = [], []
    step = np.radians(_STEP_DEG)
    for corner, after, turn in zip(outline.points, outline.edge_angles, outline.turns, strict=True):
        n = 1 if turn < 0.25 * step else max(2, int(np.ceil(turn / step)) + 1)
        spread = np.array([0.5]) if n == 1 else np.linspace(0.0, 1.0, n)
        half = 0.5 * turn / max(n - 1, 1)
        for facing in after - turn + turn * spread:
            points.append(corner + off / np.cos(half) * np.array([np.cos(facing), np.sin(facing)]))
            faces.append(facing)
    return np.array(points), np.array(faces)


def _even(path: np.ndarray, step: float) -> np.ndarray:
    """Return a closed path (n, 3) in about even steps: a wire along it has no narrow places."""
    closed = np.concatenate([path, path[:1]])
    apart = np.linalg.norm(np.diff(closed, axis=0), axis=1)
    length = np.r_[0.0, np.cumsum(apart)]
    keep = np.r_[True, apart > 1e-9]
    n = max(24, int(np.ceil(length[-1] / step)))
    wanted = length[-1] * np.arange(n) / n
    return np.stack([np.interp(wanted, length[keep], x) for x in closed[keep].T], axis=1)

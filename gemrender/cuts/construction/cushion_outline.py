"""The outline of cushions: four sides that bow out, and four round corners, all arcs; analytic."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.cuts.construction.brilliant import Girdle
from gemrender.cuts.construction.outlines import PIECES
from gemrender.errors import InputError

__all__ = ["cushion"]


def cushion(half_width: Any, half_length: Any, *, bulge: Any, corner: Any, pieces: int = PIECES) -> Girdle:
    """Return a cushion, with 16 girdle points: middles of sides and corners, and where these meet.

    Parameters
    ----------
    half_width, half_length : number
        Half of its sides, along x and y.
    bulge : number
        How far sides bow out: the height of an arc over a straight line as long as the stone there [share of
        that length]; 0.5 makes a circle of a square stone.
    corner : number
        Radius of the corners, which go over into the sides without a bend.
    pieces : int
        Facets of the girdle between two girdle points, equally long.

    Raises
    ------
    InputError
        The corners are rounder than there is room for between such sides.
    """
    ends, sides = (_radius(half, bulge) for half in (half_width, half_length))
    above, beside = half_length - ends, half_width - sides
    middle = _centre(above, beside, ends - corner, sides - corner)
    x, y = middle
    first, last = np.arctan(x / (y - above)), np.pi / 2 - np.arctan(y / (x - beside))
    if not 0 < np.real(first) < np.real(last) < np.pi / 2:  # true for NaN too
        raise InputError("these make no cushion: the corners are rounder than the sides leave room for")
    steps = np.arange(pieces) / pieces
    end, side = np.array([0.0 * x, above]), np.array([beside, 0.0 * x])
    half, quarter_turn = 0.5 * (first + last), 0.0 * last + np.pi / 2
    arcs = ((end, ends, 0.0 * x, first), (middle, corner, first, half),
            (middle, corner, half, last), (side, sides, last, quarter_turn))  # fmt: skip
    turns = np.concatenate([begin + steps * (to - begin) for _, _, begin, to in arcs] + [[quarter_turn]])
    normals = np.stack([np.sin(turns), np.cos(turns)], axis=1)
    normals[0], normals[-1] = (0.0, 1.0), (1.0, 0.0)  # exact on the axes
    on = [*np.repeat(np.arange(4), pieces).tolist(), 3]
    centres, radii = np.array([arcs[k][0] for k in on]), np.array([arcs[k][1] for k in on])
    quarter = centres + radii[:, None] * normals
    # Anticlockwise from +y: the quarters at -x +y, -x -y, +x -y, +x +y.
    whole, facing = (
        np.concatenate(
            [
                part[:-1] * [-1, 1],
                part[:0:-1] * [-1, -1],
                part[:-1] * [1, -1],
                part[:0:-1],
            ]
        )
        for part in (quarter, normals)
    )
    facing = facing[::pieces]
    return Girdle(whole.reshape(16, pieces, 2), np.stack([-facing[:, 1], facing[:, 0]], axis=1))


def _radius(half: Any, bulge: Any) -> Any:
    """Return the radius of an arc over a straight line of this half length."""
    height = 2.0 * half * bulge
    return (half * half + height * height) / (2.0 * height)


def _centre(above: Any, beside: Any, from_end: Any, from_side: Any) -> np.ndarray:
    """Return the centre of the corner at +x +y, (2,), so far from the centres of end and side.

    Those lie at (0, above) and (beside, 0). NaN if there is no such corner.
    """
    apart = above * above + beside * beside
    along = (from_end * from_end - from_side * from_side + apart) / (2.0 * apart)
    across = from_end * from_end / apart - along * along
    if not (np.real(across) > 0 and np.real(from_end) > 0 and np.real(from_side) > 0):
        return np.full(2, np.nan)
    # Of the two such points that which lies further out from the line between the centres.
    out = -np.sqrt(across)
    return np.array([along * beside + out * above, (1.0 - along) * above + out * beside])

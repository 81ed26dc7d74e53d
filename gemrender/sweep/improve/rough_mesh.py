"""Rough given as a closed mesh, and the largest stone of a shape that it holds.

In convex rough the largest scale at one turn is a linear programme in scale and position: for each plane
n . x <= d of the rough, s h(n) + n . t <= d, with h the stone's support in its direction; as of the largest
sphere in a polyhedron (Boyd & Vandenberghe, Convex Optimization (2004), 8.5.1). Of rough that is not convex
the part is used that lies deeper below its hull than any dent.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.cuts.surface import closed_surface
from gemrender.errors import InputError
from gemrender.sweep.improve.rough import Rough, check_side

__all__ = ["MeshRough"]

#: Turns at which a linear programme is solved first, and how many of the best are made finer.
_TURNS, _FINER = 24, 2
#: Turns are told to this [deg].
_TURN_DEG = 1e-4


class MeshRough(Rough):
    """A closed surface, of which a convex part is used.

    Parameters
    ----------
    name : str
        What to call it.
    vertices, triangles : (v, 3) float64, (f, 3) int64
        The surface [mm]; the stone's axis will be along z.

    Raises
    ------
    InputError
        It is open (says where), or so far from convex that nothing is left of it.
    """

    def __init__(self, name: str, vertices: np.ndarray, triangles: np.ndarray) -> None:
        surface = closed_surface(vertices, triangles)
        for side in np.ptp(surface.vertices, axis=0).tolist():
            check_side(side)
        corners = surface.vertices[surface.triangles]
        a, b, c = corners.transpose(1, 0, 2)
        self.name = name
        self.volume_mm3 = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0
        self._planes = _hull(surface.vertices)
        if not surface.is_convex:
            depth = _deepest_dent(self._planes, corners)
            self._planes[:, 3] -= depth
            self.note = f"{name} is not convex: what lies {depth:.3g} mm inside its hull is used"

    def largest(self, points: np.ndarray, fold: int) -> tuple[float, float]:
        """Return scale and turn [deg] of the largest copy of points (n, 3) that was found.

        The scale has several largest values over the turns; the best of some even turns are made finer.
        """
        from scipy.optimize import minimize_scalar

        period = 360.0 / fold
        turns = np.arange(_TURNS) * (period / _TURNS)
        scales = np.array([self._scale(points, turn) for turn in turns.tolist()])
        best, at = float(scales.max()), float(turns[scales.argmax()])
        for turn in turns[np.argsort(-scales)[:_FINER]].tolist():
            near = period / _TURNS
            found = minimize_scalar(
                lambda angle: -self._scale(points, float(angle)),
                bounds=(turn - near, turn + near), method="bounded", options={"xatol": _TURN_DEG},
            )  # fmt: skip
            if -found.fun > best:
                best, at = -float(found.fun), float(found.x)
        return best, at

    def _scale(self, points: np.ndarray, turn_deg: float) -> float:
        """Return the largest scale at which points (n, 3) fit, turned so far about z."""
        from scipy.optimize import linprog

        planes = self._planes
        angle = np.radians(turn_deg)
        turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
        support = (planes[:, :3] @ (turn @ points.T)).max(axis=1)
        found = linprog(
            [-1.0, 0.0, 0.0, 0.0],
            A_ub=np.column_stack([support, planes[:, :3]]),
            b_ub=planes[:, 3],
            bounds=[(0.0, None)] + [(None, None)] * 3,
        )
        return float(found.x[0]) if found.status == 0 else 0.0

    def to_dict(self) -> dict[str, Any]:
        """Return what it is, of JSON's types."""
        return {"mesh": self.name, "planes_mm": self._planes.tolist()}


def _hull(vertices: np.ndarray) -> np.ndarray:
    """Return the planes of a convex hull, (p, 4): n . x <= d."""
    from scipy.spatial import ConvexHull

    size = float(np.ptp(vertices, axis=0).max())
    equations = ConvexHull(vertices).equations * [1.0, 1.0, 1.0, 1.0 / size]
    _, first = np.unique(np.round(equations, 9), axis=0, return_index=True)
    return np.asarray(equations[first] * [1.0, 1.0, 1.0, -size])


def _deepest_dent(hull: np.ndarray, corners: np.ndarray) -> float:
    """Return a depth below the hull's planes (p, 4) beyond which a surface (f, 3, 3) has no dent.

    Depth is concave, so that from any point of a dent it grows on the way to the hull's deepest point; if
    that is within the surface, the way passes the surface: its deepest point is as deep as any dent.

    Raises
    ------
    InputError
        The hull's deepest point is not within the surface.
    """
    from scipy.optimize import linprog

    found = linprog(
        [0.0, 0.0, 0.0, -1.0],
        A_ub=np.column_stack([hull[:, :3], np.ones(len(hull))]),
        b_ub=hull[:, 3],
        bounds=[(None, None)] * 3 + [(0.0, None)],
    )
    middle, most = found.x[:3], float(found.x[3])
    deepest = 0.0
    part = max(1, 5_000_000 // len(hull))
    for start in range(0, len(corners), part):
        own = corners[start : start + part]
        depths = hull[:, 3] - own @ hull[:, :3].T  # (f, 3, p)
        deepest = max(deepest, float(depths.max(axis=1).min(axis=1).max()))
    a, b, c = (corners - middle).transpose(1, 0, 2)
    la, lb, lc = (np.linalg.norm(of, axis=1) for of in (a, b, c))
    dot = np.einsum
    # Solid angles: van Oosterom & Strackee, IEEE Trans. Biomed. Eng. 30, 125 (1983).
    below = (
        la * lb * lc + dot("ij,ij->i", a, b) * lc + dot("ij,ij->i", b, c) * la + dot("ij,ij->i", c, a) * lb
    )
    turns = 2.0 * np.arctan2(dot("ij,ij->i", a, np.cross(b, c)), below).sum() / (4.0 * np.pi)
    if turns < 0.5 or deepest >= most:
        raise InputError("is too far from convex: nothing is left of it below its deepest dent", key="rough")
    return deepest

"""What 57 vertices must satisfy to be a round brilliant; says which vertex or facet does not."""

from __future__ import annotations

import numpy as np

from gemrender.cuts.round_brilliant.topology import (
    CONTACT,
    CULET,
    FACET_NAMES,
    GIRDLE_LOWER,
    GIRDLE_UPPER,
    IS_CROWN,
    N_VERTICES,
    STAR_TIP,
    TABLE_CORNER,
    TRIANGLE_FACET,
    TRIANGLES,
    VERTEX_LABELS,
)
from gemrender.errors import InputError

__all__ = ["check_vertices"]

#: Largest coordinate of a vertex [girdle radius]: rays start further away than that.
FARTHEST = 5.0
#: Radius of every girdle vertex [girdle radius]: beyond, the outline is not that of a round stone.
GIRDLE_RADII = (0.8, 1.25)
#: An edge may be hollow by at most this angle [deg]. Vertices measured to 0.1 % of the diameter bend narrow
#: facets by up to 15 deg; two exchanged vertices by more.
MOST_HOLLOW_DEG = 15.0
#: Crown facets face up and pavilion facets down at least this much (cosine to the axis).
LEAST_FACING = 1e-3
#: Smallest area of a triangle [girdle radius^2]: below, single precision loses the facet.
LEAST_AREA = 1e-7

_KEY = "vertices"
_RINGS = {"table": TABLE_CORNER, "star": STAR_TIP, "girdle_upper": GIRDLE_UPPER,
          "girdle_lower": GIRDLE_LOWER, "contact": CONTACT}  # fmt: skip


def check_vertices(v: np.ndarray) -> None:
    """Refuse vertices, in the paper's frame, that are not those of a round brilliant.

    Parameters
    ----------
    v : (57, 3) float64
        Vertices [girdle radius].

    Raises
    ------
    InputError
        With the first vertex or facet that is wrong, and what is wrong with it.
    """
    if v.shape != (N_VERTICES, 3):
        raise InputError(f"must have shape ({N_VERTICES}, 3), got {v.shape}", key=_KEY)
    finite = np.isfinite(v).all(axis=1)
    if not finite.all():
        raise _at(int(np.argmin(finite)), "must be finite numbers")
    far = np.abs(v).max(axis=1) > FARTHEST
    if far.any():
        raise _at(int(np.argmax(far)), f"must lie within {FARTHEST:g} girdle radii of the girdle's centre")
    if v[TABLE_CORNER, 2].mean() < v[CULET, 2]:
        raise InputError("the stone is upside down: the table must lie above the culet", key=_KEY)
    _check_order(v)
    _check_heights(v)
    _check_outline(v)
    _check_faces(v)


def _check_order(v: np.ndarray) -> None:
    azimuth = np.arctan2(v[:, 1], v[:, 0])
    for name, ring in _RINGS.items():
        steps = np.diff(azimuth[ring], append=azimuth[ring[0]])
        steps = (steps + np.pi) % (2 * np.pi) - np.pi  # to (-pi, pi]
        if (steps > 0).all() and abs(steps.sum() - 2 * np.pi) < 1e-6:
            continue
        if (steps < 0).all() and abs(steps.sum() + 2 * np.pi) < 1e-6:
            raise InputError(
                f"the {name} vertices run clockwise: the stone is inside out; "
                "they must run anticlockwise seen from the table",
                key=_KEY,
            )
        wrong = int(np.argmax(steps <= 0)) if (steps <= 0).any() else 0
        raise _at(
            int(ring[(wrong + 1) % len(ring)]),
            f"out of order: the {len(ring)} {name} vertices must run anticlockwise seen from the table",
        )
    girdle = azimuth[GIRDLE_UPPER]
    for ring, beside in (
        (TABLE_CORNER, girdle[0::2]),
        (STAR_TIP, girdle[1::2]),
        (GIRDLE_LOWER, girdle),
        (CONTACT, girdle[1::2]),
    ):
        apart = np.abs((azimuth[ring] - beside + np.pi) % (2 * np.pi) - np.pi)
        worst = int(np.argmax(apart))
        if apart[worst] > np.pi / len(ring):  # nearer to the next girdle vertex of its kind
            raise _at(
                int(ring[worst]),
                f"out of order: lies {np.degrees(apart[worst]):.3g} deg beside its girdle vertex",
            )


def _check_heights(v: np.ndarray) -> None:
    z = v[:, 2]
    upper, lower = z[GIRDLE_UPPER], z[GIRDLE_LOWER]
    for ring in (TABLE_CORNER, STAR_TIP):
        low = ring[z[ring] <= upper.max()]
        if low.size:
            raise _at(int(low[0]), "must lie above the girdle")
    thin = np.flatnonzero(upper < lower)
    if thin.size:
        raise _at(int(GIRDLE_UPPER[thin[0]]), "must not lie below its lower girdle vertex")
    for ring in (CONTACT, np.array([CULET])):
        high = ring[z[ring] >= lower.min()]
        if high.size:
            raise _at(int(high[0]), "must lie below the girdle")


def _check_outline(v: np.ndarray) -> None:
    radius = np.hypot(v[:, 0], v[:, 1])
    low, high = GIRDLE_RADII
    for i in np.concatenate([GIRDLE_UPPER, GIRDLE_LOWER]):
        if not low <= radius[i] <= high:
            raise _at(
                int(i),
                f"radius must be from {low:g} to {high:g} of the mean girdle radius, got {radius[i]:.4g}",
            )


def _check_faces(v: np.ndarray) -> None:
    corners = v[TRIANGLES]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice_area = np.linalg.norm(cross, axis=1)
    names = [FACET_NAMES[f] for f in TRIANGLE_FACET]
    for i in np.flatnonzero(twice_area < 2 * LEAST_AREA).tolist():
        raise InputError(f"facet {names[i]} has no area: are its vertices in order?", key=_KEY)
    normals = cross / twice_area[:, None]
    crown = IS_CROWN[TRIANGLE_FACET]
    facing = np.where(crown, normals[:, 2], -normals[:, 2])
    for i in np.flatnonzero(facing < LEAST_FACING).tolist():
        side = "up" if crown[i] else "down"
        raise InputError(f"facet {names[i]} does not face {side}: are its vertices in order?", key=_KEY)

    # Hollow edges: how far the neighbour's third vertex rises above a triangle's plane, as an angle.
    a, b, i, j = _INNER_EDGES.T
    along = v[b] - v[a]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    sines = np.einsum("ij,ij->i", np.cross(normals[i], normals[j]), along)
    angles = np.degrees(np.arctan2(sines, np.einsum("ij,ij->i", normals[i], normals[j])))
    for k in np.flatnonzero(angles < -MOST_HOLLOW_DEG).tolist():
        one, other = names[i[k]], names[j[k]]
        raise InputError(
            f"the stone is hollow by {-angles[k]:.1f} deg at the edge {VERTEX_LABELS[a[k]]} - "
            f"{VERTEX_LABELS[b[k]]} ({one if one == other else f'{one} and {other}'}); at most "
            f"{MOST_HOLLOW_DEG:g} deg is allowed",
            key=_KEY,
        )


def _inner_edges() -> np.ndarray:
    """Return the edges between two triangles, (n, 4): both vertices, and the triangles on either side."""
    edges: dict[tuple[int, int], int] = {}
    for i, triangle in enumerate(TRIANGLES.tolist()):
        for k in range(3):
            edges[(triangle[k], triangle[(k + 1) % 3])] = i
    # Those of the girdle have one triangle only.
    return np.array([(a, b, i, edges[b, a]) for (a, b), i in edges.items() if i < edges.get((b, a), -1)])


_INNER_EDGES = _inner_edges()


def _at(vertex: int, allowed: str) -> InputError:
    return InputError(allowed, key=f"vertex {vertex + 1} ({VERTEX_LABELS[vertex]})")

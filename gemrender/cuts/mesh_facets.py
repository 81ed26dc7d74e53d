"""The facets of a closed surface: coplanar triangles, their planes, and which way the stone's axis lies."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from gemrender.cuts.design import MOST_FACETS
from gemrender.cuts.surface import Surface
from gemrender.errors import InputError
from gemrender.stone.facets import CROWN, GIRDLE, Facet, side_of

__all__ = ["UP", "MeshFacets", "facets_of", "find_up", "levelled", "named_facets", "turned_up"]

#: Directions that can be up.
UP = {
    "x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0),
    "-x": (-1.0, 0.0, 0.0), "-y": (0.0, -1.0, 0.0), "-z": (0.0, 0.0, -1.0),
}  # fmt: skip
#: Triangles that are smaller than this are slivers [share of the largest of their facet].
SLIVER = 1e-3
#: Largest z of a normal that is made level, or slant of one that is made upright, however small the facet;
#: and what rounding leaves of numbers of 64 bits.
MOST_LEVELLED, LAST_BITS = 0.05, 1e-12
#: Facets that may be the table, of the largest.
MOST_TABLES = 12
#: Sine of the largest angle between directions that are one.
ALIKE = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class MeshFacets:
    """The facets of a surface.

    Attributes
    ----------
    planes : (n, 4) float64
        Outward unit normals and offsets; of a facet that rounding makes uneven, the mean over its area.
    areas : (n,) float64
        Areas.
    middles : (n, 3) float64
        Centroids.
    reach : (n,) float64
        Largest distance of a corner from the centroid.
    facet : (f,) int64
        Facet of each triangle.
    """

    planes: np.ndarray
    areas: np.ndarray
    middles: np.ndarray
    reach: np.ndarray
    facet: np.ndarray


def facets_of(surface: Surface) -> MeshFacets:
    """Return the facets of a surface, the largest first.

    On a convex surface all triangles of one plane are one facet, on others those that hang together.

    Raises
    ------
    InputError
        A convex surface has more than `MOST_FACETS` facets.
    """
    vertices, triangles = surface.vertices, surface.triangles
    crosses = _crosses(vertices[triangles])
    doubled = np.linalg.norm(crosses, axis=1)
    grown = _grown_convex if surface.is_convex else _grown
    facet = grown(vertices, triangles, crosses, doubled, surface.near)
    # The planes are those of the file's own corners. Slivers, which may belong to a neighbour, have no say.
    crosses = _crosses(surface.corners)
    doubled = np.linalg.norm(crosses, axis=1)
    count = int(facet.max()) + 1
    largest = np.zeros(count)
    np.maximum.at(largest, facet, doubled)
    weight = np.where(doubled >= SLIVER * largest[facet], doubled, 0.0)
    total = np.column_stack([np.bincount(facet, crosses[:, k] * (weight > 0), count) for k in range(3)])
    length = np.linalg.norm(total, axis=1)
    normals = total / np.where(length > 0, length, 1.0)[:, None]
    weights = np.bincount(facet, weight, count)
    centres = surface.corners.mean(axis=1)
    moments = np.column_stack([np.bincount(facet, weight * centres[:, k], count) for k in range(3)])
    middles = moments / np.where(weights > 0, weights, 1.0)[:, None]
    reach = np.zeros(count)
    np.maximum.at(reach, facet, np.linalg.norm(surface.corners - middles[facet][:, None], axis=2).max(axis=1))
    planes = np.column_stack([normals, np.einsum("ij,ij->i", normals, middles)])
    return MeshFacets(planes, 0.5 * np.bincount(facet, doubled, count), middles, reach, facet)


def _crosses(corners: np.ndarray) -> np.ndarray:
    return np.asarray(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def find_up(surface: Surface, facets: MeshFacets) -> np.ndarray:
    """Return the direction of the stone's axis, table up, (3,) float64.

    The table is the largest facet whose normal sees the outline made by level facets, as those of a girdle
    are. Where there is none, up is the axis of coordinates, z before y before x, that does.
    """
    order = np.argsort(-facets.areas, kind="stable")
    candidates = [_on_axis(facets.planes[k, :3]) for k in order[:MOST_TABLES]]
    largest = float(facets.areas.max())
    sizes = [float(facets.areas[k]) / largest for k in order[:MOST_TABLES]]
    for axis in ("z", "y", "x", "-z", "-y", "-x"):
        candidates.append(np.array(UP[axis]))
        sizes.append(0.0)
    preference = [
        -sum((abs(u - np.array(UP[a])) < 1e-9).all() * w for a, w in (("z", 2), ("y", 1))) for u in candidates
    ]
    best = sorted(range(len(candidates)), key=lambda k: (-round(sizes[k], 6), preference[k], k))
    points = surface.vertices[np.unique(surface.triangles)]
    for k in best:
        if _sees_a_girdle(candidates[k], points, facets):
            return candidates[k]
    return candidates[best[0]]


def turned_up(up: np.ndarray) -> np.ndarray:
    """Return the rotation (3, 3) that takes a direction to +z, and the first axis across it to +x."""
    across = np.eye(3)[int(np.argmax(np.abs(up) < 0.9))]
    x = across - (across @ up) * up
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(up, x), up])


def named_facets(planes: np.ndarray, areas: np.ndarray) -> tuple[np.ndarray, tuple[Facet, ...]]:
    """Name the facets of a mesh by tiers: C (crown), G (girdle) and P (pavilion), T a table, K a culet facet.

    Facets of one tier have one angle and one distance from the axis's middle, up to what digits leave. The
    table comes first, then the crown's tiers from the girdle up, the girdle, the pavilion from the girdle
    down.

    Parameters
    ----------
    planes : (n, 4) float64
        In the stone's frame.
    areas : (n,) float64
        Areas.

    Returns
    -------
    ((n,) int64, tuple of Facet)
        The facets' order, and the facets in it.
    """
    sides = [side_of(z) for z in planes[:, 2].tolist()]
    angles = np.degrees(np.arctan2(np.hypot(planes[:, 0], planes[:, 1]), np.abs(planes[:, 2])))
    azimuths = np.degrees(np.arctan2(planes[:, 0], planes[:, 1])) % 360.0
    near_angle, near_offset = 0.01, 1e-4
    tiers: list[list[int]] = []
    for number in sorted(range(len(planes)), key=lambda k: (sides[k], -round(angles[k], 2), -areas[k])):
        for tier in reversed(tiers):
            first = tier[0]
            if sides[first] != sides[number] or abs(angles[first] - angles[number]) > 2 * near_angle:
                continue
            if abs(angles[first] - angles[number]) <= near_angle and (
                abs(planes[first, 3] - planes[number, 3]) <= near_offset
            ):
                tier.append(number)
                break
        else:
            tiers.append([number])
    counts: Counter[str] = Counter()
    named = []
    for tier in tiers:
        side = sides[tier[0]]
        letter = {CROWN: "C", GIRDLE: "G"}.get(side, "P")
        if len(tier) == 1 and np.hypot(*planes[tier[0], :2]) <= ALIKE:
            letter = "T" if side == CROWN else "K"
            counts[letter] += 1
            kind = letter if counts[letter] == 1 else f"{letter}{counts[letter]}"
        else:
            counts[letter] += 1
            kind = f"{letter}{counts[letter]}"
        # Round the stone as the index runs; a facet at the north but for rounding is the first.
        around = sorted(tier, key=lambda k: round((azimuths[k] + 0.001) % 360.0, 3))
        for place, number in enumerate(around, start=1):
            name = kind if len(tier) == 1 else f"{kind}_{place}"
            named.append((kind != "T", number, Facet(name, kind, side)))
    named.sort(key=lambda row: row[0])  # stable
    return np.array([number for _, number, _ in named]), tuple(facet for _, _, facet in named)


def levelled(planes: np.ndarray, middles: np.ndarray, reach: np.ndarray, near: float) -> np.ndarray:
    """Return planes (n, 4), of which those upright or level but for `near` at their ends are exactly so.

    Parameters
    ----------
    planes : (n, 4) float64
        Outward unit normals and offsets, z up.
    middles, reach : (n, 3) and (n,) float64
        Centroid of each facet, and the largest distance of a corner from it.
    near : float
        Distance that is rounding.
    """
    planes = planes.copy()
    rise, lean = np.abs(planes[:, 2]), np.hypot(planes[:, 0], planes[:, 1])
    upright = (rise * reach <= near) & (rise < MOST_LEVELLED)
    flat = (lean * reach <= near) & (lean < MOST_LEVELLED)
    # What is so to the last bits keeps them.
    changed = (upright & (rise > LAST_BITS)) | (flat & (lean > LAST_BITS))
    planes[upright, 2] = 0.0
    planes[flat, :2] = 0.0
    planes[:, :3] /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    planes[changed, 3] = np.einsum("ij,ij->i", planes[changed, :3], middles[changed])
    return planes


# ---- Growing facets ------------------------------------------------------------------------------------


def _grown_convex(
    vertices: np.ndarray, triangles: np.ndarray, crosses: np.ndarray, doubled: np.ndarray, near: float
) -> np.ndarray:
    """Return the facet of each triangle: all that lie in the plane of the largest that is left are one."""
    facet = np.full(len(triangles), -1)
    count = 0
    for seed in np.argsort(-doubled, kind="stable"):
        if facet[seed] >= 0:
            continue
        if count > MOST_FACETS:
            raise InputError(f"has more than {MOST_FACETS} flat facets")
        if doubled[seed] <= 0:  # a line: it lies in any plane through it
            facet[seed] = 0
            continue
        normal = crosses[seed] / doubled[seed]
        along = vertices @ normal
        on = np.abs(along - along[triangles[seed]].mean()) <= near
        facet[on[triangles].all(axis=1) & (facet < 0)] = count
        facet[seed] = count
        count += 1
    return facet


def _grown(
    vertices: np.ndarray, triangles: np.ndarray, crosses: np.ndarray, doubled: np.ndarray, near: float
) -> np.ndarray:
    """Return the facet of each triangle: from the largest that is left to neighbours in its plane."""
    start, end = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    pair = np.column_stack([np.minimum(start, end), np.maximum(start, end)])
    edge = np.unique(pair, axis=0, return_inverse=True)[1].reshape(-1)
    inner = np.argsort(edge, kind="stable").reshape(-1, 2)  # closed: two half edges an edge
    other = np.empty(len(edge), dtype=np.int64)
    other[inner[:, 0]], other[inner[:, 1]] = inner[:, 1] // 3, inner[:, 0] // 3
    across = other.reshape(-1, 3)
    facet = np.full(len(triangles), -1)
    count = 0
    for seed in np.argsort(-doubled, kind="stable").tolist():
        if facet[seed] >= 0:
            continue
        normal = crosses[seed] / (doubled[seed] or 1.0)
        offset = float(normal @ vertices[triangles[seed]].mean(axis=0))
        facet[seed] = count
        stack = [seed]
        while stack:
            for there in across[stack.pop()].tolist():
                if facet[there] < 0 and crosses[there] @ normal >= 0:
                    off = vertices[triangles[there]] @ normal - offset
                    if np.abs(off).max() <= near:
                        facet[there] = count
                        stack.append(there)
        count += 1
    return facet


# ---- Which way is up -----------------------------------------------------------------------------------


def _on_axis(direction: np.ndarray) -> np.ndarray:
    """Return the axis of coordinates that a direction is but for rounding, else the direction."""
    nearest = np.zeros(3)
    k = int(np.abs(direction).argmax())
    nearest[k] = np.sign(direction[k])
    return nearest if np.linalg.norm(direction - nearest) <= ALIKE else direction


def _sees_a_girdle(up: np.ndarray, points: np.ndarray, facets: MeshFacets) -> bool:
    """Whether the outline seen along a direction is made by facets that are level when it is up."""
    from scipy.spatial import ConvexHull, QhullError

    turn = turned_up(up)
    try:
        outline = ConvexHull((points @ turn.T)[:, :2])
    except QhullError:
        return False
    turned = facets.planes[:, :3] @ turn.T
    walls = turned[(np.abs(turned[:, 2]) <= 10 * ALIKE) & (facets.areas > 0)]
    if not len(walls):
        return False
    a, b = (outline.points[outline.simplices[:, k]] for k in (0, 1))
    length = np.linalg.norm(b - a, axis=1)
    facing = (outline.equations[:, :2] @ walls[:, :2].T).max(axis=1) > 1 - 1e-4
    return float(length[facing].sum()) > 0.98 * float(length.sum())

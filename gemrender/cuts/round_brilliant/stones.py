"""Round brilliants as stones: from proportions, or from 57 measured vertices."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.cuts.round_brilliant.checks import check_vertices
from gemrender.cuts.round_brilliant.planes import facet_planes
from gemrender.cuts.round_brilliant.topology import (
    FACET_KINDS,
    FACET_NAMES,
    FACET_POLYGONS,
    GIRDLE,
    GIRDLE_LOWER,
    GIRDLE_UPPER,
    IS_CROWN,
    LOWER_GIRDLE_FACETS,
    N_FACETS,
    N_VERTICES,
    TRIANGLE_FACET,
    TRIANGLES,
    UPPER_GIRDLE_FACETS,
)
from gemrender.errors import InputError
from gemrender.stone import ConvexSolid, Facet, MeshSolid, Stone, Symmetry
from gemrender.stone.planes import flat_facets

__all__ = ["FACETS", "SYMMETRY", "perfect_stone", "stone_from_vertices"]

#: Largest coordinate of a measured stone, and the reciprocal of its smallest radius [any unit]: the squares
#: of what they make are finite.
LARGEST = 1e50
#: Deviation from the paper's frame that is left alone [girdle radius]: rounding in a file's digits.
FRAME_TOLERANCE = 1e-9
#: Deviation of the girdle vertices from radius 1 that still counts as round [girdle radius]: rounding.
ROUND_TOLERANCE = 1e-12
#: Hollows as deep as this are rounding in a file's digits, and are traced as flat [girdle radius]: they move
#: no score by more than a few times as much.
HOLLOW = 1e-5
#: Level girdle facets of a measured stone between two neighbouring girdle vertices.
WALLS = 4

_STEP = np.pi / 8

#: The facets by their numbers; the girdle is the last.
FACETS = tuple(
    Facet(name, kind, "girdle" if i == GIRDLE else "crown" if IS_CROWN[i] else "pavilion")
    for i, (name, kind) in enumerate(zip(FACET_NAMES, FACET_KINDS, strict=True))
)


def _symmetry() -> Symmetry:
    """Eight mirror planes: facets of each kind stand in a ring, evenly, from azimuth 0 or half a step on."""
    first = {"star": 2, "bezel": 0, "upper_girdle": 1, "lower_girdle": 1, "pavilion_main": 0}
    images = np.tile(np.arange(N_FACETS), (8, 1))
    for kind, start in first.items():
        ring = np.flatnonzero(np.array(FACET_KINDS) == kind)
        apart = 32 // len(ring)  # azimuths count half steps of pi/8
        azimuth = start + apart * np.arange(len(ring))
        for mirror in range(8):
            images[mirror, ring] = ring[(4 * mirror - azimuth - start) % 32 // apart]
    mirrors = _STEP * np.arange(8)
    return Symmetry(fold=8, mirrors=mirrors, centre=np.zeros(2), images=images)


#: The symmetry of a perfect brilliant.
SYMMETRY = _symmetry()
_OF_PLANES = np.arange(len(FACET_POLYGONS))


def perfect_stone(vertices: np.ndarray, **facts: Any) -> Stone:
    """Return the symmetric stone of 57 vertices in the paper's frame; `facts` are fields of `Stone`."""
    solid = ConvexSolid(planes=facet_planes(vertices), facet=_OF_PLANES, is_round=True)
    return Stone(
        solid=solid, facets=FACETS, labelled_vertices=vertices, **{"known_symmetry": SYMMETRY, **facts}
    )


def stone_from_vertices(
    vertices: np.ndarray,
    *,
    name: str = "stone",
    material: str | float | None = None,
    source: str | None = None,
) -> Stone:
    """Build a measured round brilliant from its 57 vertices, in any unit of length and with any origin.

    The z axis must be the stone's axis, table up. The vertices are moved and scaled to the paper's frame:
    girdle vertices centred on the axis with mean radius 1, mean height of the girdle's lower vertices 0.

    A facet that is not flat is cut into triangles. An outline that is not round becomes level girdle facets,
    four between two neighbouring vertices, of the same area as the outline whose radius is linear in azimuth.
    A stone with hollows deeper than rounding is a mesh.

    Parameters
    ----------
    vertices : (57, 3) array_like
        x, y, z in the order of `topology.VERTEX_LABELS`.
    name : str
        What to call the stone.
    material : str or float, optional
        Name of a gem material, or a refractive index; by default diamond.
    source : str, optional
        Where the stone came from, for error messages.

    Raises
    ------
    InputError
        Not 57 rows of 3 finite numbers, or no round brilliant in that order.
    """
    v = _to_paper_frame(vertices)
    check_vertices(v)
    facts: dict[str, Any] = {"name": name, "material": material, "source": source}
    planes = flat_facets(v, TRIANGLES, TRIANGLE_FACET, HOLLOW)
    new = np.ones(len(planes), dtype=bool)  # triangles of a flat facet have its very plane; neighbours here
    new[1:] = (planes[1:] != planes[:-1]).any(axis=1) | (TRIANGLE_FACET[1:] != TRIANGLE_FACET[:-1])
    planes, facet = planes[new], TRIANGLE_FACET[new]
    outline = np.concatenate([v[GIRDLE_UPPER], v[GIRDLE_LOWER]])[:, :2]
    is_round = bool((np.abs(np.hypot(*outline.T) - 1.0) <= ROUND_TOLERANCE).all())
    solid: ConvexSolid | MeshSolid
    if (v @ planes[:, :3].T > planes[:, 3] + HOLLOW).any():
        solid = _hollow(v)
    elif is_round:
        solid = ConvexSolid(planes=planes, facet=facet, is_round=True)
    else:
        walls = _walls(_outline(v))
        solid = ConvexSolid(
            planes=np.concatenate([planes, walls]),
            facet=np.concatenate([facet, np.full(len(walls), GIRDLE)]),
        )
    return Stone(solid=solid, facets=FACETS, labelled_vertices=v, **facts)


def _outline(v: np.ndarray) -> np.ndarray:
    """Return points of the outline, (16 WALLS, 2): radius linear in azimuth between vertices, area kept."""
    middle = 0.5 * (v[GIRDLE_UPPER] + v[GIRDLE_LOWER])
    azimuth = np.unwrap(np.arctan2(middle[:, 1], middle[:, 0]))
    radius = 0.5 * (np.hypot(*v[GIRDLE_UPPER, :2].T) + np.hypot(*v[GIRDLE_LOWER, :2].T))
    azimuth = np.append(azimuth, azimuth[0] + 2 * np.pi)
    radius = np.append(radius, radius[0])
    share = np.arange(16 * WALLS) / WALLS
    at, r = (np.interp(share, np.arange(17), values) for values in (azimuth, radius))
    points = r[:, None] * np.column_stack([np.cos(at), np.sin(at)])
    a, b = radius[:-1], radius[1:]
    area = (np.diff(azimuth) * (a * a + a * b + b * b)).sum() / 6  # of half the square of the radius
    return np.asarray(points * np.sqrt(area / _area(points)))


def _area(points: np.ndarray) -> float:
    (x, y), (u, w) = points.T, np.roll(points, -1, axis=0).T
    return 0.5 * float((x * w - u * y).sum())


def _walls(points: np.ndarray) -> np.ndarray:
    """Return level planes through neighbouring points of a convex outline, (k, 4)."""
    from scipy.spatial import ConvexHull

    points = points[
        ConvexHull(points).vertices
    ]  # anticlockwise; dents of a badly measured outline are filled
    along = np.roll(points, -1, axis=0) - points
    normals = np.column_stack([along[:, 1], -along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True)
    offsets = np.einsum("ij,ij->i", points, normals)
    return np.column_stack([normals, np.zeros(len(points)), offsets])


def _hollow(v: np.ndarray) -> MeshSolid:
    """Return a stone with hollows as a mesh; girdle facets go on beyond their chords in short pieces."""
    points = _outline(v)
    n = 16 * WALLS
    planes = facet_planes(v)
    rings = []
    for facets in (UPPER_GIRDLE_FACETS, LOWER_GIRDLE_FACETS):
        plane = np.repeat(planes[facets], WALLS, axis=0)
        before = np.roll(plane, 1, axis=0)
        # At a vertex both neighbouring facets end; their planes may differ a little there.
        heights = [(p[:, 3] - (p[:, :2] * points).sum(axis=1)) / p[:, 2] for p in (plane, before)]
        rings.append(0.5 * (heights[0] + heights[1]))
    # Where the girdle is thinner than its scallops both edges meet half way.
    crossed = rings[0] <= rings[1]
    upper, lower = (np.where(crossed, 0.5 * (rings[0] + rings[1]), ring) for ring in rings)
    vertices = np.concatenate([v, np.column_stack([points, upper]), np.column_stack([points, lower])])
    renumber = np.arange(N_VERTICES)
    renumber[GIRDLE_UPPER] = N_VERTICES + WALLS * np.arange(16)
    renumber[GIRDLE_LOWER] = N_VERTICES + n + WALLS * np.arange(16)
    triangles = [renumber[TRIANGLES]]
    facet = [TRIANGLE_FACET]
    k = np.arange(n)
    following = (k + 1) % n
    for ring, of_sector, turn in (
        (N_VERTICES, UPPER_GIRDLE_FACETS, 1),
        (N_VERTICES + n, LOWER_GIRDLE_FACETS, -1),
    ):
        for j in range(16):
            arc = ring + (WALLS * j + np.arange(WALLS + 1)) % n
            fan = np.column_stack([np.full(WALLS - 1, arc[0]), arc[1:-1], arc[2:]])
            triangles.append(fan[:, ::turn])
            facet.append(np.full(WALLS - 1, of_sector[j]))
    up, low = N_VERTICES + k, N_VERTICES + n + k
    up_next, low_next = N_VERTICES + following, N_VERTICES + n + following
    triangles += [np.column_stack([low, low_next, up_next]), np.column_stack([low, up_next, up])]
    facet.append(np.full(2 * n, GIRDLE))
    corners = np.concatenate(triangles)
    merged = np.arange(N_VERTICES + 2 * n)
    merged[N_VERTICES + n :] -= n * crossed  # one edge there, not two
    corners = merged[corners]
    real = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    used, faces = np.unique(corners[real], return_inverse=True)
    return MeshSolid(
        vertices=vertices[used], triangles=faces.reshape(-1, 3), facet=np.concatenate(facet)[real]
    )


def _to_paper_frame(vertices: np.ndarray) -> np.ndarray:
    try:
        v = np.array(vertices, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"must be {N_VERTICES} rows of three numbers", key="vertices") from error
    if v.shape != (N_VERTICES, 3):
        raise InputError(f"must have shape ({N_VERTICES}, 3), got {v.shape}", key="vertices")
    if not (np.abs(v) <= LARGEST).all():  # false for NaN too
        raise InputError(f"must be finite numbers of at most {LARGEST:g}", key="vertices")
    girdle = np.concatenate([v[GIRDLE_UPPER], v[GIRDLE_LOWER]])
    origin = np.array([*girdle[:, :2].mean(axis=0), v[GIRDLE_LOWER, 2].mean()])
    radius = float(np.hypot(*(girdle - origin)[:, :2].T).mean())
    if radius < 1 / LARGEST:
        raise InputError("all girdle vertices lie on the axis", key="vertices")
    if np.abs(origin).max() <= FRAME_TOLERANCE and abs(radius - 1) <= FRAME_TOLERANCE:
        return v
    return np.asarray((v - origin) / radius)

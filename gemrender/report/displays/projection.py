"""Views of a stone: parallel projections, and its edges with those that are hidden told apart."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gemrender.report.displays.occlusion import is_hidden, split_by_sight
from gemrender.stone import Stone, StoneMesh, tessellate

__all__ = [
    "CROWN",
    "OBLIQUE",
    "PAVILION",
    "Projection",
    "StoneView",
    "corners_of",
    "look_at",
    "section",
    "side",
]

#: Straight pieces of a round girdle in a drawing. Their sagitta, (pi / 256)^2 / 2 = 8e-5 girdle radii, is
#: less than a line is wide.
PIECES = 256
#: Corners closer to each other than this are drawn and counted as one, as they are meant: in designs angles
#: and distances are rounded, and facets that should meet in a point do so nearly [stone's unit].
ONE_CORNER = 3e-3
#: A face whose normal's component to the eye is not above this is seen edge on or from behind: rounding.
EDGE_ON = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Projection:
    """A parallel projection onto a page.

    Attributes
    ----------
    name : str
        What the view is called.
    right, up : (3,) float64
        Unit vectors of the page, in the stone's frame.
    """

    name: str
    right: np.ndarray
    up: np.ndarray

    @property
    def eye(self) -> np.ndarray:
        """(3,) unit vector to the eye."""
        return np.cross(self.right, self.up)

    def flat(self, points: np.ndarray) -> np.ndarray:
        """Return where points (..., 3) lie on the page, (..., 2) [stone's unit]."""
        return np.asarray(points @ np.stack([self.right, self.up], axis=-1))


def side(azimuth_deg: float = 0.0) -> Projection:
    """Return the view from the side with an azimuth [deg] to its right; by default a main is in profile."""
    azimuth = np.radians(azimuth_deg)
    right = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    return Projection(name="Side view", right=right, up=np.array([0.0, 0.0, 1.0]))


def _oblique(azimuth_deg: float, elevation_deg: float) -> Projection:
    level, elevation = side(azimuth_deg), np.radians(elevation_deg)
    up = level.up * np.cos(elevation) - level.eye * np.sin(elevation)
    return Projection(name="Oblique view", right=level.right, up=up)


#: The plan views, with x to the right as in the side view: above it and below it on a drawing (third angle).
CROWN = Projection(name="Crown view", right=np.array([1.0, 0.0, 0.0]), up=np.array([0.0, 1.0, 0.0]))
PAVILION = Projection(name="Pavilion view", right=np.array([1.0, 0.0, 0.0]), up=np.array([0.0, -1.0, 0.0]))
#: From above and the side, off every plane of symmetry.
OBLIQUE = _oblique(8.0, 28.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StoneView:
    """What is seen of a stone in a projection.

    Attributes
    ----------
    projection : Projection
    visible, outline, hidden : tuple of (n, 2) float64
        Edges between facets on the near side, where the near side ends, and on the far side [stone's unit].
    facets : tuple of int
        Visible facets, in ascending order; of a stone that is not convex the farthest first.
    polygons : tuple of (n, 2) float64
        The outline of each visible facet.
    corners : tuple of int
        Visible corners: their rows in `corners_of`.
    """

    projection: Projection
    visible: tuple[np.ndarray, ...]
    outline: tuple[np.ndarray, ...]
    hidden: tuple[np.ndarray, ...]
    facets: tuple[int, ...]
    polygons: tuple[np.ndarray, ...]
    corners: tuple[int, ...]


def look_at(stone: Stone, projection: Projection) -> StoneView:
    """Tell the visible edges and facets of a stone from the hidden ones.

    An edge is hidden if neither of its two faces is turned to the eye, or, where a stone is not convex,
    behind a face that is; edges are cut where that begins.
    """
    mesh = _mesh(stone)
    near = _face_normals(mesh) @ projection.eye > EDGE_ON
    ends, sides = _edges(stone)
    count = near[sides].sum(axis=1)
    pairs = np.sort(mesh.face_facet[sides], axis=1)
    drawn = (pairs[:, 0] != pairs[:, 1]) | (count == 1)  # not those within a facet
    chains: dict[str, dict[tuple[int, int], list[tuple[int, int]]]] = {
        kind: defaultdict(list) for kind in ("visible", "outline", "hidden")
    }
    kinds = ("hidden", "outline", "visible")
    for (a, b), (one, other), k in zip(
        ends[drawn].tolist(), pairs[drawn].tolist(), count[drawn].tolist(), strict=True
    ):
        chains[kinds[k]][one, other].append((a, b))

    flat = projection.flat(mesh.vertices)
    lines: dict[str, list[np.ndarray]] = {kind: [] for kind in chains}
    facets = np.unique(mesh.face_facet[near])
    seen = np.zeros(len(mesh.vertices), dtype=bool)
    seen[mesh.faces[near]] = True
    joined = {
        kind: [c for edges in groups.values() for c in _chains(edges)] for kind, groups in chains.items()
    }
    if stone.is_convex:
        lines = {kind: [flat[chain] for chain in chains_of] for kind, chains_of in joined.items()}
    else:
        points = np.column_stack([flat, mesh.vertices @ projection.eye])
        faces = points[mesh.faces[near]]
        for kind, chains_of in joined.items():
            for chain in chains_of:
                shown, behind = split_by_sight(points[chain], faces)
                lines[kind] += shown if kind != "hidden" else [*shown, *behind]
                lines["hidden"] += behind if kind != "hidden" else []
        seen &= ~is_hidden(points, faces)
        facets = _in_sight(mesh, near, faces)
    polygons = [flat[_boundary(mesh.faces[near & (mesh.face_facet == facet)])] for facet in facets]
    met, corner = _meetings(mesh)
    return StoneView(
        projection=projection,
        visible=tuple(lines["visible"]),
        outline=tuple(lines["outline"]),
        hidden=tuple(lines["hidden"]),
        facets=tuple(facets.tolist()),
        polygons=tuple(polygons),
        corners=tuple(np.unique(corner[seen[met]]).tolist()),
    )


def _in_sight(mesh: StoneMesh, near: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the facets that are not hidden at the middles of all their faces, the farthest first."""
    middles, facet = faces.mean(axis=1), mesh.face_facet[near]
    facets, number = np.unique(facet, return_inverse=True)
    shown = np.bincount(number, ~is_hidden(middles, faces)) > 0
    depth = np.bincount(number, middles[:, 2]) / np.bincount(number)
    order = np.argsort(depth, kind="stable")
    return np.asarray(facets[order][shown[order]])


def corners_of(stone: Stone) -> np.ndarray:
    """Return a stone's corners, (k, 3): where three facets meet and more."""
    mesh = _mesh(stone)
    met, corner = _meetings(mesh)
    count = np.bincount(corner)
    return np.column_stack([np.bincount(corner, mesh.vertices[met, k]) / count for k in range(3)])


def _meetings(mesh: StoneMesh) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices where three facets meet and more, (k,), and the corner that each makes (k,).

    Vertices along a round girdle's edges make none.
    """
    pairs = np.unique(np.column_stack([mesh.faces.reshape(-1), np.repeat(mesh.face_facet, 3)]), axis=0)
    met = np.flatnonzero(np.bincount(pairs[:, 0], minlength=len(mesh.vertices)) > 2)
    points = mesh.vertices[met]
    corner = np.full(len(met), -1)
    for number in range(len(met)):
        if corner[number] < 0:
            near = np.abs(points - points[number]).max(axis=1) <= ONE_CORNER
            corner[near & (corner < 0)] = number
    return met, np.unique(corner, return_inverse=True)[1].reshape(-1)


def section(stone: Stone, azimuth_deg: float) -> np.ndarray:
    """Return the outline of the stone's section through its axis along an azimuth [deg].

    Returns
    -------
    (n, 2) float64
        Distance along the azimuth, and height [stone's unit], in order around the section.
    """
    mesh = _mesh(stone)
    view = side(azimuth_deg)
    depth = mesh.vertices @ view.eye
    depth[np.abs(depth) < EDGE_ON] = 0.0
    ends, _ = _edges(stone)
    a, b = depth[ends].T
    crossing = a * b < 0
    start, end = mesh.vertices[ends[crossing]].transpose(1, 0, 2)
    share = (a[crossing] / (a[crossing] - b[crossing]))[:, None]
    points = np.concatenate([start + share * (end - start), mesh.vertices[depth == 0.0]])
    flat = view.flat(points)
    middle = flat.mean(axis=0)
    return np.asarray(flat[np.argsort(np.arctan2(*(flat - middle).T[::-1]))])


@lru_cache(maxsize=2)
def _mesh(stone: Stone) -> StoneMesh:
    """Tessellate a stone once for all views of a display."""
    return tessellate(stone, PIECES)


def _face_normals(mesh: StoneMesh) -> np.ndarray:
    """Return unit normals, (f, 3): those of the planes, and on the girdle those of the faces themselves."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    planar = np.abs(mesh.face_normals).sum(axis=1, keepdims=True) > 0
    return np.where(planar, mesh.face_normals, normals)


@lru_cache(maxsize=2)
def _edges(stone: Stone) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of each edge, (e, 2), the lower vertex first, and the faces left and right of it."""
    mesh = _mesh(stone)
    start, end = mesh.faces.reshape(-1), np.roll(mesh.faces, -1, axis=1).reshape(-1)
    face = np.repeat(np.arange(len(mesh.faces)), 3)
    up = start < end
    key = np.minimum(start, end) * len(mesh.vertices) + np.maximum(start, end)
    back = np.argsort(key[~up])
    right = face[~up][back][np.searchsorted(key[~up], key[up], sorter=back)]
    return np.column_stack([start[up], end[up]]), np.column_stack([face[up], right])


def _chains(edges: list[tuple[int, int]]) -> list[list[int]]:
    """Join edges to lines as long as possible; a closed line ends where it begins."""
    ends: dict[int, list[int]] = defaultdict(list)
    for a, b in edges:
        ends[a].append(b)
        ends[b].append(a)
    chains = []
    starts = [v for v, others in ends.items() if len(others) != 2] + list(ends)
    for start in starts:
        while ends[start]:
            chain = [start]
            while ends[chain[-1]]:
                following = ends[chain[-1]].pop()
                ends[following].remove(chain[-1])
                chain.append(following)
            chains.append(chain)
    return chains


def _boundary(faces: np.ndarray) -> list[int]:
    """Vertices around a patch of faces."""
    directed = {(a, b) for face in faces.tolist() for a, b in zip(face, (*face[1:], face[0]), strict=True)}
    return max(_chains([edge for edge in directed if edge[::-1] not in directed]), key=len)

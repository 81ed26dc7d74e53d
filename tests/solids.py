"""What every stone's mesh must satisfy, and the volume of a symmetric stone without its mesh."""

from __future__ import annotations

import math

import numpy as np

from gemrender.cuts import RoundBrilliant, bundled_stones, load_stone, stone_from_vertices
from gemrender.cuts.round_brilliant.topology import CULET
from gemrender.stone import Facet, MeshSolid, Stone, StoneMesh, side_of

#: Bundled round brilliants of 57 facets and a girdle, as the paper's proportions describe them.
BRILLIANTS = [name for name in bundled_stones() if load_stone(name).description in ("proportions", "angles")]
_STEP = math.pi / 8


def bent_stone(culet: float, *, name: str = "bent", stretched: float = 1.0) -> Stone:
    """Return a measured stone with its culet moved up by so much, and its x stretched [girdle radius].

    Lowered, the pavilion mains are bent outwards and the stone stays convex; raised, they are hollow.
    """
    vertices = load_stone("inoue-3").vertices.copy()
    vertices[CULET, 2] += culet
    vertices[:, 0] *= stretched
    return stone_from_vertices(vertices, name=name)


def star_outline(points: int = 5, inner: float = 0.45) -> np.ndarray:
    """Return the corners of a star about the origin, anticlockwise, (2 points, 2)."""
    turn = np.pi / 2 + np.pi / points * np.arange(2 * points)
    radius = np.where(np.arange(2 * points) % 2, inner, 1.0)[:, None]
    return radius * np.column_stack([np.cos(turn), np.sin(turn)])


def heart_outline(cleft: float = 0.3) -> np.ndarray:
    """Return the corners of a heart with a cleft, anticlockwise, (21, 2); all are seen from the origin."""
    turn = np.radians(np.linspace(-50, 130, 10))
    lobe = np.column_stack([0.45 + 0.5 * np.cos(turn), 0.25 + 0.5 * np.sin(turn)])
    left = lobe[::-1] * [-1, 1]
    return np.concatenate([lobe, [[0.0, cleft]], left, [[0.0, -0.95]]])


def lofted_stone(outline: np.ndarray, rings: list[tuple[float, float]], name: str) -> Stone:
    """Return a stone of rings of an outline, all of which is seen from the origin; convex only if that is.

    Parameters
    ----------
    outline : (n, 2) float64
        Corners, anticlockwise.
    rings : list of (scale, height)
        From the bottom up; a scale of 0 is a tip.
    """
    n = len(outline)
    k, after = np.arange(n), (np.arange(n) + 1) % n
    vertices = np.concatenate([np.column_stack([scale * outline, np.full(n, z)]) for scale, z in rings])
    bottom, top = len(vertices), len(vertices) + 1
    vertices = np.concatenate([vertices, [(0, 0, rings[0][1]), (0, 0, rings[-1][1])]])
    triangles, facet, count = [], [], 0
    for ring in range(len(rings) - 1):
        low, high = ring * n, (ring + 1) * n
        for side in ((low + k, low + after, high + after), (low + k, high + after, high + k)):
            triangles.append(np.column_stack(side))
            facet.append(count + k)
        count += n
    last = (len(rings) - 1) * n
    for tip, ends, scale in (
        (bottom, (after, k), rings[0][0]),
        (top, (last + k, last + after), rings[-1][0]),
    ):
        triangles.append(np.column_stack([np.full(n, tip), *ends]))
        facet.append(np.full(n, count))
        count += scale > 0
    faces, facet = np.concatenate(triangles), np.concatenate(facet)
    corners = vertices[faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    faces, facet = faces[area > 1e-12], np.unique(facet[area > 1e-12], return_inverse=True)[1]
    # The corners of a tip are one.
    places, number = np.unique(np.round(vertices, 12), axis=0, return_inverse=True)
    used, faces = np.unique(number.reshape(-1)[faces], return_inverse=True)
    solid = MeshSolid(vertices=places[used], triangles=faces.reshape(-1, 3), facet=facet)
    first = np.unique(facet, return_index=True)[1]
    facets = [Facet(f"f_{i}", "f", side_of(solid.planes[row, 2])) for i, row in enumerate(first)]
    return Stone(solid=solid, facets=tuple(facets), name=name)


def star_prism() -> Stone:
    """Return a prism over a star: five grooves with an angle of 144 degrees outside."""
    return lofted_stone(star_outline(), [(1.0, -0.25), (1.0, 0.25)], "star prism")


def cleft_heart() -> Stone:
    """Return a heart with a table, a girdle, a keel and a cleft that goes in from above to below."""
    return lofted_stone(heart_outline(), [(0.0, -0.7), (1.0, 0.0), (1.0, 0.06), (0.6, 0.3)], "cleft heart")


def assert_closed(mesh: StoneMesh) -> None:
    """Every edge is shared by exactly two faces, in opposite senses; one piece without holes."""
    faces = mesh.faces.astype(np.int64)
    n = len(mesh.vertices)
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    edges, opposite = np.sort(start * n + end), np.sort(end * n + start)
    assert (start != end).all()
    assert (np.diff(edges) > 0).all(), "an edge is used twice in one sense"
    assert (edges == opposite).all(), "an edge has no other side"
    assert len(np.unique(faces)) == n, "a vertex belongs to no face"
    assert n - len(edges) // 2 + len(faces) == 2, "Euler's characteristic of a ball"
    assert np.isfinite(mesh.vertices).all()
    assert np.isfinite(mesh.corner_normals).all()


def mesh_volume(mesh: StoneMesh) -> float:
    """Volume that the mesh encloses, by the divergence theorem [girdle radius^3]."""
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def heights(p: RoundBrilliant, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Top and bottom of the 57 half-spaces over points, from the proportions (docs/model.md, section 2).

    By symmetry the points are brought into the sector between azimuth 0, where a bezel main and a pavilion
    main lie, and pi/8, where a star tip lies. There the other facets of each kind are further out.
    """
    radius, azimuth = np.hypot(x, y), np.arctan2(y, x)
    azimuth = np.abs((azimuth + _STEP) % (2 * _STEP) - _STEP)  # to [0, pi/8]
    main, odd, sector = (radius * np.cos(azimuth - a) for a in (0.0, _STEP, _STEP / 2))

    r_t, crown, girdle, depth = (
        p.table / 100,
        p.crown_height / 50,
        p.girdle_thickness / 50,
        p.pavilion_depth / 50,
    )
    cos, half = math.cos(_STEP), math.cos(_STEP / 2)
    e = r_t * cos
    r_s, r_l = e + p.star / 100 * (1 - e), p.lower_girdle_contact / 100
    z_s = crown * (1 - r_s * cos) / (1 - r_t)  # of the star tips above the girdle
    z_l = depth * (1 - r_l * cos)  # of the contacts below it
    top = np.minimum.reduce(
        [
            np.full_like(radius, crown),
            crown - (crown - z_s) * (odd - e) / (r_s - e),
            crown * (1 - main) / (1 - r_t),
            z_s * (half - sector) / (half * (1 - r_s)),
        ]
    )
    bottom = np.maximum(-depth * (1 - main), -z_l * (half - sector) / (half * (1 - r_l)))
    return girdle + top, bottom


def half_space_volume(p: RoundBrilliant) -> float:
    """Volume of the half-spaces within the cylinder, by quadrature in polar coordinates [girdle radius^3]."""
    nodes, weights = np.polynomial.legendre.leggauss(48)
    azimuth = (nodes + 1) / 2 * _STEP
    steps = 2000
    radius = (np.arange(steps) + 0.5)[:, None] / steps
    top, bottom = heights(p, radius * np.cos(azimuth), radius * np.sin(azimuth))
    thickness = np.maximum(top - bottom, 0.0)  # nothing beyond where the planes of a thin girdle meet
    return float(16 * (thickness * radius / steps).sum(axis=0) @ weights * _STEP / 2)


def scalloped_volume(p: RoundBrilliant, polyhedron: float) -> float:
    """Volume of the stone in closed form, from that of the polyhedron of its 57 vertices.

    Over each of the 16 circular segments between a chord and its arc the height between the two girdle
    facets' planes is linear: the segment's area times the height at its centroid. Holds where the scallops
    do not cross.
    """
    area = (_STEP - math.sin(_STEP)) / 2
    centroid = 4 * math.sin(_STEP / 2) ** 3 / (3 * (_STEP - math.sin(_STEP)))
    x, y = centroid * math.cos(_STEP / 2), centroid * math.sin(_STEP / 2)
    top, bottom = heights(p, np.array([x]), np.array([y]))
    return polyhedron + 16 * area * float(top[0] - bottom[0])

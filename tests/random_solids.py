"""Random planes for property tests: about ellipsoids, nearly degenerate ones, and symmetric ones."""

from __future__ import annotations

from collections import Counter

import numpy as np

from gemrender.errors import InputError
from gemrender.stone import ConvexSolid, Facet, Stone, convex_solid, in_frame, side_of
from gemrender.stone.polyhedron import Polyhedron, intersect


def directions(rng: np.random.Generator, number: int) -> np.ndarray:
    """Unit vectors in any direction, (number, 3)."""
    vectors = rng.normal(size=(number, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def about_ellipsoid(rng: np.random.Generator, number: int, centre: float = 5.0) -> np.ndarray:
    """Planes that touch an ellipsoid of any shape and place, (number, 4); they close.

    Each half-space holds the whole ellipsoid; normals are drawn until they do not lie in one hemisphere.
    """
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0] * np.exp(rng.uniform(-1.0, 1.0, 3))
    middle = rng.uniform(-centre, centre, 3)
    while True:
        normals = directions(rng, number)
        planes = np.column_stack([normals, np.linalg.norm(normals @ axes, axis=1) + normals @ middle])
        try:
            intersect(planes)
        except InputError:
            continue
        return planes


def doubled(rng: np.random.Generator, planes: np.ndarray, apart: float) -> np.ndarray:
    """Planes, and some of them once more, turned and moved by so little."""
    again = planes[rng.integers(len(planes), size=len(planes) // 2)]
    normals = again[:, :3] + apart * rng.normal(size=(len(again), 3))
    lengths = np.linalg.norm(normals, axis=1)
    offsets = again[:, 3] + apart * rng.normal(size=len(again))
    return np.concatenate([planes, np.column_stack([normals / lengths[:, None], offsets])])


def with_culet(rng: np.random.Generator, number: int, culet: np.ndarray, apart: float) -> np.ndarray:
    """So many pavilion planes of any slope through the culet (3,), but for so little; walls and a table."""
    azimuth = np.sort(rng.uniform(0.0, 2 * np.pi, number)) + np.arange(number) * 2 * np.pi / number
    slope = np.radians(rng.uniform(20.0, 60.0, number))
    normals = np.column_stack(
        [np.sin(slope) * np.cos(azimuth), np.sin(slope) * np.sin(azimuth), -np.cos(slope)]
    )
    offsets = normals @ culet + apart * rng.normal(size=number)
    wall = np.arange(12) * (2 * np.pi / 12)
    walls = np.column_stack([np.cos(wall), np.sin(wall), np.zeros(12), np.ones(12)])
    return np.concatenate([np.column_stack([normals, offsets]), walls, [[0.0, 0.0, 1.0, 0.3]]])


def with_slivers(rng: np.random.Generator, planes: np.ndarray, depth: float) -> np.ndarray:
    """Planes, and some that cut a corner or an edge off by so little."""
    body = intersect(planes)
    out = [planes]
    for _ in range(12):
        polygon = body.polygon(int(rng.choice(np.flatnonzero(body.bounds))))
        cut = body.vertices[np.roll(polygon, rng.integers(len(polygon)))[: rng.integers(1, 3)]]
        at = (np.abs(cut @ planes[:, :3].T - planes[:, 3]) < 1e-8).all(axis=0)
        normal = rng.uniform(0.1, 1.0, int(at.sum())) @ planes[at, :3]
        normal /= np.linalg.norm(normal)
        out.append(np.append(normal, normal @ cut[0] - depth)[None])
    return np.concatenate(out)


def turned(planes: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Planes turned or mirrored about the origin by a matrix (2, 2) of x and y."""
    return np.column_stack([planes[:, :2] @ matrix.T, planes[:, 2:]])


def turn(angle: float) -> np.ndarray:
    """The matrix (2, 2) of a turn [rad]."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def mirror(azimuth: float) -> np.ndarray:
    """The matrix (2, 2) of a mirror plane at an azimuth [rad]."""
    return turn(2 * azimuth) @ np.diag([1.0, -1.0])


def symmetric(
    rng: np.random.Generator, fold: int, mirror_azimuth: float | None, rings: int, centre: np.ndarray
) -> np.ndarray:
    """Planes about an upright axis through a centre (2,): so many random ones, and all their images.

    Of neighbours in a ring one is never cut away by the others: all touch one ellipsoid of revolution.
    """
    rise = rng.uniform(-0.9, 0.9, rings)
    rise[:2] = -0.5, 0.5  # they close
    azimuth = rng.uniform(0.0, 2 * np.pi, rings)
    flat = np.sqrt(1 - rise**2)
    normals = np.column_stack([flat * np.cos(azimuth), flat * np.sin(azimuth), rise])
    planes = np.column_stack([normals, np.linalg.norm(normals * [1.0, 1.0, 0.7], axis=1)])
    if mirror_azimuth is not None:
        planes = np.concatenate([planes, turned(planes, mirror(mirror_azimuth))])
    planes = np.concatenate([turned(planes, turn(2 * np.pi * k / fold)) for k in range(fold)])
    planes = np.concatenate([planes, [[0.0, 0.0, 1.0, 0.65], [0.0, 0.0, -1.0, 0.68]]])
    planes[:, 3] += planes[:, :2] @ centre
    return planes


def solid_of(planes: np.ndarray) -> ConvexSolid:
    """The solid inside planes, one facet each."""
    return convex_solid(planes, np.arange(len(planes)))[0]


def stone_of(planes: np.ndarray, *, name: str = "random") -> Stone:
    """The stone inside planes, in its frame, without those that are cut away."""
    solid = solid_of(in_frame(planes)[0])
    facets = tuple(Facet(f"F{k}", "facet", side_of(plane[2])) for k, plane in enumerate(solid.planes))
    return Stone(solid=solid, facets=facets, name=name, material=1.76)


def assert_closed_and_convex(body: Polyhedron, tolerance: float) -> None:
    """Every edge joins two polygons; Euler's formula; corners lie on their planes, and inside all others.

    The tolerance is a share of the solid's size.
    """
    polygons = [body.polygon(k).tolist() for k in np.flatnonzero(body.bounds)]
    edges = Counter(edge for p in polygons for edge in zip(p, [*p[1:], p[0]], strict=True))
    assert set(edges.values()) == {1}, "an edge is used twice in one sense"
    assert all((b, a) in edges for a, b in edges), "an edge has no other side"
    assert all(len(set(p)) == len(p) for p in polygons), "a polygon meets itself"
    assert len(body.vertices) - len(edges) // 2 + len(polygons) == 2, "Euler's formula"
    assert set(body.corners.tolist()) == set(range(len(body.vertices)))

    near = tolerance * float(np.ptp(body.vertices, axis=0).max())
    beyond = body.vertices @ body.planes[:, :3].T - body.planes[:, 3]
    assert beyond.max() <= near, "a corner lies outside a plane"
    plane = np.repeat(np.arange(len(body.planes)), np.diff(body.starts))
    assert np.abs(beyond[body.corners, plane]).max() <= near, "a corner lies beside its plane"
    assert body.areas[body.bounds].min() >= -(near**2), "a polygon runs clockwise"

"""Points in solids and solids in solids, against boxes, balls and the separating axis theorem."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from meshes import box, soup, together, turned

from gemrender.scene.closed import closed_surface
from gemrender.scene.inside import Ball, Inside, overlap, reaches_into, winding_number

#: Sums of a dozen solid angles in float64.
EXACT = 1e-12
#: What touches, and what reaches into another.
TOUCHING, CLEAR = 1e-6, 1e-3

HOLLOW = together(box(), turned(box((0.5, 0.5, 0.5))))


def triangles(mesh):
    return closed_surface(*mesh).triangles


def known(mesh):
    """The inside of a convex mesh, by its planes."""
    inside = Inside.of(triangles(mesh))
    assert inside.known is not None
    return inside


def any_mesh(mesh):
    """The inside of a mesh, as of one that is not convex."""
    return Inside(triangles=triangles(mesh), known=None)


def rotation(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


# ---- Points --------------------------------------------------------------------------------------------


def test_a_surface_winds_once_around_what_is_inside(rng):
    points = rng.uniform(-2, 2, (500, 3))
    inside = (np.abs(points) < 1).all(axis=1)
    np.testing.assert_allclose(winding_number(points, triangles(box())), inside, rtol=0, atol=EXACT)


@pytest.mark.parametrize("kind", [known, any_mesh])
def test_depth_in_a_box_is_the_distance_of_its_nearest_wall(rng, kind):
    half = np.array([1.0, 0.7, 0.4])
    points = rng.uniform(-1.2, 1.2, (500, 3))
    expected = (half - np.abs(points)).min(axis=1)
    depth = kind(box(half)).depth(points)
    np.testing.assert_allclose(np.maximum(depth, 0), np.maximum(expected, 0), rtol=0, atol=EXACT)


def test_depth_in_a_hollow_box(rng):
    # Between two walls the nearer one counts, and in the hollow none
    points = rng.uniform(-1, 1, (500, 3))
    beyond = np.linalg.norm(np.maximum(np.abs(points) - 0.5, 0), axis=1)
    expected = np.minimum((1 - np.abs(points)).min(axis=1), beyond)
    solid = Inside.of(triangles(HOLLOW))
    assert solid.known is None
    np.testing.assert_allclose(solid.depth(points), expected, rtol=0, atol=EXACT)


def test_depth_in_a_ball():
    ball = Ball(centre=np.array([1.0, 0, 0]), radius=2.0)
    np.testing.assert_allclose(ball.depth(np.array([(1, 0, 0), (3, 0, 0), (1, 5, 0)])), [2, 0, -3])


def test_a_notched_mesh_is_not_convex():
    positions, faces = box()
    middle = np.vstack([positions, [0, 0, 0.5]])  # the top's middle, pushed in
    top = [(a, b, 8) for a, b in ((1, 5), (5, 7), (7, 3), (3, 1))]
    pushed = middle, np.concatenate([np.delete(faces, (10, 11), axis=0), top])
    solid = Inside.of(triangles(pushed))
    assert solid.known is None
    assert solid.depth(np.array([(0, 0, 0.6), (0, 0, 0.4)]))[0] == 0
    assert solid.depth(np.array([(0, 0, 0.6), (0, 0, 0.4)]))[1] > 0


def test_an_inner_point_is_inside():
    for mesh in (box((3, 0.1, 1)), HOLLOW, turned(box())):
        solid = any_mesh(mesh)
        assert solid.depth(solid.inner()[None])[0] > 0


# ---- Solids in solids ----------------------------------------------------------------------------------


def gap(one, other):
    """How far two boxes (half, centre, rotation) are apart, negative if they overlap.

    Gottschalk, Lin & Manocha, "OBBTree" (1996): two boxes are apart exactly if an axis separates them that is
    normal to a face of one of them, or to an edge of both.
    """
    (a, p, m), (b, q, n) = one, other
    axes = [*m.T, *n.T, *(np.cross(x, y) for x, y in product(m.T, n.T))]
    gaps = []
    for axis in axes:
        length = np.linalg.norm(axis)
        if length > 1e-6:
            u = axis / length
            gaps.append(abs((q - p) @ u) - np.abs(m.T @ u) @ a - np.abs(n.T @ u) @ b)
    return max(gaps)


@pytest.mark.parametrize("kind", [known, any_mesh])
def test_boxes_overlap_unless_an_axis_separates_them(rng, kind):
    counts = {True: 0, False: 0}
    while min(counts.values()) < 40:
        one, other = ((rng.uniform(0.05, 1, 3), rng.uniform(-0.8, 0.8, 3), rotation(rng)) for _ in range(2))
        apart = gap(one, other)
        if abs(apart) < CLEAR:
            continue
        assert overlap(kind(box(*one)), kind(box(*other)), TOUCHING) == (apart < 0)
        counts[apart < 0] += 1


@pytest.mark.parametrize("kind", [known, any_mesh])
@pytest.mark.parametrize(
    ("shift", "expected"),
    [
        ((2, 0, 0), False),  # face to face
        ((2, 0.5, 0.3), False),
        ((2, 2, 0), False),  # edge to edge
        ((2, 2, 2), False),  # corner to corner
        ((2 - 1e-4, 0.5, 0.3), True),
        ((1, 0, 0), True),  # all edges on the other's walls
        ((0, 0, 0), True),  # the same box twice
        ((1, 1, 0), True),
        ((0.1, 0.2, 0.3), True),
        ((3, 0, 0), False),
    ],
)
def test_what_touches_does_not_overlap(kind, shift, expected):
    assert overlap(kind(box()), kind(box(centre=shift)), 1e-5) == expected


@pytest.mark.parametrize("kind", [known, any_mesh])
def test_an_edge_through_a_face_is_an_overlap(kind):
    # No corner of either is inside the other
    assert overlap(kind(box((0.1, 0.1, 5))), kind(box((1, 1, 1))), TOUCHING)
    assert overlap(kind(box((0.1, 5, 0.1))), kind(box((5, 0.1, 0.1))), TOUCHING)


@pytest.mark.parametrize("kind", [known, any_mesh])
def test_a_box_in_a_box_is_an_overlap(kind):
    assert overlap(kind(box((0.2, 0.2, 0.2))), kind(box()), TOUCHING)


def test_a_box_in_a_hollow_is_none():
    hollow = any_mesh(HOLLOW)
    assert not overlap(any_mesh(box((0.2, 0.2, 0.2))), hollow, TOUCHING)
    assert not overlap(any_mesh(box((0.5, 0.5, 0.5))), hollow, TOUCHING)  # that fills it
    assert overlap(any_mesh(box((0.6, 0.2, 0.2))), hollow, TOUCHING)


def test_triangles_of_any_winding_and_order_are_the_same(rng):
    moved = soup(*turned(box(centre=(1.5, 0.2, 0.1)), 1, 4))
    assert reaches_into(moved[0][moved[1]], known(box()), TOUCHING)


@pytest.mark.parametrize("kind", [known, any_mesh])
@pytest.mark.parametrize(("z", "expected"), [(-1.2, False), (-1, False), (-0.9, True), (0, True), (1, False)])
def test_a_wide_plane_reaches_into_what_it_cuts(kind, z, expected):
    corners = np.array([(-50, -50, z), (50, -50, z), (50, 50, z), (-50, 50, z)], dtype=float)
    assert reaches_into(corners[[(0, 1, 2), (0, 2, 3)]], kind(box()), 1e-5) == expected


def test_a_point_is_a_triangle_too():
    for point, expected in (((0.5, 0.5, 0.5), True), ((1, 0, 0), False), ((2, 0, 0), False)):
        assert reaches_into(np.tile(point, (1, 3, 1)).astype(float), known(box()), 1e-5) == expected

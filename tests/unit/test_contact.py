"""Solids face to face, against boxes that are moved along each other."""

from __future__ import annotations

import numpy as np
import pytest
from meshes import ball, box

from gemrender.scene.closed import closed_surface
from gemrender.scene.contact import faces_touch

GAP = 1e-5


def triangles(mesh):
    return closed_surface(*mesh).triangles


@pytest.mark.parametrize(
    ("shift", "expected"),
    [
        ((2, 0, 0), True),
        ((2, 0.5, -1.9), True),
        ((2, 1.9, 1.9), True),  # by a corner of each face
        ((2, 2, 0), False),  # edge to edge
        ((2, 2, 2), False),  # corner to corner
        ((2 + 0.5 * GAP, 0, 0), True),
        ((2 + 2 * GAP, 0, 0), False),
        ((2, 2.5, 0), False),
        ((0, 0, 0), False),  # in one place: their faces look the same way
    ],
)
def test_boxes_touch_where_their_faces_have_an_area_in_common(shift, expected):
    one, other = triangles(box()), triangles(box(centre=shift))
    assert faces_touch(one, other, GAP) == faces_touch(other, one, GAP) == expected


def test_a_small_face_on_a_large_one_touches_it(rng):
    for x, y in rng.uniform(-0.8, 0.8, (20, 2)):
        small = triangles(box((0.05, 0.05, 0.05), (x, y, 1.05)))
        assert faces_touch(triangles(box()), small, GAP)


def test_edges_and_corners_on_a_face_do_not_touch_it():
    turn = np.sqrt(0.5) * np.array([(np.sqrt(2), 0, 0), (0, 1, -1), (0, 1, 1)])
    assert not faces_touch(
        triangles(box()), triangles(box(centre=(0, 0, 1 + np.sqrt(2)), rotation=turn)), GAP
    )


def test_balls_do_not_touch_face_to_face():
    # At a corner, each with thousands of triangles
    positions, faces = ball()
    assert not faces_touch(
        triangles((positions, faces)), triangles((positions + np.array([2, 0, 0]), faces)), GAP
    )

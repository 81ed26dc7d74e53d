"""Convex solids read back from a stone's mesh in its place."""

from __future__ import annotations

import numpy as np
import pytest
from physics_tolerances import READ_BACK
from solids import bent_stone

from gemrender import load_stone
from gemrender.cuts.round_brilliant.topology import GIRDLE
from gemrender.scene.convex import convex_solid
from gemrender.scene.mesh import mesh_solid, placed_mesh, stone_mesh
from gemrender.scene.placing import Placed
from gemrender.stone import tessellate

#: A rotation about an axis beside all others, by 50 degrees.
AXIS = np.array([2.0, -3.0, 6.0]) / 7.0
CROSS = np.cross(np.eye(3), AXIS)
ROTATION = np.eye(3) + np.sin(np.radians(50)) * CROSS.T + (1 - np.cos(np.radians(50))) * CROSS.T @ CROSS.T
SCALE, SHIFT = 1.7, np.array([0.4, -2.0, 3.0])


def placed(stone, rotation=ROTATION, scale=SCALE, shift=SHIFT):
    return Placed(name="stone", mesh=tessellate(stone), rotation=rotation, scale=scale, shift=shift)


def solid_of(stone, **place):
    """Read back from single precision, as from a mesh of Mitsuba's."""
    there = placed(stone, **place)
    _, normals, faces = there.mesh.split()
    return convex_solid(
        there.split_points().astype(np.float32),
        (normals @ there.rotation.T).astype(np.float32),
        faces,
        there.mesh.face_facet,
    )


def expected_planes(stone):
    """The stone's own planes, brought to its place, without the girdle's: (57, 4)."""
    mesh = tessellate(stone)
    flat = mesh.face_facet != GIRDLE
    planes = {
        facet: np.append(ROTATION @ n, SCALE * offset + ROTATION @ n @ SHIFT)
        for facet, n, offset in zip(
            mesh.face_facet[flat], mesh.face_normals[flat], mesh.face_offsets[flat], strict=True
        )
    }
    return np.array([planes[facet] for facet in sorted(planes)])


def in_order(planes):
    """Rows that stand next to each other when rounded, in one order."""
    return planes[np.lexsort(np.round(planes[:, :3], 3).T)]


def test_rotation_is_one():
    np.testing.assert_allclose(ROTATION @ ROTATION.T, np.eye(3), atol=READ_BACK)
    assert np.linalg.det(ROTATION) == pytest.approx(1)
    np.testing.assert_allclose(ROTATION @ AXIS, AXIS, atol=READ_BACK)


def test_planes_are_the_stones_in_its_place():
    stone = load_stone("inoue-3")
    solid = solid_of(stone)
    expected = expected_planes(stone)
    assert solid.planes.shape == expected.shape == (57, 4)
    np.testing.assert_allclose(in_order(solid.planes), in_order(expected), rtol=0, atol=READ_BACK)


def test_cylinder_is_the_girdles_in_its_place():
    axis, centre, radius = np.split(solid_of(load_stone("inoue-3")).cylinder, [3, 6])
    assert radius[0] == pytest.approx(SCALE, abs=READ_BACK)
    vertical = ROTATION @ [0, 0, 1]
    np.testing.assert_allclose(axis * np.sign(axis @ vertical), vertical, rtol=0, atol=READ_BACK)
    np.testing.assert_allclose(np.cross(centre - SHIFT, vertical), 0, rtol=0, atol=READ_BACK)


@pytest.mark.parametrize("stone", [load_stone("inoue-1"), load_stone("inoue-2"), bent_stone(-0.003)])
def test_stone_in_its_own_frame_is_convex(stone):
    solid = solid_of(stone, rotation=np.eye(3), scale=1.0, shift=np.zeros(3))
    assert solid.cylinder is not None
    # Bent outwards, each of the eight pavilion mains is two planes.
    assert len(solid.planes) == (65 if stone.name == "bent" else 57)


@pytest.mark.parametrize(
    "stone",
    [bent_stone(0.003, name="hollow"), bent_stone(0, name="oval", stretched=1.02)],
    ids=lambda s: s.name,
)
def test_hollow_and_oval_stones_are_no_solids(stone):
    assert solid_of(stone) is None


def test_mesh_without_normals_is_no_solid():
    there = placed(load_stone("inoue-3"))
    _, normals, faces = there.mesh.split()
    assert convex_solid(there.split_points(), 0 * normals, faces, there.mesh.face_facet) is None


def test_solid_holds_what_is_inside():
    # The stone of sample 3 in its own frame: the planes of its proportions, and the girdle of radius 1.
    solid = solid_of(load_stone("inoue-3"), rotation=np.eye(3), scale=1.0, shift=np.zeros(3))
    vertices = load_stone("inoue-3").vertices
    top, bottom = vertices[:, 2].max(), vertices[:, 2].min()
    middle = 0.5 * (vertices[16:32, 2].mean() + vertices[32:48, 2].mean())  # of the girdle
    between = np.pi / 16  # two girdle vertices: there a polygon's edge would be further in
    inside = [
        (0, 0, 0.99 * top),
        (0, 0, 0.99 * bottom),
        (0.99 * np.cos(between), 0.99 * np.sin(between), middle),
    ]
    outside = [
        (0, 0, 1.01 * top),
        (0, 0, 1.01 * bottom),
        (1.01 * np.cos(between), 1.01 * np.sin(between), middle),
        (0.9, 0, 0.9 * top),
    ]
    assert solid.holds(np.array(inside)).all()
    assert not solid.holds(np.array(outside)).any()


def test_vertices_lie_on_the_solid():
    stone = load_stone("inoue-3")
    points = placed(stone).points()
    solid = solid_of(stone)
    assert solid.holds(points, margin=READ_BACK).all()
    away = points.mean(axis=0) + (1 + 1e-4) * (points - points.mean(axis=0))
    assert not solid.holds(away, margin=READ_BACK).any()


# ---- Through Mitsuba's mesh ----------------------------------------------------------------------------


def test_solid_of_a_placed_mesh(variants_all):
    stone = load_stone("inoue-3")
    solid = mesh_solid(placed_mesh(placed(stone)))
    np.testing.assert_array_equal(solid.planes, solid_of(stone).planes)
    np.testing.assert_array_equal(solid.cylinder, solid_of(stone).cylinder)


def test_scored_stones_mesh_has_the_same_solid(variant_llvm_ad_mono):
    stone = load_stone("inoue-1")
    here = {"rotation": np.eye(3), "scale": 1.0, "shift": np.zeros(3)}
    np.testing.assert_array_equal(mesh_solid(stone_mesh(stone)).planes, solid_of(stone, **here).planes)


def test_other_shapes_are_no_solids(variant_llvm_ad_mono):
    import mitsuba as mi

    assert mesh_solid(mi.load_dict({"type": "sphere"})) is None
    assert mesh_solid(mi.load_dict({"type": "cube"})) is None

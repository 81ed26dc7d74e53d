"""Convex solids by the planes that a stone's mesh carries, and where it has been moved."""

from __future__ import annotations

import numpy as np
import pytest
from physics_tolerances import READ_BACK
from solids import bent_stone

from gemrender import load_stone
from gemrender.scene.convex import placed_solid
from gemrender.scene.mesh import carried_planes, mesh_solid, placed_mesh, stone_mesh
from gemrender.scene.placing import Placed
from gemrender.stone import tessellate

#: A rotation about an axis beside all others, by 50 degrees.
AXIS = np.array([2.0, -3.0, 6.0]) / 7.0
CROSS = np.cross(np.eye(3), AXIS)
ROTATION = np.eye(3) + np.sin(np.radians(50)) * CROSS.T + (1 - np.cos(np.radians(50))) * CROSS.T @ CROSS.T
SCALE, SHIFT = 1.7, np.array([0.4, -2.0, 3.0])
TURN = ROTATION @ ROTATION
#: A brilliant, one of planes alone, and one whose outline is measured.
STONES = [load_stone("inoue-3"), bent_stone(-0.003), bent_stone(0, name="oval", stretched=1.02)]
#: Planes that are carried as the sums of two singles each: 2^-48 of an offset of 5.
CARRIED = 1e-13


def placed(stone, rotation=ROTATION, scale=SCALE, shift=SHIFT):
    return Placed(name="stone", mesh=tessellate(stone), rotation=rotation, scale=scale, shift=shift)


def solid_of(stone, moved=None, normals=1.0, **place):
    """Read back from a mesh in single precision, as from one of Mitsuba's; perhaps after a move (3, 3)."""
    there = placed(stone, **place)
    _, own, faces = there.mesh.split()
    own = normals * own @ there.rotation.T
    points, planes = there.split_points(), there.planes()
    if moved is not None:
        points = points @ moved.T
        own = own @ np.linalg.inv(moved)
        own /= np.maximum(np.linalg.norm(own, axis=1, keepdims=True), 1e-9)
    return placed_solid(points.astype(np.float32), own.astype(np.float32), faces, planes)


def expected_planes(stone):
    """The stone's own planes, brought to its place."""
    normals = stone.solid.planes[:, :3] @ ROTATION.T
    return np.column_stack([normals, SCALE * stone.solid.planes[:, 3] + normals @ SHIFT])


def in_order(planes):
    """Rows that stand next to each other when rounded, in one order."""
    return planes[np.lexsort(np.round(planes[:, :3], 3).T)]


def test_rotation_is_one():
    np.testing.assert_allclose(ROTATION @ ROTATION.T, np.eye(3), atol=READ_BACK)
    assert np.linalg.det(ROTATION) == pytest.approx(1)
    np.testing.assert_allclose(ROTATION @ AXIS, AXIS, atol=READ_BACK)


@pytest.mark.parametrize("stone", STONES, ids=lambda s: s.name)
def test_planes_are_the_stones_in_its_place(stone):
    # In double precision, though the vertices are in single
    solid, expected = solid_of(stone), expected_planes(stone)
    assert solid.planes.shape == expected.shape
    np.testing.assert_allclose(in_order(solid.planes), in_order(expected), rtol=0, atol=CARRIED)
    assert (solid.cylinder is not None) == stone.is_round


@pytest.mark.parametrize(
    "moved", [TURN, 1.5 * TURN, np.diag([-1.0, 1.0, 1.0])], ids=["turn", "scale", "mirror"]
)
@pytest.mark.parametrize("stone", STONES, ids=lambda s: s.name)
def test_planes_of_a_mesh_that_was_moved_are_fitted(stone, moved):
    solid, expected = solid_of(stone, moved), expected_planes(stone)
    scale = np.cbrt(abs(np.linalg.det(moved)))
    normals = expected[:, :3] @ moved.T / scale
    expected = np.column_stack([normals, scale * expected[:, 3]])
    np.testing.assert_allclose(in_order(solid.planes), in_order(expected), rtol=0, atol=2 * READ_BACK)
    if stone.is_round:
        assert solid.cylinder[6] == pytest.approx(scale * SCALE, abs=READ_BACK)


def test_a_stretched_brilliant_has_no_cylinder():
    stretched = np.diag([1.1, 1.0, 1.0])
    assert solid_of(STONES[0], stretched) is None
    assert solid_of(STONES[2], stretched) is not None  # its planes are planes still


def test_cylinder_is_the_girdles_in_its_place():
    axis, centre, radius = np.split(solid_of(load_stone("inoue-3")).cylinder, [3, 6])
    assert radius[0] == pytest.approx(SCALE, abs=READ_BACK)
    vertical = ROTATION @ [0, 0, 1]
    np.testing.assert_allclose(axis * np.sign(axis @ vertical), vertical, rtol=0, atol=READ_BACK)
    np.testing.assert_allclose(np.cross(centre - SHIFT, vertical), 0, rtol=0, atol=READ_BACK)


def test_a_hollow_stone_is_no_convex_solid():
    assert solid_of(bent_stone(0.003)) is None


def test_a_girdle_without_normals_is_no_cylinder():
    assert solid_of(STONES[0], TURN, normals=0.0) is None
    assert solid_of(STONES[2], TURN, normals=0.0) is not None  # planes are found by the faces


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


@pytest.mark.parametrize("stone", STONES, ids=lambda s: s.name)
def test_solid_of_a_placed_mesh(variants_all, stone):
    solid = mesh_solid(placed_mesh(placed(stone)))
    np.testing.assert_allclose(solid.planes, solid_of(stone).planes, rtol=0, atol=CARRIED)
    assert len(solid.planes) == len(stone.solid.planes)


def test_scored_stones_mesh_has_the_stones_planes(variant_llvm_ad_mono):
    for stone in STONES:
        solid = mesh_solid(stone_mesh(stone))
        np.testing.assert_allclose(in_order(solid.planes), in_order(stone.solid.planes), rtol=0, atol=CARRIED)


def test_planes_survive_a_file(variant_llvm_ad_mono, tmp_path):
    import mitsuba as mi

    mesh = placed_mesh(placed(STONES[0]))
    mesh.write_ply(str(tmp_path / "stone.ply"))
    scene = {"type": "scene", "stone": {"type": "ply", "filename": str(tmp_path / "stone.ply")}}
    for optimize in (False, True):
        (read,) = mi.load_dict(scene, optimize=optimize).shapes()
        np.testing.assert_array_equal(mesh_solid(read).planes, mesh_solid(mesh).planes)
        np.testing.assert_array_equal(carried_planes(read), carried_planes(mesh))


def test_planes_of_a_moved_file_are_where_it_is(variant_llvm_ad_mono, tmp_path):
    import mitsuba as mi

    mesh = stone_mesh(STONES[0])
    mesh.write_ply(str(tmp_path / "stone.ply"))
    to_world = mi.ScalarTransform4f().translate([0.3, 0, 0]).rotate(AXIS.tolist(), 40)
    moved = {"type": "ply", "filename": str(tmp_path / "stone.ply"), "to_world": to_world}
    solid = mesh_solid(mi.load_dict(moved))
    turn = np.array(to_world.matrix, dtype=np.float64)
    normals = STONES[0].solid.planes[:, :3] @ turn[:3, :3].T
    expected = np.column_stack([normals, STONES[0].solid.planes[:, 3] + normals @ turn[:3, 3]])
    np.testing.assert_allclose(in_order(solid.planes), in_order(expected), rtol=0, atol=READ_BACK)


def test_planes_of_a_mesh_moved_in_memory_are_where_it_is(variant_llvm_ad_mono):
    import mitsuba as mi

    mesh = stone_mesh(STONES[0])
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = parameters["vertex_positions"] * 1.25
    parameters.update()
    solid = mesh_solid(mesh)
    expected = STONES[0].solid.planes * [1, 1, 1, 1.25]
    np.testing.assert_allclose(in_order(solid.planes), in_order(expected), rtol=0, atol=READ_BACK)
    assert solid.cylinder[6] == pytest.approx(1.25, abs=READ_BACK)


def test_other_shapes_are_no_solids(variant_llvm_ad_mono):
    import mitsuba as mi

    assert mesh_solid(mi.load_dict({"type": "sphere"})) is None
    assert mesh_solid(mi.load_dict({"type": "cube"})) is None

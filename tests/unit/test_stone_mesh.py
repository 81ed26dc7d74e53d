"""The mesh: watertight, of the right volume, scalloped where planes meet the girdle's wall."""

from __future__ import annotations

import numpy as np
import pytest
from solids import assert_closed, half_space_volume, mesh_volume, scalloped_volume
from tolerances import (
    CORNER_NORMAL,
    MEASURED_WALL,
    MESH_VOLUME,
    PLANE,
    QUADRATURE_VOLUME,
    ROUNDING,
    SAGITTA,
    WALL_BEND,
)

from gemrender.cuts import RoundBrilliant, bundled_stones, load_stone, stone_from_vertices
from gemrender.cuts.round_brilliant.topology import (
    FACET_KINDS,
    GIRDLE,
    GIRDLE_LOWER,
    GIRDLE_UPPER,
    LOWER_GIRDLE_FACETS,
    N_VERTICES,
    TRIANGLE_FACET,
    TRIANGLES,
    UPPER_GIRDLE_FACETS,
)
from gemrender.stone import Stone, tessellate
from gemrender.stone.mesh import ARC_SEGMENTS

SAMPLE = {
    "table": 54.0,
    "star": 57.0,
    "lower_girdle_contact": 20.0,
    "crown_height": 15.7,
    "pavilion_depth": 43.08,
    "girdle_thickness": 2.5,
}
#: Girdle thicknesses [%] where the scallops cross (0, 1) and where they do not.
THICKNESSES = [0.0, 0.01, 0.5, 1.0, 2.5, 5.0, 10.0]


def sample(**other: float) -> Stone:
    return Stone.from_proportions(RoundBrilliant(**SAMPLE | other))


def measured(rng: np.random.Generator, scale: float) -> Stone:
    """The sample with every vertex moved at random, by so much in the mean."""
    return stone_from_vertices(sample().vertices + rng.normal(scale=scale, size=(N_VERTICES, 3)))


def edge_points(stone: Stone) -> tuple[np.ndarray, np.ndarray]:
    """The mesh's upper and lower girdle edge between the girdle vertices, each (16, ARC_SEGMENTS - 1, 3)."""
    inner = tessellate(stone).vertices[N_VERTICES:].reshape(2, 16, ARC_SEGMENTS - 1, 3)
    return inner[0], inner[1]


# ---- Closed --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", bundled_stones())
def test_bundled_stones_are_closed(name):
    assert_closed(tessellate(load_stone(name)))


@pytest.mark.parametrize("thickness", THICKNESSES)
def test_girdle_of_any_thickness_is_closed(thickness):
    assert_closed(tessellate(sample(girdle_thickness=thickness)))


@pytest.mark.parametrize("scale", [1e-9, 1e-6, 1e-4, 1e-3])
def test_measured_stone_is_closed(rng, scale):
    stone = measured(rng, scale)
    assert not stone.girdle.is_round
    mesh = tessellate(stone)
    assert_closed(mesh)
    # Moving the surface (its area is some 7) by this much changes the volume by less than their product.
    assert mesh_volume(mesh) == pytest.approx(
        half_space_volume(RoundBrilliant(**SAMPLE)), abs=7 * scale + MESH_VOLUME + QUADRATURE_VOLUME
    )


def test_measured_stone_with_a_thin_girdle_is_closed(rng):
    vertices = sample(girdle_thickness=1.0).vertices + rng.normal(scale=5e-4, size=(N_VERTICES, 3))
    assert_closed(tessellate(stone_from_vertices(vertices)))


@pytest.mark.parametrize("segments", [2, 8, 128])
def test_any_number_of_arc_pieces_is_closed(segments):
    mesh = tessellate(sample(), segments)
    assert_closed(mesh)
    assert len(mesh.faces) == 78 + 64 * segments - 32


def test_topology_is_the_same_for_every_stone(rng):
    meshes = [
        tessellate(s) for s in (load_stone("inoue-1"), sample(girdle_thickness=0.0), measured(rng, 1e-3))
    ]
    for mesh in meshes[1:]:
        assert (mesh.faces == meshes[0].faces).all()
        assert (mesh.face_facet == meshes[0].face_facet).all()
        assert len(mesh.split()[0]) == len(meshes[0].split()[0])


# ---- The solid -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", bundled_stones())
def test_volume_is_that_of_half_spaces_and_cylinder(name):
    stone = load_stone(name)
    assert stone.proportions is not None
    lacking = half_space_volume(stone.proportions) - mesh_volume(tessellate(stone))
    assert -QUADRATURE_VOLUME < lacking < MESH_VOLUME + QUADRATURE_VOLUME


@pytest.mark.parametrize("thickness", THICKNESSES)
def test_volume_with_girdles_of_any_thickness(thickness):
    stone = sample(girdle_thickness=thickness)
    assert stone.proportions is not None
    lacking = half_space_volume(stone.proportions) - mesh_volume(tessellate(stone))
    assert -QUADRATURE_VOLUME < lacking < MESH_VOLUME + QUADRATURE_VOLUME


@pytest.mark.parametrize("name", ["inoue-1", "inoue-2", "inoue-3"])
def test_volume_in_closed_form(name):
    """Quadrature and closed form agree, and the mesh tends to both as the square of its arc pieces."""
    stone = load_stone(name)
    assert stone.proportions is not None
    upper, lower = GIRDLE_UPPER, GIRDLE_LOWER
    wall = np.stack([lower, np.roll(lower, -1), np.roll(upper, -1), upper], axis=1)
    triangles = np.concatenate([TRIANGLES, wall[:, [0, 1, 2]], wall[:, [0, 2, 3]]])
    a, b, c = stone.vertices[triangles].transpose(1, 0, 2)
    exact = scalloped_volume(stone.proportions, float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6))
    assert half_space_volume(stone.proportions) == pytest.approx(exact, abs=QUADRATURE_VOLUME)
    lacking = [exact - mesh_volume(tessellate(stone, n)) for n in (16, 32, 64)]
    assert lacking[0] / lacking[1] == pytest.approx(4, rel=0.01)
    assert lacking[1] / lacking[2] == pytest.approx(4, rel=0.01)
    assert 0 < lacking[2] < MESH_VOLUME


@pytest.mark.parametrize("thickness", THICKNESSES)
def test_no_vertex_lies_outside_any_half_space_or_the_cylinder(thickness):
    stone = sample(girdle_thickness=thickness)
    vertices = tessellate(stone).vertices
    assert (vertices @ stone.facet_normals.T - stone.facet_offsets).max() < PLANE
    assert np.hypot(vertices[:, 0], vertices[:, 1]).max() < 1 + ROUNDING


@pytest.mark.parametrize("thickness", THICKNESSES)
def test_faces_of_a_facet_lie_on_its_plane_and_face_outwards(thickness):
    stone = sample(girdle_thickness=thickness)
    mesh = tessellate(stone)
    plane = mesh.face_facet < GIRDLE
    corners, facet = mesh.vertices[mesh.faces[plane]], mesh.face_facet[plane]
    distance = np.einsum("ijk,ik->ij", corners, stone.facet_normals[facet]) - stone.facet_offsets[facet, None]
    assert np.abs(distance).max() < PLANE
    assert (mesh.corner_normals[plane] == stone.facet_normals[facet, None]).all()
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (
        np.einsum("ij,ij->i", cross, stone.facet_normals[facet]).min() > -PLANE
    )  # zero where scallops cross


def test_facets_have_the_area_of_their_triangles_and_scallops(rng):
    """The facet number of a face: the 78 triangles come first, and only girdle facets have more faces."""
    mesh = tessellate(measured(rng, 1e-4))
    assert (mesh.face_facet[: len(TRIANGLES)] == TRIANGLE_FACET).all()
    assert (mesh.faces[: len(TRIANGLES)] == TRIANGLES).all()
    more = np.bincount(mesh.face_facet[len(TRIANGLES) :], minlength=58)
    expected = {
        "upper_girdle": ARC_SEGMENTS - 1,
        "lower_girdle": ARC_SEGMENTS - 1,
        "girdle": 32 * ARC_SEGMENTS,
    }
    assert more.tolist() == [expected.get(kind, 0) for kind in FACET_KINDS]


# ---- The girdle ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["inoue-1", "inoue-2", "inoue-3", "gia-excellent"])
def test_scalloped_edges_lie_on_plane_and_cylinder(name):
    stone = load_stone(name)
    for points, facets in zip(edge_points(stone), (UPPER_GIRDLE_FACETS, LOWER_GIRDLE_FACETS), strict=True):
        assert np.abs(np.hypot(points[..., 0], points[..., 1]) - 1).max() < ROUNDING
        distance = np.einsum("ijk,ik->ij", points, stone.facet_normals[facets])
        assert np.abs(distance - stone.facet_offsets[facets, None]).max() < PLANE


def test_scallops_make_the_girdle_thinner_in_the_middle_of_each_arc():
    stone = sample()
    upper, lower = edge_points(stone)
    middle = ARC_SEGMENTS // 2 - 1
    assert (upper[:, middle, 2] < stone.vertices[GIRDLE_UPPER, 2].min()).all()
    assert (lower[:, middle, 2] > stone.vertices[GIRDLE_LOWER, 2].max()).all()


def test_edges_of_a_measured_stone_lie_on_plane_and_wall(rng):
    stone = measured(rng, 1e-3)
    for points, facets in zip(edge_points(stone), (UPPER_GIRDLE_FACETS, LOWER_GIRDLE_FACETS), strict=True):
        wall = stone.girdle.radius(*points.reshape(-1, 3).T)
        assert np.abs(np.hypot(points[..., 0], points[..., 1]).reshape(-1) - wall).max() < MEASURED_WALL
        distance = np.einsum("ijk,ik->ij", points, stone.facet_normals[facets])
        assert np.abs(distance - stone.facet_offsets[facets, None]).max() < PLANE


@pytest.mark.parametrize("thickness", [0.0, 1.0])
def test_where_scallops_cross_the_girdle_has_no_height_and_lies_on_both_planes(thickness):
    stone = sample(girdle_thickness=thickness)
    upper, lower = edge_points(stone)
    crossed = upper[..., 2] == lower[..., 2]
    assert crossed[:, ARC_SEGMENTS // 2 - 1].all()
    assert crossed.all() == (thickness == 0.0)
    assert (upper[crossed] == lower[crossed]).all()
    assert (upper[..., 2] >= lower[..., 2]).all()
    for facets in (UPPER_GIRDLE_FACETS, LOWER_GIRDLE_FACETS):
        distance = (
            np.einsum("ijk,ik->ij", upper, stone.facet_normals[facets]) - stone.facet_offsets[facets, None]
        )
        assert np.abs(distance[crossed]).max() < PLANE


@pytest.mark.parametrize("thickness", THICKNESSES)
def test_girdle_normals_of_a_round_stone_are_radial_and_horizontal(thickness):
    mesh = tessellate(sample(girdle_thickness=thickness))
    girdle = mesh.face_facet == GIRDLE
    corners, normals = mesh.vertices[mesh.faces[girdle]], mesh.corner_normals[girdle]
    radius = np.hypot(corners[..., 0], corners[..., 1])
    assert (normals[..., 2] == 0).all()
    expected = corners[..., :2] / radius[..., None]
    np.testing.assert_allclose(normals[..., :2], expected, rtol=0, atol=ROUNDING)


def test_girdle_normals_of_a_measured_stone_are_those_of_its_wall(rng):
    """They differ from those of the flat faces by the angle between two faces, and by the wall's bends.

    Where the upper and the lower vertex of a bend lie at different azimuths, faces beside it get the slope
    of the neighbouring sector: a change of radius of some 1e-3 over pi / 8.
    """
    mesh = tessellate(measured(rng, 1e-3))
    girdle = mesh.face_facet == GIRDLE
    corners, normals = mesh.vertices[mesh.faces[girdle]], mesh.corner_normals[girdle]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    sine = np.linalg.norm(np.cross(flat[:, None], normals), axis=-1)
    assert sine.max() < np.pi / 8 / ARC_SEGMENTS + WALL_BEND
    assert np.einsum("ik,ijk->ij", flat, normals).min() > 0


def test_arc_pieces_stay_within_their_sagitta_of_the_cylinder():
    mesh = tessellate(sample())
    corners = mesh.vertices[mesh.faces[mesh.face_facet == GIRDLE]]
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    assert np.hypot(middles[..., 0], middles[..., 1]).min() > 1 - SAGITTA - ROUNDING


@pytest.mark.parametrize("scale", [0.0, 1e-3])
def test_split_mesh_has_one_normal_a_vertex_and_the_same_faces(rng, scale):
    mesh = tessellate(measured(rng, scale))
    positions, normals, faces = mesh.split()
    assert len(positions) == len(normals)
    assert (positions[faces] == mesh.vertices[mesh.faces]).all()
    difference = np.abs(normals[faces] - mesh.corner_normals).max()
    assert difference <= (CORNER_NORMAL if scale else 0.0)


# ---- Measured stones -----------------------------------------------------------------------------------


def test_vertices_of_a_symmetric_stone_make_that_stone():
    stone = sample()
    again = stone_from_vertices(stone.vertices)
    assert (again.vertices == stone.vertices).all()
    assert (again.facet_normals == stone.facet_normals).all()
    assert again.girdle.is_round
    assert again.proportions is None


def test_unit_of_length_and_origin_do_not_matter(rng):
    stone = measured(rng, 1e-3)
    again = stone_from_vertices(stone.vertices * 3.25 + (10.0, -4.0, 7.0))
    np.testing.assert_allclose(again.vertices, stone.vertices, rtol=0, atol=20 * ROUNDING)  # 10 away


def test_kites_that_are_not_flat_are_two_planes(rng):
    stone = measured(rng, 1e-3)
    for triangle, facet in enumerate(TRIANGLE_FACET):
        corners = stone.vertices[TRIANGLES[triangle]]
        distance = corners @ stone.triangle_normals[triangle] - stone.triangle_offsets[triangle]
        assert np.abs(distance).max() < ROUNDING, FACET_KINDS[facet]


def test_stones_can_be_compared_and_kept_in_sets():
    one, other = sample(), sample()
    assert one != other
    assert len({one, other}) == 2

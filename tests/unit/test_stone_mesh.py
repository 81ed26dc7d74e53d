"""The mesh: watertight, of the right volume, scalloped where planes meet the girdle's wall."""

from __future__ import annotations

import numpy as np
import pytest
from solids import BRILLIANTS, assert_closed, bent_stone, half_space_volume, mesh_volume, scalloped_volume
from tolerances import MESH_VOLUME, PLANE, QUADRATURE_VOLUME, ROUNDING, SAGITTA

from gemrender.cuts import RoundBrilliant, bundled_stones, load_stone, stone_from_vertices
from gemrender.cuts.round_brilliant.topology import (
    FACET_KINDS,
    GIRDLE,
    GIRDLE_LOWER,
    GIRDLE_UPPER,
    LOWER_GIRDLE_FACETS,
    N_VERTICES,
    STAR_TIP,
    TRIANGLES,
    UPPER_GIRDLE_FACETS,
)
from gemrender.stone import MeshSolid, Stone, tessellate
from gemrender.stone.solid import ROUND_PIECES

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

#: What a prism of 64 sides and the cylinder of the same section differ by in volume [girdle radius^3]: the
#: section's edge moves by 8e-4, to and fro, under heights that change by as much.
PRISM_VOLUME = 1e-4


def sample(**other: float) -> Stone:
    return Stone.from_proportions(RoundBrilliant(**SAMPLE | other))


def measured(rng: np.random.Generator, scale: float) -> Stone:
    """The sample with every vertex moved at random, by so much in the mean."""
    return stone_from_vertices(sample().vertices + rng.normal(scale=scale, size=(N_VERTICES, 3)))


def wall_edges(stone: Stone) -> tuple[np.ndarray, np.ndarray]:
    """The corners of a round girdle's upper and lower edge, each (k, 3)."""
    mesh = tessellate(stone)
    wall = mesh.face_facet == GIRDLE
    corners = mesh.vertices[np.unique(mesh.faces[wall])]
    on = [
        np.unique(mesh.faces[np.isin(mesh.face_facet, f)]) for f in (UPPER_GIRDLE_FACETS, LOWER_GIRDLE_FACETS)
    ]
    both = np.unique(mesh.faces[wall])
    upper, lower = (mesh.vertices[np.intersect1d(both, facets)] for facets in on)
    assert len(np.unique(np.concatenate([upper, lower]), axis=0)) == len(corners)
    return upper, lower


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
    assert not stone.is_round
    mesh = tessellate(stone)
    assert_closed(mesh)
    # Moving the surface (its area is some 7) by this much changes the volume by less than their product. The
    # outline has its area, but corners: cylinder and prism differ by 1e-3 near their edges.
    assert mesh_volume(mesh) == pytest.approx(
        half_space_volume(RoundBrilliant(**SAMPLE)), abs=7 * scale + PRISM_VOLUME + QUADRATURE_VOLUME
    )


def test_measured_stone_with_a_thin_girdle_is_closed(rng):
    vertices = sample(girdle_thickness=1.0).vertices + rng.normal(scale=5e-4, size=(N_VERTICES, 3))
    assert_closed(tessellate(stone_from_vertices(vertices)))


@pytest.mark.parametrize("pieces", [32, 128, 2048])
def test_a_round_girdle_of_any_number_of_pieces_is_closed(pieces):
    mesh = tessellate(sample(), pieces)
    assert_closed(mesh)
    assert np.count_nonzero(mesh.face_facet == GIRDLE) == 2 * pieces


# ---- The solid -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", BRILLIANTS)
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
    lacking = [exact - mesh_volume(tessellate(stone, n)) for n in (256, 512, 1024)]
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


def test_volume_of_the_solid_is_that_of_a_round_girdle():
    stone = sample()
    assert stone.solid.volume == pytest.approx(half_space_volume(stone.proportions), abs=QUADRATURE_VOLUME)


def test_areas_of_facets_are_those_of_their_faces(rng):
    stone = measured(rng, 1e-4)
    mesh = tessellate(stone)
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    by_facet = np.bincount(mesh.face_facet, areas, minlength=len(FACET_KINDS))
    np.testing.assert_allclose(stone.solid.areas, by_facet, rtol=0, atol=PLANE)


# ---- The girdle ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["inoue-1", "inoue-2", "inoue-3", "gia-excellent"])
def test_scalloped_edges_lie_on_planes_and_cylinder(name):
    stone = load_stone(name)
    for points, facets in zip(wall_edges(stone), (UPPER_GIRDLE_FACETS, LOWER_GIRDLE_FACETS), strict=True):
        assert len(points) == ROUND_PIECES
        assert np.abs(np.hypot(points[:, 0], points[:, 1]) - 1).max() < PLANE
        distance = points @ stone.facet_normals[facets].T - stone.facet_offsets[facets]
        assert np.abs(distance).min(axis=1).max() < PLANE


def test_scallops_make_the_girdle_thinner_in_the_middle_of_each_arc():
    stone = sample()
    upper, lower = wall_edges(stone)
    for points, ring, sign in ((upper, GIRDLE_UPPER, 1), (lower, GIRDLE_LOWER, -1)):
        step = (np.arctan2(points[:, 1], points[:, 0]) / (np.pi / 8)) % 1.0
        middle = points[np.abs(step - 0.5) < 1e-6, 2]
        assert len(middle) == 16
        assert (sign * middle < (sign * stone.vertices[ring, 2]).min()).all()


@pytest.mark.parametrize("thickness", [0.0, 0.3, 1.0])
def test_a_girdle_that_is_thinner_than_its_scallops_has_gaps(thickness):
    stone = sample(girdle_thickness=thickness)
    mesh = tessellate(stone)
    pieces = np.count_nonzero(mesh.face_facet == GIRDLE)
    assert pieces < 2 * ROUND_PIECES
    assert (pieces == 0) == (thickness == 0.0)
    assert (stone.solid.areas[GIRDLE] == 0.0) == (thickness == 0.0)


@pytest.mark.parametrize("thickness", THICKNESSES)
def test_girdle_normals_of_a_round_stone_are_radial_and_horizontal(thickness):
    mesh = tessellate(sample(girdle_thickness=thickness))
    girdle = mesh.face_facet == GIRDLE
    corners, normals = mesh.vertices[mesh.faces[girdle]], mesh.corner_normals[girdle]
    radius = np.hypot(corners[..., 0], corners[..., 1])
    assert (normals[..., 2] == 0).all()
    expected = corners[..., :2] / radius[..., None]
    np.testing.assert_allclose(normals[..., :2], expected, rtol=0, atol=ROUNDING)


def test_the_girdle_of_a_measured_stone_is_level_facets_that_keep_the_outlines_area():
    stone = bent_stone(-0.01, stretched=1.02)
    girdle = stone.solid.facet == GIRDLE
    assert np.count_nonzero(girdle) == 64
    assert (stone.solid.planes[girdle, 2] == 0).all()
    body = stone.solid.polyhedron
    outline = np.maximum(body.crosses[:, 2], 0).sum()
    middle = 0.5 * (stone.vertices[GIRDLE_UPPER] + stone.vertices[GIRDLE_LOWER])
    azimuth = np.arctan2(middle[:, 1], middle[:, 0])
    radius = 0.5 * sum(np.hypot(*stone.vertices[ring, :2].T) for ring in (GIRDLE_UPPER, GIRDLE_LOWER))
    fine = np.linspace(-np.pi, np.pi, 400_001)
    wanted = 0.5 * np.trapezoid(np.interp(fine, azimuth, radius, period=2 * np.pi) ** 2, fine)
    assert outline == pytest.approx(wanted, abs=1e-6)  # by the trapezoidal rule over kinks


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
    assert (normals[faces] == mesh.corner_normals).all()


# ---- Measured stones -----------------------------------------------------------------------------------


def test_vertices_of_a_symmetric_stone_make_that_stone():
    stone = sample()
    again = stone_from_vertices(stone.vertices)
    assert (again.vertices == stone.vertices).all()
    assert (again.facet_normals == stone.facet_normals).all()
    assert again.is_round
    assert again.proportions is None


def test_unit_of_length_and_origin_do_not_matter(rng):
    stone = measured(rng, 1e-3)
    again = stone_from_vertices(stone.vertices * 3.25 + (10.0, -4.0, 7.0))
    np.testing.assert_allclose(again.vertices, stone.vertices, rtol=0, atol=20 * ROUNDING)  # 10 away


def test_kites_that_are_not_flat_are_two_planes():
    # Star tips a little lower: every kite of the crown is bent outwards along its long diagonal.
    vertices = sample().vertices.copy()
    vertices[STAR_TIP, 2] -= 1e-4
    stone = stone_from_vertices(vertices)
    planes = np.bincount(stone.solid.facet)
    assert planes.tolist() == [2 if kind == "bezel" else 1 for kind in FACET_KINDS[:GIRDLE]]
    on_a_plane = np.abs(stone.vertices @ stone.solid.planes[:, :3].T - stone.solid.planes[:, 3]) < PLANE
    assert (on_a_plane.sum(axis=1) >= 2).all()


def test_a_hollow_stone_is_a_mesh():
    vertices = sample().vertices.copy()
    vertices[STAR_TIP, 2] += 1e-3
    stone = stone_from_vertices(vertices)
    assert not stone.is_convex
    assert isinstance(stone.solid, MeshSolid)
    mesh = tessellate(stone)
    assert_closed(mesh)
    assert mesh_volume(mesh) == pytest.approx(stone.solid.volume, abs=ROUNDING)
    assert mesh_volume(mesh) == pytest.approx(half_space_volume(sample().proportions), abs=5e-3)


def test_stones_can_be_compared_and_kept_in_sets():
    one, other = sample(), sample()
    assert one != other
    assert len({one, other}) == 2

"""Stones of any cut in their places: what they rest on, how large they are, and what holds them."""

from __future__ import annotations

import numpy as np
import pytest
from observations import ROOT
from scipy.spatial import ConvexHull
from solids import BRILLIANTS, cleft_heart, star_prism

from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.render.photoreal import make_gems
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.placing import place
from gemrender.scene.resting import resting_plane
from gemrender.scene.setup import POSES, load_setup
from gemrender.stone import ConvexSolid, Facet, MeshSolid, Stone, side_of, tessellate

DESIGNS = [
    load_stone(ROOT / "tests" / "cases" / "stones" / f"{name}.asc") for name in ("emerald", "pear", "oval")
]
#: Turned twice, from coordinates of order 1.
TURNED = 1e-9


def solid_of(planes):
    planes = np.asarray(planes, dtype=float)
    facets = tuple(Facet(f"f_{k}", "f", side_of(plane[2])) for k, plane in enumerate(planes))
    return Stone(solid=ConvexSolid(planes=planes, facet=np.arange(len(planes))), facets=facets)


def random_solid(seed, n=40):
    """Planes tangent to an ellipsoid."""
    normals = np.random.default_rng(seed).normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return solid_of(np.column_stack([normals, np.linalg.norm(normals * [1.0, 0.8, 0.5], axis=1)]))


STONES = [*DESIGNS, star_prism(), cleft_heart(), *map(random_solid, range(5))]


def centre_of_mass(stone):
    """By tetrahedra to a vertex."""
    mesh = tessellate(stone)
    corners = mesh.vertices[mesh.faces] - mesh.vertices[0]
    volumes = np.linalg.det(corners)
    return mesh.vertices[0] + volumes @ corners.sum(axis=1) / (4 * volumes.sum())


def is_stable(stone, normal):
    """Whether the centre of mass is above what touches a plane that the stone lies on."""
    heights = tessellate(stone).vertices @ normal
    touching = tessellate(stone).vertices[heights > heights.max() - 1e-7]
    across = np.linalg.svd(normal[None])[2][1:]
    if len(touching) < 3:
        return False
    hull = ConvexHull(touching @ across.T).equations
    return bool((hull[:, :2] @ (across @ centre_of_mass(stone)) + hull[:, 2] < -1e-7).all())


@pytest.mark.parametrize("name", BRILLIANTS)
def test_a_brilliant_lies_on_a_pavilion_main(name):
    stone = load_stone(name)
    main = stone.facet_kinds.index("pavilion_main")
    np.testing.assert_array_equal(resting_plane(stone), stone.solid.planes[main, :3])


@pytest.mark.parametrize("stone", STONES, ids=lambda stone: f"{stone.name} {len(stone.facets)}")
def test_a_stone_lies_where_it_is_at_rest_and_low(stone):
    normal, centre = resting_plane(stone), centre_of_mass(stone)
    assert normal[2] <= 0
    assert is_stable(stone, normal)
    vertices = tessellate(stone).vertices

    def height(normal):
        return (vertices @ normal).max() - normal @ centre

    hull = ConvexHull(vertices).equations[:, :3]
    others = [height(other) for other in hull if other[2] <= 1e-8 and is_stable(stone, other)]
    # No other is lower, but for those that are alike in that and steeper
    assert height(normal) <= 1.005 * min(others) + TURNED


def test_a_block_lies_on_its_base():
    block = solid_of(
        [[0, 0, 1, 0.2], [0, 0, -1, 0.2], *([*n, 0, 1.0] for n in ((1, 0), (0, 1), (-1, 0), (0, -1)))]
    )
    np.testing.assert_array_equal(resting_plane(block), [0, 0, -1])


def test_of_two_that_are_as_low_it_lies_on_the_flatter():
    # A wedge whose sides are alike but for their inclination: 30 and 50 degrees
    a, b = np.radians([30, 50])
    sides = [[np.sin(a), 0, -np.cos(a), 0.5], [-np.sin(b), 0, -np.cos(b), 0.5]]
    walls = [[0, 1, 0, 1.0], [0, -1, 0, 1.0], [0, 0, 1, 0.3]]
    normal = resting_plane(solid_of([*sides, *walls]))
    np.testing.assert_allclose(normal, sides[0][:3], rtol=0, atol=TURNED)


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("stone", STONES[:6], ids=lambda stone: stone.name)
def test_any_stone_stands_on_the_ground_in_any_pose(stone, pose):
    (placed,) = place([stone], pose=pose, facing_deg=20.0, gap=0.4, azimuth_deg=-90.0, sizes=[1.5])
    points = placed.points()
    assert points[:, 2].min() == pytest.approx(0, abs=TURNED)
    np.testing.assert_allclose(placed.rotation @ placed.rotation.T, np.eye(3), rtol=0, atol=TURNED)
    table = placed.rotation @ [0, 0, 1]
    assert {"table-up": table[2] == 1, "lying": table[2] >= 0, "table-down": table[2] == -1}[pose]
    if pose == "lying":
        assert (points[:, 2] < 1e-7).sum() >= 3


# ---- Sizes ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stone", DESIGNS, ids=lambda stone: stone.name)
def test_millimetres_are_those_of_the_longer_side(stone):
    corners = stone.solid.vertices
    assert np.ptp(corners, axis=0)[:2].max() == pytest.approx(2.0, abs=1e-12)
    (gem,) = make_gems([stone], material="quartz", carat=2.0)
    volume_mm3 = ConvexHull(corners * gem.diameter_mm / 2).volume
    assert volume_mm3 * 2.65 / 200 == pytest.approx(2.0, rel=1e-9)  # 2.65 g/cm^3; a carat is 200 mg


def test_a_mesh_has_a_weight():
    (gem,) = make_gems([cleft_heart()], material="diamond", carat=1.0)
    assert isinstance(gem.stone.solid, MeshSolid)
    volume = gem.stone.solid.volume * (gem.diameter_mm / 2) ** 3
    assert volume * 3.52 / 200 == pytest.approx(1.0, rel=1e-9)


def test_a_weight_needs_a_density_of_a_design_too():
    with pytest.raises(InputError, match="needs the material's density"):
        make_gems(DESIGNS[:1], carat=1.0)  # of its own index


# ---- Cups ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stone", [*DESIGNS, cleft_heart()], ids=lambda stone: stone.name)
def test_a_cup_holds_a_stone_up_to_its_girdle(variant_llvm_ad_spectral, stone):
    import mitsuba as mi

    gems = make_gems([stone, load_stone("inoue-3")], material="quartz")
    scene = photoreal_scene(gems, load_setup("hemisphere"), width=16, height=16, turn_deg=30.0)
    (placed, _), cup = scene.stones, scene.meshes()["cup_1"]
    points = placed.points()
    walls = np.array(cup.vertex_positions_buffer()).reshape(-1, 3)
    assert walls[:, 2].max() == pytest.approx(placed.shift[2], abs=1e-6)
    assert walls[:, 2].min() == pytest.approx(points[:, 2].min(), abs=1e-6)
    # Just wider than the outline
    areas = [ConvexHull(np.unique(p[:, :2].round(6), axis=0)).volume for p in (walls, points)]
    assert areas[0] / areas[1] == pytest.approx(1.001, abs=1e-5)
    assert scene.plain["cup_2"]["type"] == "cylinder"  # of a round one
    loaded = mi.load_dict(scene.to_dict())
    loaded.integrator().check(loaded, loaded.sensors()[0])  # warnings are errors

"""Meshes that others made as stones of `gem_path` and `gem_primary`: what is mended, told and refused."""

from __future__ import annotations

import mitsuba as mi
import numpy as np
import pytest
from checked_scenes import GEM, INWARDS, SOME, mean, refused, scene, told
from meshes import ball, box, seamed_box, soup, together, turned

from gemrender.errors import GemrenderWarning
from gemrender.scene.shapes import FLAT, StoneShape

#: Mean of 32 x 32 pixels of 64 samples in a furnace: the noise of Russian roulette alone.
FURNACE = 2e-3
HOLLOW = together(box(), turned(box((0.2, 0.3, 0.25))))


# ---- Meshes that others made ---------------------------------------------------------------------------


@pytest.mark.parametrize("face_normals", [False, True])
@pytest.mark.parametrize("flip_normals", [False, True])
@pytest.mark.parametrize(
    ("mesh", "as_it_is", "flipped"),
    [
        (box(), [], [INWARDS]),
        (soup(*box()), [], [INWARDS]),
        (turned(box()), [INWARDS], []),
        (soup(*turned(box())), [INWARDS], []),
        (turned(box(), 0, 5, 7), [SOME.format(3)], [SOME.format(9)]),
    ],
    ids=["joined", "soup", "inwards", "soup inwards", "mixed"],
)
def test_a_box_cannot_be_seen_in_a_furnace(
    variant_llvm_ad_rgb, ply, mesh, as_it_is, flipped, flip_normals, face_normals
):
    # However it is wound: the solid counts
    stone = ply(mesh, flip_normals=flip_normals, face_normals=face_normals)
    box_scene = scene(gem=stone)
    assert told(box_scene) == (flipped if flip_normals else as_it_is)
    assert mean(box_scene, 16) == pytest.approx(1, abs=2 * FURNACE)


@pytest.mark.parametrize(
    "mesh", [seamed_box(), HOLLOW, turned(HOLLOW)], ids=["seamed", "hollow", "hollow inwards"]
)
def test_seamed_and_hollow_stones_cannot_be_seen_in_a_furnace(variant_llvm_ad_rgb, ply, mesh):
    stone = scene(gem=ply(mesh))
    told(stone)
    assert mean(stone) == pytest.approx(1, abs=FURNACE)


def test_the_warning_is_at_the_users_line(variant_llvm_ad_rgb, ply):
    with pytest.warns(GemrenderWarning, match=INWARDS) as caught:
        mi.render(scene(gem=ply(turned(box()))), spp=1)
    assert caught[0].filename == __file__


def test_an_open_stone_is_refused_by_its_id(variant_llvm_ad_rgb, ply):
    positions, faces = box()
    expected = "stone = 'gem': must be a closed surface; 3 edges have a face on one side only"
    open_box = scene(gem=ply((positions, faces[1:])))
    assert refused(open_box) == expected
    assert refused(open_box) == expected  # each time
    with pytest.raises(RuntimeError) as error:  # of mi.render, which wraps all errors
        mi.render(open_box, spp=1)
    assert str(error.value.__cause__) == expected


def test_an_open_stone_without_an_id_is_refused_by_its_file(variant_llvm_ad_rgb, ply):
    positions, faces = box()
    file = ply((positions, faces[1:]))["filename"]
    loaded = mi.load_string(
        '<scene version="3.0.0"><integrator type="gem_path"/><sensor type="perspective"/>'
        f'<shape type="ply"><string name="filename" value="{file}"/><bsdf type="gem_dielectric"/></shape>'
        "</scene>"
    )
    assert refused(loaded).startswith("stone = 'mesh_1.ply': must be a closed surface")


@pytest.mark.parametrize("kind", ["rectangle", "disk", "cylinder"])
def test_shapes_that_bound_no_solid_are_refused(variant_llvm_ad_rgb, kind):
    expected = f"stone = 'gem': must be closed: a mesh or a sphere, not a {kind}"
    assert refused(scene(gem={"type": kind, "bsdf": GEM})) == expected


@pytest.mark.parametrize(("flip", "expected"), [(False, []), (True, [INWARDS])])
def test_a_sphere_is_a_stone(variant_llvm_ad_rgb, flip, expected):
    ball = scene(gem={"type": "sphere", "flip_normals": flip, "bsdf": GEM})
    assert told(ball) == expected
    assert mean(ball) == pytest.approx(1, abs=FURNACE)


def test_a_shape_that_cannot_be_checked_is_told(variant_llvm_ad_rgb):
    grid = np.linspace(-1, 1, 8)
    x, y, z = np.meshgrid(grid, grid, grid, indexing="ij")
    ball = mi.TensorXf((np.sqrt(x**2 + y**2 + z**2) - 0.7)[..., None].astype(np.float32))
    expected = "stone gem is a sdfgrid; whether it is closed and apart from others is not checked"
    assert told(scene(gem={"type": "sdfgrid", "grid": ball, "bsdf": GEM})) == [expected]


def test_mitsubas_cube_is_a_stone(variant_llvm_ad_rgb):
    assert mean(scene(gem={"type": "cube", "bsdf": GEM})) == pytest.approx(1, abs=FURNACE)


# ---- Vertex normals ------------------------------------------------------------------------------------


def test_a_smooth_surface_keeps_its_normals(variant_llvm_ad_rgb, ply):
    smooth = StoneShape(mi.load_dict(ply(ball())))
    assert smooth.facing is None
    inside_out = StoneShape(mi.load_dict(ply(turned(ball()))))
    np.testing.assert_array_equal(inside_out.facing, -1)


def test_a_stone_of_thousands_of_triangles_cannot_be_seen_in_a_furnace(variant_llvm_ad_rgb, ply):
    assert mean(scene(gem=ply(ball(), face_normals=True))) == pytest.approx(1, abs=FURNACE)


def test_facets_are_flat_where_mitsuba_made_normals_up(variant_llvm_ad_rgb, ply):
    # The file has none, and the mean of three faces at a corner is that of no facet: nothing to tell
    stone = StoneShape(mi.load_dict(ply(box())))
    np.testing.assert_array_equal(stone.facing, FLAT)
    assert not stone.mended


def test_normals_of_the_file_that_are_not_the_facets_are_told(variant_llvm_ad_rgb, ply):
    positions, _ = box()
    stone = scene(gem=ply(box(), normals=np.tile([0.0, 0, 1], (len(positions), 1))))
    expected = "stone gem has vertex normals that are not those of its faces; its facets are taken as flat"
    assert told(stone) == [expected]
    assert mean(stone) == pytest.approx(1, abs=FURNACE)


# ---- gem_primary ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("surface", [None, {"type": "dielectric"}, GEM])
def test_gem_primary_refuses_stones_without_facets(variant_llvm_ad_mono, ply, surface):
    stone = ply(box())
    if surface is None:
        del stone["bsdf"]
    else:
        stone["bsdf"] = surface
    film = {"type": "hdrfilm", "width": 2, "height": 2, "pixel_format": "luminance"}
    scored = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "gem_primary"},
            "sensor": {"type": "gem_orthographic", "film": film},
            "gem": stone,
        }
    )
    with pytest.raises(RuntimeError) as error:
        mi.render(scored, spp=1)
    expected = "stone = 'gem': must be a mesh with facets and their planes, as gemrender scene writes it"
    assert str(error.value.__cause__) == expected

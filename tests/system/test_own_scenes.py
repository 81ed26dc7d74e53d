"""Scenes of one's own by Mitsuba's own means: the three lines of its tutorials, any mesh, any variant."""

from __future__ import annotations

import math

import mitsuba as mi
import numpy as np
import pytest
from meshes import box, turned, write_ply
from PIL import Image
from thorough import chosen

from gemrender.cuts import load_stone
from gemrender.errors import GemrenderWarning
from gemrender.plugins import register
from gemrender.render.photoreal import make_gems
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.setup import load_setup
from gemrender.scene.xml import write_photoreal

#: Samples a pixel, and by how many standard errors two means may differ.
SAMPLES, SIGMAS = 64, 4.0
#: Single precision.
SINGLE = 1e-5
#: Each in one test at least, and in all of them where both integrators see the same.
VARIANTS = ["llvm_ad_mono", "llvm_ad_rgb", "llvm_ad_spectral"]
ALBEDO_AND_NORMAL = ["albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z"]


def own_scene(file, integrator="gem_path", material=None, **more):
    """A user's scene: a stone from a PLY file above a grey ground, under a lamp and a sky."""
    surface = {"int_ior": 1.76} if material is None else {"material": material}
    ground = mi.ScalarTransform4f().translate([0, 0, -1.01]).scale([9, 9, 1])
    lamp = mi.ScalarTransform4f().look_at([3, 3, 6], [0, 0, 0], [0, 0, 1])
    return {
        "type": "scene",
        "integrator": {"type": integrator, **more},
        "sensor": {
            "type": "perspective",
            "fov": 40,
            "to_world": mi.ScalarTransform4f().look_at([4, 3, 5], [0, 0, 0], [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": 24, "height": 16, "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": SAMPLES},
        },
        "stone": {"type": "ply", "filename": str(file), "bsdf": {"type": "gem_dielectric", **surface}},
        "ground": {"type": "rectangle", "to_world": ground, "bsdf": {"type": "diffuse"}},
        "lamp": {"type": "rectangle", "to_world": lamp, "emitter": {"type": "area"}},
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.3}},
    }


@pytest.fixture
def ply(tmp_path):
    # Soup: vertex normals are the faces', as `path` needs them
    positions, faces = box()
    return write_ply(tmp_path / "gem.ply", (positions[faces].reshape(-1, 3), np.arange(36).reshape(-1, 3)))


def pixels(path):
    mi.Thread.wait_for_tasks()  # it is written in the background
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"), dtype=float)


# ---- The tutorials' three lines ------------------------------------------------------------------------


@pytest.mark.parametrize("variants_all", chosen(VARIANTS, ["llvm_ad_spectral"]), indirect=True)
def test_a_scene_of_ones_own_becomes_a_picture(variants_all, ply, tmp_path):
    scene = mi.load_dict(own_scene(ply, material="diamond"))
    image = mi.render(scene)
    mi.util.write_bitmap(str(tmp_path / "x.png"), image)
    picture = pixels(tmp_path / "x.png")
    assert picture.shape == (16, 24, 3)
    assert picture.std() > 5
    assert image.shape[2] == (1 if mi.is_monochromatic else 3)  # without albedo and normal


@pytest.mark.parametrize("setup", chosen(["window", "studio"], ["window"]))
def test_a_written_scene_becomes_a_picture(variant_llvm_ad_spectral, tmp_path, setup):
    gems = make_gems([load_stone("inoue-3")])
    parts = photoreal_scene(gems, load_setup(setup), width=24, height=16, samples=4)
    file = write_photoreal(tmp_path, "gem", parts, about="a stone", stock=False)
    scene = mi.load_file(str(file))
    image = mi.render(scene)
    mi.util.write_bitmap(str(tmp_path / "x.png"), image)
    picture = pixels(tmp_path / "x.png")
    assert picture.shape == (16, 24, 3)
    assert picture.std() > 5
    assert image.shape[2] == 3


# ---- Albedo and normal ---------------------------------------------------------------------------------


@pytest.mark.parametrize("variants_all", chosen(VARIANTS, ["llvm_ad_rgb"]), indirect=True)
def test_albedo_and_normal_come_when_asked_for(variants_all, ply):
    plain, asked = (mi.load_dict(own_scene(ply, aovs=aovs)) for aovs in (False, True))
    assert plain.integrator().aov_names() == []
    assert asked.integrator().aov_names() == ALBEDO_AND_NORMAL
    one, other = (np.array(mi.render(scene, spp=4)) for scene in (plain, asked))
    assert other.shape[2] == one.shape[2] + 6
    np.testing.assert_allclose(other[..., :-6], one, rtol=SINGLE)  # the light is the same
    np.testing.assert_allclose(np.linalg.norm(other[..., -3:], axis=2).max(), 1, rtol=SINGLE)


def test_normals_of_a_stone_turned_round_look_outwards(variant_llvm_ad_rgb, tmp_path):
    file = write_ply(tmp_path / "gem.ply", turned(box()))
    scene = mi.load_dict(own_scene(file, aovs=True))
    with pytest.warns(GemrenderWarning, match="stone looks inwards"):
        picture = np.array(mi.render(scene, spp=16))
    middle = picture[7:9, 11:13, -3:].mean(axis=(0, 1))  # a face of the cube that the camera sees
    assert middle @ [4, 3, 5] > 0


def test_aovs_must_be_true_or_false(variant_llvm_ad_rgb):
    with pytest.raises(RuntimeError, match="must be true or false"):
        mi.load_dict({"type": "gem_path", "aovs": 1})


# ---- Both integrators, all variants --------------------------------------------------------------------


def test_path_and_gem_path_see_the_same_in_a_users_scene(variants_all, ply):
    pictures = []
    for integrator in ("path", "gem_path"):
        more = {"max_depth": -1, "rr_depth": 1000} if integrator == "path" else {}
        scene = mi.load_dict(own_scene(ply, integrator, **more))
        means = [np.array(mi.render(scene, seed=k), dtype=float).mean() for k in range(4)]
        pictures.append((float(np.mean(means)), float(np.std(means, ddof=1)) / 2))
    (one, its_error), (other, error) = pictures
    assert one == pytest.approx(other, abs=SIGMAS * math.hypot(its_error, error) + 1e-3)


def test_plugins_follow_a_variant_that_the_user_set(variant_llvm_ad_mono, ply):
    mi.set_variant("llvm_ad_rgb")
    register()
    assert mi.render(mi.load_dict(own_scene(ply)), spp=1).shape == (16, 24, 3)

"""Scenes of pictures as gem_path takes them: nothing to mend or to tell, however the stones are turned."""

from __future__ import annotations

import numpy as np
import pytest
from solids import bent_stone

from gemrender.cuts import load_stone
from gemrender.render.backend import ensure_variant
from gemrender.render.photoreal import make_gems
from gemrender.scene.mesh import placed_mesh
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.placing import Placed
from gemrender.scene.setup import load_setup
from gemrender.scene.shapes import StoneShape
from gemrender.stone import tessellate

#: Single precision of places that are a few units from the origin.
PLACE = 1e-6


def scene_of(setup, turn_deg, stones=("inoue-1", "inoue-2", "inoue-3")):
    ensure_variant("llvm_ad_spectral")
    gems = make_gems([load_stone(name) for name in stones])
    return photoreal_scene(gems, load_setup(setup), width=16, height=16, turn_deg=turn_deg)


@pytest.mark.parametrize("setup", ["hemisphere", "studio", "window"])  # a cup, a sweep, a plane
def test_bundled_setups_need_no_mending(setup):
    # A warning is an error here: ground, cups, lights and stones touch at most
    import mitsuba as mi

    scene = mi.load_dict(scene_of(setup, 37.0).to_dict())
    scene.integrator().check(scene, scene.sensors()[0])


@pytest.mark.parametrize("culet", [0.003, 0, -0.003])
@pytest.mark.parametrize("turn_deg", [0.0, 37.0])
def test_stones_keep_their_own_normals(culet, turn_deg):
    # Hollow, as cut, and bent outwards; the girdle's are smooth, and its triangles narrow
    ensure_variant("llvm_ad_mono")
    for stretched in (1.0, 1.05):
        mesh = tessellate(bent_stone(culet, stretched=stretched))
        turn = np.radians(turn_deg)
        rotation = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
        shift = np.array([30.0, -20.0, 10.0])
        placed = Placed(name="a", mesh=mesh, rotation=rotation, scale=1.3, shift=shift)
        stone = StoneShape(placed_mesh(placed))
        assert stone.facing is None
        assert stone.mended == ""


def test_cups_turn_with_their_stones():
    scene = scene_of("hemisphere", 37.0)
    for k, stone in enumerate(scene.stones, start=1):
        np.testing.assert_allclose(scene.plain[f"cup_{k}"]["p1"], stone.shift, rtol=0, atol=PLACE)
    assert np.ptp([stone.shift[1] for stone in scene.stones]) > 1

"""Loading: shapes and lights in the order in which they are described, whatever their addresses are."""

from __future__ import annotations

import pytest

from gemrender.cuts import load_stone
from gemrender.render.photoreal import make_gems
from gemrender.scene.loading import load_scene
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.setup import load_setup


def described(setup):
    gems = make_gems([load_stone("inoue-3")])
    return photoreal_scene(gems, load_setup(setup), width=4, height=4)


@pytest.mark.parametrize("setup", ["window", "studio"])
def test_shapes_and_lights_come_in_the_order_of_the_dictionary(setup, variant_llvm_ad_spectral):
    """With Mitsuba's default they come in that of a table of addresses: on no run in this one."""
    scene = described(setup).to_dict()
    loaded = load_scene(scene)
    shapes = [key for key in scene if key.startswith(("stone_", "light_", "ground"))]
    lights = [key for key in scene if key.startswith(("light_", "sky"))]
    assert [shape.id() for shape in loaded.shapes()] == shapes
    of_light = {shape.id(): shape.emitter() for shape in loaded.shapes() if shape.is_emitter()}
    of_light["sky"] = loaded.environment()
    assert list(loaded.emitters()) == [of_light[key] for key in lights]

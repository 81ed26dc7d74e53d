"""The plugins are there in every variant, through any number of switches, and their manuals' examples run."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import drjit as dr
import mitsuba as mi
import pytest
from manuals import code_tab

import gemrender.plugins

#: As the package's own table has them.
NAMES = re.findall(r"^``(gem_\w+)`` ", gemrender.plugins.__doc__, re.MULTILINE)

SCENE = {
    "type": "scene",
    "light": {"type": "gem_hemisphere"},
    "plane": {"type": "rectangle"},
    "sensor": {
        "type": "gem_orthographic",
        "film": {"type": "hdrfilm", "width": 4, "height": 4, "pixel_format": "luminance"},
    },
    "integrator": {"type": "path", "max_depth": 2},
}


def assert_lit():
    """A class left over from another variant would be left out of the scene: no light, a black image."""
    scene = mi.load_dict(SCENE)
    assert scene.environment() is not None
    assert len(scene.emitters()) == 1
    assert len(scene.sensors()) == 1
    assert dr.all(mi.render(scene, spp=16) > 0, axis=None)


def module(name):
    return sys.modules[f"gemrender.plugins.{name}"]


def test01_mitsuba_calls_back_after_each_change_of_variant(variant_llvm_ad_mono):
    calls = []

    def callback(old, new):
        calls.append((old, new, mi.variant()))

    mi.detail.add_variant_callback(callback)
    mi.detail.add_variant_callback(callback)  # a set: added twice, called once
    try:
        mi.set_variant("llvm_ad_mono")  # no change, no call
        mi.set_variant("llvm_ad_spectral")
        mi.set_variant("llvm_ad_mono")
    finally:
        mi.detail.remove_variant_callback(callback)
    mi.set_variant("llvm_ad_spectral")
    mi.set_variant("llvm_ad_mono")
    assert calls == [
        ("llvm_ad_mono", "llvm_ad_spectral", "llvm_ad_spectral"),
        ("llvm_ad_spectral", "llvm_ad_mono", "llvm_ad_mono"),
    ]


def test02_scene_keeps_its_light_through_switches(variant_llvm_ad_mono):
    assert_lit()
    for variant in ("llvm_ad_spectral", "llvm_ad_mono", "llvm_ad_rgb"):
        mi.set_variant(variant)
        assert_lit()
    with mi.util.scoped_set_variant("llvm_ad_spectral"):
        assert_lit()
    assert mi.variant() == "llvm_ad_rgb"
    assert_lit()


def test03_scalar_variant_between_does_no_harm(variant_llvm_ad_mono):
    mi.set_variant("scalar_rgb")
    gemrender.plugins.register()  # nothing to do, and no error
    mi.set_variant("llvm_ad_mono")
    assert_lit()


def test04_register_does_nothing_where_nothing_changed(variant_llvm_ad_mono):
    before = module("hemisphere").HemisphereEmitter
    gemrender.plugins.register()
    assert module("hemisphere").HemisphereEmitter is before


def test05_register_defines_the_classes_anew_for_a_new_variant(variant_llvm_ad_mono):
    before = module("hemisphere").HemisphereEmitter
    with mi.util.scoped_set_variant("llvm_ad_rgb"):
        assert module("hemisphere").HemisphereEmitter is not before


def test06_the_table_has_every_plugin():
    sources = (path.read_text() for path in Path(gemrender.plugins.__file__).parent.glob("*.py"))
    registered = {name for text in sources for name in re.findall(r'mi\.register_\w+\("(\w+)"', text)}
    assert sorted(NAMES) == sorted(registered)


@pytest.mark.parametrize("name", NAMES)
def test07_module_registers_the_plugin_of_its_name(variant_llvm_ad_mono, name):
    plugin = mi.load_dict({"type": name})
    assert type(plugin).__module__ == f"gemrender.plugins.{name.removeprefix('gem_')}"


@pytest.mark.parametrize("name", NAMES)
def test08_examples_of_the_manual_run_and_agree(variants_all, name):
    manual = type(mi.load_dict({"type": name})).__doc__
    from_dict = mi.load_dict({"type": "scene", "example": eval(f"{{{code_tab(manual, 'python')}}}")})
    from_xml = mi.load_string(f'<scene version="3.0.0">{code_tab(manual, "xml")}</scene>')
    assert name in code_tab(manual, "python")
    assert name in code_tab(manual, "xml")
    assert described(from_dict) == described(from_xml)


def described(scene):
    """Return what the objects of a scene say of themselves; a scene's own text leaves out the sensors."""
    return [str(part) for part in (*scene.sensors(), *scene.emitters(), scene.integrator())]

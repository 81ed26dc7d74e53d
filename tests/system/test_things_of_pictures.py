"""Things and settings in pictures: no light lost among metal, glass and stones; bad ones told in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from meshes import ball, box, obj
from thorough import chosen

from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.optics import load_material
from gemrender.optics.metals import METALS
from gemrender.render.passes import Passes
from gemrender.scene.loading import load_scene
from gemrender.scene.photoreal import Gem, photoreal_scene
from gemrender.scene.settings import Setting
from gemrender.scene.setup import Camera, Setup, Sky, Thing, load_setup
from gemrender.scene.surfaces import MATERIALS, surface_of

#: Standard errors of the mean of a picture.
SIGMAS = 4.0
#: What Mitsuba's spectral variants make of a flat radiance of 1.
FLAT = 1.5e-3
GEM = Gem(
    stone=load_stone("single-cut-melee"),
    material=load_material("quartz"),
    material_name="quartz",
    diameter_mm=4.0,
)


def furnace(things=(), **more):
    """A scene in light of radiance 1 from everywhere."""
    setup = Setup(
        name="furnace",
        sky=Sky(type="uniform", radiance=1.0, spectrum="e"),
        camera=Camera(margin=1.0),
        things=tuple(things),
        **more,
    )
    return photoreal_scene([GEM], setup, width=16, height=16)


def lossless(surface):
    """The surface of a metal without its losses: a mirror of reflectance 1, as rough."""
    assert surface["type"] == "twosided"
    plain = {key: value for key, value in surface["bsdf"].items() if key not in ("eta", "k")}
    return {"type": "twosided", "bsdf": plain | ({"material": "none"} if len(plain) == 1 else {})}


@pytest.mark.parametrize("finish", chosen(["polished", "rough"], ["rough"]))
def test_a_furnace_with_a_metal_ring_and_a_ball_of_glass_is_1(variant_llvm_ad_spectral, tmp_path, finish):
    glass = Thing(
        mesh=obj(tmp_path / "ball.obj", ball(16)), material="glass", place=(-1.5, -1.5, 5.0), scale=0.8
    )
    scene = furnace([glass], setting=Setting(type="solitaire", finish=finish))
    build, surface = scene.built["setting_1"]
    scene.built["setting_1"] = (build, lossless(surface))
    assert scene.built["thing_1"][1]["type"] == "dielectric"
    passes = Passes(load_scene(scene.to_dict()), seed=3)
    image, error = passes.radiance_at(550.0, 64)
    mean, expected = image.mean(), np.sqrt((error**2).sum()) / error.size
    assert abs(mean - 1) <= SIGMAS * expected + FLAT
    assert expected < 3 * FLAT


def test_metal_reflects_what_its_index_says(variant_llvm_ad_spectral, tmp_path):
    """A level mirror below the camera, in light of radiance 1: its reflectance at normal incidence."""
    import mitsuba as mi

    for metal in METALS.values():
        to_world = mi.ScalarTransform4f().look_at([0, 0, 9], [0, 0, 0], [0, 1, 0])
        film = {"type": "hdrfilm", "width": 2, "height": 2, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
        scene = load_scene(
            {
                "type": "scene",
                "integrator": {"type": "gem_path"},
                "sky": {"type": "constant", "radiance": {"type": "uniform", "value": 1.0}},
                "plate": {"type": "rectangle", "bsdf": surface_of(metal.name)},
                "sensor": {"type": "perspective", "fov": 1.0, "to_world": to_world, "film": film},
            }
        )
        passes = Passes(scene, seed=1)
        for nm in (450.0, 550.0, 650.0):
            found = passes.radiance_at(nm, 16)[0].mean()
            # The table of the scene has steps of 10 nm
            assert found == pytest.approx(float(metal.reflectance(nm)), abs=0.015), (metal.name, nm)


@pytest.mark.parametrize("material", MATERIALS)
def test_every_material_is_loaded(variant_llvm_ad_spectral, material):
    import mitsuba as mi

    for finish in ("polished", "rough") if material in (*METALS, "glass") else ("polished",):
        assert isinstance(mi.load_dict(surface_of(material, finish=finish)), mi.BSDF)


def test_stock_materials_are_loaded(variant_llvm_ad_rgb):
    import mitsuba as mi

    for material in MATERIALS:
        assert isinstance(mi.load_dict(surface_of(material, stock=True)), mi.BSDF)


# ---- Mistakes ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"material": "brass"}, "thing 1.material = 'brass': must be one of gold, silver, platinum, glass"),
        ({"material": "pape"}, "did you mean paper?"),
        ({"mesh": "ring.step"}, "thing 1.mesh = 'ring.step': must be a file of .stl, .obj, .ply, .glb"),
        ({"mesh": "none.obj"}, "thing 1.mesh = 'none.obj': no such file"),
        ({"finish": "rough", "material": "paper"}, "thing 1.finish = 'rough': is for gold"),
        (
            {"colour": "[1, 0, 0]", "material": "gold"},
            "thing 1.colour = [1, 0, 0]: is for paper, velvet only",
        ),
        (
            {"colour": "[1, 0, 2]", "material": "paper"},
            "thing 1.colour = [1, 0, 2]: must be 3 numbers from 0 to 1",
        ),
        ({"place": "[1, 2]"}, "thing 1.place = [1, 2]: must be 3 numbers from -10000 to 10000"),
        ({"scale": "2", "unit_mm": "1"}, "thing 1.scale = 2: give scale or unit_mm, not both"),
        ({"size": "2"}, "thing 1.size = 2: unknown key"),
    ],
)
def test_a_bad_thing_is_told_in_one_line(tmp_path, keys, told):
    obj(tmp_path / "box.obj", box())
    values = {"mesh": "box.obj", "material": "gold", **keys}
    lines = [
        f"{k} = {v if k in ('colour', 'place', 'scale', 'unit_mm', 'size') else repr(v)}"
        for k, v in values.items()
    ]
    file = tmp_path / "x.toml"
    file.write_text("[sky]\nradiance = 1\n[[thing]]\n" + "\n".join(lines))
    with pytest.raises(InputError) as caught:
        load_setup(file)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_missing_of_a_thing_is_told(tmp_path):
    file = tmp_path / "x.toml"
    file.write_text("[sky]\nradiance = 1\n[[thing]]\n")
    with pytest.raises(InputError, match=r"thing 1.mesh: missing.*thing 1.material: missing"):
        load_setup(file)


@pytest.mark.parametrize(
    ("mesh", "material", "told"),
    [
        (box((0.2, 0.2, 0.2), (0, 0, 0.5)), "gold", "must not cut a stone; it reaches into Single cut"),
        (box((3, 3, 3), (0, 0, 0)), "glass", "must not have a stone inside"),
        ((box()[0] + 5, box()[1][1:]), "glass", "must be a closed surface"),
    ],
)
def test_a_thing_in_or_around_a_stone_is_refused(variant_llvm_ad_spectral, tmp_path, mesh, material, told):
    thing = Thing(mesh=obj(tmp_path / "x.obj", mesh), material=material)
    with pytest.raises(InputError, match=told):
        furnace([thing])


@pytest.mark.parametrize(
    ("setting", "told"),
    [
        ('type = "solitair"', "setting.type = 'solitair': must be one of none, solitaire, bezel, pendant"),
        ('type = "bezel"\nmetal = "lead"', "setting.metal = 'lead': must be one of gold, silver, platinum"),
    ],
)
def test_a_bad_setting_is_told_in_one_line(tmp_path, setting, told):
    file = tmp_path / "x.toml"
    file.write_text(f"[sky]\nradiance = 1\n[setting]\n{setting}\n")
    with pytest.raises(InputError) as caught:
        load_setup(file)
    assert told in str(caught.value)


def test_a_things_file_is_found_from_its_setup_and_placed(variant_llvm_ad_spectral, tmp_path, monkeypatch):
    obj(tmp_path / "box.obj", box())
    file = tmp_path / "x.toml"
    thing = 'mesh = "box.obj"\nmaterial = "velvet"\nunit_mm = 4\nturn = 90\nplace = [9, 0, 3]\nup = "y"\n'
    file.write_text(f"[sky]\nradiance = 1\n[[thing]]\n{thing}")
    monkeypatch.chdir("/")
    scene = photoreal_scene([GEM], load_setup(file), width=4, height=4)
    bounds = scene.meshes()["thing_1"].bbox()  # a stone of 4 mm: its unit is 2 mm
    np.testing.assert_allclose(np.array([bounds.min, bounds.max]), [[7, -2, 1], [11, 2, 5]], atol=1e-5)


# ---- On the command line -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--metal", "gold"], "--metal = 'gold': is for a setting; give one too, as solitaire"),
        (["--setting", "bezl"], "must be one of none, solitaire, bezel, pendant; did you mean bezel?"),
        (
            ["--setting", "bezel", "--metal", "lead"],
            "--metal = 'lead': must be one of platinum, gold, silver",
        ),
        (["--setting", "bezel", "--setup", "hemisphere"], "--setting = 'bezel': must be none in a cup"),
        (["--girdle", "rough"], "--girdle = 'rough': must be one of polished, faceted, bruted"),
    ],
)
def test_options_that_cannot_be_are_told_in_one_line(gemrender, folder, options, told):
    status, out, err = gemrender("render", "inoue-3", "-o", "x.png", *options)
    assert (status, out) == (2, "")
    assert err.rstrip("\n").endswith(told)
    assert err.count("\n") == 1
    assert not Path("x.png").exists()


def test_a_scene_with_a_setting_is_written_and_read_back(gemrender, folder, variant_llvm_ad_spectral):
    import mitsuba as mi

    options = ["--setup", "window", "--setting", "bezel", "--metal", "gold", "--girdle", "bruted"]
    assert gemrender("scene", "baguette-three", "-o", "s", *options, "--size", "4")[0] == 0
    scene = mi.load_file("s/baguette-three-window.xml", optimize=False)
    surfaces = [shape.bsdf() for shape in scene.shapes()]
    assert sum("SmoothConductor" in str(surface) for surface in surfaces) == 1
    (stone,) = (surface for surface in surfaces if type(surface).__name__ == "GemDielectric")
    assert stone.girdle_alpha == pytest.approx(0.4)


def test_a_faceted_girdle_is_of_facets_within_the_round_one(variant_llvm_ad_spectral):
    scene = photoreal_scene(
        [GEM], Setup(name="x", sky=Sky(radiance=1.0), girdle="faceted"), width=4, height=4
    )
    (stone,) = scene.stones
    level = stone.planes()[np.abs(stone.planes()[:, 2]) < 1e-9]
    assert len(np.unique(level.round(9), axis=0)) == 64
    np.testing.assert_allclose(level[:, 3] - level[:, :3] @ stone.shift, np.cos(np.pi / 64), atol=1e-9)

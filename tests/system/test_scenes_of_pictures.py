"""`gemrender scene --setup`: scenes of pictures, for Mitsuba's own program and for gemrender's plugins."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
from render_help import (
    HEMISPHERE,
    MITSUBA,
    luminance,
    names,
    read_exr,
)
from thorough import chosen

from gemrender.scene.setup import bundled_setups

#: Large lights on a sweep: small ones would be found by chance.
TENT = """
pose = "lying"
[camera]
elevation = 30
[[light]]
shape = "rectangle"
elevation = 65
azimuth = 90
distance = 9
size = [9, 6]
radiance = 3
[[light]]
shape = "rectangle"
elevation = 25
azimuth = 180
distance = 10
size = [5, 5]
radiance = 1.6
[sky]
radiance = 0.35
[ground]
type = "sweep"
reflectance = 0.88
"""


#: With all kinds of ground and of light that bundled set-ups have.
SOME = ["studio", "hemisphere", "hand", "loupe", "sun", "aset"]


@pytest.mark.skipif(not MITSUBA.exists(), reason="needs Mitsuba's program")
@pytest.mark.parametrize("setups", chosen([SOME, bundled_setups()], [SOME]), ids=["some", "all"])
def test_stock_scenes_are_rendered_by_mitsubas_own_program(setups, gemrender, folder):
    """By one process of it."""
    names = []
    for setup in setups:
        options = ["--setup", setup, "--stock", "--size", "24x16", "--spp", "4"]
        status, out, err = gemrender("scene", "inoue-3", "inoue-1", "--out", "s", *options)
        path = Path(f"s/inoue-3-inoue-1-{setup}.xml")
        assert (status, out, err) == (0, "", f"written: {path}\n")
        text = path.read_text(encoding="utf-8")
        assert "gem_" not in text
        assert f"mitsuba {path.name}" in text.partition("-->")[0]
        names.append(path.name)
    done = subprocess.run(
        [str(MITSUBA), "-m", "scalar_rgb", *names], cwd="s", capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    for name in names:
        image = luminance(Path("s", name).with_suffix(".exr"))
        assert image.shape == (16, 24), name
        assert image.max() > 0.01, name


@pytest.mark.skipif(not MITSUBA.exists(), reason="needs Mitsuba's program")
@pytest.mark.parametrize(
    ("setup", "within"),
    chosen([("hemisphere", 0.02), ("tent.toml", 0.03), ("black.toml", 0.03)], [("tent.toml", 0.03)]),
)
def test_a_stock_scene_shows_what_the_picture_without_dispersion_shows(setup, within, gemrender, folder):
    Path("tent.toml").write_text(TENT)
    Path("black.toml").write_text(TENT.replace("0.88", "0.0"))  # what it takes of the stone's light is seen
    options = ["--setup", setup, "--size", "16", "--spp", "128"]
    assert gemrender("render", "inoue-3", "-o", "a.exr", *options, "--no-dispersion")[0] == 0
    assert gemrender("scene", "inoue-3", "--out", ".", "--stock", *options)[0] == 0
    command = [str(MITSUBA), "-m", "scalar_rgb", f"inoue-3-{Path(setup).stem}.xml", "-o", "x.exr"]
    subprocess.run(command, capture_output=True, check=True, timeout=60)
    assert luminance("x.exr").mean() == pytest.approx(luminance("a.exr").mean(), rel=within)


@pytest.mark.parametrize("setup", chosen(["hemisphere", "window", "white"], ["white"]))
def test_a_scene_is_read_back_and_rendered(setup, gemrender, folder, variant_llvm_ad_spectral):
    import mitsuba as mi

    options = ["--setup", setup, "--size", "16", "--spp", "4", "--material", "ruby", "--carat", "2"]
    status, out, err = gemrender("scene", "inoue-3", "--out", "s", *options)
    assert (status, out, err) == (0, "", f"written: s/inoue-3-{setup}.xml\n")
    sweep = setup == "white"
    meshes = {f"inoue-3-{setup}_stone_1.ply", f"inoue-3-{setup}_ground.ply"}
    assert names("s") == {f"inoue-3-{setup}.xml", *(meshes if sweep else {f"inoue-3-{setup}.ply"})}
    scene = mi.load_file(f"s/inoue-3-{setup}.xml")
    assert type(scene.integrator()).__name__ == "PathIntegrator"
    surfaces = [str(shape.bsdf()) for shape in scene.shapes()]
    assert sum("material = ruby" in surface for surface in surfaces) == 1
    image = np.asarray(mi.render(scene))[..., :3]
    assert image.shape == (16, 16, 3)
    assert np.isfinite(image).all()
    assert image.max() > 0.01


def test_a_scene_read_back_is_the_picture(gemrender, folder, variant_llvm_ad_spectral):
    import mitsuba as mi

    options = [*HEMISPHERE, "--size", "16", "--material", "blue sapphire", "--diameter", "9"]
    assert gemrender("render", "inoue-1", "inoue-3", "-o", "a.exr", *options, "--spp", "64")[0] == 0
    assert gemrender("scene", "inoue-1", "inoue-3", "--out", "s", *options)[0] == 0
    image = np.asarray(mi.render(mi.load_file("s/inoue-1-inoue-3-hemisphere.xml"), spp=256))[..., :3]
    rendered, _ = read_exr("a.exr")
    for k, channel in enumerate("RGB"):
        assert image[..., k].mean() == pytest.approx(rendered[channel].mean(), rel=0.03), channel


def test_a_material_file_is_found_from_any_folder(gemrender, folder, monkeypatch, variant_llvm_ad_spectral):
    import mitsuba as mi

    Path("glass.toml").write_text('name = "Glass"\n[index]\nwavelength_nm = [380, 760]\nn = [1.6, 1.5]\n')
    assert gemrender("scene", "inoue-3", "--out", "s", *HEMISPHERE, "--material", "glass.toml")[0] == 0
    monkeypatch.chdir("/")
    scene = mi.load_file(str(folder / "s/inoue-3-hemisphere.xml"), resx=4, resy=4, spp=1)
    assert any("material = Glass" in str(shape.bsdf()) for shape in scene.shapes())


def test_a_scene_is_named_after_its_stones_and_its_setup(gemrender, folder):
    Path("Mein Licht.toml").write_text("[sky]\nradiance = 1\n")
    stones = ["inoue-1", "inoue-3", "inoue-1", "tolkowsky"]
    assert gemrender("scene", *stones, "--out", "s", "--setup", "Mein Licht.toml", "--size", "4")[0] == 0
    stem = "inoue-1-inoue-3-inoue-1-2-mein-licht"
    assert names("s") == {f"{stem}.xml", *(f"{stem}_stone_{k}.ply" for k in range(1, 5))}

"""Lights of set-ups: whatever is allowed makes a picture of numbers, and a radiance means what it says."""

from __future__ import annotations

import runpy
import sys
from dataclasses import replace

import numpy as np
import pytest
from observations import ROOT
from thorough import chosen

from gemrender.cuts import load_stone
from gemrender.errors import GemrenderWarning, InputError
from gemrender.render.backend import ensure_variant
from gemrender.render.finish import developed, exposure_of
from gemrender.render.photoreal import make_gems, render
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.setup import Camera, Ground, Light, Setup, Sky, load_setup
from gemrender.scene.xml import write_photoreal

#: Single precision, of spectra and of sums over wavelengths and samples.
SINGLE = 2e-6
#: Luminance of a flat spectrum from some hundred wavelengths that are drawn evenly.
DRAWN_WAVELENGTHS = 0.01

#: A light that the camera looks at from behind, edge-on to itself; nothing else is seen.
BEHIND_A_DISC = Setup(
    name="test set-up",
    camera=Camera(elevation=88, distance=19, margin=1.4),
    lights=(Light(shape="disc", elevation=90, azimuth=0, distance=14, size=5, radiance=4),),
    sky=Sky(type="hemisphere", radiance=0.3),
    ground=Ground(type="plane", reflectance=0.85),
)


def picture_of(setup, size=16, spp=16, **options):
    return render(make_gems([load_stone("inoue-3")]), setup, width=size, height=size, spp=spp, **options)


def scaled(setup, factor):
    return replace(
        setup,
        sky=replace(setup.sky, radiance=setup.sky.radiance * factor),
        lights=tuple(replace(light, radiance=light.radiance * factor) for light in setup.lights),
    )


def test_a_light_seen_edge_on_makes_no_sample_that_is_no_number():
    """The density of a point of a disc, as seen from the disc, is finite, its square is not.

    Weights by squares have some ten samples of this picture that are no numbers.
    """
    with pytest.warns(GemrenderWarning, match="^no stone is seen in the picture: something stands between"):
        picture = picture_of(BEHIND_A_DISC, size=64, spp=32)
    assert picture.left_out == 0
    np.testing.assert_array_equal(picture.xyz, 0)


@pytest.mark.parametrize(
    ("density", "other", "weight"),
    [(2, 0, 1), (1, 1, 0.5), (3, 1, 0.9), (0, 1, 0), (0, 0, 0), (1e-30, 1e30, 0), (1e30, 1e-30, 1),
     (1e30, 1e30, 0.5), (1, np.inf, 0), (np.inf, 1, 1), (1e-44, 1e-44, 0.5)],
)  # fmt: skip
def test_the_weight_of_two_densities_is_a_number(density, other, weight, variant_llvm_ad_spectral):
    import mitsuba as mi

    mis_weight = sys.modules["gemrender.plugins.direct"].mis_weight
    assert mis_weight(mi.Float(density), mi.Float(other))[0] == pytest.approx(weight, rel=SINGLE)


@pytest.mark.parametrize("setups", chosen(["1", "20"], ["1"]))
def test_random_setups_make_pictures_of_numbers(setups, monkeypatch, capsys):
    script = str(ROOT / "scripts" / "fuzz_setups.py")
    options = ["--setups", setups, "--size", "8", "--samples", "2", "--seed", "4", "--show"]
    monkeypatch.setattr(sys, "argv", [script, *options])
    status = runpy.run_path(script)["main"]()
    told = capsys.readouterr().out
    assert status == 0, told
    wrong = "samples left out", "not finite or negative", "refused without a reason", "traceback"
    assert ", ".join(f"{name} 0" for name in wrong) in told
    assert "rendered 0" not in told


# ---- Radiance ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("setup", chosen(["hemisphere", "window"], ["window"]))
def test_a_picture_goes_with_the_radiance(setup):
    """In linear values, as its noise does not; and its exposure is the reciprocal, so the PNG is the same."""
    around = load_setup(setup)
    one = picture_of(around)
    shown = developed(one, around, exposure=exposure_of(one, around)).astype(int)
    for factor in (1e-15, 3e5):  # no power of two
        dimmed = scaled(around, factor)
        other = picture_of(dimmed)
        np.testing.assert_allclose(other.xyz / factor, one.xyz, rtol=10 * SINGLE, atol=0)
        assert other.noise == pytest.approx(one.noise, rel=SINGLE)
        exposure = exposure_of(other, dimmed)
        assert exposure * factor == pytest.approx(exposure_of(one, around), rel=10 * SINGLE)
        assert np.abs(developed(other, dimmed, exposure=exposure).astype(int) - shown).max() <= 1


@pytest.mark.parametrize("radiance", [1e-20, 1.0, 1e9])
def test_what_is_seen_of_a_light_is_its_radiance(radiance):
    """Under a sky as bright: its surface is black, and reflects nothing of the sky."""
    ball = Light(shape="sphere", elevation=0, azimuth=0, distance=2.0, size=1.2, radiance=radiance)
    around = Setup(
        name="a", camera=Camera(elevation=0, margin=2.5), lights=(ball,), sky=Sky(radiance=radiance)
    )
    picture = picture_of(around, size=24, spp=64)
    of_ball = (picture.coverage == 1) & (picture.albedo.max(axis=-1) == 0)
    assert of_ball.sum() > 5
    np.testing.assert_allclose(picture.xyz[of_ball, 1].mean() / radiance, 1, rtol=DRAWN_WAVELENGTHS)


@pytest.mark.parametrize("radiance", [1e-21, 5e-324, 1.1e9])
def test_other_radiances_are_refused(radiance):
    for make in (lambda: Sky(radiance=radiance), lambda: Light(shape="disc", radiance=radiance)):
        with pytest.raises(InputError, match=r"^radiance = \S+: must be (0 or|a number) from .* 1e\+09$"):
            make()


# ---- A light of radiance 0 -----------------------------------------------------------------------------


def flagged(**light):
    disc = Light(shape="disc", elevation=90, distance=20, size=12, **light)
    camera = Camera(elevation=90, distance=19)
    return Setup(name="flag", camera=camera, lights=(disc,), sky=Sky(type="hemisphere", radiance=1))


def test_a_light_of_radiance_0_is_a_black_screen():
    """Behind the eye, it takes from the stone what it hides of the sky, as a very dim light does."""
    black, dim = picture_of(flagged(radiance=0)), picture_of(flagged(radiance=1e-9))
    bare = picture_of(replace(flagged(radiance=0), lights=()))
    np.testing.assert_allclose(black.xyz, dim.xyz, atol=1e-6)
    assert black.xyz[..., 1].mean() < 0.95 * bare.xyz[..., 1].mean()


def test_a_black_screen_hides_what_is_behind_it():
    screen = Light(shape="disc", elevation=90, distance=10, radiance=0)
    hidden = replace(flagged(radiance=0), lights=(screen,))
    with pytest.warns(GemrenderWarning, match="^no stone is seen"):
        picture = picture_of(hidden, size=8, spp=4)
    np.testing.assert_array_equal(picture.xyz, 0)
    assert picture.noise_of == "picture"


@pytest.mark.parametrize("stock", [False, True])
def test_a_black_screen_is_written_as_a_scene(tmp_path, stock):
    import mitsuba as mi

    ensure_variant("llvm_ad_spectral")
    gems = make_gems([load_stone("inoue-3")])
    for shape in ("disc", "rectangle", "ring", "sphere"):
        screen = Light(shape=shape, elevation=90, distance=10, size=(4, 0.5), count=2, radiance=0)
        around = replace(flagged(radiance=1), lights=(screen,))
        scene = photoreal_scene(gems, around, width=4, height=4, stock=stock)
        made = mi.load_file(str(write_photoreal(tmp_path, shape, scene, about="a", stock=stock)))
        assert not any(one.is_emitter() for one in made.shapes())

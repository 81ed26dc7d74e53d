"""Noise told from two halves, and samples that are no light: left out, counted, and never taken for a 0."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from thorough import chosen

from gemrender.cuts import load_stone
from gemrender.errors import GemrenderError, GemrenderWarning
from gemrender.render.backend import ensure_variant
from gemrender.render.noise import relative_error
from gemrender.render.passes import Passes
from gemrender.render.photoreal import make_gems, render
from gemrender.scene.loading import load_scene
from gemrender.scene.photoreal import photoreal_scene
from gemrender.scene.setup import load_setup

#: Of a million draws: their own scatter.
MANY_DRAWS = 0.005


@pytest.mark.parametrize("samples", [(1, 1), (10, 30)])
def test_the_error_of_the_mean_of_two_halves(samples, rng):
    a, b = (5 + rng.normal(0, 1 / np.sqrt(n), 10**6) for n in samples)
    assert relative_error(a, b, samples) == pytest.approx(1 / np.sqrt(sum(samples)) / 5, rel=MANY_DRAWS)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_never_without_noise(bad):
    assert relative_error(np.array([1, bad]), np.ones(2), (1, 1)) == np.inf
    assert relative_error(np.zeros(2), np.array([0, bad]), (1, 1)) == np.inf


def test_black_is_without_noise():
    assert relative_error(np.zeros(3), np.zeros(3), (1, 1)) == 0


# ---- Samples that are no light -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scene():
    ensure_variant("llvm_ad_spectral")
    gems = make_gems([load_stone("inoue-3")])
    return load_scene(photoreal_scene(gems, load_setup("hemisphere"), width=8, height=8).to_dict())


def corrupt(monkeypatch, value, lanes):
    """Let the integrator return a radiance of `value` in the first samples of each tile."""
    import drjit as dr
    import mitsuba as mi

    integrator = sys.modules["gemrender.plugins.path"].PathIntegrator
    trace = integrator.sample_with_aovs

    def corrupted(self, scene, samples, ray, *args, **options):
        radiance, valid, aovs = trace(self, scene, samples, ray, *args, **options)
        first = dr.arange(mi.UInt32, dr.width(ray)) < dr.opaque(mi.UInt32, lanes)  # one kernel for all
        return dr.select(first, dr.opaque(mi.Float, value), radiance), valid, aovs

    monkeypatch.setattr(integrator, "sample_with_aovs", corrupted)


@pytest.mark.parametrize("value", chosen([np.nan, np.inf, -np.inf, -1.0], [np.inf, -1.0]))
def test_a_sample_that_is_no_light_is_left_out_and_counted(scene, monkeypatch, value):
    whole, passes = Passes(scene), Passes(scene)
    for one in (whole, passes):
        if one is passes:
            corrupt(monkeypatch, value, 3)
        one.add(16)
        one.add(16)
    assert (whole.unsound, passes.unsound) == (0, 2 * 3)
    assert np.isfinite(passes.xyz).all()
    np.testing.assert_array_equal(passes.xyz[1:], whole.xyz[1:])  # the first pixel's samples come first
    assert (passes.xyz[0, 0] <= whole.xyz[0, 0]).all()
    assert np.isfinite(passes.noise())


def test_a_picture_of_nothing_but_such_samples_has_no_noise_to_tell(scene, monkeypatch):
    corrupt(monkeypatch, np.nan, 1 << 30)
    passes = Passes(scene)
    passes.add(4)
    passes.add(4)
    assert passes.noise() == np.inf


def test_few_are_told_and_many_are_an_error(monkeypatch):
    ensure_variant("llvm_ad_spectral")
    gems, around = make_gems([load_stone("inoue-3")]), load_setup("hemisphere")
    size = {"width": 64, "height": 64, "spp": 16}
    with monkeypatch.context() as few:
        corrupt(few, np.nan, 2)
        told = "^2 of 65536 samples had a radiance that is negative or not finite; they are left out$"
        with pytest.warns(GemrenderWarning, match=told):
            picture = render(gems, around, **size)
    assert picture.left_out == 2
    assert np.isfinite(picture.xyz).all()
    corrupt(monkeypatch, np.nan, 1000)
    with pytest.raises(GemrenderError, match=r"^1000 of 65536 samples had a radiance"):
        render(gems, around, **size)

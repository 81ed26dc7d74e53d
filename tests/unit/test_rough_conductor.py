"""The surface ``gem_rough_conductor``: no light is lost, light and eye may change places."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from gemrender.errors import InputError
from gemrender.optics.metals import METALS
from gemrender.optics.microfacets import COSINES, single_albedo
from gemrender.scene.surfaces import surface_of

ROUGHNESSES = (0.05, 0.2, 0.6)
#: Directions that are drawn, and how far off means over them are at most; the table's steps too.
N_DRAWN, DRAWN = 1 << 19, 3e-3
#: Single precision.
SINGLE = 1e-5


def interaction(cos, n=1):
    si = dr.zeros(mi.SurfaceInteraction3f, n)
    si.wi = mi.Vector3f(float(np.sqrt(1 - cos * cos)), 0, cos)
    if mi.is_spectral:
        si.wavelengths = mi.Spectrum(550.0)
    return si


def numbers(seed=1):
    """Random numbers of a choice, and of a direction."""
    chance, *place = np.random.default_rng(seed).random((3, N_DRAWN)).astype(np.float32)
    return mi.Float(chance), mi.Point2f(*(mi.Float(x) for x in place))


@pytest.mark.parametrize("alpha", ROUGHNESSES)
@pytest.mark.parametrize("cos", [1.0, 0.5, 0.1])
def test_a_mirror_of_any_roughness_reflects_all(variant_llvm_ad_spectral, alpha, cos):
    rough = mi.load_dict({"type": "gem_rough_conductor", "alpha": alpha})
    si, ctx = interaction(cos, N_DRAWN), mi.BSDFContext()
    _, weight = rough.sample(ctx, si, *numbers())
    assert np.mean(weight) == pytest.approx(1, abs=DRAWN)


def test_a_mirror_reflects_all_of_unpolarised_light_in_polarised_variants(variant_llvm_ad_mono_polarized):
    rough = mi.load_dict({"type": "gem_rough_conductor", "alpha": 0.4})
    _, weight = rough.sample(mi.BSDFContext(), interaction(0.5, N_DRAWN), *numbers())
    assert np.mean(mi.unpolarized_spectrum(weight)) == pytest.approx(1, abs=DRAWN)


@pytest.mark.parametrize("alpha", ROUGHNESSES)
def test_the_first_bounce_is_that_of_mitsuba(variant_llvm_ad_spectral, alpha):
    single = mi.load_dict(
        {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": alpha}
    )
    albedo, average = single_albedo(alpha)
    for cos in (1.0, 0.75, 0.25):
        _, weight = single.sample(mi.BSDFContext(), interaction(cos, N_DRAWN), *numbers())
        assert np.mean(weight) == pytest.approx(np.interp(cos, COSINES, albedo), abs=DRAWN)
    mean = 2 * np.trapezoid(albedo * COSINES, COSINES)
    assert average == pytest.approx(mean, abs=DRAWN)


def test_light_and_eye_may_change_places(variant_llvm_ad_spectral):
    rough = mi.load_dict(surface_of("gold", finish="rough"))
    ctx = mi.BSDFContext()
    for cos, other in ((0.9, 0.2), (0.5, 0.7)):
        there = rough.eval(ctx, interaction(cos), interaction(other).wi)
        back = rough.eval(ctx, interaction(other), interaction(cos).wi)
        np.testing.assert_allclose(np.ravel(there) / other, np.ravel(back) / cos, rtol=SINGLE)


@pytest.mark.parametrize("metal", METALS)
def test_metal_gives_back_less_than_it_gets_and_more_than_the_first_bounce(variant_llvm_ad_spectral, metal):
    si, ctx = interaction(0.6, N_DRAWN), mi.BSDFContext()
    rough = mi.load_dict(surface_of(metal, finish="rough")["bsdf"])
    whole = np.mean(rough.sample(ctx, si, *numbers())[1])
    single = np.mean(rough.single.sample(ctx, si, *numbers())[1])
    of_first, _ = single_albedo(rough.alpha)
    missing = 1 - np.interp(0.6, COSINES, of_first)
    mean = float(METALS[metal].reflectance(550.0))  # at normal incidence; on average a little more
    assert single + 0.7 * mean**2 * missing < whole < single + missing


@pytest.mark.parametrize("cos", [0.9, 0.3])
def test_directions_are_drawn_as_their_density_says(variant_llvm_ad_spectral, cos):
    from mitsuba.chi2 import BSDFAdapter, ChiSquareTest, SphericalDomain

    sample, density = BSDFAdapter("gem_rough_conductor", '<float name="alpha" value="0.4"/>',
                                  wi=[float(np.sqrt(1 - cos * cos)), 0, cos])  # fmt: skip
    test = ChiSquareTest(SphericalDomain(), sample, density, sample_dim=3, sample_count=200_000, res=51)
    assert test.run(0.01, 2), test.messages


@pytest.mark.parametrize("alpha", [0, 1.5, True])
def test_a_roughness_out_of_range_is_refused(variant_llvm_ad_spectral, alpha):
    with pytest.raises(RuntimeError, match="alpha") as caught:
        mi.load_dict({"type": "gem_rough_conductor", "alpha": alpha})
    assert "must be" in str(caught.value)
    assert InputError.__name__ in str(caught.value) or isinstance(caught.value, InputError)

"""The compiled facet of a birefringent stone beside the reference's, and what it must keep."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from crystals_help import KINDS, crystals, directions

from gemrender.beam.modes import optical_crystal
from gemrender.beam.modes.shares import empty_facet, meet, ray_of, wave_vector_of, write_entering
from gemrender.beam.modes.waves import BACK
from gemrender.errors import InputError
from gemrender.optics.crystals import Indicatrix, enter, leave
from gemrender.optics.fresnel import reflectance

#: Some hundred operations, and boundaries that are met at half a degree or more from grazing.
SHARES = 1e-12
#: Waves with less flux than this run along the boundary: both ways lose their digits.
GRAZING = 1e-2


def random_cases(seed, n, kind):
    """Yield crystals, normals, tangential wave vectors that light in air has, or which are total."""
    rng = np.random.default_rng(seed)
    of, normal = crystals(rng, n, kind), directions(rng, n)
    along = np.cross(normal, directions(rng, n))
    along *= (rng.uniform(0, 1, n) * of.indices.min(axis=1) / np.linalg.norm(along, axis=1))[:, None]
    for i in range(n):
        one = Indicatrix(of.indices[i], of.frame[i], of.has_optic_axis)
        yield one, optical_crystal(one.indices, one.frame), normal[i], along[i]


@numba.njit
def waves_back(kx, ky, kz, facet, out):
    for m in range(2):
        x, y, z = wave_vector_of(BACK + m, kx, ky, kz, facet)
        out[0, m, 0], out[0, m, 1], out[0, m, 2] = x, y, z
        x, y, z = ray_of(BACK + m, facet)
        out[1, m, 0], out[1, m, 1], out[1, m, 2] = x, y, z


def back_of(k, facet):
    out = np.zeros((2, 2, 3))
    waves_back(*k, facet, out)
    return out


@pytest.mark.parametrize("kind", KINDS)
def test_light_is_shared_as_by_the_reference(kind):
    facet, compared = empty_facet(), 0
    for one, crystal, normal, along in random_cases(1, 120, kind):
        left = leave(normal, along, one)
        for mode in range(2):
            if left.incident.flux[mode] < GRAZING or np.abs(left.waves.flux).min() < GRAZING:
                continue
            k = along + left.incident.k[mode, 2].real * normal
            passed = meet(crystal, *normal, *k, mode, facet)
            np.testing.assert_allclose(passed, left.transmitted[:, mode].sum(), rtol=0, atol=SHARES)
            np.testing.assert_allclose(facet.reflected, left.reflected[:, mode], rtol=0, atol=SHARES)
            waves, rays = back_of(k, facet)
            np.testing.assert_allclose(rays, left.waves.ray @ left.axes, rtol=0, atol=SHARES)
            np.testing.assert_allclose(waves @ normal, left.waves.k[:, 2].real, rtol=0, atol=SHARES)
            compared += 1
    assert compared > 80


@pytest.mark.parametrize("kind", KINDS)
def test_light_enters_as_by_the_reference(kind):
    facet, compared = empty_facet(), 0
    for one, crystal, normal, along in random_cases(2, 120, kind):
        if np.linalg.norm(along) < 0.99:
            into = enter(normal, along, one)
            write_entering(crystal, *normal, *along, facet)
            np.testing.assert_allclose(facet.entering, into.transmitted.mean(axis=1), rtol=0, atol=SHARES)
            compared += 1
    assert compared > 40


@pytest.mark.parametrize("kind", KINDS)
def test_no_energy_is_lost(kind):
    facet = empty_facet()
    for one, crystal, normal, along in random_cases(3, 120, kind):
        left = leave(normal, along, one)
        for mode in range(2):
            if left.incident.flux[mode] > GRAZING:
                k = along + left.incident.k[mode, 2].real * normal
                passed = meet(crystal, *normal, *k, mode, facet)
                assert passed + facet.reflected.sum() == pytest.approx(1.0, abs=SHARES)


@pytest.mark.parametrize("kind", KINDS)
def test_unpolarised_light_enters_a_mode_as_half_of_what_leaves_of_it_reversed(kind):
    facet, compared = empty_facet(), 0
    for _, crystal, normal, along in random_cases(4, 100, kind):
        if np.linalg.norm(along) > 0.99:
            continue
        write_entering(crystal, *normal, *along, facet)
        entering, waves = facet.entering.copy(), back_of(along, facet)[0]
        for mode in range(2):
            assert meet(crystal, *normal, *-waves[mode], mode, facet) == pytest.approx(
                2 * entering[mode], abs=SHARES
            )
            compared += 1
    assert compared > 40


@pytest.mark.parametrize("kind", KINDS)
def test_a_reflection_reversed_has_the_same_share(kind):
    facet, compared = empty_facet(), 0
    for one, crystal, normal, along in random_cases(5, 100, kind):
        left = leave(normal, along, one)
        if min(left.incident.flux.min(), np.abs(left.waves.flux).min()) < GRAZING:
            continue
        k = along + left.incident.k[0, 2].real * normal
        meet(crystal, *normal, *k, 0, facet)
        there, waves = facet.reflected.copy(), back_of(k, facet)[0]
        for mode in range(2):
            meet(crystal, *normal, *-waves[mode], mode, facet)
            assert facet.reflected[0] == pytest.approx(there[mode], abs=SHARES)
            compared += 1
    assert compared > 40


@pytest.mark.parametrize("angle", [0.0, 10.0, 30.0, 60.0, 80.0])
def test_without_birefringence_both_modes_together_are_fresnels(angle):
    crystal, facet, sine = (
        optical_crystal((1.7, 1.7, 1.7), np.eye(3)),
        empty_facet(),
        np.sin(np.radians(angle)),
    )
    write_entering(crystal, 0.0, 0.6, 0.8, sine, 0.0, 0.0, facet)
    assert facet.entering.sum() == pytest.approx(
        1 - float(reflectance(np.array([np.cos(np.radians(angle))]), 1.7)[0]), abs=SHARES
    )


def test_along_the_optic_axis_two_modes_share_alike():
    """The light is unpolarised, and no direction across the axis is another's better."""
    crystal, facet = optical_crystal((1.76, 1.76, 1.77), np.eye(3)), empty_facet()
    write_entering(crystal, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, facet)
    transmittance = 1 - (0.76 / 2.76) ** 2
    np.testing.assert_allclose(facet.entering, transmittance / 2, rtol=0, atol=SHARES)
    for mode in range(2):
        assert meet(crystal, 0.0, 0.0, 1.0, 0.0, 0.0, 1.76, mode, facet) == pytest.approx(
            transmittance, abs=SHARES
        )


@pytest.mark.parametrize(
    ("principal", "axes", "key"),
    [
        ((1.7, 1.7), np.eye(3), "principal"),
        ((1.7, 1.7, 0.9), np.eye(3), "principal"),
        ((1.7, 1.7, np.nan), np.eye(3), "principal"),
        ((1.7, 1.7, 1.8), np.ones((3, 3)), "axes"),
        ((1.7, 1.7, 1.8), np.eye(2), "axes"),
    ],
)
def test_what_is_no_crystal_is_refused(principal, axes, key):
    with pytest.raises(InputError) as caught:
        optical_crystal(principal, axes)
    assert caught.value.key == key

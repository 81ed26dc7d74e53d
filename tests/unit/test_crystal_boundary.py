"""Boundaries of birefringent crystals: energy, reciprocity and Fresnel's limit, over random cases."""

from __future__ import annotations

import numpy as np
import pytest
from crystals_help import KINDS, at_right_angles, coming, crystals, directions, frames, not_lost
from thorough import chosen

from gemrender.optics.crystals import (
    Indicatrix,
    enter,
    leave,
    modes_along,
    optic_axes,
    shares_entering,
    shares_inside,
)
from gemrender.optics.crystals.boundary import MOST_LOST
from gemrender.optics.fresnel import reflectance_polarised

#: Issue of the crystals: energy in is energy out, and light and eye may be swapped, to this.
ENERGY = 1e-12
RECIPROCITY = 1e-12
#: Maxwell's equations of a wave whose terms are of order 10, after some hundred operations.
MAXWELL = 1e-12
#: A wave vector that is found again: near grazing its normal component is a square root of rounding.
SAME_WAVE = 1e-9
#: Fresnel's equations by way of the sine, at cosines from 0.02 on.
FRESNEL = 1e-12


#: The same where biaxial waves are next to one another: their fields are told apart by rounding over the gap.
NEXT_TO = 1e-11
#: Flux below which a wave runs along the boundary within rounding (1e-16 under a square root and more).
ALONG = 1e-6


@pytest.fixture(params=chosen([2_000, 10_000], [2_000]))
def n(request):
    """How many random cases."""
    return request.param


#: Light goes through in a fifth of the cases, less three deviations of 2000: sqrt(0.2 * 0.8 / 2000) = 0.009.
OFTEN = 0.17


def totals(result):
    return result.reflected.sum(axis=-2) + result.transmitted.sum(axis=-2)


def assert_energy_is_kept(left):
    total = totals(left)
    np.testing.assert_allclose(total[left.incident.propagating], 1.0, rtol=0, atol=MOST_LOST)
    np.testing.assert_allclose(total[left.incident.flux > ALONG], 1.0, rtol=0, atol=ENERGY)


@pytest.mark.parametrize("kind", KINDS)
def test_energy_that_enters(kind, n):
    rng = np.random.default_rng(1)
    crystal, normal = crystals(rng, n, kind), directions(rng, n)
    outside = rng.uniform(1.0, 2.0, n)  # denser than some: total reflection from outside too
    entered = enter(normal, outside[:, None] * directions(rng, n), crystal, outside)
    np.testing.assert_allclose(totals(entered), 1.0, rtol=0, atol=ENERGY)
    assert (~entered.waves.propagating).any()
    assert not entered.waves.propagating.any(axis=-1).all()


@pytest.mark.parametrize("mode", [0, 1])
@pytest.mark.parametrize("kind", KINDS)
def test_energy_that_leaves(kind, mode, n):
    rng = np.random.default_rng(2)
    crystal, outside = crystals(rng, n, kind), rng.uniform(1.0, 1.7, n)
    k, normal = coming(directions(rng, n), directions(rng, n), crystal, mode)
    left = leave(normal, k, crystal, outside)
    propagating = left.incident.propagating
    np.testing.assert_allclose(totals(left)[propagating], 1.0, rtol=0, atol=ENERGY)
    np.testing.assert_allclose(not_lost(left), 1.0, rtol=0, atol=ENERGY)  # none was set right
    np.testing.assert_array_equal(totals(left)[~propagating], 0.0)
    # One mode is totally reflected while the other leaves; one dies away while the other is reflected.
    total = (left.transmitted.sum(axis=-2) == 0) & propagating
    assert total.all(axis=-1).any()
    assert (~left.waves.propagating).any() or (kind, mode) == ("biaxial", 0)  # the inner sheet


@pytest.mark.parametrize("mode", [0, 1])
@pytest.mark.parametrize("kind", KINDS)
def test_wave_that_comes_is_among_those_found(kind, mode, n):
    rng = np.random.default_rng(3)
    crystal = crystals(rng, n, kind)
    k, normal = coming(directions(rng, n), directions(rng, n), crystal, mode)
    left = leave(normal, k, crystal)
    along = np.sum(k * normal, axis=-1)
    numbers = [mode] if kind == "uniaxial" else [0, 1]  # in a dimple of the outer sheet both are slow
    found = np.min(np.abs(left.incident.k[:, numbers, 2] - along[:, None]), axis=-1)
    np.testing.assert_allclose(found, 0.0, atol=SAME_WAVE)


@pytest.mark.parametrize("kind", KINDS)
def test_waves_fulfil_maxwells_equations(kind, n):
    rng = np.random.default_rng(4)
    crystal = crystals(rng, n, kind)
    entered = enter(directions(rng, n), 1.5 * directions(rng, n), crystal, 1.5)
    frame = crystal.frame @ np.swapaxes(entered.axes, -1, -2)
    eps = np.einsum("nai,na,naj->nij", frame, crystal.permittivities, frame)
    waves = entered.waves
    d = np.einsum("nij,nmj->nmi", eps, waves.e)
    np.testing.assert_allclose(np.cross(waves.k, waves.e), waves.h, rtol=0, atol=MAXWELL)
    np.testing.assert_allclose(np.cross(waves.k, waves.h), -d, rtol=0, atol=MAXWELL)
    assert (waves.flux <= 0).all()
    assert (waves.k[..., 2].imag[~waves.propagating] < 0).all()


@pytest.mark.parametrize("mode", [0, 1])
@pytest.mark.parametrize("kind", KINDS)
def test_light_and_eye_may_be_swapped(kind, mode, n):
    rng = np.random.default_rng(5)
    crystal, outside = crystals(rng, n, kind), rng.uniform(1.0, 1.7, n)
    k, normal = coming(directions(rng, n), directions(rng, n), crystal, mode)
    left, back = leave(normal, k, crystal, outside), leave(normal, -k, crystal, outside)
    both = left.incident.propagating[:, :, None] & left.incident.propagating[:, None, :]
    transposed = np.where(both, np.swapaxes(back.reflected, -1, -2), left.reflected)
    np.testing.assert_allclose(left.reflected, transposed, rtol=0, atol=RECIPROCITY)
    entered = enter(normal, -k, crystal, outside)
    tangential = np.linalg.norm(k - np.sum(k * normal, axis=-1, keepdims=True) * normal, axis=-1)
    through = (tangential < outside)[:, None, None] & left.incident.propagating[:, None, :]
    transposed = np.where(through, np.swapaxes(entered.transmitted, -1, -2), left.transmitted)
    np.testing.assert_allclose(left.transmitted, transposed, rtol=0, atol=RECIPROCITY)
    assert through.mean() > OFTEN


@pytest.mark.parametrize("kind", KINDS)
def test_equal_indices_are_fresnels_equations(kind):
    rng = np.random.default_rng(6)
    index, cosine = 1.77, np.append(np.linspace(0.02, 1, 200), 0.0)
    frame = frames(rng, len(cosine))
    make = {
        "uniaxial": lambda: Indicatrix.uniaxial(index, index, frame),
        "biaxial": lambda: Indicatrix.biaxial(index, index, index, frame),
    }
    tangential = np.sqrt(1 - cosine**2)[:, None] * np.array([1.0, 0.0, 0.0])
    entered = enter(np.array([0.0, 0.0, 1.0]), tangential, make[kind]())
    r_s, r_p = reflectance_polarised(cosine, index)
    np.testing.assert_allclose(entered.reflected[:, 0, 0], r_s, rtol=0, atol=FRESNEL)
    np.testing.assert_allclose(entered.reflected[:, 1, 1], r_p, rtol=0, atol=FRESNEL)
    np.testing.assert_allclose(entered.reflected[:, 0, 1], 0.0, rtol=0, atol=FRESNEL)
    np.testing.assert_allclose(entered.transmitted.sum(axis=-2)[:, 0], 1 - r_s, rtol=0, atol=FRESNEL)
    left = leave(np.array([0.0, 0.0, 1.0]), tangential, make[kind]())
    # Both modes together are unpolarised light.
    np.testing.assert_allclose(
        left.transmitted.sum(axis=(-2, -1)) / 2, 1 - (r_s + r_p) / 2, rtol=0, atol=FRESNEL
    )


@pytest.mark.parametrize("away", chosen([1e-3, 1e-6, 1e-8, 1e-10, 1e-12, 0.0], [1e-6, 1e-10, 0.0]))
@pytest.mark.parametrize("birefringence", [0.3, 0.01, 1e-9, 0.0])
def test_energy_next_to_the_optic_axis_of_a_uniaxial_crystal(birefringence, away):
    rng = np.random.default_rng(7)
    index = rng.uniform(1.3, 2.7, 1000)
    crystal = Indicatrix.uniaxial(index, index + birefringence, frames(rng, 1000))
    axis = crystal.frame[:, 2]
    along = axis + away * at_right_angles(rng, axis)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    for normals in (directions(rng, 1000), at_right_angles(rng, axis), axis):
        for mode in (0, 1):
            k, normal = coming(along, normals, crystal, mode)
            left = leave(normal, k, crystal)
            assert_energy_is_kept(left)
            entered = enter(normal, along, crystal)
            np.testing.assert_allclose(totals(entered), 1.0, rtol=0, atol=ENERGY)


@pytest.mark.parametrize("cosine", [1e-3, 1e-6, 1e-9, 0.0])
@pytest.mark.parametrize("birefringence", [0.3, 0.01, 1e-9, 0.0])
def test_energy_next_to_grazing_of_a_uniaxial_crystal(birefringence, cosine):
    rng = np.random.default_rng(8)
    index, normals = rng.uniform(1.3, 2.7, 1000), directions(rng, 1000)
    crystal = Indicatrix.uniaxial(index, index + birefringence, frames(rng, 1000))
    along = at_right_angles(rng, normals) + cosine * normals
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    for mode in (0, 1):
        k, normal = coming(along, normals, crystal, mode)
        left = leave(normal, k, crystal)
        assert_energy_is_kept(left)
        entered = enter(normal, along, crystal)
        np.testing.assert_allclose(totals(entered), 1.0, rtol=0, atol=ENERGY)


@pytest.mark.parametrize("birefringence", chosen([0.2, 0.01, 1e-4, 1e-9, 1e-12, 0.0], [0.2, 1e-4, 1e-9, 0.0]))
def test_energy_at_the_limits_of_a_biaxial_crystal(birefringence):
    """Along an optic axis and next to it, grazing and nearly, of indices however close."""
    rng = np.random.default_rng(9)
    index, normals = rng.uniform(1.3, 2.7, 500), directions(rng, 500)
    middle = index + birefringence * rng.uniform(0, 1, 500)
    crystal = Indicatrix.biaxial(index, middle, index + birefringence, frames(rng, 500))
    axis = optic_axes(crystal)[:, 0]
    cases = [(axis + away * at_right_angles(rng, axis), normals) for away in (1e-3, 1e-6, 1e-12, 0.0)]
    cases += [(at_right_angles(rng, normals) + cosine * normals, normals) for cosine in (1e-3, 1e-6, 0.0)]
    cases += [(axis, axis), (axis, at_right_angles(rng, axis))]
    for along, normal in cases:
        along = along / np.linalg.norm(along, axis=-1, keepdims=True)
        np.testing.assert_allclose(totals(enter(normal, along, crystal)), 1.0, rtol=0, atol=NEXT_TO)
        for mode in (0, 1):
            left = leave(*coming(along, normal, crystal, mode)[::-1], crystal)
            total = totals(left)
            np.testing.assert_allclose(total[left.incident.propagating], 1.0, rtol=0, atol=MOST_LOST)
            np.testing.assert_array_equal(total[~left.incident.propagating], 0.0)
            assert np.isfinite(left.r).all()
            assert np.isfinite(left.t).all()


@pytest.mark.parametrize("birefringence", [0.05, 0.01, 1e-3, 1e-6, 1e-9])
def test_energy_that_leaves_a_biaxial_gem(birefringence):
    rng = np.random.default_rng(12)
    index = rng.uniform(1.5, 2.7, 2000)
    middle = index + birefringence * rng.uniform(0, 1, 2000)
    crystal = Indicatrix.biaxial(index, middle, index + birefringence, frames(rng, 2000))
    k, normal = coming(directions(rng, 2000), directions(rng, 2000), crystal, 1)
    left = leave(normal, k, crystal)
    counted = left.incident.flux > 0.01
    np.testing.assert_allclose(not_lost(left)[counted], 1.0, rtol=0, atol=NEXT_TO)
    assert (counted | ~left.incident.propagating).mean() > 0.95


def test_shares_are_sums_over_the_polarisation_outside():
    rng = np.random.default_rng(10)
    crystal, normals = crystals(rng, 1000, "uniaxial"), directions(rng, 1000)
    mode = rng.integers(0, 2, 1000)
    along = directions(rng, 1000)
    index = np.take_along_axis(modes_along(along, crystal).index, mode[:, None], axis=-1)
    inside = shares_inside(normals, index * along, mode, crystal)
    left = leave(normals, index * along, crystal)
    expected = np.take_along_axis(left.reflected, mode[:, None, None], axis=-1)[..., 0]
    np.testing.assert_array_equal(inside.reflected, expected)
    # What is reflected goes back from the boundary, with the tangential wave vector of what came.
    assert (np.sum(inside.ray * normals[:, None], axis=-1) < MAXWELL).all()
    tangential = index * along - np.sum(index * along * normals, axis=-1, keepdims=True) * normals
    back = inside.k - np.sum(inside.k * normals[:, None], axis=-1, keepdims=True) * normals[:, None]
    np.testing.assert_allclose(back, np.stack([tangential, tangential], axis=1), rtol=0, atol=MAXWELL)
    entering = shares_entering(normals, along, crystal)
    np.testing.assert_allclose(entering.reflected + entering.transmitted.sum(axis=-1), 1, rtol=0, atol=ENERGY)


def test_optic_axis_of_a_uniaxial_crystal_is_where_both_indices_are_equal():
    crystal = crystals(np.random.default_rng(11), 100, "uniaxial")
    index = modes_along(optic_axes(crystal)[:, 0], crystal).index
    np.testing.assert_allclose(index[:, 0], index[:, 1], rtol=0, atol=ENERGY)

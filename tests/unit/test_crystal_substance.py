"""Crystals as substances, and how they lie in a stone: names, indices, absorption, optic frames."""

from __future__ import annotations

import numpy as np
import pytest
from crystals_help import crystals, directions
from physics_tolerances import ROUNDING

from gemrender import InputError
from gemrender.optics.crystals import (
    Crystal,
    Indicatrix,
    absorption_per_mm,
    frame_of_angles,
    frame_of_axes,
    frame_of_c_axis,
    modes_along,
)
from gemrender.optics.dispersion import Formula
from gemrender.optics.tabulated import Table

X, Y, Z = np.eye(3)


def constant(*indices):
    return tuple(Formula(formula="cauchy", coefficients=(index,)) for index in indices)


def flat(per_mm):
    return Table(wavelength_nm=(380.0, 760.0), values=(per_mm, per_mm), key="per_mm")


# ---- Names and numbers ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("indices", "name", "birefringence"),
    [
        ((1.718,), "isotropic", 0.0),
        ((1.544, 1.553), "uniaxial +", 0.009),  # quartz
        ((1.770, 1.762), "uniaxial -", 0.008),  # corundum
        ((1.609, 1.612, 1.619), "biaxial +", 0.010),  # topaz
        ((1.530, 1.681, 1.685), "biaxial -", 0.155),  # aragonite
        ((1.5, 1.5), "uniaxial", 0.0),
        ((1.5, 1.5, 1.5), "biaxial", 0.0),
    ],
)
def test_optic_class(indices, name, birefringence):
    crystal = Crystal(dispersions=constant(*indices))
    assert crystal.optic_class == name
    assert crystal.birefringence == pytest.approx(birefringence, abs=ROUNDING)
    assert (crystal.optic_axial_angle_deg is None) == (len(indices) < 3)


def test_indices_and_absorption_go_to_their_axes():
    frame = frame_of_c_axis([1.0, 2.0, 3.0])
    uniaxial = Crystal(dispersions=constant(1.6, 1.7), absorptions=(flat(0.1), None))
    made = uniaxial.indicatrix([500.0, 600.0], frame)
    np.testing.assert_allclose(made.indices, [[1.6, 1.6, 1.7]] * 2, rtol=0, atol=ROUNDING)
    np.testing.assert_array_equal(uniaxial.principal_absorption_per_mm(500.0), [0.1, 0.1, 0.0])
    biaxial = Crystal(dispersions=constant(1.6, 1.7, 1.8), absorptions=(flat(0.1), flat(0.2), flat(0.3)))
    np.testing.assert_allclose(biaxial.indicatrix(500.0, frame).indices, [1.6, 1.7, 1.8], atol=ROUNDING)
    np.testing.assert_array_equal(biaxial.principal_absorption_per_mm(500.0), [0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"dispersions": ()}, "dispersions = 0: must be 1, 2 or 3"),
        ({"dispersions": constant(1.5, 1.6, 1.7, 1.8)}, "must be 1, 2 or 3"),
        ({"dispersions": constant(1.5, 1.6), "absorptions": (None,)}, "as many as dispersions: 2"),
        ({"dispersions": constant(1.5, 9.0)}, "extraordinary index at 380 nm = 9.0"),
        ({"dispersions": constant(1.6, 1.5, 1.7)}, "increasing order"),
    ],
)
def test_what_is_no_crystal(given, said):
    with pytest.raises(InputError, match=said):
        Crystal(**given)


# ---- Absorption ----------------------------------------------------------------------------------------


def test_ordinary_mode_absorbs_alike_in_all_directions_and_the_other_as_it_should_at_both_ends():
    crystal = Indicatrix.uniaxial(1.6, 1.9, np.eye(3))
    normal = np.append(directions(np.random.default_rng(41), 100), [X, Z], axis=0)
    per_mm = absorption_per_mm(modes_along(normal, crystal), crystal, np.array([0.2, 0.2, 0.7]))
    np.testing.assert_allclose(per_mm[:, 0], 0.2, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(per_mm[-2:, 1], [0.7, 0.2], rtol=0, atol=ROUNDING)
    assert ((per_mm[:-2, 1] > 0.2) & (per_mm[:-2, 1] < 0.7)).all()


@pytest.mark.parametrize("kind", ["uniaxial", "biaxial"])
def test_absorption_is_the_imaginary_part_of_the_index(kind):
    """Of complex permittivities in the mode's own equation, to the first order: along the wave normal."""
    rng = np.random.default_rng(42)
    crystal, normal = crystals(rng, 200, kind), directions(rng, 200)
    principal = rng.uniform(0, 1, (200, 3))
    if kind == "uniaxial":
        principal[:, 1] = principal[:, 0]
    modes = modes_along(normal, crystal)
    ray_per_mm = absorption_per_mm(modes, crystal, principal)
    along = ray_per_mm / np.cos(np.radians(modes.walk_off_deg))
    # n + i kappa along each axis, kappa = alpha / 2 in units of omega / c: 1 / n^2 of the section across
    # the wave normal has eigenvalues whose complex roots are the modes' indices.
    step = 1e-7
    eta = (crystal.indices + 0.5j * step * principal) ** -2.0
    one = modes.d[:, 0] / np.linalg.norm(modes.d[:, 0], axis=-1, keepdims=True)
    base = np.stack([one, np.cross(normal, one)], axis=1) @ np.swapaxes(crystal.frame, -1, -2)
    values = np.linalg.eigvals(np.einsum("nia,na,nja->nij", base, eta, base))
    index = values**-0.5
    order = np.argsort(index.real, axis=-1)
    expected = np.take_along_axis(2 * index.imag / step, order, axis=-1)
    ours = np.take_along_axis(along, np.argsort(modes.index, axis=-1), axis=-1)
    np.testing.assert_allclose(ours, expected, rtol=0, atol=1e-5)  # the second order, next to an axis


# ---- Optic frames --------------------------------------------------------------------------------------


def assert_right_handed(frame):
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), rtol=0, atol=ROUNDING)
    assert np.linalg.det(frame) == pytest.approx(1.0, abs=ROUNDING)


@pytest.mark.parametrize(
    "c_axis", [[0, 0, 1], [1, 0, 0], [0, -5, 0], [1e-200, 2e-200, 3e-200], [3e200, 1, 0]]
)
def test_last_axis_of_the_frame_is_the_optic_axis(c_axis):
    frame = frame_of_c_axis(c_axis)
    assert_right_handed(frame)
    axis = np.array(c_axis, float) / np.abs(c_axis).max()
    np.testing.assert_allclose(frame[2], axis / np.linalg.norm(axis), rtol=0, atol=ROUNDING)


def test_table_is_the_stones_axis():
    np.testing.assert_array_equal(frame_of_c_axis("table"), np.eye(3))


def test_angles_turn_the_crystal():
    np.testing.assert_allclose(frame_of_angles([0, 90, 0])[2], -Y, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(frame_of_angles([90, 90, 0])[2], X, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(frame_of_angles([0, 0, 30])[0], [0.75**0.5, 0.5, 0], rtol=0, atol=ROUNDING)
    assert_right_handed(frame_of_angles([10, 50, -70]))


def test_two_axes_make_a_frame():
    for given in ({"alpha": X, "beta": Y}, {"beta": Y, "gamma": Z}, {"alpha": X, "gamma": Z}):
        np.testing.assert_allclose(frame_of_axes(**given), np.eye(3), rtol=0, atol=ROUNDING)
    frame = frame_of_axes(alpha=[1, 1, 0], gamma=[1, -1, 1e-4])
    assert_right_handed(frame)
    np.testing.assert_allclose(frame[0], np.array([1, 1, 0]) / 2**0.5, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: frame_of_c_axis([0, 0, 0]), "c_axis.*not all zeros"),
        (lambda: frame_of_c_axis([0, 1]), "three numbers"),
        (lambda: frame_of_c_axis([0, float("nan"), 1]), "finite number"),
        (lambda: frame_of_c_axis("girdle"), 'or "table"'),
        (lambda: frame_of_axes(alpha=X), "at least two"),
        (lambda: frame_of_axes(alpha=X, beta=[1, 1, 0]), "right angles to alpha.*is 45 off"),
        (lambda: frame_of_axes(alpha=X, beta=[0, 0, 0]), "beta.*not all zeros"),
        (lambda: frame_of_angles([1, 2]), "three numbers"),
    ],
)
def test_what_is_no_frame(make, said):
    with pytest.raises(InputError, match=said):
        make()

"""Amplitudes at boundaries of birefringent crystals against pyElli, which solves Berreman's 4 x 4 equations.

pyElli's z goes into the crystal, so its y and z are turned about x against the boundary's y and n, and with
them the signs of s and p of light outside.
"""

from __future__ import annotations

import numpy as np
import pytest
from crystals_help import KINDS, crystals, directions

from gemrender.optics.crystals import Indicatrix, enter, leave

#: Both in float64; pyElli takes fields from eigenvectors of a matrix that is not symmetric.
AMPLITUDE = 1e-9
#: Extinction that pyElli is given: it sorts waves by their decay first, and without it by its rounding.
ABSORPTION = 1e-12
N = 100
WAVELENGTH_NM = 589.3


def cases(kind, seed):
    """Yield crystals, normals, wave vectors of light from outside, and the index there."""
    rng = np.random.default_rng(seed)
    made, normals, comes = crystals(rng, N, kind), directions(rng, N), directions(rng, N)
    comes *= -np.sign(np.sum(comes * normals, axis=-1, keepdims=True))
    outside = rng.uniform(1.0, 1.7, N)
    for i in range(N):
        crystal = Indicatrix(made.indices[i], made.frame[i], made.has_optic_axis)
        yield crystal, normals[i], outside[i] * comes[i], outside[i]


def pyelli_material(crystal, axes):
    """Return the crystal in pyElli's frame."""
    import elli

    dispersions = [elli.ConstantRefractiveIndex(complex(n, ABSORPTION)) for n in crystal.indices]
    if crystal.has_optic_axis:
        material = elli.UniaxialMaterial(dispersions[0], dispersions[2])
    else:
        material = elli.BiaxialMaterial(*dispersions)
    material.set_rotation((crystal.frame @ axes.T * np.array([1.0, -1.0, -1.0])).T)
    return material


def isotropic(index):
    import elli

    return elli.ConstantRefractiveIndex(float(index)).get_mat()


def angle_deg(normal, k):
    """Return the angle of incidence [deg]."""
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(normal, k)), -normal @ k))


@pytest.mark.parametrize("kind", KINDS)
def test_amplitudes_that_enter(kind):
    import elli
    from elli.solver4x4 import Solver4x4

    for crystal, normal, k, outside in cases(kind, 21):
        entered = enter(normal, k, crystal, outside)
        waves = entered.waves
        material = pyelli_material(crystal, entered.axes)
        structure = elli.Structure(isotropic(outside), [], material)
        result = structure.evaluate(np.array([WAVELENGTH_NM]), angle_deg(normal, k))
        np.testing.assert_allclose(entered.r, result.jones_matrix_r[0][::-1, ::-1], rtol=0, atol=AMPLITUDE)
        # Tangential fields of the two waves for incident p and s, in either order.
        delta = Solver4x4.build_delta_matrix(
            np.array([np.linalg.norm(np.cross(normal, k))]), material.get_tensor(np.array([WAVELENGTH_NM]))
        )
        columns = Solver4x4.transition_matrix_halfspace(delta)[0][:, [2, 0]]
        theirs = columns[:, :, None] * result.jones_matrix_t[0][None, :, ::-1]
        tangential = np.concatenate([waves.e[:, :2], waves.h[:, :2]], axis=1).T
        ours = -np.array([1, -1, 1, -1])[:, None, None] * tangential[:, :, None] * entered.t
        off = min(np.abs(ours - theirs).max(), np.abs(ours[:, ::-1] - theirs).max())
        assert off < AMPLITUDE


@pytest.mark.parametrize("kind", KINDS)
def test_amplitudes_that_leave(kind):
    """Of a plate, in which all waves go to and fro: both sides' amplitudes of what is inside."""
    import elli
    from elli.solver4x4 import PropagatorEig

    for thickness_nm, (crystal, normal, k, outside) in zip(
        np.linspace(50, 1000, N), cases(kind, 22), strict=True
    ):
        entered, top = enter(normal, k, crystal, outside), leave(normal, k, crystal, outside)
        bottom = leave(-normal, k, crystal, 1.0)
        phase = 2 * np.pi * thickness_nm / WAVELENGTH_NM
        down = with_phase(top.waves, top.axes, bottom.incident, bottom.axes, phase)
        up = with_phase(bottom.waves, bottom.axes, top.incident, top.axes, phase)
        round_trip = up @ bottom.r @ down
        inside = np.linalg.solve(np.eye(2) - top.r @ round_trip, entered.t)
        reflected, transmitted = entered.r + top.t @ round_trip @ inside, -bottom.t @ down @ inside
        layer = elli.Layer(pyelli_material(crystal, entered.axes), thickness_nm)
        result = elli.Structure(isotropic(outside), [layer], isotropic(1.0)).evaluate(
            np.array([WAVELENGTH_NM]), angle_deg(normal, k), propagator=PropagatorEig()
        )
        np.testing.assert_allclose(reflected, result.jones_matrix_r[0][::-1, ::-1], rtol=0, atol=AMPLITUDE)
        np.testing.assert_allclose(transmitted, result.jones_matrix_t[0][::-1, ::-1], rtol=0, atol=AMPLITUDE)


def with_phase(start, start_axes, end, end_axes, phase):
    """Return amplitudes at a plate's other side, where a wave's field may be named by another sign."""
    turned = np.sum((start.e @ start_axes) * (end.e @ end_axes).conj(), axis=-1)
    return np.diag(turned * np.exp(1j * phase * end.k[:, 2]))

"""Birefringent crystals against what is known of them in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from crystals_help import crystals, directions, frames
from physics_tolerances import ROUNDING

from gemrender.optics.crystals import (
    Indicatrix,
    enter,
    frame_of_c_axis,
    leave,
    modes_along,
    optic_axes,
    optic_axial_angle_deg,
    shares_entering,
)

#: Calcite at the sodium line.
ORDINARY, EXTRAORDINARY = 1.6584, 1.4864
X, Y, Z = np.eye(3)
#: Closed forms with a dozen operations, and angles by arctan.
CLOSED = 1e-13
#: Fields of modes next to one another: rounding over the difference of their indices.
FIELDS = 1e-9


def calcite(c_axis):
    return Indicatrix.uniaxial(ORDINARY, EXTRAORDINARY, frame_of_c_axis(c_axis))


def incidence(sine):
    return np.asarray(sine)[..., None] * X


# ---- Modes for a wave normal ---------------------------------------------------------------------------


def test_extraordinary_index_and_walk_off_by_the_angle_to_the_axis():
    # Born & Wolf, 7th ed., section 15.3.1: 1 / n^2 = cos^2 / n_o^2 + sin^2 / n_e^2, and the ray is at
    # tan = (n_o / n_e)^2 tan to the axis.
    angle = np.radians(np.linspace(0, 90, 91))
    normal = np.cos(angle)[:, None] * Z + np.sin(angle)[:, None] * X
    modes = modes_along(normal, calcite("table"))
    n_e = 1 / np.sqrt((np.cos(angle) / ORDINARY) ** 2 + (np.sin(angle) / EXTRAORDINARY) ** 2)
    np.testing.assert_allclose(modes.index[:, 0], ORDINARY, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(modes.index[:, 1], n_e, rtol=0, atol=ROUNDING)
    to_axis = np.arctan2(ORDINARY**2 * np.sin(angle), EXTRAORDINARY**2 * np.cos(angle))
    np.testing.assert_allclose(modes.walk_off_deg[:, 1], np.degrees(to_axis - angle), rtol=0, atol=1e-11)
    np.testing.assert_allclose(modes.walk_off_deg[:, 0], 0.0, rtol=0, atol=1e-11)


@pytest.mark.parametrize("kind", ["uniaxial", "biaxial"])
def test_modes_are_transverse_and_at_right_angles(kind):
    rng = np.random.default_rng(31)
    crystal, normal = crystals(rng, 2000, kind), directions(rng, 2000)
    modes = modes_along(normal, crystal)
    eps = np.einsum("nai,na,naj->nij", crystal.frame, crystal.permittivities, crystal.frame)
    np.testing.assert_allclose(np.einsum("nij,nmj->nmi", eps, modes.e), modes.d, rtol=0, atol=CLOSED)
    for field in (modes.d, modes.h):
        np.testing.assert_allclose(np.einsum("ni,nmi->nm", normal, field), 0, rtol=0, atol=CLOSED)
        np.testing.assert_allclose(np.sum(field[:, 0] * field[:, 1], axis=-1), 0, rtol=0, atol=CLOSED)
    np.testing.assert_allclose(np.sum(modes.e * modes.ray, axis=-1), 0, rtol=0, atol=CLOSED)
    k = modes.index[..., None] * normal[:, None]
    np.testing.assert_allclose(np.cross(k, modes.h), -modes.d, rtol=0, atol=1e-12)


def test_biaxial_modes_with_two_equal_indices_are_uniaxial():
    rng = np.random.default_rng(32)
    frame, normal = frames(rng, 500), directions(rng, 500)
    one = modes_along(normal, Indicatrix.uniaxial(1.5, 1.7, frame))
    other = modes_along(normal, Indicatrix.biaxial(1.5, 1.5, 1.7, frame))
    np.testing.assert_allclose(one.index, other.index, rtol=0, atol=CLOSED)
    np.testing.assert_allclose(np.abs(np.sum(one.e * other.e, axis=-1)), 1, rtol=0, atol=CLOSED)


def test_modes_along_the_optic_axes_are_the_named_ones():
    uniaxial = modes_along(Z, calcite("table"))
    first = calcite("table").frame[0]
    np.testing.assert_allclose(np.abs(uniaxial.d[1]), ORDINARY**2 * first, rtol=0, atol=CLOSED)
    biaxial = Indicatrix.biaxial(1.5, 1.6, 1.8, np.eye(3))
    for axis in optic_axes(biaxial):
        modes = modes_along(axis, biaxial)
        np.testing.assert_allclose(np.abs(modes.e[0] @ Y), 1, rtol=0, atol=CLOSED)
        np.testing.assert_allclose(modes.index, 1.6, rtol=0, atol=CLOSED)


# ---- Optic axes of a biaxial ---------------------------------------------------------------------------


def test_optic_axes_are_where_both_modes_have_the_middle_index():
    rng = np.random.default_rng(33)
    crystal = crystals(rng, 500, "biaxial")
    axes = optic_axes(crystal)
    middle = np.median(crystal.indices, axis=-1)
    for i in (0, 1):
        index = modes_along(axes[:, i], crystal).index
        np.testing.assert_allclose(index, middle[:, None] * [1, 1], rtol=0, atol=1e-12)
    between = np.degrees(np.arccos(np.abs(np.sum(axes[:, 0] * axes[:, 1], axis=-1))))
    expected = optic_axial_angle_deg(*np.sort(crystal.indices, axis=-1).T)[1]
    np.testing.assert_allclose(between, expected, rtol=0, atol=1e-9)


def test_optic_axial_angle_of_aragonite():
    # n 1.5301, 1.6810, 1.6854: 2V is 18 degrees about alpha (any handbook of mineralogy).
    about_gamma, acute = optic_axial_angle_deg(1.5301, 1.6810, 1.6854)
    assert acute == pytest.approx(18, abs=0.5)
    assert about_gamma == pytest.approx(180 - acute, abs=1e-12)


def test_optic_axial_angle_closes_where_two_indices_meet():
    assert optic_axial_angle_deg(1.5, 1.5, 1.6)[0] == 0.0
    assert optic_axial_angle_deg(1.5, 1.6, 1.6)[0] == 180.0


# ---- Boundaries ----------------------------------------------------------------------------------------


def test_doubled_image_through_a_calcite_plate():
    """Light straight through: the ordinary image stays, the extraordinary one is moved."""
    entering = shares_entering(Z, -Z, calcite([1.0, 0.0, 1.0]))
    ratio = (ORDINARY / EXTRAORDINARY) ** 2
    walk_off = np.arctan(ratio) - np.pi / 4
    assert np.degrees(walk_off) == pytest.approx(6.2, abs=0.05)
    moved = np.hypot(entering.ray[:, 0], entering.ray[:, 1]) / -entering.ray[:, 2]
    np.testing.assert_allclose(moved, [0.0, np.tan(walk_off)], rtol=0, atol=CLOSED)
    np.testing.assert_allclose(entering.k[:, :2], 0.0, rtol=0, atol=CLOSED)


def brewster(c_axis):
    """Return sin^2 of the angle at which no p-polarised light is reflected."""
    o, e = ORDINARY**2, EXTRAORDINARY**2
    of_axis = {"y": o / (o + 1), "z": e * (o - 1) / (o * e - 1), "x": o * (e - 1) / (o * e - 1)}
    return of_axis[c_axis]


@pytest.mark.parametrize(("name", "c_axis"), [("x", X), ("y", Y), ("z", Z)])
def test_brewsters_angle(name, c_axis):
    # Lekner (1991), where the optic axis is at right angles to the plane of incidence (y) or in it: there
    # r_pp is 0 where n_o n_e cos = sqrt(n_e^2 - sin^2) (axis along the normal, z), and with n_o within (x).
    entered = enter(Z, incidence(np.sqrt(brewster(name))), calcite(c_axis))
    assert abs(entered.r[1, 1]) == pytest.approx(0.0, abs=CLOSED)
    assert abs(entered.r[0, 1]) == pytest.approx(0.0, abs=CLOSED)
    assert abs(entered.r[0, 0]) > 0.3


@pytest.mark.parametrize(("c_axis", "n_s"), [(X, ORDINARY), (Y, EXTRAORDINARY), (Z, ORDINARY)])
def test_s_polarised_reflection_is_fresnels_with_the_index_of_its_mode(c_axis, n_s):
    sine = np.linspace(0, 1, 50)
    cos, cos_n = np.sqrt(1 - sine**2), np.sqrt(n_s**2 - sine**2)
    entered = enter(Z, incidence(sine), calcite(c_axis))
    np.testing.assert_allclose(entered.r[:, 0, 0], (cos - cos_n) / (cos + cos_n), rtol=0, atol=CLOSED)


@pytest.mark.parametrize("mode", [0, 1])
def test_total_reflection_of_one_mode_while_the_other_leaves(mode):
    # Axis along y: k_t of the ordinary mode reaches 1 at asin(1 / n_o), of the extraordinary one, E along
    # y, at asin(1 / n_e), some degrees later.
    crystal = calcite(Y)
    sine = (1 / ORDINARY + 1 / EXTRAORDINARY) / 2
    index = modes_along(sine * X + np.sqrt(1 - sine**2) * Z, crystal).index
    np.testing.assert_allclose(index, [ORDINARY, EXTRAORDINARY], rtol=0, atol=ROUNDING)
    out = leave(Z, index[mode] * sine * X, crystal).transmitted[:, mode].sum()
    assert out == pytest.approx(0.0, abs=0.0) if mode == 0 else out > 0.3


@pytest.mark.parametrize("kind", ["uniaxial", "biaxial"])
def test_waves_at_a_boundary_are_the_modes_of_their_wave_normals(kind):
    rng = np.random.default_rng(34)
    crystal = crystals(rng, 1000, kind)
    entered = enter(directions(rng, 1000), directions(rng, 1000), crystal)
    for i in (0, 1):
        k = (entered.waves.k[:, i : i + 1].real @ entered.axes)[:, 0]
        e = (entered.waves.e[:, i : i + 1] @ entered.axes)[:, 0]
        ray = (entered.waves.ray[:, i : i + 1] @ entered.axes)[:, 0]
        index = np.linalg.norm(k, axis=-1)
        modes = modes_along(k / index[:, None], crystal)
        number = np.argmin(np.abs(modes.index - index[:, None]), axis=-1)
        chosen = np.arange(1000), number
        np.testing.assert_allclose(modes.index[chosen], index, rtol=0, atol=1e-11)
        np.testing.assert_allclose(np.abs(np.sum(modes.e[chosen] * e, axis=-1)), 1, rtol=0, atol=FIELDS)
        np.testing.assert_allclose(modes.ray[chosen], ray, rtol=0, atol=FIELDS)


def test_biaxial_boundary_with_two_equal_indices_is_uniaxial():
    rng = np.random.default_rng(35)
    normal, k, frame = directions(rng, 1000), directions(rng, 1000), frames(rng, 1000)
    one = enter(normal, k, Indicatrix.uniaxial(1.55, 1.8, frame))
    other = enter(normal, k, Indicatrix.biaxial(1.55, 1.55, 1.8, frame))
    np.testing.assert_allclose(one.r, other.r, rtol=0, atol=FIELDS)
    np.testing.assert_allclose(one.transmitted, other.transmitted, rtol=0, atol=FIELDS)


def test_thick_plate_at_45_degrees_between_crossed_polarisers():
    """A quarter of unpolarised light passes, less Fresnel's losses: energies add, so without colours."""
    crystal = Indicatrix.uniaxial(ORDINARY, EXTRAORDINARY, frame_of_c_axis([1.0, 1.0, 0.0]))
    entered = enter(Z, 0 * Z, crystal)
    passed = np.zeros(2)  # by s and p at the far side
    s = 0.5 * entered.transmitted[:, 0]  # of unpolarised light half passes the polariser, along s
    far, near = leave(-Z, 0 * Z, crystal), leave(Z, 0 * Z, crystal)
    for _ in range(50):
        passed += far.transmitted @ s
        s = near.reflected @ (far.reflected @ s)
    # Each mode's plate passes (1 - R) / (1 + R), R = ((n - 1) / (n + 1))^2: 2 n / (n^2 + 1).
    plates = [2 * n / (n**2 + 1) for n in (ORDINARY, EXTRAORDINARY)]
    crossed = passed[1 - int(np.argmax(np.abs(far.axes[:2] @ near.axes[1])))]
    np.testing.assert_allclose(passed.sum() / 2, crossed, rtol=0, atol=CLOSED)
    assert crossed == pytest.approx(np.mean(plates) / 4, abs=CLOSED)

"""Polygons with modes: beside rays by numpy, and beside what is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from beam_help import TOLD_AREA, owners
from exact_tolerances import EDGE, TILING
from mode_rays import average_and_rear, tree

from gemrender.beam import beam_stone
from gemrender.beam.modes import optical_crystal, score_modes, trace_mode_facets
from gemrender.beam.polygons import EXITED, GIRDLE_CELL
from gemrender.cuts import load_stone
from gemrender.observation import Model, View
from gemrender.optics.crystals import Indicatrix

#: Principal indices at the sodium line, of some hexagonal crystals and of one that is biaxial and strong.
MOISSANITE, SAPPHIRE = (2.6475, 2.6475, 2.6902), (1.7681, 1.7681, 1.7600)
STRONG = (1.65, 1.75, 1.9)
#: The optic axis along the table, along the stone's axis, and between.
LYING, STANDING = np.eye(3)[[1, 2, 0]], np.eye(3)
TURN = np.radians(35.0)
TILTED = np.array([[np.cos(TURN), 0, -np.sin(TURN)], [0, 1, 0], [np.sin(TURN), 0, np.cos(TURN)]])
#: Shares, intensities and directions after some reflections, by two ways in float64.
PATH = 1e-11
#: The probability that a normal number is further from its mean by chance: 6e-5.
FOUR_ERRORS = 4.0

TOP = View(resolution=1)
#: A view from the side, beyond any mirror plane.
ASIDE = View(resolution=1, tilt_deg=17.0, tilt_azimuth_deg=23.0)


def crystal_of(principal, axes):
    """Return the crystal for the kernels, and for the reference."""
    if principal[0] == principal[1]:
        return optical_crystal(principal, axes), Indicatrix.uniaxial(principal[0], principal[2], axes)
    return optical_crystal(principal, axes), Indicatrix.biaxial(*principal, axes)


@pytest.fixture(scope="module")
def stone():
    return load_stone("inoue-3")


@pytest.mark.parametrize("view", [TOP, ASIDE])
@pytest.mark.parametrize(("principal", "axes"), [(MOISSANITE, LYING), (SAPPHIRE, TILTED), (STRONG, LYING)])
def test_each_place_has_the_paths_that_its_rays_have(stone, principal, axes, view):
    """All of them, each with its share, its intensity and its direction; or they go on in cells."""
    kernel, reference = crystal_of(principal, axes)
    facets = trace_mode_facets(beam_stone(stone), kernel, view=view, model=Model.of(stone), least=1e-4)
    places, compared = np.random.default_rng(5).uniform(-0.7, 0.7, (6, 2)), 0
    for place, held in zip(places, owners(facets, places, EDGE), strict=True):
        if not held:
            continue
        paths = {tuple(facets.path(i)): i for i in held}
        for path, (share, light, direction) in tree(stone, reference, view.basis(), place, 3e-3).items():
            if path not in paths:
                left = [paths[path[:n]] for n in range(1, len(path) + 1) if path[:n] in paths]
                assert any(facets.status[i] == GIRDLE_CELL for i in left), path
                continue
            i, of = paths[path], facets.paths
            assert facets.status[i] == EXITED
            assert facets.share[i] == pytest.approx(share, abs=PATH)
            assert of.entering[i] * of.leaving[i] * of.section[i] == pytest.approx(light, abs=PATH)
            np.testing.assert_allclose(facets.exit_direction[i], direction, rtol=0, atol=PATH)
            compared += 1
    assert compared > 10


@pytest.mark.parametrize("principal", [MOISSANITE, STRONG])
@pytest.mark.parametrize("follows_all", [False, True])
def test_shares_make_the_view(stone, principal, follows_all):
    facets = trace_mode_facets(
        beam_stone(stone), crystal_of(principal, TILTED)[0], view=TOP, model=Model.of(stone), least=1e-4,
        follows_all=follows_all,
    )  # fmt: skip
    area = facets.paths.area[facets.paths.partial_reflections == 0]
    assert area.sum() + facets.unaccounted == pytest.approx(TOLD_AREA, abs=TILING)


def test_all_light_is_what_enters(stone):
    """Of what enters, what leaves and what still goes on make all."""
    facets = trace_mode_facets(
        beam_stone(stone), crystal_of(MOISSANITE, LYING)[0], view=TOP, model=Model.of(stone), least=1e-4,
        follows_all=True,
    )  # fmt: skip
    light = facets.paths.area * facets.paths.weight
    rest = light[facets.status == GIRDLE_CELL].sum()
    assert (light * facets.paths.leaving).sum() + rest == pytest.approx(TOLD_AREA, abs=TILING)


def test_the_beams_cross_section_is_what_its_ray_map_says(stone):
    """The product of ratios of cosines is the determinant of the map from the view."""
    facets = trace_mode_facets(
        beam_stone(stone), crystal_of(STRONG, TILTED)[0], view=ASIDE, model=Model.of(stone), least=1e-3
    )
    beams = facets.polygons.numbers[: len(facets)]
    across = np.cross(beams[:, 3:6], beams[:, 6:9])
    section = np.abs(np.sum(across * facets.exit_direction, axis=1))
    rows = facets.status == EXITED
    np.testing.assert_allclose(facets.paths.section[rows], section[rows], rtol=0, atol=PATH)


@pytest.mark.parametrize(
    ("principal", "axes"),
    [(MOISSANITE, LYING), (MOISSANITE, TILTED), (SAPPHIRE, LYING), (SAPPHIRE, TILTED), (STRONG, TILTED)],
)
@pytest.mark.parametrize(
    "n", [3000, pytest.param(1_000_000, marks=pytest.mark.slow)]
)  # of a million the error is 0.03
def test_scores_are_those_of_random_rays(stone, principal, axes, n):
    reference = crystal_of(principal, axes)[1]
    rng, parts = np.random.default_rng(6), max(n // 50_000, 1)
    found = [average_and_rear(stone, reference, TOP.basis(), n // parts, rng) for _ in range(parts)]
    average, rear, of_average, of_rear = np.mean(found, axis=0)
    measured, _ = score_modes(stone, principal=principal, axes=axes)
    by_rays = FOUR_ERRORS / np.sqrt(parts)
    assert measured.average == pytest.approx(average, abs=measured.bound + by_rays * of_average)
    assert measured.rear == pytest.approx(rear, abs=measured.bound + by_rays * of_rear)


def test_a_bound_that_is_asked_for_is_met_and_holds(stone):
    wide, _ = score_modes(stone, principal=MOISSANITE, axes=LYING, bound=0.5, least=1e-4, seed=3)
    close, _ = score_modes(stone, principal=MOISSANITE, axes=LYING, bound=0.05)
    assert wide.bound < 0.5
    assert close.bound < 0.05
    assert wide.average == pytest.approx(close.average, abs=wide.bound + close.bound)
    np.testing.assert_allclose(wide.bands, close.bands, rtol=0, atol=wide.bound + close.bound)


def test_a_part_tells_the_whole_where_the_optic_axis_is_the_stones(stone):
    part, of_part = score_modes(stone, principal=MOISSANITE, axes=STANDING)
    whole, of_whole = score_modes(stone, principal=MOISSANITE, axes=STANDING, zenith=np.eye(3)[2])
    assert (of_part.parts, of_whole.parts) == (16, 1)
    assert part.average == pytest.approx(whole.average, abs=part.bound + whole.bound)
    assert part.rear == pytest.approx(whole.rear, abs=part.bound + whole.bound)


def test_axes_of_equal_indices_change_nothing(stone):
    """Without birefringence the modes are any two, and the sums over both the same."""
    one, _ = score_modes(stone, principal=(1.76,) * 3, axes=LYING)
    other, _ = score_modes(stone, principal=(1.76,) * 3, axes=TILTED)
    assert one.average == pytest.approx(other.average, abs=one.bound + other.bound)

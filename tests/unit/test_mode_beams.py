"""Polygons with modes: beside rays by numpy, and beside what is known in closed form."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from beam_help import TOLD_AREA, owners
from designs_help import level, ring, stone_of
from exact_tolerances import EDGE, TILING
from mode_rays import average_and_rear, tree
from thorough import some

from gemrender.beam import beam_stone
from gemrender.beam.modes import optical_crystal, score_modes, trace_mode_facets
from gemrender.beam.polygons import EXITED, GIRDLE_CELL
from gemrender.cuts import load_stone, orientation
from gemrender.errors import InputError
from gemrender.measures import chosen_measures
from gemrender.observation import Model, View
from gemrender.optics.crystals import Indicatrix
from gemrender.optics.dispersion import SODIUM_NM
from gemrender.optics.material_files import load_material
from gemrender.scoring import score

#: Principal indices at the sodium line, of some hexagonal crystals and of one that is biaxial and strong.
MOISSANITE, SAPPHIRE = (2.6475, 2.6475, 2.6902), (1.7681, 1.7681, 1.7600)
STRONG = (1.65, 1.75, 1.9)
#: The optic axis along the table, along the stone's axis, and between.
LYING, STANDING = np.eye(3)[[1, 2, 0]], np.eye(3)
TURN = np.radians(35.0)
TILTED = np.array([[np.cos(TURN), 0, -np.sin(TURN)], [0, 1, 0], [np.sin(TURN), 0, np.cos(TURN)]])
#: Shares, intensities and directions after some reflections, by two ways in float64.
PATH = 1e-11
#: What the memory of how light was polarised changes of `iso` where nothing is birefringent [%].
POLARISED = 0.3
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


CRYSTALS = [(MOISSANITE, LYING), (SAPPHIRE, TILTED), (STRONG, LYING)]


@pytest.fixture(scope="module")
def stone():
    return load_stone("inoue-3")


@pytest.mark.parametrize(
    ("principal", "axes", "view"),
    some([(*of, view) for view in (TOP, ASIDE) for of in CRYSTALS], 2),
)
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
    some(
        [(MOISSANITE, LYING), (MOISSANITE, TILTED), (SAPPHIRE, LYING), (SAPPHIRE, TILTED), (STRONG, TILTED)],
        2,
    ),
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


# ---- Both images ---------------------------------------------------------------------------------------


def prism(angle):
    """A slab whose base is turned by an angle [deg] about y, between far walls."""
    turned = np.radians(angle)
    base = [[np.sin(turned), 0.0, -np.cos(turned), 0.3]]
    return stone_of(np.concatenate([ring(4, 90, 1.0), level(0.3), base]))


def doubling_of(stone, principal, axes, **options):
    [found] = score_modes(
        stone, principal=principal, axes=axes, measures=chosen_measures("doubling"), **options
    )[0].measures
    return found


CALCITE = (1.6584, 1.6584, 1.4864)
#: Angles in degrees, by some dozen operations and an arcsine.
ANGLE = 1e-10


def through(facets):
    """Tell what goes straight through a slab: not what meets the walls."""
    return (facets.paths.reflections == 0) & (facets.paths.entry_facet == 4) & (facets.paths.exit_facet == 5)


@pytest.mark.parametrize("view", [TOP, ASIDE])
def test_a_plate_turns_no_image(view):
    facets = trace_mode_facets(
        beam_stone(prism(0.0)), optical_crystal(CALCITE, TILTED), view=view, model=Model(),
        needs_images=True,
    )  # fmt: skip
    assert through(facets).sum() >= 2
    np.testing.assert_allclose(facets.paths.image_angle[through(facets)], 0.0, rtol=0, atol=ANGLE)


@pytest.mark.parametrize("angle", [5.0, 15.0, 30.0])
def test_a_prism_parts_images_by_the_difference_of_their_deviations(angle):
    """With the optic axis along its edge both indices are Snell's: sin(out) = n sin(angle)."""
    axes, sine = np.eye(3)[[2, 0, 1]], np.sin(np.radians(angle))
    apart = np.degrees(np.arcsin(CALCITE[0] * sine) - np.arcsin(CALCITE[2] * sine))
    facets = trace_mode_facets(
        beam_stone(prism(angle)), optical_crystal(CALCITE, axes), view=TOP, model=Model(),
        needs_images=True,
    )  # fmt: skip
    assert through(facets).sum() >= 2
    np.testing.assert_allclose(facets.paths.image_angle[through(facets)], apart, rtol=0, atol=ANGLE)


def test_no_birefringence_no_doubling(stone):
    assert doubling_of(stone, (1.76,) * 3, TILTED).values["value"] == pytest.approx(0.0, abs=ANGLE)


def test_rays_tell_the_doubling_that_polygons_do(stone):
    """With nearly all of it left to rays."""
    close = doubling_of(stone, MOISSANITE, LYING, bound=0.2)
    by_rays = doubling_of(stone, MOISSANITE, LYING, least=1e-2, bound=1.0)
    assert close.bound < 0.1
    assert close.values["value"] == pytest.approx(by_rays.values["value"], abs=close.bound + by_rays.bound)


# ---- Scores of stones whose material is birefringent ---------------------------------------------------


def made_of(material, **crystal):
    """Return the stone of the tests, of a material, its crystal lying so."""
    return replace(
        load_stone("inoue-3"), material=material, crystal=orientation(**crystal) if crystal else None
    )


def test_a_score_takes_the_crystal_of_the_material_as_it_lies():
    stone = made_of("moissanite", c_axis=(1.0, 0.0, 0.0))
    crystal = load_material("moissanite").crystal.indicatrix(SODIUM_NM, stone.crystal_axes)
    measured, _ = score_modes(
        stone, principal=crystal.indices, axes=crystal.frame, model=Model.of(stone), bound=0.5
    )
    found = score(stone, birefringence=True, measures="doubling", bound=0.5)
    assert found.average == pytest.approx(measured.average, abs=ANGLE)
    assert found.measures[0].values["value"] > 1.0


def test_by_default_a_score_is_that_of_the_ordinary_index():
    stone = made_of("moissanite")
    found, ordinary = score(stone, measures="doubling"), score(stone, index=Model.of(stone).index)
    assert found.average == ordinary.average
    assert np.isnan(found.measures[0].values["value"])


@pytest.mark.parametrize("options", [{"index": 2.6}, {}])
def test_what_is_isotropic_is_not_split(options):
    stone = made_of("moissanite" if options else "diamond")
    split = score(stone, birefringence=True, measures="doubling", **options)
    assert split.average == score(stone, **options).average
    assert split.measures[0].values["value"] == 0.0


def test_a_measure_over_all_views_is_refused(stone):
    with pytest.raises(InputError) as caught:
        score_modes(stone, principal=MOISSANITE, measures=chosen_measures("wlr-like"))
    assert caught.value.key == "measures"


def test_all_light_returns_as_without_birefringence_where_there_is_none(stone):
    """Of all light hardly anything tells how modes were polarised: `iso` is that of Fresnel's equations."""
    one = score_modes(stone, principal=(1.76,) * 3, axes=LYING, measures=chosen_measures("iso"), bound=0.5)[0]
    other = score(stone, index=1.76, fresnel="exact", measures="iso", bound=0.5)
    assert one.measures[0].values["value"] == pytest.approx(
        other.measures[0].values["value"], abs=one.measures[0].bound + other.measures[0].bound + POLARISED
    )


def test_the_command_splits_light_where_it_is_told_to(tmp_path, gemrender):
    path = tmp_path / "moissanite.toml"
    path.write_text(
        "[proportions]\ntable = 57\nstar = 50\nlower_girdle_contact = 20\ncrown_height = 14.5\n"
        'pavilion_depth = 43\ngirdle_thickness = 3\n[material]\nname = "moissanite"\n'
    )
    options = ["--json", "--birefringence", "--measures", "doubling", "--bound", "1"]
    status, out, _ = gemrender("score", path, *options)
    assert status == 0
    doubling = json.loads(out)[0]["measures"]["doubling"]
    assert doubling["value"] - doubling["bound"] > 0.1


def test_a_score_says_that_light_is_split():
    stone = replace(load_stone("inoue-3"), material="moissanite")
    assert score(stone, birefringence=True, bound=0.5).notes[0] == (
        "light is split: indices 2.64743, 2.68897"
    )
    assert not score(stone, bound=0.5).notes

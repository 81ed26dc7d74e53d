"""Derivatives of exact scores against differences of exact scores."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from beam_help import gem
from exact_tolerances import DERIVATIVE
from solids import bent_stone
from thorough import chosen, some

import gemrender
from gemrender.beam import beam_stone, measure
from gemrender.beam.by_tiers import design_unit, parameters_of_stone
from gemrender.beam.compiled import STEP
from gemrender.beam.sensitivity import PROPORTIONS, facet_totals, proportion_planes, sensitivity
from gemrender.cuts import RoundBrilliant, load_stone
from gemrender.cuts.families import families
from gemrender.cuts.meets import changeable
from gemrender.cuts.random import random_brilliant
from gemrender.cuts.turning import parameter_name
from gemrender.errors import InputError
from gemrender.observation import Model, View
from gemrender.stone import Stone

MODEL = Model(fresnel="exact")
DESIGNS = Path(__file__).parents[1] / "cases" / "stones"


def moved(proportions, parameter, by):
    return RoundBrilliant(**{**asdict(proportions), parameter: getattr(proportions, parameter) + by})


def assert_derivatives(stone, parameter, view=None):
    """Compare the derivatives of the sums over virtual facets with central differences of the sums.

    The sums jump where a facet reaches the critical angle, of some stones at every thousandth of a per cent,
    and differences of small steps have rounding: the step that agrees best counts.
    """
    ready = beam_stone(stone)
    planes = proportion_planes(stone.proportions, parameter)
    slopes = facet_totals(ready, planes, view=view, model=MODEL).imag / STEP
    errors = []
    for step in (1e-3, 1e-4, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7):
        low, high = (
            facet_totals(
                ready,
                beam_stone(gem(moved(stone.proportions, parameter, by))).solid.planes,
                view=view,
                model=MODEL,
            )
            for by in (-step, step)
        )
        errors.append(np.abs((high - low) / (2 * step) - slopes).max() / np.abs(slopes).max())
    assert min(errors) <= DERIVATIVE, f"{stone.name}, {parameter}: {min(errors):.1e}"


@pytest.mark.parametrize("part", some(range(10), 10))
def test01_derivatives_are_central_differences(part):
    """Rationale: areas and intensities of virtual facets are smooth, and edges that move are part of them.

    Expected: 50 random stones, each proportion: light, rear area, area of virtual facets and of girdle cells
    change as differences of exact sums say, to 1e-5 of the largest of the four.
    """
    rng = np.random.default_rng([11, part])
    for number in range(5):
        stone = gem(random_brilliant(rng), number)
        for parameter in PROPORTIONS:
            assert_derivatives(stone, parameter)


def test02_the_planes_derivative_is_the_planes_difference():
    proportions = load_stone("inoue-2").proportions
    for parameter in PROPORTIONS:
        planes = proportion_planes(proportions, parameter)
        sides = [beam_stone(gem(moved(proportions, parameter, by))).solid.planes for by in (-1e-4, 1e-4)]
        np.testing.assert_allclose(planes.imag / STEP, (sides[1] - sides[0]) / 2e-4, atol=1e-9)
        np.testing.assert_allclose(planes.real, beam_stone(load_stone("inoue-2")).solid.planes, atol=1e-14)


def test03_scores_change_as_told():
    """Sample 3 has next to no light near the girdle: differences of its scores are as its derivatives say."""
    stone = load_stone("inoue-3")
    told = sensitivity(stone, model=MODEL)
    for d in told.derivatives[: len(PROPORTIONS)]:
        step = 0.01
        low, high = (
            measure(gem(moved(stone.proportions, d.parameter, by)), model=MODEL, bound=0.001)
            for by in (-step, step)
        )
        # The same rays on both sides: their errors cancel but for a hundredth.
        slack = 0.01 * (low.bound + high.bound) / step + 1e-3
        assert d.average == pytest.approx((high.average - low.average) / (2 * step), abs=slack)
        assert d.rear == pytest.approx((high.rear - low.rear) / (2 * step), abs=slack)
        assert d.average_bound < 5e-3


def test04_angles_follow_from_heights():
    report = {"table": 57.0, "crown_angle": 34.0, "pavilion_angle": 40.7, "star": 50.0, "lower_half": 80.0,
              "girdle_thickness": 2.5}  # fmt: skip
    told = sensitivity(Stone.from_proportions(RoundBrilliant.from_angles(**report)), model=MODEL)
    for d in told.derivatives[len(PROPORTIONS) :]:
        sides = []
        for by in (-1e-4, 1e-4):
            changed = {**report, d.parameter: report[d.parameter] + by}
            sides.append(asdict(RoundBrilliant.from_angles(**changed)))
        by_chain = sum(
            e.average * (sides[1][e.parameter] - sides[0][e.parameter]) / 2e-4
            for e in told.derivatives[: len(PROPORTIONS)]
        )
        assert d.average == pytest.approx(by_chain, rel=1e-6)
        assert d.unit == ("deg" if d.parameter.endswith("angle") else "%")


@pytest.mark.parametrize("parameter", chosen(PROPORTIONS, ["table", "pavilion_depth"]))
def test05_the_stated_bound_covers_more_rays(parameter):
    stone = load_stone("inoue-2")
    coarse, fine = (
        sensitivity(stone, model=MODEL, bound=bound, seed=seed, parameters=[parameter])
        for bound, seed in ((10, 3), (2, 4))
    )
    for a, b in zip(coarse.derivatives, fine.derivatives, strict=True):
        assert abs(a.average - b.average) <= a.average_bound + b.average_bound
        assert abs(a.rear - b.rear) <= a.rear_bound + b.rear_bound


#: Of a round brilliant, of a family, and of a design, and what they are differentiated by.
CHOSEN = [
    (
        load_stone("inoue-3"),
        ["crown_angle", ("table", "angles")],
        [("table", "angles"), ("crown_angle", "angles")],
    ),
    (
        families()["emerald"]().stone(material="quartz"),
        [("table", "proportions"), "pavilion_depth"],
        [("table", "proportions"), ("pavilion_depth", "proportions")],
    ),
    (load_stone(DESIGNS / "square-barion.asc"), ["P2 angle"], [("P2 angle", "tiers")]),
]


@pytest.mark.parametrize(("stone", "chosen", "expected"), CHOSEN, ids=["round", "family", "design"])
def test_by_chosen_parameters_derivatives_are_the_same(stone, chosen, expected):
    """With as many rays, to the bit."""
    options = {"max_reflections": 6, "bound": 10.0}
    whole, found = (sensitivity(stone, parameters=of, **options) for of in (None, chosen))
    assert [(of.parameter, of.kept) for of in found.derivatives] == expected
    assert found.derivatives == tuple(of for of in whole.derivatives if (of.parameter, of.kept) in expected)
    # Told with the last of them: of virtual facets some too small to count are others.
    assert (found.average, found.rear) == pytest.approx((whole.average, whole.rear), abs=1e-6)


def test_a_parameter_that_there_is_not_is_told():
    with pytest.raises(InputError, match="parameter = 'depth': must be one of table, star, "):
        sensitivity(load_stone("inoue-3"), parameters=["depth"])
    with pytest.raises(InputError, match="parameter: names none to differentiate by"):
        sensitivity(load_stone("inoue-3"), parameters=[])


def test06_at_the_end_of_a_range_one_side_is_enough():
    thin = {**asdict(load_stone("inoue-3").proportions), "girdle_thickness": 0.0}
    told = sensitivity(gem(RoundBrilliant(**thin)), model=MODEL)
    assert np.isfinite([d.average for d in told.derivatives]).all()


@pytest.mark.parametrize("parameter", chosen(PROPORTIONS, ["table", "pavilion_depth"]))
def test07_a_tilted_view_is_differentiated_too(parameter):
    assert_derivatives(load_stone("inoue-3"), parameter, View(resolution=1, tilt_deg=15, tilt_azimuth_deg=10))


@pytest.mark.parametrize(
    "stone", [bent_stone(-0.003), load_stone("inoue-3").rotated(5)], ids=["bent", "turned"]
)
def test08_a_stone_without_proportions_is_refused(stone):
    with pytest.raises(InputError, match="has no proportions to differentiate by"):
        sensitivity(stone)


# ---- Designs -------------------------------------------------------------------------------------------
#: Step of the difference quotient of exact scores [deg], [%], and how far it is off: its second order, and a
#: score's rounding over the step.
TIER_STEP, TIER_QUOTIENT = 2e-4, 0.02


@pytest.mark.parametrize("name", ["square-barion", "slab-chiral"])
def test_tiers_of_a_design(name):
    stone = load_stone(DESIGNS / f"{name}.asc")
    design = stone.cut
    found = sensitivity(stone)
    tiers = design.tier_names()
    of_facet = dict(zip(design.facet_names(), design.facet_tiers, strict=True))
    on_the_stone = {tiers[of_facet[name]] for name in stone.facet_names}
    assert {d.parameter.rsplit(" ", 1)[0] for d in found.derivatives} == on_the_stone
    for derivative in found.derivatives:
        tier, quantity = derivative.parameter.rsplit(" ", 1)
        number = tiers.index(tier)
        key, step = (
            ("angle_deg", 1.0) if quantity == "angle" else ("distance", 0.01 * design_unit(stone, design))
        )
        value = getattr(design.tiers[number], key)
        sides = [
            gemrender.score(design.with_tier(number, **{key: value + by * step}).stone(), rear="facet")
            for by in (-TIER_STEP, 0.0, TIER_STEP)
        ]
        for score in ("average", "rear"):
            # Facets of files miss their meets by 1e-5: edges open within a step, and slopes follow.
            slopes = np.diff([getattr(side, score) for side in sides]) / TIER_STEP
            assert slopes.min() - TIER_QUOTIENT <= getattr(derivative, score) <= slopes.max() + TIER_QUOTIENT
            assert getattr(derivative, f"{score}_bound") == 0


#: Central differences of scores of designs made anew, with all meets kept: their second order, and a score's
#: rounding over the step [% per deg or %].
KEPT_STEP, KEPT_QUOTIENT = 1e-4, 1e-5


MEETS = ["round", "square-barion", "triangle-negative-gear"]


@pytest.mark.parametrize("name", chosen(MEETS, ["square-barion"]))
def test_tiers_of_a_design_whose_meets_are_kept(name):
    """Nothing opens at a corner, so that slopes have one side only and are as exact as differences."""
    stone = load_stone(DESIGNS / f"{name}.asc")
    found = {of.parameter: of for of in sensitivity(stone, meets="kept").derivatives}
    ways = changeable(stone.cut, "kept")
    design = ways.design
    closed = design.stone(name=stone.name, material=stone.material)
    parameters = parameters_of_stone(closed, design)
    assert set(found) == {parameter_name(design, *of) for of in parameters}
    for tier, quantity in parameters:
        derivative = found[parameter_name(design, tier, quantity)]
        step = KEPT_STEP * (1.0 if quantity == "angle_deg" else 0.01 * design_unit(closed, design))
        value = getattr(design.tiers[tier], quantity)
        low, high = (
            gemrender.score(ways.changed({(tier, quantity): value + by}).stone(), rear="facet")
            for by in (-step, step)
        )
        assert derivative.average_bound == derivative.rear_bound == 0
        for score in ("average", "rear"):
            quotient = (getattr(high, score) - getattr(low, score)) / (2 * KEPT_STEP)
            assert getattr(derivative, score) == pytest.approx(quotient, abs=KEPT_QUOTIENT)


def test_only_designs_have_meets():
    with pytest.raises(InputError, match="meets = 'kept': only designs of tiers have meets"):
        sensitivity(load_stone("gia-excellent"), meets="kept")

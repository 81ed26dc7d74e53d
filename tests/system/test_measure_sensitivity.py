"""Derivatives of every measure that has them, against differences of exact sums."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

import gemrender
from gemrender.beam import beam_stone
from gemrender.beam.by_parameters import changes_of
from gemrender.beam.by_tiers import parameters_of_stone, tier_planes
from gemrender.beam.compiled import STEP
from gemrender.beam.derivatives import smooth_values
from gemrender.beam.sensitivity import PROPORTIONS, proportion_planes, sensitivity, smooth_measures
from gemrender.beam.totals import facet_sides, facet_totals
from gemrender.cuts import RoundBrilliant, load_stone
from gemrender.cuts.families import families
from gemrender.cuts.meets import changeable
from gemrender.cuts.random import random_brilliant
from gemrender.errors import InputError
from gemrender.measures.measure import Measure
from gemrender.measures.tally import Tally
from gemrender.observation import Model, View
from gemrender.stone import Stone
from tests.exact_tolerances import DERIVATIVE

ALL = [of for of in smooth_measures("all") if of.views == "one"]
DESIGNS = Path(__file__).parents[1] / "cases" / "stones"
#: Steps of central differences [% or deg]: values jump where facets reach the critical angle, the edge of a
#: band, or of a zone; small steps have rounding; the one that agrees best counts.
STEPS = (1e-5, 1e-6, 1e-7, 1e-8)


def tally_of(stone):
    """All that can be differentiated, with fewer virtual facets than there are."""
    model = Model.of(stone, fresnel="exact", max_reflections=6)
    return Tally(View(resolution=1), model, ALL)


def assert_derivatives(stone, planes, moved, whole=False, tally=None):
    """Compare derivatives of all sums, and of the values, with central differences; return their sides."""
    ready, tally = beam_stone(stone), tally or tally_of(stone)

    def with_values(totals):
        return np.concatenate([totals, smooth_values(tally, totals[2], totals[4:])])

    def found(planes):
        return with_values(
            facet_totals(ready, planes, view=tally.view, model=tally.model, tally=tally, whole=whole)
        )

    sides = [
        with_values(side.totals) for side in facet_sides(ready, planes, tally, whole=whole, walls_move=True)
    ]
    assert np.isfinite(sides).all()
    slopes = np.mean(sides, axis=0).imag / STEP
    n = len(facet_totals(ready, planes.real.copy(), tally=tally))
    sizes = np.repeat([np.abs(slopes[:n]).max(), np.abs(slopes[n:]).max()], [n, len(slopes) - n])
    errors = []
    for step in STEPS:
        low, high = (found(np.ascontiguousarray(moved(by))) for by in (-step, step))
        errors.append((np.abs((high - low) / (2 * step) - slopes) / sizes).max())
        if errors[-1] <= DERIVATIVE:
            return len(sides)
    raise AssertionError(f"{stone.name}: {min(errors):.1e}")


@pytest.mark.parametrize("number", range(3))
def test_of_round_brilliants(number):
    """Rationale: what a measure adds per unit of a virtual facet's area is a smooth function of the planes.

    Expected: sums of all channels and all values change as differences say, to 1e-5 of the largest slope.
    """
    proportions = random_brilliant(np.random.default_rng([17, number]))
    stone = Stone.from_proportions(proportions, material="sapphire")
    for parameter in PROPORTIONS[number::3]:

        def moved(by, parameter=parameter):
            numbers = asdict(proportions)
            numbers[parameter] += by
            return beam_stone(Stone.from_proportions(RoundBrilliant(**numbers))).solid.planes

        assert_derivatives(stone, proportion_planes(proportions, parameter), moved)


@pytest.mark.parametrize("name", ["emerald", "princess", "asscher"])
def test_of_families(name):
    cut = families()[name]()
    stone = cut.stone(material="sapphire")
    changes = [change for change in changes_of(cut) if change.value and change.parameter != "length_to_width"]
    for change in changes[::3]:
        assert_derivatives(
            stone, change.planes(cut), lambda by, change=change: change.moved(stone, by).solid.planes
        )


def closed(name):
    """Return a design from a file, and of quartz, all its facets exactly at their meets."""
    design = changeable(load_stone(DESIGNS / f"{name}.asc").cut, "kept").design
    return replace(design.stone(name=name), material="quartz")


@pytest.mark.parametrize(
    ("name", "first", "by"), [("square-barion", 0, 1), ("checkerboard-round", 0, 1), ("emerald", 0, 4)]
)
def test_of_designs_at_their_meets(name, first, by):
    """Rationale: where more than three facets meet, what opens at the point is of second order in a step.

    Expected: slopes by angle and distance of tiers are central differences, with one side.
    """
    stone = closed(name)
    measures = [of for of in ALL if of.follow == "principal"]
    tally = Tally(View(resolution=1), tally_of(stone).model, measures)
    for tier, quantity in parameters_of_stone(stone, stone.cut)[first::by]:
        planes = tier_planes(stone, stone.cut, tier, quantity)
        speed = planes.imag / STEP
        sides = assert_derivatives(
            stone, planes, lambda by, real=planes.real, speed=speed: real + by * speed, True, tally
        )
        assert sides == 1


def test_of_all_light_of_a_design_at_its_meets():
    stone = closed("square-barion")
    for tier in (1, 4):
        planes = tier_planes(stone, stone.cut, tier, "angle_deg")
        assert_derivatives(
            stone, planes, lambda by, planes=planes: planes.real + by * planes.imag / STEP, True
        )


def test_where_both_sides_differ_their_mean_is_told():
    """Rationale: where virtual facets of no width open, each side has slopes of its own.

    Expected: of this emerald's pavilion the mean of both as differences of either side, and half of what they
    differ by as bound.
    """
    cut = families()["emerald"]()
    stone = cut.stone(material="sapphire")
    model = Model.of(stone, fresnel="exact", max_reflections=6)
    change = next(of for of in changes_of(cut) if of.parameter == "pavilion_depth")
    (told,) = sensitivity(stone, model=model, parameters=[change.parameter]).derivatives
    step = 1e-5
    low, here, high = (
        gemrender.score(change.moved(stone, by), model=model).average for by in (-step, 0.0, step)
    )
    below, above = (here - low) / step, (high - here) / step
    assert told.average == pytest.approx(0.5 * (below + above), rel=1e-3)
    assert told.average_bound == pytest.approx(0.5 * abs(above - below), rel=1e-3)
    assert told.average_bound > 0.5


def test_a_round_girdle_has_bounds():
    """Near a round girdle a difference of scores lies within the bounds."""
    stone = load_stone("inoue-3")
    (of,) = sensitivity(
        stone, measures=["extinction", "window"], bound=1.0, parameters=["pavilion_depth"]
    ).derivatives
    assert [(v.measure, v.key) for v in of.measures][::2] == [("extinction", "head"), ("extinction", "tied")]
    step, numbers = 0.001, asdict(stone.proportions)
    low, high = (
        gemrender.score(
            Stone.from_proportions(
                RoundBrilliant(**{**numbers, "pavilion_depth": numbers["pavilion_depth"] + by})
            ),
            measures="extinction",
            bound=0.002,
        ).measures[0]
        for by in (-step, step)
    )
    for value in of.measures[:2]:
        slope = (high.values[value.key] - low.values[value.key]) / (2 * step)
        # The same rays on both sides: most of their errors cancel.
        allowed = value.bound + 0.1 * (low.bound + high.bound) / (2 * step)
        assert abs(value.slope - slope) <= allowed < 0.5


def test_values_and_slopes_are_told():
    stone = families()["emerald"]().stone(material="quartz")
    by = {"max_reflections": 10, "parameters": ["table", "pavilion_angle"]}
    found = sensitivity(stone, measures="inoue,aset", bound=5.0, **by).to_dict()
    for of in found["derivatives"]:
        assert of["measures"]["inoue"]["average"]["slope"] == pytest.approx(of["average"], abs=1e-12)
        zones = of["measures"]["aset"]
        assert sum(
            zones[key]["slope"] for key in ("green", "red", "blue", "leak", "trapped")
        ) == pytest.approx(0.0, abs=1e-9)
    assert "measures" not in sensitivity(stone, **by).to_dict()["derivatives"][0]


def test_what_has_no_derivative_is_refused_with_the_reason():
    class Silent(Measure):
        name = "silent"

    with pytest.raises(
        InputError, match=r"measures = 'facets': cannot .*: its values are numbers .*inoue, iso"
    ):
        smooth_measures("facets")
    with pytest.raises(InputError, match="measures = 'silent': cannot be differentiated: it does not say"):
        smooth_measures(Silent())
    names = [of.name for of in smooth_measures("all")]
    jumps = ("facets", "doubling")
    assert names == [of.name for of in gemrender.measures.measures() if of.name not in jumps]


def test_a_measure_of_ones_own_says_what_is_smooth():
    class Overhead(Measure):
        name, smooth_keys, follow = "overhead", ("value",), "principal"

        def contributions(self, light):
            return light.share * light.zenith_cosine * (light.zenith_cosine.real > 0.9)

    cut = families()["emerald"]()
    stone = cut.stone(material="sapphire")
    change = next(of for of in changes_of(cut) if of.parameter == "crown_height")
    model = Model.of(stone, fresnel="exact", max_reflections=6)
    found = sensitivity(stone, model=model, measures=Overhead()).derivatives
    (found,) = [of.measures[0].slope for of in found if of.parameter == "crown_height"]
    tally = Tally(View(resolution=1), model, [Overhead()])
    step = 1e-7
    low, high = (
        smooth_values(tally, totals[2], totals[4:])[0]
        for totals in (
            facet_totals(
                beam_stone(stone), change.moved(stone, by).solid.planes, view=tally.view, model=tally.model,
                tally=tally,
            )
            for by in (-step, step)
        )
    )  # fmt: skip
    assert found == pytest.approx((high - low) / (2 * step), rel=1e-4)


def test_dispersion_needs_no_other_measure():
    """Rationale: its normals come with paths of all light; asked for alone it once had none, and no value."""
    stone = load_stone("inoue-3")
    (alone,) = gemrender.score(stone, measures="dispersion").measures
    (beside, _) = gemrender.score(stone, measures="dispersion,iso").measures
    for key, value in alone.values.items():
        assert value == pytest.approx(beside.values[key], abs=alone.bound + beside.bound)

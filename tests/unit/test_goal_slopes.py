"""Derivatives of goals: by the values that they are made of, and by what is varied."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from gemrender.beam.sensitivity import sensitivity
from gemrender.cuts import RoundBrilliant, load_stone
from gemrender.cuts.families import families
from gemrender.stone import Stone
from gemrender.sweep.improve.goal_slopes import goal_slopes, has_slopes
from gemrender.sweep.improve.goals import Goal
from gemrender.sweep.improve.rough import Diameter
from gemrender.sweep.improve.search import prepare_search

VALUES = {"iso.value": 80.0, "aset.leak": 6.0, "inoue.average": 60.0, "volume": 2.0}
#: Half the step of central differences [% or deg], and what they are off by, rounding for the most part.
STEP, CLOSE = 1e-6, 1e-5
#: Away from a pavilion of 45 degrees, where its light jumps.
STEP_CUT = families()["emerald"](table=63.3, crown_height=12.7, pavilion_depth=47.3).stone(
    name="e", material="quartz"
)


@pytest.mark.parametrize(
    ("text", "partials"),
    [
        ("iso - 0.5*leak", {"iso.value": 1.0, "aset.leak": -0.5}),
        ("-(iso * leak)", {"iso.value": -6.0, "aset.leak": -80.0}),
        ("iso / leak", {"iso.value": 1 / 6, "aset.leak": -80 / 36}),
        ("leak**3 + 2", {"aset.leak": 108.0}),
        ("leak**0", {"aset.leak": 0.0}),
        ("min(iso, 70) + max(leak, 1)", {"iso.value": 0.0, "aset.leak": 1.0}),
        ("abs(leak - 10)", {"aset.leak": -1.0}),
        ("volume**0.5", {"volume": 0.5 / math.sqrt(2.0)}),
        ("aset.leak + inoue + inoue.average", {"aset.leak": 1.0, "inoue.average": 2.0}),
    ],
)
def test_a_goal_is_differentiated_by_its_values(text, partials):
    assert Goal.parse(text).partials(VALUES) == pytest.approx(partials)


@pytest.mark.parametrize("text", ["1 / (leak - 6)", "(leak - 7)**0.5"])
def test_where_a_goal_is_no_number_it_has_no_derivative(text):
    assert math.isnan(Goal.parse(text).partials(VALUES)["aset.leak"])


@pytest.mark.parametrize(
    ("text", "exact"),
    [
        ("inoue - 0.5*leak", True),
        ("volume", True),
        ("iso", True),
        ("carat", False),
        ("worst(inoue, 10)", False),
        ("inoue - spread(inoue)", False),
    ],
)
def test_which_goals_have_exact_slopes(text, exact):
    assert has_slopes(Goal.parse(text)) is exact


@pytest.mark.parametrize("varied", [("table", "crown_angle", "pavilion_angle"), ("table", "pavilion_bulge")])
def test_exact_slopes_are_those_of_differences(varied):
    """By what the search moves: with the crown's angle kept where that is varied, else with its height."""
    search = prepare_search(STEP_CUT, ["inoue - 0.5*leak + 3*volume**2"], varied)
    values = search.own_values()
    (slopes,) = goal_slopes(search, values)
    for name in varied:
        low, high = (
            search.goals_of(search.stone_of({**values, name: values[name] + by}))[0] for by in (-STEP, STEP)
        )
        assert slopes[name].between is None
        assert slopes[name].slope == pytest.approx((high - low) / (2 * STEP), rel=CLOSE, abs=1e-6)


def test_the_slopes_of_a_design_whose_other_tiers_follow():
    """Its meets are kept, so that one angle moves many tiers: the chain goes through all of them."""
    stone = load_stone(Path(__file__).parents[1] / "cases" / "stones" / "square-barion.asc")
    search = prepare_search(stone, ["inoue"], ["P2 angle"])
    values, step = search.own_values(), 1e-5
    (slopes,) = goal_slopes(search, values)
    low, high = (search.goals_of(search.stone_of({"P2 angle": 43.0 + by}))[0] for by in (-step, step))
    assert values == {"P2 angle": 43.0}
    assert slopes["P2 angle"].between is None
    assert slopes["P2 angle"].slope == pytest.approx((high - low) / (2 * step), rel=CLOSE)


def test_a_table_s_slope_depends_on_what_is_kept():
    stone = families()["emerald"]().stone(name="e")
    slopes = []
    for varied in (["table"], ["table", "crown_angle"]):
        search = prepare_search(stone, ["volume"], varied)
        slopes.append(goal_slopes(search, search.own_values())[0]["table"].slope)
    assert abs(slopes[0] - slopes[1]) > 1e-3


def test_the_slopes_of_a_round_brilliant():
    """Near its girdle light is told by rays: to the bound, which differences of the goal have as well."""
    cut = RoundBrilliant.from_angles(
        table=56, crown_angle=35, pavilion_angle=40.7, star=50, lower_half=80, girdle_thickness=3
    )
    search = prepare_search(Stone.from_proportions(cut), ["inoue"], ["crown_angle", "pavilion_angle"])
    values, step = search.own_values(), 1e-3
    (slopes,) = goal_slopes(search, values)
    for name, of in slopes.items():
        low, high = (
            search.goals_of(search.stone_of({**values, name: values[name] + by}), bound=0.005)[0]
            for by in (-step, step)
        )
        assert of.slope == pytest.approx((high - low) / (2 * step), rel=0.02)
        assert of.bound < 0.2


def test_a_difference_stays_within_the_next_jump():
    stone = families()["emerald"]().stone(name="e", material="sapphire")
    slopes = []
    for goal in ("mean(volume, 5)", "volume - 0*carat"):
        search = prepare_search(stone, [goal], ["table=60:70:0.5"], rough=Diameter(6.5))
        slopes.append(goal_slopes(search, search.own_values(), {"table": (0.1, math.inf)})[0]["table"])
    of_mean, local = slopes
    assert of_mean.between == (64.5, 65.5)
    # Most of the way to the jump a tenth below the table of 65, and the whole step above
    assert 65 - 0.1 < local.between[0] < 65 - 0.8 * 0.1
    assert local.between[1] == 65.5
    assert of_mean.slope == pytest.approx(local.slope, rel=0.01)
    assert of_mean.to_dict()["between"] == [64.5, 65.5]


def test_at_the_end_of_what_can_be_made_a_difference_is_one_sided():
    stone = families()["emerald"](culet=0.0).stone(name="e")
    search = prepare_search(stone, ["mean(volume, 5)"], ["culet=0:2:0.5"])
    (slopes,) = goal_slopes(search, search.own_values())
    assert slopes["culet"].between == (0.0, 0.5)
    assert np.isfinite(slopes["culet"].slope)


@pytest.mark.parametrize(
    ("varied", "moves"),
    [
        (["pavilion_angle"], {"pavilion_depth"}),
        (["crown_angle", "star"], {"crown_height", "star"}),
        (["table", "crown_angle"], {"table", "crown_height"}),
    ],
)
def test_only_what_the_varied_parameters_move_is_differentiated_by(monkeypatch, varied, moves):
    asked = []

    def told(*arguments, parameters, **options):
        asked.append(set(parameters))
        return sensitivity(*arguments, parameters=parameters, **options)

    monkeypatch.setattr("gemrender.sweep.improve.goal_slopes.sensitivity", told)
    search = prepare_search(load_stone("inoue-3"), ["inoue"], varied)
    (slopes,) = goal_slopes(search, search.own_values(), bound=10.0)
    assert asked == [{(name, "proportions") for name in moves}]
    assert all(slopes[name].slope for name in varied)

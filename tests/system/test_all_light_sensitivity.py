"""Derivatives of measures of all light: polygons exactly, what they leave and all views within bounds."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from thorough import chosen

from gemrender.beam import beam_stone, slopes
from gemrender.beam.budget import Budget
from gemrender.beam.by_parameters import changes_of
from gemrender.beam.compiled import STEP
from gemrender.beam.derivatives import derivative
from gemrender.beam.hemisphere import measure_hemisphere
from gemrender.beam.hemisphere_slopes import hemisphere_slopes
from gemrender.beam.sensitivity import proportion_planes, sensitivity
from gemrender.beam.totals import facet_sides, facet_totals, side_sums
from gemrender.cuts import load_stone
from gemrender.cuts.families import families
from gemrender.measures import measure_named
from gemrender.measures.tally import Tally, bounds_of_sets
from gemrender.observation import Model, View

SCRIPT = runpy.run_path(str(Path(__file__).parents[2] / "scripts" / "compare_derivatives.py"))
#: Polygons and rays together give and take nothing, to rounding, and where slopes have two sides the share
#: that is taken for none.
CONSERVED = 1e-6
#: The channels of `aset` that make all light.
SHARES = [5, 6, 7, 8, 9, 10]


def emerald(material="quartz"):
    cut = families()["emerald"]()
    return cut, cut.stone(material=material)


def change_of(cut, parameter):
    return next(of for of in changes_of(cut) if (of.parameter, of.kept) == (parameter, "proportions"))


@pytest.mark.parametrize("number", chosen(range(5), [0, 1, 4]))
def test_of_random_stones(number):
    """Rationale: weights, Fresnel's terms and edges of light that was reflected in part are analytic, too.

    Expected: all values, and the light that is left to rays, change by one parameter as differences of the
    same tree of paths say, to 1e-5 of 1 % per unit or of themselves; another parameter for each cut.
    """
    *_, stone = SCRIPT["random_stones"](number + 1, 5)
    parameters = SCRIPT["moving"](stone)
    model = Model.of(stone, fresnel="exact", max_reflections=8)
    compared = SCRIPT["Compared"](stone, 1e-3, model)
    found = compared.differences(parameters[(3 * number + 1) % len(parameters)])
    assert all(of.is_smooth for of in found)
    assert len({of.value.split()[0] for of in found}) == 12  # of 13 measures two have none here, and `left`
    assert max(of.error for of in found) <= SCRIPT["ALLOWED"]


def test_what_is_left_to_rays_lies_within_its_bound():
    """Expected: few polygons and many rays have the slope that the light of many more polygons has."""
    cut, stone = emerald()
    planes, ready = change_of(cut, "table").planes(cut), beam_stone(stone)
    tally = Tally(View(resolution=1), Model.of(stone), [measure_named("iso")])
    (few,), (many,) = (facet_sides(ready, planes, tally, least=least) for least in (1e-5, 1e-8))
    assert abs(few.later.amount) > 100.0 * abs(many.later.amount)

    def slope_of(side, sums):
        return 100.0 * sums[..., 4].imag / STEP / side.totals[2].real

    found, exact = slope_of(few, side_sums([few], 1, 2048))[0], slope_of(many, many.totals)
    bound = float(bounds_of_sets(found[:, None])[0])
    assert abs(found.mean() - exact) <= bound + 0.01  # of light that the many leave
    assert 0.0 < bound < 0.3


@pytest.mark.parametrize("parameter", ["table", "pavilion_depth"])
def test_all_light_is_conserved(parameter):
    """What leaves, is mirrored, or stays inside makes the view, and so its slopes make the view's."""
    cut, stone = emerald("sapphire")
    tally = Tally(View(resolution=1), Model.of(stone, max_reflections=30), [measure_named("aset")])
    sides = facet_sides(beam_stone(stone), change_of(cut, parameter).planes(cut), tally)
    sums = side_sums(sides, 1, 64)
    of_all = sums[..., 4:][..., SHARES].sum(axis=-1)
    np.testing.assert_allclose(of_all.real, sums[..., 2].real, rtol=CONSERVED)
    np.testing.assert_allclose(of_all.imag / STEP, sums[..., 2].imag / STEP, atol=CONSERVED)
    assert np.abs(sums[..., 4:][..., SHARES].imag / STEP).max() > 1e-3  # light goes elsewhere


def test_lines_at_the_walls_may_move_or_stay():
    """Where rays take over from polygons near a round girdle is no edge of the stone.

    Expected: with lines that move light goes from polygons to rays and back, and both together have as much;
    such lines are those of the traced sums.
    """
    stone = load_stone("inoue-3")
    ready, tally = beam_stone(stone), Tally(View(resolution=1), Model.of(stone), [measure_named("aset")])
    planes = proportion_planes(stone.proportions, "pavilion_depth")
    (moves,), (stays,) = (facet_sides(ready, planes, tally, walls_move=of) for of in (True, False))
    both = [(side.totals[4:][SHARES].sum() + side.later.amount).imag / STEP for side in (moves, stays)]
    assert both[0] == pytest.approx(both[1], abs=CONSERVED)
    assert abs(moves.later.amount - stays.later.amount) / STEP > 1e-4
    assert moves.totals == pytest.approx(facet_totals(ready, planes, tally=tally))


def test_of_all_views():
    """The slope of a sum over all views lies within its bound of a difference of exact scores."""
    cut, stone = emerald()
    change, step, of = change_of(cut, "crown_height"), 2.0, measure_named("wlr-like")
    slopes = hemisphere_slopes(
        beam_stone(stone), change.planes(cut), Model.of(stone), [of],
        wanted=1.0, seed=1, whole=False, budget=Budget(60.0, 1.0),
    )  # fmt: skip
    told = derivative(
        "crown_height", "proportions", "%", [of], np.concatenate([np.zeros((2, 16, 2)), slopes], 2)
    )
    low, high = (
        measure_hemisphere(beam_stone(change.moved(stone, by)), Model.of(stone), [of], bound=0.6, seed=3)[0]
        for by in (-step, step)
    )
    slope = (high.values["value"] - low.values["value"]) / (2 * step)
    (value,) = told.measures
    assert abs(value.slope - slope) <= value.bound + (low.bound + high.bound) / (2 * step)
    assert 0.0 < value.bound < 0.02


def test_measures_are_told_in_the_order_asked_for(monkeypatch):
    """Those of all views are worked out last."""
    monkeypatch.setattr(slopes, "hemisphere_slopes", lambda *_, **__: np.full((2, 16, 1), 0.5))
    _, stone = emerald()
    options = {"max_reflections": 6, "parameters": ["table"]}
    for of in sensitivity(stone, measures="wlr-like,window", **options).derivatives:
        assert [value.measure for value in of.measures] == ["wlr-like", "window"]
        assert (of.measures[0].slope, of.measures[0].bound) == (0.5, 0.0)

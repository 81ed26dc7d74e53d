"""Bow-ties: areas in sectors in closed form, and what must be so of the dark shares of symmetric stones."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from gemrender.beam.bow_tie import area_in_sector, belly_sectors, bow_tie
from gemrender.cuts import load_stone
from gemrender.cuts.families import families
from gemrender.scoring import score

#: Areas after a few operations on numbers of order 1.
ROUNDING = 1e-12
#: Sums of thousands of areas, and shares of them.
SUMS = 1e-9
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def direction(degrees: float) -> list[float]:
    return [math.cos(math.radians(degrees)), math.sin(math.radians(degrees))]


def within(polygon, apex, first, second) -> float:
    ends = np.array([len(polygon)])
    sector = np.array([direction(first), direction(second)])
    (area,) = area_in_sector(polygon, np.array([0]), ends, np.array(apex), sector)
    return float(area)


@pytest.mark.parametrize(
    ("apex", "first", "second", "area"),
    [
        ((0, 0), -45, 45, 1.0),
        ((0, 0), 0, 45, 0.5),
        ((0, 0), -30, 30, math.tan(math.radians(30))),
        ((-1, -1), 0, 90, 4.0),  # from a corner all of it
        ((-2, 0), -45, 45, 4.0),  # from outside, through a side: half its height is 1 to 3
        ((-2, -1), 0, 45, 3.5),  # all but the triangle above the side
        ((0, 0), 10, 100, 1.0),  # a quarter turn from the middle, whichever way
        ((3, 0), -45, 45, 0.0),  # away from it
    ],
)
def test_area_of_a_square_in_a_sector(apex, first, second, area):
    assert within(SQUARE, apex, first, second) == pytest.approx(area, abs=ROUNDING)


def test_sectors_all_round_make_the_whole_polygon():
    rng = np.random.default_rng(4)
    turns = np.sort(rng.uniform(0, 360, 12))
    polygon = np.array([direction(turn) for turn in turns]) * [0.7, 1.3]
    for apex in rng.uniform(-1.5, 1.5, (20, 2)):
        sides = np.arange(0, 361, 60) + rng.uniform(0, 60)
        parts = [within(polygon, apex, *pair) for pair in itertools.pairwise(sides)]
        assert min(parts) >= -ROUNDING
        x, y = polygon.T
        whole = 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))
        assert sum(parts) == pytest.approx(whole, abs=ROUNDING)


def test_the_belly_of_an_ellipse_is_a_quarter_of_it():
    found = bow_tie(families()["oval"](length_to_width=1.3, shoulder=0.0, mains=6).stone(), max_reflections=6)
    assert found.belly.area == pytest.approx(0.25, abs=SUMS)
    assert found.ends.area == pytest.approx(0.75, abs=SUMS)
    parts = [found.belly.area * found.belly.dark, found.ends.area * found.ends.dark]
    assert sum(parts) == pytest.approx(found.whole.dark, abs=SUMS)


def test_a_round_brilliant_has_no_bow_tie():
    """Its belly is two of eight equal parts."""
    found = bow_tie(load_stone("inoue-3"))
    assert found.belly.area == pytest.approx(0.25, abs=SUMS)
    assert found.contrast == pytest.approx(0.0, abs=SUMS)
    assert found.belly.leaking == pytest.approx(found.whole.leaking, abs=SUMS)


def test_the_belly_of_a_pear_lies_about_its_culet():
    cut = families()["pear"](culet_to_point=5.0)
    apex, (right, left) = belly_sectors(cut.stone())
    assert apex == pytest.approx([0.0, 1 / 1.55 - 1 + 0.1], abs=ROUNDING)
    assert right[1] == pytest.approx([1.0, 1.55 * math.tan(math.pi / 8)], abs=ROUNDING)
    assert left.tolist() == (-right).tolist()


def test_dark_and_leaking_are_the_zones_of_an_aset():
    """Its blue zone ends 15 degrees from the zenith; what never leaves counts as leaking here."""
    stone = families()["marquise"](mains=6).stone()
    whole = bow_tie(stone).whole
    aset = score(stone, measures=["aset"]).measures[0].values
    assert 100 * whole.dark == pytest.approx(aset["blue"], abs=1e-6)
    assert 100 * whole.leaking == pytest.approx(aset["leak"] + aset["trapped"], abs=1e-6)


@pytest.mark.parametrize("name", ["oval", "marquise", "pear"])
def test_another_pavilion_takes_the_bow_tie_of_the_same_outline_away(name):
    """docs/bow-tie.jpg; belly and ends are told apart by the contrast."""
    dark, clear = (load_stone(f"{name}-{word}") for word in ("bow-tie", "clear"))
    values = [stone.cut.values() for stone in (dark, clear)]
    assert {key for key in values[0] if values[0][key] != values[1][key]} == {
        "pavilion_depth", "lower_half", "mains",
    }  # fmt: skip
    before, after = bow_tie(dark), bow_tie(clear)
    assert before.belly.dark > 0.3 > 0.05 > after.belly.dark
    assert before.contrast > 0.3 > 0.01 > after.contrast
    assert after.belly.leaking < 0.1
    assert after.whole.bright > before.whole.bright + 0.1


def test_a_larger_head_darkens_more_until_it_hides_the_sky():
    stone = families()["marquise"]().stone()
    found = [bow_tie(stone, head_deg=head, max_reflections=6).belly for head in (0.0, 15.0, 90.0)]
    assert found[0].dark == 0.0 < found[1].dark < found[2].dark
    assert found[2].bright == pytest.approx(0.0, abs=1e-5)

"""What is not known of a stone, as draws, and what it does to measures."""

from __future__ import annotations

import json

import numpy as np
import pytest
from physics_tolerances import THREE_SIGMA
from typer.testing import CliRunner

import gemrender
from gemrender.cli.program import app
from gemrender.cuts import RoundBrilliant, load_stone
from gemrender.cuts.families import families
from gemrender.errors import InputError
from gemrender.stone import Stone
from gemrender.sweep import study_symmetry
from gemrender.sweep.tolerance import study_tolerance
from gemrender.sweep.unknown import STEPS, Cutting, Measuring, Rounding, draw, figures_of

REPORT = load_stone("gia-excellent")
OVAL = families()["oval"]().stone(name="an oval")
DRAWS = 20
#: Angles and heights after a tangent and back [deg, %], and sums taken in another order.
ROUNDING = 1e-9
#: Bounds of two exact scores [%].
BOUND = 0.1


@pytest.mark.parametrize("stone", [REPORT, OVAL], ids=["round", "oval"])
def test_draws_of_rounding_fill_half_a_step_either_way(stone):
    stated = figures_of(stone)
    drawn = [figures_of(draw(stone, Rounding.of(stone), 1, number)) for number in range(DRAWS)]
    for key, step in STEPS.items():
        if key not in stated:
            continue
        off = np.array([of[key] - stated[key] for of in drawn])
        assert np.abs(off).max() <= step / 2 + ROUNDING
        # Uniform: all in one half of the step by chance in one of 2^19 seeds.
        assert off.min() < 0 < off.max()


def test_what_is_known_exactly_stays():
    known = Rounding.of(REPORT, dict.fromkeys(STEPS.keys() & figures_of(REPORT).keys(), 0.0) | {"table": 1.0})
    stated, drawn = figures_of(REPORT), figures_of(draw(REPORT, known, 1, 3))
    assert drawn.pop("table") != stated.pop("table")
    # The crown's angle is what a report states, so the height moves with the table.
    assert drawn.pop("crown_height") != stated.pop("crown_height")
    assert drawn == pytest.approx(stated, abs=ROUNDING)


def test_a_step_of_a_height_takes_the_angles_place():
    assert "crown_angle" not in Rounding.of(REPORT, {"crown_height": 0.5}).steps


def test_values_are_those_of_the_drawn_stones():
    rounding = Rounding.of(REPORT)
    study = study_tolerance(REPORT, rounding, draws=3, seed=5, measures="inoue,iso")
    for number in range(3):
        stone = draw(REPORT, rounding, 5, number)
        alone = gemrender.score(stone, measures=["inoue", "iso"], bound=0.1)
        told = [value for of in alone.measures for value in of.values.values()]
        assert study.drawn[number] == pytest.approx(told, nan_ok=True, abs=0)
    (average, *_) = study.spreads()
    assert average.least <= average.low <= average.median <= average.high <= average.most
    assert average.stated == pytest.approx(gemrender.score(REPORT).average, abs=2 * BOUND)


def test_cutting_errors_are_those_of_the_study_of_symmetry():
    of_symmetry = study_symmetry(REPORT, tilt_deg=0.3, draws=3, seed=2, processes=1, bound=0.1)
    study = study_tolerance(REPORT, Cutting(0.3), draws=3, seed=2, processes=1)
    assert study.drawn[:, 0] == pytest.approx(of_symmetry.average, abs=ROUNDING)


def test_facets_that_are_cut_too_deep_make_a_smaller_stone():
    """Each facet is off by as much either way, and the corners that are cut off are more than those added."""
    volumes = [draw(OVAL, Cutting(0.0, depth=0.5), 1, number).solid.volume for number in range(DRAWS)]
    assert len(set(volumes)) == DRAWS
    assert np.mean(volumes) == pytest.approx(OVAL.solid.volume, rel=0.05)
    outline = [np.ptp(draw(OVAL, Cutting(0.0, depth=0.5), 1, n).solid.vertices[:, 1]) for n in range(3)]
    assert outline == pytest.approx([2.0] * 3, abs=1e-6)  # the girdle stays


def test_a_study_goes_on_from_its_journal(tmp_path):
    journal = tmp_path / "draws.jsonl"
    options = {"draws": 4, "seed": 1, "measures": "inoue,aset"}
    whole = study_tolerance(REPORT, Rounding.of(REPORT), **options)
    study_tolerance(REPORT, Rounding.of(REPORT), journal=journal, **{**options, "draws": 2})
    before = journal.read_text().splitlines()
    gone_on = study_tolerance(REPORT, Rounding.of(REPORT), journal=journal, **options)
    assert journal.read_text().splitlines()[: len(before)] == before
    assert np.array_equal(gone_on.drawn, whole.drawn, equal_nan=True)
    with pytest.raises(InputError, match="is the journal of another study"):
        study_tolerance(REPORT, Cutting(0.1), journal=journal, **options)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Rounding.of(REPORT, {"tabel": 1}), "tabel: unknown key; must be one of table, .*; did you"),
        (lambda: Rounding.of(REPORT, {"table": -1.0}), "table = -1.0: must be 0 or more"),
        (lambda: Rounding.of(REPORT.rotated(5)), "has no proportions that a report could round"),
        (lambda: Cutting(6.0), "deviation = 6.0: must be from 0 to 5"),
        (lambda: Measuring(0.0).check(OVAL), "only the 57 vertices of round brilliants"),
        (lambda: study_tolerance(REPORT, Cutting(0.1), draws=0), "draws = 0: must be from 1 to 100000"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_told(make, said):
    with pytest.raises(InputError, match=said):
        make()


def test_the_command_tells_spread_and_bound(tmp_path):
    options = ["--draws", "3", "--measures", "inoue,iso", "--step", "table=0.1"]
    result = CliRunner().invoke(app, ["tolerance", "gia-excellent", *options, "--json"])
    assert result.exit_code == 0
    (found,) = json.loads(result.stdout)
    assert found["unknown"]["steps"]["table"] == 0.1
    assert found["draws"] == 3
    assert set(found["measures"]) == {"inoue", "iso"}
    average = found["measures"]["inoue"]["average"]
    assert average["least"] < average["most"]
    assert average["bound"] <= 0.1
    result = CliRunner().invoke(app, ["tolerance", "gia-excellent", *options, "-o", str(tmp_path)])
    assert result.exit_code == 0
    assert "inoue average" in result.stdout
    assert {path.name for path in tmp_path.iterdir()} == {
        "gia-excellent-tolerance.png",
        "gia-excellent-tolerance.jsonl",
    }


#: Half of the steps that GIA rounds to (`gemrender.cuts.laboratory`), about a report's values.
ROUNDED = {
    "table": (57.0, 0.5), "crown_angle": (34.5, 0.25), "pavilion_angle": (40.8, 0.1),
    "lower_half": (80.0, 2.5),
}  # fmt: skip
#: Error of an end of the central 95 % of 64 draws, in standard deviations of a normal distribution:
#: sqrt(0.025 0.975 / 64) by the density there, 0.0584.
END_OF_64 = 0.334


def test_a_score_of_a_report_tells_what_its_rounding_does(tmp_path, rng):
    path = tmp_path / "r.toml"
    path.write_text(
        "[report]\ntable = 57\ncrown_angle = 34.5\npavilion_angle = 40.8\nlower_half = 80\n"
        'girdle = "medium"\n'
    )
    result = CliRunner().invoke(app, ["score", str(path), "--json"])
    (found,) = json.loads(result.stdout)
    rounding = found["rounding"]["average"]
    drawn = []
    for _ in range(64):
        at = {key: value + half * rng.uniform(-1, 1) for key, (value, half) in ROUNDED.items()}
        cut = RoundBrilliant.from_angles(star=50.0, girdle_thickness=3.0, **at)
        drawn.append(gemrender.score(Stone.from_proportions(cut), bound=0.5).average)
    low, high = np.percentile(drawn, [2.5, 97.5])
    apart = THREE_SIGMA * np.sqrt(2) * END_OF_64 * np.std(drawn)
    assert rounding["low"] == pytest.approx(low, abs=apart)
    assert rounding["high"] == pytest.approx(high, abs=apart)
    assert rounding["low"] < found["average"] < rounding["high"]

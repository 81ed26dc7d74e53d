"""Fronts of several goals: against all stones of a small grid, and what the command makes of them."""

from __future__ import annotations

import itertools
import json
import sys

import numpy as np
import pytest

from gemrender.cli.program import run
from gemrender.cuts.families import families
from gemrender.errors import BackendError, InputError
from gemrender.report.pareto import front_figure
from gemrender.sweep.improve.answers import SearchInterruptedError
from gemrender.sweep.improve.pareto import non_dominated, pareto_front, spread_out
from gemrender.sweep.improve.ranges import ranges_of
from gemrender.sweep.improve.search import prepare_search

STONE = families()["emerald"]().stone(name="emerald", material="sapphire")
GOALS = ["inoue", "volume"]
#: Twenty stones.
GRID = ranges_of(STONE, ["pavilion_angle=38:46:2", "table=56:68:4"])


def is_worse(one, other):
    return all(a <= b for a, b in zip(one, other, strict=True)) and tuple(one) != tuple(other)


def test_a_front_is_what_nothing_is_better_than():
    goals = np.random.default_rng(1).integers(0, 6, (60, 3)).astype(float)
    expected = [not any(is_worse(one, other) for other in goals) for one in goals]
    assert non_dominated(goals).tolist() == expected


def test_answers_are_the_ends_of_a_front_then_what_is_farthest():
    front = np.array([[0.0, 10.0], [1.0, 9.0], [5.0, 5.0], [9.5, 1.0], [10.0, 0.0]])
    assert spread_out(front, 3) == [4, 0, 2]
    assert spread_out(front, 1) == [4]
    assert sorted(spread_out(front, 9)) == [0, 1, 2, 3, 4]
    assert spread_out(np.zeros((3, 2)), 3) == [0]


def test_the_front_of_a_grid_is_found():
    """Its every stone measured: the search finds the whole front; a seed is one front, and one journal."""
    search = prepare_search(STONE, GOALS, GRID)
    search.measure(itertools.product(*(range(of.count) for of in GRID)))
    known = {at: goals for at, goals in search.known.items() if search.is_possible(at)}
    front = {at for at, own in known.items() if not any(is_worse(own, of) for of in known.values())}
    expected = {tuple(search.values(at).values()): known[at] for at in front}
    found = [pareto_front(STONE, GOALS, GRID, seed=seed, rounds=6, details=False) for seed in (1, 1, 2)]
    for of in found:
        goals = {tuple(stone.values.values()): stone.goals for stone in of.front}
        assert goals.keys() == expected.keys()
        assert all(goals[at] == pytest.approx(expected[at]) for at in expected)
        assert [stone.goals for stone in of.front] == sorted((s.goals for s in of.front), reverse=True)
        assert of.answers[0].goals == of.front[0].goals
        assert of.answers[-1].goals == of.front[-1].goals
    assert [a.values for a in found[0].answers] == [a.values for a in found[1].answers]
    assert found[0].tried == found[1].tried <= 20


def test_a_search_ends_where_all_stones_are_known():
    told = []
    found = pareto_front(
        STONE, GOALS, GRID, rounds=30, details=False, progress=lambda share, best: told.append(share)
    )
    assert found.tried == 20
    assert len(told) < 30


def test_a_front_goes_on_from_its_journal(tmp_path):
    journal = tmp_path / "front.jsonl"
    options = {"rounds": 2, "details": False, "journal": journal}
    once = pareto_front(STONE, GOALS, GRID, **options)
    lines = journal.read_text().splitlines()
    journal.write_text("\n".join(lines[: len(lines) // 2]) + "\n")
    again = pareto_front(STONE, GOALS, GRID, threads=1, **options)
    assert again.front == once.front
    assert sorted(journal.read_text().splitlines()) == sorted(lines)
    with pytest.raises(InputError, match="is the journal of another search"):
        pareto_front(STONE, ["inoue", "iso"], GRID, **options)


def test_a_continuous_range_has_a_front_between_steps():
    """Both goals are of one volume, so that the front is all volumes between the two that are wanted."""
    ranges = ranges_of(STONE, ["pavilion_angle=44:46:0"])
    low, high = (STONE.cut.changed(pavilion_angle=at).stone().solid.volume for at in (44.55, 45.45))
    found = pareto_front(
        STONE, [f"0 - abs(volume - {at!r})" for at in (low, high)], ranges, rounds=8, details=False
    )
    angles = [stone.values["pavilion_angle"] for stone in found.front]
    assert min(angles) == pytest.approx(44.55, abs=0.05)
    assert max(angles) == pytest.approx(45.45, abs=0.05)
    assert any(round(10 * angle) != pytest.approx(10 * angle, abs=1e-6) for angle in angles)


def test_the_figure_marks_the_start_and_numbers_the_answers():
    found = pareto_front(STONE, [*GOALS, "0 - inoue*volume"], GRID, rounds=2, answers=3, details=False)
    figure = front_figure(found)
    assert len(figure.axes) == 3  # a panel for each pair of goals
    for axes in figure.axes:
        texts = {text.get_text() for text in axes.texts}
        assert texts == {"start", *(str(number + 1) for number in range(len(found.answers)))}


def test_ctrl_c_keeps_the_front_so_far(monkeypatch):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("gemrender.sweep.improve.pareto.described", stop)
    with pytest.raises(SearchInterruptedError) as caught:
        pareto_front(STONE, GOALS, GRID, rounds=1)
    assert caught.value.found.front


def test_the_command_writes_a_front(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("gemrender.sweep.cliffs.STEPS", 3)
    monkeypatch.setattr("gemrender.report.page.MAP_PIXELS", 64)  # of a page that is not looked at
    grid = "pavilion_angle=42:46:2,table=60:68:4"
    goals = ["--goal", "inoue", "--goal", "volume", "--vary", grid, "--rounds", "1", "--answers", "1"]
    options = ["--reach", "0.02", "--json", "-o", str(tmp_path)]
    assert run(["improve", "emerald-market", *goals, *options]) == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert found["goals"] == ["inoue", "volume"]
    assert len(found["start"]["goals"]) == 2
    assert len(found["answers"]) == 1
    assert [len(of_goal) for of_goal in found["answers"][0]["slopes"]] == [2, 2]
    assert found["front"][0] == {key: found["answers"][0][key] for key in ("goals", "values")}
    assert {path.name for path in tmp_path.iterdir()} == {
        "emerald-market-front.png", "emerald-market-improve.html", "emerald-market-improve.jsonl",
        "emerald-market-improved-1.toml",
    }  # fmt: skip
    assert (
        '<section class="tables many" aria-label="Front">'
        in (tmp_path / "emerald-market-improve.html").read_text()
    )


def test_without_pymoo_the_cure_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymoo", None)
    with pytest.raises(BackendError, match=r"to cure it: pip install 'gemrender\[pareto\]'"):
        pareto_front(STONE, GOALS, GRID)


@pytest.mark.parametrize("number", [1, 5])
def test_how_many_goals_there_may_be_is_told(number):
    with pytest.raises(InputError, match=f"goal: must be from 2 to 4 goals, got {number}"):
        pareto_front(STONE, ["inoue"] * number, GRID)

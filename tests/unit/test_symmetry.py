"""The symmetry study."""

from __future__ import annotations

import json

import numpy as np
import pytest
from solids import bent_stone
from thorough import chosen

from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.report.symmetry import study_table, write_symmetry_figure
from gemrender.sweep import SymmetryStudy, study_symmetry
from gemrender.sweep.symmetry import draw_stone
from gemrender.sweep.workers import LostProcessError
from tests.observations import run_python

STONE = load_stone("inoue-2")
#: A small study that needs no Mitsuba.
SMALL = {"draws": 5, "seed": 3, "engine": "reference", "resolution": 24, "processes": 1}
#: One that takes no time.
TINY = {**SMALL, "resolution": 6}
#: The published Rear of sample 2 [%], a stone as measured.
PAPER_REAR = 18.2


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A study that takes no time, and its journal's text."""
    journal = tmp_path_factory.mktemp("kept") / "study.jsonl"
    return study_symmetry(STONE, **TINY, journal=journal), journal.read_text()


def test_a_draw_depends_on_seed_and_number_alone():
    one, other = (draw_stone(STONE, 0.5, 0.0, 7, 4) for _ in range(2))
    assert np.array_equal(one.facet_normals, other.facet_normals)
    assert not np.array_equal(one.facet_normals, draw_stone(STONE, 0.5, 0.0, 7, 5).facet_normals)
    assert not np.array_equal(one.facet_normals, draw_stone(STONE, 0.5, 0.0, 8, 4).facet_normals)


def test_jitter_moves_the_vertices():
    moved = draw_stone(STONE, 0.5, 1e-3, 1, 0)
    assert 0 < np.abs(moved.vertices - STONE.vertices).max() < 0.01


def test_no_tilt_scores_the_stone_itself():
    study = study_symmetry(STONE, tilt_deg=0.0, **SMALL)
    assert study.average == pytest.approx([study.perfect[0]] * 5, abs=1e-9)
    assert study.rear == pytest.approx([study.perfect[1]] * 5, abs=1e-9)


def test_a_stopped_study_goes_on_to_the_same_end(tmp_path):
    whole = study_symmetry(STONE, **SMALL)
    journal = tmp_path / "study.jsonl"
    study_symmetry(STONE, **{**SMALL, "draws": 3}, journal=journal)
    text = journal.read_text()
    journal.write_text(text + "[3, 47.1")  # stopped while writing
    known = text.count("\n")
    assert study_symmetry(STONE, **SMALL, journal=journal) == whole
    assert journal.read_text().startswith(text)
    assert len(journal.read_text().splitlines()) == known + 2, "only what was missing is drawn"


@pytest.mark.parametrize(
    "line",
    [
        [2, 47.0], [2, "47", 20], [2, 100.1, 20], [2, 47, -1], {}, [2.5, 1, 1], [True, 1, 1], [-2, 1, 1], 2,
        [2, float("nan"), 20.0],
    ],
)  # fmt: skip
def test_a_line_that_is_no_draws_is_left_out(line, kept, tmp_path, caplog):
    whole, text = kept
    journal = tmp_path / "study.jsonl"
    journal.write_text(f"{text}{json.dumps(line)}\n")
    assert study_symmetry(STONE, **TINY, journal=journal) == whole
    assert "a line that is no entry is left out" in caplog.text
    assert journal.read_text() == text


def test_what_stood_in_a_line_that_is_no_draws_is_drawn_again(kept, tmp_path, caplog):
    whole, text = kept
    journal = tmp_path / "study.jsonl"
    head, *lines = text.splitlines()
    lines = ["[2, NaN, 20.0]" if json.loads(old)[0] == 2 else old for old in lines]
    journal.write_text("\n".join([head, *lines, ""]))
    assert study_symmetry(STONE, **TINY, journal=journal) == whole
    assert "a line that is no entry is left out" in caplog.text


def test_whole_numbers_are_scores_too(kept, tmp_path, caplog):
    _, text = kept
    journal = tmp_path / "study.jsonl"
    journal.write_text(f"{text}[2, 100, 0]\n")  # of two entries of a draw the later one counts
    found = study_symmetry(STONE, **TINY, journal=journal)
    assert (found.average[2], found.rear[2]) == (100.0, 0.0)
    assert not caplog.text


#: A study of which all processes, or those that share its work, are killed after some draws.
SCRIPT = """
import multiprocessing, os, pathlib, signal, sys
from gemrender.errors import GemrenderError
from gemrender.cuts import load_stone
from gemrender.sweep import study_symmetry

what, journal, done = sys.argv[1], pathlib.Path(sys.argv[2]), 0

def progress(share):
    global done
    done += 1
    if what == "all" and done == 5:
        os.kill(os.getpid(), signal.SIGKILL)
    if what == "workers" and done == 1:  # of which one has just been given more to do
        for process in multiprocessing.active_children():
            os.kill(process.pid, signal.SIGKILL)

if __name__ == "__main__":
    try:
        study_symmetry(load_stone("inoue-2"), draws=9, seed=3, processes=2, journal=journal,
                       engine="reference", resolution=6, progress=progress)
    except GemrenderError as error:
        sys.exit(f"gemrender: {error}")
"""


@pytest.mark.parametrize(("what", "status"), chosen([("all", -9), ("workers", 0)], [("all", -9)]))
def test_a_study_survives_what_is_killed(what, status, tmp_path):
    journal = tmp_path / "study.jsonl"
    done = run_python("-c", SCRIPT, what, str(journal))
    assert (done.returncode, done.stdout, "Traceback" in done.stderr) == (status, "", False)
    assert ("its work is done again" in done.stderr) == (what == "workers")
    study = {**TINY, "draws": 9}
    assert len(journal.read_text().splitlines()) >= 6
    assert study_symmetry(STONE, **study, journal=journal) == study_symmetry(STONE, **study)


def test_where_processes_are_lost_it_says_what_is_kept(tmp_path, monkeypatch):
    def lost(*_):
        yield [(-1, (50.0, 20.0))]
        raise LostProcessError("a process was ended")

    monkeypatch.setattr("gemrender.sweep.spreading.in_processes", lost)
    study, journal = {**TINY, "processes": 2}, tmp_path / "study.jsonl"
    with pytest.raises(LostProcessError, match=r"^a process was ended$"):
        study_symmetry(STONE, **study)
    with pytest.raises(
        LostProcessError, match=r"^a process was ended; what is done is kept in .*study\.jsonl$"
    ):
        study_symmetry(STONE, **study, journal=journal)
    assert journal.read_text().endswith("\n[-1, 50.0, 20.0]\n")


def test_the_journal_of_another_study_is_refused_and_left(tmp_path):
    journal = tmp_path / "study.jsonl"
    study_symmetry(STONE, **SMALL, journal=journal)
    before = journal.read_text()
    with pytest.raises(InputError, match="another study"):
        study_symmetry(STONE, **{**SMALL, "seed": 4}, journal=journal)
    with pytest.raises(InputError, match="another study"):
        study_symmetry(load_stone("inoue-3"), **SMALL, journal=journal)
    assert journal.read_text() == before


def test_a_file_that_is_no_journal_is_refused_and_left(tmp_path):
    journal = tmp_path / "study.jsonl"
    journal.write_text("my notes\n")
    with pytest.raises(InputError, match="not the journal"):
        study_symmetry(STONE, **SMALL, journal=journal)
    assert journal.read_text() == "my notes\n"


def test_processes_find_the_same(kept):
    whole, _ = kept
    assert study_symmetry(STONE, **{**TINY, "processes": 2}) == whole
    assert len(set(whole.average)) == 5  # each draw is told from the others


@pytest.mark.parametrize(
    ("key", "value"), [("tilt_deg", -1), ("tilt_deg", 6), ("jitter", 0.1), ("draws", 0), ("seed", -1)]
)
def test_values_out_of_range_are_refused(key, value):
    with pytest.raises(InputError, match="must be from"):
        study_symmetry(STONE, **{**SMALL, key: value})


def test_a_hollow_stone_is_refused():
    with pytest.raises(InputError, match="convex stones only"):
        study_symmetry(bent_stone(0.003), **SMALL)


def test_facets_of_a_measured_stone_can_be_tilted():
    study = study_symmetry(bent_stone(-0.003), **SMALL)
    assert len(set(study.average)) == 5


def test_summary_is_that_of_the_draws():
    study = SymmetryStudy(
        name="x", tilt_deg=0.5, jitter=0, seed=1, resolution=8, average=(1.0, 2.0, 3.0), rear=(4.0,) * 3,
        perfect=(2.0, 4.0),
    )  # fmt: skip
    assert study.summary()["average"] == pytest.approx(
        {"mean": 2.0, "deviation": 1.0, "low": 1.05, "median": 2.0, "high": 2.95}
    )
    assert study.summary()["rear"]["deviation"] == 0.0


def test_poor_symmetry_explains_the_papers_rear_of_sample_2():
    study = study_symmetry(STONE, draws=40, bound=0.5, processes=1)
    rear = study.summary()["rear"]
    assert rear["low"] < PAPER_REAR < rear["high"]
    assert study.perfect[1] < rear["low"], "a perfect stone does not"


def test_figure_and_table(tmp_path, capsys):
    from rich.console import Console

    from gemrender.report.formats import print_tables

    study = study_symmetry(STONE, **SMALL)
    path = write_symmetry_figure(study, tmp_path / "study.png")
    assert path.stat().st_size > 10_000
    print_tables([study_table([study])], Console(width=120))
    out = capsys.readouterr().out
    assert f"{study.perfect[1]:.2f}" in out
    assert "Inoue sample 2" in out


def test_command_prints_json(gemrender):
    status, out, err = gemrender(
        "symmetry", "inoue-2", "--draws", "2", "--engine", "reference", "--resolution", "16", "--json"
    )
    assert status == 0, err
    (study,) = json.loads(out)
    assert study["draws"] == 2
    assert set(study["summary"]) == {"average", "rear"}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--deviation", "x"], "--deviation = 'x': must be a finite number of degrees"),
        (["--deviation", "9"], "--deviation = 9.0: must be from 0 to 5"),
        (["--draws", "0"], "--draws = 0: must be from 1 to 100000"),
        (["--jitter", "1"], "--jitter = 1.0: must be from 0 to 0.05"),
    ],
)
def test_bad_input_is_one_line(words, said, gemrender):
    assert gemrender("symmetry", "inoue-2", *words) == (2, "", f"gemrender: {said}\n")

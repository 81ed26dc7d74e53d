"""Stones side by side."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest
from thorough import chosen

from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.observation import RayStatus
from gemrender.report import comparison
from gemrender.report.comparison import (
    MOST_MAPS,
    comparison_figure,
    difference_figure,
    format_scores,
    panel,
    write_comparison,
)
from gemrender.report.figures import map_picture
from gemrender.report.formats import FORMATS
from gemrender.scoring import score
from gemrender.stone import Stone
from tests.observations import ROOT, STONE, observation, run_python

FAST = ("--engine", "reference", "--resolution", "16")


def named(name: str) -> Stone:
    return Stone.from_proportions(load_stone("inoue-3").proportions, name=name)


def small(name: str = "stone", intensity: float = 50.0):
    return observation(RayStatus.EXITED, resolution=16, stone=named(name), primary_intensity=intensity)


def test_a_panels_pixels_are_means_of_the_pictures(rng):
    """Of 2 x 2 each; those of a map of 33 pixels a side, enlarged 25 times, are not all of one colour."""
    shown = observation(RayStatus.EXITED, resolution=33, primary_intensity=rng.uniform(0, 99, (33, 33)))
    whole = map_picture(shown)[:824, :824]
    means = whole.reshape(412, 2, 412, 2, 3).mean(axis=(1, 3))
    assert (means % 1 > 0).any()
    assert (panel(shown)[1] == np.floor(means)).all()


def test_csv_has_a_row_a_stone():
    scores = [panel(small("a, b", 50))[0], panel(small("c", 80))[0]]
    rows = list(csv.DictReader(io.StringIO(format_scores(scores, "csv"))))
    assert [row["name"] for row in rows] == ["a, b", "c"]
    assert [float(row["average"]) for row in rows] == [50, 80]
    assert [float(row["band_45"]) for row in rows] == [100, 0]


def test_markdown_escapes_what_would_end_a_cell():
    lines = format_scores([panel(small("a|b"))[0]], "markdown").splitlines()
    assert lines[2].startswith(r"| a\|b | 50.00 | 0.00 |")


def test_json_is_that_of_score():
    score = panel(small())[0]
    assert json.loads(format_scores([score], "json")) == json.loads(json.dumps([score.to_dict()]))


def test_unknown_format_is_refused():
    with pytest.raises(InputError, match="must be one of csv, json, markdown"):
        format_scores([panel(small())[0]], "xml")


@pytest.mark.parametrize("n", chosen([1, 2, 3, 5, 20], [1, 3, 5]))
def test_figure_shows_every_map(n):
    figure = comparison_figure([panel(small(f"stone {i}")) for i in range(n)])
    assert sum(bool(axes.images) for axes in figure.axes) == n


def test_of_many_stones_it_shows_the_bars():
    figure = comparison_figure([panel(small())] * (MOST_MAPS + 1))
    assert not any(axes.images for axes in figure.axes)
    assert len(figure.axes[-1].get_yticks()) == MOST_MAPS + 1


def test_of_very_many_stones_it_can_still_be_drawn(monkeypatch):
    assert comparison.MOST_PIXELS < 2**16
    monkeypatch.setattr(comparison, "MOST_PIXELS", 2_000)
    figure = comparison_figure([panel(small())] * 70)
    assert 1_900 < figure.bbox.height <= 2_000 + 1


def test_bars_fill_the_whole():
    figure = comparison_figure([panel(small())])
    bars = figure.axes[-1].patches
    assert sum(bar.get_width() for bar in bars) == pytest.approx(100.0)


@pytest.mark.parametrize("name", [r"$\frac$ [/]", "\u30c0\u30a4\u30e4\u30e2\u30f3\u30c9"])
def test_any_name_is_drawn_without_a_warning(name, tmp_path):
    observed = [small(name), small("b")]
    assert len(write_comparison([panel(o) for o in observed], observed, tmp_path)) == 4


def test_difference_is_first_minus_second():
    figure = difference_figure(small(intensity=80), small(intensity=30))
    assert np.ma.allequal(figure.axes[0].images[0].get_array(), 50.0)


def test_difference_of_different_views_is_refused():
    one = small()
    other = replace(one, view=replace(one.view, tilt_deg=10.0))
    with pytest.raises(ValueError, match="different views"):
        difference_figure(one, other)


def test_maps_of_different_widths_lie_on_each_other_by_their_middles():
    """The wider one has 8 pixels from -2 to 2: of its 64 the middle 16 lie within the other's width."""
    narrow = small(intensity=80)
    wide = observation(RayStatus.EXITED, resolution=8, primary_intensity=30)
    wide = replace(wide, view=replace(wide.view, half_width=2.0))
    for pair, expected in (((narrow, wide), 50.0), ((wide, narrow), -50.0)):
        image = difference_figure(*pair).axes[0].images[0].get_array()
        assert image.shape == (8, 8)
        assert np.ma.allequal(image[2:6, 2:6], expected)
        assert image.count() == 16


def test_a_coarser_map_is_sampled_at_the_pixels_of_the_finer():
    left = np.repeat([[10.0, 60.0]], 2, axis=0)
    coarse = observation(RayStatus.EXITED, resolution=2, primary_intensity=left)
    image = difference_figure(small(intensity=0), coarse).axes[0].images[0].get_array()
    assert np.ma.allequal(image, -np.repeat(left[:1], 8, axis=1).repeat(16, axis=0))


def test_files_of_a_pair(tmp_path):
    pair = [small("a"), small("b")]
    written = write_comparison([panel(o) for o in pair], pair, tmp_path)
    assert sorted(p.name for p in written) == [
        "comparison.csv", "comparison.json", "comparison.png", "difference.png",
    ]  # fmt: skip
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(p.name for p in written)


@pytest.mark.parametrize("form", FORMATS)
def test_command_prints_each_format(form, gemrender):
    status, out, err = gemrender("compare", "inoue-1", "inoue-3", *FAST, "--format", form)
    assert (status, err) == (0, "")
    assert "Inoue sample 3" in out


def test_unwritable_folder_is_one_line(tmp_path, gemrender):
    (tmp_path / "file").write_text("")
    status, out, err = gemrender("compare", "inoue-1", *FAST, "--out", str(tmp_path / "file"))
    assert (status, out, len(err.splitlines())) == (2, "", 1)


def test_script_sets_paper_beside_program():
    done = run_python(str(ROOT / "scripts" / "score_comparisons.py"), "--resolution", "64")
    assert done.returncode == 0, done.stderr
    assert "45.10" in done.stdout
    assert "over 60" in done.stdout


def test_measures_are_in_every_form_as_score_has_them(gemrender, tmp_path):
    """In what is printed and in the files, whether there are maps or not."""
    asked = ["inoue-3", "inoue-1", *FAST, "--measures", "window,iso", "--head", "15"]
    scored = json.loads(gemrender("score", *asked, "--json")[1])
    assert list(scored[0]["measures"]) == ["window", "iso"]
    for more in ([], ["-o", str(tmp_path)]):
        status, out, _ = gemrender("compare", *asked, "--json", *more)
        assert status == 0
        assert [s["measures"] for s in json.loads(out)] == [s["measures"] for s in scored]
    written = json.loads((tmp_path / "comparison.json").read_text(encoding="utf-8"))
    assert [s["measures"] for s in written] == [s["measures"] for s in scored]
    rows = list(csv.DictReader(io.StringIO((tmp_path / "comparison.csv").read_text(encoding="utf-8"))))
    assert [float(row["iso"]) for row in rows] == [s["measures"]["iso"]["value"] for s in scored]
    assert "internal" in gemrender("compare", *asked)[1]


def test_the_figure_shows_values_of_measures_beside_the_bars():
    """The one value of each, or all that it has; what is the paper's is there already."""
    shown = small()
    wanted = score(STONE, engine="reference", resolution=16, measures="inoue,window,extinction,iso")
    texts = [text.get_text() for text in comparison_figure([panel(shown, wanted)] * 2).axes[-1].texts]
    assert texts[-5:] == [
        "Average",
        "window",
        "extinction\nhead",
        "extinction\nlate leak",
        "extinction\ntied",
    ]
    by_name = {of.name: of.values for of in wanted.measures}
    assert texts[0] == f"{wanted.average:.2f}"
    assert texts[1:3] == [f"{by_name['window']['value']:.2f}", f"{by_name['extinction']['head']:.2f}"]


def test_an_unknown_measure_is_refused(gemrender):
    status, out, err = gemrender("compare", "inoue-3", *FAST, "--measures", "iso,iso2")
    assert (status, out) == (2, "")
    assert err.startswith("gemrender: --measures = 'iso2': must be one of inoue, iso, ")
    assert err.count("\n") == 1

"""Bounds of all measures: a small part of what `scripts/check_bounds.py` does, and the page on measures."""

from __future__ import annotations

import re
import runpy
import sys

import numpy as np
import pytest
from observations import ROOT
from thorough import chosen

import gemrender
from gemrender.beam import beam_stone, measure
from gemrender.beam.facets import trace_facets
from gemrender.beam.near_girdle import RIM, NearGirdle
from gemrender.measures import measures
from gemrender.measures.inoue import MET
from gemrender.observation import Model, View

TILTED = View(resolution=1, tilt_deg=20.0, tilt_azimuth_deg=33.0)
OF_ONE_VIEW = [of for of in measures() if of.views == "one"]
#: Shares that make a whole make 100 within this [%].
WHOLE = 1e-6
#: Means of 128 x 128 pixels against the exact value [%].
PIXELS = 0.5


@pytest.mark.parametrize("stones", chosen([2, 12], [2]))
def test_bounds_hold_of_stones_of_all_kinds(stones, monkeypatch, capsys):
    """At a loose bound rays are few: the scatter of sets alone does not tell what they have missed."""
    options = f"--stones {stones} --seeds 4 --turns 1 --bound 1 --truth 0.05 --longest 2"
    script = str(ROOT / "scripts" / "check_bounds.py")
    monkeypatch.setattr(sys, "argv", [script, *options.split()])
    status = runpy.run_path(script)["main"]()
    out = capsys.readouterr().out
    assert status == 0, out
    assert out.count(f"0 of {8 * stones}") == len([of for of in OF_ONE_VIEW if of.keys])


@pytest.mark.parametrize("tilt", [0.0, 20.0])
def test_weighted_shares_make_a_whole_however_few_rays_there_are(tilt):
    """Facets of entry differ: what they let in is in the shares that rays stand for."""
    view = View(resolution=1, tilt_deg=tilt)
    measured = measure(gemrender.load_stone("inoue-3"), view=view, measures=OF_ONE_VIEW, bound=5.0)
    [aset] = [of.values for of in measured.measures if of.name == "aset"]
    parts = [value for key, value in aset.items() if key.startswith("weighted_") and "tied" not in key]
    assert sum(parts) + aset["surface"] + aset["rest"] == pytest.approx(100.0, abs=WHOLE)


@pytest.fixture
def tilted_rim():
    stone = beam_stone(gemrender.load_stone("inoue-3"))
    facets = trace_facets(stone, view=TILTED, model=Model.of(stone.stone))
    near = NearGirdle(stone, facets, seed=3)
    near.go_on(near.numbers(64))
    return near


def test_all_sets_together_cover_just_the_rim(tilted_rim):
    """Each set meets more or less of it; alike in all sets, each as if it had met just its area."""
    found = tilted_rim.found()
    others = np.delete(tilted_rim.sums, RIM, axis=1).sum(axis=1)
    rim = tilted_rim.sums[:, RIM]
    pooled = tilted_rim.areas[RIM] * rim.sum(axis=0) / rim[:, MET].sum()
    np.testing.assert_allclose((found - others).mean(axis=0), pooled, atol=1e-15)
    np.testing.assert_allclose((found - others)[:, MET], tilted_rim.areas[RIM], atol=1e-15)
    assert np.ptp(rim[:, MET]) > 0.1 * tilted_rim.areas[RIM]


def test_what_all_rays_may_have_missed_falls_with_their_number(tilted_rim):
    principal, of_all = tilted_rim.unseen
    assert of_all == principal > 0.0  # only principal light was followed
    numbers = [10 * number for number in tilted_rim.numbers(64)]
    tilted_rim.go_on(tuple(numbers))
    assert 0.0 < tilted_rim.unseen[0] < 0.5 * principal


def test_what_polygons_tell_has_no_bound():
    stone = gemrender.load_stone(ROOT / "tests" / "cases" / "stones" / "emerald.asc")
    measured = measure(stone, view=TILTED, measures=OF_ONE_VIEW, bound=1.0)
    bounds = {of.name: of.bound for of in measured.measures}
    assert [bounds[name] < 1e-9 for name in ("inoue", "window", "extinction", "dispersion")] == [True] * 4
    assert 0.0 < bounds["iso"] <= 1.0


def test_the_example_of_the_page_runs(capsys):
    page = (ROOT / "docs" / "own-measure.md").read_text(encoding="utf-8")
    [code] = re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)
    found: dict = {}
    exec(code, found)
    overhead, picture = found["overhead"], found["picture"]
    assert 0.0 < overhead.bound <= 0.1
    assert capsys.readouterr().out.startswith(f"{overhead.values['value']:.1f} within")
    assert picture.shape == (128, 128, 1)
    stone = found["stone"]
    maps = gemrender.measure_maps(stone, measures=found["Overhead"](), resolution=128)
    assert maps.values["overhead"]["value"] == pytest.approx(overhead.values["value"], abs=PIXELS)


def test_the_page_tells_of_every_measure():
    page = (ROOT / "docs" / "measures.md").read_text(encoding="utf-8")
    short = {f"gemray-{sky}": f"-{sky}" for sky in ("cos", "sc2")}
    for of in measures():
        assert f"`{short.get(of.name, of.name)}`" in page

"""Bundled set-ups as photographs: paper that is white, blacks that are black."""

from __future__ import annotations

import numpy as np
import pytest
from thorough import chosen

from gemrender.cuts import load_stone
from gemrender.render.finish import developed, exposure_of
from gemrender.render.photoreal import make_gems, render
from gemrender.scene.setup import load_setup

#: Level of white paper at least, and how far apart its channels may be; level of what is black at most.
WHITE, NEUTRAL, BLACK = 245, 2, 60


def photographed(name):
    """Return a small picture as the screen shows it, and where stone and ground are."""
    setup = load_setup(name)
    picture = render(make_gems([load_stone("inoue-3")]), setup, width=40, height=40, spp=36, seed=1)
    shown = developed(picture, setup, exposure=exposure_of(picture, setup), curve=setup.curve)
    covered = picture.coverage > 0.99
    on_stone = covered & (picture.albedo.min(axis=2) > 0.99)
    return shown.astype(int), on_stone, covered & (picture.albedo.max(axis=2) < 0.99)


@pytest.mark.parametrize("name", chosen(["product", "white"], ["white"]))
def test_paper_is_white_and_neutral(name):
    shown, _, on_ground = photographed(name)
    paper = np.median(shown[on_ground], axis=0)
    assert paper.min() >= WHITE
    assert np.ptp(paper) <= NEUTRAL


@pytest.mark.parametrize("name", chosen(["studio", "fire"], ["studio"]))
def test_a_stone_has_blacks_and_whites(name):
    shown, on_stone, _ = photographed(name)
    dark, bright = np.percentile(shown[on_stone].mean(axis=1), [2, 98])  # those of scripts/measure_setups.py
    assert dark < BLACK
    assert bright > 200

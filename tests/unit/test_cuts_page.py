"""The page of cuts is what its script makes of the families, and has a figure of each."""

from __future__ import annotations

import re
import runpy
from dataclasses import fields

import numpy as np
import pytest
from observations import ROOT

from gemrender.cuts.families import families

SCRIPT = runpy.run_path(str(ROOT / "scripts" / "draw_cuts.py"))
PAGE = (ROOT / "docs" / "cuts.md").read_text(encoding="utf-8")


def test_the_page_is_that_of_the_families():
    assert SCRIPT["page"]() == PAGE, "python scripts/draw_cuts.py"


def test_every_family_has_a_section_with_a_figure_and_all_its_parameters():
    sections = {part.partition("\n")[0].casefold(): part for part in PAGE.split("\n## ")[1:]}
    for name, kind in families().items():
        section = sections[name]
        [picture] = re.findall(r"!\[.*?\]\((.*?)\)", section)
        assert (ROOT / "docs" / picture).stat().st_size > 1000
        for part in fields(kind):
            assert f"\n| `{part.name}` | " in section


def test_there_are_no_other_figures():
    pictures = {path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs" / "cuts").iterdir()}
    assert pictures == set(re.findall(r"!\[.*?\]\((.*?)\)", PAGE))


@pytest.mark.parametrize("name", ["single cut", "baguette"])
def test_a_figure_has_three_views_to_one_scale(name):
    figure = SCRIPT["figure"](families()[name]().stone(name=name))
    assert len(figure.axes) == 3
    scales = []
    for axes in figure.axes:
        box = axes.get_position().bounds
        scales += [
            box[2] * figure.get_figwidth() / np.ptp(axes.get_xlim()),
            box[3] * figure.get_figheight() / np.ptp(axes.get_ylim()),
        ]
    assert scales == pytest.approx([scales[0]] * 6)

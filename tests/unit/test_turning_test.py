"""The turning test's script: spreads, and results of other tools from a file."""

from __future__ import annotations

import re
import runpy

import numpy as np
import pytest
from observations import ROOT

from gemrender.cuts import load_stone
from gemrender.errors import InputError

SCRIPT = runpy.run_path(str(ROOT / "scripts" / "turning_test.py"))
PAGE = (ROOT / "docs" / "turning-test.md").read_text(encoding="utf-8")
[FORMAT] = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)


def test_turning_changes_nothing_beyond_the_bound():
    found = SCRIPT["turn"](load_stone("tolkowsky"), "exact", np.array([0.0, 11.0, 45.0]), 0.5)
    assert {of.number for of in found} == set(SCRIPT["NUMBERS"])
    for of in found:
        assert of.spread <= 2 * of.bound + SCRIPT["ROUNDING"]
    assert max(of.spread for of in found) > 0.0


def test_results_of_other_tools_are_read_as_the_page_says(tmp_path):
    file = tmp_path / "others.toml"
    file.write_text(FORMAT.replace("[0, 0, 0]", "[70.5, 71, 69]"), encoding="utf-8")
    [of] = SCRIPT["others"](file)
    assert (of.tool, of.stone, of.number, of.bound) == ("NAME VERSION", "Tolkowsky", "iso", None)
    assert of.spread == 2.0


@pytest.mark.parametrize(
    ("good", "bad", "key"),
    [
        ('version = "VERSION"', "", "version"),
        ("[0, 5, 10]", "[0, 5]", "angles"),
        ("[0, 0, 0]", "[0]", "values"),
        ("[0, 0, 0]", '["a", "b", "c"]', "values"),
        ('stone = "Tolkowsky"', "", "stone"),
    ],
)
def test_results_without_a_source_or_of_another_form_are_refused(tmp_path, good, bad, key):
    file = tmp_path / "others.toml"
    file.write_text(FORMAT.replace(good, bad), encoding="utf-8")
    with pytest.raises(InputError, match=key):
        SCRIPT["others"](file)

"""The scripts of the report's page: all are in it, each after those that it takes names from."""

from __future__ import annotations

import re
from importlib import resources

from gemrender.report.page import SCRIPTS

ASSETS = resources.files("gemrender.report").joinpath("assets")


def test_every_script_is_in_the_page_once():
    files = sorted(file.name for file in ASSETS.iterdir() if file.name.endswith(".js"))
    assert sorted([f"{name}.js" for name in SCRIPTS] + ["three.entry.js", "three.min.js"]) == files


def test_scripts_take_names_from_themselves_or_from_earlier_ones():
    made = set()
    for name in SCRIPTS:
        text = ASSETS.joinpath(f"{name}.js").read_text(encoding="utf-8")
        made |= set(re.findall(r"^const (Gem\w+) =", text, re.MULTILINE))
        unknown = set(re.findall(r"\bGem[A-Z]\w+", text)) - made
        assert not unknown, (name, unknown)
    assert len(made) > len(SCRIPTS) / 2  # names were found at all

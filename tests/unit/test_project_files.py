"""Files about the project agree with each other."""

from __future__ import annotations

import re
import tomllib

from observations import ROOT

import gemrender

PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_version_stands_in_one_place_and_is_the_changelogs_and_the_citations():
    assert "version" not in PYPROJECT["project"]
    assert PYPROJECT["tool"]["hatch"]["version"]["path"] == "gemrender/__init__.py"
    version, date = re.findall(r"^## ([\d.]+) \((\d{4}-\d\d-\d\d)\)$", text("CHANGELOG.md"), re.MULTILINE)[0]
    assert version == gemrender.__version__
    cited = dict(re.findall(r"^(version|date-released): (.+)$", text("CITATION.cff"), re.MULTILINE))
    assert cited == {"version": version, "date-released": date}


def test_hooks_are_of_the_linters_versions():
    pinned = dict(of.split("==") for of in PYPROJECT["project"]["optional-dependencies"]["lint"])
    assert set(pinned) == {"ruff", "mypy"}
    assert f"rev: v{pinned['ruff']}\n" in text(".pre-commit-config.yaml")


def test_types_are_told_to_checkers():
    assert (ROOT / "gemrender" / "py.typed").is_file()

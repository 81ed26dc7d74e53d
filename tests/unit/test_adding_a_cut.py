"""The family that docs/adding-a-cut.md adds: its file and its stone file are all there is to do."""

from __future__ import annotations

import re
import sys

import numpy as np
import pytest
from displays_help import texts
from observations import ROOT

from gemrender.cuts import families as folder
from gemrender.cuts import load_stone
from gemrender.cuts.families import families
from gemrender.report.displays import draw
from gemrender.stone import tessellate
from tests.solids import assert_closed

PAGE = (ROOT / "docs" / "adding-a-cut.md").read_text(encoding="utf-8")
[MODULE] = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
[STONE] = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)
#: Lengths after a few operations on numbers of order 1.
ROUNDING = 1e-12


@pytest.fixture
def pyramid(tmp_path, monkeypatch):
    """Add the page's file to the folder of families; return its class."""
    name = re.findall(r"^# gemrender/cuts/families/(\w+)\.py$", MODULE, flags=re.MULTILINE)[0]
    (tmp_path / f"{name}.py").write_text(MODULE, encoding="utf-8")
    monkeypatch.setattr(folder, "__path__", [*folder.__path__, str(tmp_path)])
    families.cache_clear()
    yield families()[name]
    families.cache_clear()
    del sys.modules[f"{folder.__name__}.{name}"]
    delattr(folder, name)


def test_the_stone_file_makes_the_stone(pyramid, tmp_path):
    path = tmp_path / "stone.toml"
    path.write_text(STONE, encoding="utf-8")
    stone = load_stone(path)
    assert (stone.name, stone.material) == ("A pyramid", "sapphire")
    assert_closed(tessellate(stone))
    assert stone.cut.table == 55.0
    assert stone.cut.alternatives()["pavilion_angle"] == pytest.approx(42.5, abs=ROUNDING)
    assert stone.cut.girdle_thickness == 3.0  # medium
    assert any("square" in words for words in stone.assumed)


def test_its_volume_in_closed_form(pyramid):
    cut = pyramid(table=50, crown_height=20, girdle_thickness=5, pavilion_depth=45)
    crown = 0.4 / 3 * (4 + 1 + 2)  # a frustum of squares of side 2 and 1
    assert cut.stone().solid.volume == pytest.approx(crown + 4 * 0.1 + 4 * 0.9 / 3, abs=ROUNDING)
    assert cut.stone().symmetry.fold == 4


def test_its_derivatives_are_exact(pyramid):
    """The slope of a bezel: its height over its run, by the crown's height."""
    cut = pyramid(crown_height=20)
    bezel = cut.construction().names.index("bezel_1")
    x, z = cut.planes(crown_height=20 + 1e-30j)[bezel, [0, 2]]
    slope = -x / z  # seen from the left: the tangent of the angle
    assert slope.imag / 1e-30 == pytest.approx(2.0 / (100.0 - cut.table), abs=ROUNDING)
    assert np.real(slope) == pytest.approx(20 * 2.0 / (100.0 - cut.table), abs=ROUNDING)


def test_its_drawing_says_what_it_adds(pyramid):
    said = texts(draw(pyramid(table=55).stone(name="x"), "outline"))
    assert {
        "sharp corner",
        "table width 55.0 %",
        "crown height 14.0 %",
        "Pyramid: outline and dimensions",
    } <= set(said)

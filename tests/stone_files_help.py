"""Stone files as text, and the one line that a bad one gets."""

from __future__ import annotations

from pathlib import Path

import pytest

from gemrender.cuts import load_stone
from gemrender.cuts.files import save_vertices
from gemrender.errors import InputError
from gemrender.stone import Stone

PROPORTIONS = """\
name = "A stone"

[proportions]
table = 54.00
star = 57.0
lower_girdle_contact = 20.0
crown_height = 15.70
pavilion_depth = 43.08
girdle_thickness = 2.50
"""
ANGLES = """\
[angles]
table = 57
crown_angle = 34.0
pavilion_angle = 40.7
star = 50
lower_half = 80
girdle_thickness = 2.5
"""


def write(text: str | bytes, name: str = "stone.toml") -> str:
    Path(name).write_bytes(text.encode() if isinstance(text, str) else text)
    return name


def refusal(stone: str) -> str:
    """The one line that a stone is refused with."""
    with pytest.raises(InputError) as caught:
        load_stone(stone)
    line = str(caught.value)
    assert "\n" not in line
    return line


def csv_lines(stone: Stone | None = None) -> list[str]:
    """The header and the 57 rows of a stone's CSV."""
    save_vertices(stone or load_stone("inoue-3"), "saved.csv")
    return Path("saved.csv").read_text(encoding="utf-8").splitlines()

"""Vertices of a brilliant that are no stone: the one line that says why."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from stone_files_help import csv_lines, refusal, write

from gemrender.cuts import load_stone, stone_from_vertices
from gemrender.errors import InputError

#: Each test runs in an empty folder of its own.
pytestmark = pytest.mark.usefixtures("folder")

_COLUMNS = "must have the 4 columns label, x, y, z, with commas between them and points in decimals"
_COUNT = (
    "must be 57: 8 table corners, 8 star tips, 16 upper and 16 lower girdle vertices, 8 contacts, the culet"
)

DAMAGED = {
    "56 rows": (lambda lines: lines[:-1], f"56 rows: {_COUNT}"),
    "58 rows": (lambda lines: [*lines, lines[-1]], f"58 rows: {_COUNT}"),
    "only a header": (lambda lines: lines[:1], f"0 rows: {_COUNT}"),
    "wrong order": (
        lambda lines: [*lines[:3], lines[4], lines[3], *lines[5:]],
        "row 3 (line 4): expected table_2, got table_3",
    ),
    "wrong order after a comment": (
        lambda lines: ["# comment", *lines[:3], lines[4], lines[3], *lines[5:]],
        "row 3 (line 5): expected table_2, got table_3",
    ),
    "another column": (
        lambda lines: ["label,x,y,z,comment", *(f"{line},a" for line in lines[1:])],
        f"row 1 (line 1): {_COLUMNS}; has 5",
    ),
    "semicolons": (
        lambda lines: [line.replace(",", ";") for line in lines],
        f"row 1 (line 1): {_COLUMNS}; has 1",
    ),
    "decimal commas": (
        lambda lines: [line.replace(".", ",") for line in lines],
        f"row 1 (line 2): {_COLUMNS}; has 7",
    ),
    "decimal commas in quotes": (
        lambda lines: [lines[0], 'table_0,"0,54",0,0', *lines[2:]],
        "row 1 (line 2), x = '0,54': must be a number, with a point in decimals",
    ),
    "other names in the header": (
        lambda lines: ["label,a,b,c", *lines[1:]],
        "row 1 (line 1), x = 'a': must be a number, with a point in decimals",
    ),
    "text": (
        lambda lines: [*lines[:57], "culet,0,0,deep"],
        "row 57 (line 58), z = 'deep': must be a number, with a point in decimals",
    ),
    "missing number": (
        lambda lines: [*lines[:57], "culet,0,,1"],
        "row 57 (line 58), y = '': must be a number, with a point in decimals",
    ),
    "Python's underscores": (
        lambda lines: [*lines[:57], "culet,0,0,1_0"],
        "row 57 (line 58), z = '1_0': must be a number, with a point in decimals",
    ),
    "NaN": (
        lambda lines: [*lines[:57], "culet,0,nan,1"],
        "row 57 (line 58), y = 'nan': must be a finite number",
    ),
    "infinity": (
        lambda lines: [*lines[:57], "culet,0,0,-1e999"],
        "row 57 (line 58), z = '-1e999': must be a finite number",
    ),
    "open quotes": (
        lambda lines: [lines[0], '"table_0,1,2,3', *lines[2:]],
        "row 1 (line 2): is not CSV: unexpected end of data",
    ),
    "far away": (
        lambda lines: [*lines[:57], "culet,0,0,-6"],
        "vertex 57 (culet): must lie within 5 girdle radii of the girdle's centre",
    ),
}


@pytest.mark.parametrize("case", DAMAGED)
def test_bad_vertices_are_told_in_one_line(case):
    change, line = DAMAGED[case]
    assert refusal(write("\n".join(change(csv_lines())), "bad.csv")) == f"bad.csv: {line}"
    write('vertices = "bad.csv"')
    assert refusal("stone.toml") == f"bad.csv: {line}"


SHAPES = {
    "inside out": (lambda v: v * (1, -1, 1), "the table vertices run clockwise: the stone is inside out"),
    "upside down": (lambda v: v * (1, -1, -1), "the stone is upside down: the table must lie above"),
    "table too low": (lambda v: np.where(np.arange(57)[:, None] < 8, v * (1, 1, 0), v), "above the girdle"),
    "reversed": (lambda v: v[::-1], "upside down"),
    "star tips turned on by one": (
        lambda v: np.concatenate([v[:8], np.roll(v[8:16], 1, axis=0), v[16:]]),
        "(star_0): out of order: lies 45 deg beside its girdle vertex",
    ),
    "girdle turned on by one": (
        lambda v: np.concatenate([v[:32], np.roll(v[32:48], 1, axis=0), v[48:]]),
        "out of order: lies 22.5 deg beside its girdle vertex",
    ),
    "girdle rings exchanged": (
        lambda v: np.concatenate([v[:16], v[32:48], v[16:32], v[48:]]),
        "must not lie below its lower girdle vertex",
    ),
    "oval": (lambda v: v * (1.6, 1, 1), "radius must be from 0.8 to 1.25 of the mean girdle radius"),
    "a point": (lambda v: v * 0, "all girdle vertices lie on the axis"),
    "nearly a point": (lambda v: v * 1e-320, "all girdle vertices lie on the axis"),
    "too large": (lambda v: v * 1e300, "must be finite numbers of at most 1e+50"),
    "too far to tell the vertices apart": (lambda v: v + 1e17, "all girdle vertices lie on the axis"),
    "two vertices in one place": (lambda v: np.where(np.arange(57)[:, None] == 1, v[0], v), "out of order"),
    "hollow": (lambda v: np.where(np.arange(57)[:, None] == 0, v * (1, 1, 0.7), v), "hollow by"),
    "no area": (
        lambda v: np.where(np.arange(57)[:, None] == 8, v[[0, 1]].mean(axis=0), v),
        "star_1 has no area",
    ),
}


@pytest.mark.parametrize("case", SHAPES)
def test_vertices_that_make_no_stone_say_why(case):
    change, words = SHAPES[case]
    rows = change(load_stone("inoue-3").vertices).tolist()
    line = refusal(write("\n".join(",".join(["v", *map(repr, row)]) for row in rows), "bad.csv"))
    assert line.startswith("bad.csv: vert")
    assert words in line


def test_any_two_vertices_exchanged_are_refused():
    vertices = load_stone("inoue-3").vertices
    for i, j in itertools.combinations(range(57), 2):
        order = np.arange(57)
        order[[i, j]] = j, i
        with pytest.raises(InputError):
            stone_from_vertices(vertices[order])


def test_vertices_measured_to_a_tenth_of_a_per_cent_are_a_stone(rng):
    """Of the diameter, standard deviation: such a stone's narrow facets are a little hollow."""
    for _ in range(10):
        jitter = rng.normal(scale=0.002, size=(57, 3))
        stone_from_vertices(load_stone("inoue-3").vertices + jitter)

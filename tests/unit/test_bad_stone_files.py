"""The one line that each bad stone file gets."""

from __future__ import annotations

import pytest
from stone_files_help import ANGLES, PROPORTIONS, refusal, write

from gemrender.cuts.files import LONGEST_LINE, MOST_BYTES

#: Each test runs in an empty folder of its own.
pytestmark = pytest.mark.usefixtures("folder")

_KEYS = "table, star, lower_girdle_contact, crown_height, pavilion_depth, girdle_thickness"

REFUSED = {
    "no shape": (
        'name = "x"',
        "needs exactly one of [proportions], [angles], [report], [cut], vertices, design and mesh; has none",
    ),
    "two shapes": (
        PROPORTIONS + ANGLES,
        "needs exactly one of [proportions], [angles], [report], [cut], vertices, design and mesh; "
        "has proportions and angles",
    ),
    "unknown section": (
        PROPORTIONS.replace("[proportions]", "[proportion]\nx = 1"),
        "proportion = {'x': 1, 'table': 54.0, 'star': 57.0, 'lower_girdle_contact…: unknown key; "
        "must be one of name, proportions, angles, report, cut, vertices, design, mesh, material, size, "
        "crystal; "
        "did you mean proportions?",
    ),
    "unknown key": (
        PROPORTIONS.replace("crown_height", "crown_hight"),
        f"proportions.crown_hight = 15.7: unknown key; must be one of {_KEYS}; did you mean crown_height?",
    ),
    "key without its section": (
        "table = 54\n" + PROPORTIONS,
        "table = 54: unknown key; must be one of name, proportions, angles, report, cut, vertices, design, "
        "mesh, material, size, crystal; "
        "it belongs in [proportions] or [angles] or [report]",
    ),
    "key of another section": (
        PROPORTIONS + "lower_half = 80",
        f"proportions.lower_half = 80: unknown key; must be one of {_KEYS}; "
        "it belongs in [angles] or [report]",
    ),
    "missing keys": (
        "[proportions]\ntable = 54\nstar = 57\ncrown_height = 15",
        f"[proportions]: missing lower_girdle_contact, pavilion_depth, girdle_thickness; needs {_KEYS}",
    ),
    "number for a section": (
        "proportions = 3",
        f"proportions = 3: must be a section: a line [proportions], and below it {_KEYS}",
    ),
    "list of sections": (
        "[[proportions]]\ntable = 54",
        f"proportions = [{{'table': 54}}]: must be a section: a line [proportions], and below it {_KEYS}",
    ),
    "text": (
        PROPORTIONS.replace("54.00", '"54"'),
        "proportions.table = '54': must be a number from 5 to 92 [%]",
    ),
    "boolean": (
        PROPORTIONS.replace("54.00", "true"),
        "proportions.table = True: must be a number from 5 to 92 [%]",
    ),
    "list": (
        PROPORTIONS.replace("54.00", "[54,\n55]"),
        "proportions.table = [54, 55]: must be a number from 5 to 92 [%]",
    ),
    "not a number": (
        PROPORTIONS.replace("54.00", "nan"),
        "proportions.table = nan: must be from 5 to 92 [%]",
    ),
    "infinity": (
        PROPORTIONS.replace("15.70", "-inf"),
        "proportions.crown_height = -inf: must be from 0.5 to 60 [%]",
    ),
    "no crown": (
        PROPORTIONS.replace("15.70", "0"),
        "proportions.crown_height = 0: must be from 0.5 to 60 [%]",
    ),
    "contact beyond the girdle": (
        PROPORTIONS.replace("20.0", "101"),
        "proportions.lower_girdle_contact = 101: must be from 1 to 99 [%]",
    ),
    "star tip above the table": (
        PROPORTIONS.replace("57.0", "10.0"),
        "proportions.star = 10.0: the star tips would lie above the table: for table = 54 % the star must be "
        "at least 17.18 %",
    ),
    "angle": (
        ANGLES.replace("40.7", "90"),
        "angles.pavilion_angle = 90: must be from 3 to 63 [deg]",
    ),
    "crown too high": (
        ANGLES.replace("34.0", "75").replace("57", "50"),
        "angles.crown_angle = 75.0: gives a crown height of 93.3 %; must be from 0.5 to 60 %",
    ),
    "name that is no text": ("name = 3\n" + ANGLES, "name = 3: must be one line of 1 to 100 characters"),
    "name of two lines": (
        'name = "a\\nb"\n' + ANGLES,
        "name = 'a\\nb': must be one line of 1 to 100 characters",
    ),
    "empty name": ('name = " "\n' + ANGLES, "name = ' ': must be one line of 1 to 100 characters"),
    "empty material": (ANGLES + "[material]", "[material]: needs exactly one of name and index; has none"),
    "two materials": (
        ANGLES + '[material]\nname = "ruby"\nindex = 1.76',
        "[material]: needs exactly one of name and index; has both",
    ),
    "material that is no section": (
        'material = "diamond"\n' + ANGLES,
        "material = 'diamond': must be a section: a line [material], and below it name, index",
    ),
    "unknown key of the material": (
        ANGLES + "[material]\nindx = 2",
        "material.indx = 2: unknown key; must be one of name, index; did you mean index?",
    ),
    "material's name that is no text": (
        ANGLES + "[material]\nname = 2.4",
        "material.name = 2.4: must be the name of a material, in quotes",
    ),
    "index of a vacuum": (
        ANGLES + "[material]\nindex = 1",
        "material.index = 1: must be a finite number above 1",
    ),
    "index that is no number": (
        ANGLES + '[material]\nindex = "2.4"',
        "material.index = '2.4': must be a finite number above 1",
    ),
    "index that is not finite": (
        ANGLES + "[material]\nindex = inf",
        "material.index = inf: must be a finite number above 1",
    ),
    "not TOML": (
        PROPORTIONS.replace("57.0", "57,0"),
        "is not TOML: Expected newline or end of document after a statement (at line 5, column 10)",
    ),
    "vertices that are no text": (
        "vertices = [1, 2]",
        "vertices = [1, 2]: must be the name of a CSV file with 57 rows label, x, y, z",
    ),
    "empty": ("", "is empty"),
    "blank": ("\n \t\n", "is empty"),
    "Latin-1": ('name = "zoë"'.encode("latin-1"), "must be text in UTF-8; byte 11 is not"),
    "UTF-16": (PROPORTIONS.encode("utf-16"), "must be text in UTF-8; byte 1 is not"),
    "long line": (
        "#" * (LONGEST_LINE + 1),
        f"line 1: is {LONGEST_LINE + 1} characters long; at most {LONGEST_LINE} are allowed",
    ),
    "huge": ("#\n" * MOST_BYTES, f"is no stone file: larger than {MOST_BYTES} bytes"),
    "nested": ("a = " + "[\n" * 100_000, "is not TOML that makes a stone: nested too deeply"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_file_is_told_in_one_line(case):
    text, line = REFUSED[case]
    assert refusal(write(text)) == f"stone.toml: {line}"


@pytest.mark.parametrize("number", ["0x" + "f" * 900, "9" * 900, "1e999"])
def test_number_beyond_every_float_is_refused(number):
    assert "must be from 5 to 92" in refusal(write(PROPORTIONS.replace("54.00", number)))
    assert "must be a finite number" in refusal(write(f"{ANGLES}[material]\nindex = {number}"))

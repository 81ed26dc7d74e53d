"""GemCad's .asc files, as they are found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gemrender.cuts.asc import parse_asc, read_asc, write_asc
from gemrender.cuts.design import MOST_FACETS, Design, Tier
from gemrender.cuts.gem import read_gem
from gemrender.errors import InputError

CASES = Path(__file__).parents[1] / "cases" / "stones"
#: .asc files have six decimals of angles and eight of distances.
DECIMALS = 1e-8
CUBE = "GemCad 5.0\ng 96 0.0\ny 4 y\nI 1.54\na -90 1 96 24 48 72\na 0 1 96\na 0 -1 96\n"


def read(text: str) -> Design:
    return parse_asc(text.encode())


def with_tier(line: str) -> Tier:
    """The tier of a line that stands in a design."""
    return read(CUBE + line).tiers[3]


@pytest.mark.parametrize("name", ["round", "pear", "novelty-chiral"])
def test_asc_and_gem_of_a_design_are_the_same_planes(name):
    asc, gem = read_asc(CASES / f"{name}.asc"), read_gem(CASES / f"{name}.gem")
    assert asc.n_facets == gem.n_facets
    apart = np.abs(asc.planes()[:, None] - gem.planes()[None]).max(axis=2)
    assert apart.min(axis=0).max() < DECIMALS
    assert apart.min(axis=1).max() < DECIMALS
    assert (asc.gear, asc.offset, asc.index) == (gem.gear, gem.offset, gem.index)


def test_the_chiral_design_is_not_its_mirror_image():
    asc, gem = (read(CASES / f"novelty-chiral.{kind}").planes() for kind, read in
                (("asc", read_asc), ("gem", read_gem)))  # fmt: skip
    mirrored = gem * (-1, 1, 1, 1)
    apart = np.abs(asc[:, None] - mirrored[None]).max(axis=2)
    assert apart.min(axis=1).max() > 0.01


def test_all_records():
    design = read(
        "GemCad 5.0\ng 64 16.0\ny 2 y\nI 1.72\nH A title\nH by someone\n"
        "a -42.5 0.61 3 n P 61 G to a point\na 0 0.36 64 n T\nF one\nF \n"
    )
    assert design == Design(
        tiers=(
            Tier(angle_deg=-42.5, distance=0.61, indices=(3, 61), names=("P", ""), instructions="to a point"),
            Tier(angle_deg=0.0, distance=0.36, indices=(64,), names=("T",)),
        ),
        gear=64,
        offset=16,
        index=1.72,
        folds=2,
        is_mirrored=True,
        headers=("A title", "by someone"),
        footnotes=("one", ""),
    )


@pytest.mark.parametrize(
    "bytes_of",
    [
        lambda text: text.encode(),
        lambda text: text.encode("utf-8-sig"),
        lambda text: text.replace("\n", "\r\n").encode(),
        lambda text: text.replace("\n", "\r").encode(),
        lambda text: text.encode("utf-16"),
        lambda text: text.encode("cp1252"),
    ],
    ids=["UTF-8", "BOM", "CRLF", "CR", "UTF-16", "Windows-1252"],
)
def test_encodings_and_line_ends(bytes_of):
    design = parse_asc(bytes_of(CUBE + "H 45° – Größe\n"))
    assert design.headers == ("45° – Größe",)
    assert design.stone().solid.volume == pytest.approx(8.0)


@pytest.mark.parametrize(
    "line", ["96 0.0", "g96 0.0", "g 64 0.0\ng 96 0.0", "g 96", "g\t96\t0.0", "g 96 0.0 1.5", "g 96,0 0,0"]
)
def test_gear_lines(line):
    design = read(CUBE.replace("g 96 0.0", line))
    assert (design.gear, design.offset) == (96, 0)
    assert design.stone().solid.volume == pytest.approx(8.0)


def test_of_several_gear_lines_the_last_wins_and_it_is_told():
    design = read(CUBE.replace("g 96 0.0", "g 64 0.0\ng 96 0.0"))
    assert design.notes == ("has several lines g; the last, line 3, is used",)
    assert read(CUBE.replace("g 96 0.0", "g 96 0.0\ng 96 0.0")).notes == ()


@pytest.mark.parametrize("index", ["0", "96", "-96", "192", "96.0", "+0", "9.6e1"])
def test_index_0_is_the_number_of_teeth(index):
    plane = Design(tiers=(with_tier(f"a 45 1.2 {index}"),)).planes()[0]
    np.testing.assert_allclose(plane, [0, np.sqrt(0.5), np.sqrt(0.5), 1.2], atol=1e-15)


def test_fractional_and_negative_indices():
    assert with_tier("a 45 1.2 1.7 -3.25 .5").indices == (1.7, -3.25, 0.5)


@pytest.mark.parametrize(
    ("items", "indices", "names", "instructions"),
    [
        ("12 n 1 24", (12, 24), ("1", ""), ""),
        ("12 n G G Set size", (12,), ("G",), "Set size"),
        ("n A 12 24", (12, 24), ("A", ""), ""),
        ("n 5 12 24", (12, 24), ("5", ""), ""),
        ("12 n a 24 n b 36", (12, 24, 36), ("a", "b", ""), ""),
        ("12 n a n b", (12,), ("b",), ""),
        ("12 word 24 nan inf 1_0", (12, 24), ("", ""), ""),
        ("12 n Crown main 24", (12, 24), ("Crown", ""), ""),
        ("12 G", (12,), ("",), ""),
        ("12 n", (12,), ("",), ""),
        ("12 n G", (12,), ("G",), ""),
        ("12 n g1 24", (12, 24), ("g1", ""), ""),
        ("12\n24 36\n n G2 48 G to a\n G point", (12, 24, 36, 48), ("", "", "G2", ""), "to a point"),
        ("12\n\n; a comment\n# another\n24", (12, 24), ("", ""), ""),
        ("12 n\nA 24", (12, 24), ("A", ""), ""),
    ],
)
def test_what_stands_in_a_tier(items, indices, names, instructions):
    tier = with_tier(f"a 45 1.2 {items}")
    assert (tier.indices, tier.names, tier.instructions) == (indices, names, instructions)


def test_words_that_are_no_index_are_told():
    assert read(CUBE + "a 45 1.2 12 word 24 nan").notes == ("words that are no index, left out: word nan",)


@pytest.mark.parametrize(
    ("angle", "distance", "expected"),
    [
        ("0.00", "-0.368", (-0.0, 0.368)),
        ("-0", "0.368", (-0.0, 0.368)),
        ("-0.000000", "-0.368", (-0.0, 0.368)),
        ("0", "0.368", (0.0, 0.368)),
        ("-42", "-0.5", (-42.0, 0.5)),
        ("\u221242", "0.5", (-42.0, 0.5)),
        ("42,5", "0,5", (42.5, 0.5)),
    ],
)
def test_a_culet_is_at_minus_0_or_a_negative_distance(angle, distance, expected):
    tier = with_tier(f"a {angle} {distance} 96")
    assert (tier.angle_deg, tier.distance) == expected
    assert np.signbit(tier.angle_deg) == np.signbit(expected[0])


def test_a_table_needs_no_index():
    assert read(CUBE.replace("a 0 1 96", "a 0 1")).stone().solid.volume == pytest.approx(8.0)
    design = read(CUBE + "a 45 1.2\n")
    assert design.n_facets == 6
    assert design.notes == ("line 8: no index, so no facet",)


def test_girdle_facets_of_both_signs():
    design = read(CUBE.replace("a -90 1 96 24 48 72", "a -90 1 96 24\na 90 1 48 72"))
    assert design.stone().facet_sides.count("girdle") == 4
    assert design.stone().solid.volume == pytest.approx(8.0)


def test_the_symmetry_of_the_dialogue_makes_no_facets():
    for line in ("y 8 y", "y", "y x n", "y 0 y", "y8y", ""):
        assert read(CUBE.replace("y 4 y", line)).stone().solid.volume == pytest.approx(8.0)


@pytest.mark.parametrize("line", ["I 0", "I", "I x", "I 1.0", "I -1.5"])
def test_what_is_no_refractive_index_is_left_out_and_told(line):
    design = read(CUBE.replace("I 1.54", line))
    assert design.index is None
    assert len(design.notes) == 1
    assert "no refractive index" in design.notes[0]


@pytest.mark.parametrize("first", ["", "gemcad 4.51\n", "\n\nGemCad\n"])
def test_the_first_line_may_be_missing(first):
    design = read(first + CUBE.partition("\n")[2])
    assert design.stone().solid.volume == pytest.approx(8.0)
    assert design.notes == (() if first else ("has no first line GemCad",))


def test_text_that_is_no_record_is_left_out_and_told():
    design = read(CUBE + "Designed 1999\nF foot\nnonsense 3\n")
    assert design.n_facets == 6
    assert design.notes == ("no record of a design, left out: line 8, 10",)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("GemCad 5.0\ng 96 0\n", 'has no facets: no line "a angle distance index ..."'),
        ("GemCad 5.0\ng 96 0\na 45 1\n", "has no facets: no tier has an index"),
        (CUBE.replace("g 96 0.0\n", ""), 'has no line "g teeth offset" for the index wheel'),
        (CUBE + "a 45\n", "line 8: a tier needs an angle and a distance"),
        (CUBE + "a x 1 2\n", "line 8 = 'x': an angle must be a number"),
        (CUBE + "a 1 nan 2\n", "line 8 = 'nan': a distance must be a number"),
        (CUBE + "a 91 1 2\n", "line 8 = '91': an angle must be -90 to 90 degrees"),
        (CUBE + "a 9 1e99 2\n", "line 8 = '1e99': a distance must be at most 1e+50"),
        (CUBE + "a 9 1 1e99\n", "line 8 = '1e99': an index must be at most 1e+06"),
        (CUBE.replace("g 96", "g 0"), "line 2 = '0': the number of teeth must be 1 to 100000, or negative"),
        (
            CUBE.replace("g 96 0.0", "g"),
            "line 2: needs the number of teeth of the index wheel and its offset",
        ),
        (CUBE.replace("g 96 0.0", "g 96 x"), "line 2 = 'x': the offset must be a number"),
        (CUBE + "a 9 1" + " 1" * MOST_FACETS, "line 8: more than 5000 facets"),
        (CUBE + "\0", "is no text: it has null characters"),
    ],
)
def test_what_is_no_design_is_told_in_one_line(text, told):
    with pytest.raises(InputError) as caught:
        read(text)
    assert str(caught.value) == told


def test_the_file_is_told(tmp_path):
    path = tmp_path / "bad.asc"
    path.write_text(CUBE + "a x\n")
    with pytest.raises(InputError) as caught:
        read_asc(path)
    assert caught.value.source == str(path)
    with pytest.raises(InputError, match="no such file"):
        read_asc(tmp_path / "none.asc")


@pytest.mark.parametrize("path", sorted(CASES.glob("*.asc")), ids=lambda path: path.stem)
def test_what_is_written_is_read_again(path, tmp_path):
    design = read_asc(path)
    write_asc(design, tmp_path / "again.asc")
    again = read_asc(tmp_path / "again.asc")
    assert again.kinds() == design.kinds()
    assert again.facet_names() == design.facet_names()
    assert np.array_equal(again.planes(), design.planes())
    for part in ("gear", "offset", "index", "folds", "is_mirrored", "footnotes"):
        assert getattr(again, part) == getattr(design, part)
    assert [h.strip() for h in again.headers] == [h.strip() for h in design.headers]


def test_all_digits_and_odd_names_are_written(tmp_path):
    design = Design(
        tiers=(
            Tier(angle_deg=-41.123456789012, distance=1 / 3, indices=(0.1, 96), names=("a b", "n")),
            Tier(angle_deg=-0.0, distance=0.5, indices=(96,), instructions="two\nlines"),
        ),
        gear=-96,
        offset=1 / 3,
        headers=("Größe\nzwei", "日本"),
    )
    write_asc(design, tmp_path / "again.asc")
    again = read_asc(tmp_path / "again.asc")
    assert np.array_equal(again.planes(), design.planes())
    assert again.kinds() == ("a_b", "n", "K")
    assert again.headers == ("Größe zwei", "日本")
    assert again.tiers[1].instructions == "two lines"

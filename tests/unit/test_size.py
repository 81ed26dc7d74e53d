"""Sizes: what millimetres and weights make of a stone, and that what is stated twice agrees."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tolerances import ROUNDING

from gemrender.cuts import load_stone, vary
from gemrender.cuts.files import save_vertices
from gemrender.cuts.measurements import read_measurements, read_size
from gemrender.cuts.size import WEIGHT_TOLERANCE
from gemrender.errors import InputError
from gemrender.report.inspection import DEFAULT_SIZE_MM, inspect_stone
from gemrender.stone import Stone

#: Lengths of some millimetres, and per cents, after a few operations.
SUM = 1000 * ROUNDING
#: Density of diamond [g/cm^3], and milligrams of a carat.
DIAMOND, CARAT_MG = 3.52, 200.0

OVAL = '[cut]\nfamily = "oval"\n'
ROUND = "[report]\ntable = 57\ncrown_angle = 34.5\npavilion_angle = 40.8\n"
DESIGN = '[cut]\nfamily = "step"\nlength = 150\n'


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    """Each test runs in an empty folder of its own."""
    monkeypatch.chdir(tmp_path)


def made(text: str, size: str) -> Stone:
    Path("x.toml").write_text(f"{text}[size]\n{size}\n")
    return load_stone("x.toml")


def refusal(text: str, size: str) -> str:
    with pytest.raises(InputError) as caught:
        made(text, size)
    line = str(caught.value)
    assert line.startswith("x.toml: ")
    assert "\n" not in line
    return line.removeprefix("x.toml: ")


def box(stone: Stone) -> list[float]:
    """Length, width and depth [mm]."""
    found = inspect_stone(stone)
    return [found.length_mm, found.width_mm, found.depth_mm]


# ---- Measurements --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "numbers", "rounding"),
    [
        ("8.10 x 5.95 x 3.70", (8.10, 5.95, 3.70), 0.005),
        ("8.10 x 5.95 x 3.70 mm", (8.10, 5.95, 3.70), 0.005),
        ("8.10*5.95*3.70", (8.10, 5.95, 3.70), 0.005),
        ("8.10\u00d75.95\u00d73.70mm", (8.10, 5.95, 3.70), 0.005),
        ("8.10 mm X 5.95 mm X 3.70 mm", (8.10, 5.95, 3.70), 0.005),
        ("8,10 - 5,95 x 3,70", (8.10, 5.95, 3.70), 0.005),
        ("6.52 - 6.55 x 4.01", (6.52, 6.55, 4.01), 0.005),
        ("6.52\u20136.55 x 4.01", (6.52, 6.55, 4.01), 0.005),
        ("8.1 by 6", (8.1, 6.0), 0.05),
        ("8x6 mm", (8.0, 6.0), 0.5),
        ("8.1234 x 5.9512 x 3.7011", (8.1234, 5.9512, 3.7011), 0.005),
    ],
)
def test_measurements_as_they_are_printed(text, numbers, rounding):
    found, half_step = read_measurements(text)
    assert found == numbers
    assert half_step == pytest.approx(rounding)


@pytest.mark.parametrize(
    "text", ["", "8.10", "8.10 x", "a x b x c", "1 x 2 x 3 x 4", "8.10 5.95 3.70", 8, None]
)
def test_what_is_no_measurement(text):
    with pytest.raises(InputError, match=r"^measurements = .*must be as reports print it"):
        read_measurements(text)


# ---- Families ------------------------------------------------------------------------------------------


def test_millimetres_give_proportions_and_size_of_a_family():
    stone = made(f"{OVAL}table = 57\n", 'measurements = "8.10 x 5.95 x 3.70"')
    assert stone.size_mm == 8.10
    assert stone.cut.length_to_width == pytest.approx(8.10 / 5.95, rel=SUM)
    assert box(stone) == pytest.approx([8.10, 5.95, 3.70], rel=SUM)


def test_millimetres_one_by_one_are_the_same():
    text = made(OVAL, 'measurements = "8.10 x 5.95 x 3.70"')
    one_by_one = made(OVAL, "length_mm = 8.10\nwidth_mm = 5.95\ndepth_mm = 3.70")
    turned = made(OVAL, "length_mm = 5.95\nwidth_mm = 8.10\ndepth_mm = 3.70")  # whichever side is named first
    assert text.cut == one_by_one.cut == turned.cut
    assert text.size_mm == one_by_one.size_mm == turned.size_mm


def test_the_width_or_the_depth_alone_gives_the_size():
    whole = load_stone_of(OVAL)
    length, width, depth = (8.0, 8.0 / 1.4, inspect_stone(whole, size_mm=8.0).depth_mm)
    for size in (f"length_mm = {length}", f"width_mm = {width!r}", f"depth_mm = {depth!r}"):
        stone = made(OVAL, size)
        assert stone.size_mm == pytest.approx(8.0, rel=SUM)
        assert stone.cut == whole.cut


def load_stone_of(text: str) -> Stone:
    Path("plain.toml").write_text(text)
    return load_stone("plain.toml")


def test_a_weight_alone_gives_the_size():
    stone = made(OVAL, "carat = 1.25")
    assert inspect_stone(stone).carat == pytest.approx(1.25, rel=SUM)
    volume = stone.solid.volume * (stone.size_mm / 2) ** 3
    assert volume * DIAMOND / CARAT_MG == pytest.approx(1.25, rel=SUM)
    sapphire = made(f'{OVAL}[material]\nname = "sapphire"\n', "carat = 1.25")
    assert inspect_stone(sapphire).carat == pytest.approx(1.25, rel=SUM)
    assert sapphire.size_mm < stone.size_mm, "it is heavier"


def test_a_weight_needs_a_density_and_millimetres_do_not():
    glass = f"{OVAL}[material]\nindex = 1.6\n"
    line = refusal(glass, "carat = 1")
    assert line.startswith("size.carat = 1: needs the material's density, which is not known")
    assert made(glass, "carat = 1\nlength_mm = 7").size_mm == 7


@pytest.mark.parametrize("share", [-0.9, 0.9, -1.2, 1.2])
def test_a_weight_beside_millimetres_agrees_or_is_told(share):
    weight = inspect_stone(load_stone_of(OVAL), size_mm=8.0).carat * 5  # of 5 times the volume
    size = 8.0 * 5 ** (1 / 3)
    stated = weight * (1 + share * WEIGHT_TOLERANCE)
    stone = made(OVAL, f"length_mm = {size!r}\ncarat = {stated!r}")
    assert stone.size_mm == pytest.approx(size)
    assert len(stone.notes) == (abs(share) > 1)
    if stone.notes:
        assert stone.notes[0].startswith(
            f"its millimetres make {weight:.3g} ct, and {stated:g} ct are stated: "
        )


REFUSED = {
    "ratio stated twice": (
        f"{OVAL}length_to_width = 1.4\n",
        'measurements = "8.10 x 5.95 x 3.70"',
        "size.measurements = '8.10 x 5.95 x 3.70': makes the length to width 1.361, and it is stated as 1.4; "
        "the rounding of a report allows a difference of 0.007",
    ),
    "depth stated twice": (
        f"{OVAL}depth = 63\n",
        "width_mm = 5.95\ndepth_mm = 3.70",
        "size.depth_mm = 3.7: makes the depth 62.18 %, and it is stated as 63 %; the rounding of a report "
        "allows a difference of 0.19 %",
    ),
    "depth beside all its parts": (
        f"{OVAL}crown_height = 14\npavilion_depth = 43\ngirdle_thickness = 3\n",
        "width_mm = 5.95\ndepth_mm = 3.70",
        "size.depth_mm = 3.7: makes the depth 62.18 %: pavilion depth 43.0 + crown height 14.0 + girdle "
        "thickness 3.0 make 60.0 %; the rounding of a report allows a difference of 0.8 %",
    ),
    "ratio out of range": (
        OVAL,
        "length_mm = 9\nwidth_mm = 3",
        "size.length_mm = 9: makes the length to width 3: must be from 1 to 2.5",
    ),
    "text and number differ": (
        OVAL,
        'measurements = "8.10 x 5.95 x 3.70"\nwidth_mm = 6.1',
        "size.width_mm = 6.1: measurements = '8.10 x 5.95 x 3.70' makes it 5.95; state only one",
    ),
    "no round stone": (
        f"{ROUND}girdle_thickness = 3\n",
        'measurements = "8.10 x 5.95 x 3.70"',
        "size.measurements = '8.10 x 5.95 x 3.70': must be at most 1.05 times the width: the cut is as "
        "wide as long",
    ),
    "unknown key": (
        OVAL,
        "lenght_mm = 8",
        "size.lenght_mm = 8: unknown key; must be one of measurements, length_mm, width_mm, depth_mm, "
        "diameter_mm, carat; did you mean length_mm?",
    ),
    "no key": (
        OVAL,
        "",
        "size: needs one or more of measurements, length_mm, width_mm, depth_mm, diameter_mm, carat",
    ),
    "no number": (OVAL, 'length_mm = "8"', "size.length_mm = '8': must be a number from 0.1 to 1000 [mm]"),
    "out of range": (OVAL, "length_mm = 0", "size.length_mm = 0: must be from 0.1 to 1000 [mm]"),
    "no text": (
        OVAL,
        'measurements = "8.10"',
        "size.measurements = '8.10': must be as reports print it: \"8.10 x 5.95 x 3.70\", of rounds "
        '"6.52 - 6.55 x 4.01" [mm]',
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_sizes_that_are_refused(case):
    text, size, line = REFUSED[case]
    assert refusal(text, size).startswith(line)


def test_a_ratio_rounded_as_reports_do_agrees_and_counts():
    stone = made(f"{OVAL}length_to_width = 1.36\ndepth = 62.2\n", 'measurements = "8.10 x 5.95 x 3.70"')
    assert stone.cut.length_to_width == 1.36
    assert stone.size_mm == 8.10


# ---- Other stones --------------------------------------------------------------------------------------


def test_a_round_report_of_a_range_of_diameters():
    """The depth makes the girdle, as it does in per cent; the mean diameter is the size."""
    stone = made(ROUND, 'measurements = "6.52 - 6.56 x 4.01"')
    assert stone.size_mm == pytest.approx(6.54)
    total = 100 * 4.01 / 6.54
    in_percent = load_stone_of(f"{ROUND}depth = {total!r}\n")
    assert stone.proportions == in_percent.proportions
    assert stone.assumed == in_percent.assumed
    assert box(stone)[2] == pytest.approx(4.01, rel=SUM)


def test_any_stone_has_a_size():
    given = load_stone("inoue-3")
    save_vertices(given, "v.csv")
    text = Path(given.source).read_text()
    assert made(text, "diameter_mm = 5").size_mm == 5
    assert made('vertices = "v.csv"\n', "length_mm = 5").size_mm == 5
    assert made(DESIGN, "length_mm = 9").size_mm == 9
    assert made(DESIGN, "width_mm = 6").size_mm == pytest.approx(9)


def test_another_shape_than_the_millimetres_is_refused():
    line = refusal(DESIGN, "length_mm = 9\nwidth_mm = 5")
    assert line.startswith(
        "size.width_mm = 5: the stone's shape makes the width 6.00 mm where the length is 9.00"
    )


def test_the_size_stays_with_the_stone():
    stone = made(OVAL, "length_mm = 8")
    assert stone.rotated(30).size_mm == 8
    assert stone.tilted(0.5, np.random.default_rng(1)).size_mm == 8
    assert replace(stone, material="sapphire").size_mm == 8
    assert [one.size_mm for one in vary(stone, ["table=55,57"])] == [8, 8]
    brilliant = made(f"{ROUND}girdle = 3\n", "diameter_mm = 7")
    assert [one.size_mm for one in vary(brilliant, ["table=55,57"])] == [7, 7]


def test_what_a_size_is_used_for():
    from gemrender.render.photoreal import make_gems

    stone, other = made(OVAL, "length_mm = 8"), load_stone("inoue-3")
    assert inspect_stone(stone).size_mm == 8
    assert inspect_stone(other).size_mm == DEFAULT_SIZE_MM
    assert inspect_stone(stone, size_mm=4).size_mm == 4
    assert [gem.diameter_mm for gem in make_gems([stone, other])] == [8, DEFAULT_SIZE_MM]
    assert [gem.diameter_mm for gem in make_gems([stone, other], diameter_mm=5)] == [5, 5]


def test_sizes_are_read_from_numbers_and_text_alike():
    assert read_size({"diameter_mm": 6.5}).sides() == (6.5, 6.5)
    assert read_size({"measurements": "5 x 6 x 3"}).sides() == (6, 5)

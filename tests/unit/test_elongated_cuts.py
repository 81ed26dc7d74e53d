"""Ovals, marquises and pears: their outlines in closed form, their facets, what they measure."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

from gemrender.cuts import RoundBrilliant, load_stone
from gemrender.cuts.construction.outlines import circle, ellipse, marquise, pear
from gemrender.cuts.families import families
from gemrender.cuts.families import marquise as marquises
from gemrender.cuts.families import oval as ovals
from gemrender.cuts.families import pear as pears
from gemrender.cuts.families.stated import from_values
from gemrender.errors import InputError
from gemrender.report.measured import measured_dimensions

#: Lengths after a hundred operations on numbers of order 1; angles of symmetry.
ROUNDING = 1e-12
#: What planes measure against what was asked.
MEASURED = 1e-9
#: Turn of a chord from the direction between its ends [rad]: of third order in its length, a tenth of the
#: outline, and where two curves of unlike curvature join of second.
CHORD = 0.02
NAMES = ("oval", "marquise", "pear")
FULL = {"table": 1, "star": 8, "bezel": 8, "upper_girdle": 16, "lower_girdle": 16, "pavilion_main": 8,
        "girdle": 64}  # fmt: skip


def polygon_of(girdle) -> np.ndarray:
    return girdle.points.reshape(-1, 2)


def area_of(girdle) -> float:
    x, y = polygon_of(girdle).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def half_marquise(width: float, height: float, steps: int) -> float:
    """Area of the chords of two arcs from the belly to the point, by the angle that each spans."""
    radius, turn = (width**2 + height**2) / (2 * width), 2 * math.atan(width / height)
    sector = 0.5 * radius**2 * steps * math.sin(turn / steps)
    return 2 * (sector - 0.5 * (radius - width) * height)


# ---- Outlines ------------------------------------------------------------------------------------------


def test_an_ellipse_has_the_area_of_its_polygon():
    assert area_of(ellipse(0.7)) == pytest.approx(32 * 0.7 * math.sin(2 * math.pi / 64), abs=ROUNDING)


def test_a_circle_is_round():
    girdle = circle(16)
    assert girdle.is_round
    assert np.hypot(*girdle.feet.T) == pytest.approx(1.0, abs=ROUNDING)
    assert (girdle.feet * girdle.tangents).sum(axis=1) == pytest.approx(0.0, abs=ROUNDING)


@pytest.mark.parametrize("width", [0.4, 0.5, 0.8])
def test_a_marquise_is_two_arcs_that_meet_in_points(width):
    girdle = marquise(width)
    points = polygon_of(girdle)
    radius = (width**2 + 1) / (2 * width)
    for side in (-1, 1):
        arc = points[side * points[:, 0] >= 0]
        assert np.hypot(arc[:, 0] + side * (radius - width), arc[:, 1]) == pytest.approx(radius, abs=ROUNDING)
    assert points[[0, 32]] == pytest.approx(np.array([[0, 1], [0, -1]]), abs=ROUNDING)
    assert area_of(girdle) == pytest.approx(2 * half_marquise(width, 1, 16), abs=ROUNDING)


@pytest.mark.parametrize("head", [0.5, 0.6, 0.72])
def test_a_pear_is_half_an_ellipse_and_half_a_marquise(head):
    girdle = pear(0.6, head)
    below = 16 * 0.6 * head * math.sin(2 * math.pi / 64)
    assert area_of(girdle) == pytest.approx(below + half_marquise(0.6, 2 - head, 16), abs=ROUNDING)
    assert girdle.feet[[0, 8]] == pytest.approx(np.array([[0, 1], [0, -1]]), abs=ROUNDING)
    # Smooth at the belly: on both sides it runs along the length.
    assert girdle.feet[[4, 12]] == pytest.approx(np.array([[-0.6, head - 1], [0.6, head - 1]]), abs=ROUNDING)
    assert girdle.tangents[[4, 12]].tolist() == [[0, -1], [0, 1]]


def test_shoulders_and_wings_are_as_far_out_as_is_said():
    middle = 2 * 4 + 0  # the girdle point half-way between belly and end, of each quarter
    plain, fuller = (polygon_of(ellipse(0.7, shoulder=share)) for share in (0.0, 0.06))
    assert fuller[middle] == pytest.approx(1.06 * plain[middle], abs=ROUNDING)
    # A wing is 4 v^2 (1 - v^2) of it further out, v the share of the way to the point.
    plain, fuller = (polygon_of(marquise(0.5, wing=share)) for share in (0.0, 0.06))
    v = np.abs(plain[:, 1])
    assert fuller[:, 1].tolist() == plain[:, 1].tolist()
    assert np.abs(fuller[:, 0]) - np.abs(plain[:, 0]) == pytest.approx(
        0.06 * 0.5 * 4 * v**2 * (1 - v**2), abs=ROUNDING
    )


@pytest.mark.parametrize(
    "girdle",
    [ellipse(0.7, shoulder=0.05), marquise(0.5, wing=-0.05), pear(0.6, 0.7, shoulder=-0.04, wing=0.05)],
)
def test_girdle_points_have_the_directions_of_the_outline(girdle):
    """The chord of the neighbours runs along it, but for a small turn (`CHORD`)."""
    points = polygon_of(girdle)
    chords = (np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0))[::4]
    turn = chords[:, 0] * girdle.tangents[:, 1] - chords[:, 1] * girdle.tangents[:, 0]
    turn = turn / np.linalg.norm(chords, axis=1)
    assert np.abs(turn / np.linalg.norm(girdle.tangents, axis=1)).max() < CHORD
    assert ((chords * girdle.tangents).sum(axis=1) > 0).all()


# ---- Facets --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_the_standard_has_58_facets_with_the_culet_and_the_girdle_apart(name):
    for culet, others in ((0.0, {}), (2.0, {"culet": 1})):
        cut = families()[name](culet=culet)
        kinds = Counter(cut.construction().kinds)
        assert kinds == FULL | others
        assert kinds.total() - 64 == 57 + bool(culet)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("mains", [4, 6])
def test_fewer_mains_are_some_of_the_eight(name, mains):
    """The ends' are left out first, then those of the belly; halves stay, 16 of them."""
    cut = families()[name]()
    every, some = cut.construction(), cut.construction(mains=mains)
    own = [plane for plane, kind in zip(some.planes, some.kinds, strict=True) if kind == "pavilion_main"]
    of_all = [plane for plane, kind in zip(every.planes, every.kinds, strict=True) if kind == "pavilion_main"]
    stay = {4: (1, 3, 5, 7), 6: (1, 2, 3, 5, 6, 7)}[mains]
    assert np.array(own) == pytest.approx(np.array(of_all)[list(stay)], abs=ROUNDING)
    assert Counter(some.kinds) == FULL | {"pavilion_main": mains}


@pytest.mark.parametrize(("name", "bezels"), [("marquise", 6), ("pear", 7)])
def test_a_french_tip_is_the_crown_without_the_bezel_there(name, bezels):
    plain, french = families()[name](), families()[name](tips="french")
    with_bezel, without = plain.construction(), french.construction()
    kinds = Counter(without.kinds)
    assert kinds == FULL | {"bezel": bezels}
    left = np.abs(with_bezel.planes[:, None] - without.planes).max(axis=2).min(axis=1)
    gone = left > ROUNDING
    assert [with_bezel.kinds[number] for number in np.flatnonzero(gone)] == ["bezel"] * (8 - bezels)
    # The ridge to each point lies in the mirror plane, above the bezel that it takes the place of.
    ridge = without.points[without.rings["ridge"]]
    assert ridge[:, 0] == pytest.approx(0.0, abs=ROUNDING)
    assert (np.einsum("ij,ij->i", ridge, with_bezel.planes[gone, :3]) > with_bezel.planes[gone, 3]).all()
    assert french.stone().solid.volume > plain.stone().solid.volume


def test_an_oval_as_long_as_wide_is_a_round_brilliant():
    """Of the same facets, but for the girdle."""
    numbers = {
        "table": 57.0,
        "star": 55.0,
        "crown_height": 15.0,
        "pavilion_depth": 43.0,
        "girdle_thickness": 3.0,
    }
    round_planes = RoundBrilliant(**numbers, lower_girdle_contact=20.0).stone().solid.planes
    cut = ovals.Parameters(
        length_to_width=1.0, shoulder=0.0, table_elongation=1.0, lower_half=80.0, **numbers
    )
    planes = cut.planes()[[kind != "girdle" for kind in cut.construction().kinds]]
    assert len(planes) == len(round_planes)
    assert np.abs(planes[:, None] - round_planes).max(axis=2).min(axis=1).max() <= ROUNDING


# ---- Symmetry ------------------------------------------------------------------------------------------

CUTS = [
    *(ovals.Parameters(mains=mains, shoulder=3.0, culet=2.0) for mains in (4, 6, 8)),
    *(marquises.Parameters(mains=mains, wing=-3.0, tips="french") for mains in (4, 6, 8)),
    *(pears.Parameters(mains=mains, shoulder=-2.0, wing=3.0, culet_to_point=4.0) for mains in (4, 6, 8)),
]  # fmt: skip


@pytest.mark.parametrize("cut", CUTS)
def test_every_cut_is_its_own_mirror_image(cut):
    planes = cut.planes()
    mirrors = [[-1, 1, 1, 1], [1, -1, 1, 1]][: 1 if isinstance(cut, pears.Parameters) else 2]
    for mirror in mirrors:
        apart = np.abs(planes[:, None] * mirror - planes).max(axis=2).min(axis=1)
        assert apart.max() <= ROUNDING
    symmetry = cut.stone().symmetry
    assert (symmetry.fold, len(symmetry.mirrors)) == (len(mirrors), len(mirrors))
    assert symmetry.mirrors[-1] == pytest.approx(np.pi / 2, abs=MEASURED)


# ---- What they measure ---------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("french", [False, True])
def test_a_stone_measures_what_was_asked(name, french):
    asked = {"length_to_width": 1.73, "table": 61.5, "crown_height": 12.25, "pavilion_depth": 44.75}
    tips = {"tips": "french"} if french and name != "oval" else {}
    cut = families()[name](**asked, girdle_thickness=2.5, **tips)
    stone = cut.stone()
    found = {key: part.value for key, part in measured_dimensions(stone).items()}
    assert {key: found[key] for key in asked} == pytest.approx(asked, abs=MEASURED)
    assert found["total_depth"] == pytest.approx(12.25 + 2.5 + 44.75, abs=MEASURED)
    box = np.array([stone.solid.vertices.min(axis=0)[:2], stone.solid.vertices.max(axis=0)[:2]])
    assert box == pytest.approx(np.array([[-1 / 1.73, -1], [1 / 1.73, 1]]), abs=MEASURED)


@pytest.mark.parametrize("name", NAMES)
def test_the_table_follows_its_width_or_is_as_long_as_is_stated(name):
    for table in (50.0, 60.0):
        cut, _ = from_values(families()[name], {"table": table})
        assert np.ptp(table_of(cut)[:, 1]) == pytest.approx(
            2 * table * cut.table_elongation / 100, abs=MEASURED
        )
        cut, _ = from_values(families()[name], {"table": table, "table_length": 56.0})
        assert np.ptp(table_of(cut)[:, 1]) == pytest.approx(2 * 0.56, abs=MEASURED)


def table_of(cut) -> np.ndarray:
    made = cut.construction()
    return made.points[made.rings["table"]]


def test_a_report_of_an_oval_makes_it():
    cut, taken = from_values(
        ovals.Parameters, {"length_to_width": 1.4, "table": 57, "depth": 62.2, "girdle": "medium"}
    )
    parts = cut.crown_height + cut.girdle_thickness + cut.pavilion_depth
    assert parts == pytest.approx(62.2, abs=MEASURED)
    assert "mains 8 (the commonest)" in taken


@pytest.mark.parametrize(
    ("name", "ratio", "factor"),
    [
        *(("oval", ratio, 0.0062) for ratio in (1.25, 1.4, 1.5)),
        *(("marquise", ratio, factor) for ratio, factor in ((1.75, 0.0057), (2.0, 0.0058))),
        *(("pear", ratio, factor) for ratio, factor in ((1.25, 0.00615), (1.5, 0.006), (1.66, 0.0059))),
    ],
)
def test_weights_are_those_of_the_formulas_of_the_trade(name, ratio, factor):
    """Factors of Gemgate and Esslinger, as cited in `elongated`: carat by millimetres."""
    cut = families()[name](length_to_width=ratio)
    length, width = 2.0, 2.0 / ratio
    depth = width * (cut.crown_height + cut.girdle_thickness + cut.pavilion_depth) / 100
    base = ((length + width) / 2) ** 2 if name == "oval" else length * width
    carat = cut.stone().solid.volume * 3.52 / 200
    assert carat == pytest.approx(factor * base * depth, rel=0.03)


def test_an_oval_weighs_what_its_report_says():
    """A diamond of 1.01 carat, 8.13 x 5.61 mm, with table and depth (Diamond Screener, "Oval Cut ...")."""
    stone = load_stone("oval-classic")
    carat = stone.solid.volume * (8.13 / 2) ** 3 * 3.52 / 200
    assert carat == pytest.approx(1.01, rel=0.03)


def test_the_culet_of_a_pear_lies_on_the_belly_or_nearer_to_the_point():
    for share in (0.0, 6.0):
        cut = pears.Parameters(culet_to_point=share)
        corners = cut.stone().solid.vertices
        lowest = corners[corners[:, 2].argmin()]
        belly = 2 * 0.5 / 1.55 - 1  # the head is half a circle, half the width high
        assert lowest[:2] == pytest.approx([0.0, belly + share / 50], abs=MEASURED)


@pytest.mark.parametrize(
    ("kind", "values", "said"),
    [
        (marquises.Parameters, {"tips": "fish"}, 'tips = \'fish\': must be one of "bezel", "french"'),
        (ovals.Parameters, {"mains": 5}, "mains = 5: must be one of 4, 6, 8"),
        (pears.Parameters, {"head": 80}, "head = 80: must be from 40 to 60 [%]"),
    ],
)
def test_what_is_out_of_range_is_told(kind, values, said):
    with pytest.raises(InputError) as caught:
        kind(**values)
    assert said in str(caught.value)

"""Round brilliants with culets and painted facets, old European cuts, single cuts and cushions."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gemrender.cuts import RoundBrilliant
from gemrender.cuts.construction.cushion_outline import cushion as cushion_outline
from gemrender.cuts.families import cushion, old_european, round_brilliant, single_cut
from gemrender.cuts.girdle_words import CULET_WORDS
from gemrender.errors import InputError
from gemrender.scoring import score

#: Lengths after a hundred operations on numbers of order 1, and lengths, angles and per cent measured so.
ROUNDING = 1e-12
MEASURED = 1e-9
#: Volumes of round stones are good to this (`ConvexSolid.volume`).
VOLUME = 1e-8
#: Pixels of the reference's maps, and what their edges leave of a mean [%].
PIXELS, MAP = 64, 2.0

CROWN = {"table": 1, "star": 8, "bezel": 8, "upper_girdle": 16}
PAVILION = {"lower_girdle": 16, "pavilion_main": 8}
BRILLIANTS = (round_brilliant.Parameters, old_european.Parameters)
EXAMPLES = {
    "point": (round_brilliant.Parameters(), {**CROWN, **PAVILION, "girdle": 1}),
    "culet": (round_brilliant.Parameters(culet=3), {**CROWN, **PAVILION, "girdle": 1, "culet": 1}),
    "painted": (
        round_brilliant.Parameters(crown_painting=3, pavilion_painting=-1),
        {**CROWN, **PAVILION, "girdle": 1},
    ),
    "old european": (old_european.Parameters(), {**CROWN, **PAVILION, "girdle": 1, "culet": 1}),
    "single cut": (single_cut.Parameters(), {"table": 1, "bezel": 8, "pavilion_main": 8, "girdle": 1}),
    "single cut, culet": (
        single_cut.Parameters(culet="medium"),
        {"table": 1, "bezel": 8, "pavilion_main": 8, "girdle": 1, "culet": 1},
    ),
    "cushion brilliant": (cushion.Parameters(style="brilliant"), {**CROWN, **PAVILION, "girdle": 64}),
    "cushion modified": (
        cushion.Parameters(culet=2),
        {**CROWN, **PAVILION, "break": 16, "girdle": 64, "culet": 1},
    ),
}
each = pytest.mark.parametrize(("cut", "counts"), EXAMPLES.values(), ids=EXAMPLES)


def height_at(plane: np.ndarray, x: float, y: float) -> np.ndarray:
    return (plane[3] - plane[0] * x - plane[1] * y) / plane[2]


def planes_of(cut, kind: str) -> np.ndarray:
    made = cut.construction()
    return made.planes[[k for k, other in enumerate(made.kinds) if other == kind]]


def angle_between(one: np.ndarray, other: np.ndarray) -> float:
    return math.degrees(math.acos(one[:3] @ other[:3]))


# ---- Facets and symmetry -------------------------------------------------------------------------------


@each
def test_it_has_the_standard_facets(cut, counts):
    assert Counter(cut.stone().facet_kinds) == counts


@each
def test_it_is_as_symmetric_as_its_outline(cut, counts):
    symmetry = cut.stone().symmetry
    expected = 2 if isinstance(cut, cushion.Parameters) else 8
    assert (symmetry.fold, len(symmetry.mirrors)) == (expected, expected)


@pytest.mark.parametrize("style", ["brilliant", "modified brilliant"])
def test_a_square_cushion_has_four_mirrors(style):
    symmetry = cushion.Parameters(style=style, length_to_width=1.0).stone().symmetry
    assert (symmetry.fold, len(symmetry.mirrors)) == (4, 4)


# ---- As asked ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", BRILLIANTS)
@settings(max_examples=20, deadline=None, derandomize=True)
@given(
    table=st.floats(40, 70), crown=st.floats(5, 25), pavilion=st.floats(35, 50), culet=st.floats(0.1, 15),
    girdle=st.floats(2, 10), crown_painting=st.floats(-3, 3), pavilion_painting=st.floats(-3, 3),
)  # fmt: skip
def test_a_brilliant_measures_what_was_asked(
    kind, table, crown, pavilion, culet, girdle, crown_painting, pavilion_painting
):
    cut = kind(
        table=table, crown_height=crown, pavilion_depth=pavilion, culet=culet, girdle_thickness=girdle,
        crown_painting=crown_painting, pavilion_painting=pavilion_painting, star=60, lower_half=70,
    )  # fmt: skip
    made = cut.construction()
    bezel, main = planes_of(cut, "bezel")[0], planes_of(cut, "pavilion_main")[0]
    top, low = planes_of(cut, "table")[0][3], -planes_of(cut, "culet")[0][3]
    upper, lower = height_at(bezel, 1, 0), height_at(main, 1, 0)
    measured = 50 * np.array([top - low, top - upper, upper - lower, lower - low])
    asked = [crown + girdle + pavilion, crown, girdle, pavilion]
    assert measured == pytest.approx(asked, abs=MEASURED)
    across = made.points[made.rings["table"]]
    assert 50 * np.ptp(across[:, 0]) == pytest.approx(table, abs=MEASURED)
    # Culets are as wide from main to main: there the main's plane has the culet's height.
    assert height_at(main, culet / 100, 0) == pytest.approx(low, abs=MEASURED)
    angles = [angle_between(bezel, np.eye(4)[2]), 180 - angle_between(main, np.eye(4)[2])]
    assert angles == pytest.approx(
        [cut.alternatives()["crown_angle"], cut.alternatives()["pavilion_angle"]], abs=MEASURED
    )


@settings(max_examples=20, deadline=None, derandomize=True)
@given(
    table=st.floats(20, 85), crown=st.floats(3, 35), pavilion=st.floats(20, 65), girdle=st.floats(0, 20),
    culet=st.floats(0.1, 20),
)  # fmt: skip
def test_a_single_cut_measures_what_was_asked_in_the_middle_of_its_facets(
    table, crown, pavilion, girdle, culet
):
    cut = single_cut.Parameters(
        table=table, crown_height=crown, pavilion_depth=pavilion, girdle_thickness=girdle, culet=culet
    )
    bezel, main = planes_of(cut, "bezel")[0], planes_of(cut, "pavilion_main")[0]
    outward = bezel[:2] / np.hypot(*bezel[:2])
    top, low = planes_of(cut, "table")[0][3], -planes_of(cut, "culet")[0][3]
    upper, lower = height_at(bezel, *outward), height_at(main, *outward)
    measured = 50 * np.array([top - upper, upper - lower, lower - low])
    assert measured == pytest.approx([crown, girdle, pavilion], abs=MEASURED)
    # Nowhere on the circle is the girdle thinner, and it begins at z = 0.
    turns = np.linspace(0, 2 * np.pi, 721)[:, None]
    x, y = np.cos(turns), np.sin(turns)
    above = height_at(planes_of(cut, "bezel").T, x, y).min(axis=1)
    below = height_at(planes_of(cut, "pavilion_main").T, x, y).max(axis=1)
    assert (above - below).min() >= girdle / 50 - MEASURED
    assert below.min() == pytest.approx(0, abs=MEASURED)
    flat = angle_between(bezel, np.eye(4)[2]), 180 - angle_between(main, np.eye(4)[2])
    assert flat == pytest.approx(
        [cut.alternatives()["crown_angle"], cut.alternatives()["pavilion_angle"]], abs=MEASURED
    )


@pytest.mark.parametrize("style", ["brilliant", "modified brilliant"])
@pytest.mark.parametrize("ratio", [1.0, 1.2, 1.5])
def test_a_cushion_measures_what_was_asked(style, ratio):
    cut = cushion.Parameters(style=style, length_to_width=ratio, culet=3, girdle_thickness=6)
    stone, made = cut.stone(), cut.construction()
    size = np.ptp(stone.solid.vertices, axis=0)
    assert size[1] == pytest.approx(2, abs=MEASURED)
    assert size[1] / size[0] == pytest.approx(ratio, abs=MEASURED)
    percent = 100 / size[0]
    assert size[2] * percent == pytest.approx(
        cut.crown_height + cut.girdle_thickness + cut.pavilion_depth, abs=MEASURED
    )
    table, lower = (made.points[made.rings[name]] for name in ("table", "culet"))
    assert np.ptp(table[:, 0]) * percent == pytest.approx(cut.table, abs=MEASURED)
    assert np.ptp(table[:, 1]) / 2 == pytest.approx(cut.table / 100, abs=MEASURED)
    edge = made.points[made.rings["girdle_upper"]]
    assert (table[0, 2] - edge[:, 2].max()) * percent == pytest.approx(cut.crown_height, abs=MEASURED)
    assert -lower[0, 2] * percent == pytest.approx(cut.pavilion_depth, abs=MEASURED)
    side = next(
        plane
        for plane in planes_of(cut, "pavilion_main")
        if plane[0] > 0 and abs(plane[1]) < ROUNDING  # the one that faces +x
    )
    assert height_at(side, cut.culet / percent / 2, 0) == pytest.approx(lower[0, 2], abs=MEASURED)


def test_the_outline_of_a_cushion_is_smooth():
    """Girdle points lie where arcs meet, which do so without a bend."""
    fine = cushion_outline(0.8, 1.0, bulge=0.06, corner=0.4, pieces=256)
    points = fine.points.reshape(-1, 2)
    assert np.abs(points).max(axis=0) == pytest.approx([0.8, 1.0], abs=ROUNDING)
    along = np.roll(points, -1, axis=0) - points
    turns = np.degrees(np.arctan2(*along.T))
    bends = (np.diff(turns, append=turns[0]) + 180) % 360 - 180
    assert bends.max() < 0  # anticlockwise all round
    assert bends.min() > -0.5
    straight = along / np.linalg.norm(along, axis=1, keepdims=True)
    assert (straight[::256] * fine.tangents).sum(axis=1).min() > 1 - 1e-4


def test_a_square_cushion_that_bows_out_by_half_is_a_circle():
    """An arc as high as half its straight line is a half circle: its corners are of the same radius."""
    points = cushion_outline(1.0, 1.0, bulge=0.4999, corner=0.98).points.reshape(-1, 2)
    assert np.hypot(*points.T) == pytest.approx(np.ones(64), abs=1e-3)


# ---- Volumes -------------------------------------------------------------------------------------------


def test_the_volume_of_a_single_cut_in_closed_form():
    """A sector of the circle under a plane, eight times, less the pyramid above the table."""
    cut = single_cut.Parameters(table=60, crown_height=14, pavilion_depth=43, girdle_thickness=3, culet=5)
    half = math.pi / 8
    volume = math.pi * cut.girdle_thickness / 50
    for height, flat in (
        (cut.crown_height / 50, math.cos(half) * cut.table / 100),
        (cut.pavilion_depth / 50, cut.culet / 100),
    ):
        slope = height / (1 - flat)
        # Over the sectors the height above the middle of facets is slope (1 - r cos); what is cut off at the
        # top is a pyramid over an octagon of this inner radius.
        volume += slope * 16 * (half / 2 - math.sin(half) / 3) - slope * 8 / 3 * math.tan(half) * flat**3
    assert cut.stone().solid.volume == pytest.approx(volume, abs=VOLUME)


@pytest.mark.parametrize("style", ["brilliant", "modified brilliant"])
def test_the_volume_of_a_cushion_is_that_of_its_mesh(style):
    trimesh = pytest.importorskip("trimesh")
    cut = cushion.Parameters(style=style, culet=2)
    hull = trimesh.convex.convex_hull(cut.construction().points)
    assert cut.stone().solid.volume == pytest.approx(hull.volume, rel=MEASURED)


# ---- From and to the paper's proportions ---------------------------------------------------------------

PROPORTIONS = RoundBrilliant(
    table=56, star=52, lower_girdle_contact=23, crown_height=15.1, pavilion_depth=43.3, girdle_thickness=3.2
)
PARAMETERS = {
    "table": 56, "star": 52, "lower_half": 77, "crown_height": 15.1, "pavilion_depth": 43.3,
    "girdle_thickness": 3.2,
}  # fmt: skip


def test_a_plain_brilliant_is_the_stone_of_the_papers_proportions():
    stone = round_brilliant.Parameters(**PARAMETERS).stone(name="x")
    assert stone.cut == PROPORTIONS
    np.testing.assert_array_equal(stone.solid.planes, PROPORTIONS.stone().solid.planes)
    np.testing.assert_array_equal(stone.labelled_vertices, PROPORTIONS.vertices())


@pytest.mark.parametrize("kind", BRILLIANTS)
def test_planes_go_over_into_those_of_the_paper(kind):
    """Facet by facet, as painting and culet vanish."""
    paper = PROPORTIONS.stone().solid.planes
    cut = kind(**PARAMETERS, culet=0)
    assert np.abs(cut.planes() - paper).max() <= ROUNDING
    for small in (1e-3, 1e-6):
        planes = cut.planes(culet=small, crown_painting=small, pavilion_painting=-small)
        assert np.abs(planes[:-1] - paper).max() <= small
        assert planes[-1] == pytest.approx([0, 0, -1, PROPORTIONS.pavilion_depth / 50], abs=ROUNDING)


def test_contacts_state_what_lower_halves_do():
    cut = round_brilliant.Parameters(lower_half=77)
    assert cut.alternatives()["lower_girdle_contact"] == 23
    assert cut.changed(lower_girdle_contact=30).lower_half == 70


# ---- Painting and digging out --------------------------------------------------------------------------


@pytest.mark.parametrize("painting", [-4.0, -1.5, 2.0, 5.0])
@pytest.mark.parametrize(("part", "main"), [("upper_girdle", "bezel"), ("lower_girdle", "pavilion_main")])
def test_painted_halves_lean_towards_their_main(part, main, painting):
    which = "crown_painting" if main == "bezel" else "pavilion_painting"
    plain = round_brilliant.Parameters(girdle_thickness=8)
    cut = plain.changed(**{which: painting})
    half = planes_of(cut, part)[0]  # between the main at +x and where halves meet, at 22.5 deg
    assert math.degrees(math.atan2(half[1], half[0])) == pytest.approx(11.25 - painting, abs=MEASURED)
    beside, before = (angle_between(planes_of(one, part)[0], planes_of(one, main)[0]) for one in (cut, plain))
    assert (beside < before) == (painting > 0)
    # It passes through the main's girdle point, and steeper where it is dug out.
    edge = cut.girdle_thickness / 50 if main == "bezel" else 0.0
    assert height_at(half, 1, 0) == pytest.approx(edge, abs=ROUNDING)
    slopes = [abs(np.hypot(*one[:2]) / one[2]) for one in (half, planes_of(plain, part)[0])]
    assert (slopes[0] > slopes[1]) == (painting < 0)


@pytest.mark.parametrize("painting", [-4.0, 5.0])
def test_the_girdle_is_thicker_where_painted_halves_meet(painting):
    """In closed form: a plane of slope s through the main's girdle point, at the next girdle point."""
    cut = round_brilliant.Parameters(girdle_thickness=8, crown_painting=painting)
    made = cut.construction()
    half = planes_of(cut, "upper_girdle")[0]
    slope = np.hypot(*half[:2]) / half[2]
    azimuth = math.radians(11.25 - painting)
    rise = slope * (math.cos(azimuth) - math.cos(math.pi / 8 - azimuth))
    edge = made.points[made.rings["girdle_upper"], 2]
    assert edge[::2] == pytest.approx(np.full(8, 0.16), abs=ROUNDING)
    assert edge[1::2] == pytest.approx(np.full(8, 0.16 + rise), abs=ROUNDING)
    assert (rise > 0) == (painting > 0)


def test_a_girdle_that_is_dug_through_is_told_with_what_is_needed():
    dug = {"crown_painting": -6.0, "pavilion_painting": -6.0}
    with pytest.raises(InputError) as caught:
        round_brilliant.Parameters(girdle_thickness=1.0, **dug).stone()
    assert caught.value.key == "girdle_thickness"
    needed = float(str(caught.value).split("at least ")[1].split(" ")[0])
    round_brilliant.Parameters(girdle_thickness=needed + 0.01, **dug).stone()
    with pytest.raises(InputError):
        round_brilliant.Parameters(girdle_thickness=needed - 0.02, **dug).stone()


def test_a_culet_that_reaches_the_lower_halves_is_told():
    with pytest.raises(InputError, match="would reach the lower halves: for lower_half = 92 % it must be"):
        round_brilliant.Parameters(lower_half=92, culet="extremely large")


# ---- Old European cuts, corners, light -----------------------------------------------------------------


def test_the_default_old_european_cut_is_one_by_all_of_gias_criteria():
    cut = old_european.Parameters()
    assert cut.table <= 53
    assert cut.alternatives()["crown_angle"] >= 40
    assert cut.lower_half <= 60
    assert cut.culet >= CULET_WORDS["slightly large"]


def test_corners_that_are_too_round_are_told():
    with pytest.raises(InputError, match="the corners are rounder than the sides leave room for"):
        cushion_outline(1 / 1.5, 1.0, bulge=0.2, corner=0.6)


@pytest.mark.parametrize(
    "cut",
    [round_brilliant.Parameters(culet=3, crown_painting=3), single_cut.Parameters(), cushion.Parameters()],
    ids=["painted", "single", "cushion"],
)
def test_exact_scores_are_those_of_the_reference(cut):
    stone = cut.stone()
    exact, reference = score(stone), score(stone, engine="reference", resolution=PIXELS)
    assert exact.engine == "exact"
    assert exact.average == pytest.approx(reference.average, abs=MAP)
    assert exact.rear == pytest.approx(reference.rear, abs=MAP)

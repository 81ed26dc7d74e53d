"""The symmetric stone against the closed forms of the paper (docs/model.md, section 2)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tolerances import ANGLE_DEG, PLANE, PRINTED_PERCENT, ROUNDING

from gemrender.cuts import RoundBrilliant
from gemrender.cuts.round_brilliant.proportions import ANGLE_RANGES, RANGES, smallest_star
from gemrender.cuts.round_brilliant.topology import (
    CONTACT,
    CULET,
    FACET_KINDS,
    FACET_POLYGONS,
    GIRDLE_LOWER,
    GIRDLE_UPPER,
    STAR_TIP,
    TABLE_CORNER,
    VERTEX_LABELS,
)
from gemrender.errors import InputError
from gemrender.stone import Stone

# The paper's samples (docs/model.md, section 6): TB, SU, LG, CH, PD, GH.
SAMPLES = {
    "inoue-1": (62.48, 56.0, 10.40, 12.89, 46.86, 4.55),
    "inoue-2": (62.72, 56.0, 19.67, 14.09, 44.89, 5.56),
    "inoue-3": (54.00, 57.0, 20.00, 15.70, 43.08, 2.50),
}
KEYS = ("table", "star", "lower_girdle_contact", "crown_height", "pavilion_depth", "girdle_thickness")
GOOD = dict(zip(KEYS, SAMPLES["inoue-3"], strict=True))
REPORT = {
    "table": 57.0,
    "crown_angle": 34.0,
    "pavilion_angle": 40.7,
    "star": 50.0,
    "lower_half": 80.0,
    "girdle_thickness": 2.5,
}
STEP = math.pi / 8


@pytest.fixture(params=SAMPLES)
def proportions(request) -> RoundBrilliant:
    return RoundBrilliant(**dict(zip(KEYS, SAMPLES[request.param], strict=True)))


@pytest.fixture
def stone(proportions) -> Stone:
    return Stone.from_proportions(proportions)


def across(azimuth: float, point: np.ndarray) -> np.ndarray:
    """Distance from the axis, measured along an azimuth."""
    return point[..., 0] * np.cos(azimuth) + point[..., 1] * np.sin(azimuth)


# ---- Vertices ------------------------------------------------------------------------------------------


def test_vertices_are_the_papers(proportions):
    p, v = proportions, proportions.vertices()
    r_t, crown, girdle = p.table / 100, p.crown_height / 50, p.girdle_thickness / 50
    e = r_t * math.cos(STEP)
    r_s = e + p.star / 100 * (1 - e)
    z_s = girdle + crown * (1 - r_s * math.cos(STEP)) / (1 - r_t)
    r_l = p.lower_girdle_contact / 100
    z_l = -p.pavilion_depth / 50 * (1 - r_l * math.cos(STEP))
    rings = [
        (TABLE_CORNER, range(0, 16, 2), r_t, girdle + crown),
        (STAR_TIP, range(1, 16, 2), r_s, z_s),
        (GIRDLE_UPPER, range(16), 1.0, girdle),
        (GIRDLE_LOWER, range(16), 1.0, 0.0),
        (CONTACT, range(1, 16, 2), r_l, z_l),
    ]
    for rows, azimuths, radius, z in rings:
        for row, j in zip(rows, azimuths, strict=True):
            expected = (radius * math.cos(j * STEP), radius * math.sin(j * STEP), z)
            np.testing.assert_allclose(v[row], expected, rtol=0, atol=ROUNDING, err_msg=VERTEX_LABELS[row])
    assert v[CULET].tolist() == [0.0, 0.0, -p.pavilion_depth / 50]


def test_star_length_is_measured_from_the_middle_of_a_table_edge(proportions):
    v = proportions.vertices()
    edge = np.linalg.norm((v[TABLE_CORNER[0]] + v[TABLE_CORNER[1]])[:2] / 2)
    tip = np.linalg.norm(v[STAR_TIP[0], :2])
    assert 100 * (tip - edge) / (1 - edge) == pytest.approx(proportions.star, abs=100 * ROUNDING)


# ---- Facets --------------------------------------------------------------------------------------------


def test_planes_contain_their_vertices(stone):
    for facet, polygon in enumerate(FACET_POLYGONS):
        distance = stone.vertices[list(polygon)] @ stone.facet_normals[facet] - stone.facet_offsets[facet]
        assert np.abs(distance).max() < ROUNDING, FACET_KINDS[facet]


def test_every_vertex_lies_within_every_plane(stone):
    assert (stone.vertices @ stone.facet_normals.T - stone.facet_offsets).max() < ROUNDING


def test_planes_are_those_of_the_closed_forms(stone, proportions):
    """Heights of each facet's plane over the disc, from the proportions alone."""
    p, rng = proportions, np.random.default_rng(1)
    point = rng.uniform(-1, 1, size=(20, 3))
    r_t, crown, girdle = p.table / 100, p.crown_height / 50, p.girdle_thickness / 50
    depth, cos, half = p.pavilion_depth / 50, math.cos(STEP), math.cos(STEP / 2)
    e = r_t * cos
    r_s = e + p.star / 100 * (1 - e)
    drop = crown - crown * (1 - r_s * cos) / (1 - r_t)  # from the table to the star tips
    r_l = p.lower_girdle_contact / 100

    def height(kind: str, k: int) -> np.ndarray:
        main, odd, sector = (across(a * STEP, point) for a in (2 * k, 2 * k + 1, k + 0.5))
        return {
            "table": np.full(len(point), girdle + crown),
            "star": girdle + crown - drop * (odd - e) / (r_s - e),
            "bezel": girdle + crown * (1 - main) / (1 - r_t),
            # Both hold the chord between two girdle vertices, at half from the axis.
            "upper_girdle": girdle + (crown - drop) * (half - sector) / (half * (1 - r_s)),
            "lower_girdle": -depth * (1 - r_l * cos) * (half - sector) / (half * (1 - r_l)),
            "pavilion_main": -depth * (1 - main),
        }[kind]

    seen = dict.fromkeys(FACET_KINDS, 0)
    for facet in range(57):
        kind = FACET_KINDS[facet]
        n, offset = stone.facet_normals[facet], stone.facet_offsets[facet]
        z = (offset - point[:, :2] @ n[:2]) / n[2]
        np.testing.assert_allclose(z, height(kind, seen[kind]), rtol=0, atol=PLANE, err_msg=kind)
        seen[kind] += 1


def test_normals_are_outward_unit_vectors(stone):
    assert np.abs(np.linalg.norm(stone.facet_normals, axis=1) - 1).max() < ROUNDING
    assert (stone.facet_offsets > 0).all()  # the origin lies inside
    upwards = [kind in ("table", "star", "bezel", "upper_girdle") for kind in FACET_KINDS[:57]]
    assert ((stone.facet_normals[:, 2] > 0) == upwards).all()


def test_every_vertex_of_a_facet_lies_on_its_plane(stone):
    for facet, polygon in enumerate(FACET_POLYGONS):
        distance = stone.vertices[list(polygon)] @ stone.facet_normals[facet] - stone.facet_offsets[facet]
        assert np.abs(distance).max() < PLANE


def test_58_facets_of_the_right_kinds():
    counts = {kind: FACET_KINDS.count(kind) for kind in FACET_KINDS}
    assert counts == {
        "table": 1,
        "star": 8,
        "bezel": 8,
        "upper_girdle": 16,
        "lower_girdle": 16,
        "pavilion_main": 8,
        "girdle": 1,
    }


def test_main_facets_have_the_crown_and_pavilion_angles(stone, proportions):
    tilt = np.degrees(np.arccos(np.abs(stone.facet_normals[:, 2])))
    for kind, angle in (
        ("bezel", proportions.crown_angle_deg),
        ("pavilion_main", proportions.pavilion_angle_deg),
    ):
        of_kind = [f for f in range(57) if FACET_KINDS[f] == kind]
        np.testing.assert_allclose(tilt[of_kind], angle, rtol=0, atol=ANGLE_DEG)


def test_stone_is_symmetric_under_turns_of_45_degrees_and_reflection(stone):
    v = stone.vertices
    turned, mirrored = stone.rotated(45).vertices, v * (1, -1, 1)
    for other in (turned, mirrored):
        nearest = np.linalg.norm(v[:, None] - other[None], axis=-1)
        assert nearest.min(axis=1).max() < ROUNDING
    ring = np.roll(np.arange(8), 1)
    np.testing.assert_allclose(turned[TABLE_CORNER[ring]], v[TABLE_CORNER], rtol=0, atol=ROUNDING)


# ---- A laboratory's angles -----------------------------------------------------------------------------


def test_gias_reference_stone_has_the_heights_gia_prints():
    p = RoundBrilliant.from_angles(**REPORT)
    assert p.crown_height == pytest.approx(14.5, abs=PRINTED_PERCENT)
    assert p.pavilion_depth == pytest.approx(43.0, abs=PRINTED_PERCENT)
    assert p.lower_girdle_contact == 20.0


def test_tolkowskys_angles_give_his_heights():
    p = RoundBrilliant.from_angles(
        table=53, crown_angle=34.5, pavilion_angle=40.75, star=50, lower_half=60, girdle_thickness=2
    )
    assert p.crown_height == pytest.approx(16.2, abs=PRINTED_PERCENT)
    assert p.pavilion_depth == pytest.approx(43.1, abs=PRINTED_PERCENT)


def test_angles_come_back():
    p = RoundBrilliant.from_angles(**REPORT)
    assert p.crown_angle_deg == pytest.approx(34.0, abs=100 * ROUNDING)
    assert p.pavilion_angle_deg == pytest.approx(40.7, abs=100 * ROUNDING)


# ---- Refusals ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("key", KEYS)
@pytest.mark.parametrize("beyond", ["below", "above", "nan", "inf"])
def test_value_out_of_range_is_refused_with_key_value_and_range(key, beyond):
    low, high = RANGES[key]
    value = {"below": low - 0.01, "above": high + 0.01, "nan": math.nan, "inf": math.inf}[beyond]
    with pytest.raises(InputError) as caught:
        RoundBrilliant(**GOOD | {key: value})
    assert str(caught.value) == f"{key} = {value}: must be from {low:g} to {high:g} [%]"


@pytest.mark.parametrize("value", ["54", None, True, [54.0], 1j, np.array(54.0)])
def test_value_that_is_no_number_is_refused(value):
    with pytest.raises(InputError, match=r"^table = .*: must be a number from 5 to 92 \[%\]$"):
        RoundBrilliant(**GOOD | {"table": value})


def test_integer_beyond_every_float_is_refused():
    with pytest.raises(InputError, match=r"^table = 1000"):
        RoundBrilliant(**GOOD | {"table": 10**400})


@pytest.mark.parametrize("value", [54, np.float32(54), np.int64(54)])
def test_numbers_of_any_kind_become_floats(value):
    p = RoundBrilliant(**GOOD | {"table": value})
    assert type(p.table) is float
    assert p == RoundBrilliant(**GOOD)


def test_star_tip_above_the_table_is_refused_with_the_smallest_star():
    smallest = smallest_star(54.0)
    RoundBrilliant(**GOOD | {"star": smallest})
    with pytest.raises(
        InputError, match=r"^star = .*star tips would lie above the table.* at least 17\.18 %"
    ):
        RoundBrilliant(**GOOD | {"star": smallest - 0.01})


def test_a_girdle_of_next_to_no_height_is_none():
    """Its facets are lost among rounding: a stone of 6e-8 % had edges that were there twice."""
    assert RoundBrilliant(**GOOD | {"girdle_thickness": 6e-8}).girdle_thickness == 0.0
    assert RoundBrilliant(**GOOD | {"girdle_thickness": 1e-6}).girdle_thickness == 1e-6


def test_smallest_star_is_within_its_range_for_every_table():
    """A table is never refused for its star with a length that the star cannot have."""
    _, high = RANGES["star"]
    for table in np.linspace(*RANGES["table"], 50):
        assert smallest_star(float(table)) < high


@pytest.mark.parametrize("key", ["crown_angle", "pavilion_angle", "lower_half"])
def test_angle_out_of_range_is_told_in_the_reports_terms(key):
    low, high = ANGLE_RANGES[key]
    unit = "%" if key == "lower_half" else "deg"
    with pytest.raises(InputError) as caught:
        RoundBrilliant.from_angles(**REPORT | {key: high + 1})
    assert str(caught.value) == f"{key} = {high + 1}: must be from {low:g} to {high:g} [{unit}]"


def test_crown_that_would_be_too_high_is_told_by_its_angle():
    with pytest.raises(InputError, match=r"^crown_angle = 74\.0: gives a crown height of 82\.8 %; must be"):
        RoundBrilliant.from_angles(**REPORT | {"table": 52.5, "crown_angle": 74})

"""Faceters' designs: planes, names, the stone they cut."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from gemrender.cuts.asc import read_asc
from gemrender.cuts.design import MOST_FACETS, Design, Tier
from gemrender.errors import InputError
from gemrender.stone.polyhedron import intersect

CASES = Path(__file__).parents[1] / "cases" / "stones"
TRUTH = json.loads((CASES / "truth.json").read_text())
#: The solid facts of `truth.json` have eight decimals, and length to width six.
FACTS = 1e-6
#: Rounding of a few operations.
ROUNDING = 1e-14


def square(**tiers: Tier) -> Design:
    """A cube of half side 1 by four girdle facets, a table and a culet, and what is given."""
    return Design(
        tiers=(
            Tier(angle_deg=-90.0, distance=1.0, indices=(96, 24, 48, 72)),
            Tier(angle_deg=0.0, distance=1.0, indices=(96,)),
            Tier(angle_deg=-0.0, distance=1.0, indices=(96,)),
            *tiers.values(),
        )
    )


@pytest.mark.parametrize("name", TRUTH)
def test_the_solids_facts(name):
    """Counts, volume, area and length to width are those of an independent computation."""
    truth = TRUTH[name]["solid"]
    design = read_asc(CASES / TRUTH[name]["file"])
    stone = design.stone()
    sides = Counter(stone.facet_sides)
    assert (len(stone.facets), sides["crown"], sides["girdle"], sides["pavilion"]) == tuple(
        truth[key] for key in ("facets", "crown", "girdle", "pavilion")
    )
    # Truth's unit is the largest radius of the outline about the design's axis.
    body = intersect(design.planes())
    unit = float(np.hypot(*body.vertices[:, :2].T).max()) / (
        0.5 * float(np.ptp(body.vertices[:, :2], axis=0).max())
    )
    length, width, depth = (float(x) for x in np.ptp(stone.vertices, axis=0))
    up = stone.facet_normals[:, 2].clip(0.0)
    assert stone.solid.volume / unit**3 == pytest.approx(truth["volume"], rel=FACTS)
    assert float(stone.solid.areas @ up) / unit**2 == pytest.approx(truth["projected_area"], rel=FACTS)
    assert depth / unit == pytest.approx(truth["depth"], rel=FACTS)
    assert max(length, width) / min(length, width) == pytest.approx(truth["length_over_width_box"], abs=FACTS)
    assert stone.material == TRUTH[name]["refractive_index"]
    assert stone.cut == Design(**{k: getattr(design, k) for k in ("tiers", "gear", "offset", "index")} | {
        "folds": design.folds, "is_mirrored": design.is_mirrored, "notes": design.notes,
    })  # fmt: skip


def test_the_index_runs_from_y_to_x():
    """Clockwise seen from the table: index 24 of 96 is +x."""
    design = Design(tiers=(Tier(angle_deg=30.0, distance=0.5, indices=(96, 24, 12)),))
    s, c, r = 0.5, np.sqrt(0.75), np.sqrt(0.5)
    expected = [[0, s, c, 0.5], [s, 0, c, 0.5], [s * r, s * r, c, 0.5]]
    np.testing.assert_allclose(design.planes(), expected, atol=ROUNDING)


def test_a_negative_gear_runs_the_other_way_and_the_offset_is_in_teeth():
    tiers = (Tier(angle_deg=-30.0, distance=0.5, indices=(48, 24)),)
    planes = Design(tiers=tiers, gear=-96, offset=48).planes()
    np.testing.assert_allclose(planes[:, 0:2], [[0, 0.5], [0.5, 0]], atol=ROUNDING)
    assert (planes[:, 2] < 0).all()


@pytest.mark.parametrize(
    ("angle", "rise"), [(0.0, 1.0), (-0.0, -1.0), (90.0, 0.0), (-90.0, 0.0), (60.0, 0.5), (-60.0, -0.5)]
)
def test_level_and_upright_facets_are_exactly_so(angle, rise):
    planes = Design(tiers=(Tier(angle_deg=angle, distance=1.0, indices=(7.3,)),)).planes()
    assert planes[0, 2] == pytest.approx(rise, abs=0.0 if abs(rise) in (0, 1) else ROUNDING)
    assert np.hypot(*planes[0, :2]) == pytest.approx(np.sqrt(1 - rise * rise), abs=ROUNDING)


@pytest.mark.parametrize("angle", [-41.0, 33.0, -0.0, 90.0])
def test_complex_angles_and_distances_give_derivatives(angle):
    """By the complex step: d normal / d angle is the normal turned by 90 degrees [per rad]."""
    step = 1e-30
    tier = Tier(angle_deg=complex(angle, np.degrees(step)), distance=0.7 + 2j * step, indices=(5.0, 41.0))
    planes = Design(tiers=(Tier(angle_deg=angle, distance=0.7, indices=(5.0, 41.0)),)).planes()
    made = Design(tiers=(tier,)).planes()
    np.testing.assert_allclose(made.real, planes, atol=ROUNDING)
    up = -1.0 if np.signbit(angle) else 1.0
    phi = 2 * np.pi * np.array([5.0, 41.0]) / 96
    i = np.radians(angle)
    # n = (sin |i| sin phi, sin |i| cos phi, +-cos i), and |i| = +-i
    slope = np.column_stack(
        [up * np.cos(i) * np.sin(phi), up * np.cos(i) * np.cos(phi), np.full(2, -up * np.sin(i))]
    )
    np.testing.assert_allclose(made.imag[:, :3] / step, slope, atol=1e-12)
    np.testing.assert_allclose(made.imag[:, 3] / step, 2.0)


def test_names_are_unique_and_of_the_tier():
    design = Design(
        tiers=(
            Tier(angle_deg=-40.0, distance=0.6, indices=(96, 24), names=("P", "")),
            Tier(angle_deg=-40.0, distance=0.7, indices=(0, 24.5), names=("P", "")),
            Tier(angle_deg=-50.0, distance=0.6, indices=(1,)),
            Tier(angle_deg=90.0, distance=0.6, indices=(-12, 3)),
            Tier(angle_deg=30.0, distance=0.6, indices=(5, 6, 7, 8), names=("", "a", "", "b")),
            Tier(angle_deg=0.0, distance=0.3, indices=(0,)),
            Tier(angle_deg=-0.0, distance=0.3, indices=(0,)),
        )
    )
    assert design.kinds() == ("P", "P", "P", "P", "P1", "G1", "G1", "a", "a", "a", "b", "T", "K")
    assert design.facet_names() == (
        "P_96", "P_24", "P_96_2", "P_24.5", "P1", "G1_84", "G1_3", "a_5", "a_6", "a_7", "b", "T", "K",
    )  # fmt: skip


def test_a_made_name_is_none_that_is_there():
    tiers = (
        Tier(angle_deg=30.0, distance=0.6, indices=(5,)),
        Tier(angle_deg=20.0, distance=0.6, indices=(5,), names=("C1",)),
        Tier(angle_deg=0.0, distance=0.3, indices=(0,)),
        Tier(angle_deg=10.0, distance=0.3, indices=(0,), names=("T",)),
    )
    assert Design(tiers=tiers).kinds() == ("C2", "C1", "T1", "T")


def test_the_same_plane_twice_is_one_facet():
    stone = square(twice=Tier(angle_deg=90.0, distance=1.0, indices=(0, 24), names=("X",))).stone()
    assert stone.facet_names == ("G1_96", "G1_24", "G1_48", "G1_72", "T", "K")
    assert stone.notes == ("the same plane stands twice, once is used: X_96, X_24",)
    assert stone.solid.volume == pytest.approx(8.0)


def test_a_facet_that_others_cut_away_is_none():
    stone = square(away=Tier(angle_deg=45.0, distance=2.0, indices=(12, 36), names=("far",))).stone()
    assert len(stone.facets) == 6
    assert stone.notes == ("other facets cut away far_12, far_36",)


def test_planes_that_do_not_close_are_refused():
    for tiers in ((), square().tiers[:2], square().tiers[1:]):
        with pytest.raises(InputError, match=r"no facets|do not close"):
            Design(tiers=tiers).stone()


def test_the_material_given_takes_the_place_of_the_index():
    design = Design(tiers=square().tiers, index=1.76)
    assert design.stone().material == 1.76
    assert design.stone(material="spinel").material == "spinel"
    assert design.stone(material="spinel").assumed == ()
    assert square().stone().assumed == ("diamond (no refractive index in the file)",)


def test_headers_are_kept_where_they_are_asked_for_only():
    design = Design(tiers=square().tiers, headers=("Cube", "by A. Nyone"), footnotes=("A. Street 1",))
    assert design.title == "Cube"
    stone = design.stone()
    assert "Nyone" not in repr(stone.notes) + repr(stone.cut)
    stone = design.stone(with_headers=True)
    assert stone.notes == ("Cube", "by A. Nyone", "A. Street 1")
    assert stone.cut == design


def test_a_tier_can_be_changed():
    changed = square().with_tier(1, distance=0.5)
    assert changed.stone().solid.volume == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"gear": 0}, "gear = 0: must be 1 tooth or more, or negative"),
        (
            {"tiers": (Tier(angle_deg=91.0, distance=1.0, indices=(1,)),)},
            "tier 1 angle = 91.0: must be -90 to 90 degrees",
        ),
        (
            {"tiers": (Tier(angle_deg=9.0, distance=-1.0, indices=(1,)),)},
            "tier 1 distance = -1.0: must be a finite number, 0 or more",
        ),
        (
            {"tiers": (Tier(angle_deg=9.0, distance=1.0, indices=(float("nan"),)),)},
            "tier 1 indices: must be finite numbers",
        ),
        (
            {"tiers": (Tier(angle_deg=9.0, distance=1.0, indices=(1,) * (MOST_FACETS + 1)),)},
            "has 5001 facets; at most 5000 are allowed",
        ),
    ],
)
def test_what_is_no_design_is_refused(changes, told):
    with pytest.raises(InputError) as caught:
        Design(**{"tiers": (), **changes})
    assert str(caught.value) == told


def test_a_large_design_is_a_stone():
    """637 facets, the most of 2,270 designs."""
    rng = np.random.default_rng(0)
    angles = np.degrees(np.arcsin(rng.uniform(-1, 1, 637)))
    design = Design(
        tiers=tuple(
            Tier(angle_deg=float(a), distance=1.0, indices=(float(i),))
            for a, i in zip(angles, rng.uniform(0, 96, 637), strict=True)
        )
    )
    assert len(design.stone().facets) == 637

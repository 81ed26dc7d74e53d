"""Princess, radiant and trilliant: their facets, symmetry, dimensions and volumes, and what light does."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

from gemrender.cuts.families import families
from gemrender.report.measured import measured_dimensions
from gemrender.scoring import score
from gemrender.stone import Stone

PRINCESS, RADIANT, TRILLIANT = (families()[name] for name in ("princess", "radiant", "trilliant"))
#: Measured from planes, against what was asked [% or deg].
EXACT = 1e-9
#: Scores of a grid of 64 x 64 rays against exact ones [%]: 3000 rays whose intensities scatter by 35 %, three
#: times their mean's scatter.
GRID, GRID_ERROR = 64, 2.0

PRINCESS_CROWN = {"table": 1, "star": 8, "table_break": 4, "girdle_break": 4, "bezel": 4}
RADIANT_CROWN = {"table": 1, "star": 8, "table_break": 8, "girdle_break": 8}
TRILLIANT_CROWN = {"table": 1, "star": 6, "bezel": 6, "upper_girdle": 12}


def kinds(stone: Stone) -> dict[str, int]:
    return dict(Counter(facet.kind for facet in stone.facets))


def angles(cut, kind: str) -> list[float]:
    """Return the angles of the facets of a kind [deg]."""
    return [abs(tier.angle_deg) for tier in cut.tiers() if tier.names == (kind,)]


# ---- Facets --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("chevrons", "total"), [(2, 49), (3, 57), (4, 65)])
def test_facets_of_princesses(chevrons, total):
    """49, 57 or 65, with the girdle's four: mgc-labs.ru, "Princess"."""
    pavilion = {"pavilion_side": 4, "pavilion_main": 4, "chevron": 8 * chevrons}
    stone = PRINCESS(chevrons=chevrons).stone()
    assert kinds(stone) == {**PRINCESS_CROWN, "girdle": 4, **pavilion}
    assert len(stone.facets) == total
    cut = PRINCESS(chevrons=chevrons, corner=2.0, culet=2.0).stone()
    assert kinds(cut) == {**PRINCESS_CROWN, "girdle": 8, **pavilion, "culet": 1}


@pytest.mark.parametrize(("halves", "total"), [(3, 70), (2, 62)])
def test_facets_of_radiants(halves, total):
    """25 of the crown, 8 of the girdle, 37 or 29 of the pavilion with the culet: the trade's 70 and 62."""
    stone = RADIANT(halves=halves, culet=1.0).stone()
    pavilion = {"half": 8 * halves, "kite": 4, "shield": 4, "pavilion_corner": 4, "culet": 1}
    assert kinds(stone) == {**RADIANT_CROWN, "girdle": 8, **pavilion}
    assert Counter(stone.facet_sides) == {"crown": 25, "girdle": 8, "pavilion": total - 33}
    assert len(RADIANT(halves=halves).stone().facets) == total - 1


@pytest.mark.parametrize("mains", [3, 6])
def test_facets_of_trilliants(mains):
    """25 of the crown, 18 or 15 of the pavilion, and the culet."""
    stone = TRILLIANT(mains=mains, culet=2.0).stone()
    assert kinds(stone) == {
        **TRILLIANT_CROWN, "girdle": 48, "lower_girdle": 12, "pavilion_main": mains, "culet": 1
    }  # fmt: skip


@pytest.mark.parametrize(
    ("cut", "fold", "mirrors"),
    [
        (PRINCESS(), 4, 4),
        (PRINCESS(corner=2.0, culet=1.0, chevrons=2), 4, 4),
        (PRINCESS(length_to_width=1.2, corner=2.0), 2, 2),
        (RADIANT(length_to_width=1.0), 4, 4),
        (RADIANT(), 2, 2),
        (RADIANT(halves=2, length_to_width=1.0, culet=1.0), 4, 4),
        (RADIANT(halves=2), 2, 2),
        (TRILLIANT(), 3, 3),
        (TRILLIANT(corner=4.0, mains=3, culet=1.0), 3, 3),
        (TRILLIANT(length_to_width=1.05), 1, 1),
    ],
)
def test_symmetry(cut, fold, mirrors):
    symmetry = cut.stone().symmetry
    assert (symmetry.fold, len(symmetry.mirrors)) == (fold, mirrors)


# ---- Dimensions ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "cut",
    [
        PRINCESS(),
        PRINCESS(length_to_width=1.37, table=61.3, pavilion_depth=52.7, corner=3.0, culet=2.5),
        RADIANT(),
        RADIANT(halves=2, culet=1.5),
        RADIANT(length_to_width=1.45, table=61.3, crown_height=13.1, corner=9.0, culet=2.5),
        TRILLIANT(length_to_width=1.07, table=58.3, crown_height=11.1, pavilion_depth=31.7, culet=2.5),
        TRILLIANT(length_to_width=1.02, bow=12.0, corner=3.0),
        TRILLIANT(bow=9.0, crown_height=11.1, pavilion_depth=31.7),
    ],
)
def test_what_is_measured_from_the_planes_is_what_was_asked(cut):
    measured = {name: part.value for name, part in measured_dimensions(cut.stone()).items()}
    for name in ("table", "crown_height", "pavilion_depth"):
        assert measured[name] == pytest.approx(getattr(cut, name), abs=EXACT)
    total = cut.crown_height + cut.girdle_thickness + cut.pavilion_depth
    assert measured["total_depth"] == pytest.approx(total, abs=EXACT)
    if cut.length_to_width:
        assert measured["length_to_width"] == pytest.approx(cut.length_to_width, abs=EXACT)


def test_a_shorter_length_of_a_trilliant_is_its_width():
    measured = measured_dimensions(TRILLIANT(length_to_width=0.9).stone())
    assert measured["length_to_width"].value == pytest.approx(1 / 0.9, abs=EXACT)
    assert measured["table"].value == pytest.approx(TRILLIANT().table, abs=EXACT)


def test_the_sides_of_a_trilliant_are_as_long_as_their_arcs_make_them():
    """Pointed corners: length over width is that of the triangle and the height of an arc."""
    measured = measured_dimensions(TRILLIANT(bow=9.0).stone())
    assert 1 / measured["length_to_width"].value == pytest.approx(math.sqrt(0.75) + 0.09, abs=EXACT)


@pytest.mark.parametrize("corner", [0.0, 3.0])
def test_the_angles_of_a_princess_are_those_of_its_mains(corner):
    cut = PRINCESS(corner=corner, culet=1.5).changed(crown_angle=36.0, corner_angle=40.0, side_angle=58.0)
    for kind, angle in (("girdle_break", 36.0), ("pavilion_main", 40.0), ("pavilion_side", 58.0)):
        assert angles(cut, kind) == pytest.approx([angle], abs=EXACT)


def test_chevrons_of_a_princess_lie_between_its_mains_and_end_at_even_distances():
    """Of two chevrons 5, 15 and 25 % of the width from the axis (Harding, of the AGS's designs)."""
    cut = PRINCESS(chevrons=2)
    body = cut.stone().solid.polyhedron.vertices
    on_middle = body[(np.abs(body[:, 1]) < EXACT) & (body[:, 0] > EXACT) & (body[:, 2] < -EXACT)]
    assert np.sort(on_middle[:, 0]) / 2 == pytest.approx([0.05, 0.15, 0.25], abs=EXACT)
    low, high = angles(cut, "pavilion_main")[0], angles(cut, "pavilion_side")[0]
    assert all(low < angle < high for angle in angles(cut, "chevron"))


def test_the_angles_of_a_trilliant_are_those_of_its_mains():
    cut = TRILLIANT(corner=4.0).changed(crown_angle=31.0, pavilion_angle=39.0)
    for kind, angle in (("bezel", 31.0), ("pavilion_main", 39.0)):
        assert max(angles(cut, kind)) == pytest.approx(angle, abs=EXACT)


# ---- Volumes -------------------------------------------------------------------------------------------


def test_the_pavilion_of_a_princess_is_eight_cones():
    """Each with its tip in a corner, over the section through the middles of two sides: 8/3 of its half."""
    depth = 58.0
    small, large = (PRINCESS(pavilion_depth=d).stone().solid for d in (depth, 1.01 * depth))
    # All heights of the pavilion grow with its depth.
    volume = (large.volume - small.volume) / 0.01
    at = np.array([0.0, 0.1, 0.1 + 0.4 / 3, 0.1 + 0.8 / 3, 0.5, 1.0])
    planes = small.planes[small.planes[:, 2] < -EXACT]
    heights = ((planes[:, 3:] - planes[:, :1] * at) / planes[:, 2:3]).max(axis=0)
    assert volume == pytest.approx(-8 / 3 * np.trapezoid(heights, at), rel=1e-9)


@pytest.mark.parametrize(
    ("cut", "area"),
    [
        # Square of side 2 without four corners of a hundredth of it each way; rectangle without corners.
        (PRINCESS(corner=1.0), 4.0 - 2 * 0.02**2),
        (RADIANT(length_to_width=1.25, corner=10.0), 4.0 * 0.8 - 2 * 0.16**2),
    ],
)
def test_a_girdle_is_a_prism_over_the_outline(cut, area):
    thicker = cut.changed(girdle_thickness=cut.girdle_thickness + 1.0)
    added = thicker.stone().solid.volume - cut.stone().solid.volume
    assert added == pytest.approx(area * 0.02 / cut.length_to_width, rel=1e-9)


# ---- Light ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [PRINCESS, RADIANT, TRILLIANT])
def test_exact_scores_agree_with_the_reference(kind):
    stone = kind().stone()
    exact = score(stone)
    assert exact.engine == "exact"
    assert exact.bound < 1e-3
    rays = score(stone, engine="reference", resolution=GRID)
    assert rays.average == pytest.approx(exact.average, abs=GRID_ERROR)
    assert rays.rear == pytest.approx(exact.rear, abs=GRID_ERROR)

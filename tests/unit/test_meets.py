"""Meet points of designs: found, closed, and kept while tiers change; known answers of pyramids."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gemrender.cuts.asc import read_asc
from gemrender.cuts.design import Design, Tier
from gemrender.cuts.meets import KEPT, Meets, changeable
from gemrender.cuts.turning import Loose, parameter_name
from gemrender.errors import InputError

CASES = Path(__file__).parents[1] / "cases" / "stones"
#: What is solved for is there to this [unit of the design, deg].
SOLVED = 1e-11
#: Central differences over such a step [deg, unit of the design]: their second order, in shares of a slope,
#: and what is solved for over the step.
STEP, QUOTIENT, SOLVED_FOR = 1e-5, 1e-5, 1e-5
#: Rounding of distances in files [unit of the design].
EIGHT_DECIMALS = 1e-8


def box(length: float, width: float, *tiers: Tier) -> Design:
    """Return a design of a rectangular girdle, a table at 1, and these tiers."""
    return Design(
        tiers=(
            Tier(angle_deg=-90.0, distance=length, indices=(24, 72), names=("GL",)),
            Tier(angle_deg=-90.0, distance=width, indices=(48, 96), names=("GW",)),
            Tier(angle_deg=0.0, distance=1.0, indices=(96,)),
            *tiers,
        )
    )


def facets(name: str, angle: float, distance: float, *indices: float) -> Tier:
    return Tier(angle_deg=angle, distance=distance, indices=indices, names=(name,))


def pyramid(length: float, width: float, depth: float) -> Design:
    """A rectangle whose four pavilion facets meet in one point."""
    tiers = []
    for name, half, indices in (("PL", length, (24, 72)), ("PW", width, (48, 96))):
        angle = np.arctan2(depth, half)
        tiers.append(facets(name, -float(np.degrees(angle)), float(np.cos(angle) * depth), *indices))
    return box(length, width, *tiers)


def missed(design: Design, corners: list[np.ndarray]) -> float:
    """Return by how much facets miss the corner that is nearest to all of them."""
    planes, worst = design.planes().real, 0.0
    for at in corners:
        point = np.linalg.lstsq(planes[at, :3], planes[at, 3], rcond=None)[0]
        worst = max(worst, float(np.abs(planes[at, :3] @ point - planes[at, 3]).max()))
    return worst


def test_the_meets_of_a_round_brilliant():
    """Its culet; at the girdle 16 of its pavilion, 8 of these with mains, and 16 + 8 of its crown; and on
    the crown 8 of breaks, mains and stars, and 8 at the table."""
    meets = Meets(read_asc(CASES / "round.asc"))
    counts = np.bincount([len(at) for at in meets.corners])
    assert counts.tolist() == [0, 0, 0, 0, 32, 24, 0, 0, 1]
    names = meets.design.tier_names()
    of = [{names[meets.design.facet_tiers[number]] for number in at.tolist()} for at in meets.corners]
    assert sum(tiers == {"B", "C", "T"} for tiers in of) == 8
    assert sum(tiers == {"A", "B", "C"} for tiers in of) == 8
    assert sum(tiers == {"2"} for tiers in of) == 1


@pytest.mark.parametrize("path", sorted(CASES.glob("*.asc")), ids=lambda path: path.stem)
def test_meets_of_real_files_can_be_closed(path):
    """By no more than files are off: a cutter's distances have eight decimals, and slips of a few 1e-4."""
    design = read_asc(path)
    meets = Meets(design)
    assert missed(meets.design, meets.corners) < SOLVED
    for old, new in zip(design.tiers, meets.design.tiers, strict=True):
        assert new.angle_deg == pytest.approx(old.angle_deg, abs=1e-4)
        assert new.distance == pytest.approx(old.distance, abs=1e-3)
        assert (new.indices, new.names) == (old.indices, old.names)


def test_closing_changes_distances_alone_where_that_will_do():
    design = read_asc(CASES / "round.asc")
    meets = Meets(design)
    for old, new in zip(design.tiers, meets.design.tiers, strict=True):
        assert new.angle_deg == pytest.approx(old.angle_deg, abs=1e-12)
        assert new.distance == pytest.approx(old.distance, abs=EIGHT_DECIMALS)


def test_a_facet_turns_about_the_girdle_that_is_kept():
    """A square pyramid: the girdle's lower edge stays at height 0, so the distance is its half side's."""
    made = Meets(pyramid(1.0, 1.0, 0.8)).changed({(3, "angle_deg"): -42.0, (4, "angle_deg"): -42.0})
    for tier in made.tiers[3:]:
        assert tier.distance == pytest.approx(np.sin(np.radians(42.0)), abs=SOLVED)
    assert [tier.distance for tier in made.tiers[:3]] == pytest.approx([1.0, 1.0, 1.0], abs=SOLVED)


def test_the_other_angle_follows_by_the_ratio_of_tangents():
    """Facets over both sides of a rectangle meet in a point: their tangents stay as its sides."""
    meets = Meets(pyramid(1.5, 1.0, 0.9))
    made = meets.changed({(3, "angle_deg"): -33.0})
    assert np.tan(np.radians(made.tiers[4].angle_deg)) == pytest.approx(
        1.5 * np.tan(np.radians(-33.0)), abs=SOLVED
    )
    assert missed(made, meets.corners) < SOLVED
    angles, _ = meets.slopes(3, "angle_deg")
    own = np.radians(meets.design.tiers[3].angle_deg)
    other = np.radians(meets.design.tiers[4].angle_deg)
    assert angles[4] == pytest.approx(1.5 * np.cos(other) ** 2 / np.cos(own) ** 2, abs=SOLVED)


def test_two_angles_that_cannot_both_be_are_refused_by_name():
    meets = Meets(pyramid(1.5, 1.0, 0.9))
    asked = {(3, "angle_deg"): -35.0, (4, "angle_deg"): -42.0}
    with pytest.raises(InputError, match=r"^PL angle = '35': meets cannot be kept: the girdle would change$"):
        meets.changed(asked)
    outline = {(0, "distance"): 1.5, (1, "distance"): 1.0}
    with pytest.raises(InputError, match=r"keep where .*PL and PW meet$") as caught:
        meets.changed(asked | outline)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["round", "novelty-chiral", "oval"])
def test_meets_are_kept(name):
    """Every angle half a degree steeper, where it can be: exactly, with indices and the girdle's outline."""
    meets = Meets(read_asc(CASES / f"{name}.asc"))
    unit = float(np.abs(meets.design.planes()[:, 3]).max())
    made = 0
    for number, tier in enumerate(meets.design.tiers):
        if not 0 < abs(tier.angle_deg) < 90:
            continue
        angle = tier.angle_deg + (0.5 if tier.is_crown else -0.5)
        try:
            new = meets.changed({(number, "angle_deg"): angle})
        except InputError:
            continue
        made += 1
        assert new.tiers[number].angle_deg == pytest.approx(angle, abs=SOLVED)
        assert missed(new, meets.corners) < KEPT * unit
        for old, now in zip(meets.design.tiers, new.tiers, strict=True):
            assert now.indices == old.indices
            if old.side == "girdle":
                assert now.distance == pytest.approx(old.distance, abs=KEPT)
    assert made >= 4


@pytest.mark.parametrize("name", ["round", "oval", "square-barion"])
@pytest.mark.parametrize("meets", ["kept", "loose", "free"])
def test_slopes_are_those_of_designs_made_anew(name, meets):
    ways = changeable(read_asc(CASES / f"{name}.asc"), meets)
    for number, tier in enumerate(ways.design.tiers):
        quantities = ["angle_deg"] if 0 < abs(tier.angle_deg) < 90 else []
        for quantity in (*quantities, "distance"):
            value = getattr(tier, quantity)
            sides = [ways.changed({(number, quantity): value + by}) for by in (-STEP, STEP)]
            angles, distances = ways.slopes(number, quantity)
            for key, slopes in (("angle_deg", angles), ("distance", distances)):
                low, high = (np.array([getattr(of, key) for of in side.tiers]) for side in sides)
                np.testing.assert_allclose((high - low) / (2 * STEP), slopes, rtol=QUOTIENT, atol=SOLVED_FOR)


def test_a_loose_tier_turns_about_the_middle_of_its_facets():
    """The middle of a pyramid's side is a third up from its base; and no other tier moves."""
    design = pyramid(1.0, 1.0, 0.8)
    made = Loose(design).changed({(3, "angle_deg"): -45.0})
    middle = np.array([2.0 / 3.0, -0.8 / 3.0])
    assert made.tiers[3].distance == pytest.approx(
        np.sin(np.pi / 4) * middle[0] - np.cos(np.pi / 4) * middle[1], abs=SOLVED
    )
    assert made.tiers[:3] + made.tiers[4:] == design.tiers[:3] + design.tiers[4:]


def test_a_tier_that_would_cut_a_meet_away_is_named():
    """Hinged at the girdle, flatter breaks pass over the culet; the other change has no part in it."""
    meets = Meets(read_asc(CASES / "round.asc"))
    names = meets.design.tier_names()
    asked = {(names.index("1"), "angle_deg"): -41.5, (names.index("A"), "angle_deg"): 38.0}
    with pytest.raises(InputError, match=r"^1 angle = '41.5': meets cannot be kept: 1 would cut away"):
        meets.changed(asked)


def test_a_twin_of_a_facet_follows_it():
    design = pyramid(1.0, 1.0, 0.8)
    twice = replace(design, tiers=(*design.tiers, replace(design.tiers[3], names=("again",))))
    made = Meets(twice).changed({(3, "angle_deg"): -40.0})
    assert made.tiers[5].angle_deg == pytest.approx(-40.0, abs=SOLVED)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({(3, "angle_deg"): 42.0}, r"PL angle = '42': must be between 0 and 90 degrees from the girdle"),
        ({(3, "angle_deg"): -90.0}, r"PL angle = '-90': must be between 0 and 90"),
        ({(2, "angle_deg"): 1.0}, r"T angle: cannot be changed: the tier is level or upright"),
        ({(3, "distance"): -0.1}, r"PL distance = -0.1: must be a finite number, 0 or more"),
        ({(3, "distance"): float("nan")}, r"PL distance = nan: must be a finite number"),
    ],
)
@pytest.mark.parametrize("meets", ["kept", "loose", "free"])
def test_what_cannot_be_changed_is_told(changes, said, meets):
    with pytest.raises(InputError, match=said):
        changeable(pyramid(1.0, 1.0, 0.8), meets).changed(changes)


def test_there_are_three_ways():
    with pytest.raises(InputError, match="meets = 'tight': must be one of free, loose, kept"):
        changeable(pyramid(1.0, 1.0, 0.8), "tight")
    assert parameter_name(pyramid(1.0, 1.0, 0.8), 4, "distance") == "PW distance"

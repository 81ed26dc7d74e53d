"""What is true of every family over the whole range of its parameters: closed, convex, meeting, as asked."""

from __future__ import annotations

from dataclasses import MISSING, fields

import numpy as np
import pytest
from thorough import chosen

from gemrender.cuts.construction.meet_points import LEAST_SHARE, MEET
from gemrender.cuts.design import Design
from gemrender.cuts.families import families
from gemrender.cuts.families.family import Family
from gemrender.errors import InputError
from gemrender.stone import tessellate
from gemrender.stone.frame import in_frame
from gemrender.stone.polyhedron import intersect
from tests.solids import assert_closed

FAMILIES = {name: kind for name, kind in families().items() if issubclass(kind, Family)}
#: Lengths after a hundred operations on numbers of order 1.
ROUNDING = 1e-12
#: Step of central differences [% or deg], and their error against exact derivatives: third derivatives times
#: its square, and rounding over it.
STEP, DIFFERENCE = 1e-4, 1e-6
#: Step of the complex step: its square is 0.
TINY = 1e-30


def draw(kind: type[Family], rng: np.random.Generator) -> dict:
    """Draw values of all parameters from their whole ranges, now and then from their ends."""
    drawn = {}
    for part in fields(kind):
        if "allowed" in part.metadata:
            allowed = part.metadata["allowed"]
            drawn[part.name] = allowed[rng.integers(len(allowed))]
        else:
            assert not part.metadata["many"]
            ends = part.metadata["range"]
            special = [*ends, *([0.0] * 5 if part.metadata["or_zero"] else [])]
            is_special = rng.random() < 0.05 * len(special)
            drawn[part.name] = special[rng.integers(len(special))] if is_special else rng.uniform(*ends)
    return drawn


@pytest.mark.parametrize("kind", FAMILIES.values(), ids=FAMILIES)
def test_every_parameter_has_a_default_and_the_family_alone_is_a_stone(kind):
    assert all(part.default is not MISSING for part in fields(kind))
    stone = kind().stone()
    assert_closed(tessellate(stone))
    # A brilliant that the paper's proportions describe keeps these as its cut.
    assert stone.cut in (kind(), getattr(kind(), "proportions", kind)())


@pytest.mark.parametrize("examples", chosen([20, 200], [20]))
@pytest.mark.parametrize("kind", FAMILIES.values(), ids=FAMILIES)
def test_over_the_whole_range_it_is_a_convex_stone_or_one_line(kind, examples):
    made, refused = 0, []

    rng = np.random.default_rng(1)
    for _ in range(examples):
        try:
            cut = kind(**draw(kind, rng))
            stone = cut.stone()
        except InputError as error:
            refused.append(str(error))
            continue
        made += 1
        construction = cut.construction()
        planes, points = construction.planes, construction.points
        above = points @ planes[:, :3].T - planes[:, 3]
        assert above.max() <= MEET
        for number, corners in enumerate(construction.corners):
            assert np.abs(above[list(corners), number]).max() <= MEET
        assert len(set(stone.facet_names)) == len(stone.facets)
        if stone.is_round:
            continue
        body = intersect(planes)
        # Every facet bounds the stone, and meets others in the very points that were placed.
        assert body.bounds.all()
        apart = np.abs(body.vertices[:, None] - points[None]).max(axis=2)
        assert apart.min(axis=1).max() <= MEET
        assert np.abs(in_frame(planes)[0] - planes).max() <= MEET
        outline = body.crosses[planes[:, 2] > MEET, 2].sum()
        free = np.array([kind in ("girdle", "culet") for kind in construction.kinds])
        assert body.areas[~free].min() >= LEAST_SHARE * outline * (1 - ROUNDING)
    assert made >= examples // 3
    assert not any("\n" in line for line in refused)


@pytest.mark.parametrize("kind", FAMILIES.values(), ids=FAMILIES)
@pytest.mark.parametrize("thickness", [0.0, 1e-12, 1e-8])
def test_a_girdle_of_next_to_no_height_is_one_line(kind, thickness):
    """Its facets would be lost among rounding; a round one is a cylinder, and may have none."""
    if kind.IS_ROUND:
        kind(girdle_thickness=thickness)
        return
    with pytest.raises(InputError, match=r"girdle.* (would vanish|meet)"):
        kind(girdle_thickness=thickness).stone()


@pytest.mark.parametrize("kind", FAMILIES.values(), ids=FAMILIES)
def test_derivatives_of_planes_are_those_of_differences(kind):
    """By every parameter and every alternative, from the middle of the defaults and a little way off."""
    cut = kind()
    for name, value in (cut.values() | cut.alternatives()).items():
        if isinstance(value, int | str):
            continue
        if name in cut.values():
            low, high = kind.__dataclass_fields__[name].metadata["range"]
            value = min(max(value, low + 0.01 * (high - low)), high - 0.01 * (high - low))
        exact = cut.planes(**{name: complex(value, TINY)})
        sides = [cut.planes(**{name: value + by}) for by in (-STEP, STEP)]
        difference = (sides[1] - sides[0]) / (2 * STEP)
        assert np.abs(exact.imag / TINY - difference).max() <= DIFFERENCE, name
        # The faceter's tiers of it are the same planes, with the same derivatives.
        tiers = Design(tiers=cut.tiers(**{name: complex(value, TINY)})).planes()
        place = [int(np.abs(exact.real - plane.real).max(axis=1).argmin()) for plane in tiers]
        assert sorted(place) == list(range(len(exact)))
        assert np.abs(tiers.real - exact.real[place]).max() <= ROUNDING
        assert np.abs(tiers.imag - exact.imag[place]).max() / TINY <= 1e-9


@pytest.mark.parametrize("kind", FAMILIES.values(), ids=FAMILIES)
def test_alternatives_lead_back_to_the_parameters(kind):
    cut = kind()
    for name, value in cut.alternatives().items():
        back = cut.changed(**{name: value}).values()
        words = {key for key, said in back.items() if isinstance(said, str)}
        assert {key: back.pop(key) for key in words} == {key: cut.values()[key] for key in words}
        assert back == pytest.approx({key: cut.values()[key] for key in back}, rel=ROUNDING)

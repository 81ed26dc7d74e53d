"""The exact engine on convex solids of any kind: no girdle, no cylinder, no symmetry, many corners."""

from __future__ import annotations

from contextlib import contextmanager

import numpy as np
import pytest
from designs_help import level, ring, stone_of
from exact_tolerances import TILING
from physics_tolerances import ROUNDING

from gemrender.beam import Budget, beam_stone, measure, trace_facets
from gemrender.beam.measure import facet_sums
from gemrender.beam.view_area import view_area
from gemrender.observation import REAR_RULES, Model, View
from gemrender.scoring import score
from gemrender.stone import Stone

ROUND_TABLE = 128
#: What pixels of the reference's map are off by, on stones of this kind [%].
SAMPLING = 0.4


def step_cut(sides: int = 4, *, stretch: float = 1.0, start: float = 0.5) -> Stone:
    """A crown and a pavilion of two steps each, on an upright girdle."""
    steps = [(35.0, 0.80), (20.0, 0.52), (-48.0, 0.80), (-41.0, 0.72), (90.0, 1.0)]
    rings = [ring(sides, slope, offset, stretch=stretch, start=start) for slope, offset in steps]
    return stone_of(np.concatenate([*rings, level(0.42)]), name=f"{sides} sides")


def skew() -> Stone:
    """Turned crown steps: a rotation and no mirror plane."""
    rings = [
        ring(4, 35.0, 0.8, start=0.6),
        ring(4, 20.0, 0.52, start=0.5),
        ring(4, -45.0, 0.75),
        ring(4, 90.0, 1.0),
    ]
    return stone_of(np.concatenate([*rings, level(0.42)]), name="skew")


def lopsided() -> Stone:
    """No symmetry at all, and no girdle."""
    planes = np.concatenate([ring(5, 38.0, 0.7), ring(5, -44.0, 0.7, start=0.3), level(0.45)])
    planes[:, 3] += np.linspace(0.0, 0.05, len(planes))
    return stone_of(planes, name="lopsided")


STONES = {
    "square": (step_cut, 8),
    "emerald": (lambda: step_cut(stretch=1.4), 4), "triangle": (lambda: step_cut(3), 6),
    "hexagon": (lambda: step_cut(6), 12), "skew": (skew, 1), "lopsided": (lopsided, 1),
}  # fmt: skip


def off_centre(stone: Stone) -> Stone:
    """Return a stone moved sideways, as a bounding box that is not centred on the axis moves it."""
    planes = stone.solid.planes.copy()
    planes[:, 3] += planes[:, :3] @ [0.2, -0.1, 0.0]
    return stone_of(planes, name="off centre")


class Coarse(Budget):
    """A budget that leaves polygons below a hundredth of the view to rays."""

    @contextmanager
    def polygon_limits(self):
        yield np.array([1e-2, np.inf, 0.0])


@pytest.fixture(params=STONES)
def case(request):
    make, parts = STONES[request.param]
    return make(), parts


@pytest.fixture(scope="module")
def cube():
    return stone_of(np.concatenate([ring(4, 90.0, 1.0, start=0.0), level(1.0), level(1.0, down=True)]))


def test_light_goes_straight_through_a_cube(cube):
    """In and out along the normals; seen by direction and by facet, all of it is rear light."""
    for rear in ("facet", "direction"):
        found = measure(cube, model=Model(index=1.54, fresnel="exact", rear=rear))
        assert (found.rear, found.average) == (pytest.approx(100), 0)
    facets = trace_facets(cube, model=Model(index=1.54, fresnel="exact"))
    assert (facets.paths.cos_entry, facets.paths.cos_exit) == pytest.approx((1, 1), abs=ROUNDING)


def test_the_area_of_a_cubes_view(cube):
    assert measure(cube).area == pytest.approx(4, abs=TILING)
    for azimuth in (0.0, 30.0):
        view = View(resolution=1, tilt_deg=30, tilt_azimuth_deg=azimuth)
        turn, tilt = np.radians([azimuth, 30.0])
        seen = 4 * (np.cos(tilt) + np.sin(tilt) * (np.cos(turn) + np.sin(turn)))
        assert measure(cube, view=view).area == pytest.approx(seen, abs=TILING)


@pytest.mark.parametrize("tilt", [0, 15])
def test_no_ray_is_needed_and_nothing_is_lost(case, tilt):
    stone, _ = case
    view = View(resolution=1, tilt_deg=tilt, tilt_azimuth_deg=90)
    found, facets = measure(stone, view=view), trace_facets(stone, view=view)
    assert found.rays == 0
    assert found.bound == pytest.approx(found.trapped + found.lost)
    assert found.trapped < 1e-6
    assert np.isfinite(facets.exit_map).all()  # beams along a plane never meet it
    assert facets.area.sum() == pytest.approx(view_area(beam_stone(stone), view), abs=TILING)
    assert found.bands.sum() + found.rear + found.trapped + found.lost == pytest.approx(100, abs=1e-9)


@pytest.mark.parametrize("move", [lambda stone: stone, off_centre], ids=["centred", "off centre"])
def test_a_part_between_mirrors_stands_for_the_whole(case, move):
    stone, parts = case
    stone = move(stone)
    for rear in REAR_RULES:
        model = Model.of(stone, rear=rear)
        whole, part = trace_facets(stone, model=model), trace_facets(stone, model=model, whole=False)
        assert part.parts == parts
        np.testing.assert_allclose(parts * facet_sums(part), facet_sums(whole), rtol=0, atol=TILING)
        assert part.images()[part.is_counted].sum() == whole.is_counted.sum()


@pytest.mark.parametrize("tilt", [0, 15])
def test_the_reference_agrees(case, tilt):
    stone, _ = case
    exact = score(stone, engine="exact", tilt=tilt)
    seen = score(stone, engine="reference", tilt=tilt, resolution=200)
    assert exact.average == pytest.approx(seen.average, abs=SAMPLING)
    assert exact.rear == pytest.approx(seen.rear, abs=SAMPLING)


def test_facets_may_have_any_number_of_corners():
    """A table of 128 corners, and as many sides: nothing is cut off."""
    planes = np.concatenate(
        [
            ring(ROUND_TABLE, 35.0, 0.72),
            ring(ROUND_TABLE, -42.0, 0.74),
            ring(ROUND_TABLE, 90.0, 1.0),
            level(0.45),
        ]
    )
    facets = trace_facets(stone_of(planes))
    assert np.diff(facets.covered_ends, prepend=0).max() == ROUND_TABLE
    assert facets.area.sum() == pytest.approx(ROUND_TABLE * np.tan(np.pi / ROUND_TABLE), abs=TILING)
    assert facets.unaccounted < TILING


def test_637_facets_within_the_memory_of_a_score():
    """As many as a real design has: planes that touch an ellipsoid, seven rings and a table."""
    slopes = (62.0, 48.0, 35.0, 90.0, -50.0, -43.0, -35.0)
    rings = [
        ring(
            91 - (k == 6), slope, float(np.hypot(np.sin(np.radians(slope)), 0.6 * np.cos(np.radians(slope))))
        )
        for k, slope in enumerate(slopes)
    ]
    stone = stone_of(np.concatenate([*rings, level(0.55)]))
    assert (stone.solid.n_facets, stone.solid.areas.min() > 0) == (637, True)
    found = measure(stone, bound=0.5, budget=Budget(3600.0, 1.0))
    assert (found.rays, found.notes) == (0, ())
    assert found.bound < 1e-6


def test_what_is_past_the_budget_single_rays_tell(case):
    """Without a cylinder there are rays only then, and their scatter is in the bound."""
    stone, _ = case
    view = View(resolution=1, tilt_deg=15, tilt_azimuth_deg=90)
    truth, found = measure(stone, view=view), measure(stone, view=view, bound=0.5, budget=Coarse(3600.0, 1.0))
    assert found.rays > 0
    assert found.notes[0].startswith("virtual facets of ")
    for ours, theirs in zip(
        (found.average, found.rear, *found.bands), (truth.average, truth.rear, *truth.bands), strict=True
    ):
        assert abs(ours - theirs) <= found.bound + truth.bound

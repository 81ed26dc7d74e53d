"""Budgets of exact scores: what is past them is told, and the bound that is left is true."""

from __future__ import annotations

import io
import sys
import time
from contextlib import contextmanager

import numpy as np
import pytest
from beam_help import TOLD_AREA
from exact_tolerances import TILING
from physics_tolerances import THREE_SIGMA
from rich.console import Console
from thorough import chosen

from gemrender.beam import Budget, FacetStatus, MemoryBudget, beam_stone, check_limits, measure, trace_facets
from gemrender.beam.budget import MEMORY_RANGE, PAUSED, TIME_RANGE
from gemrender.beam.maps import observe
from gemrender.beam.sensitivity import sensitivity
from gemrender.cuts import RoundBrilliant, load_stone
from gemrender.engines import require_engine
from gemrender.errors import InputError
from gemrender.observation import MAP_TYPES, Model, View, bound_text
from gemrender.reference.tracer import START_DISTANCE, trace
from gemrender.report.formats import print_tables
from gemrender.report.tables import score_table
from gemrender.scoring import score, score_measurement
from gemrender.stone import Stone, tessellate

STONE = load_stone("inoue-2")
#: No time left, however often one asks.
NONE = (0.0,) * 100
#: Seconds and GiB that no test comes near.
PLENTY = (3600.0, 64.0)


class Fixed(Budget):
    """Limits of polygons that do not depend on the clock, and what it says of the time for rays."""

    def __init__(self, smallest=0.0, held=np.inf, seconds_left=()):
        super().__init__(5.0, 1.0)
        self._limits, self._left = np.array([smallest, held, 0.0]), iter(seconds_left)

    @property
    def left(self):
        return next(self._left, 1e6)

    @contextmanager
    def polygon_limits(self):
        yield self._limits


def many_facets() -> tuple[Stone, View]:
    """Return a stone, seen from the side, that falls into more polygons than memory holds, and its view."""
    flat = RoundBrilliant(
        table=22.85522684315765, star=41.35319692819073, lower_girdle_contact=99.0, crown_height=0.5,
        pavilion_depth=2.0, girdle_thickness=0.01,
    )  # fmt: skip
    stone = Stone.from_proportions(flat, name="flat", material=1.77)
    return stone, View.of(stone, 1, tilt_deg=89, tilt_azimuth_deg=340.97)


# ---- What is allowed -----------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf"), True, "long", None])
@pytest.mark.parametrize("key", ["time", "memory"])
def test_a_limit_out_of_range_is_refused(key, value):
    low, high = {"time": TIME_RANGE, "memory": MEMORY_RANGE}[key]
    with pytest.raises(InputError, match=rf"^{key} = .*: must be from {low:g} to {high:g} \["):
        check_limits(**{"time_limit": 1.0, "memory_limit": 1.0, f"{key}_limit": value})
    with pytest.raises(InputError, match=f"^{key} = "):
        score(STONE, **{f"{key}_limit": value})


def test_other_engines_make_no_use_of_them():
    assert score(STONE, engine="reference", resolution=8, time_limit=-1).notes == ()


# ---- Within the budget ---------------------------------------------------------------------------------


def test_time_in_which_kernels_are_compiled_does_not_count():
    """A first score is the same as later ones, however long compiling takes."""
    budget = Budget(60.0, 1.0)
    with PAUSED.compiling(), PAUSED.compiling():
        before = budget.seconds
        end = time.process_time() + 0.05
        while time.process_time() < end:
            pass
        assert budget.seconds - before < 0.025
    assert budget.seconds - before < 0.025
    while budget.seconds - before < 0.05:  # and then it runs on
        pass


def test_a_score_within_its_budget_is_the_one_without():
    free, limited = (measure(STONE, budget=budget) for budget in (None, Budget(*PLENTY)))
    assert (free.average, free.rear, free.bound) == (limited.average, limited.rear, limited.bound)
    np.testing.assert_array_equal(free.sizes, limited.sizes)
    assert free.notes == limited.notes == ()


# ---- Past it -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("smallest", "held"), [(1e-4, np.inf), (np.inf, np.inf), (0.0, 1e4)])
def test_polygons_that_are_left_over_are_told_by_rays(smallest, held):
    """Nothing of the view is lost, and the score is the stone's, within its bound."""
    budget = Fixed(smallest, held)
    facets = trace_facets(STONE, budget=budget)
    assert facets.left_over > 0
    assert facets.area.sum() == pytest.approx(TOLD_AREA, abs=TILING)
    whole = trace_facets(STONE)
    near = [f.area[f.status == FacetStatus.GIRDLE].sum() for f in (facets, whole)]
    assert near[0] > near[1]
    assert facets.is_counted.sum() < whole.is_counted.sum()
    truth, found = measure(STONE, bound=0.01), measure(STONE, bound=0.1, budget=budget)
    for ours, theirs in zip(
        (found.average, found.rear, *found.bands), (truth.average, truth.rear, *truth.bands), strict=True
    ):
        assert abs(ours - theirs) <= found.bound + truth.bound
    assert found.notes[0].startswith("virtual facets of ")
    limit = "memory limit of 1 GiB" if np.isfinite(held) else "time limit of 5 s"
    assert found.notes[0].endswith(f" % of the view left to single rays: the {limit} was reached")


def test_rays_end_with_the_time_and_say_so():
    found = measure(STONE, bound=1e-3, budget=Fixed(seconds_left=NONE))
    assert found.bound > 1e-3
    assert found.notes == (
        f"bound {bound_text(found.bound)} instead of 0.001: the time limit of 5 s was reached",
    )
    truth = measure(STONE, bound=0.01)
    assert abs(found.average - truth.average) <= found.bound + truth.bound


def test_rays_go_as_far_as_the_time():
    few, more = (measure(STONE, bound=1e-3, budget=Fixed(seconds_left=s)) for s in (NONE, (1.0, *NONE)))
    assert more.rays > few.rays


def test_maps_past_the_budget_are_those_within_it():
    """What polygons leave over, single rays tell, pixel by pixel."""
    view = View.of(STONE, 64)
    within, past = (observe(STONE, view, bound=5.0, budget=budget) for budget in (None, Budget(*PLENTY)))
    for name in MAP_TYPES:
        np.testing.assert_array_equal(getattr(within, name), getattr(past, name))
    tilted = View.of(STONE, 64, tilt_deg=10)
    within, past = (
        observe(STONE, tilted, bound=5.0, budget=budget) for budget in (None, Fixed(smallest=np.inf))
    )
    assert past.measured.girdle > 99
    few = within.reflections <= 20
    np.testing.assert_array_equal(within.path_code[few], past.path_code[few])
    np.testing.assert_allclose(within.primary_intensity[few], past.primary_intensity[few], rtol=0, atol=1e-3)


#: Scores of `many_facets` by random rays, and their standard errors [%]; the reference tracer has them too.
AVERAGE, REAR = (35.57, 0.08), (59.46, 0.07)


def test_a_stone_of_many_facets_ends_with_a_true_bound():
    """Without limits it takes gigabytes."""
    stone, view = many_facets()
    require_engine("exact")  # compiled before the clock runs
    found = measure(beam_stone(stone), view=view, budget=Budget(0.5, 0.125))
    assert abs(found.average - AVERAGE[0]) <= AVERAGE[1] + found.bound
    assert abs(found.rear - REAR[0]) <= REAR[1] + found.bound
    assert 0.05 < found.bound < 5
    assert len(found.notes) == 2


@pytest.mark.parametrize("rays", chosen([4_000, 200_000], [4_000]))
def test_the_reference_tracer_has_these_scores(rays, rng):
    """By random rays over the narrow box that the stone fills of its view."""
    stone, view = many_facets()
    eye = view.basis()[2]
    across = np.cross([0.0, 0.0, 1.0], eye)
    axes = np.stack([across / np.linalg.norm(across), np.cross(eye, across) / np.linalg.norm(across)])
    corners = tessellate(stone).vertices @ axes.T
    points = rng.uniform(corners.min(axis=0), corners.max(axis=0), (rays, 2)) @ axes + START_DISTANCE * eye
    seen = trace(stone, points, np.broadcast_to(-eye, points.shape), Model.of(stone))
    met = seen.coverage > 0
    assert met.mean() > 0.5
    for values, (right, error) in ((seen.primary_intensity, AVERAGE), (100.0 * seen.rear_mask, REAR)):
        of_rays = values[met].std() / np.sqrt(met.sum())
        assert abs(values[met].mean() - right) <= THREE_SIGMA * np.hypot(of_rays, error)


def test_derivatives_of_such_a_stone_are_refused_in_one_line():
    stone, view = many_facets()
    require_engine("exact")
    with pytest.raises(InputError, match="flat: falls into more virtual facets than can be differentiated"):
        sensitivity(stone, view=view, time_limit=2.0)


# ---- Bounds that are missed for other reasons ----------------------------------------------------------


def test_trapped_light_is_a_reason():
    (note,) = measure(STONE, model=Model(max_reflections=2), bound=0.1).notes
    assert note.startswith("bound ")
    assert note.endswith(" % of the light was still inside after all reflections that are followed")


def test_too_few_rays_are_a_reason(monkeypatch):
    monkeypatch.setattr(sys.modules["gemrender.beam.measure"], "MOST_RAYS", 64)
    (note,) = measure(STONE, bound=1e-3).notes
    assert note.endswith(" instead of 0.001: no more than 1024 rays are followed")


# ---- How it is told ------------------------------------------------------------------------------------


def test_notes_are_in_the_score_its_json_and_its_table():
    view, model = View(resolution=1), Model.of(STONE)
    told = score_measurement(measure(STONE, bound=1e-3, budget=Fixed(seconds_left=NONE)), STONE, view, model)
    assert list(told.to_dict())[-1] == "notes"
    assert told.to_dict()["notes"] == list(told.notes)
    console = Console(width=200, file=io.StringIO())
    print_tables([score_table([told])], console)
    text = console.file.getvalue()
    assert f"{STONE.name}: {told.notes[0]}." in text
    assert f"every figure within ±{bound_text(told.bound)}." in text


@pytest.mark.parametrize(
    ("bound", "text"),
    [
        (0.0349, "0.035"), (0.0301, "0.031"), (0.05, "0.05"), (0.00126, "0.0013"), (0.0996, "0.1"),
        (0.255, "0.26"), (1.23, "1.3"), (12.3, "13"), (1e-4, "0.0001"), (4e-13, "0.0001"), (0.0, "0.0001"),
    ],
)  # fmt: skip
def test_a_bound_in_words_is_never_smaller_than_it_is(bound, text):
    assert bound_text(bound) == text
    assert float(text) >= bound


# ---- Memory alone --------------------------------------------------------------------------------------


def test_a_budget_of_memory_counts_no_time_and_keeps_to_its_memory():
    budget = MemoryBudget(0.25)
    time.sleep(0.01)
    assert budget.left == TIME_RANGE[1]
    with budget.polygon_limits() as limits, Budget(TIME_RANGE[1], 0.25).polygon_limits() as expected:
        np.testing.assert_array_equal(limits, expected)
    plain, within = measure(STONE, bound=1.0), measure(STONE, bound=1.0, budget=budget)
    assert (within.average, within.bound, within.notes) == (plain.average, plain.bound, ())

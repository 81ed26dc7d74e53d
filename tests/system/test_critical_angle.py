"""Facets at exactly the critical angle: every tracer reflects all light there, whichever way it rounds."""

from __future__ import annotations

import numpy as np
import pytest
from critical import INDICES, at_critical_angle
from thorough import some

import gemrender.render.observe as by_mitsuba
from gemrender.beam import beam_stone, measure
from gemrender.beam.compiled import STEP
from gemrender.beam.maps import observe as by_beams
from gemrender.beam.sensitivity import facet_totals, proportion_planes
from gemrender.crosscheck import LONG_PATH, crosscheck
from gemrender.observation import Model, RayStatus, View
from gemrender.reference import observe as by_reference

#: Just beyond the critical angle [deg], where no tolerance counts: edges have moved by less than 1e-6 girdle
#: radii, and scores by less than 1e-4 %.
BEYOND_DEG, MOVED_PERCENT = 1e-5, 1e-4
#: Differences to one side, of a function whose slope changes as fast as it likes [relative].
ONE_SIDED = 1e-3


@pytest.mark.parametrize("index", some(INDICES, 2))
def test01_all_tracers_take_the_same_side(index, variant_llvm_ad_mono):
    """Rationale: rays meet the mains a few roundings to either side of the critical angle.

    Expected: the cross-check passes, ray by ray. Longer paths, where tracers part of any stone, end trapped.
    """
    stone = at_critical_angle(index)
    view, model = View.of(stone, 64), Model(index=index, fresnel="exact", max_reflections=LONG_PATH)
    rays = by_mitsuba.sensor_rays(view, variant="llvm_ad_mono")
    truth = by_reference(stone, view, model, rays=rays)
    for seen in (by_mitsuba.observe(stone, view, model), by_beams(stone, view, model, bound=5.0, rays=rays)):
        assert crosscheck(seen, truth).failures == []
    assert (truth.status != RayStatus.LOST).all()


@pytest.mark.parametrize("index", INDICES)
def test02_the_score_is_the_limit_from_above(index):
    """Rationale: at the critical angle itself all light is reflected, as beyond it."""
    at, beyond, below = (
        measure(beam_stone(at_critical_angle(index, by)), bound=0.2) for by in (0.0, BEYOND_DEG, -BEYOND_DEG)
    )
    assert at.average == pytest.approx(beyond.average, abs=MOVED_PERCENT + at.bound + beyond.bound)
    assert at.rear == pytest.approx(beyond.rear, abs=MOVED_PERCENT + at.bound + beyond.bound)
    assert abs(at.rear - below.rear) > 1  # the mains leak at once


def test03_the_issues_stone_has_its_scores():
    """Computed independently, by the limit from above: Average 30.5, Rear 43.9."""
    found = measure(beam_stone(at_critical_angle(2.0)))
    assert found.average == pytest.approx(30.5, abs=0.05 + found.bound)
    assert found.rear == pytest.approx(43.9, abs=0.05 + found.bound)


def test04_derivatives_are_those_from_above():
    """Rationale: a stone at the critical angle is differentiated as one beyond it, where sums are smooth."""
    stone = at_critical_angle(2.0)
    slopes = (
        facet_totals(beam_stone(stone), proportion_planes(stone.proportions, "pavilion_depth")).imag / STEP
    )
    sums, depths = [], []
    for beyond_deg in (0.0, 1e-5):
        moved = at_critical_angle(2.0, beyond_deg)
        sums.append(facet_totals(beam_stone(moved), beam_stone(moved).solid.planes))
        depths.append(moved.proportions.pavilion_depth)
    difference = (sums[1] - sums[0]) / (depths[1] - depths[0])
    np.testing.assert_allclose(slopes, difference, rtol=0, atol=ONE_SIDED * np.abs(slopes).max())

"""Derivatives of exact scores by the parameters of families, against differences of exact scores."""

from __future__ import annotations

import numpy as np
import pytest

import gemrender
from gemrender.beam import beam_stone
from gemrender.beam.by_parameters import changes_of
from gemrender.beam.compiled import STEP
from gemrender.beam.sensitivity import facet_totals, sensitivity
from gemrender.cuts.families import families
from gemrender.cuts.families.family import Family
from gemrender.errors import InputError
from gemrender.observation import Model
from tests.exact_tolerances import DERIVATIVE

FAMILIES = {name: kind for name, kind in families().items() if issubclass(kind, Family)}
POLYGONAL = {name: kind for name, kind in FAMILIES.items() if not kind().stone().is_round}
#: Fewer virtual facets than diamond has, and light that is reflected more often left out.
MODEL = Model(index=1.77, fresnel="exact", max_reflections=6)
#: Steps of central differences [% or deg]: scores jump where facets reach the critical angle, small steps
#: have rounding; the one that agrees best counts.
STEPS = (1e-6, 1e-7, 1e-8)


def has_room(change, stone):
    """Whether it can become smaller and larger: some are as small as they may be."""
    try:
        return all(change.moved(stone, by) for by in (-STEPS[0], STEPS[0]))
    except InputError:
        return False


@pytest.mark.parametrize("name", POLYGONAL)
def test_derivatives_are_central_differences(name):
    """Of each family by one parameter, another one in each; planes are held for all of them elsewhere."""
    cut = POLYGONAL[name]()
    stone = cut.stone()
    changes = [change for change in changes_of(cut) if has_room(change, stone)]
    change = changes[list(POLYGONAL).index(name) % len(changes)]
    ready = beam_stone(stone)
    slopes = facet_totals(ready, change.planes(cut), model=MODEL).imag / STEP
    errors = []
    for step in STEPS:
        low, high = (
            facet_totals(ready, change.moved(stone, by).solid.planes, model=MODEL) for by in (-step, step)
        )
        errors.append(np.abs((high - low) / (2 * step) - slopes).max() / np.abs(slopes).max())
        if errors[-1] <= DERIVATIVE:
            break
    assert min(errors) <= DERIVATIVE, change


def test_angles_stay_where_they_are_kept():
    cut = FAMILIES["oval"]()
    kept = {(change.parameter, change.kept): change for change in changes_of(cut)}
    stone = kept["table", "angles"].moved(cut.stone(), 1.0)
    assert stone.cut.table == cut.table + 1.0
    assert stone.cut.alternatives()["crown_angle"] == pytest.approx(cut.alternatives()["crown_angle"])
    assert stone.cut.crown_height < cut.crown_height
    assert kept["table", "proportions"].moved(cut.stone(), 1.0).cut.crown_height == cut.crown_height


def test_a_round_girdle_has_bounds():
    """Near a round girdle rays tell how light changes: a difference of scores lies within the bounds."""
    cut = FAMILIES["single cut"]()
    found = sensitivity(cut.stone(), bound=5.0, parameters=[("girdle_thickness", "proportions")])
    (derivative,) = found.derivatives
    step = 0.04
    low, high = (
        gemrender.score(cut.changed(girdle_thickness=cut.girdle_thickness + by).stone(), bound=0.02)
        for by in (-step, step)
    )
    for key in ("average", "rear"):
        slope = (getattr(high, key) - getattr(low, key)) / (2 * step)
        allowed = getattr(derivative, f"{key}_bound") + (low.bound + high.bound) / (2 * step)
        assert abs(getattr(derivative, key) - slope) <= allowed

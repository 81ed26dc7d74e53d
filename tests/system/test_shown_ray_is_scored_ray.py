"""The ray that is shown for a point of the map is the ray that was scored there.

Rationale: rays are drawn by the reference tracer's `full_paths`; maps are traced pixel by pixel, by Mitsuba
or by the reference. Expected: for 1000 pixels of each map the path drawn through the pixel's centre has the
same facet sequence, the same exit facet and the same intensity.
"""

from __future__ import annotations

import numpy as np
import pytest
from any_stones import design, hollow_stone
from displays_help import measured_stone
from thorough import some

from gemrender.cuts import load_stone
from gemrender.engines import observe
from gemrender.observation import PATH_CODE_FACTOR, PATH_CODE_MASK, RayStatus
from gemrender.reference import full_paths
from gemrender.report.displays.rays import check_points

PIXELS = 1000
RESOLUTION = 256

#: A reference observation keeps float64 intensities of at most 100 % in single precision: half a unit in the
#: last place of numbers from 64 to 128, 2^-18.
REFERENCE_PERCENT = 2.0**-18
#: Mitsuba computes paths in double precision but starts rays from, and stores results in, single precision:
#: 2^-24 radii, a few hundred times as much in per cent where transmittance falls steeply.
MITSUBA_PERCENT = 1e-4
#: Rays that meet the curved wall: after so many reflections any rounding has grown beyond that.
FEW_REFLECTIONS = 40
#: Rays that pass an edge within single precision's rounding may fall on either side of it, and long paths
#: part; the cross-check allows one in a thousand to, and of a sample of 1000 that is at most three (two
#: standard deviations above the mean).
MOST_PARTED = 3

STONES = {
    "inoue-1": lambda: load_stone("inoue-1"),
    "inoue-3": lambda: load_stone("inoue-3"),
    "measured": measured_stone,
    "emerald": lambda: design("emerald"),
    "pear": lambda: design("pear"),
    "hollow": hollow_stone,
}


def path_code(facets) -> int:
    """Code a facet sequence as an observation does, written once more."""
    code = 0
    for facet in facets:
        code = (code * PATH_CODE_FACTOR + int(facet) + 1) & PATH_CODE_MASK
    return code


def shown_and_scored(observation, rng):
    """Choose pixels, and return their paths as shown and what the map says of them."""
    row, column = np.nonzero(observation.coverage)
    chosen = rng.choice(len(row), PIXELS, replace=False)
    row, column = row[chosen], column[chosen]
    x, y = observation.view.cell_centres()
    paths = full_paths(
        observation.stone,
        np.stack([x[column], y[row]], axis=1),
        view=observation.view,
        model=observation.model,
    )
    return paths, (row, column)


def compare(observation, rng, most_parted, percent):
    paths, pixels = shown_and_scored(observation, rng)
    codes = np.array([path_code(path.facets) for path in paths])
    same = codes == observation.path_code[pixels]
    assert np.count_nonzero(~same) <= most_parted

    exits = np.array([path.facets[-1] if path.status == RayStatus.EXITED else -1 for path in paths])
    status = np.array([path.status for path in paths])
    assert (status == observation.status[pixels])[same].all()
    assert (exits == observation.exit_facet[pixels])[same].all()
    assert (np.array([path.rear for path in paths]) == observation.rear_mask[pixels])[same].all()
    intensity = np.array([path.primary_intensity for path in paths])
    difference = np.abs(intensity - observation.primary_intensity[pixels])
    wall = len(observation.stone.facets) - 1 if observation.stone.is_round else -1
    at_wall = np.array([wall in path.facets for path in paths])
    few = np.array([path.reflections <= FEW_REFLECTIONS for path in paths])
    assert difference[same & ~(at_wall & ~few)].max() <= percent
    assert np.count_nonzero(~few) <= PIXELS // 100
    assert len(set(codes)) > 50, "the pixels see many different paths"


@pytest.mark.parametrize("name", some(STONES, 2))
def test01_reference(name, rng):
    observation = observe(STONES[name](), engine="reference", resolution=RESOLUTION // 4)
    compare(observation, rng, 0, REFERENCE_PERCENT)


@pytest.mark.parametrize("name", some(STONES, 2))
def test02_mitsuba(name, rng, variant_llvm_ad_mono):
    observation = observe(
        STONES[name](), engine="mitsuba", variant=variant_llvm_ad_mono, resolution=RESOLUTION
    )
    compare(observation, rng, MOST_PARTED, MITSUBA_PERCENT)


@pytest.mark.parametrize("intensity", ["primary", "radiance"])
@pytest.mark.parametrize("rear", ["position", "direction"])
def test03_every_rule_of_the_model(rear, intensity, rng):
    options = {"rear": rear, "intensity": intensity, "fresnel": "exact"}
    observation = observe(load_stone("inoue-2"), engine="reference", resolution=64, **options)
    compare(observation, rng, 0, REFERENCE_PERCENT)


def test04_the_display_draws_the_paths_that_are_compared_here(rng):
    """`check_points` hands the display the very paths of `full_paths`."""
    observation = observe(load_stone("inoue-3"), engine="reference", resolution=64)
    paths, _ = shown_and_scored(observation, rng)
    points = [(path.x, path.y) for path in paths[:100]]
    shown = check_points(observation.stone, points, observation.model)
    for drawn, scored in zip(shown, paths[:100], strict=True):
        assert np.array_equal(drawn.points, scored.points)
        assert np.array_equal(drawn.facets, scored.facets)
        assert drawn.primary_intensity == scored.primary_intensity

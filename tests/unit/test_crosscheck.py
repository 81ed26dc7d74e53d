"""The cross-check: doctored observations trip the tolerance that is meant to catch them, and no other."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from observations import STONE, observation

from gemrender.crosscheck import LONG_PATH, crosscheck
from gemrender.cuts import load_stone
from gemrender.observation import Model, RayStatus, View

#: Pixels a side, all of them covered: one pixel is 0.01 %.
N = 100

TRUTH = observation(resolution=N, primary_intensity=50, exit_facet=7, path_code=12345)


def doctored(pixels: int, **values):
    """Return the truth with other values in its first so many pixels."""
    changed = {}
    for name, value in values.items():
        changed[name] = getattr(TRUTH, name).copy()
        changed[name].reshape(-1)[:pixels] = value
    return dataclasses.replace(TRUTH, **changed)


def failures(other):
    return crosscheck(other, TRUTH).failures


def test_equal_observations_agree_in_everything():
    check = crosscheck(TRUTH, TRUTH)
    assert (check.rays, check.same_exit, check.same_path) == (N * N, 100, 100)
    assert (check.largest_intensity, check.mean_intensity, check.average, check.rear) == (0, 0, 0, 0)
    assert [band.share for band in check.bands] == [0] * 6
    assert check.failures == []


# Each case: pixels doctored, their values, and the one tolerance that they break; one pixel less in a
# hundred breaks none.
CASES = {
    # 0.11 % leave elsewhere; the tolerance is 0.1 %.
    "exit": (11, {"exit_facet": 8}, "99.8900 % of rays end alike, at least 99.9 % must"),
    # 0.51 % are 10 brighter, by another path: 0.051 in the Average, within one band.
    "average": (51, {"primary_intensity": 59.9, "path_code": 1}, "Average differs by +0.0505"),
    # 0.06 % are rear light: 0.03 in the Average, 0.06 in a band.
    "rear": (6, {"rear_mask": 1, "primary_intensity": 0, "path_code": 1}, "Rear differs by +0.0600"),
    # 0.11 % are in another band, 5 darker.
    "band": (11, {"primary_intensity": 44.9, "path_code": 1}, "a band differs by 0.1100"),
    # 2 in 10 000 are 6 off by the same path.
    "intensity": (2, {"primary_intensity": 56}, "intensities differ by 1.20e-03 in the mean"),
    # One in 10 000 is lost.
    "lost": (1, {"status": RayStatus.LOST, "primary_intensity": 0}, "0.0100 % of rays are lost"),
}


@pytest.mark.parametrize("case", CASES)
def test_each_tolerance_catches_its_own_fault(case):
    pixels, values, words = CASES[case]
    (failure,) = failures(doctored(pixels, **values))
    assert failure.startswith(words)


@pytest.mark.parametrize("case", CASES)
def test_a_little_less_is_within_the_tolerance(case):
    pixels, values, _ = CASES[case]
    assert failures(doctored(pixels - 1, **values)) == []


def test_rays_reflected_a_hundred_times_may_part_if_the_scores_agree():
    """But a ray that only one tracer takes for such a long one is no agreement."""
    long = doctored(50, exit_facet=8, reflections=LONG_PATH + 1)
    truth = dataclasses.replace(TRUTH, reflections=long.reflections)
    check = crosscheck(long, truth)
    assert (check.same_exit, check.same_exit_short, check.failures) == (99.5, 100, [])
    assert crosscheck(long, TRUTH).failures
    assert crosscheck(TRUTH, long).failures


def test_nan_never_passes():
    assert failures(doctored(1, primary_intensity=np.nan))


def test_a_ray_that_only_one_tracer_sees_is_no_agreement():
    check = crosscheck(doctored(100, status=RayStatus.MISSED, coverage=0, exit_facet=-1), TRUTH)
    assert (check.rays, check.same_exit) == (N * N, 99)


def test_a_ray_that_neither_sees_does_not_count():
    half = {"status": RayStatus.MISSED, "coverage": 0, "exit_facet": -1, "primary_intensity": 0}
    other = doctored(N * N // 2, **half)
    assert crosscheck(other, other).rays == N * N // 2


def test_differences_are_first_minus_second():
    check = crosscheck(doctored(100, primary_intensity=60, rear_mask=0), TRUTH)
    assert check.average == pytest.approx(0.1)
    assert check.largest_intensity == pytest.approx(10)
    assert {band.low: round(band.share, 9) for band in check.bands if band.share} == {60: 1.0, 45: -1.0}


@pytest.mark.parametrize(
    "change",
    [
        {"stone": load_stone("inoue-1")},
        {"view": View(resolution=N, tilt_deg=1)},
        {"model": Model(rear="direction")},
    ],
    ids=lambda change: next(iter(change)),
)
def test_only_like_is_compared_with_like(change):
    with pytest.raises(ValueError, match="different stones, views or models"):
        crosscheck(dataclasses.replace(TRUTH, **change), TRUTH)


def test_the_json_has_the_failures_in_words():
    out = json.loads(json.dumps(crosscheck(doctored(1, status=RayStatus.LOST), TRUTH).to_dict()))
    assert out["name"] == STONE.name
    assert out["lost"] == 0.01
    assert list(out["bands"][0]) == ["from", "to", "difference"]
    assert len(out["failures"]) == 1

"""The cross-check: doctored observations trip the tolerance that is meant to catch them, and no other."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from observations import STONE, observation

from gemrender.crosscheck import LONG_PATH, compare_scores, crosscheck
from gemrender.cuts import load_stone
from gemrender.measures.tally import SETS, STUDENT_T
from gemrender.observation import Model, RayStatus, View
from gemrender.scoring import UNSEEN_RAYS, score_pixels

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


# ---- Scores of rays of one's own -----------------------------------------------------------------------

#: Sets whose Average scatters by 0.1 about that of the truth, and whose other shares are the truth's.
APART = 0.1
EXACT = dataclasses.replace(score_pixels(TRUTH), engine="exact", bound=0.02)
SETS_OF_RAYS = [
    dataclasses.replace(score_pixels(TRUTH), average=EXACT.average + (APART if k % 2 else -APART))
    for k in range(SETS)
]
#: What is allowed by the bound and the scatter: the standard deviation of 16 sets, by that of the mean.
SCATTER = STUDENT_T * APART * np.sqrt(SETS / (SETS - 1)) / np.sqrt(SETS)


#: What all rays may miss, of a million.
RAYS, UNSEEN = 1_000_000, 100 * UNSEEN_RAYS / 1_000_000


def moved(**values):
    return [dataclasses.replace(of, **values) for of in SETS_OF_RAYS]


def test_means_are_compared_within_bound_and_scatter():
    check = compare_scores(SETS_OF_RAYS, EXACT, rays=RAYS)
    assert (check.rays, check.engines, check.failures) == (RAYS, (SETS_OF_RAYS[0].engine, "exact"), [])
    assert check.average == pytest.approx(0.0, abs=1e-12)
    assert check.average_allowed == pytest.approx(0.02 + UNSEEN + SCATTER)
    assert check.rear == 0.0
    assert (check.rear_allowed, *check.bands_allowed) == pytest.approx((0.02 + UNSEEN,) * 7)


def test_what_no_ray_has_seen_is_allowed_as_the_probability_of_that_is():
    """Of 1000 rays none meets a share p with the probability (1 - p)^1000: 0.1 % of 0.69 %."""
    allowed = compare_scores(SETS_OF_RAYS, EXACT, rays=1000).bands_allowed[0] - EXACT.bound
    assert (1 - allowed / 100) ** 1000 == pytest.approx(1e-3, rel=0.05)


@pytest.mark.parametrize("by", [0.95, 1.05])
def test_a_mean_further_away_fails(by):
    apart = by * (0.02 + UNSEEN + SCATTER)
    of = [dataclasses.replace(one, average=one.average + apart) for one in SETS_OF_RAYS]
    told = compare_scores(of, EXACT, rays=RAYS).failures
    assert [words.partition(" by ")[0] for words in told] == (["Average differs"] if by > 1 else [])


BAND = tuple(dataclasses.replace(b, share=b.share + 0.03 * (b.low == 15)) for b in EXACT.bands)


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"rear": 0.03}, "Rear differs by +0.0300, at most 0.0207 is allowed"),
        ({"rear": float("nan")}, "Rear differs by +nan, at most nan is allowed"),
        ({"lost": 0.01}, "0.0100 % of rays are lost, at most 0.001 % may be"),
        ({"bands": BAND}, "the band from 15 differs by +0.0300, at most 0.0207 is allowed"),
    ],
    ids=["rear", "nan", "lost", "band"],
)
def test_each_value_has_its_tolerance(values, told):
    assert compare_scores(moved(**values), EXACT, rays=RAYS).failures == [told]


def test_the_json_has_what_is_allowed():
    out = json.loads(json.dumps(compare_scores(moved(rear=0.03), EXACT, rays=RAYS).to_dict()))
    assert list(out["bands"][0]) == ["from", "to", "difference", "allowed"]
    assert len(out["failures"]) == 1

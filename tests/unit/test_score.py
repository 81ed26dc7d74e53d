"""Scores of observations made by hand: every number is a count of pixels."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
from observations import SHARE, STONE, observation

import gemrender
from gemrender.errors import InputError
from gemrender.observation import RayStatus
from gemrender.scoring import BAND_EDGES, score_observation

MISSED, EXITED, TRAPPED, LOST = RayStatus

#: A map of 4 x 4: 3 pixels outside the stone; of the other 13, 8 lit, 2 rear light, 2 trapped and 1 lost.
STATUS = [
    [MISSED, EXITED, EXITED, MISSED],
    [EXITED, EXITED, EXITED, EXITED],
    [EXITED, EXITED, EXITED, TRAPPED],
    [MISSED, LOST, TRAPPED, EXITED],
]
REAR = [[0, 1, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]]
INTENSITY = [[0, 0, 80, 0], [70, 70, 50, 40], [20, 5, 0, 0], [0, 0, 0, 0]]
AREA = 13


def scored():
    return score_observation(observation(STATUS, rear_mask=REAR, primary_intensity=INTENSITY))


def shares(score):
    return {band.low: band.share for band in score.bands}


def test_average_is_over_the_covered_area_with_rear_trapped_and_lost_as_zero():
    assert scored().average == pytest.approx((80 + 70 + 70 + 50 + 40 + 20 + 5) / AREA, abs=SHARE)


def test_rear_is_a_share_of_the_covered_area():
    assert scored().rear == pytest.approx(100 * 2 / AREA, abs=SHARE)


def test_trapped_and_lost_are_apart():
    assert scored().trapped == pytest.approx(100 * 2 / AREA, abs=SHARE)
    assert scored().lost == pytest.approx(100 * 1 / AREA, abs=SHARE)


def test_bands_count_the_lit_pixels():
    counts = {75: 1, 60: 2, 45: 1, 30: 1, 15: 1, 0: 2}
    assert shares(scored()) == pytest.approx({low: 100 * n / AREA for low, n in counts.items()}, abs=SHARE)


def test_bands_rear_trapped_and_lost_make_100():
    score = scored()
    whole = sum(shares(score).values()) + score.rear + score.trapped + score.lost
    assert whole == pytest.approx(100, abs=SHARE)


def test_bands_join_without_a_gap_from_the_brightest_down():
    bands = scored().bands
    assert [band.low for band in bands] == [75, 60, 45, 30, 15, 0]
    assert [band.high for band in bands] == [None, 75, 60, 45, 30, 15]


@pytest.mark.parametrize("edge", BAND_EDGES)
def test_an_edge_belongs_to_the_band_above_it(edge):
    score = score_observation(observation(resolution=1, primary_intensity=edge))
    assert shares(score)[edge] == 100


@pytest.mark.parametrize(("edge", "below"), list(itertools.pairwise(BAND_EDGES)))
def test_just_under_an_edge_is_the_band_below_it(edge, below):
    intensity = np.nextafter(np.float32(edge), np.float32(0))
    score = score_observation(observation(resolution=1, primary_intensity=intensity))
    assert shares(score)[below] == 100


def test_lit_by_next_to_nothing_is_lit():
    """Intensity 0 from the front is a dark facet, not rear light."""
    score = score_observation(observation(resolution=2, primary_intensity=0))
    assert (shares(score)[0], score.rear, score.average) == (100, 0, 0)


def test_more_than_100_is_bright():
    """The paper's measure may exceed the light's: beams get narrower towards the eye."""
    assert shares(score_observation(observation(resolution=1, primary_intensity=180)))[75] == 100


def test_nothing_met_is_refused():
    with pytest.raises(InputError, match="resolution = 3: must be larger, no ray met the stone"):
        score_observation(observation(MISSED, resolution=3))


def test_the_json_keeps_the_contract_and_adds_at_the_end():
    keys = list(scored().to_dict())
    contract = ["name", "average", "rear", "bands", "trapped", "engine", "variant", "resolution", "fresnel"]
    assert keys[:10] == [*contract, "seconds"]
    assert keys[10:16] == ["lost", "tilt_deg", "tilt_azimuth_deg", "rear_rule", "intensity", "index"]
    assert keys[16:] == ["bound", "facets", "assumed", "notes"]


def test_the_json_holds_a_band_as_from_to_share():
    bands = scored().to_dict()["bands"]
    assert [list(band) for band in bands] == [["from", "to", "share"]] * 6
    assert (bands[0]["from"], bands[0]["to"], bands[5]["from"], bands[5]["to"]) == (75, None, 0, 15)


def test_numbers_of_numpy_go_into_json():
    score = gemrender.score(STONE, engine="reference", resolution=np.int64(8), tilt=np.float32(5))
    assert json.loads(json.dumps(score.to_dict()))["resolution"] == 8


def test_what_was_asked_for_is_on_record():
    score = gemrender.score(
        STONE, engine="reference", resolution=8, tilt=5, tilt_azimuth=-30,
        fresnel="exact", rear="direction", intensity="radiance",
    )  # fmt: skip
    assert (score.name, score.engine, score.variant, score.resolution) == (STONE.name, "reference", "", 8)
    assert (score.tilt_deg, score.tilt_azimuth_deg, score.index) == (5, -30, 2.4173)
    assert (score.fresnel, score.rear_rule, score.intensity) == ("exact", "direction", "radiance")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"engine": "magic"}, "engine = 'magic': must be one of auto, exact, mitsuba, reference"),
        ({"engine": "reference", "variant": "mono"}, "variant = 'mono': must be one of llvm_ad_rgb, "),
        ({"engine": "reference", "variant": "scalar_rgb"}, "variant = 'scalar_rgb': must be one of "),
        ({"engine": "mitsuba", "variant": "mono"}, "variant = 'mono': must be one of llvm_ad_rgb, "),
        ({"resolution": 0}, "resolution = 0: must be from 1 to 16384"),
        ({"tilt": float("nan")}, "tilt = nan: must be from 0 to below 90"),
    ],
)
def test_bad_options_are_refused_with_what_is_allowed(options, words):
    with pytest.raises(InputError) as caught:
        gemrender.score(STONE, **options)
    assert str(caught.value).startswith(words)

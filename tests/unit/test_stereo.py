"""A viewer with two eyes: what both see alike, and how much they do not."""

from __future__ import annotations

import numpy as np
import pytest
from designs_help import level, ring, stone_of

import gemrender
from gemrender.errors import InputError

BOUND = 0.05
MEASURES = "iso,aset"


def box() -> gemrender.Stone:
    """A flat square plate: all that is seen in it is the ground below."""
    return stone_of(np.concatenate([ring(4, 90, 1.0), level(0.1), level(0.1, down=True)]))


def test_eyes_that_are_not_apart_see_the_same():
    seen = gemrender.score_stereo(gemrender.load_stone("inoue-2"), measures=MEASURES, eye_separation=0.0)
    for eye in (seen.left, seen.right):
        assert eye.average == pytest.approx(seen.middle.average, abs=2 * BOUND)
        assert eye.rear == pytest.approx(seen.middle.rear, abs=2 * BOUND)
    assert seen.disagreement == 0.0


def test_both_eyes_of_a_mirror_symmetric_stone_see_as_much():
    seen = gemrender.score_stereo(gemrender.load_stone("inoue-3"), measures=MEASURES, bound=BOUND)
    assert seen.left.average == pytest.approx(seen.right.average, abs=2 * BOUND)
    for left, right in zip(seen.left.measures or (), seen.right.measures or (), strict=True):
        assert left.values == pytest.approx(right.values, abs=left.bound + right.bound)
    assert seen.left.average != pytest.approx(seen.middle.average, abs=2 * BOUND)


def test_each_eye_is_turned_by_half_the_angle_between_them():
    seen = gemrender.score_stereo(
        box(), eye_separation=60.0, eye_distance=300.0, tilt=20.0, tilt_azimuth=90.0
    )
    half = np.arctan(0.1)
    for eye in (seen.left, seen.right):  # at a right angle to the tilt
        assert np.cos(np.radians(eye.tilt_deg)) == pytest.approx(np.cos(half) * np.cos(np.radians(20)))


def test_two_eyes_see_one_window():
    """Through a plate both see the ground wherever they see through its base; beside it, its sides."""
    seen = gemrender.score_stereo(box(), measures="aset,window", eye_separation=65.0)
    assert seen.disagreement < 100 * 0.1 * np.tan(0.11) * 2  # as much as the sides hide, at the most
    for eye in (seen.left, seen.right):
        aset = (eye.measures or ())[0].values
        assert aset["leak"] > 90


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"eye_separation": -1.0}, r"eye_separation = -1.0: must be from 0 to 200 \[mm\]"),
        ({"eye_distance": 10.0}, r"eye_distance = 10.0: must be from 50 to 10000 \[mm\]"),
        ({"engine": "mitsuba"}, "engine = 'mitsuba': must be exact for two eyes"),
        ({"tilt": 89.0, "tilt_azimuth": 0.0}, "must be from 0 to below 90"),
    ],
)
def test_what_two_eyes_cannot_be_is_refused(options, words):
    with pytest.raises(InputError, match=words):
        gemrender.score_stereo(box(), **options)

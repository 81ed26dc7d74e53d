"""`--quality`: a word for where rendering ends, and what numbers beside it do."""

from __future__ import annotations

import pytest

from gemrender.render.quality import BEST_NOISE, BEST_SAMPLES, Quality, ends_of


def ends(spp=None, noise=None, time_limit=None):
    return {"spp": spp, "noise": noise, "time_limit": time_limit}


@pytest.mark.parametrize(
    ("quality", "expected"),
    [
        (None, ends(256)),
        ("draft", ends(16)),
        ("good", ends(256)),
        ("best", ends(BEST_SAMPLES, BEST_NOISE)),
    ],
)
def test_a_word_alone(quality, expected):
    assert ends_of(quality and Quality(quality)) == expected


@pytest.mark.parametrize("quality", [None, *Quality])
@pytest.mark.parametrize("given", [{"spp": 9}, {"noise": 0.1}, {"spp": 9, "noise": 0.1, "time_limit": 3.0}])
def test_samples_and_noise_in_numbers_stand_in_its_place(quality, given):
    assert ends_of(quality, **given) == ends(**given)


def test_a_time_stands_beside_the_word():
    assert ends_of(Quality.BEST, time_limit=60.0) == ends(BEST_SAMPLES, BEST_NOISE, 60.0)
    assert ends_of(Quality.DRAFT, time_limit=60.0) == ends(16, None, 60.0)


def test_a_time_alone_is_the_only_end():
    assert ends_of(time_limit=60.0) == ends(time_limit=60.0)

"""How long work goes on, and when that is said: with a clock that is set by hand."""

from __future__ import annotations

import numpy as np
import pytest

from gemrender.progress import ProgressLines, TimeLeft, duration_words

#: The estimate halfway of a render whose noise is known to some 10 % only.
NOISY_ESTIMATE = 0.3


class Clock:
    """A clock that is set by hand [s]."""

    def __init__(self):
        self.now = 1000.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def lines(clock):
    said = []
    lines = ProgressLines(said.append, clock=clock)

    def at(seconds, share=None, label=""):
        """Set the clock, tell a share; returns what is said then."""
        clock.now = 1000.0 + seconds
        said.clear()
        if share is None:
            lines.tick()
        else:
            lines.update(share, label)
        return list(said)

    return at


# ---- How long --------------------------------------------------------------------------------------------


def told(clock, history):
    left = TimeLeft(clock)
    for at, share in history:
        clock.now = at
        left.update(share)
    return left.seconds()


def test_even_work_takes_what_it_took(clock):
    assert told(clock, [(0, 0.0), (10, 0.1), (40, 0.4)]) == pytest.approx(60)


def test_before_the_first_step_nothing_is_known(clock):
    assert told(clock, []) is None
    assert told(clock, [(0, 0.0)]) is None
    assert told(clock, [(0, 0.0), (9, 0.0)]) is None


def test_the_first_step_tells_already(clock):
    assert told(clock, [(0, 0.0), (10, 0.1)]) == pytest.approx(90)


def test_a_slow_first_step_is_left_out_later(clock):
    """A minute to compile, then a second each."""
    assert told(clock, [(0, 0.0), (61, 0.01), (71, 0.11)]) == pytest.approx(89)


def test_frames_that_were_there_took_no_time(clock):
    """A film is taken up with 60 of 100 frames."""
    assert told(clock, [(0, 0.60), (10, 0.61), (20, 0.62)]) == pytest.approx(380)


def test_towards_a_time_it_is_the_time(clock):
    assert told(clock, [(2, 2 / 300), (9, 9 / 300), (100, 100 / 300)]) == pytest.approx(200)


def test_towards_a_noise_it_goes_by_its_square(clock, rng):
    """Noise is c / sqrt(t), known to a tenth: at 0.02, 0.01 is three times the time so far away."""
    wanted, history = 0.01, [(0.0, 0.0)]
    for t in range(5, 401, 5):
        noise = 0.4 / np.sqrt(t) * (1 + 0.1 * rng.standard_normal())
        history.append((t, min((wanted / noise) ** 2, 0.99)))
    assert told(clock, history) == pytest.approx(1200, rel=NOISY_ESTIMATE)


def test_a_noise_that_grew_leaves_it_open(clock):
    assert told(clock, [(0, 0.1), (9, 0.2), (12, 0.1)]) is None


def test_time_goes_on_between_shares(clock):
    left = TimeLeft(clock)
    left.update(0.0)
    clock.now += 10
    left.update(0.1)
    clock.now += 4
    assert left.seconds() == pytest.approx(86)


def test_a_step_that_takes_longer_makes_the_whole_longer(clock):
    """Of ten steps the first took 10 s; the second, of 30 s and more, leaves eight of at least 20 s."""
    left = TimeLeft(clock)
    left.update(0.0)
    clock.now += 10
    left.update(0.1)
    clock.now += 30
    assert left.seconds() == pytest.approx(160)


def test_a_last_step_that_takes_longer_is_overdue(clock):
    left = TimeLeft(clock)
    for share in (0.0, 0.5):
        left.update(share)
        clock.now += 10
    assert left.seconds() is None
    assert left.is_overdue
    left.update(1.0)
    assert (left.seconds(), left.is_overdue) == (0, False)


def test_slower_work_that_follows_fast_work_is_taken_at_its_own_pace(clock):
    """70 % in 7 s, then 30 % in 60 s: halfway through the latter half a minute is left."""
    fast = [(t, t / 10) for t in range(8)]
    slow = [(7 + t, 0.7 + t / 200) for t in range(1, 31)]
    assert told(clock, fast + slow) == pytest.approx(30, rel=1e-6)


def test_of_many_shares_the_pace_is_the_same(clock):
    left = TimeLeft(clock)
    for k in range(100_001):
        clock.now = 1000.0 + k / 100
        left.update(k / 200_000)
    assert left.seconds() == pytest.approx(1000)


# ---- When it is said -------------------------------------------------------------------------------------


def test_it_is_said_after_the_first_step_then_every_half_minute(lines):
    assert lines(0, 0.0) == []
    assert lines(10, 0.1) == ["about 1 min 30 s left (10 % done)"]
    assert lines(20, 0.2) == []
    assert lines(39, 0.39) == []
    assert lines(40, 0.4) == ["about 1 min left (40 % done)"]
    assert lines(69, 0.69) == []
    assert lines(71, 0.71) == ["about 30 s left (71 % done)"]
    assert lines(100, 1.0) == []


def test_short_work_passes_without_a_word(lines):
    assert [lines(t, t / 20) for t in range(21)] == [[]] * 21


def test_a_step_longer_than_half_a_minute_does_not_keep_it_silent(lines):
    assert lines(0, 0.0) == []
    assert lines(29) == []
    assert lines(31) == ["30 s so far, how long it takes is not known yet"]
    assert lines(100, 0.25) == ["about 5 min left (25 % done)"]
    assert lines(131) == ["about 4 min 30 s left (25 % done)"]


def test_work_that_takes_longer_than_foretold_is_told_so(lines):
    """Never "a few seconds left", again and again."""
    assert lines(0, 0.0) == []
    assert lines(60, 0.5) == ["about 1 min left (50 % done)"]
    assert lines(110) == ["about 10 s left (50 % done)"]
    assert lines(141) == ["2 min 20 s so far, longer than it seemed (50 % done)"]
    assert lines(150, 0.75) == []
    assert lines(172, 0.8) == ["about 45 s left (80 % done)"]


def test_what_starts_and_compiles_is_no_pace(lines):
    """A second each of 100 steps, but the first takes three."""
    assert lines(0, 0.0) == []
    assert lines(3, 0.01) == []
    assert lines(5.1, 0.03) == ["about 1 min 40 s left (3 % done)"]


def test_it_says_what_is_being_done(lines):
    assert lines(0, 0.0, "frame 1 of 4") == []
    assert lines(60, 0.25, "frame 2 of 4") == ["frame 2 of 4: about 3 min left (25 % done)"]


def test_a_context_speaks_up_by_itself():
    import threading

    spoken = threading.Event()
    with ProgressLines(lambda _: spoken.set(), every=0.05):
        assert spoken.wait(30)  # a step that takes long


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0, "a few seconds"),
        (3, "5 s"),
        (42, "40 s"),
        (57, "55 s"),
        (58, "1 min"),
        (130, "2 min 10 s"),
        (599, "10 min"),
        (640, "11 min"),
        (3600, "1 h"),
        (7260, "2 h 1 min"),
        (40_000, "11 h"),
        (200_000, "2 d 8 h"),
    ],
)
def test_times_are_said_as_people_say_them(seconds, words):
    assert duration_words(seconds) == words

"""The studio's pictures: orders to the process that renders, and what comes of them."""

from __future__ import annotations

import io
import pickle
import queue
import subprocess
import sys
import threading

import pytest
from echo_painter import echoing
from PIL import Image
from refusals import refused
from test_studio_session import read, told

import gemrender
from gemrender.studio.frames import Wanted
from gemrender.studio.painter import Job, Orders, Stage, paint
from gemrender.studio.pictures import Pictures

#: Long enough for a machine that has much else to do [s].
PATIENCE = 240.0
#: Nothing comes for so long [s].
SILENCE = 0.3


def wanted(number=1, setup="studio", held=None, **changes):
    picture = None if setup is None else {"setup": setup, **(held or {})}
    return Wanted.of({**told("inoue-3", picture=picture, **changes), "number": number})


@pytest.fixture
def sent():
    return queue.Queue()


@pytest.fixture
def made(sent):
    of = Pictures(sent.put)
    yield of
    of.close()


@pytest.fixture
def echoed(made, monkeypatch):
    return echoing(monkeypatch)


def rest(of, state):
    of.rest(state, state.stone({}))


def heard(sent, patience=PATIENCE):
    return read(sent.get(timeout=patience))


@pytest.mark.parametrize(
    "picture", [{"setup": "/etc/passwd"}, {"setup": "../studio"}, {"setup": ["studio"]}, {}, "studio", 1]
)
def test_a_picture_is_in_a_bundled_set_up_and_never_in_a_file(picture):
    refused(lambda: Wanted.of(told("inoue-3", picture=picture)), "picture")


def test_the_same_scene_goes_on_and_is_shown_again_under_the_new_states_number(made, sent, echoed):
    rest(made, wanted(1))
    assert [heard(sent)[0]["number"] for _ in range(2)] == [1, 1]
    made.pause()
    rest(made, wanted(2, view={"tilt": 9.0, "azimuth": 0.0}))  # a picture has an eye of its own
    header, arrays = heard(sent)
    assert (header["type"], header["number"], header["noise"]) == ("picture", 2, None)
    assert arrays["png"].tobytes() == b"studio"
    with pytest.raises(queue.Empty):
        heard(sent, SILENCE)  # and it was not begun anew
    rest(made, wanted(3, "sun"))
    assert heard(sent)[1]["png"].tobytes() == b"sun"
    assert len(echoed) == 1


@pytest.mark.parametrize("key", ["setting", "metal"])
@pytest.mark.parametrize("word", ["clamp", "/etc/passwd", 1, ["gold"], ""])
def test_what_holds_a_stone_is_one_of_a_few_words(key, word):
    refused(lambda: Wanted.of(told("inoue-3", picture={"setup": "studio", key: word})), key)


def test_another_setting_is_another_picture(made, sent, echoed):
    rest(made, wanted(1, held={"setting": "pendant", "metal": "gold"}))
    assert heard(sent)[1]["png"].tobytes() == b"studio gold pendant"
    heard(sent)  # told twice
    rest(made, wanted(2, held={"setting": "none"}))
    assert heard(sent)[1]["png"].tobytes() == b"studio none"


def test_a_setting_that_the_set_up_has_no_place_for_is_refused():
    job = Job(1, gemrender.load_stone("inoue-3"), "hearts", setting="bezel")
    refused(lambda: paint(job, Orders(), io.BytesIO()), "setting")


def test_while_something_moves_nothing_is_shown_and_afterwards_the_last_picture_is(made, sent, echoed):
    rest(made, wanted(1))
    made.pause()
    while not sent.empty():
        sent.get()
    with pytest.raises(queue.Empty):
        heard(sent, SILENCE)
    rest(made, wanted(2))
    assert heard(sent)[0]["number"] == 2


def test_where_no_picture_is_wanted_the_process_ends(made, sent, echoed):
    rest(made, wanted(1))
    heard(sent)
    rest(made, wanted(2, None))
    assert echoed[0].wait(PATIENCE) != 0


def test_a_process_that_is_lost_is_told_in_a_line_and_the_next_scene_begins_another(made, sent, echoed):
    rest(made, wanted(1, "velvet"))
    header, _ = heard(sent)
    assert (header["type"], header["number"]) == ("unpictured", 1)
    assert header["why"] == "the process that renders ended by exit status 3"
    rest(made, wanted(2))
    assert heard(sent)[0]["type"] == "picture"
    assert len(echoed) == 2


def test_a_job_that_is_paused_waits_and_one_that_is_replaced_ends():
    orders, (first, second) = Orders(), (Job(1, None, "studio"), Job(2, None, "sun"))
    orders.take("paint", first)
    assert orders.next() is first
    assert orders.go_on(first)
    orders.take("pause")
    answers = queue.Queue()
    threading.Thread(target=lambda: answers.put(orders.go_on(first)), daemon=True).start()
    with pytest.raises(queue.Empty):
        answers.get(timeout=SILENCE)
    orders.take("paint", second)
    assert answers.get(timeout=PATIENCE) is False
    assert orders.next() is second


def test_a_job_that_was_paused_goes_on():
    orders, job = Orders(), Job(1, None, "studio")
    orders.take("paint", job)
    orders.take("pause")
    orders.take("go")
    assert orders.next() is job
    assert orders.go_on(job)


def test_the_real_process_ends_where_there_is_nobody_to_work_for():
    command = [sys.executable, "-m", "gemrender.studio.painter"]
    done = subprocess.run(command, input=b"", capture_output=True, timeout=PATIENCE, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


def test_the_real_process_tells_what_cannot_be_rendered(made, sent):
    rest(made, wanted(2, material=9.5))
    header, _ = heard(sent)
    assert (header["type"], header["number"]) == ("unpictured", 2)
    assert "must be a number from 1.05 to 4" in header["why"]
    assert "\n" not in header["why"]


def test_a_picture_is_coarse_first_and_then_refines_until_it_is_done():
    orders, answers = Orders(), io.BytesIO()
    job = Job(7, gemrender.load_stone("inoue-3"), "studio")
    orders.take("paint", job)
    # Of each one its end only, however long it takes
    paint(job, orders, answers, stages=(Stage(8, 2), Stage(16, 4)), apart=float("inf"))
    answers.seek(0)
    told = [pickle.load(answers) for _ in range(2)]
    assert [of["samples"] for of in told] == [2, 4]
    assert [of["isDone"] for of in told] == [False, True]
    assert [of["key"] for of in told] == [7, 7]
    assert not answers.read()
    for of, side in zip(told, (8, 16), strict=True):
        with Image.open(io.BytesIO(of["png"])) as image:
            assert image.size == (side, side)
            assert "diamond" in image.text["Title"]

"""SIGTERM and SIGHUP end things as Ctrl-C does."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time

import pytest

from gemrender.interruption import interrupted_by_signals, interruptions_held
from tests.observations import environment

pytestmark = pytest.mark.usefixtures("hangups_end")

STATUS = {"SIGTERM": 143, "SIGHUP": 129, "SIGINT": 130}


@pytest.mark.parametrize(("name", "status"), STATUS.items())
def test_a_signal_interrupts_once_and_has_its_status(name, status):
    before = signal.getsignal(signal.SIGTERM)
    with interrupted_by_signals() as status_of_interruption:
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(getattr(signal, name))
        if name != "SIGINT":
            signal.raise_signal(signal.SIGTERM)  # ignored from now on
            signal.raise_signal(signal.SIGHUP)
        assert status_of_interruption() == status
    assert signal.getsignal(signal.SIGTERM) is before


def test_what_is_ignored_stays_so():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    try:
        with interrupted_by_signals():
            signal.raise_signal(signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)


def test_outside_the_main_thread_it_does_nothing():
    found = []

    def work():
        with interrupted_by_signals() as status:
            found.append(status())

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [130]


#: A script that writes half a file, then waits: by short sleeps, since a signal that arrives between Python's
#: last look for signals and the system call of a long one is answered only at that one's end.
SCRIPT = """
import pathlib, sys, time
from gemrender.interruption import interrupted_by_signals, interruptions_held
from gemrender.writing import write_whole

def half(path):
    path.write_text("half")
    while True:
        time.sleep(0.01)

with interrupted_by_signals() as status:
    try:
        write_whole(pathlib.Path(sys.argv[1]), {"x.txt": lambda path: path.write_text("x"), "y.txt": half})
    except KeyboardInterrupt:
        sys.exit(status())
"""


@pytest.mark.parametrize(("name", "status"), STATUS.items())
def test_a_signal_while_files_are_written_leaves_none(name, status, tmp_path):
    process = subprocess.Popen([sys.executable, "-c", SCRIPT, tmp_path], env=environment({}))
    try:
        until = time.monotonic() + 60
        while not list(tmp_path.glob("*/y.txt")):
            assert time.monotonic() < until
            time.sleep(0.02)
        process.send_signal(getattr(signal, name))
        assert process.wait(timeout=60) == status
    finally:
        process.kill()
        process.wait()
    assert list(tmp_path.iterdir()) == []


def test_what_cannot_be_broken_off_is_done_first():
    done = []

    def work():
        with interruptions_held():
            signal.raise_signal(signal.SIGINT)
            done.append("all of it")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done == ["all of it"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_what_is_ignored_is_not_held():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with interruptions_held():
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no SIGHUP here")
def test_other_signals_are_held_too():
    with pytest.raises(KeyboardInterrupt), interrupted_by_signals() as status, interruptions_held():
        signal.raise_signal(signal.SIGHUP)
    assert status() == 129

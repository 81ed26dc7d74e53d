"""Processes that share work: what they return, how they end, and what happens where one is lost."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest
from thorough import chosen

from gemrender.errors import GemrenderError, InputError
from gemrender.sweep.workers import MOST_TRIES, LostProcessError, in_processes
from tests import worker_tasks
from tests.observations import environment

pytestmark = pytest.mark.usefixtures("hangups_end")

#: By then a process has ended, however busy the machine is [s].
ENDS_WITHIN = 30.0


def ids_in(folder, number):
    """Wait until so many processes have said that they are at work; return their ids."""
    until = time.monotonic() + 60
    while len(names := list(folder.iterdir())) < number:
        assert time.monotonic() < until
        time.sleep(0.02)
    return [int(path.name) for path in names]


def have_ended(processes):
    """Whether all of them end soon; a zombie, which nobody has waited for, has ended."""
    until = time.monotonic() + ENDS_WITHIN
    while any(is_running(process) for process in processes):
        if time.monotonic() > until:
            for process in processes:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(process, signal.SIGKILL)
            return False
        time.sleep(0.02)
    return True


def is_running(process):
    stat = Path(f"/proc/{process}/stat")
    if Path("/proc/self/stat").exists():
        try:
            return stat.read_text().rpartition(")")[2].split()[0] not in "ZX"
        except OSError:
            return False
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def test_all_is_done_by_as_many_processes_as_asked_for():
    answers = list(in_processes(worker_tasks.double, range(7), 2))
    assert sorted(value for value, _ in answers) == [0, 2, 4, 6, 8, 10, 12]
    assert len({process for _, process in answers} - {os.getpid()}) == 2
    assert not multiprocessing.active_children()


def test_without_work_no_process_is_started():
    assert list(in_processes(worker_tasks.double, [], 3)) == []


def test_an_error_of_the_work_ends_it_as_it_is():
    error = InputError("must be 1", source="x.toml", key="k", value=2)
    with pytest.raises(InputError, match=r"^x\.toml: k = 2: must be 1$"):
        list(in_processes(partial(worker_tasks.refused, error), range(4), 2))
    assert not multiprocessing.active_children()
    with pytest.raises(ZeroDivisionError) as caught:
        list(in_processes(partial(worker_tasks.refused, ZeroDivisionError("oh")), range(4), 1))
    assert "in refused" in caught.value.__notes__[0], "where it came from"


def test_an_answer_that_cannot_be_sent_is_an_error():
    with pytest.raises(GemrenderError, match="cannot be sent"):
        list(in_processes(worker_tasks.unsendable, [1], 1))


@pytest.mark.parametrize("processes", [1, 2])
def test_what_a_killed_process_was_at_is_done_again(processes, tmp_path, caplog):
    found = list(in_processes(partial(worker_tasks.killed_at_first, tmp_path), range(6), processes))
    assert sorted(found) == list(range(6))
    (record,) = caplog.records
    assert record.getMessage() == (
        "a process was ended by signal 9; perhaps memory ran out; its work is done again, by 1 at a time"
    )


def test_work_that_kills_again_and_again_is_given_up_in_one_line(caplog):
    found = []
    with pytest.raises(LostProcessError) as caught:
        found += in_processes(worker_tasks.killed_always, range(5), 2)
    assert caught.value.exit_status == 1
    assert str(caught.value) == (
        "a process was ended by signal 9; perhaps memory ran out; this was attempt 3 at the same work"
    )
    assert len(caplog.records) == MOST_TRIES - 1
    assert not multiprocessing.active_children()


def test_a_process_that_cannot_start_is_told_at_once(caplog):
    with pytest.raises(GemrenderError, match=r'exit status 3.*if __name__ == "__main__"'):
        list(in_processes(worker_tasks.ended, [3, 3], 2))
    assert not caplog.records


def test_they_end_when_nobody_wants_more(tmp_path):
    work = partial(worker_tasks.busy, tmp_path, 0.0)
    with contextlib.closing(in_processes(work, range(1000), 2)) as results:
        next(results)
    assert have_ended(ids_in(tmp_path, 1))
    assert not multiprocessing.active_children()


#: A script that has two processes wait for ten minutes.
SCRIPT = """
import pathlib, sys
from functools import partial
from gemrender.sweep.workers import in_processes
from tests.worker_tasks import busy
list(in_processes(partial(busy, pathlib.Path(sys.argv[1]), 600.0), range(4), 2))
"""


@pytest.mark.parametrize("name", chosen(["SIGKILL", "SIGTERM", "SIGHUP", "SIGINT"], ["SIGKILL", "SIGTERM"]))
def test_they_end_with_the_process_that_started_them(name, tmp_path):
    parent = subprocess.Popen(
        [sys.executable, "-c", SCRIPT, tmp_path], env=environment({}), stderr=subprocess.PIPE, text=True
    )
    try:
        workers = ids_in(tmp_path, 2)
        parent.send_signal(getattr(signal, name))
        _, err = parent.communicate(timeout=ENDS_WITHIN)
    finally:
        parent.kill()
        parent.wait()
    assert parent.returncode == -getattr(signal, name)
    assert have_ended(workers)
    assert err.count("Traceback") == (name == "SIGINT"), "the one of the parent"


def test_a_signal_of_the_terminal_to_all_is_answered_by_one(tmp_path):
    """Ctrl-C reaches every process before the terminal."""
    parent = subprocess.Popen(
        [sys.executable, "-c", SCRIPT, tmp_path],
        env=environment({}), stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    try:
        workers = ids_in(tmp_path, 2)
        os.killpg(parent.pid, signal.SIGINT)
        _, err = parent.communicate(timeout=ENDS_WITHIN)
    finally:
        parent.kill()
        parent.wait()
    assert err.count("Traceback") == 1
    assert err.rstrip().endswith("KeyboardInterrupt")
    assert have_ended(workers)

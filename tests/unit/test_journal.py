"""The journal: what it takes up, what it leaves out, and what it refuses."""

from __future__ import annotations

import json
import os
import socket
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from gemrender.errors import InputError
from gemrender.journal import Journal, OtherWorkError
from gemrender.reading import open_file
from tests.observations import environment

HEAD = {"stone": "x", "sizes": [1.5, 2]}
HEAD_LINE = json.dumps(HEAD)


def entry(line):
    number, value = line
    if type(number) is not int or type(value) is not float:
        raise ValueError
    return number, value


@pytest.fixture
def path(tmp_path):
    return tmp_path / "study.jsonl"


def opened(path, head=HEAD):
    return Journal(path, head, entry, work="study")


def known(path):
    with opened(path) as journal:
        return journal.known


def refusal(path):
    with pytest.raises(InputError) as caught:
        opened(path)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(f"{path}: ")
    return line.removeprefix(f"{path}: ")


def test_entries_come_back_and_the_later_of_two_counts(path):
    with opened(path) as journal:
        assert journal.known == {}
        journal.add(0, 0.1)
        journal.add(1, 1.5)
        assert len(path.read_text().splitlines()) == 3, "they are written at once"
        journal.add(0, 1 / 3)
    assert known(path) == {0: 1 / 3, 1: 1.5}


def test_a_new_file_has_the_permissions_of_any_other(path, tmp_path):
    opened(path).close()
    (tmp_path / "plain").write_text("x")
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE((tmp_path / "plain").stat().st_mode)
    assert {file.name for file in tmp_path.iterdir()} == {"study.jsonl", "plain"}


@pytest.mark.parametrize(
    "line",
    [
        b"[0, NaN]", b"[0, Infinity]", b"[0, -Infinity]", b"[0, 1e999]", b"[0, null]", b'[0, "1.0"]',
        b"[0]", b"[0, 1.0, 2.0]", b"[true, 1.0]", b'{"0": 1.0}', b"0", b"null", b"[0, 1.", b"nonsense",
        b"[0, 1" + b"0" * 5000 + b"]", b"[" * 100_000, b"\0\0\0", b"\xff\xfe[", "[0, 1.0]".encode("utf-16"),
    ],
    ids=lambda line: repr(line[:16]),
)  # fmt: skip
def test_a_line_that_is_no_entry_is_told_and_dropped(line, path, caplog):
    lines = [HEAD_LINE.encode(), b"[1, 1.0]", line, b"[2, 2.0]", b""]
    path.write_bytes(b"\n".join(lines))
    assert known(path) == {1: 1.0, 2: 2.0}
    (record,) = caplog.records
    said = "a line that is no entry is left out; what was there is done again"
    assert (record.getMessage(), record.name) == (f"{path}: {said}", "gemrender")
    assert path.read_text().splitlines() == [HEAD_LINE, "[1, 1.0]", "[2, 2.0]"]
    caplog.clear()
    assert known(path) == {1: 1.0, 2: 2.0}
    assert not caplog.records, "told once"


def test_what_is_told_of_a_journal_reaches_stderr_without_any_setting(path):
    path.write_text(f"{HEAD_LINE}\n[1, NaN]\n[\n")
    code = (
        "import sys, pathlib; from gemrender.journal import Journal\n"
        f"Journal(pathlib.Path(sys.argv[1]), {HEAD!r}, tuple, work='study').close()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, path], env=environment({}), capture_output=True, text=True, timeout=60
    )
    said = "2 lines that are no entries are left out; what was there is done again"
    assert (done.returncode, done.stderr) == (0, f"{path}: {said}\n")


def test_an_entry_at_the_end_without_a_line_end_is_one(path, caplog):
    path.write_text(f"{HEAD_LINE}\n[1, 1.0]\n[2, 2.5]")
    with opened(path) as journal:
        assert journal.known == {1: 1.0, 2: 2.5}
        journal.add(3, 3.0)
    assert known(path) == {1: 1.0, 2: 2.5, 3: 3.0}
    assert not caplog.records


@pytest.mark.parametrize(
    "text", ["", "\n", "\0" * 4096, *(HEAD_LINE[:n] for n in range(1, len(HEAD_LINE) + 1))]
)
def test_a_file_that_ends_within_its_first_line_is_begun_anew(text, path):
    path.write_text(text)
    assert known(path) == {}
    assert path.read_text() == HEAD_LINE + "\n"


def test_the_head_cut_of_another_study_is_begun_anew(path):
    path.write_text('{"stone": "a longer name')
    assert known(path) == {}


@pytest.mark.parametrize("text", ["my notes", "my notes\n", "my\nnotes\n", "\xff\xfe", "a" * 10_000, '{"x'])
def test_a_file_that_is_no_journal_is_refused_and_left(text, path):
    path.write_text(text, encoding="latin-1")
    before = path.read_bytes()
    assert refusal(path) == "is not the journal of a study"
    assert path.read_bytes() == before


@pytest.mark.parametrize("text", ["{}", "[]", "null", json.dumps({**HEAD, "sizes": [1.5, 3]})])
def test_the_journal_of_another_work_is_refused_and_left(text, path):
    path.write_text(f"{text}\n[1, 1.0]\n")
    assert refusal(path) == "is the journal of another study; remove it, or name another folder"
    with pytest.raises(OtherWorkError):
        opened(path)
    assert path.read_text() == f"{text}\n[1, 1.0]\n"


def test_a_damaged_head_before_entries_is_refused_and_left(path):
    text = f"{HEAD_LINE[:10]}\n[1, 1.0]\n"
    path.write_text(text)
    assert refusal(path) == (
        "has entries of a study, but the first line, which says of which, is damaged; mend that, "
        "or remove the file"
    )
    assert path.read_text() == text


def test_two_at_once_are_refused_and_one_after_the_other_is_not(path):
    with opened(path) as first:
        first.add(1, 1.0)
        assert refusal(path) == "is in use: another gemrender is at the same work"
        first.add(2, 2.0)
    assert known(path) == {1: 1.0, 2: 2.0}


def test_it_is_locked_after_it_was_written_anew(path):
    path.write_text(f"{HEAD_LINE}\nnonsense\n")
    with opened(path):
        assert "in use" in refusal(path)


def test_a_link_stays_and_its_file_is_written(path, tmp_path):
    path.symlink_to("elsewhere.jsonl")
    with opened(path) as journal:
        journal.add(1, 1.0)
    assert path.is_symlink()
    assert (tmp_path / "elsewhere.jsonl").read_text() == f"{HEAD_LINE}\n[1, 1.0]\n"


def test_what_is_no_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert refusal(tmp_path / "pipe") == "must be a file, not a pipe"
    assert refusal(tmp_path) == "cannot be written (Is a directory)"
    assert refusal(Path(os.devnull)) == "must be a file, not a device"
    with socket.socket(socket.AF_UNIX) as listening:
        # A path of at most 107 bytes is allowed.
        here = Path.cwd()
        os.chdir(tmp_path)
        listening.bind("socket")
        os.chdir(here)
    assert refusal(tmp_path / "socket") == "must be a file, not a socket"
    assert "No such file" in refusal(tmp_path / "none" / "x.jsonl")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs Linux's device that is full")
def test_a_full_disk_is_one_line(path, monkeypatch):
    files = []

    def remembered(*arguments):
        files.append(open_file(*arguments))
        return files[-1]

    monkeypatch.setattr("gemrender.journal.open_file", remembered)
    with opened(path) as journal:
        # From now on what is written there goes to a device that has no room
        full = os.open("/dev/full", os.O_RDWR)
        os.dup2(full, files[-1].fileno())
        os.close(full)
        with pytest.raises(InputError, match=r"study\.jsonl: cannot be written \(No space left on device\)"):
            journal.add(1, 1.0)


def test_only_finite_numbers_are_added(path):
    with opened(path) as journal, pytest.raises(ValueError, match="JSON"):
        journal.add(1, float("nan"))
    assert known(path) == {}


def test_a_removed_journal_leaves_nothing(path, tmp_path):
    with opened(path) as journal:
        journal.remove()
    assert list(tmp_path.iterdir()) == []

"""Files that are written whole or not at all: several at once, through links, with the permissions of any."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from gemrender.errors import InputError
from gemrender.writing import check_place, write_whole

NEW = {name: (lambda path, name=name: path.write_text(f"new {name}")) for name in ("a", "b", "c")}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, which the test runs in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def contents():
    """Text of each file in the folder, temporary ones too."""
    return {path.name: path.read_text() if path.is_file() else None for path in Path().iterdir()}


def refusal(writers, folder="."):
    with pytest.raises(InputError) as caught:
        write_whole(Path(folder), writers)
    return str(caught.value)


def test_all_are_written_and_nothing_else(folder):
    Path("b").write_text("old")
    assert write_whole(folder, NEW) == [folder / name for name in "abc"]
    assert contents() == {name: f"new {name}" for name in "abc"}


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), RuntimeError("disk full")])
def test_where_one_cannot_be_written_none_is(error, folder):
    Path("a").write_text("old")

    def fails(path):
        path.write_text("half")
        raise error

    said = {OSError: "No space left on device", RuntimeError: "disk full"}[type(error)]
    assert refusal({**NEW, "b": fails}) == f"b: cannot be written: {said}"
    assert contents() == {"a": "old"}


@pytest.mark.parametrize("has_links", [True, False])
@pytest.mark.parametrize("error", [OSError(5, "Input/output error"), KeyboardInterrupt()])
def test_where_one_cannot_be_moved_all_are_as_they_were(error, has_links, folder, monkeypatch):
    for name in "ac":
        Path(name).write_text("old")
    real = Path.replace

    def replace(self, target):
        if Path(target).name == "c" and self.name == "c":
            raise error
        return real(self, target)

    def no_links(self, target):
        raise PermissionError

    monkeypatch.setattr(Path, "replace", replace)
    if not has_links:
        monkeypatch.setattr(Path, "hardlink_to", no_links)
    with pytest.raises((InputError, KeyboardInterrupt)):
        write_whole(folder, NEW)
    assert contents() == {"a": "old", "c": "old"}


def test_an_interrupted_writer_leaves_nothing(folder):
    def interrupted(path):
        path.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_whole(folder, {**NEW, "c": interrupted})
    assert contents() == {}


@pytest.mark.parametrize("umask", [0o022, 0o077, 0o002])
def test_permissions_are_those_of_open(umask, folder):
    before = os.umask(umask)
    try:
        with open("plain", "w"):  # noqa: PTH123
            pass
        Path("a").write_text("old")
        Path("a").chmod(0o640)
        write_whole(folder, NEW)
    finally:
        os.umask(before)
    modes = {name: stat.S_IMODE(Path(name).stat().st_mode) for name in ("plain", "a", "b")}
    assert modes == {"plain": 0o666 & ~umask, "b": 0o666 & ~umask, "a": 0o640}


def test_a_file_that_is_write_protected_is_refused(folder, monkeypatch):
    Path("b").write_text("old")
    Path("b").chmod(0o444)
    real = os.access  # root may write what it likes
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != "b" and real(path, mode))
    assert refusal(NEW) == "b: cannot be written: Permission denied"
    assert contents() == {"b": "old"}


def test_links_stay_and_their_files_are_written(folder):
    Path("else").mkdir()
    Path("else/there").write_text("old")
    Path("a").symlink_to("else/there")
    Path("b").symlink_to("else/not-there")
    Path("c").symlink_to(Path("b").absolute())  # by way of another
    write_whole(folder, {name: NEW[name] for name in "ab"})
    assert all(Path(name).is_symlink() for name in "abc")
    assert {p.name: p.read_text() for p in Path("else").iterdir()} == {"there": "new a", "not-there": "new b"}
    write_whole(folder, {"c": NEW["c"]})
    assert Path("else/not-there").read_text() == "new c"
    assert {p.name for p in Path("else").iterdir()} == {"there", "not-there"}


def test_links_that_lead_nowhere_are_refused(folder):
    Path("a").symlink_to("a")
    Path("b").symlink_to("none/b")
    assert refusal({"a": NEW["a"]}) == "a: cannot be written: a link that leads to itself"
    assert "none: cannot be written: No such file or directory" in refusal({"b": NEW["b"]})
    assert {path.name for path in Path().iterdir()} == {"a", "b"}


def test_what_no_file_can_replace_is_refused_and_left(folder):
    Path("a").mkdir()
    os.mkfifo("b")
    Path("c").symlink_to(os.devnull)
    assert refusal({"a": NEW["a"]}) == "a: cannot be written: Is a directory"
    for name in "bc":
        allowed = "cannot be written: is no file, but a pipe, a socket or a device"
        assert refusal({name: NEW[name]}) == f"{name}: {allowed}"
    assert stat.S_ISFIFO(Path("b").stat().st_mode)
    assert stat.S_ISCHR(Path(os.devnull).stat().st_mode)


def test_a_folder_that_is_not_there_is_told(folder):
    assert refusal(NEW, "none") == "none: cannot be written: No such file or directory"
    assert refusal(NEW, "no\0ne").endswith("cannot be written: embedded null byte")


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("folder", "Is a directory"),
        ("pipe", "is no file, but a pipe, a socket or a device"),
        ("loop", "a link that leads to itself"),
        ("none/x", "No such file or directory"),
        ("a\0b", "embedded null byte"),
        ("protected", "Permission denied"),
    ],
)
def test_a_place_is_checked_before_any_work(name, said, folder, monkeypatch):
    Path("folder").mkdir()
    os.mkfifo("pipe")
    Path("loop").symlink_to("loop")
    Path("protected").write_text("old")
    real = os.access  # root may write what it likes
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != "protected" and real(path, mode))
    before = set(Path().iterdir())
    with pytest.raises(InputError) as caught:
        check_place(Path(name))
    assert str(caught.value).endswith(f": cannot be written: {said}")
    check_place(Path("new"))
    assert set(Path().iterdir()) == before

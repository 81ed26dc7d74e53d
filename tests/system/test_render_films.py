"""`gemrender render`: films of one turn, that go on where they were interrupted."""

from __future__ import annotations

import dataclasses
import json
import shutil
import signal
import sys
from pathlib import Path

import numpy as np
import pytest
from meshes import box, obj
from observations import run_python
from PIL import Image
from render_help import (
    FILM,
    interrupt_after,
    names,
)
from thorough import chosen, some

from gemrender import cli, load_setup, load_stone, render_film
from gemrender.render import frames, photoreal
from gemrender.render.photoreal import make_gems
from gemrender.scene.moves import Move


def pictures(av, path):
    with av.open(str(path)) as film:
        (stream,) = film.streams.video
        return float(stream.average_rate), [frame.to_ndarray(format="rgb24") for frame in film.decode(stream)]


def ended(*arguments):
    """Run the command line; return its exit status."""
    with pytest.raises(SystemExit) as caught:
        cli.main(list(arguments))
    return caught.value.code


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The frames of `FILM`, made in one go."""
    av = pytest.importorskip("av")
    with pytest.MonkeyPatch.context() as patched:
        patched.chdir(tmp_path_factory.mktemp("whole"))
        assert ended(*FILM) == 0
        return pictures(av, "x.mp4")[1]


@pytest.fixture(scope="module")
def two_frames(tmp_path_factory):
    """The folder that `FILM` leaves when it is interrupted before its third frame."""
    pytest.importorskip("av")
    real = frames.render

    def render(*arguments, **options):
        if options["share"] > 0.5:
            raise KeyboardInterrupt
        return real(*arguments, **options)

    with pytest.MonkeyPatch.context() as patched:
        patched.chdir(tmp_path_factory.mktemp("two"))
        patched.setattr(frames, "render", render)
        assert ended(*FILM) == 130
        return Path("x.mp4.frames").resolve()


@pytest.fixture
def begun(two_frames, folder):
    """The same as it was left, in the folder to work in: a film to go on with."""
    return shutil.copytree(two_frames, "x.mp4.frames")


def test_a_film_is_one_turn(gemrender, folder, av, turns):
    status, out, err = gemrender(*FILM, "--fps", "12")
    assert (status, out, err) == (0, "", "written: x.mp4\n")
    assert turns() == [0, 120, 240]
    assert names(".") == {"x.mp4"}
    rate, images = pictures(av, "x.mp4")
    assert rate == 12
    assert [image.shape for image in images] == [(16, 16, 3)] * 3
    assert max(image.mean() for image in images) > 30


@pytest.mark.parametrize(("at", "done"), chosen([(0, 0), (240, 2)], [(240, 2)]))
def test_a_film_goes_on_where_it_was_interrupted(at, done, whole, gemrender, folder, av, turns):
    turns.at = at
    status, out, err = gemrender(*FILM)
    assert (status, out) == (130, "")
    assert err.splitlines() == [
        "interrupted: the frames so far are in x.mp4.frames; the same command goes on from there",
        "gemrender: interrupted",
    ]
    assert names(".") == {"x.mp4.frames"}
    assert names("x.mp4.frames") == {"journal.jsonl", *(f"{k:05d}.png" for k in range(done))}
    assert turns() == [120 * k for k in range(done)]

    turns.at = None
    assert gemrender(*FILM)[0] == 0
    assert turns() == [120 * k for k in range(done, 3)]
    assert names(".") == {"x.mp4"}
    np.testing.assert_array_equal(pictures(av, "x.mp4")[1], whole)


def even_sky():
    """A set-up that stones may tilt in, and that nothing has to be traced from lights in."""
    Path("sky.toml").write_text("[sky]\nradiance = 1\n")
    return "sky.toml"


@pytest.mark.parametrize(
    ("name", "to"), chosen([("rock", ()), ("tilt", ("--to", "20"))], [("tilt", ("--to", "20"))])
)
def test_a_film_rocks_and_tilts_to_and_fro(name, to, gemrender, folder, av, turns):
    status, out, err = gemrender(*FILM[:-1], "4", "--setup", even_sky(), "--move", name, *to)
    assert (status, out, err) == (0, "", "written: x.mp4\n")
    most = 20 if to else 15
    np.testing.assert_allclose(turns(), [0, most, 0, -most], rtol=0, atol=1e-12)
    with av.open("x.mp4") as film:
        assert film.metadata["comment"].endswith(f", {name} by {most} degrees in 4 frames")


def test_python_makes_the_same_film(gemrender, folder):
    sky = even_sky()
    words = ["inoue-3", "--setup", sky, "--size", "16", "--aspect", "4:5", "--spp", "2"]
    assert gemrender("render", *words, "-o", "a.webp", "--frames", "3", "--move", "tilt")[0] == 0
    shares = []
    path = render_film("inoue-3", "b.webp", sky, frames=3, move="tilt", size=16, aspect="4:5", spp=2,
                       progress=shares.append)  # fmt: skip
    assert path.read_bytes() == Path("a.webp").read_bytes()
    assert names(".") == {sky, "a.webp", "b.webp"}
    assert shares == sorted(shares)
    assert shares[-1] == 1
    with Image.open(path) as film:
        assert (film.n_frames, film.size) == (3, (16, 20))


def test_a_film_of_another_move_is_another_film(gemrender, folder, av, turns):
    turns.at = 240
    on_ground = [*FILM, "--setup", even_sky()]
    assert gemrender(*on_ground)[0] == 130
    turns.at = None
    status, _, err = gemrender(*on_ground, "--move", "rock")
    assert status == 2
    assert err.startswith("gemrender: x.mp4.frames: holds frames of another film; ")


def write_sky(value):
    import OpenEXR

    plane = np.full((8, 16), value, np.float32)
    planes = dict.fromkeys("RGB", plane)
    OpenEXR.File({"type": OpenEXR.scanlineimage}, planes).write("sky.exr")


CHANGED = {
    "sky.exr": lambda: write_sky(2.0),
    "box.obj": lambda: obj("box.obj", box(half=(1, 1, 1.5))),
    "glass.toml": lambda: Path("glass.toml").write_text(GLASS.replace("1.6", "1.61")),
}
GLASS = "[index]\nwavelength_nm = [380, 760]\nn = [1.6, 1.5]\n"


@pytest.mark.parametrize("changed", some(CHANGED, 3))
def test_a_film_whose_files_say_something_else_is_another_film(changed, gemrender, folder, av, turns):
    write_sky(1.0)
    obj("box.obj", box())
    Path("glass.toml").write_text(GLASS)
    thing = '[[thing]]\nmesh = "box.obj"\nmaterial = "paper"\nplace = [0, 5, 0]\n'
    Path("around.toml").write_text(f'[sky]\ntype = "image"\nimage = "sky.exr"\n{thing}')
    film = [*FILM, "--setup", "around.toml", "--material", "glass.toml"]
    turns.at = 240
    assert gemrender(*film)[0] == 130
    before = {path: path.read_bytes() for path in Path("x.mp4.frames").iterdir()}
    turns.at, again = None, Path(changed).read_bytes()
    CHANGED[changed]()
    status, _, err = gemrender(*film)
    assert status == 2
    assert err.startswith("gemrender: x.mp4.frames: holds frames of another film; ")
    assert {path: path.read_bytes() for path in Path("x.mp4.frames").iterdir()} == before
    Path(changed).write_bytes(again)
    turns()
    assert gemrender(*film)[0] == 0
    assert turns() == [240]


@pytest.fixture(scope="module")
def moments():
    """A stone on white ground, by share of its turn and seed."""
    gems, setup = make_gems([load_stone("inoue-3")]), load_setup("white")
    # Without its lights, whose light the stone throws about on all of the ground: its sky is left
    setup = dataclasses.replace(setup, lights=())

    def frame(share, seed=0):
        return photoreal.render(gems, setup, width=32, height=32, spp=8, move=Move(), share=share, seed=seed)

    return {of: frame(*of) for of in ((0.0,), (1.0,), (1e-6,), (0.1,), (0.0, 1))}


def test_a_turn_ends_where_it_began(moments):
    np.testing.assert_array_equal(moments[1.0,].xyz, moments[0.0,].xyz)


def test_noise_stays_where_it_is(moments):
    """Of a stone that hardly moved nearly the same, of another seed another; of still ground the same."""
    first, nearly, later, other = (moments[of] for of in ((0.0,), (1e-6,), (0.1,), (0.0, 1)))
    stone, ground = first.albedo.min(axis=2) > 0.99, first.albedo.max(axis=2) < 0.99

    def change(picture):
        return float(np.sqrt(np.mean((picture.xyz - first.xyz)[stone] ** 2)))

    assert change(nearly) < 0.3 * change(other)
    # Only light that has been at the stone is other light
    assert (later.xyz == first.xyz)[ground].mean() > 0.3
    assert (other.xyz == first.xyz)[ground].mean() < 0.05


#: A film that is killed in the midst of a line of its journal.
KILLED = """
import os, signal, sys
from gemrender import cli
from gemrender.render import frames

class Journal(frames.Journal):
    def add(self, k, *line):
        if k == 2:
            self._file.write(f"[{k}, 0.".encode())
            os.kill(os.getpid(), signal.SIGKILL)
        super().add(k, *line)

frames.Journal = Journal
cli.main(sys.argv[1:])
"""


class KilledError(BaseException):
    """Stands for the end of a process that is killed."""


def killed_while_writing(name, monkeypatch, capsys):
    """Leave what a process leaves that is killed while it writes a file; return what it has said."""

    def half_then_killed(path, *_, **__):
        Path(path).write_bytes(b"half")
        shutil.copytree("x.mp4.frames", "left")
        raise KilledError

    save = Image.Image.save

    def save_or_end(image, path, *arguments, **options):
        writes = half_then_killed if Path(path).name == name else save.__get__(image)
        writes(path, *arguments, **options)

    with monkeypatch.context() as patched:
        patched.setattr(Image.Image, "save", save_or_end)
        if name == "x.mp4":
            patched.setattr(frames, "encode_film", half_then_killed)
        with pytest.raises(KilledError):
            cli.main(FILM)
    shutil.rmtree("x.mp4.frames")
    Path("left").rename("x.mp4.frames")
    return capsys.readouterr().err


def test_a_film_killed_three_times_is_that_of_one_go(
    whole, gemrender, folder, av, turns, monkeypatch, capsys
):
    def is_kept(done):
        lines = Path("x.mp4.frames/journal.jsonl").read_text().splitlines()[1:]
        assert [json.loads(line)[0] for line in lines[:done]] == list(range(done))
        assert not Path("x.mp4").exists()

    assert killed_while_writing("00001.png", monkeypatch, capsys) == ""
    assert turns() == [0, 120]
    is_kept(1)
    killed = run_python("-c", KILLED, *FILM)
    assert (killed.returncode, killed.stdout) == (-signal.SIGKILL, "")
    is_kept(2)
    assert "a line that is no entry is left out" in killed_while_writing("x.mp4", monkeypatch, capsys)
    assert turns() == [240]
    is_kept(3)
    assert gemrender(*FILM) == (0, "", "written: x.mp4\n")
    assert turns() == []
    assert names(".") == {"x.mp4"}
    np.testing.assert_array_equal(pictures(av, "x.mp4")[1], whole)


def damaged(folder, what):
    """Damage the frames of a film; return which ones are lost."""
    frame, journal = folder / "00001.png", folder / "journal.jsonl"
    lines = journal.read_text().splitlines()
    if what == "an empty frame":
        frame.write_bytes(b"")
    elif what == "half a frame":
        frame.write_bytes(frame.read_bytes()[:-20])
    elif what == "a frame of another turn":
        frame.write_bytes((folder / "00000.png").read_bytes())
    elif what == "no frame":
        frame.unlink()
    elif what == "a lost line":
        journal.write_text("\n".join([lines[0], *lines[2:]]) + "\n")
        return [0]
    elif what == "lines that are none":
        journal.write_text("\n".join([lines[0], "[0, NaN, 1]", '[1, -1.0, "a"]', "[true]", "[7, 1.0, 2]"]))
        return [0, 1]
    elif what == "another exposure":
        k, exposure, digest = json.loads(lines[2])
        journal.write_text("\n".join([*lines[:2], json.dumps([k, 2 * exposure, digest])]))
    else:
        (folder / ".gemrender-killed").mkdir()
        (folder / ".gemrender-killed/00001.png").write_bytes(b"half")
        return []
    return [1]


DAMAGE = [
    "half a frame", "a lost line", "another exposure", "what a killed process left",
    "an empty frame", "a frame of another turn", "no frame", "lines that are none",
]  # fmt: skip


@pytest.mark.parametrize("what", chosen(DAMAGE, DAMAGE[:2]))
def test_frames_that_are_not_as_they_were_are_rendered_again(what, begun, gemrender, av, turns):
    lost = damaged(Path("x.mp4.frames"), what)
    assert gemrender(*FILM)[0] == 0
    assert turns() == [120 * k for k in (*lost, 2)]
    assert names(".") == {"x.mp4"}
    assert len(pictures(av, "x.mp4")[1]) == 3


@pytest.mark.parametrize("text", chosen([None, "", '{"film": "12'], ['{"film": "12']))
def test_a_folder_of_frames_without_a_head_is_begun_anew(text, gemrender, folder, av, turns):
    Path("x.mp4.frames").mkdir()
    if text is not None:
        Path("x.mp4.frames/journal.jsonl").write_text(text)
    assert gemrender(*FILM[:-1], "2")[0] == 0
    assert names(".") == {"x.mp4"}


def test_a_film_is_made_by_one_process_at_a_time(begun, gemrender, monkeypatch):
    inner = []
    real = frames.render

    def render(*arguments, **options):
        monkeypatch.setattr(frames, "render", real)
        inner.append(gemrender(*FILM))
        return real(*arguments, **options)

    monkeypatch.setattr(frames, "render", render)
    assert gemrender(*FILM)[0] == 0
    said = "gemrender: x.mp4.frames/journal.jsonl: is in use: another gemrender is at the same work\n"
    assert inner == [(2, "", said)]


def test_what_else_is_in_the_folder_is_kept(begun, gemrender):
    Path("x.mp4.frames/notes.txt").write_text("mine")
    assert gemrender(*FILM)[0] == 0
    assert names("x.mp4.frames") == {"notes.txt"}


def test_a_frame_that_is_not_done_is_none(gemrender, folder, av, short_passes, monkeypatch):
    interrupt_after(monkeypatch, 3)  # in the second pass of the second frame
    assert gemrender(*FILM, "--spp", "8")[0] == 130
    assert names("x.mp4.frames") == {"journal.jsonl", "00000.png"}


@pytest.mark.parametrize(
    "other",
    [
        ["--seed", "1"],
        ["--frames", "4"],
        ["--material", "ruby"],
        ["--carat", "3"],
        ["--exposure", "1"],
        ["--setup", "white"],
    ],
    ids=" ".join,
)
def test_frames_of_another_film_are_refused_and_kept(other, begun, gemrender):
    before = {path: path.read_bytes() for path in Path("x.mp4.frames").iterdir()}
    assert {path.name for path in before} == {"journal.jsonl", "00000.png", "00001.png"}
    status, out, err = gemrender(*FILM, *other)
    assert (status, out) == (2, "")
    assert err == (
        "gemrender: x.mp4.frames: holds frames of another film; remove it, or give the film another name\n"
    )
    assert {path: path.read_bytes() for path in Path("x.mp4.frames").iterdir()} == before
    assert names(".") == {"x.mp4.frames"}


def test_a_folder_that_is_no_films_is_refused(gemrender, folder, av, turns):
    Path("x.mp4.frames").mkdir()
    Path("x.mp4.frames/holiday.txt").write_text("dear diary")
    assert gemrender(*FILM)[0] == 2
    for text in ("dear diary", "[]", '"x"', json.dumps({"film": "x"})):
        Path("x.mp4.frames/journal.jsonl").write_text(text)
        status, _, err = gemrender(*FILM)
        assert (status, err.count("\n")) == (2, 1), text
        assert err.startswith("gemrender: x.mp4.frames")
    assert turns() == []
    assert names("x.mp4.frames") == {"holiday.txt", "journal.jsonl"}


def test_without_the_library_a_film_is_one_line_with_the_cure(gemrender, folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    status, out, err = gemrender(*FILM)
    assert (status, out, err.count("\n")) == (1, "", 1)
    assert err.endswith("to cure it: pip install av\n")
    assert names(".") == set()


def test_a_full_disk_leaves_no_half_frame(gemrender, folder, av, monkeypatch):
    def full(self, path, *_, **__):
        Path(str(path)).write_bytes(b"half")
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr("PIL.Image.Image.save", full)
        status, out, err = gemrender(*FILM[:-1], "2")
    assert (status, out) == (2, "")
    assert err == "gemrender: x.mp4.frames/00000.png: cannot be written: No space left on device\n"
    assert names("x.mp4.frames") == {"journal.jsonl"}
    assert gemrender(*FILM[:-1], "2")[0] == 0  # once there is room

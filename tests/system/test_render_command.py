"""`gemrender render` and `gemrender scene --setup`: what they write, how they end, and what they refuse."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from observations import TERMINAL_VARIABLES, run_python

from gemrender import cli
from gemrender.colorimetry import colour_matching, luminance_weights, y_integral_nm
from gemrender.render import frames, passes, photoreal
from gemrender.scene.setup import bundled_setups
from gemrender.stone import load_stone
from gemrender.stone.files import save_vertices

#: The paper's light; a set-up that shows no ground.
HEMISPHERE = ["--setup", "hemisphere"]
#: A picture that is rendered in an instant.
SMALL = [*HEMISPHERE, "--size", "16", "--spp", "4"]
#: What an EXR holds besides spectral bins.
CHANNELS = {
    *"RGBXYZ", "coverage", *(f"albedo.{c}" for c in "RGB"), *(f"normal.{c}" for c in "XYZ"),
}  # fmt: skip


@pytest.fixture
def gemrender(capsys, monkeypatch):
    """Run the command line in this process; returns exit status, stdout and stderr."""
    for variable in TERMINAL_VARIABLES:
        monkeypatch.delenv(variable, raising=False)

    def run(*arguments):
        with pytest.raises(SystemExit) as caught:
            cli.main([str(argument) for argument in arguments])
        return (caught.value.code, *capsys.readouterr())

    return run


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def render(gemrender, folder):
    """Render a picture that succeeds; returns what is said, without its line end."""

    def run(*arguments):
        status, out, err = gemrender("render", *arguments)
        assert (status, out) == (0, ""), err
        assert err.count("\n") == 1
        return err.rstrip()

    return run


@pytest.fixture
def short_passes(monkeypatch):
    """Passes of four samples a pixel, of pictures of 16 x 16."""
    monkeypatch.setattr(passes, "PASS_SAMPLES", 1 << 10)


def read_exr(path):
    """Return an EXR's channels and its attributes."""
    import OpenEXR

    file = OpenEXR.File(str(path), separate_channels=True)
    return {name: channel.pixels for name, channel in file.channels().items()}, file.header()


def read_png(path):
    image = pytest.importorskip("PIL.Image")
    with image.open(path) as opened:
        opened.load()
        return np.asarray(opened), opened.text


def samples_and_noise(said):
    """What a finished picture says of itself."""
    found = re.search(r"\((\d+) samples a pixel, noise ([^,]+), ([\d.]+) s, exposure ([^)]+)\)", said)
    assert found, said
    known = found[2].removesuffix(" of the stones")
    return int(found[1]), float("inf") if known == "not known of one pass" else float(known)


def names(folder):
    return {path.name for path in Path(folder).iterdir()}


def on_the_stone(channels):
    return channels["coverage"] > 0.99


# ---- Pictures ------------------------------------------------------------------------------------------


def test_a_png_is_written_with_what_it_shows(render):
    said = render("inoue-3", "-o", "a.png", *HEMISPHERE, "--size", "24x16", "--spp", "5")
    assert re.fullmatch(r"written: a\.png \(5 samples a pixel, noise .*, .* s, exposure .*\)", said)
    pixels, texts = read_png("a.png")
    assert (pixels.shape, pixels.dtype) == ((16, 24, 3), np.uint8)
    assert texts["Title"] == "Inoue sample 3 (diamond)"
    assert texts["Description"] == "set-up Face-up under a hemisphere, 5 samples a pixel"
    assert names(".") == {"a.png"}
    middle, corner = pixels[4:12, 8:16], pixels[0, 0]
    assert middle.mean() > 30  # a stone
    assert corner.max() == 0  # before nothing


def test_an_exr_is_written_with_all_that_is_known(render):
    render("inoue-3", "-o", "a.EXR", *SMALL)
    channels, header = read_exr("a.EXR")
    assert set(channels) == CHANNELS
    assert "spectralLayoutVersion" not in header
    assert all(plane.shape == (16, 16) and np.isfinite(plane).all() for plane in channels.values())
    # Linear values, unexposed: the sky has radiance 1, and what a stone shows is never brighter
    stone = on_the_stone(channels)
    assert 0.3 < channels["Y"][stone].mean() < 1
    rgb = np.stack([channels[c] for c in "RGB"], axis=-1)
    np.testing.assert_allclose(rgb @ luminance_weights(), channels["Y"], rtol=0, atol=1e-4)  # D65 is white
    assert (channels["albedo.R"][stone] > 0.99).all()
    assert (channels["normal.Z"][7:9, 7:9] > 0.99).all()  # the table
    assert channels["coverage"][0, 0] == 0


def test_spectral_bins_are_there_and_their_sum_is_the_luminance(render):
    render("inoue-3", "-o", "a.exr", *SMALL, "--spp", "16", "--bins", "76")
    channels, header = read_exr("a.exr")
    assert header["spectralLayoutVersion"] == "1.0"
    middles = np.arange(382.5, 760, 5)
    bins = [f"S0.{nm:.6f}".replace(".", ",").replace(",", ".", 1) + "nm" for nm in middles]
    assert set(channels) == CHANNELS | set(bins)
    spectrum = np.stack([channels[name] for name in bins], axis=-1)
    y = spectrum @ colour_matching(middles)[:, 1] * 5 / y_integral_nm()
    # The samples are the same; all that differs is ybar within a bin
    np.testing.assert_allclose(y, channels["Y"], rtol=0, atol=0.02)
    assert y.mean() == pytest.approx(channels["Y"].mean(), rel=2e-3)


def test_bins_cover_the_range_that_is_asked_for(render):
    render("inoue-3", "-o", "a.exr", *SMALL, "--bins", "2", "--range", "450,650")
    channels, _ = read_exr("a.exr")
    assert set(channels) - CHANNELS == {"S0.500,000000nm", "S0.600,000000nm"}


def test_the_same_seed_gives_the_same_picture_and_another_another(render):
    for name, seed in (("a", 5), ("b", 5), ("c", 6)):
        render("inoue-3", "-o", f"{name}.exr", *SMALL, "--seed", seed)
    a, b, c = (read_exr(f"{name}.exr")[0] for name in "abc")
    for name in CHANNELS:
        np.testing.assert_array_equal(a[name], b[name], err_msg=name)
    assert (a["Y"] != c["Y"])[on_the_stone(a)].mean() > 0.9
    assert a["Y"].mean() == pytest.approx(c["Y"].mean(), rel=0.1)


def test_options_reach_the_picture(render):
    def picture(*options):
        render("inoue-3", "-o", "a.exr", *SMALL, *options)
        return read_exr("a.exr")[0]

    plain = picture()
    assert (picture("--no-dispersion")["Y"] != plain["Y"]).any()
    ruby = picture("--material", "ruby")
    assert ruby["R"].mean() > 1.3 * ruby["G"].mean()
    # The larger, the longer the way of light in it
    for size in (["--diameter", "30"], ["--carat", "100"]):
        assert picture("--material", "ruby", *size)["R"].mean() < 0.7 * ruby["R"].mean()
    turned = picture("--turn", "20")
    assert np.abs(turned["Y"] - plain["Y"]).max() > 0.1
    assert turned["coverage"].mean() == pytest.approx(plain["coverage"].mean(), rel=0.02)


def test_exposure_and_curve_change_the_png_only(render):
    def mean(*options):
        render("inoue-3", "-o", "a.png", *SMALL, "--size", "32", *options)
        return float(read_png("a.png")[0].mean())

    plain = mean()
    assert mean("--exposure", "-2") < 0.8 * plain
    assert mean("--exposure", "1") > 1.05 * plain
    assert mean("--curve", "linear") != plain
    images = []
    for exposure in ("0", "-2"):
        render("inoue-3", "-o", "a.exr", *SMALL, "--exposure", exposure)
        images.append(read_exr("a.exr")[0]["Y"])
    np.testing.assert_array_equal(*images)


def test_a_stone_of_a_bare_index_can_be_pictured(render):
    text = (Path(__file__).parents[2] / "scenes" / "inoue-3.toml").read_text(encoding="utf-8")
    Path("x.toml").write_text(f"{text}\n[material]\nindex = 1.76\n", encoding="utf-8")
    render("x.toml", "-o", "a.png", *SMALL)
    assert read_png("a.png")[1]["Title"] == "Inoue sample 3 (index 1.76)"


def test_a_measured_stone_in_a_material_of_its_own_can_be_pictured(render):
    save_vertices(load_stone("inoue-3"), "x.csv")
    Path("glass.toml").write_text('name = "Glass"\n[index]\nwavelength_nm = [380, 760]\nn = [1.6, 1.5]\n')
    render("x.csv", "-o", "a.png", *SMALL, "--material", "glass.toml")
    assert read_png("a.png")[1]["Title"] == "x (Glass)"


# ---- What is seen --------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def face_up(tmp_path_factory):
    """Mean luminance of samples 1 and 3 alone, under the hemisphere."""
    means, folder = {}, tmp_path_factory.mktemp("face-up")
    for name in ("inoue-1", "inoue-3"):
        path = folder / f"{name}.exr"
        with pytest.raises(SystemExit) as caught:
            cli.main(["render", name, "-o", str(path), *HEMISPHERE, "--size", "48", "--spp", "32"])
        assert caught.value.code == 0
        channels, _ = read_exr(path)
        means[name] = channels["Y"], on_the_stone(channels)
    return means


def test_sample_1_is_darker_than_sample_3(face_up):
    """Inoue's paper: sample 1, with its deep pavilion, loses light below the girdle."""
    mean_1, mean_3 = (float(y[stone].mean()) for y, stone in face_up.values())
    assert mean_1 < 0.95 * mean_3


def test_sample_1_shows_a_dark_ring_at_its_rim(face_up):
    """Within it sample 1 is bright, and sample 3 has none."""

    def within_and_rim(name):
        y, stone = face_up[name]
        n = len(y)
        across = (np.arange(n) + 0.5 - n / 2) * 2 * 1.12 / n  # the set-up's margin
        radius = np.hypot(*np.meshgrid(across, across))
        return float(y[radius < 0.75].mean()), float(y[stone & (radius > 0.8)].mean())

    (within_1, rim_1), (within_3, rim_3) = within_and_rim("inoue-1"), within_and_rim("inoue-3")
    assert within_1 > 0.85
    assert rim_1 < 0.85 * within_1
    assert rim_1 < 0.85 * rim_3
    assert rim_3 > 0.95 * within_3


def test_stones_stand_side_by_side_in_their_order(render, face_up):
    (mean_1, mean_3) = (float(y[stone].mean()) for y, stone in face_up.values())
    for order in (("inoue-1", "inoue-3"), ("inoue-3", "inoue-1")):
        render(*order, "-o", "a.exr", *HEMISPHERE, "--size", "96x40", "--spp", "16")
        channels, header = read_exr("a.exr")
        stone = on_the_stone(channels)
        assert not stone[:, 46:50].any()  # the gap
        halves = [
            float(channels["Y"][:, half][stone[:, half]].mean()) for half in (slice(48), slice(48, None))
        ]
        alone = {"inoue-1": mean_1, "inoue-3": mean_3}
        for name, mean in zip(order, halves, strict=True):
            # A neighbour takes a little light from the horizon
            assert mean == pytest.approx(alone[name], rel=0.04), name
        assert (halves[0] < halves[1]) == (order[0] == "inoue-1")
        shown = {"inoue-1": "Inoue sample 1 (diamond)", "inoue-3": "Inoue sample 3 (diamond)"}
        assert header["Title"] == ", ".join(shown[name] for name in order)


@pytest.mark.parametrize("setup", bundled_setups())
def test_every_setup_makes_a_picture(setup, render):
    render("inoue-3", "-o", "a.exr", "--setup", setup, "--size", "16", "--spp", "8")
    channels, _ = read_exr("a.exr")
    assert all(np.isfinite(plane).all() for plane in channels.values())
    assert channels["Y"].min() >= 0
    assert on_the_stone(channels).any()
    assert np.ptp(channels["Y"]) > 0.01


# ---- Where it ends -------------------------------------------------------------------------------------


def test_it_ends_at_a_noise(render, short_passes):
    samples, noise = samples_and_noise(render("inoue-3", "-o", "a.png", *SMALL[:4], "--noise", "0.1"))
    assert noise <= 0.1
    assert 8 <= samples < 500
    assert samples % 4 == 0


def test_it_ends_at_the_samples_where_those_come_first(render, short_passes):
    said = render("inoue-3", "-o", "a.png", *SMALL, "--spp", "12", "--noise", "0.0001", "--time", "60")
    assert samples_and_noise(said)[0] == 12


def test_it_ends_after_a_time(render, short_passes):
    said = render("inoue-3", "-o", "a.png", *SMALL[:4], "--time", "0.5")
    samples, _ = samples_and_noise(said)
    assert samples >= 4
    seconds = float(re.search(r"([\d.]+) s,", said)[1])
    assert seconds < 10  # the first pass may have to be compiled


def test_however_short_the_time_a_pass_is_rendered(render, short_passes):
    assert samples_and_noise(render("inoue-3", "-o", "a.png", *SMALL[:4], "--time", "1e-9"))[0] == 4


def interrupt_after(monkeypatch, n):
    """Send what Ctrl-C sends, during pass n + 1."""
    add, done = passes.Passes.add, []

    def add_or_stop(self, spp):
        if len(done) == n:
            signal.raise_signal(signal.SIGINT)
        add(self, spp)
        done.append(spp)

    monkeypatch.setattr(passes.Passes, "add", add_or_stop)
    return done


@pytest.mark.parametrize("name", ["a.png", "a.exr"])
def test_an_interruption_keeps_what_is_done(name, gemrender, folder, monkeypatch, short_passes):
    done = interrupt_after(monkeypatch, 2)
    status, out, err = gemrender("render", "inoue-3", "-o", name, *SMALL, "--spp", "100")
    assert (status, out, done) == (130, "", [4, 4])
    first, *others = err.splitlines()
    assert samples_and_noise(first)[0] == 8
    assert others == ["interrupted: the picture holds what was done", "gemrender: interrupted"]
    assert names(".") == {name}


def test_interrupted_it_is_the_picture_of_as_many_samples(gemrender, folder, monkeypatch, short_passes):
    gemrender("render", "inoue-3", "-o", "a.exr", *SMALL, "--spp", "8")
    interrupt_after(monkeypatch, 2)
    assert gemrender("render", "inoue-3", "-o", "b.exr", *SMALL, "--spp", "100")[0] == 130
    np.testing.assert_array_equal(read_exr("a.exr")[0]["Y"], read_exr("b.exr")[0]["Y"])


def test_an_interruption_before_the_first_pass_leaves_nothing(gemrender, folder, monkeypatch):
    interrupt_after(monkeypatch, 0)
    status, out, err = gemrender("render", "inoue-3", "-o", "a.png", *SMALL)
    assert (status, out, err) == (130, "", "gemrender: interrupted\n")
    assert names(".") == set()


# ---- Films ---------------------------------------------------------------------------------------------

FILM = ["render", "inoue-3", "-o", "x.mp4", *SMALL, "--frames", "3"]


@pytest.fixture
def av():
    return pytest.importorskip("av")


@pytest.fixture
def turns(monkeypatch):
    """The turns that frames are rendered at; `at` is one that Ctrl-C comes at [deg]."""
    rendered, real = [], frames.render

    def render(*arguments, **options):
        if options["turn_deg"] == turns.at:
            raise KeyboardInterrupt
        rendered.append(options["turn_deg"])
        return real(*arguments, **options)

    def turns():
        return [rendered.pop(0) for _ in range(len(rendered))]

    turns.at = None
    monkeypatch.setattr(frames, "render", render)
    return turns


def pictures(av, path):
    with av.open(str(path)) as film:
        (stream,) = film.streams.video
        return float(stream.average_rate), [frame.to_ndarray(format="rgb24") for frame in film.decode(stream)]


def test_a_film_is_one_turn(gemrender, folder, av, turns):
    status, out, err = gemrender(*FILM, "--fps", "12")
    assert (status, out, err) == (0, "", "written: x.mp4\n")
    assert turns() == [0, 120, 240]
    assert names(".") == {"x.mp4"}
    rate, images = pictures(av, "x.mp4")
    assert rate == 12
    assert [image.shape for image in images] == [(16, 16, 3)] * 3
    assert max(image.mean() for image in images) > 30


@pytest.mark.parametrize(("at", "done"), [(0, 0), (240, 2)])
def test_a_film_goes_on_where_it_was_interrupted(at, done, gemrender, folder, av, turns):
    assert gemrender(*FILM)[0] == 0
    whole = pictures(av, "x.mp4")
    Path("x.mp4").unlink()
    turns()

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
    np.testing.assert_array_equal(pictures(av, "x.mp4")[1], whole[1])


#: A film that is killed where the first argument says.
KILLED = """
import os, signal, sys
from pathlib import Path
from PIL import Image
from gemrender import cli
from gemrender.render import frames

def half_then_killed(path, *_, **__):
    Path(path).write_bytes(b"half")
    os.kill(os.getpid(), signal.SIGKILL)

class Journal(frames.Journal):
    def add(self, k, *line):
        if k == 2:
            self._file.write(f"[{k}, 0.".encode())
            os.kill(os.getpid(), signal.SIGKILL)
        super().add(k, *line)

where, *arguments = sys.argv[1:]
save = Image.Image.save
if where == "frame":
    Image.Image.save = lambda image, path, *a, **b: (
        half_then_killed if Path(path).name == "00001.png" else save.__get__(image))(path, *a, **b)
elif where == "journal":
    frames.Journal = Journal
else:
    frames.encode_film = half_then_killed
cli.main(arguments)
"""


def test_a_film_killed_three_times_is_that_of_one_go(gemrender, folder, av, turns, monkeypatch):
    for where, done in (("frame", 1), ("journal", 2), ("film", 3)):
        killed = run_python("-c", KILLED, where, *FILM)
        assert (killed.returncode, killed.stdout) == (-signal.SIGKILL, "")
        lines = Path("x.mp4.frames/journal.jsonl").read_text().splitlines()[1:]
        assert [json.loads(line)[0] for line in lines[:done]] == list(range(done))
        assert not Path("x.mp4").exists()
    assert gemrender(*FILM) == (0, "", "written: x.mp4\n")
    assert turns() == []
    assert names(".") == {"x.mp4"}
    resumed = pictures(av, "x.mp4")
    assert gemrender(*FILM)[0] == 0
    assert len(turns()) == 3
    np.testing.assert_array_equal(resumed[1], pictures(av, "x.mp4")[1])


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


@pytest.mark.parametrize(
    "what",
    ["an empty frame", "half a frame", "a frame of another turn", "no frame", "a lost line",
     "lines that are none", "another exposure", "what a killed process left"],
)  # fmt: skip
def test_frames_that_are_not_as_they_were_are_rendered_again(what, gemrender, folder, av, turns):
    turns.at = 240
    assert gemrender(*FILM)[0] == 130
    turns()
    lost = damaged(Path("x.mp4.frames"), what)
    turns.at = None
    assert gemrender(*FILM)[0] == 0
    assert turns() == [120 * k for k in (*lost, 2)]
    assert names(".") == {"x.mp4"}
    assert len(pictures(av, "x.mp4")[1]) == 3


@pytest.mark.parametrize("text", [None, "", '{"film": "12'])
def test_a_folder_of_frames_without_a_head_is_begun_anew(text, gemrender, folder, av, turns):
    Path("x.mp4.frames").mkdir()
    if text is not None:
        Path("x.mp4.frames/journal.jsonl").write_text(text)
    assert gemrender(*FILM)[0] == 0
    assert names(".") == {"x.mp4"}


def test_a_film_is_made_by_one_process_at_a_time(gemrender, folder, av, turns, monkeypatch):
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


def test_what_else_is_in_the_folder_is_kept(gemrender, folder, av, turns):
    turns.at = 120
    gemrender(*FILM)
    Path("x.mp4.frames/notes.txt").write_text("mine")
    turns.at = None
    assert gemrender(*FILM)[0] == 0
    assert names("x.mp4.frames") == {"notes.txt"}


def test_a_frame_that_is_not_done_is_none(gemrender, folder, av, monkeypatch):
    interrupt_after(monkeypatch, 3)  # in the second pass of the second frame
    assert gemrender(*FILM)[0] == 130
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
def test_frames_of_another_film_are_refused_and_kept(other, gemrender, folder, av, turns):
    turns.at = 120
    gemrender(*FILM)
    before = {path: path.read_bytes() for path in Path("x.mp4.frames").iterdir()}
    turns.at = None
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


# ---- The denoiser --------------------------------------------------------------------------------------


def roughness(y):
    """Mean difference of neighbours."""
    return float(np.abs(np.diff(y, axis=0)).mean() + np.abs(np.diff(y, axis=1)).mean())


def test_a_denoised_picture_is_smoother_and_as_bright(render):
    pytest.importorskip("mitsuba_oidn")
    options = ["--setup", "white", "--size", "40", "--spp", "4"]
    images = []
    for more in ([], ["--denoise"], ["--spp", "128"]):
        render("inoue-3", "-o", "a.exr", *options, *more)
        images.append(read_exr("a.exr")[0]["Y"].astype(np.float64))
    noisy, smooth, truth = images
    assert roughness(smooth) < 0.9 * roughness(noisy)
    assert smooth.mean() == pytest.approx(noisy.mean(), rel=0.03)
    assert np.mean((smooth - truth) ** 2) < 0.7 * np.mean((noisy - truth) ** 2)


def test_a_denoised_picture_keeps_colours_outside_the_gamut(render):
    """Fire is more saturated than a screen: its negative components survive."""
    pytest.importorskip("mitsuba_oidn")
    options = ["--setup", "fire", "--size", "48", "--spp", "8"]
    lowest = []
    for more in ([], ["--denoise"]):
        render("inoue-3", "-o", "a.exr", *options, *more)
        channels, _ = read_exr("a.exr")
        assert all(np.isfinite(plane).all() for plane in channels.values())
        lowest.append(min(float(channels[c].min()) for c in "RGB"))
    assert max(lowest) < -0.01


def test_without_the_denoiser_it_is_one_line_with_the_cure(gemrender, folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    monkeypatch.setattr(photoreal, "render", lambda *_, **__: pytest.fail("told before any work"))
    status, out, err = gemrender("render", "inoue-3", "-o", "a.png", *SMALL, "--denoise")
    assert (status, out, err.count("\n")) == (1, "", 1)
    assert err.startswith("gemrender: the denoiser cannot be imported (")
    assert err.endswith("to cure it: pip install mitsuba-oidn\n")
    assert names(".") == set()


# ---- Bad input -----------------------------------------------------------------------------------------

RENDER = "render inoue-3 -o a.png"
SCENE = "scene inoue-3 --out s"
BAD_INPUT = {
    "render": "STONE: missing: stone files, or names of bundled stones",
    "render inoue-3": "--out: missing: picture or film to write, or the folder for it: .png, ",
    "render inoue-9 -o a.png": "inoue-9: no such file; the bundled stones are fish-eye, ",
    "render inoue-3 -o a.bmp": "--out = 'a.bmp': must end in .png, .jpg, .jpeg, .webp, .exr, .mp4",
    "render inoue-3 -o a": "--out = 'a': must end in .png, .jpg, .jpeg, .webp, .exr, .mp4",
    "render inoue-3 -o text.txt/a.png": "--out = 'text.txt': must be a folder that can be written: is a file",
    "render inoue-3 -o /proc/a.png": "--out = '/proc': must be a folder that can be written: ",
    f"{RENDER} --material unobtainium": "--material = 'unobtainium': must be one of blue sapphire, ",
    f"{RENDER} --material no.toml": "no.toml: no such file",
    "render odd.toml -o a.png": "odd.toml: material.name = 'unobtainium': must be one of blue sapphire, ",
    f"{RENDER} --setup studoi": "--setup = 'studoi': must be a set-up file or one of fire, ",
    f"{RENDER} --setup no.toml": "no.toml: no such file",
    f"{RENDER} --setup dark.toml": "dark.toml: [[light]]: needs a light or a sky with a radiance above 0",
    f"{RENDER} --setup near.toml": "near.toml: camera.distance = 0.3: is too near to see Inoue sample 3 ",
    f"{RENDER} --curve log": "--curve = 'log': must be one of linear, filmic",
    f"{RENDER} --size 0": "--size = '0': must be a number of pixels or two, as 1024 or 1600x900, from 1 to ",
    f"{RENDER} --size -5": "--size = '-5': must be a number of pixels or two",
    f"{RENDER} --size 70000": "--size = '70000': must be a number of pixels or two",
    f"{RENDER} --size 12x": "--size = '12x': must be a number of pixels or two",
    f"{RENDER} --size 12x0": "--size = '12x0': must be a number of pixels or two",
    f"{RENDER} --size 1x2x3": "--size = '1x2x3': must be a number of pixels or two",
    f"{RENDER} --size 1{'0' * 9999}": f"--size = '1{'0' * 57}…: must be a number of pixels or two",
    f"{RENDER} --spp 0": "--spp = 0: must be from 1 to 16777216",
    f"{RENDER} --spp many": "--spp = 'many': must be a whole number",
    f"{RENDER} --noise 0": "--noise = 0.0: must be from 0.00001 to 1",
    f"{RENDER} --noise nan": "--noise = 'nan': must be a finite number",
    f"{RENDER} --time 0": "--time = 0.0: must be above 0 [s]",
    f"{RENDER} --time -1": "--time = -1.0: must be above 0 [s]",
    f"{RENDER} --seed -1": "--seed = -1: must be from 0 to 1073741823",
    f"{RENDER} --seed x": "--seed = 'x': must be a whole number",
    f"{RENDER} --carat 0": "--carat = 0.0: must be a finite number above 0",
    f"{RENDER} --carat heavy": "--carat = 'heavy': must be a finite number of carats",
    f"{RENDER} --diameter 0": "--diameter = 0.0: must be from 0.1 to 1000 [mm]",
    f"{RENDER} --carat 1 --diameter 6": "--carat = 1.0: give a weight or a diameter, not both",
    f"{RENDER} --carat 1 --material glass.toml": "--carat = 1.0: needs the material's density",
    f"{RENDER} --exposure 21": "--exposure = 21.0: must be from -20 to 20",
    f"{RENDER} --exposure x": "--exposure = 'x': must be a finite number of stops",
    f"{RENDER} --turn x": "--turn = 'x': must be a finite number of degrees",
    f"{RENDER} --bins 8": "--bins = 8: go into EXR pictures only",
    "render inoue-3 -o a.exr --bins 0": "--bins = 0: must be from 1 to 200",
    "render inoue-3 -o a.exr --bins x": "--bins = 'x': must be a whole number",
    "render inoue-3 -o a.exr --bins 8 --range 900,300": "--range = '900,300': must be two increasing ",
    "render inoue-3 -o a.exr --bins 8 --range 300,900": "--range = '300,900': must be two increasing ",
    "render inoue-3 -o a.exr --bins 8 --range 500": "--range = '500': must be two wavelengths, as 380,760",
    "render inoue-3 -o a.exr --bins 8 --range 500,": "--range = '500,': must be two wavelengths, as 380,760",
    f"{RENDER} --frames 9": "--frames = 9: go with a film, a file that ends in .mp4",
    "render inoue-3 -o x.mp4": "--frames: missing: a film needs a number of frames",
    "render inoue-3 -o x.mp4 --frames 1": "--frames = 1: must be from 2 to 100000",
    "render inoue-3 -o x.mp4 --frames x": "--frames = 'x': must be a whole number",
    "render inoue-3 -o x.mp4 --frames 3 --fps 0": "--fps = 0.0: must be from 1 to 240 [frames a second]",
    "render inoue-3 -o x.mp4 --frames 3 --size 15": "--size = '15x15': must be even for a film",
    "render inoue-3 -o x.mp4 --frames 3 --bins 8": "--bins = 8: go into EXR pictures only",
    "render inoue-3 -o x.mp4 --frames 3 --turn 8": "--turn = 8.0: is for still pictures only",
    f"{RENDER} --variant llvm_ad_rgb": "--variant = 'llvm_ad_rgb': must be a spectral variant, ",
    f"{RENDER} --variant spectral": "--variant = 'spectral': must be a spectral variant, ",
    f"{RENDER} --variant x_spectral": "--variant = 'x_spectral': must be one of llvm_ad_rgb, ",
    # ---- Scenes ----
    f"{SCENE} --setup studoi": "--setup = 'studoi': must be a set-up file or one of fire, ",
    f"{SCENE} --setup near.toml": "near.toml: camera.distance = 0.3: is too near to see ",
    f"{SCENE} --setup studio --resolution 9": "--resolution: is for the scored scene only, not with --setup",
    f"{SCENE} --setup studio --resolution 1024": "--resolution: is for the scored scene only, not with ",
    f"{SCENE} --setup studio --fresnel exact": "--fresnel: is for the scored scene only, not with --setup",
    f"{SCENE} --setup studio --rear position": "--rear: is for the scored scene only, not with --setup",
    f"{SCENE} --setup studio --intensity primary": "--intensity: is for the scored scene only, not with ",
    f"{SCENE} --setup studio --tilt 0": "--tilt: is for the scored scene only, not with --setup",
    f"{SCENE} --setup studio --tilt-azimuth 0": "--tilt-azimuth: is for the scored scene only, not with ",
    f"{SCENE} --stock": "--stock: is for a picture's scene only, with --setup",
    f"{SCENE} --material ruby": "--material: is for a picture's scene only, with --setup",
    f"{SCENE} --carat 1": "--carat: is for a picture's scene only, with --setup",
    f"{SCENE} --diameter 6": "--diameter: is for a picture's scene only, with --setup",
    f"{SCENE} --size 16": "--size: is for a picture's scene only, with --setup",
    f"{SCENE} --spp 16": "--spp: is for a picture's scene only, with --setup",
    f"{SCENE} --setup studio --material x": "--material = 'x': must be one of blue sapphire, ",
    f"{SCENE} --setup studio --carat x": "--carat = 'x': must be a finite number of carats",
    f"{SCENE} --setup studio --size 0": "--size = '0': must be a number of pixels or two",
    f"{SCENE} --setup studio --spp 0": "--spp = 0: must be from 1 to 16777216",
    f"{SCENE} --setup studio --variant scalar_rgb": "--variant = 'scalar_rgb': scalar variants are refused",
    "scene inoue-3 --setup studio --out text.txt": "--out = 'text.txt': must be a folder that can be written",
}


@pytest.mark.parametrize(("line", "words"), BAD_INPUT.items(), ids=[line[:70] for line in BAD_INPUT])
def test_bad_input_is_one_line_that_says_what_is_allowed(line, words, gemrender, folder):
    Path("text.txt").write_text("text")
    Path("dark.toml").write_text('name = "Cellar"\n')
    Path("near.toml").write_text("[sky]\nradiance = 1\n[camera]\ndistance = 0.3\n")
    Path("glass.toml").write_text("[index]\nwavelength_nm = [380, 760]\nn = [1.6, 1.5]\n")
    shape = "table = 54\nstar = 57\nlower_girdle_contact = 20\ncrown_height = 15\npavilion_depth = 43\n"
    Path("odd.toml").write_text(
        f'[proportions]\n{shape}girdle_thickness = 3\n[material]\nname = "unobtainium"\n'
    )
    before = sorted(folder.rglob("*"))

    status, out, err = gemrender(*line.split())

    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert err.startswith(f"gemrender: {words}")
    assert sorted(folder.rglob("*")) == before  # nothing is written, no folder made


@pytest.mark.parametrize("name", ["a.png", "a.exr"])
def test_a_folder_that_may_not_be_written_is_told_before_any_work(name, gemrender, folder, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.TemporaryFile", refuse)
    monkeypatch.setattr(photoreal, "render", lambda *_, **__: pytest.fail("told before any work"))
    status, out, err = gemrender("render", "inoue-3", "-o", name, *SMALL)
    assert (status, out) == (2, "")
    assert err == "gemrender: --out = '.': must be a folder that can be written: Permission denied\n"


@pytest.mark.parametrize("name", ["a.png", "a.exr"])
def test_a_full_disk_is_one_line_and_leaves_what_was_there(name, gemrender, folder, monkeypatch):
    Path(name).write_bytes(b"before")

    def full(self, path, *_, **__):
        Path(str(path)).write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("PIL.Image.Image.save", full)
    monkeypatch.setattr("OpenEXR.File.write", full)
    status, out, err = gemrender("render", "inoue-3", "-o", name, *SMALL)
    assert (status, out, err) == (2, "", f"gemrender: {name}: cannot be written: No space left on device\n")
    assert [path.read_bytes() for path in folder.iterdir()] == [b"before"]


def test_a_full_disk_leaves_no_half_frame(gemrender, folder, av, monkeypatch):
    def full(self, path, *_, **__):
        Path(str(path)).write_bytes(b"half")
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr("PIL.Image.Image.save", full)
        status, out, err = gemrender(*FILM)
    assert (status, out) == (2, "")
    assert err == "gemrender: x.mp4.frames/00000.png: cannot be written: No space left on device\n"
    assert names("x.mp4.frames") == {"journal.jsonl"}
    assert gemrender(*FILM)[0] == 0  # once there is room


# ---- Scenes of pictures --------------------------------------------------------------------------------

MITSUBA = Path(sys.executable).with_name("mitsuba")


def luminance(path):
    channels, _ = read_exr(path)
    rgb = np.stack([channels[c] for c in "RGB"], axis=-1)
    assert np.isfinite(rgb).all()
    return rgb @ luminance_weights()


@pytest.mark.skipif(not MITSUBA.exists(), reason="needs Mitsuba's program")
@pytest.mark.parametrize("setup", bundled_setups())
def test_a_stock_scene_is_rendered_by_mitsubas_own_program(setup, gemrender, folder):
    options = ["--setup", setup, "--stock", "--size", "24x16", "--spp", "4"]
    status, out, err = gemrender("scene", "inoue-3", "inoue-1", "--out", "s", *options)
    path = Path(f"s/inoue-3-inoue-1-{setup}.xml")
    assert (status, out, err) == (0, "", f"written: {path}\n")
    text = path.read_text(encoding="utf-8")
    assert "gem_" not in text
    assert f"mitsuba {path.name}" in text.partition("-->")[0]
    done = subprocess.run(
        [str(MITSUBA), "-m", "scalar_rgb", path.name, "-o", "x.exr"],
        cwd="s", capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    image = luminance("s/x.exr")
    assert image.shape == (16, 24)
    assert image.max() > 0.01


@pytest.mark.skipif(not MITSUBA.exists(), reason="needs Mitsuba's program")
@pytest.mark.parametrize(("setup", "within"), [("hemisphere", 0.02), ("white", 0.03)])
def test_a_stock_scene_shows_what_the_picture_without_dispersion_shows(setup, within, gemrender, folder):
    options = ["--setup", setup, "--size", "16", "--spp", "128"]
    assert gemrender("render", "inoue-3", "-o", "a.exr", *options, "--no-dispersion")[0] == 0
    assert gemrender("scene", "inoue-3", "--out", ".", "--stock", *options)[0] == 0
    command = [str(MITSUBA), "-m", "scalar_rgb", f"inoue-3-{setup}.xml", "-o", "x.exr"]
    subprocess.run(command, capture_output=True, check=True, timeout=60)
    assert luminance("x.exr").mean() == pytest.approx(luminance("a.exr").mean(), rel=within)


@pytest.mark.parametrize("setup", ["hemisphere", "window", "white"])
def test_a_scene_is_read_back_and_rendered(setup, gemrender, folder, variant_llvm_ad_spectral):
    import mitsuba as mi

    options = ["--setup", setup, "--size", "16", "--spp", "4", "--material", "ruby", "--carat", "2"]
    status, out, err = gemrender("scene", "inoue-3", "--out", "s", *options)
    assert (status, out, err) == (0, "", f"written: s/inoue-3-{setup}.xml\n")
    sweep = setup == "white"
    meshes = {f"inoue-3-{setup}_stone_1.ply", f"inoue-3-{setup}_ground.ply"}
    assert names("s") == {f"inoue-3-{setup}.xml", *(meshes if sweep else {f"inoue-3-{setup}.ply"})}
    scene = mi.load_file(f"s/inoue-3-{setup}.xml")
    assert type(scene.integrator()).__name__ == "PathIntegrator"
    surfaces = [str(shape.bsdf()) for shape in scene.shapes()]
    assert sum("material = ruby" in surface for surface in surfaces) == 1
    image = np.asarray(mi.render(scene))[..., :3]
    assert image.shape == (16, 16, 3)
    assert np.isfinite(image).all()
    assert image.max() > 0.01


def test_a_scene_read_back_is_the_picture(gemrender, folder, variant_llvm_ad_spectral):
    import mitsuba as mi

    options = [*HEMISPHERE, "--size", "16", "--material", "blue sapphire", "--diameter", "9"]
    assert gemrender("render", "inoue-1", "inoue-3", "-o", "a.exr", *options, "--spp", "64")[0] == 0
    assert gemrender("scene", "inoue-1", "inoue-3", "--out", "s", *options)[0] == 0
    image = np.asarray(mi.render(mi.load_file("s/inoue-1-inoue-3-hemisphere.xml"), spp=256))[..., :3]
    rendered, _ = read_exr("a.exr")
    for k, channel in enumerate("RGB"):
        assert image[..., k].mean() == pytest.approx(rendered[channel].mean(), rel=0.03), channel


def test_a_material_file_is_found_from_any_folder(gemrender, folder, monkeypatch, variant_llvm_ad_spectral):
    import mitsuba as mi

    Path("glass.toml").write_text('name = "Glass"\n[index]\nwavelength_nm = [380, 760]\nn = [1.6, 1.5]\n')
    assert gemrender("scene", "inoue-3", "--out", "s", *HEMISPHERE, "--material", "glass.toml")[0] == 0
    monkeypatch.chdir("/")
    scene = mi.load_file(str(folder / "s/inoue-3-hemisphere.xml"), resx=4, resy=4, spp=1)
    assert any("material = Glass" in str(shape.bsdf()) for shape in scene.shapes())


def test_a_scene_is_named_after_its_stones_and_its_setup(gemrender, folder):
    Path("Mein Licht.toml").write_text("[sky]\nradiance = 1\n")
    stones = ["inoue-1", "inoue-3", "inoue-1", "tolkowsky"]
    assert gemrender("scene", *stones, "--out", "s", "--setup", "Mein Licht.toml", "--size", "4")[0] == 0
    stem = "inoue-1-inoue-3-inoue-1-2-mein-licht"
    assert names("s") == {f"{stem}.xml", *(f"{stem}_stone_{k}.ply" for k in range(1, 5))}

"""`gemrender render`: pictures, what is seen in them, and where rendering ends."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from render_help import (
    CHANNELS,
    HEMISPHERE,
    SMALL,
    interrupt_after,
    names,
    on_the_stone,
    read_exr,
    read_png,
    samples_and_noise,
)
from thorough import chosen

from gemrender import cli
from gemrender.colorimetry import colour_matching, luminance_weights, y_integral_nm
from gemrender.cuts import load_stone
from gemrender.cuts.files import save_vertices
from gemrender.render import photoreal
from gemrender.scene.setup import bundled_setups

#: Single precision, of means of some thousand pixels.
AS_BRIGHT = 1e-4


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


# ---- What is seen -----------------------------------------------------------------------------------


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


#: The others are rendered in tests of passes, lights and photographs, or are as one of these is.
OF_KINDS = ["aset", "loupe"]


@pytest.mark.parametrize("setup", chosen(bundled_setups(), OF_KINDS))
def test_every_setup_makes_a_picture(setup, render):
    render("inoue-3", "-o", "a.exr", "--setup", setup, "--size", "16", "--spp", "8")
    channels, _ = read_exr("a.exr")
    assert all(np.isfinite(plane).all() for plane in channels.values())
    assert channels["Y"].min() >= 0
    assert on_the_stone(channels).any()
    assert np.ptp(channels["Y"]) > 0.01


# ---- Where it ends ----------------------------------------------------------------------------------


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


# ---- The denoiser -----------------------------------------------------------------------------------


def roughness(y):
    """Mean difference of neighbours."""
    return float(np.abs(np.diff(y, axis=0)).mean() + np.abs(np.diff(y, axis=1)).mean())


@pytest.mark.parametrize("setup", chosen(["hemisphere", "white"], ["hemisphere"]))
def test_a_denoised_picture_is_smoother_and_as_bright(setup, render):
    pytest.importorskip("mitsuba_oidn")
    options = ["--setup", setup, "--size", "40", "--spp", "2"]
    images = []
    for more in ([], ["--denoise"], ["--spp", "128"]):
        render("inoue-3", "-o", "a.exr", *options, *more)
        images.append(read_exr("a.exr")[0]["Y"].astype(np.float64))
    noisy, smooth, truth = images
    assert roughness(smooth) < 0.9 * roughness(noisy)
    assert smooth.mean() == pytest.approx(noisy.mean(), rel=AS_BRIGHT)
    assert np.mean((smooth - truth) ** 2) < 0.7 * np.mean((noisy - truth) ** 2)


def test_a_denoised_picture_keeps_colours_outside_the_gamut(render):
    """Fire is more saturated than a screen: its negative components survive, and no luminance is negative."""
    pytest.importorskip("mitsuba_oidn")
    options = ["--setup", "fire", "--size", "48", "--spp", "8"]
    lowest = []
    for more in ([], ["--denoise"]):
        render("inoue-3", "-o", "a.exr", *options, *more)
        channels, _ = read_exr("a.exr")
        assert all(np.isfinite(plane).all() for plane in channels.values())
        lowest.append(min(float(channels[c].min()) for c in "RGB"))
        assert min(float(channels[c].min()) for c in "XYZ") >= 0
    assert max(lowest) < -0.01


def test_without_the_denoiser_it_is_one_line_with_the_cure(gemrender, folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    monkeypatch.setattr(photoreal, "render", lambda *_, **__: pytest.fail("told before any work"))
    status, out, err = gemrender("render", "inoue-3", "-o", "a.png", *SMALL, "--denoise")
    assert (status, out, err.count("\n")) == (1, "", 1)
    assert err.startswith("gemrender: the denoiser cannot be imported (")
    assert err.endswith("to cure it: pip install mitsuba-oidn\n")
    assert names(".") == set()

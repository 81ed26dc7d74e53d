"""What tests of `gemrender render` and `gemrender scene --setup` share."""

from __future__ import annotations

import re
import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from gemrender.colorimetry import luminance_weights
from gemrender.render import passes

#: The paper's light; a set-up that shows no ground.
HEMISPHERE = ["--setup", "hemisphere"]

#: A picture that is rendered in an instant.
SMALL = [*HEMISPHERE, "--size", "16", "--spp", "4"]

#: What an EXR holds besides spectral bins.
CHANNELS = {
    *"RGBXYZ", "coverage", *(f"albedo.{c}" for c in "RGB"), *(f"normal.{c}" for c in "XYZ"),
}  # fmt: skip


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


def interrupt_after(monkeypatch, n):
    """Send what Ctrl-C sends, during pass n + 1."""
    add, done = passes.Passes.add, []

    def add_or_stop(self, spp, **options):
        if len(done) == n:
            signal.raise_signal(signal.SIGINT)
        add(self, spp, **options)
        done.append(spp)

    monkeypatch.setattr(passes.Passes, "add", add_or_stop)
    return done


FILM = ["render", "inoue-3", "-o", "x.mp4", *SMALL, "--frames", "3"]

MITSUBA = Path(sys.executable).with_name("mitsuba")


def luminance(path):
    channels, _ = read_exr(path)
    rgb = np.stack([channels[c] for c in "RGB"], axis=-1)
    assert np.isfinite(rgb).all()
    return rgb @ luminance_weights()

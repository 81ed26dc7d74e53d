"""Fixtures of tests of pictures and films: quick renders by the command line."""

from __future__ import annotations

import pytest

from gemrender.render import frames, passes


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

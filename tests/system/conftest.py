"""Fixtures of tests of pictures and films, quick renders by the command line; and of pages, a browser."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from browser_help import CHROMIUM, FLAGS, Opened, Windows

from gemrender.render import frames, lanes, passes


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
    monkeypatch.setattr(lanes, "AT_ONCE", 1 << 10)
    monkeypatch.setattr(passes, "LEAST_SPP", 4)


@pytest.fixture
def av():
    return pytest.importorskip("av")


@pytest.fixture
def turns(monkeypatch):
    """The turns that frames are rendered at; `at` is one that Ctrl-C comes at [deg]."""
    rendered, real = [], frames.render

    def render(*arguments, **options):
        turn = options["move"].angle_deg(options["share"])
        if turn == turns.at:
            raise KeyboardInterrupt
        rendered.append(turn)
        return real(*arguments, **options)

    def turns():
        return [rendered.pop(0) for _ in range(len(rendered))]

    turns.at = None
    monkeypatch.setattr(frames, "render", render)
    return turns


@pytest.fixture(scope="module")
def windows() -> Iterator[Windows]:
    """A browser, and what opens pages in it; all are closed at the end."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if CHROMIUM is None:
        pytest.skip("no Chromium here")
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=CHROMIUM, headless=True, args=FLAGS)
        yield Windows(started)
        started.close()


@pytest.fixture
def opened(windows) -> Iterator[Any]:
    """What opens a page for one test."""
    pages = []

    def open_one(*arguments: Any, **options: Any) -> Opened:
        pages.append(windows.open(*arguments, **options))
        return pages[-1]

    yield open_one
    for seen in pages:
        seen.page.close()

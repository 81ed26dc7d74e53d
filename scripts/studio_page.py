"""Use the studio in a headless Chromium: how long a move takes to be drawn, and what the page looks like.

    python scripts/studio_page.py latency inoue-3 oval-classic     time from a slider's event to the drawn map
    python scripts/studio_page.py latency inoue-3 --picture        the same while a picture is rendered
    python scripts/studio_page.py drag inoue-3 --seconds 600       random dragging: memory, and the last state
    python scripts/studio_page.py picture docs/studio.png          a screenshot

Needs playwright and a Chromium. The times are those of a page and a server that share this machine.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]

#: Move a slider, and tell how long it took until the map of that very state was drawn [ms].
MOVE = """([name, value]) => new Promise((done) => {
    const root = document.documentElement;
    const range = document.getElementById(`slider-${name}`);
    const start = performance.now();
    const before = Number(root.dataset.drawn);
    range.value = value;
    range.dispatchEvent(new Event('input', { bubbles: true }));
    const watch = new MutationObserver(() => {
        if (Number(root.dataset.drawn) <= before) return;
        watch.disconnect();
        done(performance.now() - start);
    });
    watch.observe(root, { attributes: true, attributeFilter: ['data-drawn'] });
})"""


@contextlib.contextmanager
def studio(stone: str) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """Start a studio; its address, and its process."""
    command = [sys.executable, "-m", "gemrender", "studio", "--no-browser", stone]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        assert server.stdout is not None
        yield server.stdout.readline().strip(), server
    finally:
        server.terminate()
        server.wait()


@contextlib.contextmanager
def chromium() -> Iterator[Any]:
    """Start a headless Chromium."""
    from playwright.sync_api import sync_playwright

    path = shutil.which("chromium") or shutil.which("google-chrome")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield browser
        browser.close()


@contextlib.contextmanager
def opened(address: str, width: int = 1400, height: int = 900, scheme: Any = "light") -> Iterator[Any]:
    """Open the page, and wait for its first map."""
    with chromium() as browser:
        page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
        page.on("console", _tell_error)
        page.on("pageerror", lambda error: print("error:", error))
        page.goto(address)
        page.wait_for_selector("html[data-drawn]", timeout=120_000)
        yield page


def _tell_error(message: Any) -> None:
    """Print what the page's console has as an error."""
    if message.type == "error":
        print("console:", message.text)


def ranges(page: Any) -> list[tuple[str, float, float]]:
    """Name and ends of each slider."""
    found: list[tuple[str, float, float]] = page.eval_on_selector_all(
        "#sliders input[type=range]",
        "all => all.map(({id, min, max}) => [id.replace('slider-', ''), Number(min), Number(max)])",
    )
    return found


def latency(stones: list[str], moves: int, with_picture: bool) -> None:
    """Print percentiles of the time from a slider's event to the drawn map, with the load of the machine."""
    for stone in stones:
        with studio(stone) as (address, _), opened(address) as page:
            page.wait_for_selector(".push > .Average", timeout=120_000)  # what is compiled once is compiled
            if with_picture:
                page.click("#paint")
                page.wait_for_selector(".picture[data-samples]", timeout=300_000)
            took = []
            for name, low, high in [of for of in ranges(page) if of[0].endswith(("angle", "table"))]:
                start = float(page.input_value(f"#slider-{name}"))
                step = 0.004 * (high - low)
                for k in range(moves):
                    took.append(page.evaluate(MOVE, [name, start + step * ((k % 20) - 9.5)]))
                    # A hand's events are apart, too; after a rest the picture is at work again.
                    page.wait_for_timeout(1000 if with_picture else 20)
                page.evaluate(MOVE, [name, start])
            took.sort()
            print(
                f"{stone}: {len(took)} moves, median {statistics.median(took):.0f} ms, "
                f"95 % {took[int(0.95 * len(took))]:.0f} ms, most {took[-1]:.0f} ms; "
                f"load {os.getloadavg()[0]:.1f}"
            )


def drag(stone: str, seconds: float, seed: int) -> None:
    """Drag at random for a while, and print memory on the way and whether the last state is shown."""
    chance = random.Random(seed)
    with studio(stone) as (address, server), opened(address) as page:
        known, end, told = ranges(page), time.monotonic() + seconds, 0.0
        count = 0
        while time.monotonic() < end:
            name, low, high = chance.choice(known)
            value = chance.uniform(low + 0.3 * (high - low), low + 0.7 * (high - low))
            page.eval_on_selector(
                f"#slider-{name}",
                "(range, value) => { range.value = value;"
                " range.dispatchEvent(new Event('input', { bubbles: true })); }",
                value,
            )
            count += 1
            page.wait_for_timeout(chance.choice([0, 5, 16, 40, 200]))
            if time.monotonic() > told:
                told = time.monotonic() + max(seconds / 10, 5.0)
                heap = page.evaluate("performance.memory ? performance.memory.usedJSHeapSize / 2**20 : 0")
                print(f"{count} moves: server {_resident(server.pid):.0f} MiB, page {heap:.0f} MiB")
        rest(page)
        shown = page.evaluate("document.documentElement.dataset.drawn")
        print(f"{count} moves; the state that is drawn is number {shown}, and the page rests")


def rest(page: Any) -> None:
    """Wait until all is found out about what is shown."""
    told = "document.documentElement.dataset"
    while not page.evaluate(f"{told}.rested === {told}.drawn"):
        page.wait_for_timeout(200)


def _resident(pid: int) -> float:
    """Resident memory of a process [MiB]."""
    lines = Path(f"/proc/{pid}/status").read_text(encoding="utf-8").splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1024.0


def picture(file: Path, setup: str, samples: int) -> None:
    """Write a screenshot of the whole page with a stone at rest, and a picture of so many samples a pixel."""
    with studio("inoue-3") as (address, _), opened(address, 1400, 1000) as page:
        page.click("#keep")
        page.evaluate(MOVE, ["pavilion_angle", 40.9])
        page.wait_for_selector(".around canvas")
        rest(page)
        page.select_option("#setup", setup)
        page.wait_for_selector(".picture[data-samples]:not(.stale)", timeout=600_000)
        page.wait_for_function(
            "(least) => Number(document.querySelector('.picture').dataset.samples) >= least",
            arg=samples, timeout=600_000,
        )  # fmt: skip
        rest(page)
        page.screenshot(path=str(file), full_page=True)


def main() -> None:
    """Run what the command line names."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=("latency", "drag", "picture"))
    parser.add_argument("of", nargs="+", help="stones, or the file of the picture")
    parser.add_argument("--moves", type=int, default=40, help="moves of each slider")
    parser.add_argument("--picture", action="store_true", help="latency while a picture is rendered")
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--setup", default="studio", help="set-up of the picture in the screenshot")
    parser.add_argument("--samples", type=int, default=32, help="samples a pixel of it, at least")
    given = parser.parse_args()
    if given.what == "latency":
        latency(given.of, given.moves, given.picture)
    elif given.what == "drag":
        drag(given.of[0], given.seconds, given.seed)
    else:
        picture(Path(given.of[0]), given.setup, given.samples)


if __name__ == "__main__":
    main()

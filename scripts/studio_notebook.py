"""Use the studio's widget in a real JupyterLab, in a headless Chromium.

    python scripts/studio_notebook.py studio-notebook.png           light; --dark, --width 390 ...

A notebook shows `gemrender.Studio("inoue-3")`; a slider is dragged, the map changes, and the kernel knows the
stone that is shown; at last the kernel is restarted, and the page says so. It prints what the page's console
has as an error, and ends with 1 where something is not as it should be. Needs jupyterlab, anywidget,
playwright and a Chromium.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from studio_page import chromium

#: Long enough for a kernel that compiles [ms].
PATIENCE = 120_000
CELLS = (
    'import gemrender\n\nstudio = gemrender.Studio("inoue-3")\nstudio',
    "print(studio.stone.cut.values()['table'], round(studio.score.average, 2))",
)
#: What JupyterLab itself asks for without need, and tells as errors where it is not there.
FOREIGN = re.compile(r"/api/(contents|workspaces|news)|favicon|ERR_INTERNET", re.I)


@contextlib.contextmanager
def laboratory(folder: Path) -> Iterator[str]:
    """Start a JupyterLab in a folder; its address."""
    command = [sys.executable, "-m", "jupyterlab", "--no-browser", "--port=0", "--allow-root",
               f"--ServerApp.root_dir={folder}", "--LabApp.expose_app_in_browser=True",
               "--LabApp.news_url=None"]  # fmt: skip
    server = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        assert server.stderr is not None
        told = (
            re.search(r"http://(?:127\.0\.0\.1|localhost):\d+/\S*token=\w+", line) for line in server.stderr
        )
        address = next(found[0] for found in told if found)
        # What else it tells must not fill the pipe.
        drain = subprocess.Popen(["cat"], stdin=server.stderr, stdout=subprocess.DEVNULL)
        yield address.replace("/lab?", "/lab/tree/studio.ipynb?")
        drain.terminate()
    finally:
        server.terminate()
        try:
            server.wait(30)
        except subprocess.TimeoutExpired:  # kernels see its end by themselves
            server.kill()
            server.wait()


def notebook() -> str:
    """Return the notebook, as its file has it."""
    cells: list[dict[str, object]] = [
        {
            "cell_type": "code", "id": f"cell{i}", "source": source, "metadata": {}, "outputs": [],
            "execution_count": None,
        }
        for i, source in enumerate(CELLS)
    ]  # fmt: skip
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    return json.dumps(
        {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    )


def run(page: Any, number: int) -> None:
    """Run a cell as a hand does; again where JupyterLab, just begun, has not heard it."""
    cell = page.locator(".jp-CodeCell").nth(number - 1)
    while re.fullmatch(r"\[ *\]:", cell.locator(".jp-InputPrompt").first.inner_text().strip()):
        cell.locator(".jp-InputArea-editor").click()
        page.keyboard.press("Shift+Enter")
        page.wait_for_timeout(3000)


def use(address: str, picture: Path, width: int, height: int, is_dark: bool) -> list[str]:
    """Use the widget by hand; return what was not as it should be."""
    from playwright.sync_api import TimeoutError as TooLong

    wrong: list[str] = []

    def hear(message: Any) -> None:
        if message.type == "error" and not FOREIGN.search(message.text + message.location.get("url", "")):
            wrong.append(f"console: {message.text}")

    with chromium() as browser:
        page = browser.new_page(viewport={"width": width, "height": height})
        page.set_default_timeout(PATIENCE)
        page.on("console", hear)
        page.on("pageerror", lambda error: wrong.append(f"error: {error}"))
        page.goto(address)
        page.wait_for_selector(".jp-Notebook .jp-CodeCell")
        page.wait_for_function("window.jupyterapp")
        page.evaluate("jupyterapp.restored.then(() => true)")
        page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status=idle]")
        page.wait_for_timeout(6000)  # its outputs are listened to a little later
        if is_dark:
            page.evaluate(
                "void jupyterapp.commands.execute('apputils:change-theme', {theme: 'JupyterLab Dark'})"
            )
        run(page, 1)
        page.wait_for_selector("iframe[title='gemrender studio']")
        frame = page.frame_locator("iframe[title='gemrender studio']")
        frame.locator("html[data-drawn]").wait_for(state="attached")
        before = int(frame.locator("html").get_attribute("data-drawn") or 0)

        slider = frame.locator("#slider-table")
        box = slider.bounding_box()
        assert box is not None
        middle = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + 0.4 * box["width"], middle)
        page.mouse.down()
        for step in range(10):
            page.mouse.move(box["x"] + (0.4 + 0.03 * step) * box["width"], middle)
            page.wait_for_timeout(30)
        page.mouse.up()
        value = float(slider.input_value())
        last = frame.locator(f"html:not([data-drawn='{before}'])")
        last.wait_for(state="attached")
        page.wait_for_timeout(3000)  # and what rests has been told

        run(page, 2)
        told = page.locator(".jp-CodeCell").nth(1).locator(".jp-OutputArea-output pre").inner_text().split()
        average = frame.locator(".headline .average").inner_text()
        print(f"table {value} on the slider, {told[0]} in the kernel; Average {average[:5]}, {told[1]}")
        if abs(float(told[0]) - value) > 1e-9:
            wrong.append("the kernel's stone is not the one that is shown")
        if abs(float(told[1]) - float(average[:5])) > 0.2:
            wrong.append("the kernel's score is not the one that is shown")
        page.evaluate("document.querySelector('.jp-WindowedPanel-outer')?.scrollTo(0, 0)")
        page.wait_for_timeout(4000)
        page.screenshot(path=str(picture))

        page.evaluate("void jupyterapp.commands.execute('kernelmenu:restart')")
        page.click(".jp-Dialog button.jp-mod-accept")
        lost = frame.locator("#lost:not([hidden])")
        try:
            lost.wait_for(timeout=60_000)
            print("its kernel restarted:", lost.inner_text())
        except TooLong:
            wrong.append("the page does not say that its kernel is gone")
    return wrong


def main() -> None:
    """Run what the command line names."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("picture", type=Path, help="the file of the screenshot")
    parser.add_argument("--width", type=int, default=1500)
    parser.add_argument("--height", type=int, default=1100)
    parser.add_argument("--dark", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "studio.ipynb").write_text(notebook(), encoding="utf-8")
        with laboratory(Path(folder)) as address:
            wrong = use(address, given.picture, given.width, given.height, given.dark)
    print("\n".join(wrong) or "nothing amiss", flush=True)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()

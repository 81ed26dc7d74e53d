"""The studio's page in a headless Chromium against a running server."""

from __future__ import annotations

import base64
import json
import queue
import threading
import time
from contextlib import contextmanager, suppress

import numpy as np
import pytest
from browser_help import CHROMIUM, CONTRASTS, FLAGS, LEAST_CONTRAST, NO_WEBGL, WINDOW
from echo_painter import echoing

import gemrender
from gemrender.render.picture_files import png_bytes
from gemrender.studio.assets import WIDGET, embedded_page, files
from gemrender.studio.desk import Desk
from gemrender.studio.serve import listen
from gemrender.studio.session import Session
from gemrender.studio.texts import saved

pytest.importorskip("uvicorn")
playwright = pytest.importorskip("playwright.sync_api")

import uvicorn  # noqa: E402

from gemrender.studio.app import make_app  # noqa: E402

TOKEN = "the-token"
#: Long enough for a machine that has much else to do [ms].
PATIENCE = 120_000


@contextmanager
def running(port=0):
    """A studio's server in a thread; yields its port."""
    with listen("127.0.0.1", port) as listening:
        port = listening.getsockname()[1]
        app = make_app(Desk([gemrender.load_stone("inoue-3")]), TOKEN, port)
        server = uvicorn.Server(
            uvicorn.Config(app, log_level="error", access_log=False, timeout_graceful_shutdown=1)
        )
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
        thread.start()
        try:
            while not server.started:
                time.sleep(0.01)
            yield port
        finally:
            server.should_exit = True
            thread.join(60)


@pytest.fixture(scope="module")
def scored():
    """Average of the stone that the page begins with, as it shows it."""
    return f"{gemrender.score('inoue-3').average:.2f}"


@pytest.fixture(scope="module")
def context():
    """One for all pages: they share a process, which takes long to start."""
    if CHROMIUM is None:
        pytest.skip("no Chromium here")
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        made = browser.new_context(viewport=WINDOW, accept_downloads=True)
        made.set_default_timeout(PATIENCE)
        yield made
        browser.close()


def drawn(page, after=0):
    """Wait until a state later than this one is drawn; its number."""
    until(page, f"Number(document.documentElement.dataset.drawn ?? 0) > {after}")
    return int(page.evaluate("document.documentElement.dataset.drawn"))


def until(page, expression):
    """Wait for something in the page: its own policy lets nobody evaluate text there, as Playwright would."""
    page.evaluate(f"""() => new Promise((done, fail) => {{
        const end = performance.now() + {PATIENCE};
        const look = () => {{
            if ({expression}) done();
            else if (performance.now() > end) fail(new Error({json.dumps(expression)}));
            else setTimeout(look, 20);
        }};
        look();
    }})""")


def test_the_page_is_used_by_hand_and_by_keys_and_outlives_its_server(context, scored):
    page, errors, asked = context.new_page(), [], []
    page.on("console", lambda message: message.type == "error" and errors.append(message.text))
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    average = page.locator(".headline .average")
    with running() as port:
        page.goto(f"http://127.0.0.1:{port}/{TOKEN}/")
        number = drawn(page)
        assert average.inner_text().startswith(scored)

        # A key on a slider is a step; the state behind it can be undone, and done again.
        page.press("#slider-pavilion_angle", "ArrowRight")
        number = drawn(page, number)
        assert not average.inner_text().startswith(scored)
        page.keyboard.press("Control+z")
        number = drawn(page, number)
        assert average.inner_text().startswith(scored)
        page.keyboard.press("Control+y")
        number = drawn(page, number)

        # What cannot be is one line, and the last good map stays.
        page.fill("#sliders input[type=number] >> nth=0", "99")
        page.press("#sliders input[type=number] >> nth=0", "Enter")
        page.wait_for_selector("#refused:not([hidden])")
        assert "table" in page.inner_text("#refused")
        page.click("#undo")
        number = drawn(page, number)

        # A click chooses the ray; a drag tilts.
        box = page.locator(".view .over").bounding_box()
        middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.click(middle[0] + 0.2 * box["width"], middle[1])
        assert "reaches the eye" in page.inner_text(".ray .sentence")
        page.mouse.move(*middle)
        page.mouse.down()
        page.mouse.move(middle[0] + 60, middle[1], steps=3)
        page.mouse.up()
        number = drawn(page, number)
        assert 9 < float(page.input_value("#tilt")) < 13

        # A file is opened, and what is saved of it is the same design.
        design = saved(gemrender.load_stone("princess-ideal"), "asc")
        page.set_input_files("#file", {"name": "mine.asc", "mimeType": "text/plain", "buffer": design})
        until(page, "document.getElementById('name').value === 'mine'")
        number = drawn(page, number)
        # Of a design's tier the distance goes with an angle that turns, and its slider says so.
        angle = page.locator("#sliders input[id$=angle]").last.get_attribute("id")
        distance = f"#{angle.replace('angle', 'distance')}"
        before = page.input_value(distance)
        page.press(f"#{angle}", "PageUp")
        number = drawn(page, number)
        until(page, f"document.querySelector('{distance}').value !== '{before}'")
        page.click("#save summary")
        with page.expect_download() as download:
            page.click("#save [data-kind=asc]")
        assert download.value.suggested_filename == "mine.asc"

        assert all(ratio >= LEAST_CONTRAST for ratio, _ in page.evaluate(CONTRASTS))
        page.click("#theme")
        low = [told for told in page.evaluate(CONTRASTS) if told[0] < LEAST_CONTRAST]
        assert not low
        page.set_viewport_size({"width": 390, "height": 844})
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        unnamed = page.eval_on_selector_all(
            "button, input:not([hidden]), select, summary, canvas[role]",
            "all => all.filter((e) => !(e.ariaLabel || e.textContent.trim() || e.labels?.length))"
            ".map((e) => e.outerHTML)",
        )
        assert not unnamed
        assert not errors
        assert all(url.startswith((f"http://127.0.0.1:{port}/", "blob:", "data:")) for url in asked)

    page.wait_for_selector("#lost:not([hidden])")
    before = page.evaluate("document.documentElement.dataset.drawn")
    with running(port):
        page.wait_for_selector("#lost", state="hidden")
        page.press("#tilt", "ArrowRight")
        drawn(page, int(before))
    page.close()


def test_a_picture_is_shown_saved_and_faded_while_something_moves(context, monkeypatch):
    png = png_bytes(np.full((8, 8, 3), 200, dtype=np.uint8))
    begun = echoing(monkeypatch, png)
    monkeypatch.setattr("gemrender.studio.live.studies", lambda *_: iter(()))  # of curves, maps and cliffs
    page, errors = context.new_page(), []
    page.add_init_script(NO_WEBGL)
    page.on("console", lambda message: message.type == "error" and errors.append(message.text))
    page.on("pageerror", lambda error: errors.append(str(error)))
    with running() as port:
        page.goto(f"http://127.0.0.1:{port}/{TOKEN}/")
        drawn(page)
        assert not begun  # none is rendered before it is asked for
        page.select_option("#setup", "fire")
        page.wait_for_selector(".picture:not(.stale) img:not([hidden])")
        assert page.evaluate("document.querySelector('.picture img').naturalWidth") == 8
        assert "set-up fire: 4 samples a pixel, denoised" in page.get_attribute(".picture img", "alt")
        with page.expect_download() as download:
            page.click("#keep-picture")
        assert download.value.path().read_bytes() == png
        assert download.value.suggested_filename == "Inoue-sample-3-fire.png"

        page.press("#slider-pavilion_angle", "ArrowRight")
        page.wait_for_selector(".picture.stale")
        page.wait_for_selector(".picture:not(.stale)")
        assert not page.is_visible("#metal")
        page.select_option("#setting", "pendant")
        page.wait_for_selector(".picture:not(.stale) img[alt*='set-up fire, platinum pendant']")
        page.select_option("#metal select", "gold")
        page.wait_for_selector(".picture:not(.stale) img[alt*='set-up fire, gold pendant']")
        page.click("#undo")
        page.wait_for_selector(".picture:not(.stale) img[alt*='set-up fire, platinum pendant']")
        page.select_option("#setting", "none")
        page.wait_for_selector(".picture:not(.stale) img[alt*='set-up fire:']")
        assert not page.is_visible("#metal")

        page.select_option("#setup", "velvet")
        page.wait_for_selector(".picture .refused:not([hidden])")
        assert page.inner_text(".picture .refused").endswith("ended by exit status 3")
        page.click("#paint")
        page.wait_for_selector(".picture img", state="hidden")
        page.click("#undo")  # a picture that is wanted is a step of the history, and part of the link
        assert page.get_attribute("#paint", "aria-pressed") == "true"
        assert not errors
    page.close()
    assert all(process.wait(60) is not None for process in begun)


#: What stands for a notebook: the widget's script with a model whose messages go to the test.
NOTEBOOK = """
async ([script]) => {
    const blob = new Blob([script], { type: 'text/javascript' });
    const { default: { render } } = await import(URL.createObjectURL(blob));
    const heard = {};
    const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const model = {
        get: () => 600, on: (name, hear) => { heard[name] = hear; }, off: () => {},
        send: (content, _, [buffer] = []) => toKernel(content, buffer ? [...new Uint8Array(buffer)] : null),
    };
    window.fromKernel = (content, text) => heard['msg:custom'](content, [new DataView(bytes(text).buffer)]);
    window.lose = () => heard['comm:close']();
    const el = document.body.appendChild(document.createElement('div'));
    window.end = render({ model, el });
}
"""


def test_the_page_runs_in_a_notebooks_frame_and_reaches_nothing_of_it(context, scored):
    page, errors, asked, sent = context.new_page(), [], [], queue.Queue()
    page.add_init_script(NO_WEBGL)
    page.on("console", lambda message: message.type == "error" and errors.append(message.text))
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    desk, heard = Desk([gemrender.load_stone("inoue-3")]), []
    session = Session(desk, sent.put)
    page.expose_function("toKernel", lambda content, data: heard.append((content, data)))

    def is_so(expression):
        with suppress(playwright.Error):  # the frame has only now got its page
            return len(page.frames) > 1 and page.frames[1].evaluate(expression)

    def until_in_frame(expression):
        """Hand messages on, both ways, until something is so in the frame."""
        end = time.monotonic() + PATIENCE / 1000
        while not is_so(expression):
            assert time.monotonic() < end, (expression, errors)
            while heard:
                content, data = heard.pop(0)
                if content["type"] == "begin":
                    deliver({**content, "type": "page"}, embedded_page(desk.told()))
                elif content["type"] == "message":
                    session.take(content.get("text") or bytes(data))
                views.add(content["view"])
            while not sent.empty():
                deliver({"view": next(iter(views)), "type": "message"}, sent.get())
            page.wait_for_timeout(20)

    def deliver(content, message):
        page.evaluate(
            "([content, text]) => fromKernel(content, text)", [content, base64.b64encode(message).decode()]
        )

    views = set()
    try:
        page.goto("about:blank")
        page.evaluate(NOTEBOOK, [files()[WIDGET][1].decode()])
        until_in_frame("Number(document.documentElement.dataset.drawn ?? 0) > 0")
        frame = page.frames[1]
        assert frame.inner_text(".headline .average").startswith(scored)
        frame.press("#slider-pavilion_angle", "ArrowRight")
        until_in_frame("Number(document.documentElement.dataset.drawn) > 1")
        assert not frame.inner_text(".headline .average").startswith(scored)
        # Of another origin than the notebook: its page, its cookies, and the network are out of reach.
        blocked = "(() => { try { return parent.document.title; } catch (error) { return error.name; } })()"
        assert frame.evaluate(blocked) == "SecurityError"
        reached = "fetch('http://127.0.0.1:9/').then(() => 'reached', () => 'refused')"
        assert frame.evaluate(reached) == "refused"
        assert any("Content Security Policy" in error for error in errors)
        assert all("Content Security Policy" in error and "127.0.0.1:9" in error for error in errors), errors
        assert not frame.locator("#save [data-kind=link]").count()
        page.evaluate("lose()")
        until_in_frame("!document.getElementById('lost').hidden")
        assert "kernel" in frame.inner_text("#lost")
        page.evaluate("end()")
        page.wait_for_timeout(50)
        assert heard[-1][0]["type"] == "end"
        assert all(url.startswith(("blob:", "data:", "about:")) for url in asked), asked
    finally:
        session.close(wait=60)
        page.close()

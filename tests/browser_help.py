"""Pages in a real headless Chromium, opened from disk, with every request recorded and refused."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gemrender.observation import RayStatus

#: What is drawn at its edge of the map's canvas around the stone (map.js, MAP_MARGIN).
MAP_MARGIN = 0.03
#: Insides of windows and phones [CSS px]: a window as the widest layout needs, no larger, as all is drawn.
WINDOW, PHONE = {"width": 1100, "height": 800}, {"width": 390, "height": 844}
#: Least contrast of text to its ground (WCAG 2, level AA).
LEAST_CONTRAST = 4.5

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
FLAGS = [
    "--no-sandbox", "--disable-gpu-sandbox", "--enable-unsafe-swiftshader", "--disable-background-networking",
    "--disable-component-update", "--disable-default-apps", "--disable-sync", "--no-first-run",
]  # fmt: skip


CONTRASTS = """() => {
    const channels = (text) => text.match(/[\\d.]+/g).map(Number);
    const luminance = ([r, g, b]) => {
        const linear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
        const [x, y, z] = [r, g, b].map((v) => linear(v / 255));
        return 0.2126 * x + 0.7152 * y + 0.0722 * z;
    };
    const ground = (e) => {
        for (; e; e = e.parentElement) {
            const c = channels(getComputedStyle(e).backgroundColor);
            if (c.length === 3 || c[3] > 0.99) return c;
        }
        return [255, 255, 255];
    };
    const hasText = (e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
    return [...document.querySelectorAll('body *')]
        .filter((e) => hasText(e) && e.checkVisibility())
        .map((e) => {
            const [a, b] = [luminance(channels(getComputedStyle(e).color)), luminance(ground(e))];
            return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), e.textContent.slice(0, 40)];
        });
}"""

#: What a canvas shows, and how much of that has changed since it was asked first.
PIXELS = """(canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const told = { bright: 0, red: 0, changed: 0, deviation: 0 };
    let [sum, squares] = [0, 0];
    for (let i = 0; i < data.length; i += 4) {
        const [r, g, b] = data.subarray(i, i + 3);
        told.bright += Math.min(r, g, b) > 120;
        told.red += r > 150 && g < 110;
        told.changed += Boolean(window.first) && [0, 1, 2].some((k) => window.first[i + k] !== data[i + k]);
        sum += r + g + b;
        squares += (r + g + b) ** 2;
    }
    window.first ??= data;
    const mean = sum / (data.length / 4);
    return { ...told, deviation: Math.sqrt(squares / (data.length / 4) - mean ** 2) };
}"""

#: Counts the drawings of maps and of stages.
COUNT = """(() => {
    const { drawImage } = CanvasRenderingContext2D.prototype;
    window.drawn = { map: 0, stage: 0 };
    CanvasRenderingContext2D.prototype.drawImage = function (...all) {
        const panel = this.canvas.closest('.panel');
        if (panel) drawn[panel.classList.contains('map') ? 'map' : 'stage'] += 1;
        return drawImage.apply(this, all);
    };
})()"""

#: Makes a browser one without WebGL, where stones are drawn in lines: without a graphics card that takes most
#: of a page's time.
NO_WEBGL = """(() => {
    const { getContext } = HTMLCanvasElement.prototype;
    HTMLCanvasElement.prototype.getContext = function (kind, ...all) {
        return kind.startsWith('webgl') ? null : getContext.call(this, kind, ...all);
    };
})();"""

#: What was asked for is drawn in the next frame, or the one after where a stone comes into sight first.
FRAMES = """() => new Promise((drawn) => {
    requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(drawn)));
})"""


@dataclass
class Opened:
    """A page, and what it said and asked for."""

    page: Any
    errors: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def canvas(self, kind: str, number: int = 0) -> Any:
        return self.page.locator(f".{kind} canvas").nth(number)

    def place(self, x: Any, y: Any, *, number: int = 0, half_width: float = 1.0) -> tuple[Any, Any]:
        """Where a point of the view is in the window; or many, as arrays."""
        box = self.canvas("map", number).bounding_box()
        scale = (1 - 2 * MAP_MARGIN) * box["width"] / 2 / half_width
        return box["x"] + box["width"] / 2 + scale * x, box["y"] + box["height"] / 2 - scale * y

    def click(self, x: float, y: float, **options: Any) -> None:
        self.canvas("map", options.get("number", 0)).scroll_into_view_if_needed()
        self.page.mouse.click(*self.place(x, y, **options))

    def settle(self) -> None:
        """Wait until what was asked for is drawn."""
        self.page.evaluate(FRAMES)

    def ray(self, number: int = 0) -> dict[str, Any]:
        """What the page tells of a stone's ray, facets in the order from the eye."""
        told = self.page.locator(".ray").nth(number).evaluate(
            "ray => ({...ray.dataset, text: ray.querySelector('.intensity').innerText,"
            " facets: [...ray.querySelectorAll('tbody tr')].map(row => row.dataset.facet)})"
        )  # fmt: skip
        if int(told["status"]) == RayStatus.EXITED:
            told["facets"].reverse()
        return told


@dataclass
class Windows:
    """What opens pages in a browser, in one context for windows and one for phones.

    Pages of one context share a process, and starting one takes longer than loading a page.
    """

    browser: Any
    contexts: dict[bool, Any] = field(default_factory=dict)

    def open(
        self,
        file: Path,
        link: str = "",
        *,
        phone: bool = False,
        dark: bool = False,
        webgl: bool = True,
        script: str = "",
    ) -> Opened:
        """Open a page in a window of its own, with a link's end such as "#x=0.1", after a script."""
        if phone not in self.contexts:
            self.contexts[phone] = self.browser.new_context(
                viewport=PHONE if phone else WINDOW, has_touch=phone, accept_downloads=True
            )
        page = self.contexts[phone].new_page()
        page.emulate_media(color_scheme="dark" if dark else "light")
        page.add_init_script(script if webgl else NO_WEBGL + script)
        seen = Opened(page)
        address = file.as_uri()

        def on_request(route: Any) -> None:
            seen.requests.append(route.request.url.partition("#")[0])
            if seen.requests[-1] == address:
                route.continue_()
            else:
                route.abort()

        page.route("**/*", on_request)
        page.on("console", lambda message: message.type == "error" and seen.errors.append(message.text))
        page.on("pageerror", lambda error: seen.errors.append(str(error)))
        page.on("dialog", lambda dialog: (seen.errors.append("dialog"), dialog.dismiss()))
        page.goto(address + link)
        page.wait_for_selector("html[data-ready]", timeout=20_000)
        return seen


def page_data(page: str) -> dict[str, Any]:
    text = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1]
    return json.loads(text)

"""The report in a real headless Chromium, opened from disk, with every request recorded and refused."""

from __future__ import annotations

import base64
import re
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from any_stones import design, hollow_stone
from browser_help import CONTRASTS, COUNT, LEAST_CONTRAST, PHONE, PIXELS, WINDOW, Opened, page_data
from observations import observation as made_observation
from thorough import chosen
from typer.testing import CliRunner

from gemrender.cli.report import report
from gemrender.cuts import load_stone, stone_from_vertices
from gemrender.errors import InputError
from gemrender.observation import PATH_CODE_FACTOR, PATH_CODE_MASK, Observation, RayStatus, View
from gemrender.reference import full_paths, observe
from gemrender.reference.path import RayPath
from gemrender.report import page
from gemrender.report.page import INTENSITY_STEPS, MOST_STONES, report_html, write_report
from gemrender.scoring import score_observation
from gemrender.stone import Stone

#: Pixels a side of the maps.
RESOLUTION = 128
#: Largest file of one stone [bytes].
MOST_BYTES = 3_000_000
#: Intensities on the same path [%]: the page's tracer against the reference, and against a map in float32.
SAME_PERCENT, SAME_PIXEL = 1e-6, 1e-5
#: Paths of more reflections may part by rounding; at most so large a share of a map's pixels.
FEW_REFLECTIONS, LONG_SHARE = 30, 0.005
#: Least height of a button to be touched (WCAG 2.2, level AA) [CSS px].
LEAST_BUTTON = 24

HOSTILE = '</script><script>alert(1)</script><img src=x onerror="alert(2)">{{data}}&amp;\u2028'


def measured() -> Stone:
    rng = np.random.default_rng(1)
    vertices = load_stone("inoue-2").vertices
    return stone_from_vertices(vertices + rng.normal(0, 0.002, vertices.shape), name="measured")


@pytest.fixture(scope="module")
def observed() -> dict[str, Observation]:
    stones = {
        "inoue-3": load_stone("inoue-3"),
        "inoue-1": load_stone("inoue-1"),
        "measured": measured(),
        "emerald": design("emerald"),
        "pear": design("pear"),
        "hollow": hollow_stone(),
    }
    small = ("measured", "emerald", "pear", "hollow")
    return {
        name: observe(stone, View.of(stone, RESOLUTION // 2 if name in small else RESOLUTION))
        for name, stone in stones.items()
    }


@pytest.fixture(scope="module")
def pages(observed, tmp_path_factory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("report")
    one, other = observed["inoue-3"], observed["inoue-1"]
    return {
        "one": write_report([one], folder / "one.html"),
        "two": write_report([one, other], folder / "two.html"),
        **{
            name: write_report([observed[name]], folder / f"{name}.html")
            for name in ("measured", "emerald", "pear", "hollow")
        },
        "cuts": write_report([one, observed["pear"], observed["emerald"]], folder / "cuts.html"),
    }


@pytest.fixture(scope="module")
def shared(windows, pages) -> Callable[..., Opened]:
    """What opens a page once, for all tests that leave it as it was, but for the ray and the stones' turns.

    The one of two stones is opened in the dark, and some by a browser without WebGL; `opening` is what was
    drawn until a page was there.
    """

    @cache
    def opened_once(name: str) -> Opened:
        seen = windows.open(pages[name], dark=name == "two", webgl=name not in IN_LINES, script=COUNT)
        for _ in range(2):
            seen.settle()
        seen.page.evaluate("window.opening = { ...drawn }")
        return seen

    def in_front(name: str) -> Opened:
        seen = opened_once(name)
        seen.page.bring_to_front()  # a page behind another one is drawn once a second
        return seen

    return in_front


def expected_path(seen: dict[str, Any], observation: Observation) -> RayPath:
    point = (float(seen["x"]), float(seen["y"]))
    return full_paths(observation.stone, [point], view=observation.view, model=observation.model)[0]


def assert_shown(seen: dict[str, Any], observation: Observation) -> None:
    """The page shows the reference's path at its point, which is the map's pixel there."""
    path = expected_path(seen, observation)
    assert tuple(seen["facets"]) == path.facet_names
    assert float(seen["intensity"]) == pytest.approx(path.primary_intensity, abs=SAME_PERCENT, rel=0)
    assert seen["text"].replace("\n", "") == f"{path.primary_intensity:.2f} %"
    assert int(seen["reflections"]) == path.reflections
    assert (seen["rear"] == "true") == path.rear
    x, y = observation.view.cell_centres()
    row, column = np.abs(y - path.y).argmin(), np.abs(x - path.x).argmin()
    assert (x[column], y[row]) == pytest.approx((path.x, path.y), abs=1e-12)
    pixel = float(observation.primary_intensity[row, column])
    assert float(seen["intensity"]) == pytest.approx(pixel, abs=SAME_PIXEL)


# ---- In the browser ------------------------------------------------------------------------------------


NAMES = ("one", "two", "measured", "emerald", "pear", "hollow", "cuts")
#: Those that a browser without WebGL opens, which draws stones in lines.
IN_LINES = ("measured", "cuts")


@pytest.mark.parametrize("name", chosen(NAMES, [name for name in NAMES if name != "emerald"]))
def test01_loads_without_errors_and_without_requests(shared, pages, name):
    seen = shared(name)
    assert seen.errors == []
    assert seen.requests == [pages[name].as_uri()]
    assert seen.page.evaluate("performance.getEntriesByType('resource').length") == 0
    told = [shown.is_visible() for shown in seen.page.locator(".failure").all()]
    assert told == [name in IN_LINES] * (3 if name == "cuts" else 2 if name == "two" else 1)


@pytest.mark.parametrize("name", ["one", "measured"])
def test02_the_stone_is_drawn(shared, name):
    seen = shared(name)
    seen.page.evaluate("location.hash = 'x=-0.32&y=-0.12'")
    seen.canvas("stage").focus()

    def pixels(key: str = "") -> dict[str, float]:
        if key:
            seen.page.keyboard.press(key)
        seen.settle()
        return seen.canvas("stage").evaluate(PIXELS)

    drawn = pixels("0")
    assert drawn["deviation"] > 30, "blank"
    assert drawn["bright"] > 500, "no outlines"
    assert drawn["red"] > 200, "no red ray"
    assert pixels("ArrowLeft")["changed"] > 5000, "does not turn"
    assert pixels("0")["changed"] == 0, "0 does not bring it back"


def test02_what_changed_is_drawn_and_once(shared):
    seen = shared("two")

    def drawn() -> tuple[int, int]:
        for _ in range(2):
            seen.settle()
        told = seen.page.evaluate("({ ...drawn })")
        seen.page.evaluate("drawn.map = drawn.stage = 0")
        return told["map"], told["stage"]

    assert seen.page.evaluate("opening") == {"map": 2, "stage": 2}
    seen.page.mouse.move(0, 0)
    drawn()
    seen.click(0.99, 0.99)
    assert drawn() == (2, 2), "another ray, in a table of fewer rows"
    seen.canvas("stage").focus()
    seen.page.keyboard.press("ArrowLeft")
    assert drawn() == (0, 1), "a stone turned"
    for _ in range(2):
        seen.page.locator("[data-lines]").first.click()
        assert drawn() == (1, 0), "lines over a map, and none"
    seen.page.locator(".shares tbody tr").first.hover()
    assert drawn() == (4, 0), "a band of light: over what is fainter, in both maps"
    seen.page.mouse.move(0, 0)
    seen.page.set_viewport_size(PHONE)
    seen.page.evaluate("scrollTo(0, 0)")
    drawn()
    seen.page.evaluate("location.hash = 'x=0.2&y=0.1'")
    assert drawn() == (1, 1), "the other stone is out of sight"
    seen.page.evaluate("GemPage.cards[1].root.scrollIntoView()")
    assert drawn() == (1, 1), "and in sight"
    seen.page.set_viewport_size(WINDOW)
    seen.page.evaluate("scrollTo(0, 0)")


# That the page's tracer is right of the others too is below.
@pytest.mark.parametrize(
    "name", chosen(["inoue-3", "measured", "emerald", "pear", "hollow"], ["inoue-3", "pear", "hollow"])
)
def test03_a_click_shows_the_reference_path(shared, observed, name):
    observation = observed[name]
    seen = shared("one" if name == "inoue-3" else name)
    half_width = observation.view.half_width
    statuses = set()
    points = [(0.1, 0.05), (-0.45, 0.31), (0.62, -0.4), (0.93, 0.34), (-0.2, -0.88), (0.99, 0.99)]
    if name != "inoue-3":
        points = points[::2] + points[-1:]  # where the light of other stones goes is the tracer's, below
    some_rear = np.argwhere(observation.rear_mask > 0)
    row, column = some_rear[len(some_rear) // 2]
    points.append(
        tuple(axis[i] for axis, i in zip(observation.view.cell_centres(), (column, row), strict=True))
    )
    for x, y in points:
        seen.click(x, y, half_width=half_width)
        told = seen.ray()
        assert abs(float(told["x"]) - x) < 0.02
        assert abs(float(told["y"]) - y) < 0.02
        if int(told["status"]) == RayStatus.MISSED:
            assert told["facets"] == []
        else:
            assert_shown(told, observation)
        statuses.add((told["status"], told["rear"]))
    assert {("0", "false"), ("1", "false"), ("1", "true")} <= statuses


def test04_a_click_on_the_stone_shows_the_ray_there(shared, observed):
    seen = shared("one")
    seen.page.get_by_role("button", name="Top").click()
    box = seen.canvas("stage").bounding_box()
    centre = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    seen.page.mouse.click(centre[0] + 0.2 * box["width"], centre[1] - 0.1 * box["height"])
    told = seen.ray()
    x, y = float(told["x"]), float(told["y"])
    assert x == pytest.approx(-2 * y * -1, abs=0.03)
    assert 0.4 < x < 0.6
    assert_shown(told, observed["inoue-3"])
    # From the side: the facet that is clicked is the one that the ray comes out of.
    seen.page.get_by_role("button", name="Tilted").click()
    seen.page.mouse.click(centre[0], centre[1] - 0.16 * box["height"])
    tilted = seen.ray()
    assert (tilted["x"], tilted["y"]) != (told["x"], told["y"])
    assert_shown(tilted, observed["inoue-3"])
    # Turning by hand chooses nothing.
    seen.page.mouse.move(*centre)
    seen.page.mouse.down()
    seen.page.mouse.move(centre[0] + 60, centre[1] + 20, steps=4)
    seen.page.mouse.up()
    assert seen.ray() == tilted
    # The pavilion has no point of the map.
    seen.page.get_by_role("button", name="Below").click()
    seen.page.mouse.click(*centre)
    assert seen.ray() == tilted


def test05_two_stones_stay_linked(shared, observed):
    seen = shared("two")
    for number, x, y in [(0, 0.3, 0.4), (1, -0.5, 0.1)]:
        seen.click(x, y, number=number)
        first, second = seen.ray(0), seen.ray(1)
        assert (first["x"], first["y"]) == (second["x"], second["y"])
        assert abs(float(first["x"]) - x) < 0.02
        assert_shown(first, observed["inoue-3"])
        assert_shown(second, observed["inoue-1"])
    seen.canvas("map", 1).focus()
    seen.page.keyboard.press("ArrowUp")
    moved = seen.ray(0)
    assert float(moved["y"]) == pytest.approx(float(first["y"]) + 2 / RESOLUTION, abs=1e-12)
    assert (moved["x"], moved["y"]) == (seen.ray(1)["x"], seen.ray(1)["y"])


def test05_stones_of_different_cuts_are_told_in_one_table(shared):
    """What one cut has and another lacks is a dash."""
    rows = (
        shared("cuts")
        .page.locator("#proportions tbody tr")
        .evaluate_all("rows => rows.map(row => [...row.children].map(cell => cell.innerText))")
    )
    values = {name: cells for name, *cells in rows}
    assert values["Star length"] == ["57.00 %", "–", "–"]
    assert values["Length to width"] == ["–", "1.25", "1.25"]
    assert values["Total depth"] == ["61.28 %", "60.28 %", "63.52 %"]


def test06_keyboard(shared):
    seen = shared("one")
    page, order = seen.page, []
    # From the page's beginning on, wherever the last click was
    page.evaluate(
        "document.body.tabIndex = -1; document.body.focus(); document.body.removeAttribute('tabindex')"
    )
    for _ in range(11):
        page.keyboard.press("Tab")
        name, outline = page.evaluate(
            "() => { const e = document.activeElement, s = getComputedStyle(e);"
            " return [e.getAttribute('aria-label') ?? e.innerText,"
            " s.outlineStyle === 'none' ? 0 : parseFloat(s.outlineWidth)] }"
        )
        order.append(name.split(".")[0])
        assert outline >= 2, name
    assert order == [
        "Dark", "Print", "Inoue sample 3 in 3D", "Tilted", "Top", "Side", "Below", "Zoom out", "Zoom in",
        "Intensity map of Inoue sample 3, seen from above", "Facet lines",
    ]  # fmt: skip
    page.keyboard.press("Shift+Tab")
    before = seen.ray()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowDown")
    after = seen.ray()
    assert float(after["x"]) - float(before["x"]) == pytest.approx(2 / RESOLUTION, abs=1e-12)
    assert float(before["y"]) - float(after["y"]) == pytest.approx(16 * 2 / RESOLUTION, abs=1e-12)
    # Not wait_for_function: where it has to poll it calls eval, which the page's security policy forbids.
    page.locator("#announce").filter(has_text="%").wait_for(state="attached")


def test07_hover_tells_facet_and_intensity(shared, observed):
    seen, observation = shared("one"), observed["inoue-3"]
    x, y = observation.view.cell_centres()
    for row, column in [(64, 70), (30, 45), (100, 85)]:
        seen.page.mouse.move(*seen.place(x[column], y[row]))
        facet = observation.stone.facet_names[observation.entry_facet[row, column]].replace(
            "bezel", "bezel_main"
        )
        said = seen.page.locator("#tip").inner_text()
        name, value = said.split(": ")
        assert name == facet.replace("_", " ")
        if observation.rear_mask[row, column]:
            assert value == "rear light"
        else:
            assert float(value.split()[0]) == pytest.approx(
                float(observation.primary_intensity[row, column]), abs=0.06
            )


def is_wide(seen: Opened) -> bool:
    return seen.page.evaluate("document.documentElement.scrollWidth") > PHONE["width"]


def least_button(seen: Opened) -> float:
    return min(
        seen.page.evaluate(
            "[...document.querySelectorAll('button')].filter(b => b.checkVisibility())"
            ".map(b => b.getBoundingClientRect().height)"
        )
    )


# The last has all that the others have, but for what a single stone's page looks like, which is below.
@pytest.mark.parametrize("name", chosen(["one", "two", "emerald", "pear", "cuts"], ["cuts"]))
def test08_a_phone_scrolls_one_way_only(opened, pages, observed, name):
    seen = opened(pages[name], phone=True, webgl=False)
    assert not is_wide(seen)
    before = seen.ray()
    seen.canvas("map").scroll_into_view_if_needed()
    seen.page.touchscreen.tap(*seen.place(0.9, 0.34))  # more rows, longer words
    after = seen.ray()
    assert (after["x"], after["y"]) != (before["x"], before["y"])
    if name in ("one", "two", "cuts"):
        assert len(after["facets"]) > len(before["facets"])
        assert_shown(after, observed["inoue-3"])
    assert not is_wide(seen)
    assert least_button(seen) >= LEAST_BUTTON


def test08_a_narrow_window_scrolls_one_way_only(shared):
    """Of a single stone, whatever row of the table the longest words are in."""
    seen = shared("one")
    seen.page.set_viewport_size(PHONE)
    for point in ("x=0.1&y=0.05", "x=0.9&y=0.34"):
        seen.page.evaluate("hash => { location.hash = hash; }", point)
        seen.settle()
        assert not is_wide(seen)
    assert least_button(seen) >= LEAST_BUTTON
    seen.page.set_viewport_size(WINDOW)


def test09_light_and_dark_are_legible(shared):
    seen, grounds = shared("two"), []
    assert seen.page.evaluate("document.documentElement.dataset.theme") == "dark", "as it was opened"
    for system in ("light", "dark"):
        seen.page.emulate_media(color_scheme=system)
        for _ in range(2):  # as the system says, and toggled
            contrasts = seen.page.evaluate(CONTRASTS)
            assert len(contrasts) > 100
            ratio, text = min(contrasts)
            assert ratio >= LEAST_CONTRAST, text
            grounds.append(seen.page.evaluate("getComputedStyle(document.body).backgroundColor"))
            seen.page.locator("#theme").click()
    assert grounds[0] == grounds[3] != grounds[1] == grounds[2]


def test10_prints(shared):
    dark = shared("two")
    dark.page.emulate_media(media="print")
    assert dark.page.locator("#print").is_hidden()
    assert dark.page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    printed = dark.page.pdf(prefer_css_page_size=True, print_background=True)
    dark.page.emulate_media(media="null")
    assert printed.startswith(b"%PDF")
    assert 20_000 < len(printed) < MOST_BYTES
    assert len(re.findall(rb"/Type\s*/Page\b", printed)) == 2


def test11_names_are_harmless(opened, tmp_path):
    rng = np.random.default_rng(1)
    stone = stone_from_vertices(load_stone("inoue-3").vertices, name=HOSTILE)
    hostile = made_observation(
        resolution=32, stone=stone, primary_intensity=rng.uniform(0, 90, (32, 32)), reflections=2
    )
    for number in (1, 2):
        seen = opened(write_report([hostile] * number, tmp_path / "hostile.html"), webgl=False)
        assert seen.errors == []
        assert len(seen.requests) == 1
        assert seen.page.locator("img").count() == 0
        heading = seen.page.locator("h1" if number == 1 else ".name").first
        assert heading.evaluate("e => e.textContent") == HOSTILE
        assert HOSTILE.rstrip("\u2028")[:60] in seen.page.title()


def test12_the_ray_shown_is_the_ray_that_was_scored(shared, observed):
    """1000 pixels of each map, traced by the page's tracer with the page's data."""
    rng = np.random.default_rng(5)
    for name, file in (("inoue-3", "one"), ("measured", "measured"), ("pear", "pear")):
        observation = observed[name]
        rows, columns = rng.permutation(np.argwhere(observation.coverage > 0))[:1000].T
        x, y = observation.view.cell_centres()
        found = shared(file).page.evaluate(
            """(points) => {
                const data = JSON.parse(document.getElementById('data').textContent);
                const stone = data.stones[0], surfaces = GemTracer.surfacesOf(stone.solid);
                return points.map(([x, y]) => {
                    const p = GemTracer.trace(surfaces, data.optics, stone.view, stone.model, x, y);
                    return [p.intensity, p.facets];
                });
            }""",
            np.stack([x[columns], y[rows]], axis=1).tolist(),
        )
        parted = 0
        for i, (intensity, facets) in enumerate(found):
            at = rows[i], columns[i]
            code = 0
            for facet in facets:
                code = (code * PATH_CODE_FACTOR + facet + 1) & PATH_CODE_MASK
            same = code == observation.path_code[at] and intensity == pytest.approx(
                float(observation.primary_intensity[at]), abs=SAME_PIXEL
            )
            assert same or observation.reflections[at] > FEW_REFLECTIONS
            parted += not same
        assert len(found) == 1000
        assert parted <= 1000 * LONG_SHARE


# ---- The file ------------------------------------------------------------------------------------------


def test13_the_map_is_the_scored_map(observed):
    for observation in (observed["inoue-3"], observed["measured"]):
        stone = page_data(report_html([observation]))["stones"][0]
        size = stone["map"]["size"]
        planes = np.frombuffer(zlib.decompress(base64.b64decode(stone["map"]["data"])), dtype=np.uint8)
        high, low = planes.reshape(2, size, size).astype(np.uint16)
        codes = np.cumsum(high * 256 + low, axis=1, dtype=np.uint16)
        lit = (observation.status == RayStatus.EXITED) & (observation.rear_mask == 0)
        error = observation.primary_intensity[lit] - codes[lit] / INTENSITY_STEPS
        assert error.min() > -1e-5
        assert error.max() < 1 / INTENSITY_STEPS + 1e-5
        # Rounding down keeps every pixel in its band.
        met = np.count_nonzero(observation.coverage)
        bands = score_observation(observation).bands
        for band in bands:
            steps = band.low * INTENSITY_STEPS, (band.high or 300) * INTENSITY_STEPS
            share = 100 * np.count_nonzero(lit & (codes >= steps[0]) & (codes < steps[1])) / met
            assert share == pytest.approx(band.share, abs=1e-9)
        assert (codes[observation.rear_mask > 0] == 65001).all()
        assert (codes[observation.status == RayStatus.MISSED] == 65003).all()


def test14_large_maps_keep_every_second_pixel(monkeypatch):
    monkeypatch.setattr(page, "MAP_PIXELS", 16)
    side = 2 * 16
    large = made_observation(resolution=side, primary_intensity=50.0)
    shown = page_data(report_html([large]))["stones"][0]["map"]
    x = large.view.cell_centres()[0]
    assert shown["size"] == 16
    assert shown["start"] == x[1]
    assert shown["pitch"] == pytest.approx(x[3] - x[1])


def test15_one_file_of_moderate_size_with_its_licences(pages):
    page = pages["one"].read_text(encoding="utf-8")
    assert pages["one"].stat().st_size < MOST_BYTES
    assert "The MIT License" in page
    assert "Permission is hereby granted" in page
    assert "@license" in page
    assert not re.search(r'(?:src|href)\s*=\s*"(?!data:)', page.split("<script>")[0])


def test16_bad_input_is_one_line(tmp_path):
    one = made_observation(resolution=4, primary_intensity=50.0)
    there = tmp_path / "there.html"
    there.write_text("kept")
    for observations, path in (
        ([], there),
        ([one] * (MOST_STONES + 1), there),
        (iter([]), there),
        ([one], tmp_path),
        ([one], there / "below.html"),
        ([one], ""),
        ([one], "/dev/null"),
        ([one], tmp_path / "null\0"),
        ([one], tmp_path / ("x" * 300)),
    ):
        with pytest.raises(InputError) as caught:
            write_report(observations, path)
        assert "\n" not in str(caught.value)
    assert there.read_text() == "kept"
    assert [file.name for file in tmp_path.iterdir()] == ["there.html"]


def test17_the_command(tmp_path):
    app = typer.Typer()
    app.command()(report)
    out = tmp_path / "new" / "page.html"
    arguments = ["inoue-3", "inoue-1", "-o", str(out), "--engine", "reference", "--resolution", "24"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    told = page_data(out.read_text(encoding="utf-8"))
    assert [stone["name"] for stone in told["stones"]] == ["Inoue sample 3", "Inoue sample 1"]
    assert isinstance(CliRunner().invoke(app, ["inoue-3"] * (MOST_STONES + 1)).exception, InputError)

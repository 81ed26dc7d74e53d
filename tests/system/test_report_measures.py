"""Measures in the report: the table on top, its link, what lights up, and tilts, in a real browser."""

from __future__ import annotations

import csv
import io
import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser_help import CONTRASTS, LEAST_CONTRAST, Opened, page_data

from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.measures import measure_named
from gemrender.observation import Observation, RayStatus, View, bound_text
from gemrender.reference import full_paths, observe
from gemrender.report.figures import BAND_COLOURS, REAR_COLOUR
from gemrender.report.page import report_html, write_report
from gemrender.report.studied import Study, all_measures, check_tilts, study_stone
from gemrender.report.tables import score_record
from gemrender.scoring import BAND_EDGES, score

#: Pixels a side of the maps, and of the map that a tilted one is compared with.
RESOLUTION, COMPARED = 128, 96
#: Bound of the measures [%]: the page shows what is found, however well it is known.
BOUND = 0.3
TURNS = (-10.0, -5.0, 0.0, 5.0, 10.0)
MEASURES = "iso,window,wlr-like"
#: Away from the edges of virtual facets maps agree, but where the ray is drawn: at this share of points.
ALIKE_SHARE = 0.9
#: Intensities on the same path [%].
SAME_PERCENT = 1e-6
#: Poses that are images of each other, seen by few rays [%].
ROUNDING = 1e-9


@pytest.fixture(scope="module")
def studied() -> list[tuple[Observation, Study]]:
    return [
        study_stone(
            load_stone(name),
            engine="exact",
            resolution=RESOLUTION,
            measures=MEASURES,
            bound=BOUND,
            tilts=10.0,
            tilt_step=5.0,
        )
        for name in ("inoue-3", "inoue-1")
    ]


@pytest.fixture(scope="module")
def page(studied, tmp_path_factory) -> Path:
    return write_report(studied, tmp_path_factory.mktemp("measures") / "page.html")


@pytest.fixture(scope="module")
def loaded(windows, page) -> Opened:
    return windows.open(page, webgl=False)


@pytest.fixture
def seen(loaded) -> Opened:
    """The page as it is without a link, with the mouse beside everything."""
    loaded.page.bring_to_front()  # behind another one it is drawn once a second
    loaded.page.mouse.move(0, 0)
    if is_chosen(loaded):
        follow(loaded, "#")
    loaded.page.evaluate("scrollTo(0, 0)")
    yield loaded
    assert loaded.errors == []


def follow(seen: Opened, link: str) -> None:
    """Open another link of the page."""
    seen.page.evaluate("link => { location.hash = link; scrollTo(0, 0); }", f"{link}&at={time.monotonic()}")
    seen.settle()


def is_chosen(seen: Opened) -> bool:
    """Whether anything was chosen since the link without anything was followed: it is in the link then."""
    return not re.fullmatch(r"(#&at=[\d.]+)?", seen.page.evaluate("location.hash"))


CELLS = """() => [
    JSON.parse(document.getElementById('data').textContent).table.columns.map((column) => column.key),
    [...document.querySelectorAll('#scores tbody tr')].map((row) =>
        [...row.children].map((cell) => cell.innerText)),
]"""


def cells(seen: Any) -> dict[str, dict[str, str]]:
    """What the table on top shows, by stone and column, in its order."""
    keys, rows = seen.page.evaluate(CELLS)
    return {name: dict(zip(keys, shown, strict=True)) for name, *shown in rows}


def numbers(study: Study, turn: float = 0.0) -> dict[str, tuple[float, float | None]]:
    """Values and bounds by column."""
    [of_turn] = [of.measures for of in study.turned if of.turn_deg == turn] or [study.measures]
    return {
        key if k == 0 else of.name if key == "value" else f"{of.name}_{key}": (value, of.bound)
        for k, of in enumerate(of_turn)
        for key, value in of.values.items()
    }


def press_heading(seen: Any, name: str) -> None:
    seen.page.locator("#scores thead th button").filter(has_text=re.compile(f"^{name}$")).first.click()


# ---- The table -----------------------------------------------------------------------------------------


def test_the_table_has_every_value_with_its_bound(seen, page, studied):
    assert seen.requests == [page.as_uri()]
    shown = cells(seen)
    assert list(shown) == ["Inoue sample 3", "Inoue sample 1"]
    for (_, study), found in zip(studied, shown.values(), strict=True):
        known = numbers(study)
        for key, text in found.items():
            value, bound = known[key]
            told, within = text.split(" ±")
            assert float(told) == pytest.approx(value, abs=0.0051)
            assert within == bound_text(bound)
        assert {"average", "band_75", "iso", "iso_surface", "window", "wlr-like"} <= set(found)


def test_every_column_sorts_both_ways_and_then_not(seen, studied):
    names = ["Inoue sample 3", "Inoue sample 1"]
    known = [numbers(study) for _, study in studied]
    for key, label in (
        ("average", "Average"),
        ("rear", "Rear"),
        ("iso", "value"),
        ("iso_internal", "internal"),
    ):
        rising = sorted(range(2), key=lambda i, key=key: known[i][key][0])
        for order, said in ((rising[::-1], "descending"), (rising, "ascending"), ([0, 1], None)):
            press_heading(seen, label)
            assert list(cells(seen)) == [names[i] for i in order]
            head = seen.page.locator("#scores th[aria-sort]")
            assert (head.get_attribute("aria-sort") if said else head.count()) == (said or 0)
    press_heading(seen, "Stone")
    assert list(cells(seen)) == names[::-1]


def test_against_a_baseline_there_are_differences_with_both_bounds(seen, studied):
    seen.page.locator("#baseline").select_option("Inoue sample 3")
    shown = cells(seen)
    base, other = (numbers(study) for _, study in studied)
    assert shown["Inoue sample 3"]["average"].startswith(f"{base['average'][0]:.2f}")
    for key, text in shown["Inoue sample 1"].items():
        told, within = text.replace("−", "-").split(" ±")
        difference, bound = other[key][0] - base[key][0], other[key][1] + base[key][1]
        assert float(told) == pytest.approx(difference, abs=0.0051)
        assert float(within) >= bound
        place = list(shown["Inoue sample 1"]).index(key)
        cell = seen.page.locator("#scores tbody tr").nth(1).locator("td").nth(place)
        assert ("within" in (cell.get_attribute("class") or "")) == (abs(difference) <= bound)


def test_the_csv_is_the_command_lines_with_all_tilts(seen, studied):
    follow(seen, "#sort=rear")
    with seen.page.expect_download() as download:
        seen.page.locator("#csv").click()
    assert download.value.suggested_filename == "gemrender-scores.csv"
    text = Path(download.value.path()).read_text(encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(text, newline="")))
    assert [(row["name"], float(row["tilt_deg"])) for row in rows] == [
        (name, abs(turn)) for name in ("Inoue sample 3", "Inoue sample 1") for turn in TURNS
    ]
    record = score_record(studied[1][1].score)
    assert list(rows[0]) == list(record)
    assert [float(rows[7][key]) for key in ("average", "iso", "iso_bound")] == [
        record[key] for key in ("average", "iso", "iso_bound")
    ]
    assert float(rows[9]["iso"]) == numbers(studied[1][1], 10.0)["iso"][0]


def test_a_definition_is_one_click_away(seen):
    dialog = seen.page.locator("#definition")
    for name in ("inoue", "wlr-like"):
        assert dialog.is_hidden()
        press_heading(seen, name)
        text = dialog.inner_text().replace("−", "-")
        assert measure_named(name).definition[1:] in text
        assert measure_named(name).source in text
        if name == "inoue":
            dialog.get_by_role("button", name="Close").click()
        else:
            seen.page.keyboard.press("Escape")
    assert dialog.is_hidden()


def test_the_table_stays_on_top_and_a_phone_scrolls_one_way(opened, page):
    seen = opened(page, phone=True, dark=True, webgl=False)
    seen.page.evaluate("scrollTo(0, 1500)")
    box = seen.page.locator("#scores").bounding_box()
    assert box["y"] == pytest.approx(0, abs=1)
    assert box["height"] < 844 / 3
    assert seen.page.evaluate("document.documentElement.scrollWidth") <= 390
    small = seen.page.evaluate(
        "[...document.querySelectorAll('button, select, input')].filter(e => e.checkVisibility())"
        ".map(e => [e.getBoundingClientRect().height, e.outerHTML])"
    )
    assert min(small)[0] >= 24, min(small)
    seen.page.locator("#baseline").select_option("0")
    seen.page.locator("#theme").click()
    for _ in range(2):
        ratio, text = min(seen.page.evaluate(CONTRASTS))
        assert ratio >= LEAST_CONTRAST, text
        seen.page.locator("#theme").click()


# ---- What lights up ------------------------------------------------------------------------------------

COLOURS = """(canvas, points) => {
    const context = canvas.getContext('2d');
    const scale = canvas.width / canvas.clientWidth;
    const { data, width } = context.getImageData(0, 0, canvas.width, canvas.height);
    return points.map(([u, v]) => {
        const at = 4 * (Math.round(v * scale) * width + Math.round(u * scale));
        return [...data.subarray(at, at + 4)];
    });
}"""


def colours(seen: Any, points: np.ndarray, half_width: float, number: int = 0) -> np.ndarray:
    """Colours of a map's canvas at points of the view (n, 2), (n, 4)."""
    seen.settle()
    box = seen.canvas("map", number).bounding_box()
    x, y = seen.place(*np.transpose(points), number=number, half_width=half_width)
    offsets = np.stack([x - box["x"], y - box["y"]], axis=1)
    return np.array(seen.canvas("map", number).evaluate(COLOURS, offsets.tolist()))


def rgb(colour: str) -> np.ndarray:
    return np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)])


def half_width(studied: list[tuple[Observation, Study]], number: int = 0) -> float:
    """Half the width of the map on the page, which holds every tilt."""
    observation, study = studied[number]
    return max(observation.view.half_width, *(of.view.half_width for of in study.turned))


def test_a_band_lights_up_in_the_map_and_the_map_in_the_band(seen, studied):
    width = half_width(studied)
    observation = studied[0][0]
    x, y = observation.view.cell_centres()
    intensity, rear = observation.primary_intensity, observation.rear_mask > 0
    wanted = (intensity >= 76) & ~rear, (intensity > 62) & (intensity < 72)
    inside = [points[len(points) // 2] for points in map(np.argwhere, wanted)]
    bright, other = np.array([(x[column], y[row]) for row, column in inside])
    before = colours(seen, [bright, other], width)
    row = seen.page.locator(".shares").first.locator("tbody tr").first
    row.hover()
    lit = colours(seen, [bright, other], width)
    assert (lit[0] == before[0]).all()
    assert lit[1][3] < 60, "what is of another band fades"
    seen.page.mouse.move(0, 0)
    assert (colours(seen, [bright, other], width) == before).all()
    row.get_by_role("button").click()  # stays, as on a phone
    seen.page.mouse.move(0, 0)
    assert colours(seen, [bright, other], width)[1][3] < 60
    row.get_by_role("button").click()
    # The other way round: in the stone's list, and in its row on top.
    seen.canvas("map").evaluate("canvas => canvas.scrollIntoView()")
    seen.page.mouse.move(*seen.place(*bright, half_width=width))
    assert "lit" in (row.get_attribute("class") or "")
    cell = seen.page.locator("#scores td.lit")
    assert (cell.count(), cell.get_attribute("data-band")) == (1, "0")


def test_virtual_facets_light_up_both_ways(seen, page, studied):
    width = half_width(studied)
    facets = page_data(page.read_text(encoding="utf-8"))["stones"][0]["virtualFacets"]
    kind = facets["alike"][2]
    assert [facet for of in facets["alike"] for facet in of["members"]][:17] == list(range(17))
    outline = np.reshape(facets["outlines"][kind["members"][3]], (-1, 2))
    corner = 0.5 * (outline[0] + outline[1])  # in the middle of an edge
    row = seen.page.locator(".alike").first.locator("tbody tr").nth(2)
    assert row.inner_text().split() == [
        f"{len(kind['members'])}", "×", f"{kind['share']:.3f}", "%", f"{kind['intensity']:.1f}", "%",
    ]  # fmt: skip
    row.hover()
    assert (colours(seen, [corner], width)[0][:3] > 200).all(), "no white outline"
    seen.canvas("map").evaluate("canvas => canvas.scrollIntoView()")
    seen.page.mouse.move(*seen.place(*outline.mean(axis=0), half_width=width))
    assert "lit" in (row.get_attribute("class") or "")
    assert seen.page.locator(".alike tr.lit").count() == 1


def test_virtual_facets_are_outlined_where_the_engine_knows_them(studied):
    one = studied[0][0]
    other = observe(load_stone("inoue-1"), View.of(load_stone("inoue-1"), 16))
    known, unknown = (page_data(report_html([of]))["stones"][0] for of in (one, other))
    assert unknown["virtualFacets"] is None
    assert known["virtualFacets"]["number"] == one.measured.sizes.size
    areas = []
    for outline in known["virtualFacets"]["outlines"]:
        x, y = np.reshape(outline, (-1, 2)).T
        areas.append(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    # Corners have four digits, and a few thousand of them move areas by their edges' lengths.
    assert sum(areas) == pytest.approx(np.pi, abs=1e-3)


CHANGED = """(canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    const before = window.before ?? data;
    window.before = data;
    let changed = 0;
    for (let i = 0; i < data.length; i += 4) changed += [0, 1, 2].some((k) => before[i + k] !== data[i + k]);
    return changed;
}"""


def test_a_button_shows_the_virtual_facets(seen, studied):
    canvas, button = seen.canvas("map"), seen.page.locator("[data-virtual]").first
    assert button.inner_text() == f"{studied[0][0].measured.sizes.size} virtual facets"
    assert canvas.evaluate(CHANGED) == 0
    for pressed in ("true", "false"):
        button.click()
        seen.settle()
        assert canvas.evaluate(CHANGED) > 2000
        assert button.get_attribute("aria-pressed") == pressed


# ---- The link, and tilts -------------------------------------------------------------------------------


def test_what_was_chosen_is_in_the_link(seen, opened, page, studied):
    ray = seen.ray()
    seen.click(0.3, -0.2, half_width=half_width(studied), number=1)
    press_heading(seen, "Rear")
    seen.page.locator("#baseline").select_option("1")
    seen.page.locator("#curve select").select_option("rear")
    seen.page.locator("#scores input").focus()
    seen.page.keyboard.press("ArrowRight")
    link = seen.page.evaluate("location.hash")
    assert re.fullmatch(r"#stone=2&x=0\.\d+&y=-0\.\d+&sort=-rear&baseline=2&tilt=5&curve=rear", link)
    chosen = seen.ray(), cells(seen)
    follow(seen, "#")  # no more to be traced
    again = opened(page, link, webgl=False)
    assert (again.ray(), cells(again)) == chosen
    assert again.page.locator("#scores output").inner_text() == "5°"
    assert again.page.locator("#curve select").input_value() == "rear"
    assert again.page.locator("#baseline").input_value() == "1"
    # A link that makes no sense shows the page as it is without.
    follow(again, "#stone=9&x=here&y=1e999&sort=-grade&baseline=0&tilt=7&curve=name&%")
    assert (again.ray(), again.errors) == (ray, [])
    assert again.page.locator("#scores output").inner_text() == "0°"


#: Wait until a map is traced but for its last and finest round.
TRACED = """() => new Promise((done) => {
    const look = () => (GemPage.cards[0].map.stride > 1 ? requestAnimationFrame(look) : done());
    look();
})"""


def test_score_curve_map_and_ray_move_with_the_tilt(seen, studied):
    seen.click(0.1, 0.35, half_width=half_width(studied))
    seen.page.locator("#scores input").focus()
    seen.page.keyboard.press("End")
    _, study = studied[0]
    stone = load_stone("inoue-3")
    value, bound = numbers(study, 10.0)["iso"]
    direct = score(stone, tilt=10.0, tilt_azimuth=90.0, measures="iso").measures[0]
    assert value == pytest.approx(direct.values["value"], abs=bound + direct.bound)
    assert cells(seen)["Inoue sample 3"]["iso"] == f"{value:.2f} ±{bound_text(bound)}"
    average = numbers(study, 10.0)["average"][0]
    assert seen.page.locator(".average").first.inner_text().startswith(f"{average:.2f}")
    assert seen.page.locator("#curve .now").inner_text().startswith(f"10°: Inoue sample 3 {value:.2f} ±")
    # The ray is the reference's from there.
    view = View.of(stone, COMPARED, tilt_deg=10.0, tilt_azimuth_deg=90.0)
    told = seen.ray()
    path = full_paths(stone, [(float(told["x"]), float(told["y"]))], view=view, model=studied[0][0].model)[0]
    assert tuple(told["facets"]) == path.facet_names
    assert float(told["intensity"]) == pytest.approx(path.primary_intensity, abs=SAME_PERCENT)
    # And so is the map, once it is traced: every second pixel, and the one it stands for.
    seen.page.mouse.move(0, 0)
    seen.canvas("map").evaluate("canvas => canvas.scrollIntoView()")
    tilted = observe(stone, view, studied[0][0].model)
    kinds = np.searchsorted(-np.array(BAND_EDGES), -tilted.primary_intensity, side="left")
    kinds[tilted.rear_mask > 0] = len(BAND_COLOURS)
    kinds[tilted.status != RayStatus.EXITED] = -1
    # Away from edges: where all pixels around are alike.
    around = [np.roll(kinds, (v, u), axis=(0, 1)) for v in (-1, 0, 1) for u in (-1, 0, 1)]
    rows, columns = np.argwhere((np.array(around) == kinds).all(axis=0) & (kinds >= 0))[::7].T
    x, y = view.cell_centres()
    points = np.stack([x[columns], y[rows]], axis=1)
    palette = np.array([rgb(colour) for colour in (*BAND_COLOURS, REAR_COLOUR)])
    assert len(rows) > 50
    seen.page.evaluate(TRACED)
    found = colours(seen, points, half_width(studied))[:, :3]
    alike = (found == palette[kinds[rows, columns]]).all(axis=1).mean()
    assert alike > ALIKE_SHARE
    assert seen.page.locator("[data-virtual]").first.is_disabled()
    # A click on the curve goes to the nearest tilt.
    plot = seen.page.locator("#curve svg[role=img]")
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    seen.page.mouse.click(box["x"] + 0.55 * box["width"], box["y"] + 60)
    assert seen.page.locator("#scores output").inner_text() == "0°"


# ---- What the page is told -----------------------------------------------------------------------------


def test_sums_over_all_views_do_not_tilt(studied):
    for _, study in studied:
        upright = {of.name: of for of in study.measures}
        for turned in study.turned:
            of = {each.name: each for each in turned.measures}
            assert of["wlr-like"] is upright["wlr-like"]
            assert of["iso"].values != upright["iso"].values


def test_the_scores_own_values_come_first_and_once():
    found = score(load_stone("inoue-3"), engine="reference", resolution=16, measures="window,inoue")
    own, *others = all_measures(found)
    assert (own.name, own.values["average"], own.values["rear"]) == ("inoue", found.average, found.rear)
    assert [of.name for of in others] == ["window"]


@pytest.mark.parametrize(("to", "step"), [(90, 1), (-1, 1), (30, 0), (30, 31), (30, 0.1)])
def test_tilts_out_of_range_are_refused(to, step):
    with pytest.raises(InputError, match="must be"):
        check_tilts(to, step)


def test_stones_of_a_page_have_the_same_measures(studied):
    other = study_stone(load_stone("inoue-1"), engine="reference", resolution=16, measures="window")
    with pytest.raises(InputError, match="must have the measures and turns of the first stone"):
        report_html([studied[0], other])


def test_the_command(gemrender, tmp_path):
    out = tmp_path / "page.html"
    asked = ["report", "inoue-3", "--engine", "reference", "--resolution", "16", "-o", out]
    tilts = ["--tilts", "20", "--tilt-step", "10", "--tilt-axis", "y"]
    status, _, err = gemrender(*asked, "--measures", "iso", "--head", "20", *tilts)
    assert status == 0, err
    table = page_data(out.read_text(encoding="utf-8"))["table"]
    assert (table["turns"], table["axis"]) == ([-20, -10, 0, 10, 20], "y")
    column = [column["key"] for column in table["columns"]].index("iso")
    for turn, values in zip(table["turns"], table["values"][0], strict=True):
        wanted = score(
            load_stone("inoue-3"), engine="reference", resolution=16, measures="iso", head=20.0,
            tilt=abs(turn), tilt_azimuth=180.0 if turn > 0 else 0.0,
        )  # fmt: skip
        # Poses that symmetry makes of each other are traced once.
        assert values[column] == pytest.approx(wanted.measures[0].values["value"], abs=ROUNDING)
    for more, words in (
        (
            ["--tilts", "10", "--tilt", "5"],
            "--tilts = 10.0: is from straight above, and cannot be given with tilt",
        ),
        (["--tilts", "95"], "--tilts = 95.0: must be above 0 and below 90 [deg]"),
        (["--tilts", "20", "--tilt-step", "30"], "--tilt-step = 30.0: must be from 0.222 to 20 [deg]"),
        (["--measures", "isi"], "--measures = 'isi': must be one of"),
    ):
        status, _, err = gemrender(*asked, *more)
        assert (status, err.count("\n")) == (2, 1)
        assert words in err

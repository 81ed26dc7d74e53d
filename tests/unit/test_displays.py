"""The paper's displays: each draws, says what it must, and no label lies on another."""

from __future__ import annotations

import os
import stat
import xml.etree.ElementTree as ElementTree
from functools import cache

import numpy as np
import pytest
from displays_help import boxes, measured_stone, overlaps, texts
from matplotlib import image
from solids import BRILLIANTS
from thorough import chosen, some

from gemrender.cuts import RoundBrilliant, load_stone, stone_from_vertices
from gemrender.cuts.round_brilliant.topology import FACET_KINDS, GIRDLE, TRIANGLES, VERTEX_LABELS
from gemrender.errors import InputError
from gemrender.observation import Model, RayStatus
from gemrender.reference import full_paths
from gemrender.report import displays
from gemrender.report.brilliant.triangles import visible_triangles
from gemrender.report.brilliant.vertices import VERTEX_CODES, visible_vertices
from gemrender.report.dimensions import dimensions
from gemrender.report.displays import DISPLAYS, FORMATS, draw, write_display
from gemrender.report.displays.fan import fan_points
from gemrender.report.displays.projection import CROWN, OBLIQUE, PAVILION, PIECES, look_at, section, side
from gemrender.report.displays.ray_colours import RAY_COLOURS, REAR_COLOUR, ray_colour
from gemrender.report.displays.rays import default_points
from gemrender.stone import Stone, tessellate

#: Means over a measured stone's places, and what they are compared with [%]: float64 rounding.
ROUNDING_PERCENT = 1e-10
#: Values are written with two decimals.
WRITTEN = 0.005

DRAWINGS = ("outline", "vertices", "shape", "triangles", "rays", "fan")
NAMES = chosen(("measured", *BRILLIANTS), ("measured", "inoue-2"))


@cache
def stone_named(name):
    return measured_stone() if name == "measured" else load_stone(name)


@cache
def drawn(name, what):
    return draw(stone_named(name), what)


@pytest.fixture(params=NAMES)
def name(request):
    return request.param


# ---- Every display of every stone ----


LABELLED = [(name, what) for name in ("measured", *BRILLIANTS) for what in DRAWINGS]


@pytest.mark.parametrize(
    ("name", "what"),
    chosen(LABELLED, [("measured", "rays"), ("measured", "vertices"), ("inoue-2", "rays")]),
)
def test_labels_do_not_overlap_and_stay_on_the_page(name, what):
    figure = drawn(name, what)
    assert overlaps(figure) == []
    width, height = figure.bbox.size
    for text, (left, bottom, right, top) in boxes(figure):
        assert left >= 0, text
        assert bottom >= 0, text
        assert right <= width, text
        assert top <= height, text


#: At the edges of the allowed proportions: all lines close together, or far apart.
EXTREMES = {
    "thin and flat": RoundBrilliant(
        table=90, star=99, lower_girdle_contact=1, crown_height=0.5, pavilion_depth=2, girdle_thickness=0
    ),
    "tall": RoundBrilliant(
        table=5, star=50, lower_girdle_contact=99, crown_height=60, pavilion_depth=100, girdle_thickness=50
    ),
    "narrow mains": RoundBrilliant(
        table=70, star=70, lower_girdle_contact=2, crown_height=9, pavilion_depth=43, girdle_thickness=0.5
    ),
}


DRAWN = [(extreme, what) for extreme in EXTREMES for what in ("outline", "shape", "rays", "fan")]


@pytest.mark.parametrize(
    ("extreme", "what"),
    chosen(DRAWN, [*zip(EXTREMES, ("outline", "fan", "shape"), strict=True), ("narrow mains", "rays")]),
)
def test_extreme_stones_draw(extreme, what):
    draw(Stone.from_proportions(EXTREMES[extreme], name=extreme), what).canvas.draw()


@pytest.mark.parametrize("formats", chosen(["png svg", "png svg pdf"], ["png svg"]))
def test_the_map_is_that_of_the_report(formats, tmp_path):
    formats = formats.split()
    written = write_display(
        stone_named("inoue-3"), "map", tmp_path, "x", formats=formats, engine="reference", resolution=32
    )
    assert [path.name for path in written] == [f"x-map.{ending}" for ending in formats]
    assert all(path.stat().st_size > 10_000 for path in written)


# ---- Outline ----


@pytest.mark.parametrize("bundled", some(BRILLIANTS, 4))
def test_the_outline_says_the_proportions(bundled):
    p = stone_named(bundled).proportions
    said = texts(drawn(bundled, "outline"))
    for symbol, value in {
        "TB": p.table, "LG": p.lower_girdle_contact, "CH": p.crown_height, "PD": p.pavilion_depth,
        "GH": p.girdle_thickness,
    }.items():  # fmt: skip
        [text] = [text for text in said if text.startswith(f"{symbol} ")]
        assert text.splitlines()[0] == f"{symbol} {value:.2f} %"
    assert f"SU a : b = {p.star:g} : {100 - p.star:g}" in said
    assert f"α {p.crown_angle_deg:.2f}°" in said
    assert f"β {p.pavilion_angle_deg:.2f}°" in said
    assert f"{p.crown_height + p.girdle_thickness + p.pavilion_depth:.2f} %" in said


def test_the_angles_of_a_report_come_back():
    """gia-excellent is entered by angles."""
    said = texts(drawn("gia-excellent", "outline"))
    assert {"α 34.00°", "β 40.70°"} <= set(said)


@pytest.mark.parametrize("bundled", ["inoue-1", "tolkowsky"])
def test_a_stone_is_measured_as_it_was_made(bundled):
    made = stone_named(bundled)
    measured = stone_from_vertices(2.5 * made.vertices + (1, 2, 3))
    expected = dimensions(made)
    for key, dimension in dimensions(measured).items():
        assert dimension.value == pytest.approx(expected[key].value, abs=ROUNDING_PERCENT), key
        assert dimension.most - dimension.least < ROUNDING_PERCENT


def test_a_measured_outline_says_mean_and_spread():
    stone = stone_named("measured")
    said = texts(drawn("measured", "outline"))
    table = np.hypot(*(stone.vertices[:4] - stone.vertices[4:8])[:, :2].T)
    radius = np.hypot(*stone.vertices[16:48, :2].T).mean()
    percent = 100 * table / (2 * radius)
    assert f"TB {percent.mean():.2f} %" in said
    assert f"{percent.min():.2f} – {percent.max():.2f}" in said
    tilts = [
        np.degrees(np.arccos(abs(stone.facet_normals[i, 2])))
        for i, kind in enumerate(FACET_KINDS)
        if kind == "pavilion_main"
    ]
    assert f"β {np.mean(tilts):.2f}°" in said
    assert f"{min(tilts):.2f} – {max(tilts):.2f}" in said


def test_dimension_lines_have_the_lengths_they_say():
    """The extension lines of TB and PD stand as far apart as the stone's parts."""
    p = stone_named("inoue-1").proportions
    profile = drawn("inoue-1", "outline").axes[2]
    lines = [line.get_xydata() for line in profile.lines]
    upright = sorted({round(float(a[0]), 9) for a, b in lines if a[0] == b[0]})
    level = sorted({round(float(a[1]), 9) for a, b in lines if a[1] == b[1]})
    assert np.ptp(upright[1:3]) == pytest.approx(2 * p.table / 100)
    assert upright[-1] - upright[0] >= 2
    heights = np.diff(level)
    expected = [2 * p.pavilion_depth / 100, 2 * p.girdle_thickness / 100, 2 * p.crown_height / 100]
    assert heights == pytest.approx(expected)


# ---- Vertices and triangles ----


def test_codes_abbreviate_the_labels_of_files():
    for code, label in zip(VERTEX_CODES, VERTEX_LABELS, strict=True):
        kind, _, number = label.rpartition("_")
        letters = {
            "table": "T",
            "star": "S",
            "girdle_upper": "U",
            "girdle_lower": "L",
            "contact": "C",
            "": "K",
        }
        assert code == (letters[kind] + number if kind else "K")


def test_every_vertex_is_labelled(name):
    crown, pavilion, profile, _ = drawn(name, "vertices").axes
    labels = [[text.get_text() for text in axes.texts] for axes in (crown, pavilion, profile)]
    assert sorted(labels[0]) == sorted(VERTEX_CODES[:32])
    assert sorted(labels[1]) == sorted(VERTEX_CODES[32:])
    assert len(labels[2]) == len(set(labels[2])) >= 30


def test_every_triangle_is_numbered(name):
    crown, pavilion, profile, _ = drawn(name, "triangles").axes
    numbers = [sorted(int(text.get_text()) for text in axes.texts) for axes in (crown, pavilion, profile)]
    assert numbers[0] == list(range(1, 47))
    assert numbers[1] == list(range(47, 79))
    assert numbers[2][-1] == 79
    assert len(set(numbers[2])) == len(numbers[2])


def test_numbers_stand_in_their_triangles_or_have_a_leader():
    """Of the crown every number stands in its own triangle."""
    stone = stone_named("inoue-3")
    figure = drawn("inoue-3", "triangles")
    crown = figure.axes[0]
    flat = CROWN.flat(stone.vertices)
    for text, box in zip(crown.texts, _data_boxes(crown), strict=True):
        a, b, c = flat[TRIANGLES[int(text.get_text()) - 1]]
        for corner in (box[:2], box[2:], box[[0, 3]], box[[2, 1]]):
            weights = np.linalg.solve(np.array([a - c, b - c]).T, corner - c)
            assert weights.min() > 0
            assert weights.sum() < 1


def _data_boxes(axes):
    from gemrender.report.displays.labels import text_boxes

    corners = axes.transData.inverted().transform(text_boxes(axes).reshape(-1, 2))
    return corners.reshape(-1, 4)


# ---- Hidden lines ----


@pytest.mark.parametrize("bundled", BRILLIANTS)
def test_facets_seen_from_above_and_below(bundled):
    stone = stone_named(bundled)
    crown, pavilion = look_at(stone, CROWN), look_at(stone, PAVILION)
    assert crown.facets == tuple(range(33))
    assert pavilion.facets == tuple(range(33, 57))
    assert len(visible_vertices(crown)) == len(visible_vertices(pavilion)) + 7 == 32
    # An octagon of a table falls into six; bezels and mains have four corners, the others three
    assert len(visible_triangles(stone, crown)) == 6 + 8 + 2 * 8 + 16
    assert len(visible_triangles(stone, pavilion)) == 2 * 8 + 16


@pytest.mark.parametrize("bundled", BRILLIANTS)
def test_facets_seen_from_the_side(bundled):
    """By symmetry half of each kind, less what is seen edge on."""
    view = look_at(stone_named(bundled), side())
    seen = [FACET_KINDS[facet] for facet in view.facets]
    # Four stars; of the mains two are edge on at either end; all girdle facets of the near half.
    assert {kind: seen.count(kind) for kind in set(seen)} == {
        "star": 4, "bezel": 3, "upper_girdle": 8, "lower_girdle": 8, "pavilion_main": 3, "girdle": 1,
    }  # fmt: skip


def test_edges_of_a_plan_view():
    """Edges of the table, of stars, of bezels, between upper girdle facets; arcs around."""
    view = look_at(stone_named("inoue-1"), CROWN)
    corners = sum(len(line) - 1 for line in view.outline)
    assert corners == 16 * 16
    rim = np.concatenate(view.outline)
    assert np.hypot(*rim.T) == pytest.approx(1.0)
    # Inside, every edge is straight; joined where they belong to the same two facets.
    assert sum(len(line) - 1 for line in view.visible) == 8 + 16 + 16 + 8
    assert sum(len(line) - 1 for line in view.hidden) == 16 * 16 + 8 + 16 + 8


@pytest.mark.parametrize(
    "projection", [CROWN, PAVILION, OBLIQUE, side(), side(11.25), side(-100)], ids=lambda p: p.name
)
@pytest.mark.parametrize("name", ["inoue-1", "fish-eye", "measured"])
def test_visible_polygons_fill_the_silhouette(projection, name):
    """Shoelace areas: the visible facets' sum is that of the silhouette, the convex hull of the mesh."""
    stone = stone_named(name)
    area = sum(_area(polygon) for polygon in look_at(stone, projection).polygons)
    hull = _area(_hull(projection.flat(tessellate(stone, PIECES).vertices)))
    # A measured stone is not quite convex: by its deviations times its circumference.
    assert area == pytest.approx(hull, rel=1e-9 if stone.proportions else 0.01)


def _area(polygon):
    x, y = polygon.T
    return abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def _turn(a, b, c):
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])


def _hull(points):
    """Convex hull by Andrew's monotone chain."""
    chains = []
    for ordered in (sorted(map(tuple, points)), sorted(map(tuple, points), reverse=True)):
        chain = []
        for p in ordered:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        chains += chain[:-1]
    return np.array(chains)


@pytest.mark.parametrize("azimuth", [0.0, 7.0, 22.5, 90.0])
def test_a_section_lies_within_the_side_view(azimuth, name):
    stone = stone_named(name)
    outline = section(stone, azimuth)
    low, high = stone.vertices[:, 2].min(), stone.vertices[:, 2].max()
    assert outline[:, 1].min() == pytest.approx(low, abs=0.02)
    assert outline[:, 1].max() == pytest.approx(high, abs=0.02)
    if stone.proportions:
        assert np.abs(outline[:, 0]).max() == pytest.approx(1.0, abs=1e-4)  # the arcs' sagitta
        if azimuth in (0.0, 90.0):  # a trapezium, the wall and a triangle
            p = stone.proportions
            r, c, g, d = p.table / 100, p.crown_height / 50, p.girdle_thickness / 50, p.pavilion_depth / 50
            assert _area(outline) == pytest.approx((1 + r) * c + 2 * g + d)


# ---- Rays ----


def test_a_ray_is_told_in_full():
    stone = stone_named("inoue-3")
    [path] = full_paths(stone, [(0.3, 0.1)])
    figure = draw(stone, "rays", at=[(0.3, 0.1)])
    said = texts(figure)
    assert "The path of a ray" in said
    assert f"{path.primary_intensity:.1f} %" in said
    for triple in (path.points[-1], -path.directions[-1]):
        assert f"({', '.join(f'{v + 0.0:.3f}' for v in triple)})".replace("-", "−") in said
    names = [name.replace("_", " ") for name in path.facet_names]
    assert [text for text in said if text in names] == names[::-1], "as the light runs"
    for angle in path.incidence_deg[1:]:
        assert f"{angle:.1f}°" in said


def test_the_drawn_line_is_the_path():
    stone = stone_named("inoue-3")
    [path] = full_paths(stone, [(0.3, 0.1)])
    crown, profile, *_ = draw(stone, "rays", at=[(0.3, 0.1)]).axes
    for axes, projection in ((crown, CROWN), (profile, side())):
        lines = [segment for c in axes.collections if c.get_zorder() == 7 for segment in c.get_segments()]
        assert len(lines) == 1
        assert lines[0][1:-1] == pytest.approx(projection.flat(path.points[::-1]))


def test_colours_tell_intensity():
    stone = stone_named("inoue-1")
    paths = full_paths(stone, np.random.default_rng(1).uniform(-0.7, 0.7, (300, 2)))
    rear = [path for path in paths if path.rear]
    lit = sorted(
        (path for path in paths if path.status == RayStatus.EXITED and not path.rear),
        key=lambda path: path.primary_intensity,
    )
    assert {ray_colour(path) for path in rear} == {REAR_COLOUR} == {"#ffffff"}
    weak, strong = ray_colour(lit[0]), ray_colour(lit[-1])
    assert weak[0] < strong[0]
    assert all(colour[0] > max(colour[1:3]) for colour in (weak, strong)), "red"


def test_the_red_scale_is_read_without_seeing_red():
    """Lightness rises evenly, by CIE 1976, for eyes that see no red too (its luminance left out)."""
    rgb = np.array([list(bytes.fromhex(c[1:])) for c in RAY_COLOURS]) / 255
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    for weights in ((0.2126, 0.7152, 0.0722), (0.1124, 0.8876, 0.0)):  # sRGB; protanopes (Viénot 1999)
        lightness = 116 * np.cbrt(linear @ np.array(weights)) - 16
        assert (np.diff(lightness) > 3).all()


def test_default_points_show_a_bright_a_weak_and_a_rear_ray():
    stone = stone_named("inoue-1")
    points = default_points(stone, Model.of(stone))
    bright, weak, rear = full_paths(stone, points)
    assert bright.primary_intensity > 70 > 40 > weak.primary_intensity > 0
    assert rear.rear


@pytest.mark.parametrize("count", chosen([1, 2, 5, 13, 40], [1, 5, 13]))
def test_many_points(count):
    points = [(0.9 * np.cos(i) * i / count, 0.9 * np.sin(i) * i / count) for i in range(count)]
    figure = draw(stone_named("inoue-1"), "rays", at=points)
    said = texts(figure)
    assert f"The paths of {count} rays" in said or count == 1
    if count <= 5:
        assert overlaps(figure) == []


def test_a_ray_that_is_reflected_often_is_told_in_short():
    stone = stone_named("inoue-2")
    [path] = full_paths(stone, [(0.508, 0.193)])
    assert path.reflections > 40
    figure = draw(stone, "rays", at=[(0.508, 0.193)])
    [gap] = [text for text in texts(figure) if "total reflections more" in text]
    told = len([text for text in texts(figure) if text in ("total reflection", "light in", "to the eye")])
    assert int(gap.split()[0]) + told == len(path.points)
    assert overlaps(figure) == []


@pytest.mark.parametrize("azimuth", chosen([0.0, 22.5, -33.0], [-33.0]))
def test_a_fan_is_equally_spaced_and_says_its_intensities(azimuth):
    stone = stone_named("inoue-2")
    points = fan_points(stone, azimuth, 16)
    direction = np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))])
    assert np.diff(points @ direction) == pytest.approx(2 / 16, abs=1e-4)
    assert points @ (direction[::-1] * (-1, 1)) == pytest.approx(0, abs=1e-12)
    paths = full_paths(stone, points)
    axes = draw(stone, "fan", azimuth_deg=azimuth, rays=16).axes[0]
    assert [text.get_text() for text in axes.texts] == [f"{path.primary_intensity:.0f}" for path in paths]


def test_in_a_plane_of_symmetry_the_fan_stays_in_it():
    paths = full_paths(stone_named("inoue-3"), fan_points(stone_named("inoue-3"), 0.0, 24))
    assert max(np.abs(path.points[:, 1]).max() for path in paths) < 1e-9


# ---- Files ----


#: Every drawing's lines, and one in all formats; all in all are slow.
FILES = [*((what, ("svg",)) for what in DRAWINGS), *((what, FORMATS) for what in DRAWINGS)]


@pytest.mark.parametrize(
    ("what", "formats"), chosen(FILES, [*FILES[1 : len(DRAWINGS)], ("outline", FORMATS)])
)
def test_files(what, formats, tmp_path, monkeypatch):
    monkeypatch.setattr(displays, "draw", lambda _, what: drawn("inoue-3", what))
    written = write_display(stone_named("inoue-3"), what, tmp_path, "stem", formats=formats)
    assert [path.name for path in written] == [f"stem-{what}.{suffix}" for suffix in formats]
    assert sorted(tmp_path.iterdir()) == sorted(written)
    of = {path.suffix: path for path in written}
    if ".png" in of:
        assert image.imread(of[".png"]).shape[1] > 1500
        assert f"Title\0Inoue sample 3: {what}".encode() in of[".png"].read_bytes()
    root = ElementTree.parse(of[".svg"]).getroot()
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert not list(root.iter("{http://www.w3.org/2000/svg}image")), "lines, not pixels"


def test_the_same_picture_is_the_same_file(tmp_path):
    for stem in "ab":
        write_display(stone_named("inoue-3"), "shape", tmp_path, stem, formats=("svg",))
    assert (tmp_path / "a-shape.svg").read_bytes() == (tmp_path / "b-shape.svg").read_bytes()


def test_a_name_that_no_font_has_and_mathematics(tmp_path):
    stone = stone_named("inoue-3")
    for title in ("井上 \U0001f48e $\\frac{$ <b>&", "x" * 150):
        named = Stone.from_proportions(stone.proportions, name=title)
        [path] = write_display(named, "shape", tmp_path, "s", formats=("svg",))
        ElementTree.parse(path)


def test_a_failure_leaves_what_was_there(tmp_path, monkeypatch):
    there = tmp_path / "s-shape.png"
    there.write_bytes(b"before")

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", full)
    with pytest.raises(InputError, match=r"s-shape\.png: cannot be written: No space left on device$"):
        write_display(stone_named("inoue-3"), "shape", tmp_path, "s")
    assert there.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [there]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_written(tmp_path):
    tmp_path.chmod(stat.S_IRUSR | stat.S_IXUSR)
    with pytest.raises(InputError, match="cannot be written"):
        write_display(stone_named("inoue-3"), "shape", tmp_path, "s")


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(InputError, match="cannot be written: No such file or directory"):
        write_display(stone_named("inoue-3"), "shape", tmp_path / "none", "s")


# ---- Bad input ----


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"display": "photo"}, r"what = 'photo': must be one of outline, vertices, "),
        ({"display": "rays", "at": [(1.0, 0.1)]}, r"at = \(1.0, 0.1\): lies outside the stone"),
        ({"display": "rays", "at": [(0, 0.1), (1e300, 0)]}, r"at = \(1e\+300, 0.0\): lies outside the stone"),
        ({"display": "rays", "at": [(float("nan"), 0)]}, r"at = \(nan, 0.0\): must be two finite numbers"),
        ({"display": "rays", "at": [(0.1, 0, 0)]}, r"must be pairs of numbers x, y"),
        ({"display": "rays", "at": []}, r"must be pairs of numbers x, y"),
        ({"display": "rays", "at": "ab"}, r"at = 'ab': must be pairs of numbers x, y"),
        ({"display": "rays", "at": [(0, 0)] * 101}, r"must be at most 100 points, not 101"),
        ({"display": "rays", "azimuth_deg": float("inf")}, r"azimuth = inf: must be a finite angle"),
        ({"display": "fan", "azimuth_deg": float("nan")}, r"azimuth = nan: must be a finite angle"),
        ({"display": "fan", "rays": 0}, r"rays = 0: must be a whole number from 1 to 200"),
        ({"display": "fan", "rays": 2.5}, r"rays = 2.5: must be a whole number"),
        ({"display": "rays", "fresnel": "none"}, r"fresnel = 'none': must be one of"),
    ],
    ids=str,
)
def test_bad_input_is_one_line(options, said):
    with pytest.raises(InputError, match=said) as caught:
        draw(stone_named("inoue-3"), **options)
    assert "\n" not in str(caught.value)


def test_an_unknown_format(tmp_path):
    with pytest.raises(InputError, match=r"format = 'gif': must be one of png, svg, pdf"):
        write_display(stone_named("inoue-3"), "shape", tmp_path, "s", formats=("gif",))


def test_the_command_knows_what_the_package_draws(gemrender, folder):
    allowed = ", ".join([*DISPLAYS, "all"])
    assert gemrender("show", "inoue-3", "--what", "?") == (
        2, "", f"gemrender: --what = '?': must be one of {allowed}\n"
    )  # fmt: skip
    assert gemrender("show", "inoue-3", "--what", "shape", "--format", "all", "--out", "drawn")[0] == 0
    assert {path.name for path in (folder / "drawn").iterdir()} == {f"inoue-3-shape.{of}" for of in FORMATS}


def test_points_as_the_command_line_gives_them(gemrender, folder):
    drawing = ("show", "inoue-3", "--what", "rays", "--format", "svg")
    given = ("--at", "0.3,0.1", "--at", "-0.2, .5 ;0,0")
    assert gemrender(*drawing, *given)[0] == 0
    points = [(0.3, 0.1), (-0.2, 0.5), (0.0, 0.0)]
    [expected] = write_display(stone_named("inoue-3"), "rays", folder, "x", formats=("svg",), at=points)
    assert (folder / "inoue-3-rays.svg").read_bytes() == expected.read_bytes()


@pytest.mark.parametrize("text", ["", "1", "1,2,3", "a,b", "nan,0", "0,inf", ","])
def test_what_is_no_point_is_refused_in_one_line(text, gemrender, folder):
    status, _, err = gemrender("show", "inoue-3", "--what", "rays", "--at", text)
    assert (status, err.count("\n")) == (2, 1)
    assert err.startswith(f"gemrender: --at = '{text}': must be two finite numbers x,y")
    assert list(folder.iterdir()) == []


def test_only_the_near_side_is_seen_of_the_girdle():
    assert GIRDLE in look_at(stone_named("inoue-1"), side(33.0)).facets

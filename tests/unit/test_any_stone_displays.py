"""Displays of faceters' designs and of a stone that is not convex: every kind of `show` draws every stone."""

from __future__ import annotations

import json
from functools import cache

import numpy as np
import pytest
from any_stones import FOLDER, design, hollow_stone
from displays_help import boxes, overlaps, texts
from matplotlib.colors import to_hex
from thorough import chosen

from gemrender.beam import trace_facets
from gemrender.beam.facets import FacetStatus
from gemrender.report.displays import draw, write_display
from gemrender.report.displays.occlusion import is_hidden, split_by_sight
from gemrender.report.displays.projection import CROWN, PAVILION, corners_of, look_at, side
from gemrender.report.facets import facets_figure
from gemrender.report.palettes import OTHER_KINDS, TIER_COLOURS, exit_colours, kind_tints
from gemrender.stone import Facet, Stone, convex_solid, in_frame, side_of

DRAWINGS = ("outline", "vertices", "shape", "triangles", "rays", "fan")
NAMES = ("emerald", "pear", "slab-chiral", "hollow")
TRUTH = json.loads((FOLDER / "truth.json").read_text(encoding="utf-8"))
#: Shares are written with one decimal.
WRITTEN = 0.05


@cache
def stone_named(name: str) -> Stone:
    return hollow_stone() if name == "hollow" else design(name)


@cache
def drawn(name, display):
    return draw(stone_named(name), display)


LABELLED = [(name, display) for name in NAMES for display in DRAWINGS]
#: Each drawing, and each stone twice.
SHOWN = [
    ("emerald", "outline"), ("emerald", "vertices"), ("pear", "triangles"), ("pear", "fan"),
    ("slab-chiral", "shape"), ("slab-chiral", "rays"), ("hollow", "triangles"), ("hollow", "fan"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "display"), chosen(LABELLED, SHOWN))
def test_labels_do_not_overlap_and_stay_on_the_page(name, display):
    figure = drawn(name, display)
    assert overlaps(figure) == []
    width, height = figure.bbox.size
    for text, (left, bottom, right, top) in boxes(figure):
        assert 0 <= left <= right <= width, text
        assert 0 <= bottom <= top <= height, text


# ---- Outline -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["emerald", "pear"])
def test_the_outline_says_length_and_width(name):
    said = texts(drawn(name, "outline"))
    ratio = TRUTH[name]["solid"]["length_over_width_box"]
    assert f"L {100 * ratio:.2f} %" in said
    assert "W 100.00 %" in said
    assert f"{ratio:.3f}" in said


def test_the_outline_names_the_tiers_with_their_angles():
    """Tier P1 of the file: two facets at 47 degrees."""
    said = [text.get_text() for text in drawn("emerald", "outline").axes[-1].texts]
    assert said[said.index("P1") + 1 :][:2] == ["2", "47.00°"]
    kinds = dict.fromkeys(stone_named("emerald").facet_kinds)
    assert set(kinds) <= set(said)


def test_dimension_lines_have_the_lengths_they_say():
    """Heights of crown, girdle and pavilion of the side view add up to the stone's."""
    stone = stone_named("emerald")
    profile = drawn("emerald", "outline").axes[2]
    lines = [line.get_xydata() for line in profile.lines]
    heights = sorted({round(float(a[1]), 9) for a, b in lines if a[1] == b[1]})
    z = stone.solid.vertices[:, 2]
    assert heights[0] == pytest.approx(z.min())
    assert heights[-1] == pytest.approx(z.max())
    assert 0.0 in [pytest.approx(height, abs=1e-6) for height in heights]  # the girdle's lower edge


# ---- Corners and facets --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["emerald", "pear"])
def test_every_corner_is_numbered(name):
    crown, pavilion, _, _ = drawn(name, "vertices").axes
    numbers = {int(text.get_text()) for axes in (crown, pavilion) for text in axes.texts}
    assert numbers == set(range(1, len(corners_of(stone_named(name))) + 1))


def test_corners_are_where_three_facets_meet():
    """Neighbours that should be one point, and are not by the rounding of the file, are one."""
    corners = corners_of(stone_named("emerald"))
    solid = stone_named("emerald").solid
    on = np.abs(corners @ solid.planes[:, :3].T - solid.planes[:, 3]) < 3e-3
    assert on.sum(axis=1).min() >= 3
    apart = np.abs(corners[:, None] - corners).max(axis=-1) + 10 * np.eye(len(corners))
    assert apart.min() > 3e-3


@pytest.mark.parametrize("name", ["emerald", "pear", "hollow"])
def test_facets_are_named_where_they_are(name):
    """Each name stands in its own polygon; of the crown all but slivers have theirs."""
    stone = stone_named(name)
    figure = drawn(name, "triangles")
    for axes, projection in zip(figure.axes, (CROWN, PAVILION), strict=False):
        view = look_at(stone, projection)
        polygons = {i: polygon[:-1] for i, polygon in zip(view.facets, view.polygons, strict=True)}
        places = {text.get_text(): np.array(text.get_position()) for text in axes.texts}
        named = {i for i, facet in enumerate(stone.facets) if facet.name.replace("_", " ") in places}
        assert named <= polygons.keys()
        for number in named:
            place = places[stone.facets[number].name.replace("_", " ")]
            assert _contains(polygons[number], place)
        large = {i for i, polygon in polygons.items() if _area(polygon) > 0.02}
        assert large <= named


def _area(polygon):
    x, y = polygon.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _contains(polygon, place):
    to, along = place - polygon, np.roll(polygon, -1, axis=0) - polygon
    side = along[:, 0] * to[:, 1] - along[:, 1] * to[:, 0]
    return (side > 0).all() or (side < 0).all()


def test_the_legend_counts_every_tier():
    said = [text.get_text() for text in drawn("pear", "triangles").axes[-1].texts]
    stone = stone_named("pear")
    told = dict(zip(said[1::2], said[2::2], strict=False))
    for kind in dict.fromkeys(stone.facet_kinds):
        assert told[kind] == str(stone.facet_kinds.count(kind))


def test_tints_go_on_for_any_number_of_tiers():
    stone = stone_named("hollow")
    tints = kind_tints(stone)
    assert tints.keys() == {(facet.side, facet.kind) for facet in stone.facets}
    assert len({tint for (side, _), tint in tints.items() if side == "girdle"}) == 1


def test_of_very_many_corners_those_with_room_are_numbered():
    """A solid of 200 planes that touch an ellipsoid has some 400 corners."""
    normals = np.random.default_rng(5).normal(size=(200, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    offsets = np.linalg.norm(normals * (1.0, 0.8, 0.6), axis=1)
    solid, _ = convex_solid(in_frame(np.column_stack([normals, offsets]))[0], np.arange(200))
    facets = tuple(Facet(f"F{i}", "F", side_of(plane[2])) for i, plane in enumerate(solid.planes))
    figure = draw(Stone(solid=solid, facets=facets, material=1.7), "vertices")
    assert overlaps(figure) == []
    assert len(figure.axes[0].texts) > 100
    assert any("have no room for their number" in text for text in texts(figure))


# ---- Virtual facets ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["emerald", "pear"])
def test_every_virtual_facet_has_the_colour_of_the_tier_its_light_comes_in_through(name):
    stone = stone_named(name)
    facets = trace_facets(stone)
    drawn_ones = np.flatnonzero(facets.is_counted)
    exits = np.array([facets.path(int(i))[-1] for i in drawn_ones])
    kinds = exit_colours(stone, np.bincount(exits, facets.area[drawn_ones], len(stone.facets)))
    figure = facets_figure(stone, colour="facet")
    [shown] = [c for c in figure.axes[0].collections if c.get_gid() == "virtual-facets"]
    by_polygon = {
        path.vertices[:-1].tobytes(): to_hex(face)
        for path, face in zip(shown.get_paths(), shown.get_facecolors(), strict=True)
    }
    assert len(by_polygon) == len(drawn_ones)
    for i, facet in zip(drawn_ones, exits, strict=True):
        if facets.status[i] == FacetStatus.EXITED:
            colour = kinds.colours[kinds.group[facet]][int(facets.rear_mask[i])]
            assert by_polygon[facets.polygon(int(i)).tobytes()] == colour


def test_of_many_tiers_those_with_most_of_the_view_have_colours():
    stone = stone_named("pear")  # 22 tiers
    weight = np.zeros(len(stone.facets))
    weight[stone.facet_kinds.index("m")], weight[stone.facet_kinds.index("T")] = 2.0, 1.0
    kinds = exit_colours(stone, weight)
    assert kinds.names[:2] == ("m", "T")
    assert len(kinds.names) == len(TIER_COLOURS) + 1
    assert kinds.names[-1] == f"{22 - len(TIER_COLOURS)} other tiers"
    assert kinds.colours[-1] == OTHER_KINDS


def test_shares_make_a_hundred():
    said = [text.get_text() for text in facets_figure(stone_named("pear"), colour="facet").axes[1].texts]
    start = next(i for i, text in enumerate(said) if text.startswith("Share of the view by "))
    end = next(i for i, text in enumerate(said) if text.endswith(" virtual facets"))
    shares = [float(text.removesuffix(" %")) for text in said[start + 1 : end] if text.endswith(" %")]
    assert sum(shares) == pytest.approx(100.0, abs=WRITTEN * len(shares))


def test_scales_count_half_lengths_where_a_stone_is_not_round():
    axes = facets_figure(stone_named("pear")).axes[0]
    assert axes.get_xlabel() == "x [half length]"


def test_all_of_them_are_files(tmp_path):
    for display in ("map", "facets", "triangles"):
        options = {"engine": "reference", "resolution": 24} if display == "map" else {}
        [path] = write_display(stone_named("pear"), display, tmp_path, "pear", formats=("svg",), **options)
        assert path.name == f"pear-{display}.svg"
        assert path.stat().st_size > 10_000


# ---- What hides what -----------------------------------------------------------------------------------


def test_a_point_is_hidden_by_a_face_before_it():
    face = np.array([[[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]])
    points = np.array([[0.2, 0.2, 0.0], [0.2, 0.2, 1.0], [0.2, 0.2, 2.0], [0.9, 0.9, 0.0]])
    assert is_hidden(points, face).tolist() == [True, False, False, False]


def test_a_line_is_cut_where_it_goes_behind_a_face():
    face = np.array([[[0.0, -1.0, 1.0], [2.0, 0.0, 1.0], [0.0, 1.0, 1.0]]])
    [seen], [hidden] = split_by_sight(np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), face)
    assert seen[[0, -1]].tolist() == [[-1.0, 0.0], [0.0, 0.0]]
    assert hidden[[0, -1]].tolist() == [[0.0, 0.0], [1.0, 0.0]]


def test_from_the_side_the_pit_of_a_hollow_stone_is_hidden_by_its_rim():
    """Its bottom is in the middle, 0.1 below the top; from above it is seen."""
    stone = stone_named("hollow")
    bottom = corners_of(stone)[np.abs(corners_of(stone)[:, :2]).max(axis=1) < 1e-9][0]
    for view, is_seen in ((look_at(stone, side()), False), (look_at(stone, CROWN), True)):
        place = view.projection.flat(bottom)
        ends = np.concatenate([np.concatenate([line[:1], line[-1:]]) for line in view.visible])
        assert (np.abs(ends - place).max(axis=1).min() < 1e-9) == is_seen
    pit = {i for i, facet in enumerate(stone.facets) if facet.name in ("F29", "F30", "F31", "F32")}
    assert pit <= set(look_at(stone, CROWN).facets)
    assert not pit & set(look_at(stone, side()).facets)

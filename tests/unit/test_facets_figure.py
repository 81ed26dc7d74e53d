"""Virtual facets as a figure: every polygon is there in its colour, and all that is written is true."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections import Counter
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from displays_help import boxes, overlaps, texts
from matplotlib.colors import to_hex, to_rgb
from solids import bent_stone
from thorough import chosen

from gemrender import cli
from gemrender.beam import FacetStatus, trace_facets
from gemrender.cuts import load_stone
from gemrender.cuts.files import save_vertices
from gemrender.cuts.round_brilliant.topology import FACET_KINDS
from gemrender.errors import InputError
from gemrender.observation import Model, View
from gemrender.report import displays
from gemrender.report.displays import FORMATS, draw, write_display
from gemrender.report.facets import (
    COLOURS,
    GIRDLE_COLOUR,
    REFLECTION_COLOURS,
    check_colour,
    facets_figure,
)
from gemrender.report.figures import BAND_COLOURS, REAR_COLOUR, UNSOLVED_COLOUR
from gemrender.report.palettes import EXIT_COLOURS, TIER_COLOURS
from gemrender.scoring import BAND_EDGES, score
from gemrender.stone import Stone

#: Shares are written with one decimal, or more.
WRITTEN = 0.05
#: The outline is drawn with straight pieces, the girdle's area is that of arcs: (pi / 256)^2 / 6 of it.
OUTLINE_AREA = 1e-4
#: Corners on the outline that the tracer and the mesh compute differently [girdle radius].
ROUNDING = 1e-9
#: Least difference of colours that people tell apart beside each other (CIEDE2000): 2.3 are just noticed.
TOLD_APART = 10.0
#: The same of ten tiers, which are more than can be ten apart for every eye.
TIERS_APART = 7.5
#: Least difference in lightness (CIE L*) of light and rear light through one tier: plainly seen.
DARKER = 10.0

#: Bundled stones from above, light near the girdle, a tilted eye, tilted facets and an oval girdle.
VIEWS = {
    "inoue-2": ("inoue-2", 0.0),
    "inoue-3": ("inoue-3", 0.0),
    "tilted eye": ("fish-eye", 20.0),
    "tilted facets": ("tilted facets", 0.0),
    "oval": ("oval", 10.0),
}


@cache
def stone_named(name):
    if name == "oval":
        return bent_stone(-0.004, name="oval", stretched=1.05)
    if name == "tilted facets":
        return load_stone("inoue-1").tilted(0.5, np.random.default_rng(1))
    return load_stone(name)


def view_of(key):
    name, tilt = VIEWS[key]
    return View.of(stone_named(name), 1, tilt_deg=tilt, tilt_azimuth_deg=25.0)


@cache
def drawn(key, colour="intensity"):
    return facets_figure(stone_named(VIEWS[key][0]), colour=colour, view=view_of(key))


@cache
def scored(key):
    name, tilt = VIEWS[key]
    return score(stone_named(name), engine="exact", tilt=tilt, tilt_azimuth=25.0)


@cache
def traced(key):
    return trace_facets(stone_named(VIEWS[key][0]), view=view_of(key))


def polygons(figure):
    """Return the collection of virtual facets."""
    [found] = [c for c in figure.axes[0].collections if c.get_gid() == "virtual-facets"]
    return found


def outline(figure):
    """Return the corners of what is hatched beneath them."""
    [found] = [p for p in figure.axes[0].patches if p.get_gid() == "near-the-girdle"]
    assert to_hex(found.get_facecolor()) == GIRDLE_COLOUR
    return found.get_xy()[:-1]


def legend(figure):
    """Return the rows of the legend: what is written, and its share [%]."""
    said = [text.get_text() for text in figure.axes[1].texts]
    start = next(i for i, text in enumerate(said) if text.startswith("Share of the view by "))
    end = next(i for i, text in enumerate(said) if text.endswith(" virtual facets"))
    rows = said[start + 1 : end]
    return {name: float(share.removesuffix(" %")) for name, share in zip(rows[::2], rows[1::2], strict=True)}


def area(corners):
    x, y = corners.T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


@pytest.fixture(params=VIEWS)
def key(request):
    return request.param


#: Every view by intensity, and every colour of one; all of all are slow.
COLOURED = [(key, colour) for key in VIEWS for colour in COLOURS]
DRAWN = chosen(
    COLOURED, [case for case in COLOURED if case[1] == "intensity" or case[0] in ("inoue-2", "tilted eye")]
)


# ---- The polygons --------------------------------------------------------------------------------------


def colour_of(facets, i, colour):
    """Tell the colour of a virtual facet, as the legend has it."""
    intensity, reflections, rear = facets.primary_intensity[i], facets.reflections[i], facets.rear_mask[i]
    if facets.status[i] == FacetStatus.TRAPPED:
        return UNSOLVED_COLOUR
    if colour == "facet":
        return EXIT_COLOURS[FACET_KINDS[facets.path(i)[-1]]][int(rear)]
    if colour == "reflections":
        group = min(reflections, 5) + (reflections > 5) + (reflections > 10) + (reflections > 20)
        return REFLECTION_COLOURS[group]
    band = next(k for k, edge in enumerate(BAND_EDGES) if intensity >= edge)
    return REAR_COLOUR if rear else BAND_COLOURS[band]


@pytest.mark.parametrize(("key", "colour"), DRAWN)
def test_every_virtual_facet_is_drawn_in_its_colour(key, colour):
    facets, shown = traced(key), polygons(drawn(key, colour))
    expected = Counter(
        (facets.polygon(i).tobytes(), colour_of(facets, i, colour))
        for i in range(len(facets))
        if facets.status[i] != FacetStatus.GIRDLE and facets.area[i] > 1e-12
    )
    found = Counter(
        (path.vertices[:-1].tobytes(), to_hex(face))
        for path, face in zip(shown.get_paths(), shown.get_facecolors(), strict=True)
    )
    assert found == expected


def test_the_number_that_is_written_is_that_of_the_polygons_and_of_the_score(key):
    number = len(polygons(drawn(key)).get_paths())
    assert f"{number} virtual facets" in texts(drawn(key))
    assert scored(key).facets.number == number


def test_polygons_lie_within_the_outline(key):
    corners = outline(drawn(key))
    across = np.roll(corners, -1, axis=0) - corners
    assert np.hypot(*across.T).min() > ROUNDING
    inward = np.column_stack([-across[:, 1], across[:, 0]]) / np.linalg.norm(across, axis=1, keepdims=True)
    points = np.concatenate([path.vertices[:-1] for path in polygons(drawn(key)).get_paths()])
    depth = points @ inward.T - np.einsum("ij,ij->i", corners, inward)
    assert depth.min() > -ROUNDING


def test_the_outline_is_the_girdle():
    assert np.hypot(*outline(drawn("inoue-3")).T) == pytest.approx(1.0)


def test_hatching_is_what_no_polygon_tells(key):
    """Area of the outline less that of the polygons."""
    left = area(outline(drawn(key))) - sum(
        area(path.vertices[:-1]) for path in polygons(drawn(key)).get_paths()
    )
    told = legend(drawn(key)).get("Near the girdle", 0.0)
    assert 100 * left / area(outline(drawn(key))) == pytest.approx(told, abs=WRITTEN + 100 * OUTLINE_AREA)


def test_edges_are_opaque_and_narrower_than_their_facets(key):
    figure = drawn(key)
    shown = polygons(figure)
    assert (shown.get_edgecolors()[:, 3] == 1).all(), "no ground shines through between two facets"
    scale = 72 * 6.4 / (2 * view_of(key).half_width)  # points a girdle radius
    for path, width in zip(shown.get_paths(), shown.get_linewidths(), strict=True):
        corners = path.vertices[:-1]
        around = np.hypot(*(np.roll(corners, -1, axis=0) - corners).T).sum()
        assert width <= scale * area(corners) / around


# ---- The panel -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("key", "colour"), DRAWN)
def test_shares_make_a_hundred(key, colour):
    shares = legend(drawn(key, colour))
    assert sum(shares.values()) == pytest.approx(100.0, abs=WRITTEN * len(shares))


def test_shares_are_those_of_the_score_where_hardly_any_light_comes_near_the_girdle():
    result = scored("inoue-3")
    assert result.facets.near_girdle < WRITTEN
    *bands, rear, _ = legend(drawn("inoue-3")).values()
    assert bands == pytest.approx([band.share for band in result.bands], abs=2 * WRITTEN)
    assert rear == pytest.approx(result.rear, abs=2 * WRITTEN)


def test_scores_are_written_with_their_bound(key):
    result = scored(key)
    said = [text.get_text() for text in drawn(key).axes[1].texts]
    for heading, value in (("Average", result.average), ("Rear", result.rear)):
        written, bound = said[said.index(heading) + 1 :][:2]
        assert re.fullmatch(r"\d+\.\d{2,4} %", written)
        assert float(written[:-2]) == pytest.approx(value, abs=0.01)
        bound = bound.removeprefix("± ").removesuffix(" %")
        assert result.bound <= float(bound) <= max(1.1 * result.bound, 1e-4)  # two digits, rounded up
        (caption,) = (text for text in said if "every figure within" in text)
        assert f"every figure within ±{bound}" in caption.splitlines()[-1 - ("single rays" in caption)]


def test_the_table_counts_every_virtual_facet(key):
    said = [text.get_text() for text in drawn(key).axes[1].texts]
    rows = said[said.index("Share") + 1 :][:15]
    assert rows[::3] == ["≥ 1", "0.1 – 1", "0.01 – 0.1", "0.001 – 0.01", "< 0.001"]
    assert sum(int(number) for number in rows[1::3]) == len(polygons(drawn(key)).get_paths())


def test_the_model_asked_for_is_traced_and_told():
    stone = load_stone("inoue-1")
    model = Model(index=1.77, fresnel="exact", rear="direction", intensity="radiance")
    said = "\n".join(texts(facets_figure(stone, model=model))).replace("\u00a0", " ").replace("\n", " ")
    assert "radiance, Fresnel's equations (index 1.77), rear light by direction" in said
    assert "Share of the view by radiance" in said
    tilted = "\n".join(texts(drawn("tilted eye")))
    assert "eye tilted by 20° towards azimuth 25°" in tilted


@pytest.mark.parametrize("key", chosen(VIEWS, ["inoue-2", "tilted eye"]))
def test_labels_do_not_overlap_and_stay_on_the_page(key):
    assert_legible(drawn(key, "reflections"))


def test_a_long_legend_and_a_long_name_fit():
    stone = load_stone("fish-eye")
    named = Stone.from_proportions(stone.proportions, name="$\\frac{ <b>& " + 12 * "a long name ")
    view = View.of(stone, 1, tilt_deg=30, tilt_azimuth_deg=11)
    figure = facets_figure(named, colour="facet", view=view, model=Model.of(named, rear="direction"))
    assert len(legend(figure)) >= 12
    assert_legible(figure)


def assert_legible(figure):
    assert overlaps(figure) == []
    width, height = figure.bbox.size
    for text, (left, bottom, right, top) in boxes(figure):
        assert 0 <= left <= right <= width, text
        assert 0 <= bottom <= top <= height, text


# ---- The colours ---------------------------------------------------------------------------------------


def lab(colours, kind):
    """Return colours in CIE Lab as eyes see them that lack a kind of cone."""
    import colour

    linear = colour.cctf_decoding(np.array([to_rgb(c) for c in colours]), function="sRGB")
    if kind:
        linear = np.clip(linear @ colour.matrix_cvd_Machado2009(kind, 1.0).T, 0, 1)
    return colour.XYZ_to_Lab(colour.sRGB_to_XYZ(colour.cctf_encoding(linear, function="sRGB")))


@pytest.mark.filterwarnings("ignore:.*Machado:Warning")  # tritanopia is approximate
@pytest.mark.parametrize("kind", [None, "Protanomaly", "Deuteranomaly", "Tritanomaly"])
def test_kinds_of_facets_are_told_apart(kind):
    import colour

    colours = [*(c for pair in EXIT_COLOURS.values() for c in pair), GIRDLE_COLOUR, UNSOLVED_COLOUR]
    a, b = np.array(list(combinations(lab(colours, kind), 2))).transpose(1, 0, 2)
    assert colour.delta_E(a, b, method="CIE 2000").min() > TOLD_APART


@pytest.mark.filterwarnings("ignore:.*Machado:Warning")
@pytest.mark.parametrize("kind", [None, "Protanomaly", "Deuteranomaly", "Tritanomaly"])
def test_tiers_are_told_apart(kind):
    """Their colours for light that is no rear light; legends name the tiers as well."""
    import colour

    colours = [*(light for light, _ in TIER_COLOURS), GIRDLE_COLOUR, UNSOLVED_COLOUR]
    a, b = np.array(list(combinations(lab(colours, kind), 2))).transpose(1, 0, 2)
    assert colour.delta_E(a, b, method="CIE 2000").min() > TIERS_APART
    lightness = lab([c for pair in TIER_COLOURS for c in pair], kind)[:, 0]
    assert (lightness[::2] - lightness[1::2]).min() > DARKER


@pytest.mark.parametrize("kind", [None, "Protanomaly", "Deuteranomaly"])
def test_more_reflections_are_darker(kind):
    lightness = lab(REFLECTION_COLOURS, kind)[:, 0]
    assert np.diff(lightness).max() < -5


# ---- Files ---------------------------------------------------------------------------------------------


def test_the_command_writes_the_same_facets_into_the_same_files(show, tmp_path):
    status, err = show("inoue-3", "--what", "facets", "--colour", "facet", "--format", "all", "-o", "shown")
    files = [f"shown/inoue-3-facets.{ending}" for ending in FORMATS]
    assert (status, err.split("\n")[:-1]) == (0, [f"written: {name}" for name in files])
    one = [tmp_path / name for name in files]
    other = write_display(load_stone("inoue-3"), "facets", tmp_path, "b", formats=FORMATS, colour="facet")
    assert [path.name for path in other] == ["b-facets.png", "b-facets.svg", "b-facets.pdf"]
    for a, b in zip(one, other, strict=True):
        content = a.read_bytes()
        assert content == b.read_bytes()
        assert len(content) > 10_000
        assert b"Date" not in content, "nor tomorrow"
        assert a.suffix == ".pdf" or b"Inoue sample 3: facets" in content


def test_the_drawing_has_a_path_for_every_virtual_facet(tmp_path):
    [path] = write_display(load_stone("inoue-2"), "facets", tmp_path, "s", formats=("svg",))
    root = ElementTree.parse(path).getroot()
    [group] = [g for g in root.iter("{http://www.w3.org/2000/svg}g") if g.get("id") == "virtual-facets"]
    facets = traced("inoue-2")
    assert (
        len(list(group.iter("{http://www.w3.org/2000/svg}path")))
        == (facets.status != FacetStatus.GIRDLE).sum()
    )
    assert not list(root.iter("{http://www.w3.org/2000/svg}image")), "polygons, not pixels"


def test_a_document_has_its_fonts(tmp_path):
    """As TrueType, which journals ask for; letters that no font has are no error."""
    named = Stone.from_proportions(load_stone("inoue-3").proportions, name="井上 \U0001f48e $\\frac{")
    [path] = write_display(named, "facets", tmp_path, "s", formats=("pdf",))
    content = path.read_bytes()
    assert content.startswith(b"%PDF")
    assert b"/FontFile2" in content
    assert b"/Subtype /Type3" not in content


# ---- Bad input, and the command line -------------------------------------------------------------------


def test_unknown_colours_are_refused_before_any_work():
    said = r"^colour = 'red': must be one of intensity, reflections, facet$"
    with pytest.raises(InputError, match=said):
        check_colour("red")
    with pytest.raises(InputError, match=said):
        draw(bent_stone(0.003), "facets", colour="red")


def test_a_hollow_stone_is_refused():
    with pytest.raises(InputError, match="bent: is not convex"):
        draw(bent_stone(0.003), "facets")


@pytest.fixture
def show(capsys, monkeypatch, tmp_path):
    """Run the command in a folder with a hollow stone, hollow.csv; returns exit status and stderr."""
    monkeypatch.chdir(tmp_path)
    save_vertices(bent_stone(0.003), "hollow.csv")

    def run(*arguments):
        with pytest.raises(SystemExit) as caught:
            cli.main(["show", *arguments])
        return caught.value.code, capsys.readouterr().err

    return run


@pytest.fixture
def asked(monkeypatch):
    """Return the displays that are asked for, without drawing them."""
    asked = []
    monkeypatch.setattr(
        displays, "write_display", lambda _, what, __, stem, **___: asked.append((stem, what)) or []
    )
    return asked


def test_unknown_colours_are_one_line_of_the_command(show, asked):
    status, err = show("inoue-3", "--what", "facets", "--colour", "red")
    assert status == 2
    assert err == "gemrender: --colour = 'red': must be one of intensity, reflections, facet\n"
    assert not asked


def test_virtual_facets_of_a_hollow_stone_are_an_error_before_anything_is_drawn(show, asked):
    status, err = show("inoue-3", "hollow.csv", "--what", "outline", "--what", "facets")
    assert status == 2
    assert err.startswith("gemrender: hollow.csv: is not convex")
    assert err.count("\n") == 1
    assert not asked


@pytest.mark.parametrize("what", [[], ["--what", "all"]])
def test_of_a_hollow_stone_all_is_all_the_rest(show, asked, what):
    status, err = show("inoue-3", "hollow.csv", *what, "--engine", "reference")
    assert status == 0
    assert err.startswith("virtual facets left out: hollow.csv: is not convex")
    assert err.count("\n") == 1
    everything = [("inoue-3", what) for what in displays.DISPLAYS]
    rest = [("hollow", what) for what in displays.DISPLAYS if what != "facets"]
    assert asked == everything + rest

"""What notebooks ask of the Python face: stones by name, real signatures, results that show themselves."""

from __future__ import annotations

import base64
import inspect
import io
import re
from dataclasses import replace
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot
from observations import ROOT
from PIL import Image

import gemrender
from gemrender.cuts import as_stone
from gemrender.render.from_python import FilmOptions
from gemrender.report.figures import BAND_COLOURS, REAR_COLOUR
from gemrender.report.notebook import drawings
from gemrender.signatures import parameter_texts, types_of
from gemrender.sweep.cliffs import find_cliffs

STONE = gemrender.load_stone("inoue-3")
FUNCTIONS = {
    name: value
    for name in gemrender.__all__
    if callable(value := getattr(gemrender, name)) and not isinstance(value, type)
} | {"find_cliffs": find_cliffs}

# ---- Stones by name ------------------------------------------------------------------------------------

#: Calls of all public functions that take a stone, as cheap as they come; each returns what can be compared.
CALLS = {
    "score": lambda stone: gemrender.score(stone).average,
    "observe": lambda stone: gemrender.observe(stone, resolution=8).primary_intensity.tobytes(),
    "trace_paths": lambda stone: len(gemrender.trace_paths(stone)),
    "trace_facets": lambda stone: len(gemrender.trace_facets(stone)),
    "measure_maps": lambda stone: gemrender.measure_maps(stone, measures="iso", resolution=8).values,
    "sensitivity": lambda stone: gemrender.sensitivity(stone, bound=1.0).derivatives,
    "score_stereo": lambda stone: gemrender.score_stereo(stone, bound=0.5).disagreement,
    "study_tilt": lambda stone: gemrender.study_tilt(stone, to_deg=1, processes=1).values("inoue", "average")[
        0
    ],
    "study_symmetry": lambda stone: gemrender.study_symmetry(stone, draws=1, processes=1).average,
    "study_tolerance": lambda stone: gemrender.study_tolerance(stone, draws=1, processes=1).drawn.tobytes(),
    "vary": lambda stone: [each.name for each in gemrender.vary(stone, ["table=55"])],
    "View": lambda stone: gemrender.View.of(stone, 8),
    "Model": lambda stone: gemrender.Model.of(stone),
    "Rounding": lambda stone: gemrender.Rounding.of(stone),
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_a_name_is_as_good_as_the_stone(call):
    assert call("inoue-3") == call(STONE)


def test_a_path_is_as_good_as_the_stone(tmp_path):
    path = tmp_path / "stone.asc"
    gemrender.save_stone("inoue-3", path)
    assert gemrender.score(path).average == gemrender.score(gemrender.load_stone(path)).average


@pytest.mark.parametrize("function", [gemrender.score, gemrender.trace_facets, gemrender.study_tilt])
@pytest.mark.parametrize("stone", [3.0, None, ["inoue-3"]], ids=str)
def test_what_is_no_stone_is_refused(function, stone):
    with pytest.raises(gemrender.InputError, match=r"^stone = .*: must be a stone, a name or a file"):
        function(stone)


def test_a_stone_stays_itself():
    assert as_stone(STONE) is STONE


# ---- Real signatures -----------------------------------------------------------------------------------


@pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)
def test_parameters_have_names_types_and_words(function):
    parameters = inspect.signature(function).parameters.values()
    assert [each.name for each in parameters if each.kind in (each.VAR_KEYWORD, each.VAR_POSITIONAL)] == []
    assert [each.name for each in parameters if each.annotation is each.empty] == []
    told = parameter_texts(function.__doc__) if parameters else {}
    assert [each.name for each in parameters if each.name not in told] == []


def test_the_options_of_a_film_are_those_of_a_picture():
    picture = inspect.signature(gemrender.render).parameters
    film = types_of(FilmOptions)
    assert picture.keys() - film.keys() == {"stone", "setup", "bins", "range", "on_pass", "progress"}
    assert {name: picture[name].annotation for name in film} == film


def test_what_the_help_says_of_defaults_holds():
    """The short forms' own are those of `Model.of`; a view and a model of them are the same."""
    short = inspect.signature(gemrender.observe).parameters
    of_model = inspect.signature(gemrender.Model.of).parameters
    assert {name: each.default for name, each in of_model.items() if name != "stone"} == {
        name: short[name].default for name in of_model if name != "stone"
    }


def test_options_are_told_once_and_alike():
    told = [
        parameter_texts(function.__doc__).get("tilt") for function in (gemrender.score, gemrender.observe)
    ]
    assert told[0] == told[1] is not None
    assert "[deg]" in told[0]


def test_every_parameter_stands_in_its_function_s_help():
    for name in gemrender.__all__:
        function = getattr(gemrender, name)
        if not inspect.isfunction(function):
            continue
        texts = parameter_texts(function.__doc__)
        for each in inspect.signature(function).parameters.values():
            assert each.kind is not each.VAR_KEYWORD, name
            assert each.name != "options", name
            assert each.name in texts, (name, each.name)


def test_studies_take_the_options_of_a_score():
    found = gemrender.study_tolerance(STONE, draws=1, processes=1, tilt=5.0, bound=0.5, measures="iso")
    once = gemrender.score(STONE, tilt=5.0, bound=0.5, measures="iso", resolution=256)
    assert found.stated[0] == pytest.approx(once.measures[0].values["value"], rel=ROUNDING)
    with pytest.raises(TypeError, match="unknown option 'resolutoin'"):
        gemrender.study_tilt(STONE, to_deg=1, processes=1, resolutoin=10)


# ---- What notebooks show -------------------------------------------------------------------------------

#: Double precision, of a stone that is turned and one that is looked at from the side.
ROUNDING = 1e-9
#: A name that would do harm, were it taken for HTML.
NASTY = replace(STONE, name="<script>alert('x')</script> & \"a\"")
#: Corners of drawings are rounded to a thousandth of the unit: areas of facets are off by their outline's
#: length times half of that, shares of the whole view by less than this [%].
DRAWN = 0.05


@pytest.fixture(scope="module")
def results():
    """A result of each kind, of a stone with a name that would do harm."""
    return {
        "Stone": NASTY,
        "Score": gemrender.score(NASTY, measures="iso,facets", tilt=5),
        "Paths": gemrender.trace_paths(NASTY),
        "VirtualFacets": gemrender.trace_facets(NASTY),
        "MeasureMaps": gemrender.measure_maps(NASTY, measures="iso,aset", resolution=16),
        "Observation": gemrender.observe(NASTY, resolution=16),
        "StereoScore": gemrender.score_stereo(NASTY, bound=0.5),
        "Sensitivity": gemrender.sensitivity(NASTY, bound=1.0),
        "TiltStudy": gemrender.study_tilt(NASTY, to_deg=1, processes=1),
        "SymmetryStudy": gemrender.study_symmetry(NASTY, draws=1, processes=1),
        "ToleranceStudy": gemrender.study_tolerance(NASTY, draws=2, processes=1),
        "Improvement": gemrender.improve(
            NASTY, "inoue", ["table=53.9:54.1"], rounds=1, answers=1, threads=1, details=False
        ),
    }


@pytest.fixture(scope="module")
def pages(results):
    """What a notebook shows of each, read as XML: well-formed, or it raises."""
    return {kind: ElementTree.fromstring(result._repr_html_()) for kind, result in results.items()}


KINDS = ("Stone", "Score", "Paths", "VirtualFacets", "MeasureMaps", "Observation")
STUDIES = ("StereoScore", "Sensitivity", "TiltStudy", "SymmetryStudy", "ToleranceStudy", "Improvement")


@pytest.mark.parametrize("kind", KINDS + STUDIES)
def test_names_from_files_are_text(pages, kind):
    root = pages[kind]
    assert NASTY.name in "".join(root.itertext())
    assert not {"script", "link", "iframe"} & {element.tag.split("}")[-1] for element in root.iter()}


@pytest.mark.parametrize("kind", KINDS + STUDIES)
def test_a_page_brings_all_it_needs(pages, kind):
    for element in pages[kind].iter():
        for name in ("src", "href", "onload", "onclick"):
            assert element.get(name, "data:").startswith("data:image/png") or name not in element.attrib
        assert "url(" not in element.get("style", "")


@pytest.mark.parametrize("kind", KINDS + STUDIES)
def test_text_has_the_colour_of_the_notebook(pages, kind):
    for element in pages[kind].iter():
        assert not re.search(r"(?<!-)color:(?!inherit)", element.get("style", ""))


@pytest.mark.parametrize("kind", KINDS + STUDIES)
def test_the_plain_text_is_short(results, kind):
    assert len(repr(results[kind])) < 3000
    assert "\n" not in repr(results[kind])


def test_a_score_is_told_with_its_bound(results, pages):
    rows = [["".join(cell.itertext()) for cell in row] for row in pages["Score"].iter("tr")]
    score = results["Score"]
    told = {row[0]: row[1:] for row in rows}
    assert float(told["Average intensity"][0]) == pytest.approx(score.average, abs=0.005)
    assert float(told["Average intensity"][1].strip("± ")) >= score.bound
    assert told["iso"][1] == f"{score.measures[0].values['value']:.2f}"


def areas_by_colour(root):
    """Return the areas of all polygons of a drawing by their colour [unit of the drawing^2]."""
    areas = {}
    for path in root.iter("{http://www.w3.org/2000/svg}path"):
        for polygon in path.get("d").split("z")[:-1]:
            x, y, *steps = (float(number) for number in re.findall(r"-?\d+", polygon))
            corners = np.cumsum([[x, y], *np.reshape(steps, (-1, 2))], axis=0)
            ahead = np.roll(corners, -1, axis=0)
            area = 0.5 * abs(np.sum(corners[:, 0] * ahead[:, 1] - corners[:, 1] * ahead[:, 0]))
            areas[path.get("fill")] = areas.get(path.get("fill"), 0.0) + area
    return areas


def test_the_drawn_facets_have_the_areas_of_the_score(pages):
    areas = areas_by_colour(pages["VirtualFacets"])
    score = gemrender.score(STONE)
    whole = np.pi * 1000.0**2
    for colour, share in zip(BAND_COLOURS, (band.share for band in score.bands), strict=True):
        assert 100.0 * areas.get(colour, 0.0) / whole == pytest.approx(share, abs=DRAWN)
    assert 100.0 * areas[REAR_COLOUR] / whole == pytest.approx(score.rear, abs=DRAWN)


def test_a_drawing_has_the_largest_facets_where_there_are_many(results, monkeypatch):
    facets = results["VirtualFacets"]
    monkeypatch.setattr(drawings, "MOST_POLYGONS", 100)
    shown = facets._repr_html_()
    assert f"drawn are the 100 largest; {facets.is_counted.sum() - 100} smaller ones" in shown
    assert shown.count("z") < 400


def test_a_map_is_transparent_beside_the_stone(results, pages):
    [shown, *_] = pages["Observation"].iter("img")
    data = base64.b64decode(shown.get("src").partition(",")[2])
    alpha = np.asarray(Image.open(io.BytesIO(data)))[..., 3]
    seen = results["Observation"].coverage
    assert alpha[0, 0] == 0
    assert alpha.mean() / 255.0 == pytest.approx(seen.mean(), abs=0.005)


def test_a_stone_of_no_known_material_is_shown_all_the_same():
    assert "unobtainium" in replace(STONE, material="unobtainium")._repr_html_()


# ---- Plots and tables ----------------------------------------------------------------------------------


@pytest.fixture
def axes():
    mpl.use("agg")
    figure, axes = pyplot.subplots()
    yield axes
    pyplot.close(figure)


def test_results_are_drawn_onto_the_axes_that_are_given(results, axes):
    for kind in (*KINDS, "TiltStudy"):
        if kind != "Paths":
            axes.clear()
            assert results[kind].plot(ax=axes) is axes
            assert axes.has_data()


def test_without_axes_there_are_new_ones():
    mpl.use("agg")
    axes = STONE.plot(view="side")
    pyplot.close(axes.figure)
    assert axes.dataLim.width == pytest.approx(2.0, abs=1e-3)  # a girdle radius is 1


def test_what_cannot_be_plotted_is_refused(results, axes):
    for call, said in (
        (lambda: STONE.plot(axes, view="below"), "must be one of crown, pavilion, side, oblique"),
        (lambda: results["VirtualFacets"].plot(axes, colour="blue"), "must be one of intensity"),
        (lambda: results["MeasureMaps"].plot(axes, measure="gemray"), "must be one of iso, aset"),
    ):
        with pytest.raises(gemrender.InputError, match=said):
            call()


def test_a_score_is_one_row_with_the_columns_of_the_csv(results):
    from gemrender.report.tables import score_record

    frame = results["Score"].to_pandas()
    assert len(frame) == 1
    assert list(frame.columns) == list(score_record(results["Score"]))
    assert frame.average[0] == results["Score"].average


@pytest.mark.parametrize("kind", STUDIES)
def test_studies_are_tables(results, kind):
    assert len(results[kind].to_pandas()) >= 1


def test_a_study_of_tilts_has_a_row_a_pose(results):
    study = results["TiltStudy"]
    frame = study.to_pandas()
    assert list(frame.turn_deg) == [found.pose.turn_deg for found in study.found]
    assert list(frame.inoue_average) == list(study.values("inoue", "average"))


def test_facets_are_rows(results):
    facets = results["VirtualFacets"]
    frame = facets.to_pandas()
    assert len(frame) == len(facets)
    of = frame[frame.counted]
    score = gemrender.score(STONE)
    mean = (of.area * of.primary_intensity).sum() / frame.area.sum()
    assert mean == pytest.approx(score.average, abs=0.01)  # the rest is light near the girdle


def test_maps_are_datasets(results):
    seen = results["Observation"].to_xarray()
    assert seen.primary_intensity.dims == ("y", "x")
    assert seen.exit_point.dims == ("y", "x", "axis")
    assert float(seen.y[0]) == -float(seen.y[-1]) == pytest.approx(1.0 - 1.0 / 16)
    maps = results["MeasureMaps"].to_xarray()
    covered = maps.where(maps.coverage > 0)
    assert float(covered["iso.value"].mean()) == pytest.approx(maps.attrs["iso.value"], rel=1e-5)


# ---- The page ------------------------------------------------------------------------------------------


def test_the_page_runs():
    blocks = re.findall(
        r"```python\n(.*?)```", (ROOT / "docs" / "notebooks.md").read_text("utf-8"), re.DOTALL
    )
    assert len(blocks) >= 4
    mpl.use("agg")
    names = {}
    for block in blocks:
        exec(compile(block, "notebooks.md", "exec"), names)
    pyplot.close("all")

"""What notebooks ask of the Python face: stones by name, real signatures, results that show themselves."""

from __future__ import annotations

import inspect

import pytest

import gemrender
from gemrender.cuts import as_stone
from gemrender.render.from_python import FilmOptions
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

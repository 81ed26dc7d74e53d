"""What a Python user sees: names, what an import costs, and that the design's example runs."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from types import ModuleType

import pytest
from observations import run_python
from thorough import chosen

import gemrender

#: Everything but the plugins, which take their classes from a variant, and the module that is a program.
MODULES = [
    name
    for _, name, _ in pkgutil.walk_packages(gemrender.__path__, "gemrender.")
    if not name.startswith(("gemrender.plugins", "gemrender.__main__"))
]

#: The design's example, as printed there.
EXAMPLE = """
import gemrender
stone = gemrender.load_stone("inoue-3")        # a bundled name, a file, or built from RoundBrilliant(...)
result = gemrender.score(stone, engine="mitsuba", resolution=1024)
result.average, result.rear, result.bands
observation = gemrender.observe(stone)         # the maps behind the score
"""


def test_all_is_what_is_exported():
    exported = {
        name
        for name in dir(gemrender)
        if not name.startswith("_")
        and (not isinstance(value := getattr(gemrender, name), ModuleType) or callable(value))
        and getattr(value, "__module__", "").startswith("gemrender")
    }
    assert exported == set(gemrender.__all__)


def test_all_is_sorted_and_without_repetition():
    assert gemrender.__all__ == sorted(set(gemrender.__all__))


def test_every_module_has_what_its_all_names():
    modules = [importlib.import_module(name) for name in MODULES]
    named = [(module, name) for module in modules for name in getattr(module, "__all__", [])]
    assert len(named) > len(MODULES)
    lacking = [(module, name) for module, name in named if not hasattr(module, name)]
    assert [of for of in lacking if isinstance(of[0], ModuleType)] == []


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'gemrender' has no attribute 'polish'"):
        gemrender.polish  # noqa: B018


HEAVY = "{'numpy', 'mitsuba', 'drjit', 'matplotlib', 'OpenEXR', 'rich', 'typer', 'colour'}"


def test_the_import_is_light():
    done = run_python("-c", f"import sys, gemrender; print(sorted({HEAVY} & set(sys.modules)))")
    assert done.stdout == "[]\n", done.stderr


def test_help_needs_no_numbers():
    heavy = "{'numpy', 'mitsuba', 'drjit', 'matplotlib', 'OpenEXR', 'colour'}"
    done = run_python(
        "-c",
        "import sys, gemrender.cli.program as c\n"
        "status = [c.run(line.split()) for line in ('--help', 'score --help', '--version')]\n"
        f"print(status, {heavy} & set(sys.modules))",
    )
    assert done.stdout.endswith("\n[0, 0, 0] set()\n"), done.stdout + done.stderr


def test_the_import_of_both_sets_no_variant():
    code = "import gemrender, mitsuba; gemrender.load_stone('inoue-3'); print(mitsuba.variant())"
    assert run_python("-c", code).stdout == "None\n"


#: The first ones name a module that is called as a function is, the others import one on their way.
STATEMENTS = [
    "import gemrender.scoring",
    "import gemrender.render",
    "from gemrender.scoring import Score",
    "import gemrender.crosscheck",
    "import gemrender.cli",
    "import gemrender.engines; gemrender.load_stone('inoue-1')",
    "import gemrender.render.picture_files",
]


@pytest.mark.parametrize("statement", chosen(STATEMENTS, [*STATEMENTS[:2], STATEMENTS[-1]]))
def test_score_stays_the_function(statement):
    called = "[callable(each) for each in (gemrender.score, gemrender.observe, gemrender.render)]"
    assert run_python("-c", f"import gemrender; {statement}; print({called})").stdout == f"{[True] * 3}\n"


def test_what_renders_pictures_is_a_package_too():
    from gemrender.render import backend, from_python

    assert gemrender.render.backend is backend
    assert inspect.signature(gemrender.render) == inspect.signature(from_python.render)
    assert gemrender.render.__doc__ == from_python.render.__doc__


def test_the_example_of_the_design_runs(variant_llvm_ad_rgb):
    names: dict = {}
    exec(EXAMPLE, names)
    assert round(names["result"].average, 1) == 60.4
    assert names["observation"].primary_intensity.shape == (1024, 1024)


def test_short_forms_mean_the_same_in_every_function():
    stone = gemrender.load_stone("inoue-3")
    view = gemrender.View.of(stone, 16, tilt_deg=5.0)
    facets = gemrender.trace_facets(stone, tilt=5.0, fresnel="exact")
    assert (facets.view.tilt_deg, facets.model.fresnel) == (5.0, "exact")
    score = gemrender.score(stone, tilt=5.0, fresnel="exact")
    model = gemrender.Model.of(stone, fresnel="exact")
    assert score.average == gemrender.score(stone, view=view, model=model).average
    with pytest.raises(TypeError, match="unknown option 'tilt_deg'"):
        gemrender.score(stone, tilt_deg=5.0)
    with pytest.raises(gemrender.InputError, match="tilt: is given twice, by view and by itself"):
        gemrender.trace_facets(stone, view=view, tilt=5.0)

"""Who may import whom (`design.md`), and what tests may know: read from the source, functions included."""

from __future__ import annotations

import ast
import contextlib
import gc
import re
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path

import pytest

import gemrender

PACKAGE = Path(gemrender.__file__).parent

#: What atlases are stored by, and measured on clusters by.
_ATLASES = ("xarray", "zarr", "fsspec", "h5netcdf", "h5py", "dask", "distributed")

#: The parts, lowest first, and the libraries that each may use. A part imports only from parts above its
#: own line; those on one line do not know each other.
LAYERS: list[dict[str, set[str]]] = [
    {"errors": set(), "signatures": set()},
    {"shown": set()},
    {"mistakes": set()},
    {"writing": set(), "reading": set(), "progress": set(), "interruption": set(), "processors": set()},
    {"journal": set()},
    {"stone": {"numpy", "scipy"}, "optics": {"numpy"}},
    {"cuts": {"numpy", "scipy", "defusedxml", "trimesh", "srn_parser"}},
    {"templates": set()},
    {"colorimetry": {"numpy", "colour"}},
    {"measurement": {"numpy"}},
    {"observation": {"numpy"}},
    {"paths": {"numpy"}},
    {"measures": {"numpy"}},
    {"request": set()},
    {"reference": {"numpy"}},
    {"beam": {"numpy", "numba"}},
    {"scene": {"numpy", "scipy", "mitsuba", "drjit"}},
    {"plugins": {"numpy", "mitsuba", "drjit"}},
    {"render": {"numpy", "numba", "mitsuba", "drjit", "OpenEXR", "PIL", "av", "mitsuba_oidn"}},
    {"engines": {"numpy"}},
    {"scoring": {"numpy"}},
    {"mapping": {"numpy"}},
    {"crosscheck": {"numpy"}, "stereo": {"numpy"}},
    {"sweep": {"numpy", "scipy", "drjit", "pymoo", *_ATLASES}},
    {"report": {"numpy", "matplotlib", "mpl_toolkits", "rich", "OpenEXR", "colour"}},
    {"studio": {"numpy", "starlette", "uvicorn", "websockets", "anywidget", "traitlets"}},
    {"cli": {"numpy", "typer", "rich"}},
    {"__main__": set()},
]
#: The one way back: results show themselves, and look up what draws them when they are shown.
WAYS_BACK = {("shown", f"gemrender.report.{name}") for name in ("notebook", "plots", "records")}
RANK = {part: rank for rank, layer in enumerate(LAYERS) for part in layer}
LIBRARIES = {part: libraries for layer in LAYERS for part, libraries in layer.items()}

MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")
TESTS = Path(__file__).parents[1]

#: Members that begin with an underscore and are no secrets of ours, and by whose documents.
OTHERS_MEMBERS = {
    "_exit": "Python's os",
    "_repr_html_": "IPython's display protocol",
    "_repr_png_": "IPython's display protocol",
}
#: What takes the name of a member as a string, and changes or reads it.
BY_NAME = ("setattr", "delattr", "getattr", "hasattr")


def part_of(path: Path) -> str:
    """Name the part that a module belongs to: its package, or the module itself."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    gc.disable()  # it would look at all of half a million again and again: half of the time
    try:
        return tuple(ast.walk(ast.parse(path.read_text(encoding="utf-8"), str(path))))
    finally:
        gc.enable()


@pytest.fixture(scope="module", autouse=True)
def _nodes_go():
    """Let go of them at the end: Python would look through them before its own."""
    yield
    nodes.cache_clear()


@cache
def imported(path: Path) -> tuple[str, ...]:
    return tuple(imports(nodes(path)))


def imports(nodes: Iterable[ast.AST]) -> Iterator[str]:
    """Yield the full name of every module or member that is imported, wherever in the file."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and named(node.func, "import_module"):
            name = node.args[0]
            if isinstance(name, ast.Constant):
                yield str(name.value)


def named(node: ast.expr, name: str) -> bool:
    """Whether an expression is a name, or a member of that name."""
    return getattr(node, "id", None) == name or getattr(node, "attr", None) == name


def is_mitsuba(node: ast.AST, member: str = "") -> bool:
    """Whether an expression is a member of Mitsuba's module, or a member of such a one."""
    while isinstance(node, ast.Attribute | ast.Call):
        last, node = node, node.func if isinstance(node, ast.Call) else node.value
        if isinstance(node, ast.Name) and isinstance(last, ast.Attribute):
            return node.id in ("mi", "mitsuba") and last.attr.startswith(member)
    return False


def check_all(rule: Callable[[Path], Iterator[str]], modules: Sequence[Path] = MODULES) -> None:
    """Hold every module against a rule, which yields what breaks it; all that do are told at once."""
    assert len(modules) > 100  # the walk finds them
    broken = [f"{path.relative_to(PACKAGE).as_posix()}: {what}" for path in modules for what in rule(path)]
    assert not broken, "\n".join(broken)


def in_other_parts_than(part: str) -> list[Path]:
    return [path for path in MODULES if part_of(path) != part]


def test_every_module_belongs_to_a_part():
    unknown = {part_of(path) for path in MODULES} - set(RANK)
    assert not unknown, "not in the design: give it a place in LAYERS, and in design.md"


def test_imports_go_upwards():
    def rule(path):
        part = part_of(path)
        for name in imported(path):
            above = name.split(".")[1] if name.startswith("gemrender.") else part
            if (part, name) in WAYS_BACK or above in (part, "__version__"):
                continue
            if not RANK[above] < RANK[part]:
                yield f"{part} must not import {name}"

    check_all(rule)


def test_no_study_imports_from_a_package_of_studies():
    """Atlases and the search for better stones rest on the other files of `sweep`, not on each other."""
    inner = {f"gemrender.sweep.{path.parent.name}" for path in (PACKAGE / "sweep").glob("*/__init__.py")}
    assert inner == {"gemrender.sweep.atlas", "gemrender.sweep.improve"}

    def rule(path):
        others = inner - {f"gemrender.sweep.{path.parent.name}"}
        for name in imported(path) if part_of(path) == "sweep" else ():
            if ".".join(name.split(".")[:3]) in others:
                yield f"must not import {name}"

    check_all(rule)


def test_work_is_shared_among_processors_of_the_process_not_of_the_machine():
    """A job of a cluster has some of them; the doctor tells both numbers."""

    def rule(path):
        if path.stem not in ("processors", "diagnosis"):
            for node in nodes(path):
                if named(node, "cpu_count"):
                    yield "must ask gemrender.processors"

    check_all(rule)


def test_the_face_is_asked_for_its_version_only():
    """From inside, `import gemrender` would be a way back."""

    def rule(path):
        if "gemrender" not in imported(path):
            return
        for node in nodes(path):
            if (
                isinstance(node, ast.Attribute)
                and node.attr != "__version__"
                and named(node.value, "gemrender")
            ):
                yield f"line {node.lineno}"

    check_all(rule, [path for path in MODULES if path.name != "__main__.py"])


def test_libraries_are_those_of_the_part():
    def rule(path):
        part = part_of(path)
        for name in imported(path):
            root = name.split(".")[0]
            if root not in sys.stdlib_module_names and root != "gemrender" and root not in LIBRARIES[part]:
                yield f"{part} must not import {root}"

    check_all(rule)


def test_classes_are_derived_from_mitsuba_in_plugins_only():
    def rule(path):
        for node in nodes(path):
            if isinstance(node, ast.ClassDef) and any(is_mitsuba(base) for base in node.bases):
                yield node.name

    check_all(rule, in_other_parts_than("plugins"))


@pytest.mark.parametrize(
    ("member", "file"),
    [
        ("Mesh", "scene/mesh.py"),
        ("load_", "scene/loading.py"),  # which keeps their order
    ],
)
def test_meshes_are_made_and_scenes_loaded_in_one_file_only(member, file):
    def rule(path):
        for node in nodes(path):
            if isinstance(node, ast.expr) and is_mitsuba(node, member):
                yield f"line {node.lineno}"

    assert list(rule(PACKAGE / file)), "the file itself does"
    check_all(rule, [path for path in MODULES if path != PACKAGE / file])


def test_plugins_are_reached_by_name_only():
    """A plugin's class imported from its module is soon that of another variant."""
    plugins = {f"gemrender.plugins.{path.stem}" for path in (PACKAGE / "plugins").glob("[!_]*.py")}

    def rule(path):
        for full in imported(path):
            yield from plugins & {full, full.rpartition(".")[0]}

    check_all(rule, in_other_parts_than("plugins"))


def test_modules_that_name_mitsuba_put_off_their_annotations():
    def rule(path):
        names = set(imported(path))
        if any(name.split(".")[0] == "mitsuba" for name in names) and "__future__.annotations" not in names:
            yield "from __future__ import annotations"

    check_all(rule)


# ---- What tests may know -------------------------------------------------------------------------------


def is_private(name: str) -> bool:
    """Whether a name begins with one underscore; those with two on each side are Python's."""
    return name.startswith("_") and not name.startswith("__")


def private_names(nodes: Iterable[ast.AST]) -> Iterator[str]:
    """Yield the private names of gemrender that a test knows: imported, as members, or in strings.

    Members of `self` and `cls` are a test's own. Whose other members are cannot be told from the source:
    those of other packages are the few in `OTHERS_MEMBERS`.
    """
    for node in nodes:
        if isinstance(node, ast.Attribute):
            if is_private(node.attr) and not (named(node.value, "self") or named(node.value, "cls")):
                yield from {node.attr} - OTHERS_MEMBERS.keys()
        elif isinstance(node, ast.Import | ast.ImportFrom):
            for name in imports([node]):
                if name.startswith("gemrender.") and any(map(is_private, name.split("."))):
                    yield name
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and "gemrender" in node.value:
            with contextlib.suppress(SyntaxError):  # a path of names, a program for another process, or words
                yield from private_names(ast.walk(ast.parse(textwrap.dedent(node.value))))
        elif isinstance(node, ast.Call) and any(named(node.func, name) for name in BY_NAME):
            for name in node.args[1:2]:
                if isinstance(name, ast.Constant) and is_private(str(name.value)):
                    yield from {str(name.value)} - OTHERS_MEMBERS.keys()


def test_tests_use_no_private_names():
    """What a test needs is public, or is seen in what comes out: else every change of how breaks it."""
    paths = sorted({*TESTS.rglob("*.py")} - {Path(__file__)})  # the next test shows what is not allowed
    assert len(paths) > 100  # the walk finds them
    broken = [
        f"{path.relative_to(TESTS).as_posix()}: {name}"
        for path in paths
        if re.search(r"\b_[A-Za-z]", path.read_text(encoding="utf-8"))  # others need no reading
        for name in private_names(nodes(path))
    ]
    assert not broken, "\n".join(broken)


def test_the_walk_sees_private_names_however_they_are_used():
    source = """
from gemrender.sweep.tilt import _entry, study_tilt
import gemrender._inner
from helpers import _own
painter._paint(self._job, cls._jobs, page._repr_html_(), os._exit, page.__dict__)
monkeypatch.setattr(output, "_PATIENCE", 1)
monkeypatch.setattr(output, "PATIENCE", 1)
monkeypatch.setattr("gemrender.sweep.store._READ", 2)
run_python("-c", "from gemrender.sweep import _said\\nprint(_said)")
with pytest.raises(ValueError, match="gemrender and its _ways"): ...
"""
    assert sorted(private_names(ast.walk(ast.parse(source)))) == [
        "_PATIENCE",
        "_READ",
        "_paint",
        "gemrender._inner",
        "gemrender.sweep._said",
        "gemrender.sweep.tilt._entry",
    ]


# ---- The rules themselves ------------------------------------------------------------------------------


def test_the_walk_sees_imports_wherever_they_are():
    source = (
        "def f():\n if x:\n  import matplotlib.pyplot\n  importlib.import_module('drjit')\nfrom a.b import c"
    )
    assert set(imports(ast.walk(ast.parse(source)))) == {"matplotlib.pyplot", "drjit", "a.b.c"}

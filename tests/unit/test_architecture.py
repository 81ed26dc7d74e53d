"""Who may import whom (`design.md`): read from the source, function-level imports included."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
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
    {"errors": set()},
    {"mistakes": set()},
    {"writing": set(), "reading": set(), "progress": set(), "interruption": set()},
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
    {"scene": {"numpy", "scipy", "mitsuba"}},
    {"plugins": {"numpy", "mitsuba", "drjit"}},
    {"render": {"numpy", "numba", "mitsuba", "drjit", "colour", "OpenEXR", "PIL", "av", "mitsuba_oidn"}},
    {"engines": {"numpy"}},
    {"scoring": {"numpy"}},
    {"mapping": {"numpy"}},
    {"crosscheck": {"numpy"}, "stereo": {"numpy"}},
    {"sweep": {"numpy", "scipy", "drjit", "pymoo", *_ATLASES}},
    {"report": {"numpy", "matplotlib", "mpl_toolkits", "rich", "OpenEXR", "colour"}},
    {"cli": {"numpy", "typer", "rich"}},
    {"__main__": set()},
]
RANK = {part: rank for rank, layer in enumerate(LAYERS) for part in layer}
LIBRARIES = {part: libraries for layer in LAYERS for part, libraries in layer.items()}

MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def part_of(path: Path) -> str:
    """Name the part that a module belongs to: its package, or the module itself."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


def imports(tree: ast.AST) -> Iterator[str]:
    """Yield the full name of every module or member that is imported, wherever in the file."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
            name = node.args[0]
            if isinstance(name, ast.Constant):
                yield str(name.value)


def is_mitsuba(node: ast.expr, member: str = "") -> bool:
    """Whether an expression is a member of Mitsuba's module."""
    return isinstance(node, ast.Attribute) and ast.unparse(node).startswith(
        (f"mi.{member}", f"mitsuba.{member}")
    )


@pytest.fixture(params=MODULES, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def module(request):
    return request.param


def test_every_module_belongs_to_a_part(module):
    assert part_of(module) in RANK, "not in the design: give it a place in LAYERS, and in design.md"


def test_imports_go_upwards(module):
    part = part_of(module)
    for name in imports(parsed(module)):
        above = name.split(".")[1] if name.startswith("gemrender.") else part
        if above in (part, "__version__"):
            continue
        assert RANK[above] < RANK[part], f"{part} must not import {name}"


def test_the_face_is_asked_for_its_version_only(module):
    """From inside, `import gemrender` would be a way back."""
    if module.name == "__main__.py":
        return
    tree = parsed(module)
    if "gemrender" not in imports(tree):
        return
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "gemrender":
            assert node.attr == "__version__"


def test_libraries_are_those_of_the_part(module):
    part = part_of(module)
    for name in imports(parsed(module)):
        root = name.split(".")[0]
        if root not in sys.stdlib_module_names and root != "gemrender":
            assert root in LIBRARIES[part], f"{part} must not import {root}"


def test_classes_are_derived_from_mitsuba_in_plugins_only(module):
    if part_of(module) == "plugins":
        return
    for node in ast.walk(parsed(module)):
        if isinstance(node, ast.ClassDef):
            assert not any(is_mitsuba(base) for base in node.bases), node.name


def test_meshes_are_made_in_one_file_only(module):
    if module == PACKAGE / "scene" / "mesh.py":
        return
    for node in ast.walk(parsed(module)):
        assert not (isinstance(node, ast.expr) and is_mitsuba(node, "Mesh")), f"line {node.lineno}"


def test_scenes_are_loaded_in_one_file_only(module):
    """Which keeps their order: `scene/loading.py`."""
    if module == PACKAGE / "scene" / "loading.py":
        return
    for node in ast.walk(parsed(module)):
        assert not (isinstance(node, ast.expr) and is_mitsuba(node, "load_")), f"line {node.lineno}"


def test_plugins_are_reached_by_name_only(module):
    """A plugin's class imported from its module is soon that of another variant."""
    if part_of(module) == "plugins":
        return
    plugins = {f"gemrender.plugins.{path.stem}" for path in (PACKAGE / "plugins").glob("[!_]*.py")}
    assert not plugins & {
        name for full in imports(parsed(module)) for name in (full, full.rpartition(".")[0])
    }


def test_modules_that_name_mitsuba_put_off_their_annotations(module):
    tree = parsed(module)
    if any(name.split(".")[0] == "mitsuba" for name in imports(tree)):
        assert "__future__.annotations" in imports(tree)


def test_the_walk_sees_imports_wherever_they_are():
    source = (
        "def f():\n if x:\n  import matplotlib.pyplot\n  importlib.import_module('drjit')\nfrom a.b import c"
    )
    assert set(imports(ast.parse(source))) == {"matplotlib.pyplot", "drjit", "a.b.c"}

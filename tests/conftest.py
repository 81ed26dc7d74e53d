"""Fixtures: one for each variant that gemrender works in, and random numbers with a fixed seed.

A test that needs Mitsuba takes one of the variant fixtures and imports what it likes::

    def test01_weight_is_one(variant_llvm_ad_mono): ...   # in this variant
    def test02_survives(variants_all): ...                # once in each
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import importlib
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from observations import TERMINAL_VARIABLES

from gemrender import cli
from gemrender.errors import BackendError
from gemrender.processors import usable_processors
from gemrender.progress import ProgressLines
from gemrender.render.backend import ensure_variant, prepare_llvm

# Dr.Jit loads its LLVM while it is imported, and test modules import it. Where there is none, the variant
# fixtures say so, and the tests that need no Mitsuba still run.
with contextlib.suppress(BackendError, ImportError):
    prepare_llvm()
    # Threads of Dr.Jit wait for work busily: those of one process of tests would take the others' cores
    if processes := int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "0")):
        importlib.import_module("drjit").set_thread_count(max(1, usable_processors() // processes))

# Where Python is told to keep no bytecode, every program that a test starts would compile the whole package:
# two seconds instead of one, each time. xdist's workers are started with this too.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Threads of NumPy's matrix products wait busily, too, and matrices of tests are small. NumPy looks at this
# when it is imported: it is for xdist's workers and for programs that tests start.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Shells have their jobs in the background ignore SIGINT, and so would every program that a test interrupts.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Keep modules and tests, which stay to the end, out of the garbage collector's sight.

    It looked at all of them again and again: a quarter of collecting, a tenth of tests (half of it is saved).
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.collect()
        gc.freeze()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with pictures, then what is in a variant, one variant after the other.

    Processes of xdist each begin with half of the tests. Where nothing is compiled yet, so only one of them
    compiles numba's kernels, and the other one reads them later. A change of variant, in which Mitsuba loads
    its integrators in Python anew, takes longer than most tests.
    """

    def order(item: pytest.Item) -> tuple[bool, bool, str]:
        variant = _variant_of(item)
        return (not item.path.name.startswith("test_render_"), not variant, variant)

    items.sort(key=order)


def _variant_of(item: pytest.Item) -> str:
    """Return the variant that a test's fixture switches on; "" for none."""
    named = next((name for name in item.fixturenames if name.startswith("variant_")), "")
    call = getattr(item, "callspec", None)
    return str(getattr(call, "params", {}).get("variants_all", named.removeprefix("variant_")))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Iterator[None]:
    """Do the same with what a module has imported, compiled and left in caches, once its fixtures are gone.

    Each test in a variant lets the garbage collector look at what there is: 0.3 s and more, were it all.
    """
    yield
    if nextitem is not None and nextitem.path != item.path:
        gc.collect()
        gc.freeze()


def pytest_sessionfinish() -> None:
    atexit.register(_let_go)


def _let_go() -> None:
    """Have what Dr.Jit holds let go in its order; but later than pytest has looked for garbage.

    Python looks for it once more after that, at all there is, and need not do so twice.
    """
    gc.unfreeze()
    gc.disable()


def _variant(name: str) -> Iterator[str]:
    """Switch the variant on; afterwards wait for its kernels, so that a failure shows up in its own test."""
    gc.collect()  # scenes of tests before: their lights and surfaces would be in the kernels of this one
    yield ensure_variant(name)

    import drjit as dr

    dr.sync_thread()
    dr.kernel_history_clear()


@pytest.fixture
def variant_llvm_ad_mono() -> Iterator[str]:
    yield from _variant("llvm_ad_mono")


@pytest.fixture
def variant_llvm_ad_mono_polarized() -> Iterator[str]:
    yield from _variant("llvm_ad_mono_polarized")


@pytest.fixture
def variant_llvm_ad_rgb() -> Iterator[str]:
    yield from _variant("llvm_ad_rgb")


@pytest.fixture
def variant_llvm_ad_spectral() -> Iterator[str]:
    yield from _variant("llvm_ad_spectral")


@pytest.fixture(params=["llvm_ad_mono", "llvm_ad_rgb", "llvm_ad_spectral"])
def variants_all(request: pytest.FixtureRequest) -> Iterator[str]:
    yield from _variant(request.param)


@pytest.fixture
def hangups_end() -> Iterator[None]:
    """SIGHUP has its usual meaning, in programs that a test starts, too; nohup has them ignore it."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL) if hasattr(signal, "SIGHUP") else None
    yield
    if before is not None:
        signal.signal(signal.SIGHUP, before)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(seed=12345)


@pytest.fixture
def ply(tmp_path: Path) -> Callable[..., dict[str, object]]:
    """Return what writes a mesh (positions, faces) as a PLY file, and gives the gem that reads it."""
    from meshes import write_ply

    count = 0

    def stone(mesh: object, *, normals: object = None, **more: object) -> dict[str, object]:
        nonlocal count
        count += 1
        path = write_ply(tmp_path / f"mesh_{count}.ply", mesh, normals)
        bsdf = {"type": "gem_dielectric", "dispersion": False}
        return {"type": "ply", "filename": str(path), "bsdf": bsdf, **more}

    return stone


@pytest.fixture
def gemrender(capsys, monkeypatch):
    """Run the command line in this process; returns exit status, stdout and stderr."""
    for variable in TERMINAL_VARIABLES:
        monkeypatch.delenv(variable, raising=False)
    # On a busy machine a command may take so long that it says so
    monkeypatch.setitem(ProgressLines.__init__.__kwdefaults__, "every", 3600.0)

    def run(*arguments):
        with pytest.raises(SystemExit) as caught:
            cli.main([str(argument) for argument in arguments])
        return (caught.value.code, *capsys.readouterr())

    return run


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path

"""Switching a variant on: what is refused, and with which cure. Mitsuba itself is faked."""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from gemrender.errors import BackendError, InputError
from gemrender.render import backend

VARIANTS = ["scalar_rgb", "llvm_ad_mono", "llvm_ad_spectral", "cuda_ad_mono"]


class FakeMitsuba:
    """Stands for Mitsuba, Dr.Jit and the plugins, and notes what is asked of it."""

    JitBackend = SimpleNamespace(CUDA="cuda")

    def __init__(self, monkeypatch, *, version="3.9.1", llvm=(23, 1, 4), active=None):
        self.__version__, self.active, self.switches, self.registered = version, active, 0, 0
        self.detail = SimpleNamespace(llvm_version=lambda: llvm)
        modules = dict.fromkeys(("mitsuba", "drjit", "gemrender.plugins"), self)
        monkeypatch.setattr(importlib, "import_module", lambda name: modules[name])
        monkeypatch.setitem(sys.modules, "drjit", self)

    def variants(self):
        return VARIANTS

    def variant(self):
        return self.active

    def set_variant(self, variant):
        self.active, self.switches = variant, self.switches + 1

    def has_backend(self, name):
        return False

    def register(self):
        self.registered += 1


def import_fails_with(monkeypatch, error):
    def fail(name):
        raise error

    monkeypatch.setattr(importlib, "import_module", fail)
    monkeypatch.setitem(sys.modules, "drjit", None)  # so that no LLVM is looked for


def test_importing_the_module_loads_no_drjit():
    code = (
        "import sys, gemrender.render.backend; sys.exit(any(m in sys.modules for m in ('drjit', 'mitsuba')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_variant_is_set_and_plugins_registered(monkeypatch):
    mitsuba = FakeMitsuba(monkeypatch)
    assert backend.ensure_variant("llvm_ad_spectral") == "llvm_ad_spectral"
    assert (mitsuba.active, mitsuba.registered) == ("llvm_ad_spectral", 1)


def test_active_variant_is_not_set_again(monkeypatch):
    mitsuba = FakeMitsuba(monkeypatch, active="llvm_ad_mono")
    backend.ensure_variant("llvm_ad_mono")
    assert mitsuba.switches == 0


def test_scalar_variant_is_refused_with_the_reason():
    with pytest.raises(InputError, match=r"variant = 'scalar_rgb': .*0\.1 million rays"):
        backend.ensure_variant("scalar_rgb")


def test_unknown_variant_is_refused_with_the_allowed_ones(monkeypatch):
    FakeMitsuba(monkeypatch)
    with pytest.raises(InputError, match=r"must be one of llvm_ad_mono, llvm_ad_spectral, cuda_ad_mono$"):
        backend.ensure_variant("llvm_ad_ultraviolet")


def test_llvm_is_named_before_drjit_is_imported(monkeypatch):
    FakeMitsuba(monkeypatch)
    monkeypatch.delitem(sys.modules, "drjit")
    prepared = []
    monkeypatch.setattr(backend, "prepare_llvm", lambda: prepared.append("drjit" in sys.modules))
    backend.ensure_variant("llvm_ad_mono")
    assert prepared == [False]


def test_missing_libatomic_as_drjit_shows_it(monkeypatch):
    import_fails_with(monkeypatch, NameError("name '_drjit_ext' is not defined"))
    with pytest.raises(BackendError, match=r"libatomic.*; to cure it: apt-get install libatomic1$"):
        backend.ensure_variant("cuda_ad_mono")


def test_missing_library_is_named_from_the_first_error(monkeypatch):
    error = NameError("name '_drjit_ext' is not defined")
    error.__context__ = ImportError("libz.so.1: cannot open shared object file: No such file or directory")
    import_fails_with(monkeypatch, error)
    with pytest.raises(BackendError, match=r"Dr\.Jit needs libz\.so\.1"):
        backend.ensure_variant("cuda_ad_mono")


def test_missing_mitsuba_is_told_with_the_cure(monkeypatch):
    import_fails_with(monkeypatch, ModuleNotFoundError("No module named 'mitsuba'"))
    with pytest.raises(BackendError, match=r"pip install mitsuba==3\.9\.1 drjit==1\.5\.0"):
        backend.ensure_variant("cuda_ad_mono")


def test_other_mitsuba_is_refused(monkeypatch):
    FakeMitsuba(monkeypatch, version="3.10.0")
    with pytest.raises(BackendError, match=r"needs Mitsuba 3\.9\.1, found 3\.10\.0"):
        backend.ensure_variant()


def test_old_llvm_that_drjit_has_loaded_is_refused_before_the_variant_is_set(monkeypatch):
    found = backend.LlvmLibrary(path=Path("libLLVM.so.19.1"), origin="system", version=19)
    monkeypatch.setattr(backend, "prepare_llvm", lambda: found)
    monkeypatch.setattr(backend, "require_loadable", lambda library: None)
    monkeypatch.setattr(backend, "exchange_llvm", lambda drjit, mitsuba: "for a reason")
    mitsuba = FakeMitsuba(monkeypatch, llvm=(15, 0, 6))
    with pytest.raises(
        BackendError,
        match=r"imported with LLVM 15\.0\.6, .*: for a reason; .*start Python with DRJIT_LIBLLVM_PATH=lib",
    ):
        backend.ensure_variant()
    assert mitsuba.switches == 0


def test_old_llvm_that_drjit_exchanges_is_no_error(monkeypatch):
    found = backend.LlvmLibrary(path=Path("libLLVM.so.19.1"), origin="system", version=19)
    monkeypatch.setattr(backend, "prepare_llvm", lambda: found)
    monkeypatch.setattr(backend, "require_loadable", lambda library: None)
    versions = iter([(15, 0, 6), (19, 1, 0)])
    mitsuba = FakeMitsuba(monkeypatch)
    mitsuba.detail.llvm_version = lambda: next(versions)
    monkeypatch.setattr(backend, "exchange_llvm", lambda drjit, mitsuba: "")
    assert backend.ensure_variant() == mitsuba.active == "llvm_ad_mono"


def test_cuda_without_a_graphics_processor_is_refused_in_one_line(monkeypatch):
    FakeMitsuba(monkeypatch)
    with pytest.raises(BackendError, match=r"^cuda_ad_mono needs an NVIDIA.*--variant llvm_ad_mono$"):
        backend.ensure_variant("cuda_ad_mono")

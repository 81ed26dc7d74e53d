"""`gemrender.mitsuba` in every order of imports, each in a process of its own.

The LLVMs that do not work are the system's old ones, where it has some (Debian's 14, 15 and 16 do not). That
Dr.Jit can leave one LLVM for another is tested on every machine, with one and the same.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from observations import run_python
from thorough import chosen

import gemrender
from gemrender.errors import BackendError
from gemrender.render import backend, import_order, llvm

#: Versions that Dr.Jit refuses (14) or that end the process in a minimum, on a processor with AVX-512.
OLD = sorted(Path("/usr/lib/x86_64-linux-gnu").glob("libLLVM-1[456].so.1"))

#: Ends the process (SIGABRT) with an LLVM that does not work, and shows that the plugins are there.
USE = """
import drjit as dr, sys
assert sys.modules["mitsuba"] is mi
plugin = type(mi.load_dict({"type": "gem_path"})).__module__
print(mi.variant(), dr.minimum(mi.Float([1, 2]), mi.Float([3, 0])), plugin)
"""
WORKS = "[1, 0] gemrender.plugins.path\n"


#: What a user did before, and the variant that is asked for then.
BEFORE = {
    "imported": ("", "llvm_ad_spectral"),
    "scalar-scene": ("mi.set_variant('scalar_rgb'); scene = mi.load_dict(mi.cornell_box())", "llvm_ad_rgb"),
    "llvm-variant": ("try: mi.set_variant('llvm_ad_rgb')\nexcept ImportError: pass", "llvm_ad_rgb"),
}


def run(code, **variables):
    variables.setdefault("DRJIT_LIBLLVM_PATH", "")
    return run_python("-c", code, environment=variables)


def with_old(path, code):
    """Import Dr.Jit with that LLVM, as it would find it itself on another machine, then run the code."""
    first = f"import os; os.environ['DRJIT_LIBLLVM_PATH'] = {str(path)!r}; import drjit; "
    return run(f"{first}del os.environ['DRJIT_LIBLLVM_PATH']\n{code}")


def test_mitsuba_is_ready_in_the_variant_of_pictures():
    done = run(f"import gemrender; mi = gemrender.mitsuba()\n{USE}")
    assert done.stdout == f"llvm_ad_spectral {WORKS}", done.stderr


def test_plain_mitsuba_works_after_gemrender_is_imported():
    """Whoever imports Dr.Jit then, and without a call of gemrender."""
    done = run(
        "import gemrender, mitsuba as mi; mi.set_variant('llvm_ad_rgb'); import drjit as dr\n"
        "print(dr.minimum(mi.Float(1), 2), dr.detail.llvm_version() >= (17, 0, 0))"
    )
    assert done.stdout == "[1] True\n", done.stderr


def test_the_users_variable_is_left_alone():
    done = run("import gemrender, os; import drjit; print(os.environ['DRJIT_LIBLLVM_PATH'])",
               DRJIT_LIBLLVM_PATH="/no/such/library.so")  # fmt: skip
    assert done.stdout == "/no/such/library.so\n"


@pytest.mark.parametrize("old", chosen(OLD, OLD[:1]), ids=lambda path: path.name)
@pytest.mark.parametrize(("before", "variant"), chosen(BEFORE.values(), [*BEFORE.values()][-1:]), ids=BEFORE)
def test_an_llvm_that_does_not_work_is_exchanged(old, before, variant):
    done = with_old(
        old, f"import mitsuba as mi\n{before}\nimport gemrender; mi = gemrender.mitsuba({variant!r})\n{USE}"
    )
    assert done.stdout == f"{variant} {WORKS}", done.stderr


@pytest.mark.parametrize("old", [path for path in OLD if "14" not in path.name], ids=lambda path: path.name)
def test_with_a_scene_alive_the_llvm_is_refused_in_one_line(old):
    done = with_old(
        old,
        "import mitsuba as mi; mi.set_variant('llvm_ad_rgb'); scene = mi.load_dict({'type': 'sphere'})\n"
        "import gemrender\ntry: gemrender.mitsuba()\nexcept gemrender.BackendError as error: print(error)",
    )
    assert done.stdout.count("\n") == 1
    assert "cannot change it now: there are scenes, or parts of one, that were made with it" in done.stdout
    assert "to cure it: import gemrender before mitsuba and drjit, or start Python with" in done.stdout


def test_no_llvm_is_refused_in_one_line_with_the_cure():
    done = with_old(
        "/no/such/library.so",
        "import gemrender\ntry: gemrender.mitsuba()\nexcept gemrender.BackendError as error: print(error)",
    )
    assert done.stdout.count("\n") == 1
    assert "Dr.Jit was imported with no LLVM" in done.stdout
    assert "start Python with DRJIT_LIBLLVM_PATH=" in done.stdout


#: Renders, exchanges the LLVM between two scenes, and renders again; arrays and settings live on.
EXCHANGE = """
import gemrender, numpy as np
mi = gemrender.mitsuba("llvm_ad_rgb")
import drjit as dr
from gemrender.render.import_order import exchange_llvm
def picture():
    return np.array(mi.render(mi.load_dict(mi.cornell_box()), spp=1, seed=7))
dr.set_thread_count(1)  # with more, the order of sums changes their last bits
before, numbers, unevaluated = picture(), mi.Float([1, 2]), dr.arange(mi.Float, 3) * 2
sphere = mi.load_dict({"type": "sphere"})
print(exchange_llvm(dr, mi))
del sphere
into = dr.zeros(mi.Float, 4)
dr.eval(into)
dr.scatter(into, mi.Float(1), mi.UInt(2))
print(exchange_llvm(dr, mi))
dr.eval(into)
print(repr(exchange_llvm(dr, mi)), dr.thread_count(), numbers + 1, unevaluated, into)
print(np.array_equal(before, picture()))
"""


def test_arrays_and_settings_outlive_the_exchange_and_scenes_prevent_it():
    done = run(EXCHANGE)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [
        "there are scenes, or parts of one, that were made with it",
        "there are scattered values that were not yet evaluated",
        "'' 1 [2, 3] [0, 2, 4] [0, 0, 1, 0]",
        "True",
    ]


def test_a_drjit_without_the_functions_is_left_as_it_is(tmp_path):
    drjit = type(sys)("drjit")
    drjit.__file__ = str(tmp_path / "__init__.py")
    assert import_order.exchange_llvm(drjit, None) == "this build of Dr.Jit cannot change it"


def test_the_finder_is_there_once_and_only_until_drjit_is_imported(monkeypatch):
    monkeypatch.setattr(sys, "meta_path", [])
    monkeypatch.delitem(sys.modules, "drjit", raising=False)
    named = []
    monkeypatch.setattr(llvm, "prepare_llvm", lambda: named.append("LLVM"))
    import_order.name_llvm_before_drjit()
    import_order.name_llvm_before_drjit()
    (finder,) = sys.meta_path
    assert finder.find_spec("numpy") is None
    assert not named
    assert finder.find_spec("drjit") is None
    assert (named, sys.meta_path) == (["LLVM"], [])


def test_the_finder_leaves_it_to_others_to_miss_an_llvm(monkeypatch):
    def prepare():
        raise BackendError("none")

    monkeypatch.setattr(llvm, "prepare_llvm", prepare)
    monkeypatch.setattr(sys, "meta_path", [])
    monkeypatch.delitem(sys.modules, "drjit", raising=False)
    import_order.name_llvm_before_drjit()
    (finder,) = sys.meta_path
    assert finder.find_spec("drjit") is None


@pytest.mark.parametrize(
    ("active", "asked", "variant"),
    [
        (None, None, "llvm_ad_spectral"),
        ("scalar_rgb", None, "llvm_ad_spectral"),
        ("llvm_ad_rgb", None, "llvm_ad_rgb"),
        ("llvm_ad_rgb", "llvm_ad_mono", "llvm_ad_mono"),
    ],
)
def test_the_active_variant_is_kept_unless_another_is_asked_for(monkeypatch, active, asked, variant):
    fake = type(sys)("mitsuba")
    fake.variant = lambda: active
    monkeypatch.setitem(sys.modules, "mitsuba", fake)
    ensured = []
    monkeypatch.setattr(backend, "ensure_variant", ensured.append)
    assert gemrender.mitsuba(asked) is fake
    assert ensured == [variant]

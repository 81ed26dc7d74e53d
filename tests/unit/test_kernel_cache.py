"""Compiled kernels on disk: a damaged, an unreadable or an old file costs a compilation, and nothing else."""

from __future__ import annotations

import importlib.util
import queue
import shutil
import threading

import numba
import numpy as np
import pytest
from doctor_help import found
from observations import run_python
from thorough import chosen

import gemrender.beam
from gemrender.beam import cache as kernel_cache
from gemrender.beam import is_compiled, polygons, prepare
from gemrender.beam.compiled import COMPILING

SOURCE = """
from gemrender.beam.compiled import jit

@jit
def doubled(x):
    return 2 * x
"""


def test_who_asks_waits_for_who_compiles():
    """numba has one list of what it knows; two threads that look through it at once make it fail."""
    answers = queue.Queue()
    thread = threading.Thread(target=lambda: answers.put(is_compiled()))
    with COMPILING:
        thread.start()
        with pytest.raises(queue.Empty):
            answers.get(timeout=0.2)
    assert answers.get(timeout=60) in (True, False)
    thread.join()


@pytest.fixture
def load(tmp_path):
    """Load a module with one kernel, as another process would."""
    (tmp_path / "tiny.py").write_text(SOURCE)

    def load():
        spec = importlib.util.spec_from_file_location("tiny", tmp_path / "tiny.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module.doubled

    return load


def compilations(kernel) -> int:
    """Call it, and return how often it had to be compiled for that."""
    assert kernel(21) == 42
    return sum(kernel.stats.cache_misses.values())


def damaged(kernel) -> list[str]:
    """Return the files of a kernel that are damaged."""
    return kernel_cache.KernelCache(kernel.py_func).damaged()


def cut(path):
    path.write_bytes(path.read_bytes()[:-40])


def flip(path):
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


def turn_into_a_folder(path):
    path.unlink()
    path.mkdir()


DAMAGE = {
    "empty": lambda path: path.write_bytes(b""),
    "cut short": cut,
    "a bit flipped": flip,
    "something else": lambda path: path.write_bytes(b"\x80\x05not a pickle" * 100),
    "zeros": lambda path: path.write_bytes(bytes(path.stat().st_size)),
    "gone": lambda path: path.unlink(),
}


def files(tmp_path, ending):
    return list((tmp_path / "__pycache__").glob(f"*.{ending}"))


def test_a_kernel_is_compiled_once(load):
    assert [compilations(load()) for _ in range(3)] == [1, 0, 0]


#: Each kind of damage, and each kind of file by turns; each of each is slow.
DAMAGED = [(damage, ending) for damage in DAMAGE for ending in ("nbi", "nbc")]


@pytest.mark.parametrize(("damage", "ending"), chosen(DAMAGED, [*DAMAGED[::4], *DAMAGED[3::4]]))
def test_a_damaged_file_is_replaced(load, tmp_path, ending, damage):
    compilations(load())
    (path,) = files(tmp_path, ending)
    DAMAGE[damage](path)
    assert damaged(load()) == ([] if damage == "gone" else [str(path)])
    assert [compilations(load()) for _ in range(2)] == [1, 0]
    assert damaged(load()) == []


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_a_file_that_cannot_be_replaced_does_no_harm(load, tmp_path, ending):
    compilations(load())
    (path,) = files(tmp_path, ending)
    turn_into_a_folder(path)
    assert [compilations(load()) for _ in range(2)] == [1, 1]
    assert damaged(load()) == [str(path)]


def test_a_folder_that_is_gone_is_made_again(load, tmp_path):
    kernel = load()
    shutil.rmtree(tmp_path / "__pycache__")
    assert compilations(kernel) == 1
    assert compilations(load()) == 0


def test_a_change_of_any_kernels_source_is_seen(load, monkeypatch):
    """Also of one that this kernel calls, in another file."""
    compilations(load())
    monkeypatch.setattr(kernel_cache, "source_stamp", lambda: "other sources")
    assert damaged(load()) == []  # old, not damaged
    assert [compilations(load()) for _ in range(2)] == [1, 0]


def test_the_stamp_is_that_of_all_sources(tmp_path, monkeypatch):
    kernel_cache.source_stamp.cache_clear()
    before = kernel_cache.source_stamp()
    folder = tmp_path / "beam"
    shutil.copytree(kernel_cache.Path(kernel_cache.__file__).parent, folder)
    monkeypatch.setattr(kernel_cache, "__file__", str(folder / "cache.py"))
    kernel_cache.source_stamp.cache_clear()
    assert kernel_cache.source_stamp() == before
    with (folder / "crossing.py").open("a") as file:
        file.write("\n")
    kernel_cache.source_stamp.cache_clear()
    assert kernel_cache.source_stamp() != before
    kernel_cache.source_stamp.cache_clear()


# ---- Whether a score would compile ---------------------------------------------------------------------

LOOK = """
import gc, sys
from numba.core.dispatcher import Dispatcher
from gemrender.beam import is_compiled, prepare
told = is_compiled()
if told:
    prepare()
kernels = [k for k in gc.get_objects() if isinstance(k, Dispatcher) and k.__module__.startswith("gemrender")]
print(told, sum(sum(k.stats.cache_misses.values()) for k in kernels))
if told:
    from gemrender.beam import rays, rim
    kernels = (rim.line_points, rays.enter_rays, rays.follow_rays)
    before = [list(kernel.signatures) for kernel in kernels]
    sys.modules["gemrender.beam.prepare"].compile_rays()
    print(before == [list(kernel.signatures) for kernel in kernels], all(before))
"""


@pytest.fixture(scope="module")
def looked():
    """What another process says, once all is compiled."""
    prepare()
    assert is_compiled()
    done = run_python("-c", LOOK)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_what_is_told_to_be_compiled_needs_no_compilation(looked, tmp_path):
    assert looked[0] == "True 0"
    done = run_python("-c", LOOK, environment={"NUMBA_CACHE_DIR": str(tmp_path)})
    assert (done.returncode, done.stdout) == (0, "False 0\n"), done.stderr


# ---- What the doctor says ------------------------------------------------------------------------------


def test_the_doctor_tells_of_damaged_files(monkeypatch):
    monkeypatch.setattr(gemrender.beam, "damaged_cache_files", lambda: ["/somewhere/rays.nbi"])
    check = found(monkeypatch)["exact engine"]
    assert check.ok
    assert check.detail.endswith(": 1 of its files damaged, the first one rays.nbi")
    assert "compiled again" in check.cure


def test_the_doctor_tells_of_a_folder_that_cannot_be_written(monkeypatch):
    monkeypatch.setattr(polygons, "follow_polygons", numba.njit(lambda: None))  # a kernel that is not kept
    check = found(monkeypatch)["exact engine"]
    assert check.ok
    assert "every run compiles again" in check.detail
    assert check.cure == "set NUMBA_CACHE_DIR to a folder that can be written"


def test_another_process_compiles_what_a_score_takes_of_rays(looked):
    """With other types it would compile for nothing."""
    assert looked[1:] == ["True True"]


def test_kernels_of_birefringent_stones_are_compiled_before_a_score():
    from gemrender.beam.modes import measure_modes, optical_crystal, polygons, rays
    from gemrender.beam.modes.prepare import prepare_modes

    crystal = optical_crystal((1.76, 1.76, 1.77), np.eye(3))
    prepare_modes(crystal)
    kernels = [polygons.follow_modes, rays.enter_mode_rays, rays.start_mode_rays, rays.follow_mode_rays]
    ready = [list(kernel.signatures) for kernel in kernels]
    measure_modes(gemrender.load_stone("corundum-round"), crystal)
    assert [list(kernel.signatures) for kernel in kernels] == ready
    assert all(ready)

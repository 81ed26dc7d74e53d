"""LLVM in whatever order gemrender, Mitsuba and Dr.Jit are imported.

Dr.Jit loads LLVM while it is imported. `name_llvm_before_drjit` sees that coming; `exchange_llvm` is for a
Dr.Jit that was there first. Importing this module costs next to nothing: the package's face does it.
"""

from __future__ import annotations

import contextlib
import sys
from typing import Any

__all__ = ["exchange_llvm", "name_llvm_before_drjit"]


class _BeforeDrjit:
    """A finder of modules that finds none, but names an LLVM when Dr.Jit is about to be imported."""

    def find_spec(self, name: str, path: object = None, target: object = None) -> None:
        if name == "drjit":
            from gemrender.errors import BackendError
            from gemrender.render.llvm import prepare_llvm

            with contextlib.suppress(ValueError):  # another thread was faster
                sys.meta_path.remove(self)
            # Not all that Dr.Jit and Mitsuba do needs LLVM; what does, says so later.
            with contextlib.suppress(BackendError, OSError):
                prepare_llvm()


def name_llvm_before_drjit() -> None:
    """See to it that Dr.Jit is told of an LLVM that works, whoever imports it, if that is still to come."""
    if "drjit" not in sys.modules and not any(isinstance(finder, _BeforeDrjit) for finder in sys.meta_path):
        sys.meta_path.insert(0, _BeforeDrjit())


def exchange_llvm(dr: Any, mi: Any) -> str:
    """Make Dr.Jit leave the LLVM that it was imported with, and load the one that DRJIT_LIBLLVM_PATH names.

    By ``jit_shutdown`` and ``jit_init``, of which its header (drjit-core/jit.h) says that they may follow one
    another; they have no names in Python. Arrays live on. Objects of Mitsuba's would not, and end the process
    when they are freed, so that nothing is done where there are some.

    Parameters
    ----------
    dr, mi : module
        Dr.Jit and Mitsuba.

    Returns
    -------
    str
        Why it cannot be done; empty where it was tried.
    """
    import ctypes
    import gc
    from pathlib import Path

    try:
        (path,) = Path(dr.__file__).parent.glob("libdrjit-core.*")
        core = ctypes.CDLL(str(path))
        shutdown, init, whos = core._Z12jit_shutdowni, core._Z8jit_initj, core._Z12jit_var_whosv
        id_bound = core._Z21jit_registry_id_boundPKcS0_
    except (AttributeError, OSError, ValueError):  # Windows has other names for them
        return "this build of Dr.Jit cannot change it"
    whos.restype = ctypes.c_char_p
    id_bound.argtypes, id_bound.restype = [ctypes.c_char_p, ctypes.c_char_p], ctypes.c_uint32

    gc.collect()
    if any(
        id_bound(variant.encode(), kind.name.encode()) for variant in mi.variants() for kind in mi.ObjectType
    ):
        return "there are scenes, or parts of one, that were made with it"
    listed = whos()
    if b"CUDA" in listed or b"Metal" in listed:
        return "there are arrays on a graphics processor"
    if b" void " in listed:
        return "there are scattered values that were not yet evaluated"
    threads, warns = dr.thread_count(), dr.detail.leak_warnings()
    dr.detail.set_leak_warnings(False)  # an array that lives on is no leak
    try:
        shutdown(0)
        init(1 << dr.JitBackend.LLVM.value | 1 << dr.JitBackend.CUDA.value)
    finally:
        dr.detail.set_leak_warnings(warns)
    dr.set_thread_count(threads)
    return ""

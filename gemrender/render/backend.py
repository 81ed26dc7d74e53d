"""Mitsuba and its variant: import it, check that it can run here, switch the variant on.

Nothing here imports Mitsuba or Dr.Jit at import, because **Dr.Jit loads its LLVM while it is imported**: the
environment variable that names the library has to be set before.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any

from gemrender.errors import BackendError, InputError
from gemrender.interruption import interruptions_held
from gemrender.processors import usable_processors
from gemrender.render.cures import backend_error, cure_for_missing, library_cure
from gemrender.render.import_order import exchange_llvm
from gemrender.render.llvm import (
    LLVM_FLOOR,
    LLVM_VARIABLE,
    LlvmLibrary,
    find_llvm,
    prepare_llvm,
    require_loadable,
)

__all__ = [
    "DRJIT",
    "MITSUBA",
    "LlvmLibrary",
    "ensure_variant",
    "find_llvm",
    "mitsuba",
    "prepare_llvm",
]

#: Versions that gemrender runs with, as pinned in pyproject.toml.
MITSUBA, DRJIT = "3.9.1", "1.5.0"


def mitsuba(variant: str | None = None) -> Any:
    """Return Mitsuba, ready: with an LLVM that works, a variant set, and gemrender's plugins registered.

    ::

        mi = gemrender.mitsuba()
        scene = mi.load_file("scene.xml")
        mi.util.write_bitmap("picture.png", mi.render(scene))

    In whatever order gemrender, Mitsuba and Dr.Jit are imported, and whatever variant was set before. Once a
    scene has been loaded with an LLVM that does not work, it is too late.

    Parameters
    ----------
    variant : str, optional
        Name of a Mitsuba variant, not one of the scalar ones. None is the active variant if there is one and
        it is not scalar, and else ``llvm_ad_spectral``, in which stones have dispersion and colour.

    Returns
    -------
    module
        Mitsuba, as ``import mitsuba`` names it.

    Raises
    ------
    InputError
        No such variant, or a scalar one.
    BackendError
        Mitsuba, Dr.Jit, LLVM or a GPU is missing or of the wrong version; with the cure.
    """
    if variant is None:
        imported = sys.modules.get("mitsuba")
        active = None if imported is None else imported.variant()
        variant = "llvm_ad_spectral" if active is None or active.startswith("scalar") else active
    ensure_variant(variant)
    return sys.modules["mitsuba"]


def ensure_variant(variant: str = "llvm_ad_mono") -> str:
    """Make `variant` Mitsuba's active variant, with gemrender's plugins registered in it.

    Cheap where it is active already.

    Parameters
    ----------
    variant : str, optional
        Name of a Mitsuba variant, not one of the scalar ones.

    Returns
    -------
    str
        The variant.

    Raises
    ------
    InputError
        No such variant, or a scalar one.
    BackendError
        Mitsuba, Dr.Jit, LLVM or a GPU is missing or of the wrong version; with the cure.
    """
    if variant.startswith("scalar"):
        raise InputError(
            "scalar variants are refused, Python plugins trace only about 0.1 million rays a second in them; "
            "use llvm_ad_mono or llvm_ad_spectral",
            key="variant",
            value=variant,
        )
    if "drjit" not in sys.modules:
        try:
            prepare_llvm()
        except BackendError:
            # CUDA does without LLVM, but this is the only chance to name one for a later switch to it.
            if variant.startswith("llvm"):
                raise
    with interruptions_held():  # of which Mitsuba and Dr.Jit, while they are imported, make aborts
        _activate(_import_mitsuba(), variant)
    return variant


def _activate(mi: Any, variant: str) -> None:
    """Set the variant, and register the plugins in it."""
    allowed = [name for name in mi.variants() if not name.startswith("scalar")]
    if variant not in allowed:
        raise InputError(f"must be one of {', '.join(allowed)}", key="variant", value=variant)
    _check_backend(mi, variant)
    if mi.variant() != variant:
        try:
            mi.set_variant(variant)
        except ImportError as error:
            raise backend_error(f"Mitsuba cannot use {variant} ({error})", "gemrender doctor") from error
    importlib.import_module("gemrender.plugins").register()
    if usable_processors() == 1:
        _give_second_thread()


def _give_second_thread() -> None:
    """Give Dr.Jit, which has as many threads as there are processors, two at least.

    Mitsuba 3.9.1 reads and writes OpenEXR by threads beside its own, and waits for ever where there are none.
    """
    dr = importlib.import_module("drjit")
    if dr.thread_count() < 2:
        dr.set_thread_count(2)


def _import_mitsuba() -> Any:
    """Import Mitsuba; tell a missing library and a wrong version with the cure."""
    reinstall = f"pip install mitsuba=={MITSUBA} drjit=={DRJIT}"
    try:
        mi = importlib.import_module("mitsuba")
    except ModuleNotFoundError as error:
        raise backend_error(f"Mitsuba cannot be imported ({error})", reinstall) from error
    except (ImportError, NameError) as error:
        first: BaseException = error
        while first.__context__ is not None:
            first = first.__context__
        if missing := cure_for_missing(str(first)):
            found, cure = f"Dr.Jit needs {missing[0]}, which is missing", missing[1]
        elif "_drjit_ext" in str(error) or "libatomic" in str(error):
            # Dr.Jit names its extension while it reports that it could not be loaded: NameError.
            found = "Dr.Jit cannot be loaded, as where libatomic.so.1 is missing"
            cure = library_cure("libatomic.so.1")
        else:
            found, cure = f"Mitsuba cannot be imported ({first})", f"{reinstall} --force-reinstall"
        raise backend_error(found, cure) from error
    if not str(mi.__version__).startswith(MITSUBA):
        raise backend_error(f"gemrender needs Mitsuba {MITSUBA}, found {mi.__version__}", reinstall)
    return mi


def _check_backend(mi: Any, variant: str) -> None:
    """Check that Dr.Jit, by now imported, has a usable back end for the variant, or give it one."""
    dr = importlib.import_module("drjit")
    if variant.startswith("cuda"):
        if not dr.has_backend(dr.JitBackend.CUDA):
            found = f"{variant} needs an NVIDIA graphics processor and its driver, and Dr.Jit found none"
            raise backend_error(found, "--variant llvm_ad_mono")
        return
    version = tuple(dr.detail.llvm_version())  # (-1, -1, -1) where it has none
    if not variant.startswith("llvm") or version >= (LLVM_FLOOR, 0, 0):
        return
    took = f"LLVM {version[0]}.{version[1]}.{version[2]}" if version[0] > 0 else "no LLVM"
    library = prepare_llvm()
    require_loadable(library)
    why = exchange_llvm(dr, mi)
    if not why:
        version = tuple(dr.detail.llvm_version())
        if version >= (LLVM_FLOOR, 0, 0):
            return
        why = "it looks for one only once"
    raise backend_error(
        f"Dr.Jit was imported with {took}, needs {LLVM_FLOOR} or newer, and cannot change it now: {why}",
        f"import gemrender before mitsuba and drjit, or start Python with {LLVM_VARIABLE}={library.path}",
    )

"""What gemrender needs of this machine, looked at piece by piece: the findings behind `gemrender doctor`."""

from __future__ import annotations

import contextlib
import ctypes
import importlib.metadata
import os
import platform
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from gemrender.errors import BackendError
from gemrender.processors import usable_processors
from gemrender.render.backend import DRJIT, MITSUBA
from gemrender.render.cures import cure_for_missing, found_and_cure, last_words, library_cure
from gemrender.render.llvm import LLVM_VARIABLE, find_llvm

__all__ = ["EXACT_ENGINE", "Check", "diagnose"]

#: Name of the check of what runs without Mitsuba.
EXACT_ENGINE = "exact engine"


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One finding of `diagnose`.

    Parameters
    ----------
    name : str
        What was looked at.
    ok : bool or None
        True: as it should be. False: gemrender cannot run. None: for information.
    detail : str
        What was found, in one line.
    cure : str, optional
        What to do about it; empty where there is nothing to do.
    """

    name: str
    ok: bool | None
    detail: str
    cure: str = ""


def diagnose() -> list[Check]:
    """Check everything that gemrender needs of this machine.

    Takes about two seconds: Dr.Jit and Mitsuba run in another process, because a bad LLVM aborts.

    Returns
    -------
    list of Check
        Causes before effects. gemrender can run here where no check is False.
    """
    return [
        # pip refuses older Pythons.
        Check(name="Python", ok=True, detail=f"{platform.python_version()}, {sys.executable}"),
        Check(name="processor", ok=None, detail=_processor()),
        Check(name="threads", ok=None, detail=_threads()),
        _check_package("gemrender", required=False),
        _check_package("mitsuba", MITSUBA),
        _check_package("drjit", DRJIT),
        _check_package("numpy"),
        _check_package("OpenEXR"),
        _check_package("colour-science"),
        _check_package("matplotlib"),
        _check_libatomic(),
        _check_llvm(),
        *_check_running(),
        _check_cache(),
        _check_exact(),
    ]


def _processor() -> str:
    detail = f"{platform.system()} {platform.release()}, {platform.machine()}"
    try:
        flags = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return detail
    return f"{detail}, {'with' if 'avx512f' in flags else 'without'} AVX-512"


def _threads() -> str:
    cores = os.cpu_count() or 1
    return f"{cores} cores, {usable_processors()} of them open to this process"


def _check_package(name: str, wanted: str = "", *, required: bool = True) -> Check:
    """Look a package's version up without importing it."""
    cure = f"pip install {name}=={wanted}" if wanted else f"pip install {name}"
    try:
        version = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        if not required:
            return Check(name=name, ok=None, detail="not installed, runs from its folder")
        return Check(name=name, ok=False, detail="not installed", cure=cure)
    if version.startswith(wanted):
        return Check(name=name, ok=True, detail=version)
    return Check(name=name, ok=False, detail=f"{version}, and {wanted} is needed", cure=cure)


def _check_libatomic() -> Check:
    name = "libatomic"
    if platform.system() != "Linux":
        return Check(name=name, ok=None, detail="not needed here")
    try:
        ctypes.CDLL("libatomic.so.1")
    except OSError as error:
        return Check(name=name, ok=False, detail=str(error), cure=library_cure("libatomic.so.1"))
    return Check(name=name, ok=True, detail="libatomic.so.1")


def _check_llvm() -> Check:
    try:
        library = find_llvm()
    except BackendError as error:
        found, cure = found_and_cure(error)
        return Check(name="LLVM", ok=False, detail=found, cure=cure)
    detail = f"{library.version or 'version unknown'}, {library.path} ({library.origin})"
    return Check(name="LLVM", ok=True, detail=detail)


# A line "name<tab>detail" for each step that passed. min and max are what a bad LLVM cannot compile.
_SELF_TEST = """
import sys
import drjit as dr, mitsuba as mi
from drjit.llvm import Float
def passed(name, detail):
    print(name, detail, sep="\\t", flush=True)
passed("CUDA", "found" if dr.has_backend(dr.JitBackend.CUDA) else "none found, none needed")
if not dr.has_backend(dr.JitBackend.LLVM):
    sys.exit("Dr.Jit has no LLVM")  # its arrays would end the process
assert dr.all(dr.maximum(dr.minimum(Float(0, 1, 2, 3), 2), 1) == Float(1, 1, 2, 2))
passed("Dr.Jit", "LLVM " + ".".join(map(str, dr.detail.llvm_version())) + " compiles and runs a kernel")
for variant in ("llvm_ad_mono", "llvm_ad_spectral"):
    mi.set_variant(variant)
    scene = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}})
    hit = scene.ray_intersect(mi.Ray3f(mi.Point3f([0, 0.1], 0, -5), mi.Vector3f(0, 0, 1)))
    assert dr.allclose(hit.t, [4, 5 - 0.99**0.5], atol=1e-4)
    passed(variant, "traces a ray")
"""


def _check_running() -> list[Check]:
    """Compile and run kernels in another process, without the kernel cache, which would hide a bad LLVM."""
    environment = dict(os.environ)
    with contextlib.suppress(BackendError):
        environment[LLVM_VARIABLE] = str(find_llvm().path)
    with tempfile.TemporaryDirectory() as cache:
        environment["DRJIT_CACHE_DIR"] = cache
        command = [sys.executable, "-P", "-c", _SELF_TEST]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=120, check=False, env=environment
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            done = subprocess.CompletedProcess(command, 1, "", str(error))
    passed = dict(line.split("\t", 1) for line in done.stdout.splitlines() if "\t" in line)
    failure, (_, cure) = last_words(done), cure_for_missing(done.stderr) or ("", "")
    checks = []
    for name in ("Dr.Jit", "llvm_ad_mono", "llvm_ad_spectral"):
        if name in passed:
            checks.append(Check(name=name, ok=True, detail=passed[name]))
        else:
            checks.append(Check(name=name, ok=False, detail=failure, cure=cure))
            failure, cure = "not reached", ""
    return [*checks, Check(name="CUDA", ok=None, detail=passed.get("CUDA", "not reached"))]


def _check_cache() -> Check:
    """Check Dr.Jit's folder of compiled kernels; without it every run compiles anew."""
    if named := os.environ.get("DRJIT_CACHE_DIR"):
        folder = Path(named)
    elif platform.system() == "Windows":
        folder = Path(tempfile.gettempdir()) / "drjit"
    else:
        folder = Path(os.environ.get("HOME") or "/nonexistent") / ".drjit"  # as Dr.Jit: HOME, no look-up
    present = next(place for place in (folder.absolute(), *folder.absolute().parents) if place.exists())
    try:
        with tempfile.TemporaryFile(dir=present):
            return Check(name="kernel cache", ok=True, detail=str(folder))
    except OSError:
        detail = f"{folder} is not writable, every run compiles its kernels again"
        cure = "set DRJIT_CACHE_DIR to a folder that can be written"
        return Check(name="kernel cache", ok=None, detail=detail, cure=cure)


def _check_exact() -> Check:
    """Check the exact engine, which needs no Mitsuba."""
    try:
        import numba

        from gemrender.beam import damaged_cache_files, is_compiled
        from gemrender.beam.polygons import follow_polygons
    except Exception as error:  # whatever a half-installed numba raises
        detail = f"numba cannot be imported: {error}"
        return Check(name=EXACT_ENGINE, ok=False, detail=detail, cure="pip install numba")
    found = f"numba {numba.__version__}"
    folder = getattr(follow_polygons.stats, "cache_path", None)
    if not folder:
        detail = f"{found}, no folder for its cache can be written, every run compiles again"
        cure = "set NUMBA_CACHE_DIR to a folder that can be written"
        return Check(name=EXACT_ENGINE, ok=True, detail=detail, cure=cure)
    detail = f"{found}, cache in {folder}"
    if damaged := damaged_cache_files():
        detail += f": {len(damaged)} of its files damaged, the first one {Path(damaged[0]).name}"
        cure = f"none is needed, they are compiled again; if that does not last, remove {folder}"
        return Check(name=EXACT_ENGINE, ok=True, detail=detail, cure=cure)
    if not is_compiled():
        detail += ", to be compiled by the first score"
    return Check(name=EXACT_ENGINE, ok=True, detail=detail)

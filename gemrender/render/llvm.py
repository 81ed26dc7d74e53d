"""Finding the LLVM library that Dr.Jit compiles with, without loading it.

LLVM 15 and 16 are refused although Dr.Jit takes them: on a processor with AVX-512 they end the process
(SIGABRT, nothing that Python could catch) at the first kernel with a minimum or a maximum in it.
"""

from __future__ import annotations

import ctypes.util
import functools
import importlib.metadata
import os
import platform
import re
import shlex
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from gemrender.render.cures import backend_error, cure_for_missing, last_words

__all__ = [
    "LLVM_FLOOR",
    "LLVM_VARIABLE",
    "LlvmLibrary",
    "export_line",
    "find_llvm",
    "prepare_llvm",
    "require_loadable",
    "system_folders",
]

#: Lowest major version that gemrender runs with.
LLVM_FLOOR = 17
#: Environment variable that names the library to Dr.Jit.
LLVM_VARIABLE = "DRJIT_LIBLLVM_PATH"
_LLVM_WHEEL = "karellen-llvm-core"
#: Where LLVM is: Homebrew's on either processor, MacPorts'; Debian's, WSL's, Fedora's and SUSE's, Arch's.
_MACOS_FOLDERS = (
    "opt/homebrew/Cellar/llvm*/*/lib",
    "usr/local/Cellar/llvm*/*/lib",
    "opt/local/libexec/llvm-*/lib",
)
_LINUX_FOLDERS = (
    "usr/lib/llvm*/lib",
    "usr/lib/wsl/lib",
    "usr/lib64",
    "usr/lib64/llvm*/lib",
    "usr/local/lib",
    "usr/lib",
)

# libLLVM.so, libLLVM-15.so.1, libLLVM-14.0.6.so, libLLVM.so.23.1, libLLVM-19.dylib; not libLLVMX86.so,
# and not the libLLVM that Rust brings. A lone number behind ".so" is no version of LLVM (libLLVM-15.so.1).
_LLVM_NAME = re.compile(r"libLLVM(?:-(\d+)[\d.]*?)?\.(?:so|dylib)(?:\.(\d+)\.\d+)?[\d.]*|LLVM-C\.dll")
_HOMEBREW_VERSION = re.compile(r"/Cellar/llvm(?:@\d+)?/(\d+)\.")


@dataclass(frozen=True, slots=True, kw_only=True)
class LlvmLibrary:
    """An LLVM shared library that Dr.Jit can use.

    Parameters
    ----------
    path : Path
        The library; a bare file name leaves the search to the system's loader.
    origin : {"DRJIT_LIBLLVM_PATH", "wheel", "system"}
        What named it: the environment variable, the karellen-llvm-core wheel, or a system folder.
    version : int or None
        Major version; None where neither the file's name nor the library itself could tell.
    """

    path: Path
    origin: Literal["DRJIT_LIBLLVM_PATH", "wheel", "system"]
    version: int | None


def find_llvm() -> LlvmLibrary:
    """Find an LLVM library that Dr.Jit can use, without loading it.

    The environment variable DRJIT_LIBLLVM_PATH is final, as it is for Dr.Jit. Without it the wheel
    karellen-llvm-core is taken, and without that the highest version in the system's folders.

    Returns
    -------
    LlvmLibrary
        Of version 17 or newer.

    Raises
    ------
    BackendError
        No such library, or DRJIT_LIBLLVM_PATH names none; with the cure.
    """
    if named := os.environ.get(LLVM_VARIABLE):
        return _llvm_named_by_user(named)
    refused: list[str] = []
    if best := _highest_version(_wheel_paths(), refused):
        return LlvmLibrary(path=best[1], origin="wheel", version=best[0])
    if best := _highest_version(_system_paths(), refused):
        return LlvmLibrary(path=best[1], origin="system", version=best[0])
    found = f"found only {', '.join(refused)}" if refused else "no LLVM library found"
    raise backend_error(f"{found}, and Dr.Jit needs LLVM {LLVM_FLOOR} or newer", _llvm_cure())


def prepare_llvm() -> LlvmLibrary:
    """Name the LLVM library to Dr.Jit, in the environment variable DRJIT_LIBLLVM_PATH.

    Has an effect only before the first import of ``drjit`` or ``mitsuba`` in this process.

    Returns
    -------
    LlvmLibrary
        The library that Dr.Jit will load.

    Raises
    ------
    BackendError
        As `find_llvm`.
    """
    library = find_llvm()
    os.environ[LLVM_VARIABLE] = str(library.path)
    return library


def require_loadable(library: LlvmLibrary) -> None:
    """Load the library in another process.

    Raises
    ------
    BackendError
        It cannot be loaded, as where a library that it needs is missing; with the cure.
    """
    try:
        _asked_version(str(library.path))
    except OSError as error:
        _, cure = cure_for_missing(str(error)) or ("", _llvm_cure())
        raise backend_error(f"Dr.Jit cannot load LLVM {library.path} ({error})", cure) from error


def export_line() -> str:
    """Return the line for a shell (sh, bash, zsh) that names the LLVM library to what the shell starts.

    After ``eval "$(gemrender doctor --export)"`` the program ``mitsuba`` works, as do others' scripts.

    Returns
    -------
    str
        As in ``export DRJIT_LIBLLVM_PATH=/usr/lib/libLLVM.so.19.1``, quoted where the path needs it.

    Raises
    ------
    BackendError
        As `find_llvm` and `require_loadable`.
    """
    library = find_llvm()
    require_loadable(library)
    return f"export {LLVM_VARIABLE}={shlex.quote(str(library.path))}"


def _llvm_named_by_user(named: str) -> LlvmLibrary:
    path, names = Path(named), f"{LLVM_VARIABLE} names {named}, which"
    try:
        if path.name == named:
            _asked_version(named)  # the loader knows where a bare name is: OSError where it does not
        else:
            path = path.resolve()  # the library looks for its own libraries beside the path it is loaded by
            if not path.is_file():
                raise backend_error(f"{names} is no file", _variable_cure())
        version = _major_version(path)
    except OSError as error:
        raise backend_error(f"{names} cannot be loaded ({error})", _variable_cure()) from error
    if version is not None and version < LLVM_FLOOR:
        what = f"LLVM {version}" if version else "an LLVM before 16, or none"
        why = f"below {LLVM_FLOOR} LLVM aborts the process on AVX-512 processors"
        raise backend_error(f"{names} is {what}: {why}", _variable_cure())
    return LlvmLibrary(path=path, origin="DRJIT_LIBLLVM_PATH", version=version)


def _highest_version(paths: Iterable[Path], refused: list[str]) -> tuple[int, Path] | None:
    """Return the highest version from 17 on and its path, the first of equals; note what is refused."""
    best: tuple[int, Path] | None = None
    for path in paths:
        try:
            version = _major_version(path)
        except OSError:
            refused.append(f"{path} (cannot be loaded)")
            continue
        if not version or version < LLVM_FLOOR:
            refused.append(f"{path} ({version or 'version unknown'})")
        elif best is None or version > best[0]:
            best = version, path
    return best


def _major_version(path: Path) -> int | None:
    """Return the major version, from the names (of the file, then of a link to it) or else from the library.

    Returns None where it cannot be told, 0 for an LLVM before 16; raises OSError where it cannot be loaded.
    """
    real = path.resolve()
    for name in (real.name, path.name):
        if (match := _LLVM_NAME.fullmatch(name)) and (version := match[1] or match[2]):
            return int(version)
    if match := _HOMEBREW_VERSION.search(real.as_posix()):
        return int(match[1])
    return _asked_version(str(path))


# LLVMGetVersion came with LLVM 16.
_ASK_VERSION = """
import ctypes, sys
try:
    library = ctypes.CDLL(sys.argv[1])
except OSError as error:
    sys.exit(str(error))
numbers = [ctypes.c_uint() for _ in range(3)]
if get_version := getattr(library, "LLVMGetVersion", None):
    get_version(*map(ctypes.byref, numbers))
print(numbers[0].value)
"""


@functools.cache
def _asked_version(library: str) -> int | None:
    """Ask the library itself, in another process: two LLVMs in one process would share their symbols."""
    if not sys.executable:
        return None
    command = [sys.executable, "-I", "-S", "-c", _ASK_VERSION, library]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    except subprocess.TimeoutExpired:
        return None
    if done.returncode != 0:
        raise OSError(last_words(done))
    return int(done.stdout)


def _wheel_paths() -> Iterator[Path]:
    """Yield the libraries of the karellen-llvm-core wheel (``lib/libLLVM.so.23.1`` under the prefix)."""
    try:
        files = importlib.metadata.files(_LLVM_WHEEL) or []
    except importlib.metadata.PackageNotFoundError:
        return
    for file in files:
        if _LLVM_NAME.fullmatch(file.name) and (path := Path(str(file.locate())).resolve()).is_file():
            yield path


def _system_paths() -> Iterator[Path]:
    """Yield the libraries in the system's folders, each once, then what the loader knows besides."""
    seen = set()
    for folder in system_folders():
        for pattern in ("libLLVM*.so*", "libLLVM*.dylib", "LLVM-C.dll"):
            for path in sorted(folder.glob(pattern)):
                real = path.resolve()
                if _LLVM_NAME.fullmatch(path.name) and real.is_file() and real not in seen:
                    seen.add(real)
                    yield real
    if known := ctypes.util.find_library("LLVM-C" if platform.system() == "Windows" else "LLVM"):
        yield Path(known)


def system_folders(root: Path = Path("/")) -> Iterator[Path]:
    """Yield the folders to search: where Dr.Jit looks, and where the distributions put LLVM.

    Parameters
    ----------
    root : Path
        What the distributions' folders are under.
    """
    system = platform.system()
    variable = {"Windows": "PATH", "Darwin": "DYLD_LIBRARY_PATH"}.get(system, "LD_LIBRARY_PATH")
    yield from (Path(folder) for folder in os.environ.get(variable, "").split(os.pathsep) if folder)
    yield Path(sys.prefix, "Library", "bin") if system == "Windows" else Path(sys.prefix, "lib")  # conda
    if system == "Windows":
        yield Path(os.environ.get("PROGRAMFILES", "C:\\Program Files")) / "LLVM" / "bin"
    elif system == "Darwin":
        for pattern in _MACOS_FOLDERS:
            yield from root.glob(pattern)
    else:
        for pattern in (f"usr/lib/{platform.machine()}-linux-gnu", *_LINUX_FOLDERS):
            yield from root.glob(pattern)


def _llvm_cure() -> str:
    system, machine = platform.system(), platform.machine()
    if system == "Linux":
        return f'pip install "{_LLVM_WHEEL}>=22,<24"' if machine == "x86_64" else "apt-get install libllvm19"
    return "brew install llvm" if system == "Darwin" else "winget install LLVM.LLVM"


def _variable_cure() -> str:
    unset = "set DRJIT_LIBLLVM_PATH=" if platform.system() == "Windows" else f"unset {LLVM_VARIABLE}"
    return f"{unset}, or let it name an LLVM library of version {LLVM_FLOOR} or newer"

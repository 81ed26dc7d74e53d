"""What is missing on this machine, told together with the command that cures it."""

from __future__ import annotations

import contextlib
import re
import signal
import subprocess

from gemrender.errors import BackendError

__all__ = ["backend_error", "cure_for_missing", "found_and_cure", "last_words", "library_cure"]

_CURE = "; to cure it: "  # stands between what was found and the cure in every message
_MISSING_LIBRARY = re.compile(r"(lib[\w+.-]*\.so[\w.]*): cannot open shared object")
_PACKAGES = {"libatomic.so.1": "libatomic1", "libz.so.1": "zlib1g", "libstdc++.so.6": "libstdc++6"}


def backend_error(found: str, cure: str) -> BackendError:
    """Make the error, one line, from what was found and what cures it."""
    return BackendError(" ".join(f"{found}{_CURE}{cure}".split()))


def found_and_cure(error: BackendError) -> tuple[str, str]:
    """Take an error of `backend_error` apart again."""
    found, _, cure = str(error).partition(_CURE)
    return found, cure


def library_cure(library: str) -> str:
    """Return the command that installs a missing library of the system."""
    if package := _PACKAGES.get(library):
        return f"apt-get install {package}"
    return f"install the system's package that holds {library}"


def cure_for_missing(message: str) -> tuple[str, str] | None:
    """Find the library that a loader's message misses; return its name and the cure, or None."""
    missing = _MISSING_LIBRARY.search(message)
    return (missing[1], library_cure(missing[1])) if missing else None


def last_words(done: subprocess.CompletedProcess[str]) -> str:
    """Tell in one line how a process ended that did not end well."""
    lines = done.stderr.strip().splitlines()
    words = next(
        (line for line in lines if line.startswith("LLVM ERROR")), lines[-1] if lines else ""
    ).strip()
    if done.returncode >= 0:
        return words or f"exit status {done.returncode}"
    name = f"signal {-done.returncode}"
    with contextlib.suppress(ValueError):
        name = signal.Signals(-done.returncode).name
    return f"the process was ended by {name}" + (f": {words}" if words else "")

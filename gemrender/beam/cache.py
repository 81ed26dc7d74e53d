"""Compiled kernels on disk: checked when they are read, and made anew when any kernel's source has changed.

numba keeps an index and the machine code of each function beside its source, takes both on trust, and looks
at the function's own file only. Here each file carries a digest: what is empty, cut short or damaged counts
as not there, is compiled again and replaced. And all kernels share one stamp, a digest of all their sources.
"""

from __future__ import annotations

import contextlib
import hashlib
import pickle
from functools import lru_cache
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache, IndexDataCacheFile

import gemrender
from gemrender.optics import fresnel

__all__ = ["KernelCache", "source_stamp"]

_DIGEST = hashlib.sha256
_DIGEST_BYTES = 32


@lru_cache(maxsize=1)
def source_stamp() -> str:
    """Return a digest of what goes into the kernels: their sources, and the numbers that they take over."""
    digest = _DIGEST(gemrender.__version__.encode())
    for path in (*sorted(Path(__file__).parent.rglob("*.py")), Path(fresnel.__file__)):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


class _CheckedFiles(IndexDataCacheFile):  # type: ignore[misc]  # numba has no types
    """The index of a kernel and its machine code, each behind a digest that tells of damage."""

    def _dump(self, obj: Any) -> bytes:
        data: bytes = super()._dump(obj)
        return self._digest(data) + data

    def _digest(self, data: bytes) -> bytes:
        return _DIGEST(self._source_stamp.encode() + data).digest()

    def _checked(self, data: bytes) -> bytes:
        digest, data = data[:_DIGEST_BYTES], data[_DIGEST_BYTES:]
        if digest != self._digest(data):
            raise ValueError("damaged, or of other sources")
        return data

    def _read(self, name: str) -> bytes:
        return self._checked(Path(self._data_path(name)).read_bytes())

    def _load_index(self) -> dict[Any, str]:
        try:
            with Path(self._index_path).open("rb") as file:
                if pickle.load(file) != self._version:
                    return {}
                stamp, overloads = pickle.loads(self._checked(file.read()))
        except Exception:  # whatever pickle makes of a damaged file
            return {}
        return overloads if stamp == self._source_stamp else {}

    def _load_data(self, name: str) -> Any:
        return pickle.loads(self._read(name))

    def holds(self, target: Any) -> bool:
        """Whether machine code for this target is there, whole."""
        try:
            names = [name for key, name in self._load_index().items() if key[1] == target]
            for name in names:
                self._read(name)
        except Exception:
            return False
        return bool(names)

    def damaged(self) -> list[str]:
        """Return the files that are there and not what was written, or cannot be read."""
        index = Path(self._index_path)
        overloads = self._load_index()
        if index.exists() and not overloads:
            return [] if self._is_of_other_sources(index) else [str(index)]
        out = []
        for name in overloads.values():
            try:
                self._read(name)
            except FileNotFoundError:
                continue
            except (OSError, ValueError):
                out.append(self._data_path(name))
        return out

    def _is_of_other_sources(self, index: Path) -> bool:
        """Tell an index of other sources or of another numba, which is in order, from a damaged one."""
        try:
            with index.open("rb") as file:
                if pickle.load(file) != self._version:
                    return True
                data = file.read()
        except Exception:
            return False
        for part in (data[_DIGEST_BYTES:], data):  # ours, and numba's own without a digest
            with contextlib.suppress(Exception):
                stamp, _ = pickle.loads(part)
                return bool(stamp != self._source_stamp)
        return False


class KernelCache(FunctionCache):  # type: ignore[misc]
    """The cache of one kernel.

    Parameters
    ----------
    function : callable
        The kernel's Python function.

    Raises
    ------
    RuntimeError, OSError
        No folder can be written.
    """

    def __init__(self, function: Any) -> None:
        super().__init__(function)
        self._cache_file = _CheckedFiles(self._cache_path, self._impl.filename_base, source_stamp())

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled function, or None where there is none that is whole."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:
            return None  # it is compiled again, and the files are replaced

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled function, where that can be written."""
        with contextlib.suppress(OSError):  # a full disk, a folder that has become read-only
            super().save_overload(sig, data)

    def holds(self, target: Any) -> bool:
        """Whether the kernel is there for a target (numba's `magic_tuple`), whole."""
        return bool(self._cache_file.holds(target))

    def damaged(self) -> list[str]:
        """Return the kernel's files that are damaged or cannot be read."""
        return list(self._cache_file.damaged())

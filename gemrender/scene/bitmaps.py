"""Image files by Mitsuba, on any number of threads.

Mitsuba 3.9.1 reads and writes OpenEXR by threads of Dr.Jit's beside its own, and waits for ever where there
are none: on a machine of one processor, and after ``drjit.set_thread_count(1)``.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

__all__ = ["read_bitmap", "write_bitmap"]


def read_bitmap(path: str | Path) -> Any:
    """Return the image of a file, a ``mi.Bitmap``; raises what Mitsuba does."""
    import mitsuba as mi

    with _another_thread():
        return mi.Bitmap(str(path))


def write_bitmap(bitmap: Any, path: str | Path) -> None:
    """Write a ``mi.Bitmap`` in the format that its file's ending says."""
    with _another_thread():
        bitmap.write(str(path))


@contextmanager
def _another_thread() -> Iterator[None]:
    import drjit as dr

    threads = dr.thread_count()
    if threads < 2:
        dr.set_thread_count(2)
    try:
        yield
    finally:
        if threads < 2:
            dr.set_thread_count(threads)

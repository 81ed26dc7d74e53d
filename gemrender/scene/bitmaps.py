"""Image files by Mitsuba, on any number of threads.

Mitsuba 3.9.1 reads and writes OpenEXR by threads of Dr.Jit's beside its own, and waits for ever where there
are none, as after ``drjit.set_thread_count(1)``. (On a machine of one processor `ensure_variant` makes two.)
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

__all__ = ["another_thread", "read_bitmap", "write_bitmap"]


def read_bitmap(path: str | Path) -> Any:
    """Return the image of a file, a ``mi.Bitmap``; raises what Mitsuba does."""
    import mitsuba as mi

    with another_thread():
        return mi.Bitmap(str(path))


def write_bitmap(bitmap: Any, path: str | Path) -> None:
    """Write a ``mi.Bitmap`` in the format that its file's ending says."""
    with another_thread():
        bitmap.write(str(path))


@contextmanager
def another_thread() -> Iterator[None]:
    """Give Dr.Jit two threads where it has one, for a while: for ``mi.load_file`` with an EXR, say."""
    import drjit as dr

    threads = dr.thread_count()
    if threads < 2:
        dr.set_thread_count(2)
    try:
        yield
    finally:
        if threads < 2:
            dr.set_thread_count(threads)

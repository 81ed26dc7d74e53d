"""What must not happen while a kernel is made."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["instances_held"]


@contextmanager
def instances_held() -> Iterator[None]:
    """Keep Python's garbage collector from taking shapes, lights or surfaces away while a kernel is made.

    A call of a method is made for all instances that there are, those of scenes that nobody holds any more
    among them, and directly where all have one code. Were some collected between two calls of a method, the
    kernel would hold that code twice, once for either kind of call, and Dr.Jit 1.5.0 ends the process:
    "invalid redefinition of function".
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()

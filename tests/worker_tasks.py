"""What processes are given to do in tests; in a module of its own, which they import."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path


def double(number: int) -> tuple[int, int]:
    """Return twice a number, and the process that did it."""
    return 2 * number, os.getpid()


def killed_at_first(folder: Path, number: int) -> int:
    """Return a number; the first process that is given 3 is killed."""
    if number == 3 and not (folder / "killed").exists():
        (folder / "killed").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def killed_always(number: int) -> int:
    """Return a number; whoever is given 3 is killed."""
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def ended(number: int) -> int:
    """End the process."""
    os._exit(number)


def refused(error: Exception, number: int) -> int:
    """Raise an error."""
    raise error


def unsendable(number: int) -> object:
    """Return what cannot be sent."""
    return lambda: number


def busy(folder: Path, seconds: float, number: int) -> int:
    """Say which process this is, by a file of that name; then wait."""
    (folder / str(os.getpid())).touch()
    time.sleep(seconds)
    return number

"""What commands show: progress, tables, JSON, messages."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["patience", "print_json", "progress_bar", "say", "stdout"]

#: Progress is shown of work that takes longer [s].
_PATIENCE = 1.0
#: Least width of a table [characters]: that of a terminal of old.
_LEAST_WIDTH = 80


@contextmanager
def progress_bar(total: int) -> Iterator[Callable[[int, str], Callable[[float], None]]]:
    """Show a bar on a terminal once the work has taken a second; yields a callback for each of its steps."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    bar = Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeRemainingColumn(),
        console=console,
        transient=True,
    )
    task = bar.add_task("", total=total)
    started = time.monotonic()

    def step(number: int, description: str) -> Callable[[float], None]:
        def advance(share: float) -> None:
            bar.update(task, completed=number + share, description=description)
            waited = time.monotonic() - started > _PATIENCE
            if waited and console.is_terminal and not bar.live.is_started:
                bar.start()

        return advance

    try:
        yield step
    finally:
        if bar.live.is_started:
            bar.stop()


@contextmanager
def patience(message: str) -> Iterator[None]:
    """Say something to who sits before a terminal and has waited for a second and more."""
    import threading

    if sys.stderr is None or not sys.stderr.isatty():
        yield
        return
    timer = threading.Timer(1.5 * _PATIENCE, say, [message])
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def stdout() -> Console:
    """Return a console whose tables lose no digit on a narrow terminal, and are never wrapped in a file."""
    from rich.console import Console

    console = Console()
    return Console(width=max(console.width, _LEAST_WIDTH) if console.is_terminal else 1000)


def print_json(value: Any) -> None:
    """Print a value as JSON on stdout."""
    import json

    typer.echo(json.dumps(value, indent=2))  # ASCII, for any encoding that stdout may have


def say(message: str) -> None:
    """Tell people something, on stderr."""
    if sys.stderr is not None:  # closed; print would turn to stdout
        print(message, file=sys.stderr)

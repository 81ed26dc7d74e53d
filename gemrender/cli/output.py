"""What commands show: progress, tables, JSON, messages."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from gemrender.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from gemrender.report.formats import TextTable

__all__ = [
    "PATIENCE_S",
    "named_as",
    "output_file",
    "patience",
    "print_csv",
    "print_json",
    "print_records",
    "progress_bar",
    "renamed",
    "say",
    "stdout",
]

#: Progress is shown of work that takes longer [s].
PATIENCE_S = 1.0
#: Width of tables in a file [characters]: no line is broken.
_UNLIMITED = 100_000


@contextmanager
def progress_bar(total: int) -> Iterator[Callable[[int, str], Callable[[float], None]]]:
    """Show a bar on a terminal once the work has taken a second; yields a callback for each of its steps."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    from gemrender.progress import ProgressLines, TimeLeft, duration_words

    console = Console(stderr=True)
    if not console.is_terminal:
        with ProgressLines(say) as lines:
            yield (
                lambda number, description: lambda share: lines.update((number + share) / total, description)
            )
        return
    left = TimeLeft()
    bar = Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TextColumn("{task.fields[left]}", markup=False),
        console=console,
        transient=True,
    )
    task = bar.add_task("", total=total, left="")
    started = time.monotonic()

    def step(number: int, description: str) -> Callable[[float], None]:
        def advance(share: float) -> None:
            left.update((number + share) / total)
            seconds = left.seconds()
            words = "" if seconds is None else f"about {duration_words(seconds)} left"
            bar.update(task, completed=number + share, description=description, left=words)
            if time.monotonic() - started > PATIENCE_S and not bar.live.is_started:
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
    timer = threading.Timer(1.5 * PATIENCE_S, say, [message])
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def stdout() -> Console:
    """Return a console for tables: as wide as the terminal, and in a file as wide as they are.

    The variable COLUMNS wins over both.
    """
    from rich.console import Console

    console = Console()
    if not console.is_terminal and "COLUMNS" not in os.environ:
        return Console(width=_UNLIMITED)
    return console


def print_json(value: Any) -> None:
    """Print a value as JSON on stdout."""
    from gemrender.report.formats import format_json

    typer.echo(format_json(value))


def print_csv(records: Iterable[Mapping[str, Any]]) -> None:
    """Print records as CSV on stdout, line by line as they come."""
    from gemrender.report.formats import csv_lines

    for line in csv_lines(records):
        typer.echo(line)


def print_records(
    form: str,
    *,
    tables: Callable[[], Sequence[TextTable]],
    records: Callable[[], Iterable[Mapping[str, Any]]],
    values: Callable[[], Any] | None = None,
) -> None:
    """Print results in one of the forms.

    Parameters
    ----------
    form : {"table", "json", "csv", "markdown"}
        The form.
    tables : callable
        Returns tables for people.
    records : callable
        Returns flat records for machines.
    values : callable, optional
        Returns what JSON has instead of the records.
    """
    from gemrender.report.formats import format_markdown, print_tables

    if form == "json":
        print_json((values or (lambda: list(records())))())
    elif form == "csv":
        print_csv(records())
    elif form == "markdown":
        typer.echo(format_markdown(tables()))
    else:
        print_tables(tables(), stdout())


def say(message: str) -> None:
    """Tell people something, on stderr."""
    if sys.stderr is not None:  # closed; print would turn to stdout
        with contextlib.suppress(OSError):  # a terminal that is gone
            print(message, file=sys.stderr)


def renamed(old: str, old_value: Any, new: str, new_value: Any, default: Any) -> tuple[Any, list[str]]:
    """Return an option's value, given by its new name or by its old one, and what is to be said of that."""
    if old_value is None:
        return default if new_value is None else new_value, []
    if new_value is not None:
        raise InputError(f"is the old name of {new}; give one of them", key=old, value=old_value)
    return old_value, [f"gemrender: {old} is called {new} in this command now"]


@contextmanager
def named_as(argument: str) -> Iterator[None]:
    """Tell input errors that come from no file as those of an argument or option."""
    try:
        yield
    except InputError as error:
        if error.source is not None:
            raise
        raise InputError(error.allowed, key=argument, value=error.value) from error


def output_file(out: str, name: str) -> str:
    """Return the file to write: `out`, or the file of that name in it where it is a folder.

    Folders are there already, or end in a slash.
    """
    return str(Path(out, name)) if out.endswith(("/", os.sep)) or Path(out).is_dir() else out

"""The commands `stones` and `doctor`: what is there, and whether it works."""

from __future__ import annotations

import typer

from gemrender.cli.output import stdout

__all__ = ["doctor", "stones"]


def stones() -> None:
    """List the bundled stones."""
    from gemrender.stone import bundled_stones, load_stone

    for name in bundled_stones():
        typer.echo(f"{name:<16} {load_stone(name).name}")


def doctor() -> None:
    """Say what of Mitsuba, Dr.Jit and LLVM was found, and whether gemrender can run here."""
    from gemrender.render.diagnosis import diagnose
    from gemrender.report.doctor import print_doctor

    if not print_doctor(diagnose(), stdout()):
        raise typer.Exit(1)

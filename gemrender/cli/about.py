"""The commands `stones`, `setups`, `materials` and `doctor`: what is there, and whether it works."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from gemrender.cli.gems import complete_materials, complete_setups
from gemrender.cli.groups import command
from gemrender.cli.options import OUTPUT, TableOptions, bundled_names
from gemrender.cli.output import print_records, stdout
from gemrender.cli.values import complete_words, listed
from gemrender.errors import InputError

__all__ = ["doctor", "materials", "setups", "stones"]


def _show_option(words: str, complete: Any) -> Any:
    return typer.Option("--show", metavar="NAME", help=words, autocompletion=complete, rich_help_panel=OUTPUT)


@command
def stones(
    table: TableOptions,
    show: Annotated[
        str | None,
        _show_option("Print the file of one instead, to start from.", complete_words(bundled_names)),
    ] = None,
) -> None:
    """List the bundled stones and their proportions."""
    from gemrender.report.catalogue import stone_records, stone_table

    if show is not None:
        _print_bundled("", show)
        return
    print_records(table.chosen, tables=lambda: [stone_table()], records=stone_records)


@command
def setups(
    table: TableOptions,
    show: Annotated[
        str | None, _show_option("Print the file of one instead, to start from.", complete_setups)
    ] = None,
) -> None:
    """List the set-ups that stones can be pictured in."""
    from gemrender.report.catalogue import setup_records, setup_table

    if show is not None:
        _print_bundled("setups", show)
        return
    print_records(table.chosen, tables=lambda: [setup_table()], records=setup_records)


def _print_bundled(folder: str, name: str) -> None:
    """Print a bundled file as it is."""
    from gemrender.reading import bundled_files

    files = bundled_files(folder)
    if name not in files:
        raise InputError(f"must be one of {listed(name, files)}", key="--show", value=name)
    typer.echo(files[name].read_text(encoding="utf-8"), nl=False)


@command
def materials(
    table: TableOptions,
    show: Annotated[
        str | None, _show_option("Print a file of one instead, to start from.", complete_materials)
    ] = None,
) -> None:
    """List the materials: index, dispersion, density, and where they come from."""
    from gemrender.report.catalogue import material_records, material_table

    print_records(table.chosen, tables=lambda: [material_table()], records=material_records)


@command
def doctor(table: TableOptions) -> None:
    """Say what of Mitsuba, Dr.Jit and LLVM was found, and whether gemrender can run here."""
    from gemrender.render.diagnosis import diagnose
    from gemrender.report.catalogue import check_records, check_table
    from gemrender.report.doctor import print_doctor

    form = table.chosen
    checks = diagnose()
    if form == "table":
        ready = print_doctor(checks, stdout())
    else:
        ready = all(check.ok is not False for check in checks)
        print_records(form, tables=lambda: [check_table(checks)], records=lambda: check_records(checks))
    if not ready:
        raise typer.Exit(1)

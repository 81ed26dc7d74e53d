"""The commands `stones`, `setups`, `materials` and `doctor`: what is there, and whether it works."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import typer

from gemrender.cli.gems import complete_setups
from gemrender.cli.groups import command
from gemrender.cli.options import OUTPUT, TableOptions, bundled_names
from gemrender.cli.output import named_as, print_records, stdout
from gemrender.cli.values import complete_materials, complete_words

__all__ = ["doctor", "materials", "setups", "stones"]


def _show_option(words: str, complete: Any) -> Any:
    return typer.Option("--show", metavar="NAME", help=words, autocompletion=complete, rich_help_panel=OUTPUT)


def _family_names() -> list[str]:
    from gemrender.cuts.families import families

    return list(families())


@command
def stones(
    table: TableOptions,
    show: Annotated[
        str | None,
        _show_option("Print the file of one instead, to start from.", complete_words(bundled_names)),
    ] = None,
    family: Annotated[
        str | None,
        typer.Option(
            "--family",
            metavar="NAME",
            help="Only those of a family, as oval, or a laboratory's word for it.",
            autocompletion=complete_words(_family_names),
        ),
    ] = None,
) -> None:
    """List the bundled stones and their proportions, or those of a family of cuts."""
    from gemrender.report.catalogue import stone_records, stone_table
    from gemrender.templates import stone_template

    if show is not None:
        _print_template(stone_template, show)
        return
    with named_as("--family"):
        print_records(
            table.chosen, tables=lambda: [stone_table(family)], records=lambda: stone_records(family)
        )


@command
def setups(
    table: TableOptions,
    show: Annotated[
        str | None, _show_option("Print the file of one instead, to start from.", complete_setups)
    ] = None,
) -> None:
    """List the set-ups that stones can be pictured in."""
    from gemrender.report.catalogue import setup_records, setup_table
    from gemrender.templates import setup_template

    if show is not None:
        _print_template(setup_template, show)
        return
    print_records(table.chosen, tables=lambda: [setup_table()], records=setup_records)


@command
def materials(
    table: TableOptions,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="MATERIAL",
            help="Names or files of materials, to be told in full; by default all are listed.",
            autocompletion=complete_materials,
        ),
    ] = None,
    show: Annotated[
        str | None, _show_option("Print a file of one instead, to start from.", complete_materials)
    ] = None,
) -> None:
    """List the materials, or tell of some their index by wavelength and what is continued."""
    from gemrender.report.catalogue import material_records, material_table, sheet_table
    from gemrender.templates import material_template

    if show is not None:
        _print_template(material_template, show)
        return
    with named_as("MATERIAL"):
        print_records(
            table.chosen,
            tables=lambda: [sheet_table(names) if names else material_table()],
            records=lambda: material_records(names or ()),
        )


def _print_template(template: Callable[[str], str], name: str) -> None:
    with named_as("--show"):
        typer.echo(template(name), nl=False)


@command
def doctor(
    table: TableOptions,
    export: Annotated[
        bool,
        typer.Option(
            "--export",
            "-e",
            help='Print the line that makes Mitsuba\'s own program work: eval "$(gemrender doctor -e)".',
        ),
    ] = False,
) -> None:
    """Say what of Mitsuba, Dr.Jit and LLVM was found, and whether gemrender can run here."""
    from gemrender.render.diagnosis import diagnose
    from gemrender.render.llvm import export_line
    from gemrender.report.catalogue import check_records, check_table
    from gemrender.report.doctor import print_doctor

    if export:
        typer.echo(export_line())
        return
    form = table.chosen
    checks = diagnose()
    if form == "table":
        passed = print_doctor(checks, stdout())
    else:
        passed = all(check.ok is not False for check in checks)
        print_records(form, tables=lambda: [check_table(checks)], records=lambda: check_records(checks))
    if not passed:
        raise typer.Exit(1)

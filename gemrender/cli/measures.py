"""The command `measures`: what a view can be measured by."""

from __future__ import annotations

from gemrender.cli.groups import command
from gemrender.cli.options import TableOptions
from gemrender.cli.output import print_records

__all__ = ["measures"]


@command
def measures(table: TableOptions) -> None:
    """List the measures: name, version, definition and source."""
    from gemrender.report.catalogue import measure_records, measure_table

    print_records(table.chosen, tables=lambda: [measure_table()], records=measure_records)

"""The command `inspect`."""

from __future__ import annotations

from typing import Annotated

from gemrender.cli.groups import command
from gemrender.cli.options import MaterialOptions, Stones, TableOptions, trace_options
from gemrender.cli.output import print_records
from gemrender.cli.stones import load
from gemrender.cli.values import number_option

__all__ = ["inspect"]


@command
def inspect(
    stones: Stones,
    of: MaterialOptions,
    table: TableOptions,
    size: Annotated[
        float | None,
        number_option(
            "--size",
            "millimetres",
            "Longer side of the outline, or the diameter of a round stone, for its weight; by default what "
            "its file says, else 6.5.",
            metavar="MM",
        ),
    ] = None,
) -> None:
    """Tell what stones are: facets by tier, proportions, symmetry, volume, weight, what was mended."""
    from gemrender.report.inspection import (
        check_size,
        inspect_stone,
        inspection_records,
        inspection_tables,
        inspection_values,
    )

    form = table.chosen
    if size is not None:
        check_size(size)
    loaded = load(stones, trace_options(), material=of.material)
    found = [inspect_stone(stone, size_mm=size) for stone in loaded.stones]
    print_records(
        form,
        tables=lambda: inspection_tables(found),
        values=lambda: [inspection_values(one) for one in found],
        records=lambda: [record for one in found for record in inspection_records(one)],
    )

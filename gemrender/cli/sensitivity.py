"""The command `sensitivity`."""

from __future__ import annotations

from typing import Annotated

from gemrender.cli.groups import command
from gemrender.cli.options import (
    ENGINE,
    EngineOptions,
    MaterialOptions,
    ModelOptions,
    TableOptions,
    ViewOptions,
    output_option,
    prepare_engine,
    trace_options,
    view_and_model,
)
from gemrender.cli.output import print_records, progress_bar, renamed, say
from gemrender.cli.stones import StoneOptions, load
from gemrender.cli.values import number_option

__all__ = ["sensitivity"]

#: Wanted error bound of a derivative [% per unit].
_DEFAULT_BOUND = 0.2


@command
def sensitivity(
    given: StoneOptions,
    of: MaterialOptions,
    model: ModelOptions,
    view: ViewOptions,
    table: TableOptions,
    derivative_bound: Annotated[
        float | None,
        number_option(
            "--derivative-bound",
            "per cent",
            f"Wanted error bound of the derivatives, per unit; {_DEFAULT_BOUND:g} by default.",
            metavar="PERCENT",
            rich_help_panel=ENGINE,
        ),
    ] = None,
    bound: Annotated[
        float | None, number_option("--bound", "per cent", "Old name.", metavar="PERCENT", hidden=True)
    ] = None,
    out: Annotated[str | None, output_option("Where to write a figure for each stone.")] = None,
) -> None:
    """Differentiate Average and Rear by each proportion and angle: exact, moving edges included."""
    from gemrender.beam.sensitivity import check_differentiable
    from gemrender.beam.sensitivity import sensitivity as differentiate
    from gemrender.report.files import file_stems, prepare_folder
    from gemrender.report.sensitivity import sensitivity_records, sensitivity_table, write_sensitivity

    form = table.chosen
    wanted, notes = renamed("--bound", bound, "--derivative-bound", derivative_bound, _DEFAULT_BOUND)
    options = trace_options(EngineOptions(engine="exact", bound=wanted), model, view)
    loaded = load(given.stones, options, given.settings, of.material)
    for stone in loaded.stones:
        check_differentiable(stone)
    prepare_engine(options, loaded.samples, out)
    for words in notes:
        say(words)
    loaded.tell()
    folder = None if out is None else prepare_folder(out)
    found = []
    with progress_bar(len(loaded)) as step:
        for i, (stone, stem) in enumerate(zip(loaded.stones, file_stems(loaded.names), strict=True)):
            at, rules = view_and_model(stone, options)
            progress = step(i, stone.name)
            found.append(differentiate(stone, view=at, model=rules, bound=wanted, progress=progress))
            if folder is not None:
                say(f"written: {write_sensitivity(found[-1], folder, stem)}")
    print_records(
        form,
        tables=lambda: [sensitivity_table(found)],
        values=lambda: [s.to_dict() for s in found],
        records=lambda: [record for s in found for record in sensitivity_records(s)],
    )

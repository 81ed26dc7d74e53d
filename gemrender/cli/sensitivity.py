"""The command `sensitivity`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

import typer

from gemrender.cli.groups import command
from gemrender.cli.options import (
    ENGINE,
    EngineOptions,
    MaterialOptions,
    MeasureOptions,
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
from gemrender.cli.values import choice_option, number_option
from gemrender.errors import InputError

__all__ = ["sensitivity"]

#: Wanted error bound of a derivative [% per unit].
_DEFAULT_BOUND = 0.2
#: Share of the time that derivatives take where cliffs are looked for too.
_FIRST = 0.4


@command
def sensitivity(
    given: StoneOptions,
    of: MaterialOptions,
    model: ModelOptions,
    view: ViewOptions,
    measured: MeasureOptions,
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
    cliffs: Annotated[
        bool,
        typer.Option(
            "--cliffs",
            help="Tell for each parameter the next place to either side where values jump, and by how much.",
        ),
    ] = False,
    reach: Annotated[
        float | None,
        number_option(
            "--reach",
            "per cent or degrees",
            "How far cliffs are looked for; by default 2 % or 1 degree.",
            metavar="REACH",
        ),
    ] = None,
    threshold: Annotated[
        float,
        number_option("--threshold", "per cent", "Smaller jumps are no cliff.", metavar="PERCENT"),
    ] = 0.5,
    meets: Annotated[
        str,
        choice_option(
            "--meets",
            ("free", "loose", "kept"),
            "What becomes of a design's meet points where a tier changes: all else stays; it turns about the "
            "middle of its facets; or other tiers follow, so that they are kept.",
            metavar="HOW",
        ),
    ] = "free",
    out: Annotated[str | None, output_option("Where to write a figure for each stone.")] = None,
) -> None:
    """Differentiate scores by each proportion, angle or tier: exact, moving edges included; tell cliffs."""
    from gemrender.beam.sensitivity import check_differentiable, smooth_measures
    from gemrender.beam.sensitivity import sensitivity as differentiate
    from gemrender.engines import check_head
    from gemrender.report.files import file_stems, prepare_folder
    from gemrender.report.sensitivity import (
        cliffs_table,
        measure_slopes_table,
        sensitivity_records,
        sensitivity_table,
        write_sensitivity,
    )
    from gemrender.sweep.cliffs import check_reach, find_cliffs

    form = table.chosen
    wanted, notes = renamed("--bound", bound, "--derivative-bound", derivative_bound, _DEFAULT_BOUND)
    options = trace_options(EngineOptions(engine="exact", bound=wanted), model, view)
    loaded = load(given.stones, options, given.settings, of.material)
    if (reach is not None or threshold != 0.5) and not cliffs:
        raise InputError("is of cliffs; add --cliffs", key="--threshold" if reach is None else "--reach")
    check_reach(reach, threshold)
    measures, head = smooth_measures(measured.measures or ()), check_head(measured.head)
    for stone in loaded.stones:
        check_differentiable(stone)
    prepare_engine(options, loaded.samples, out)
    for words in notes:
        say(words)
    loaded.tell()
    folder = None if out is None else prepare_folder(out)
    found, near = [], []
    with progress_bar(len(loaded)) as step:
        for i, (stone, stem) in enumerate(zip(loaded.stones, file_stems(loaded.names), strict=True)):
            at, rules = view_and_model(stone, options)
            progress = step(i, stone.name)
            first = _part(progress, 0.0, _FIRST if cliffs else 1.0)
            found.append(
                differentiate(
                    stone,
                    view=at,
                    model=rules,
                    bound=wanted,
                    progress=first,
                    measures=measures,
                    head=head,
                    meets=meets,
                )
            )
            if cliffs:
                near.append(
                    find_cliffs(
                        stone,
                        measures=measures or "inoue",
                        view=at,
                        model=rules,
                        head=head,
                        reach=reach,
                        meets=meets,
                        threshold=threshold,
                        progress=_part(progress, _FIRST, 1.0),
                    )
                )
            if folder is not None:
                say(f"written: {write_sensitivity(found[-1], folder, stem)}")
    print_records(
        form,
        tables=lambda: [
            sensitivity_table(found),
            *([measure_slopes_table(found)] if measures else []),
            *([cliffs_table([s.name for s in found], near)] if cliffs else []),
        ],
        values=lambda: [
            s.to_dict() | ({"cliffs": [of.to_dict() for of in near[i]]} if cliffs else {})
            for i, s in enumerate(found)
        ],
        records=lambda: [
            record
            for i, s in enumerate(found)
            for record in sensitivity_records(s, near[i] if cliffs else None)
        ],
    )


def _part(progress: Callable[[float], None], first: float, last: float) -> Callable[[float], None]:
    """Return what tells the progress of a part of the work, between two shares of it."""
    return lambda share: progress(first + (last - first) * share)

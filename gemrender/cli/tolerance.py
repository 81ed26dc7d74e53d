"""The command `tolerance`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.groups import command
from gemrender.cli.options import (
    DEFAULT_DEVIATION,
    Bound,
    CuttingDeviation,
    EngineOptions,
    MaterialOptions,
    MeasureOptions,
    ModelOptions,
    Resolution,
    TableOptions,
    ViewOptions,
    output_option,
    prepare_engine,
    trace_options,
)
from gemrender.cli.output import print_records
from gemrender.cli.stones import StoneOptions, load
from gemrender.cli.studies import study_each
from gemrender.cli.values import choice_option, number_option, whole_option
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.stone import Stone
    from gemrender.sweep.unknown import Unknown

__all__ = ["tolerance"]

#: Its words are those of `gemrender.sweep.unknown`, which is heavier to import.
_KINDS = ("rounding", "cutting", "scan")
#: What is drawn where nothing else is said [girdle radii]: 20 um of 3.25 mm.
_JITTER = 0.006


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawEngineOptions(EngineOptions):
    """What measures the draws: hundreds of stones, so less finely than a single one."""

    bound: Bound = 0.1
    resolution: Resolution = 256


@command
def tolerance(
    given: StoneOptions,
    engine: DrawEngineOptions,
    of: MaterialOptions,
    model: ModelOptions,
    view: ViewOptions,
    measured: MeasureOptions,
    table: TableOptions,
    unknown: Annotated[
        str | None,
        choice_option(
            "--unknown",
            _KINDS,
            "What is not known: a report's rounding, a cutter's errors, or a scanner's; by default rounding, "
            "of stones without proportions cutting.",
            metavar="WHAT",
        ),
    ] = None,
    steps: Annotated[
        list[str] | None,
        typer.Option(
            "--step",
            metavar="KEY=STEP",
            help="Rounding: the step of a figure in place of a laboratory's, as table=0.1; 0 where it is "
            "known exactly. May be given several times.",
        ),
    ] = None,
    deviation: CuttingDeviation = DEFAULT_DEVIATION,
    depth: Annotated[
        float,
        number_option(
            "--depth",
            "per cent",
            "Cutting: standard deviation of how far facets are off, in per cent of half the length.",
            metavar="PERCENT",
        ),
    ] = 0.0,
    jitter: Annotated[
        float,
        number_option(
            "--jitter",
            "girdle radii",
            "Scan: standard deviation of each coordinate of the 57 vertices, in girdle radii.",
            metavar="RADII",
        ),
    ] = _JITTER,
    draws: Annotated[int, whole_option("--draws", "Number of draws.")] = 200,
    seed: Annotated[int, whole_option("--seed", "Seed of the draws.")] = 1,
    out: Annotated[
        str | None,
        output_option("Where to write the figure and every draw; a study that was stopped goes on there."),
    ] = None,
) -> None:
    """Tell how measures spread under what is not known of stones: rounding, cutting or scan errors."""
    from gemrender.cuts.families.family import Family
    from gemrender.engines import check_head
    from gemrender.measures import chosen_measures
    from gemrender.report.tolerance import tolerance_records, tolerance_table, write_tolerance_figure
    from gemrender.sweep.tolerance import study_tolerance
    from gemrender.sweep.unknown import Cutting, Measuring, Rounding

    form = table.chosen
    options = trace_options(engine, model, view)
    loaded = load(given.stones, options, given.settings, of.material)
    changes = dict(_step(text) for text in steps or ())

    def unknown_of(stone: Stone) -> Unknown:
        is_made = stone.proportions is not None or isinstance(stone.cut, Family)
        kind = unknown or ("rounding" if is_made else "cutting")
        if kind == "rounding":
            return Rounding.of(stone, changes)
        return Cutting(deviation, depth) if kind == "cutting" else Measuring(jitter)

    for stone in loaded.stones:
        unknown_of(stone).check(stone)
    study: dict[str, Any] = {
        "measures": chosen_measures(measured.measures or "inoue"),
        "head": check_head(measured.head),
        "draws": draws,
        "seed": seed,
    }
    prepare_engine(options, loaded.samples, out)
    loaded.tell()
    studies = study_each(
        loaded, "tolerance", out,
        lambda stone, journal, progress: study_tolerance(
            stone, unknown_of(stone), **study, **options, journal=journal, progress=progress
        ),
        write_tolerance_figure,
    )  # fmt: skip
    print_records(
        form,
        tables=lambda: [tolerance_table(studies)],
        values=lambda: [each.to_dict() for each in studies],
        records=lambda: [record for each in studies for record in tolerance_records(each)],
    )


def _step(text: str) -> tuple[str, float]:
    """Read the step of a figure, as table=0.1."""
    key, _, value = (part.strip() for part in text.partition("="))
    try:
        return key.replace("-", "_").lower(), float(value)
    except ValueError:
        raise InputError("must be KEY=STEP, such as table=0.1", key="--step", value=text) from None

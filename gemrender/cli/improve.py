"""The command `improve`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.groups import command
from gemrender.cli.options import (
    DEFAULT_DEVIATION,
    CuttingDeviation,
    EngineOptions,
    Head,
    MaterialOptions,
    ModelOptions,
    OneStone,
    TableOptions,
    output_option,
    prepare_engine,
    trace_options,
)
from gemrender.cli.output import print_records, progress_bar, say
from gemrender.cli.stones import load
from gemrender.cli.values import choice_option, whole_option
from gemrender.engines import DEFAULT_HEAD
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.stone import Stone
    from gemrender.sweep.improve import Improvement
    from gemrender.sweep.unknown import Unknown

__all__ = ["improve"]


@command
def improve(
    stone: OneStone,
    of: MaterialOptions,
    model: ModelOptions,
    table: TableOptions,
    goal: Annotated[
        str,
        typer.Option(
            metavar="EXPRESSION",
            help="What should be large: measures, numbers, + - * / **, min, max, abs, mean and worst over "
            "tilts, spread, volume, yield, carat; as iso - 0.5*leak, worst(inoue, 15), iso - 2*spread(iso).",
        ),
    ],
    vary: Annotated[
        str,
        typer.Option(
            metavar="PARAMETER,...",
            help="What is varied, with commas between: a parameter, or with its range and step, as "
            "crown_angle,pavilion_angle=40:42:0.1; of designs tiers, as 'P1 angle=40:43:0.1,C1 angle'.",
        ),
    ],
    keep: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=LOW:HIGH",
            help="What must stay within a range, as table=54:58; may be given several times.",
        ),
    ] = None,
    within: Annotated[
        str | None,
        choice_option(
            "--within",
            ("rounding", "cutting"),
            "Robust answers: two standard deviations of the goal under rounding or cutting errors count "
            "against it.",
            metavar="WHAT",
        ),
    ] = None,
    deviation: CuttingDeviation = DEFAULT_DEVIATION,
    draws: Annotated[int, whole_option("--draws", "Draws that a spread is taken over.")] = 16,
    answers: Annotated[int, whole_option("--answers", "Most answers; each differs from the others.")] = 3,
    rounds: Annotated[int, whole_option("--rounds", "Most rounds of the search.")] = 40,
    seed: Annotated[int, whole_option("--seed", "Seed of the search.")] = 1,
    head: Head = DEFAULT_HEAD,
    meets: Annotated[
        str | None,
        choice_option(
            "--meets",
            ("kept", "loose"),
            "What becomes of a design's meet points: other tiers follow, so that they are kept, as by "
            "default; or each tier turns about the middle of its facets.",
            metavar="HOW",
        ),
    ] = None,
    rough: Annotated[
        str | None,
        typer.Option(
            metavar="ROUGH",
            help="What the stones are cut from, for goals of yield [%] and carat: box=LENGTHxWIDTHxHEIGHT, "
            "diameter=D (in mm, of the girdle), or mesh=FILE (in mm, the stone's axis along z).",
        ),
    ] = None,
    out: Annotated[
        str | None,
        output_option(
            "Where to write the stones that are found, a page that compares them with the first, and every "
            "stone tried; a search that was stopped goes on there."
        ),
    ] = None,
) -> None:
    """Improve a cut: search its parameters for a goal; several different answers, each a stone file."""
    from gemrender.report.files import file_stems, prepare_folder
    from gemrender.report.improve import improvement_records, improvement_table, improvement_values
    from gemrender.sweep.goals import Goal
    from gemrender.sweep.improve import improve as search
    from gemrender.sweep.ranges import figure_name, ranges_of
    from gemrender.sweep.sized import read_rough
    from gemrender.sweep.unknown import Cutting

    form = table.chosen
    traced = trace_options(EngineOptions(engine="exact", bound=0.1), model)
    chosen_elsewhere = ("engine", "variant", "resolution", "tilt", "tilt_azimuth")
    options = {key: value for key, value in traced.items() if key not in chosen_elsewhere}
    loaded = load([stone], traced, material=of.material)
    if len(loaded) != 1:
        raise InputError(f"is a table of {len(loaded)} stones; one stone is improved", source=stone)
    first = loaded.stones[0]
    kept = {figure_name(first, key): limits for key, limits in map(_limits, keep or ())}
    aim = Goal.parse(f"({goal}) - 2*spread({goal})" if within else goal)
    ranges = ranges_of(first, vary.split(","), kept)
    given = None if rough is None else read_rough(rough)
    unknown: Unknown | None = Cutting(deviation) if within == "cutting" else None
    prepare_engine(traced, loaded.samples, out)
    loaded.tell()
    if given is not None and given.note:
        say(given.note)
    folder = None if out is None else prepare_folder(out)
    stem = file_stems(loaded.names)[0]
    with progress_bar(1) as step:
        advance = step(0, first.name)
        found = search(
            first,
            aim,
            ranges,
            keep=kept,
            unknown=unknown,
            draws=draws,
            answers=answers,
            rounds=rounds,
            seed=seed,
            head=head,
            meets=meets,
            rough=given,
            options=options,
            journal=None if folder is None else folder / f"{stem}-improve.jsonl",
            progress=lambda share, _: advance(share),
        )
    print_records(
        form,
        tables=lambda: [improvement_table(found)],
        values=lambda: [improvement_values(found)],
        records=lambda: improvement_records(found),
    )
    if folder is not None:
        _write(found, first, folder, stem, options)


def _write(found: Improvement, first: Stone, folder: Path, stem: str, options: dict[str, Any]) -> None:
    """Write the stone file of each answer, and a page that compares them with the first stone."""
    from dataclasses import replace

    from gemrender.cuts.stone_file import save_stone_file
    from gemrender.report.page import write_report
    from gemrender.report.studied import study_stone
    from gemrender.sweep.varied import angles_that_followed

    stones = [first]
    for number, answer in enumerate(found.answers, start=1):
        path = folder / f"{stem}-improved-{number}.toml"
        made = replace(answer.stone, name=f"{first.name}, improved {number}")
        save_stone_file(
            made,
            path,
            comments=(
                f"{found.goal.text} = {answer.goal:.4g}, found by gemrender improve",
                *angles_that_followed(first, answer.stone, answer.values),
            ),
        )
        say(f"written: {path}")
        stones.append(made)
    studied = (study_stone(made, measures=found.goal.measures or None, **options) for made in stones)
    say(f"written: {write_report(studied, folder / f'{stem}-improve.html')}")


def _limits(text: str) -> tuple[str, tuple[float, float]]:
    """Read a range that is kept, as table=54:58."""
    key, _, limits = (part.strip() for part in text.partition("="))
    try:
        low, high = (float(cell) for cell in limits.split(":"))
    except ValueError:
        raise InputError("must be KEY=LOW:HIGH, such as table=54:58", key="--keep", value=text) from None
    if not low <= high:
        raise InputError("must have its lower limit first", key="--keep", value=text)
    return key, (low, high)

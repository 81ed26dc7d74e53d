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
    Resolution,
    TableOptions,
    Variant,
    output_option,
    prepare_engine,
    trace_options,
)
from gemrender.cli.output import print_records, progress_bar, say
from gemrender.cli.stones import load
from gemrender.cli.values import choice_option, number_option, whole_option
from gemrender.engines import DEFAULT_HEAD, DEFAULT_VARIANT
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.stone import Stone
    from gemrender.sweep.improve import Front, Improvement
    from gemrender.sweep.unknown import Unknown

__all__ = ["improve"]

#: Pixels a side of what checks answers (`CHECK_RESOLUTION` of `gemrender.sweep.improve.checks`, heavier to
#: import).
_CHECK_RESOLUTION = 256


@command
def improve(
    stone: OneStone,
    of: MaterialOptions,
    model: ModelOptions,
    table: TableOptions,
    goal: Annotated[
        list[str],
        typer.Option(
            metavar="EXPRESSION",
            help="What should be large: measures, numbers, + - * / **, min, max, abs, mean and worst over "
            "tilts, spread, volume, yield, carat; as iso - 0.5*leak, worst(inoue, 15), iso - 2*spread(iso). "
            "Given several times: stones of which none is better by all of them (the Pareto front).",
        ),
    ],
    vary: Annotated[
        str,
        typer.Option(
            metavar="PARAMETER,...",
            help="What is varied, with commas between: a parameter, or with its range and step, as "
            "crown_angle,pavilion_angle=40:42:0.1; a step of 0 is any number; of designs tiers, as "
            "'P1 angle=40:43:0.1,C1 angle'.",
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
    answers: Annotated[
        int | None,
        whole_option("--answers", "Most answers, each unlike the others; by default 3, of several goals 5."),
    ] = None,
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
    reach: Annotated[
        float | None,
        number_option(
            "--reach",
            "per cent or degrees",
            "How far cliffs are looked for beside each answer; by default 2 % or 1 degree.",
            metavar="REACH",
        ),
    ] = None,
    check: Annotated[
        bool,
        typer.Option("--check", help="Have Mitsuba and the reference tell the goal of each answer, too."),
    ] = False,
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = _CHECK_RESOLUTION,
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
    from gemrender.report.improve import improvement_records, improvement_tables, improvement_values
    from gemrender.sweep.improve import SearchInterruptedError, pareto_front
    from gemrender.sweep.improve import improve as search_one
    from gemrender.sweep.improve.checks import Check
    from gemrender.sweep.improve.goals import Goal
    from gemrender.sweep.improve.ranges import figure_name, ranges_of
    from gemrender.sweep.improve.sized import read_rough
    from gemrender.sweep.unknown import Cutting

    form = table.chosen
    traced = trace_options(
        EngineOptions(engine="exact", bound=0.1, variant=variant, resolution=resolution), model
    )
    chosen_elsewhere = ("engine", "variant", "resolution", "tilt", "tilt_azimuth")
    options = {key: value for key, value in traced.items() if key not in chosen_elsewhere}
    loaded = load([stone], traced, material=of.material)
    if len(loaded) != 1:
        raise InputError(f"is a table of {len(loaded)} stones; one stone is improved", source=stone)
    if not check and (variant, resolution) != (DEFAULT_VARIANT, _CHECK_RESOLUTION):
        key = "--variant" if variant != DEFAULT_VARIANT else "--resolution"
        raise InputError("is of the engines that check answers; add --check", key=key)
    first = loaded.stones[0]
    kept = {figure_name(first, key): limits for key, limits in map(_limits, keep or ())}
    aims = [Goal.parse(f"({text}) - 2*spread({text})" if within else text) for text in goal]
    ranges = ranges_of(first, vary.split(","), kept)
    given = None if rough is None else read_rough(rough)
    unknown: Unknown | None = Cutting(deviation) if within == "cutting" else None
    prepare_engine(traced, loaded.samples, out)
    if check:
        prepare_engine(traced, loaded.samples, engine="mitsuba")
    loaded.tell()
    if given is not None and given.note:
        say(given.note)
    folder = None if out is None else prepare_folder(out)
    stem = file_stems(loaded.names)[0]
    found: Improvement | Front
    with progress_bar(1) as step:
        advance = step(0, first.name)
        settings: dict[str, Any] = {
            "keep": kept,
            "unknown": unknown,
            "draws": draws,
            "rounds": rounds,
            "seed": seed,
            "head": head,
            "meets": meets,
            "rough": given,
            **options,
            "journal": None if folder is None else folder / f"{stem}-improve.jsonl",
            "progress": lambda share, _: advance(share),
            "reach": reach,
            "check": Check(variant=variant, resolution=resolution) if check else None,
        } | ({} if answers is None else {"answers": answers})
        is_stopped = False
        try:
            if len(aims) == 1:
                found = search_one(first, aims[0], ranges, **settings)
            else:
                found = pareto_front(first, aims, ranges, **settings)
        except SearchInterruptedError as stopped:
            found, is_stopped = stopped.found, True
    if is_stopped:
        where = "" if folder is None else f"; the same command goes on from {settings['journal']}"
        say(f"gemrender: stopped; these are the best of {found.tried} stones tried{where}")
    print_records(
        form,
        tables=lambda: improvement_tables(found),
        values=lambda: [improvement_values(found)],
        records=lambda: improvement_records(found),
    )
    if folder is not None:
        stones = _write_stones(found, first, folder, stem)
        if not is_stopped:
            _write_page(found, stones, folder, stem, options)
    if is_stopped:
        raise KeyboardInterrupt


def _write_stones(found: Improvement | Front, first: Stone, folder: Path, stem: str) -> list[Stone]:
    """Write the stone file of each answer; return the first stone and them."""
    from dataclasses import replace

    from gemrender.cuts.stone_file import save_stone_file
    from gemrender.sweep.improve.varied import angles_that_followed

    stones = [first]
    for number, answer in enumerate(found.answers, start=1):
        path = folder / f"{stem}-improved-{number}.toml"
        made = replace(answer.stone, name=f"{first.name}, improved {number}")
        goals = zip(found.goals, answer.goals, strict=True)
        comments = (
            *(f"{goal.text} = {value:.4g}, found by gemrender improve" for goal, value in goals),
            *angles_that_followed(first, answer.stone, answer.values),
        )
        save_stone_file(made, path, comments=comments)
        say(f"written: {path}")
        stones.append(made)
    return stones


def _write_page(
    found: Improvement | Front, stones: list[Stone], folder: Path, stem: str, options: dict[str, Any]
) -> None:
    """Write a page that compares the answers with the first stone; of several goals a figure of the front."""
    from gemrender.report.improve import improvement_sections
    from gemrender.report.page import MOST_STONES, write_report
    from gemrender.report.pareto import write_front_figure
    from gemrender.report.studied import study_stone
    from gemrender.sweep.improve import Front

    measures = tuple({of.name: of for goal in found.goals for of in goal.measures}.values())
    figure = None
    if isinstance(found, Front):
        figure = write_front_figure(found, folder / f"{stem}-front.png")
        say(f"written: {figure}")
    if len(stones) > MOST_STONES:
        say(f"gemrender: the page has the first {MOST_STONES} of {len(stones)} stones")
    studied = (study_stone(made, measures=measures or None, **options) for made in stones[:MOST_STONES])
    page = write_report(studied, folder / f"{stem}-improve.html", improvement_sections(found, figure))
    say(f"written: {page}")


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

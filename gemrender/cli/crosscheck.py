"""The command `crosscheck`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.groups import command
from gemrender.cli.options import (
    MODEL,
    AnyStones,
    EngineOptions,
    MaterialOptions,
    ModelOptions,
    Resolution,
    TableOptions,
    Variant,
    ViewOptions,
    prepare_engine,
    trace_options,
)
from gemrender.cli.output import print_records, progress_bar
from gemrender.cli.stones import load
from gemrender.cli.values import complete_words, whole_option
from gemrender.engines import DEFAULT_RESOLUTION, DEFAULT_VARIANT
from gemrender.errors import InputError
from gemrender.reading import did_you_mean

if TYPE_CHECKING:
    from gemrender.stone import Stone

__all__ = ["crosscheck"]

#: Most random stones of a cross-check: days of work.
_MOST_RANDOM = 100_000


def _families() -> list[str]:
    return ["all", *_kinds("all")]


@command
def crosscheck(
    of: MaterialOptions,
    model: ModelOptions,
    view: ViewOptions,
    table: TableOptions,
    stones: AnyStones = None,
    random: Annotated[
        int, whole_option("--random", "Random stones to check besides.", low=0, high=_MOST_RANDOM)
    ] = 0,
    family: Annotated[
        str,
        typer.Option(
            "--family",
            metavar="NAME",
            help="What the random stones are of: a family of cuts, or all of them.",
            autocompletion=complete_words(_families),
        ),
    ] = "",
    seed: Annotated[int, whole_option("--seed", "Seed of the random stones, and of random rays.", low=0)] = 1,
    birefringence: Annotated[
        bool,
        typer.Option(
            help="Whether birefringent stones split light: Mitsuba's mean over random rays, as many as the "
            "map has pixels, against the exact score. Modes are drawn, so no rays are the same.",
            rich_help_panel=MODEL,
        ),
    ] = False,
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = DEFAULT_RESOLUTION,
) -> None:
    """Trace the same rays with all engines; exit status 1 if any differs from the reference."""
    from gemrender.crosscheck import crosscheck as compare
    from gemrender.crosscheck import crosscheck_scores
    from gemrender.engines import observe_alike
    from gemrender.render.backend import ensure_variant
    from gemrender.report.tables import crosscheck_record, crosscheck_tables, score_check_table

    form = table.chosen
    options = trace_options(EngineOptions(variant=variant, resolution=resolution), model, view)
    named = load(stones or [], options, material=of.material)
    loaded = [*named.stones, *_random_stones(random, seed, family, of.material)]
    if not loaded:
        raise InputError("missing: name stones, or ask for some by --random", key="STONE")
    ensure_variant(variant)
    prepare_engine(options, loaded)
    named.tell()
    for key in ("engine", "time_limit", "memory_limit"):
        del options[key]
    checks: list[Any] = []
    with progress_bar(len(loaded)) as step:
        for i, stone in enumerate(loaded):
            if birefringence:
                checks.append(crosscheck_scores(stone, seed=seed, progress=step(i, stone.name), **options))
                continue
            # Nearly all of the time is the reference's.
            truth, *others = observe_alike(stone, progress=step(i, stone.name), **options)
            checks += [compare(other, truth) for other in others]
            del truth, others
    print_records(
        form,
        tables=lambda: [score_check_table(checks)] if birefringence else crosscheck_tables(checks),
        values=lambda: [c.to_dict() for c in checks],
        records=lambda: [crosscheck_record(c) for c in checks],
    )
    if any(c.failures for c in checks):
        raise typer.Exit(1)


def _random_stones(number: int, seed: int, family: str, material: str | float | None) -> list[Stone]:
    """Draw so many round brilliants with the proportions of what is sold, or members of families.

    They are of the material that all stones are of, or of that of their cut.
    """
    from dataclasses import replace

    import numpy as np

    from gemrender.cuts.random import random_brilliant, random_member

    rng = np.random.default_rng(seed)
    kinds = _kinds(family) if family else {"": None}
    stones = []
    with progress_bar(number * len(kinds)) as step:
        for name, kind in kinds.items():
            for i in range(number):
                cut = random_brilliant(rng) if kind is None else random_member(kind, rng)
                stone = cut.stone(name=f"random {name} {seed}.{i + 1}".replace("  ", " "))
                stones.append(stone if material is None else replace(stone, material=material))
                step(len(stones) - 1, "drawing")(1.0)
    return stones


def _kinds(name: str) -> dict[str, Any]:
    """Return the families that can be drawn from, by name: one of them, or all."""
    from gemrender.cuts.families import families
    from gemrender.cuts.families.family import Family

    known = {own: kind for own, kind in families().items() if issubclass(kind, Family)}
    if name == "all":
        return known
    if name not in known:
        allowed = ["all", *known]
        raise InputError(
            f"must be one of {', '.join(allowed)}{did_you_mean(name, allowed)}", key="--family", value=name
        )
    return {name: known[name]}

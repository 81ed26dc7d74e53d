"""The command `crosscheck`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gemrender.cli.groups import command
from gemrender.cli.options import (
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
from gemrender.cli.values import whole_option
from gemrender.engines import DEFAULT_RESOLUTION, DEFAULT_VARIANT
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.stone import Stone

__all__ = ["crosscheck"]

#: Most random stones of a cross-check: days of work.
_MOST_RANDOM = 100_000


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
    seed: Annotated[int, whole_option("--seed", "Seed of the random stones.", low=0)] = 1,
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = DEFAULT_RESOLUTION,
) -> None:
    """Trace the same rays with all engines; exit status 1 if any differs from the reference."""
    from gemrender.crosscheck import crosscheck as compare
    from gemrender.engines import observe_alike
    from gemrender.render.backend import ensure_variant
    from gemrender.report.tables import crosscheck_record, crosscheck_tables

    form = table.chosen
    options = trace_options(EngineOptions(variant=variant, resolution=resolution), model, view)
    named = load(stones or [], options, material=of.material)
    loaded = [*named.stones, *_random_stones(random, seed)]
    if not loaded:
        raise InputError("missing: name stones, or ask for some by --random", key="STONE")
    ensure_variant(variant)
    prepare_engine(options, loaded)
    named.tell()
    for key in ("engine", "time_limit", "memory_limit"):
        del options[key]
    checks = []
    with progress_bar(len(loaded)) as step:
        for i, stone in enumerate(loaded):
            # Nearly all of the time is the reference's.
            truth, *others = observe_alike(stone, progress=step(i, stone.name), **options)
            checks += [compare(other, truth) for other in others]
            del truth, others
    print_records(
        form,
        tables=lambda: crosscheck_tables(checks),
        values=lambda: [c.to_dict() for c in checks],
        records=lambda: [crosscheck_record(c) for c in checks],
    )
    if any(c.failures for c in checks):
        raise typer.Exit(1)


def _random_stones(number: int, seed: int) -> list[Stone]:
    import numpy as np

    from gemrender.cuts.random import random_brilliant
    from gemrender.stone import Stone

    rng = np.random.default_rng(seed)
    stones = []
    with progress_bar(number) as step:
        for i in range(number):
            name = f"random {seed}.{i + 1}"
            stones.append(Stone.from_proportions(random_brilliant(rng), name=name))
            step(i, "drawing")(1.0)
    return stones

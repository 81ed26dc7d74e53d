"""The commands `score` and `crosscheck`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gemrender.cli.options import (
    BOUND,
    RESOLUTION,
    AnyStones,
    Bound,
    Engine,
    Fresnel,
    Intensity,
    Json,
    Out,
    Rear,
    Resolution,
    Stones,
    Tilt,
    TiltAzimuth,
    Variant,
    load,
    prepare_engine,
    trace_options,
    whole,
)
from gemrender.cli.output import print_json, progress_bar, say, stdout
from gemrender.engines import DEFAULT_ENGINE, DEFAULT_VARIANT
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.stone import Stone

__all__ = ["crosscheck", "score"]

#: Most random stones of a cross-check: days of work.
_MOST_RANDOM = 100_000


def score(
    stones: Stones,
    engine: Engine = DEFAULT_ENGINE,
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = "0",
    tilt_azimuth: TiltAzimuth = "0",
    bound: Bound = BOUND,
    as_json: Json = False,
    out: Out = None,
) -> None:
    """Score stones: Average, Rear and the bands of the top view."""
    from gemrender.engines import observe
    from gemrender.score import score as score_stone
    from gemrender.score import score_observation

    options = trace_options(resolution, fresnel, rear, intensity, tilt, tilt_azimuth, bound)
    loaded = load(stones, options)
    prepare_engine(engine, variant, loaded, options["bound"])
    if out is not None:
        from gemrender.report.files import file_stems, prepare_folder, write_observation

        folder, stems = prepare_folder(out), file_stems(stones)
    scores = []
    with progress_bar(len(loaded)) as step:
        for i, stone in enumerate(loaded):
            traced = {"engine": engine, "variant": variant, "progress": step(i, stone.name), **options}
            if out is None:
                scores.append(score_stone(stone, **traced))
                continue
            observation = observe(stone, **traced)
            scores.append(score_observation(observation))
            write_observation(observation, folder, stems[i])
            del observation  # before the next one is made: at 4096 x 4096 its maps take 0.8 GB
    if as_json:
        print_json([s.to_dict() for s in scores])
    else:
        from gemrender.report.tables import print_scores

        print_scores(scores, stdout())
    if out is not None:
        say(f"maps written to {folder}")


def crosscheck(
    stones: AnyStones = None,
    random: Annotated[str, typer.Option(metavar="NUMBER", help="Random stones to check besides.")] = "0",
    seed: Annotated[str, typer.Option(metavar="NUMBER", help="Seed of the random stones.")] = "1",
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = "0",
    tilt_azimuth: TiltAzimuth = "0",
    as_json: Json = False,
) -> None:
    """Trace the same rays with all engines; exit status 1 if any differs from the reference."""
    from gemrender.crosscheck import crosscheck as compare
    from gemrender.engines import observe_alike
    from gemrender.render.backend import ensure_variant

    options = trace_options(resolution, fresnel, rear, intensity, tilt, tilt_azimuth)
    loaded = load(stones or [], options) + _random_stones(random, seed)
    if not loaded:
        raise InputError("missing: name stones, or ask for some by --random", key="STONE")
    ensure_variant(variant)
    prepare_engine("auto", variant, loaded)
    checks = []
    with progress_bar(len(loaded)) as step:
        for i, stone in enumerate(loaded):
            # Nearly all of the time is the reference's.
            truth, *others = observe_alike(stone, variant=variant, progress=step(i, stone.name), **options)
            checks += [compare(other, truth) for other in others]
            del truth, others
    if as_json:
        print_json([c.to_dict() for c in checks])
    else:
        from gemrender.report.tables import print_crosschecks

        print_crosschecks(checks, stdout())
    if any(c.failures for c in checks):
        raise typer.Exit(1)


def _random_stones(number: str, seed: str) -> list[Stone]:
    import numpy as np

    from gemrender.stone import Stone
    from gemrender.stone.random import random_brilliant

    n, start = whole("random", number), whole("seed", seed)
    if not 0 <= n <= _MOST_RANDOM:
        raise InputError(f"must be from 0 to {_MOST_RANDOM}", key="random", value=n)
    if start < 0:
        raise InputError("must not be negative", key="seed", value=start)
    rng = np.random.default_rng(start)
    stones = []
    with progress_bar(n) as step:
        for i in range(n):
            name = f"random {start}.{i + 1}"
            stones.append(Stone.from_proportions(random_brilliant(rng), name=name))
            step(i, "drawing")(1.0)
    return stones

"""The command `compare`."""

from __future__ import annotations

from typing import Annotated

import typer

from gemrender.cli.options import (
    BOUND,
    RESOLUTION,
    Bound,
    Engine,
    Fresnel,
    Intensity,
    Rear,
    Resolution,
    Stones,
    Tilt,
    TiltAzimuth,
    Variant,
    load,
    prepare_engine,
    trace_options,
)
from gemrender.cli.output import progress_bar, say, stdout
from gemrender.engines import DEFAULT_ENGINE, DEFAULT_VARIANT
from gemrender.errors import InputError

__all__ = ["compare"]


def compare(
    stones: Stones,
    form: Annotated[
        str, typer.Option("--format", metavar="table|csv|json|markdown", help="Form of the table.")
    ] = "table",
    out: Annotated[
        str | None,
        typer.Option(metavar="FOLDER", help="Where to write the figures, and the table as CSV and JSON."),
    ] = None,
    engine: Engine = DEFAULT_ENGINE,
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = "0",
    tilt_azimuth: TiltAzimuth = "0",
    bound: Bound = BOUND,
) -> None:
    """Compare stones: a table, the maps side by side, the bands; of two stones their difference too."""
    from gemrender.engines import observe
    from gemrender.report.comparison import FORMATS, format_scores, panel, write_comparison
    from gemrender.report.files import prepare_folder
    from gemrender.score import score, score_observation

    if form not in FORMATS:
        raise InputError(f"must be one of {', '.join(FORMATS)}", key="format", value=form)
    options = trace_options(resolution, fresnel, rear, intensity, tilt, tilt_azimuth, bound)
    loaded = load(stones, options)
    prepare_engine(engine, variant, loaded, options["bound"])
    folder = None if out is None else prepare_folder(out)
    scores, panels, pair = [], [], []
    with progress_bar(len(loaded)) as step:
        for i, stone in enumerate(loaded):
            traced = {"engine": engine, "variant": variant, "progress": step(i, stone.name), **options}
            if folder is None:
                scores.append(score(stone, **traced))
                continue
            observation = observe(stone, **traced)
            scores.append(score_observation(observation))
            panels.append(panel(observation))
            if len(loaded) == 2:
                pair.append(observation)
            del observation
    if form == "table":
        from gemrender.report.tables import print_scores

        print_scores(scores, stdout())
    else:
        typer.echo(format_scores(scores, form))
    if folder is not None:
        for path in write_comparison(panels, pair, folder):
            say(f"written: {path}")

"""The command `report`: stones in a browser, in one file."""

from __future__ import annotations

from typing import Annotated

import typer

from gemrender.cli.options import (
    RESOLUTION,
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
from gemrender.cli.output import progress_bar, say
from gemrender.engines import DEFAULT_ENGINE, DEFAULT_VARIANT

__all__ = ["report"]


def report(
    stones: Stones,
    out: Annotated[
        str, typer.Option("--out", "-o", metavar="FILE", help="The HTML file to write.")
    ] = "report.html",
    engine: Engine = DEFAULT_ENGINE,
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = "0",
    tilt_azimuth: TiltAzimuth = "0",
) -> None:
    """Write a page for the browser: the stones in 3D, their maps, and the ray behind every point."""
    from gemrender.engines import observe
    from gemrender.report.page import check_number, check_target, write_report

    check_number(len(stones))
    options = trace_options(resolution, fresnel, rear, intensity, tilt, tilt_azimuth)
    loaded = load(stones, options)
    check_target(out)
    prepare_engine(engine, variant, loaded)
    with progress_bar(len(loaded)) as step:
        # One after the other: the page keeps less of each than its maps.
        traced = (
            observe(stone, engine=engine, variant=variant, progress=step(i, stone.name), **options)
            for i, stone in enumerate(loaded)
        )
        path = write_report(traced, out)
    say(f"written: {path}")

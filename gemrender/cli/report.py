"""The command `report`: stones in a browser, in one file."""

from __future__ import annotations

from typing import Annotated

from gemrender.cli.groups import command
from gemrender.cli.options import (
    VIEW,
    EngineOptions,
    MaterialOptions,
    MeasureOptions,
    ModelOptions,
    Stones,
    ViewOptions,
    measure_options,
    output_option,
    prepare_engine,
    trace_options,
)
from gemrender.cli.output import output_file, progress_bar, say
from gemrender.cli.stones import load
from gemrender.cli.values import choice_option, number_option

__all__ = ["report"]


@command
def report(
    stones: Stones,
    engine: EngineOptions,
    of: MaterialOptions,
    model: ModelOptions,
    view: ViewOptions,
    measured: MeasureOptions,
    tilts: Annotated[
        float,
        number_option(
            "--tilts",
            "degrees",
            "Measure the stones tilted by up to so much both ways, too: a slider on the page; 0 for none.",
            metavar="DEGREES",
            rich_help_panel=VIEW,
        ),
    ] = 0.0,
    tilt_step: Annotated[
        float,
        number_option("--tilt-step", "degrees", "Steps of --tilts.", metavar="DEGREES", rich_help_panel=VIEW),
    ] = 2.0,
    tilt_axis: Annotated[
        str,
        choice_option(
            "--tilt-axis", ("x", "y"), "Axis that --tilts turns about.", metavar="AXIS", rich_help_panel=VIEW
        ),
    ] = "x",
    out: Annotated[str, output_option("The HTML file to write, or the folder for it.", "FILE")] = (
        "report.html"
    ),
) -> None:
    """Write a page for the browser: the stones in 3D, their maps, and the ray behind every point."""
    from gemrender.report.page import check_number, check_target, write_report
    from gemrender.report.studied import check_tilts, study_stone

    options, measures = trace_options(engine, model, view), measure_options(measured)
    if tilts:
        check_tilts(tilts, tilt_step, options["tilt"])
    loaded = load(stones, options, material=of.material)
    check_number(len(loaded))
    target = output_file(out, "report.html")
    check_target(target)
    prepare_engine(options, loaded.samples)
    loaded.tell()
    with progress_bar(len(loaded)) as step:
        # One after the other: the page keeps less of each than its maps.
        studied = (
            study_stone(
                stone,
                tilts=tilts,
                tilt_step=tilt_step,
                axis=tilt_axis,
                progress=step(i, stone.name),
                **measures,
                **options,
            )
            for i, stone in enumerate(loaded.stones)
        )
        path = write_report(studied, target)
    say(f"written: {path}")

"""The command `report`: stones in a browser, in one file."""

from __future__ import annotations

from typing import Annotated

from gemrender.cli.groups import command
from gemrender.cli.options import (
    EngineOptions,
    MaterialOptions,
    ModelOptions,
    Stones,
    ViewOptions,
    output_option,
    prepare_engine,
    trace_options,
)
from gemrender.cli.output import output_file, progress_bar, say
from gemrender.cli.stones import load

__all__ = ["report"]


@command
def report(
    stones: Stones,
    engine: EngineOptions,
    of: MaterialOptions,
    model: ModelOptions,
    view: ViewOptions,
    out: Annotated[str, output_option("The HTML file to write, or the folder for it.", "FILE")] = (
        "report.html"
    ),
) -> None:
    """Write a page for the browser: the stones in 3D, their maps, and the ray behind every point."""
    from gemrender.engines import observe
    from gemrender.report.page import check_number, check_target, write_report

    options = trace_options(engine, model, view)
    loaded = load(stones, options, material=of.material)
    check_number(len(loaded))
    target = output_file(out, "report.html")
    check_target(target)
    prepare_engine(options, loaded.samples)
    loaded.tell()
    with progress_bar(len(loaded)) as step:
        # One after the other: the page keeps less of each than its maps.
        traced = (
            observe(stone, progress=step(i, stone.name), **options) for i, stone in enumerate(loaded.stones)
        )
        path = write_report(traced, target)
    say(f"written: {path}")

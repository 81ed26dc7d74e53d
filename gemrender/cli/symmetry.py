"""The command `symmetry`."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from gemrender.cli.options import (
    Engine,
    Fresnel,
    Intensity,
    Json,
    Rear,
    Resolution,
    Stones,
    Variant,
    load,
    number,
    prepare_engine,
    trace_options,
    whole,
)
from gemrender.cli.output import print_json, progress_bar, say, stdout
from gemrender.engines import DEFAULT_ENGINE, DEFAULT_VARIANT

__all__ = ["symmetry"]


def symmetry(
    stones: Stones,
    tilt: Annotated[
        str,
        typer.Option(metavar="DEGREES", help="Standard deviation of the angles that facets are tilted by."),
    ] = "0.5",
    jitter: Annotated[
        str,
        typer.Option(
            metavar="RADII",
            help="Jitter the 57 vertices instead: standard deviation of each coordinate, in girdle radii.",
        ),
    ] = "0",
    draws: Annotated[str, typer.Option(metavar="NUMBER", help="Number of draws.")] = "200",
    seed: Annotated[str, typer.Option(metavar="NUMBER", help="Seed of the draws.")] = "1",
    engine: Engine = DEFAULT_ENGINE,
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = "256",
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    as_json: Json = False,
    out: Annotated[
        str | None,
        typer.Option(
            metavar="FOLDER",
            help="Where to write the figure and each draw's scores; a study that was stopped goes on there.",
        ),
    ] = None,
) -> None:
    """Study what poor symmetry does to the scores: facets tilted at random, many times."""
    from gemrender.report.files import file_stems, prepare_folder
    from gemrender.sweep import check_study, study_symmetry

    options = trace_options(resolution, fresnel, rear, intensity, "0", "0")
    loaded = load(stones, options)
    study: dict[str, Any] = {
        "tilt_deg": number("tilt", tilt),
        "jitter": number("jitter", jitter, "girdle radii"),
        "draws": whole("draws", draws),
        "seed": whole("seed", seed),
    }
    check_study(loaded, **study)
    prepare_engine(engine, variant, loaded)
    folder = None if out is None else prepare_folder(out)
    stems = file_stems(stones)
    del options["tilt_deg"], options["tilt_azimuth_deg"]
    options |= {"engine": engine, "variant": variant}
    studies = []
    with progress_bar(len(loaded)) as step:
        for i, stone in enumerate(loaded):
            journal = None if folder is None else folder / f"{stems[i]}-symmetry.jsonl"
            studies.append(
                study_symmetry(stone, **study, options=options, journal=journal, progress=step(i, stone.name))
            )
            if folder is not None:
                from gemrender.report.symmetry import write_symmetry_figure

                say(f"written: {write_symmetry_figure(studies[-1], folder / f'{stems[i]}-symmetry.png')}")
    if as_json:
        print_json([s.to_dict() for s in studies])
    else:
        from gemrender.report.symmetry import print_studies

        print_studies(studies, stdout())

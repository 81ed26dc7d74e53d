"""The command `sensitivity`."""

from __future__ import annotations

from typing import Annotated

import typer

from gemrender.cli.options import (
    RESOLUTION,
    Fresnel,
    Intensity,
    Json,
    Rear,
    Stones,
    Tilt,
    TiltAzimuth,
    load,
    prepare_engine,
    trace_options,
    view_and_model,
)
from gemrender.cli.output import print_json, progress_bar, say, stdout
from gemrender.engines import DEFAULT_VARIANT

__all__ = ["sensitivity"]


def sensitivity(
    stones: Stones,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = "0",
    tilt_azimuth: TiltAzimuth = "0",
    bound: Annotated[
        str, typer.Option(metavar="PERCENT", help="Wanted error bound of the derivatives, per unit.")
    ] = "0.2",
    as_json: Json = False,
    out: Annotated[
        str | None, typer.Option(metavar="FOLDER", help="Where to write a figure for each stone.")
    ] = None,
) -> None:
    """Differentiate Average and Rear by each proportion and angle: exact, moving edges included."""
    from gemrender.beam.sensitivity import check_differentiable
    from gemrender.beam.sensitivity import sensitivity as differentiate
    from gemrender.report.files import file_stems, prepare_folder

    options = trace_options(RESOLUTION, fresnel, rear, intensity, tilt, tilt_azimuth, bound)
    loaded = load(stones, options)
    for stone in loaded:
        check_differentiable(stone)
    prepare_engine("exact", DEFAULT_VARIANT, loaded, options["bound"])
    folder = None if out is None else prepare_folder(out)
    found = []
    with progress_bar(len(loaded)) as step:
        for i, (stone, stem) in enumerate(zip(loaded, file_stems(stones), strict=True)):
            view, model = view_and_model(stone, options)
            progress = step(i, stone.name)
            found.append(
                differentiate(stone, view=view, model=model, bound=options["bound"], progress=progress)
            )
            if folder is not None:
                from gemrender.report.sensitivity import write_sensitivity

                say(f"written: {write_sensitivity(found[-1], folder, stem)}")
    if as_json:
        print_json([s.to_dict() for s in found])
    else:
        from gemrender.report.sensitivity import print_sensitivities

        print_sensitivities(found, stdout())

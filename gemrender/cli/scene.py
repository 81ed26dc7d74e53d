"""The command `scene`."""

from __future__ import annotations

from typing import Annotated

import typer

from gemrender.cli.options import (
    RESOLUTION,
    Fresnel,
    Intensity,
    Rear,
    Resolution,
    Stones,
    Tilt,
    TiltAzimuth,
    Variant,
    load,
    trace_options,
    view_and_model,
)
from gemrender.cli.output import say
from gemrender.engines import DEFAULT_VARIANT

__all__ = ["scene"]


def scene(
    stones: Stones,
    out: Annotated[str, typer.Option(metavar="FOLDER", help="Where to write the XML and PLY files.")],
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = "0",
    tilt_azimuth: TiltAzimuth = "0",
) -> None:
    """Write the scored scene of each stone as Mitsuba XML, its mesh beside it."""
    from gemrender.render.backend import ensure_variant
    from gemrender.report.files import file_stems, prepare_folder
    from gemrender.scene.xml import write_scene

    options = trace_options(resolution, fresnel, rear, intensity, tilt, tilt_azimuth)
    loaded = load(stones, options)
    ensure_variant(variant)
    folder = prepare_folder(out)
    for stone, stem in zip(loaded, file_stems(stones), strict=True):
        say(f"written: {write_scene(folder, stem, stone, *view_and_model(stone, options))}")

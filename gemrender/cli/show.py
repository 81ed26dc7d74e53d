"""The command `show`: displays of stones as files."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Annotated

import typer

from gemrender.cli.options import (
    RESOLUTION,
    Engine,
    Fresnel,
    Intensity,
    Rear,
    Resolution,
    Stones,
    Variant,
    load,
    number,
    prepare_engine,
    trace_options,
    view_and_model,
    whole,
)
from gemrender.cli.output import progress_bar, say
from gemrender.engines import DEFAULT_ENGINE, DEFAULT_VARIANT
from gemrender.errors import BackendError, InputError

if TYPE_CHECKING:
    from gemrender.stone import Stone

__all__ = ["show"]

_WHATS = ("outline", "vertices", "shape", "triangles", "rays", "fan", "map", "facets")
_FORMATS = {
    "png": ("png",),
    "svg": ("svg",),
    "both": ("png", "svg"),
    "pdf": ("pdf",),
    "all": ("png", "svg", "pdf"),
}


def show(
    stones: Stones,
    what: Annotated[
        list[str] | None,
        typer.Option(metavar="|".join((*_WHATS, "all")), help="What to show; may be given several times."),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            metavar="X,Y",
            help="Point of the top view whose ray is shown, in girdle radii; may be given several times. "
            "By default a bright, a weak and a rear ray.",
        ),
    ] = None,
    azimuth: Annotated[
        str,
        typer.Option(
            metavar="DEGREES", help="Azimuth of the fan's section, and to the right in the rays' side view."
        ),
    ] = "0",
    rays: Annotated[str, typer.Option(metavar="NUMBER", help="Rays of the fan.")] = "24",
    colour: Annotated[
        str,
        typer.Option(
            metavar="intensity|reflections|facet",
            help="What the colours of virtual facets tell: intensity, number of reflections, or the kind of "
            "facet that the light comes in through.",
        ),
    ] = "intensity",
    out: Annotated[str, typer.Option(metavar="FOLDER", help="Where to write the pictures.")] = ".",
    form: Annotated[
        str, typer.Option("--format", metavar="|".join(_FORMATS), help="Format of the pictures.")
    ] = "png",
    engine: Engine = DEFAULT_ENGINE,
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
) -> None:
    """Draw stones: outline, vertices, shape, triangles, rays, a fan, the map, virtual facets."""
    # Everything is checked before anything is drawn.
    asked = what or ["all"]
    shown = _displays(asked)
    points = _points(at)
    turn, in_fan = number("azimuth", azimuth), whole("rays", rays)
    options = trace_options(resolution, fresnel, rear, intensity, "0", "0")
    if form not in _FORMATS:
        raise InputError(f"must be one of {', '.join(_FORMATS)}", key="format", value=form)

    from gemrender.report.displays import write_display
    from gemrender.report.displays.rays import check_fan, check_points
    from gemrender.report.facets import check_colour
    from gemrender.report.files import file_stems, prepare_folder

    loaded = load(stones, options)
    if "rays" in shown and points is not None:
        for stone in loaded:
            check_points(stone, points, view_and_model(stone, options)[1])
    check_fan(in_fan)
    check_colour(colour)
    if "map" in shown:
        prepare_engine(engine, variant, loaded)
    if "facets" in asked:
        prepare_engine("exact", variant, loaded)
    folder = prepare_folder(out)
    jobs = [
        (stone, stem, display)
        for stone, stem in zip(loaded, file_stems(stones), strict=True)
        for display in shown
        if display != "facets" or "facets" in asked or _has_facets(stone, variant)
    ]
    with progress_bar(len(jobs)) as step:
        for i, (stone, stem, display) in enumerate(jobs):
            written = write_display(
                stone,
                display,
                folder,
                stem,
                formats=_FORMATS[form],
                at=points,
                azimuth_deg=turn,
                rays=in_fan,
                engine=engine,
                variant=variant,
                resolution=options["resolution"],
                fresnel=fresnel,
                rear=rear,
                intensity=intensity,
                colour=colour,
            )
            step(i, f"{stone.name}: {display}")(1.0)
            for path in written:
                say(f"written: {path}")


def _has_facets(stone: Stone, variant: str) -> bool:
    """Tell whether the stone's virtual facets can be drawn, and say so if not."""
    try:
        prepare_engine("exact", variant, [stone])
    except (InputError, BackendError) as error:
        say(f"virtual facets left out: {error}")
        return False
    return True


def _displays(names: list[str]) -> list[str]:
    for name in names:
        if name not in (*_WHATS, "all"):
            raise InputError(f"must be one of {', '.join(_WHATS)}, all", key="what", value=name)
    return [name for name in _WHATS if name in names or "all" in names]


def _points(texts: list[str] | None) -> list[tuple[float, float]] | None:
    """Read points: one a text, or several with blanks or semicolons between them."""
    if not texts:
        return None
    pairs = []
    for text in texts:
        pairs += re.sub(r"\s*,\s*", ",", text.replace(";", " ")).split() or [text]
    return [_point(pair) for pair in pairs]


def _point(text: str) -> tuple[float, float]:
    allowed = "must be two finite numbers x,y in girdle radii, such as 0.3,-0.1"
    parts = text.split(",")
    if len(parts) != 2:
        raise InputError(allowed, key="at", value=text)
    try:
        x, y = (float(part) for part in parts)
    except ValueError as error:
        raise InputError(allowed, key="at", value=text) from error
    if not (math.isfinite(x) and math.isfinite(y)):
        raise InputError(allowed, key="at", value=text)
    return x, y

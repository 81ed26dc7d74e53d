"""The command `show`: displays of stones as files."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.groups import command
from gemrender.cli.options import (
    OUTPUT,
    EngineOptions,
    MaterialOptions,
    ModelOptions,
    Stones,
    output_option,
    prepare_engine,
    trace_options,
    view_and_model,
)
from gemrender.cli.output import progress_bar, say
from gemrender.cli.stones import load
from gemrender.cli.values import choice_option, number_option, whole_option
from gemrender.errors import BackendError, InputError

if TYPE_CHECKING:
    from gemrender.stone import Stone

__all__ = ["show"]

_DISPLAYS = ("outline", "vertices", "shape", "triangles", "rays", "fan", "map", "facets")
_FORMATS = {
    "png": ("png",),
    "svg": ("svg",),
    "both": ("png", "svg"),
    "pdf": ("pdf",),
    "all": ("png", "svg", "pdf"),
}


@command
def show(
    stones: Stones,
    engine: EngineOptions,
    of: MaterialOptions,
    model: ModelOptions,
    chosen: Annotated[
        list[str] | None,
        choice_option(
            "--what", (*_DISPLAYS, "all"), "What to show; may be given several times.", metavar="DISPLAY"
        ),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            metavar="X,Y",
            help="Point of the top view whose ray is shown, in girdle radii, or half lengths of a stone that "
            "is not round; may be given several times. By default a bright, a weak and a rear ray.",
        ),
    ] = None,
    azimuth: Annotated[
        float,
        number_option(
            "--azimuth",
            "degrees",
            "Azimuth of the fan's section, and to the right in the rays' side view.",
            metavar="DEGREES",
        ),
    ] = 0.0,
    rays: Annotated[int, whole_option("--rays", "Rays of the fan.")] = 24,
    colour: Annotated[
        str,
        choice_option(
            "--colour",
            ("intensity", "reflections", "facet"),
            "What the colours of virtual facets tell: intensity, number of reflections, or the kind of facet "
            "that the light comes in through.",
            metavar="QUANTITY",
        ),
    ] = "intensity",
    form: Annotated[
        str,
        choice_option(
            "--format", _FORMATS, "Format of the pictures.", metavar="FORMAT", rich_help_panel=OUTPUT
        ),
    ] = "png",
    out: Annotated[str, output_option("Where to write the pictures.")] = ".",
) -> None:
    """Draw stones: outline, vertices, shape, triangles, rays, a fan, the map, virtual facets."""
    # Everything is checked before anything is drawn.
    wanted = chosen or ["all"]
    shown = [name for name in _DISPLAYS if name in wanted or "all" in wanted]
    points = _points(at)
    options = trace_options(engine, model)

    from gemrender.report.displays import write_display
    from gemrender.report.displays.rays import check_fan, check_points
    from gemrender.report.files import file_stems, prepare_folder

    loaded = load(stones, options, material=of.material)
    if "rays" in shown and points is not None:
        for stone in loaded.stones:
            check_points(stone, points, view_and_model(stone, options)[1])
    check_fan(rays)
    if "map" in shown:
        prepare_engine(options, loaded.samples, out)
    if "facets" in wanted:
        prepare_engine(options, loaded.samples, out, engine="exact")
    folder = prepare_folder(out)
    loaded.tell()
    jobs = [
        (stone, stem, display)
        for stone, stem in zip(loaded.stones, file_stems(loaded.names), strict=True)
        for display in shown
        if display != "facets" or "facets" in wanted or _has_facets(stone, options)
    ]
    drawn = {key: options[key] for key in ("engine", "variant", "resolution", "fresnel", "rear", "intensity")}
    with progress_bar(len(jobs)) as step:
        for i, (stone, stem, display) in enumerate(jobs):
            written = write_display(
                stone,
                display,
                folder,
                stem,
                formats=_FORMATS[form],
                at=points,
                azimuth_deg=azimuth,
                rays=rays,
                colour=colour,
                **drawn,
            )
            step(i, f"{stone.name}: {display}")(1.0)
            for path in written:
                say(f"written: {path}")


def _has_facets(stone: Stone, options: dict[str, Any]) -> bool:
    """Tell whether the stone's virtual facets can be drawn, and say so if not."""
    try:
        prepare_engine(options, [stone], engine="exact")
    except (InputError, BackendError) as error:
        say(f"virtual facets left out: {error}")
        return False
    return True


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

"""The command `show`: displays of stones as files."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.atlas import MapOptions, show_atlas
from gemrender.cli.groups import command
from gemrender.cli.options import (
    OUTPUT,
    EngineOptions,
    Head,
    MaterialOptions,
    ModelOptions,
    Stones,
    measure_names,
    output_option,
    prepare_engine,
    trace_options,
    view_and_model,
)
from gemrender.cli.output import named_as, progress_bar, say
from gemrender.cli.stones import load
from gemrender.cli.values import choice_option, complete_words, number_option, whole_option
from gemrender.engines import DEFAULT_HEAD
from gemrender.errors import BackendError, InputError

if TYPE_CHECKING:
    from pathlib import Path

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
    of_atlas: MapOptions,
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
            "is not round; may be given several times. By default a bright, a weak and a rear ray. Of an "
            "atlas: where another parameter is fixed, as table=57; by default in its middle.",
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
    measures: Annotated[
        list[str] | None,
        typer.Option(
            "--measure",
            metavar="NAME",
            help="Measure that the map is of, instead of the paper's intensity, or all; may be given several "
            "times. Its EXR file is written too (see: gemrender measures).",
            autocompletion=complete_words(measure_names),
        ),
    ] = None,
    head: Head = DEFAULT_HEAD,
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
    """Draw stones: outline, vertices, shape, triangles, rays, a fan, the map, virtual facets; or an atlas."""
    from gemrender.sweep.atlas.store import is_atlas

    if any(map(is_atlas, stones)):
        show_atlas(stones, of_atlas, measures, at, _FORMATS[form], out)
        return
    for option, value in (("--x", of_atlas.x), ("--y", of_atlas.y), ("--mark", of_atlas.mark)):
        if value:
            raise InputError("is for atlases", key=option, value=value)
    # Everything is checked before anything is drawn.
    wanted = chosen or ["all"]
    shown = [name for name in _DISPLAYS if name in wanted or "all" in wanted]
    points = _points(at)
    options = trace_options(engine, model)
    mapped = _mapped(measures, head, shown)

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
            progress = step(i, f"{stone.name}: {display}")
            if display == "map" and mapped is not None:
                for path in _write_maps(stone, stem, folder, options, mapped | {"progress": progress}, form):
                    say(f"written: {path}")
                continue
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
            progress(1.0)
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


def _mapped(names: list[str] | None, head: float, shown: list[str]) -> dict[str, Any] | None:
    """Name what maps are asked of as `gemrender.measure_maps` does, checked; None for the paper's map."""
    from gemrender.engines import check_head

    check_head(head)
    if not names:
        return None
    from gemrender.measures.maps import mapped_measures

    if "map" not in shown:
        raise InputError("is for the map: --what map", key="--measure", value=names[0])
    with named_as("--measure"):
        return {"measures": mapped_measures("all" if "all" in names else names), "head": head}


def _write_maps(
    stone: Stone, stem: str, folder: Path, options: dict[str, Any], of: dict[str, Any], form: str
) -> list[Path]:
    """Write the maps of measures."""
    from gemrender.mapping import measure_maps
    from gemrender.report.measure_maps import write_measure_maps

    traced = {key: value for key, value in options.items() if key != "bound"}
    return write_measure_maps(measure_maps(stone, **of, **traced), folder, stem, formats=_FORMATS[form])


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

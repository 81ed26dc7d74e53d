"""Arguments and groups of options that commands share: one word, one meaning, everywhere."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.output import patience
from gemrender.cli.values import (
    choice_option,
    complete_files,
    complete_words,
    material_option,
    number_option,
    whole_option,
)
from gemrender.engines import (
    DEFAULT_BOUND,
    DEFAULT_ENGINE,
    DEFAULT_HEAD,
    DEFAULT_MEMORY_LIMIT,
    DEFAULT_RESOLUTION,
    DEFAULT_TIME_LIMIT,
    DEFAULT_VARIANT,
    ENGINES,
    VARIANTS,
)
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.observation import Model, View
    from gemrender.stone import Stone

__all__ = [
    "DEFAULT_DEVIATION",
    "AnyStones",
    "CuttingDeviation",
    "EngineOptions",
    "Head",
    "MaterialOptions",
    "MeasureOptions",
    "ModelOptions",
    "OneStone",
    "Stones",
    "TableOptions",
    "ViewOptions",
    "bundled_names",
    "measure_names",
    "measure_options",
    "output_option",
    "prepare_engine",
    "trace_options",
    "view_and_model",
]

#: Headings of the groups in the help.
ENGINE, MODEL, VIEW, OUTPUT = "Engine", "Model", "View", "Output"

#: Forms of a printed table; `gemrender.report.formats` makes them, which is heavier to import.
_FORMATS = ("table", "json", "csv", "markdown")


# ---- Stones --------------------------------------------------------------------------------------------


def bundled_names() -> list[str]:
    """Return the names of the bundled stones."""
    from gemrender.reading import bundled_files

    return list(bundled_files(""))


_complete_stones = complete_files(
    bundled_names,
    (".toml", ".csv", ".tsv", ".asc", ".gem", ".gcs", ".stl", ".obj", ".ply", ".glb", ".srn"),
)
_STONES_HELP = (
    "Stone files (.toml, .csv, .asc, .gem, .gcs, .stl, .obj, .ply, .glb, .srn), names of bundled stones "
    "(see: gemrender stones), or tables of stones (.csv)."
)
Stones = Annotated[
    list[str], typer.Argument(metavar="STONE", help=_STONES_HELP, autocompletion=_complete_stones)
]
OneStone = Annotated[str, typer.Argument(metavar="STONE", help=_STONES_HELP, autocompletion=_complete_stones)]
AnyStones = Annotated[
    list[str] | None, typer.Argument(metavar="STONE", help=_STONES_HELP, autocompletion=_complete_stones)
]


# ---- Engine --------------------------------------------------------------------------------------------

Engine = Annotated[
    str,
    choice_option(
        "--engine",
        ENGINES,
        "Tracer; auto is exact for convex stones, mitsuba for others.",
        metavar="ENGINE",
        rich_help_panel=ENGINE,
    ),
]
Variant = Annotated[
    str,
    typer.Option(
        metavar="NAME",
        help="Mitsuba variant.",
        autocompletion=complete_words(lambda: VARIANTS),
        rich_help_panel=ENGINE,
    ),
]
Resolution = Annotated[
    int,
    whole_option(
        "--resolution",
        "Pixels a side of the map, 1 to 16384.",
        metavar="PIXELS",
        example="1024",
        rich_help_panel=ENGINE,
    ),
]
Bound = Annotated[
    float,
    number_option(
        "--bound",
        "per cent",
        "Error bound of exact scores, in per cent of the light; 0.0001 to 10.",
        metavar="PERCENT",
        rich_help_panel=ENGINE,
    ),
]


Time = Annotated[
    float,
    number_option(
        "--time",
        "seconds",
        "Time that an exact score may take; past it, it ends with the bound that it has, and says so.",
        metavar="SECONDS",
        rich_help_panel=ENGINE,
    ),
]
Memory = Annotated[
    float,
    number_option(
        "--memory",
        "gibibytes",
        "Memory that it may take, likewise.",
        metavar="GIB",
        rich_help_panel=ENGINE,
    ),
]


@dataclass(frozen=True, slots=True, kw_only=True)
class EngineOptions:
    """What traces the stones, and how finely."""

    engine: Engine = DEFAULT_ENGINE
    variant: Variant = DEFAULT_VARIANT
    resolution: Resolution = DEFAULT_RESOLUTION
    bound: Bound = DEFAULT_BOUND
    time: Time = DEFAULT_TIME_LIMIT
    memory: Memory = DEFAULT_MEMORY_LIMIT


# ---- Model and view ------------------------------------------------------------------------------------

Fresnel = Annotated[
    str | None,
    choice_option(
        "--fresnel",
        ("gubelin", "exact"),
        "Transmittance: the paper's table (diamond only, and its default), or Fresnel's equations.",
        metavar="LAW",
        rich_help_panel=MODEL,
    ),
]
Rear = Annotated[
    str | None,
    choice_option(
        "--rear",
        ("position", "facet", "direction"),
        "Rear light: what came in below the girdle, through a pavilion facet, or from below the horizon; by "
        "default position where the girdle's lower edge is level, else facet.",
        metavar="RULE",
        rich_help_panel=MODEL,
    ),
]
Intensity = Annotated[
    str,
    choice_option(
        "--intensity",
        ("primary", "radiance"),
        "The paper's measure of intensity, or radiance.",
        metavar="MEASURE",
        rich_help_panel=MODEL,
    ),
]
TILT = number_option(
    "--tilt",
    "degrees",
    "Tilt of the eye from the stone's axis, 0 to below 90.",
    metavar="DEGREES",
    rich_help_panel=VIEW,
)
Tilt = Annotated[float, TILT]
TiltAzimuth = Annotated[
    float,
    number_option(
        "--tilt-azimuth",
        "degrees",
        "Azimuth that the eye is tilted to.",
        metavar="DEGREES",
        rich_help_panel=VIEW,
    ),
]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelOptions:
    """The rules that light is followed and counted by."""

    fresnel: Fresnel = None
    rear: Rear = None
    intensity: Intensity = "primary"


@dataclass(frozen=True, slots=True, kw_only=True)
class MaterialOptions:
    """What the stones are made of."""

    material: Annotated[
        Any,
        material_option(
            "Material of all stones (see: gemrender materials), or its refractive index; by default what "
            "their files say.",
            rich_help_panel=MODEL,
        ),
    ] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewOptions:
    """Where the eye is."""

    tilt: Tilt = 0.0
    tilt_azimuth: TiltAzimuth = 0.0


Head = Annotated[
    float,
    number_option(
        "--head",
        "degrees",
        "Half the angle at which the viewer's head is seen from the stone, 0 to below 90.",
        metavar="DEGREES",
        rich_help_panel=VIEW,
    ),
]


def measure_names() -> tuple[str, ...]:
    """Return what may stand for measures: their names, and all."""
    from gemrender.measures import measures

    return ("all", *(measure.name for measure in measures()))


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasureOptions:
    """What else to measure."""

    measures: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,...",
            help="Further measures, with commas between them, or all (see: gemrender measures).",
            autocompletion=complete_words(measure_names),
            rich_help_panel=MODEL,
        ),
    ] = None
    head: Head = DEFAULT_HEAD


# ---- Cutting errors ------------------------------------------------------------------------------------

#: Standard deviation of the angles that facets are tilted by unless another is asked for: good cutting [deg].
DEFAULT_DEVIATION = 0.2

CuttingDeviation = Annotated[
    float,
    number_option(
        "--deviation",
        "degrees",
        "Cutting: standard deviation of the angles that facets are tilted by, 0 to 5.",
        metavar="DEGREES",
    ),
]


# ---- Output --------------------------------------------------------------------------------------------

Format = Annotated[
    str | None,
    choice_option(
        "--format",
        _FORMATS,
        "Form of what is printed; json and csv have every digit.",
        metavar="FORM",
        rich_help_panel=OUTPUT,
    ),
]
Json = Annotated[bool, typer.Option("--json", help="The same as --format json.", rich_help_panel=OUTPUT)]


@dataclass(frozen=True, slots=True, kw_only=True)
class TableOptions:
    """Form of the printed table."""

    form: Format = None
    as_json: Json = False

    @property
    def chosen(self) -> str:
        """The form that was asked for, by either option."""
        if self.as_json and self.form not in (None, "json"):
            raise InputError("is another form than --json", key="--format", value=self.form)
        return "json" if self.as_json else self.form or "table"


def output_option(words: str, metavar: str = "FOLDER") -> Any:
    """Return the option that says where to write: -o and --out in every command."""
    return typer.Option("--out", "-o", metavar=metavar, help=words, rich_help_panel=OUTPUT)


# ---- What commands make of them ------------------------------------------------------------------------


def trace_options(
    engine: EngineOptions | None = None, model: ModelOptions | None = None, view: ViewOptions | None = None
) -> dict[str, Any]:
    """Name the options as `gemrender.observe` does; a group that a command lacks has its defaults."""
    engine, model, view = engine or EngineOptions(), model or ModelOptions(), view or ViewOptions()
    return {
        "engine": engine.engine,
        "variant": engine.variant,
        "resolution": engine.resolution,
        "fresnel": model.fresnel,
        "rear": model.rear,
        "intensity": model.intensity,
        "tilt": view.tilt,
        "tilt_azimuth": view.tilt_azimuth,
        "bound": engine.bound,
        "time_limit": engine.time,
        "memory_limit": engine.memory,
    }


def measure_options(of: MeasureOptions) -> dict[str, Any]:
    """Name the options as `gemrender.score` does, checked.

    Raises
    ------
    InputError
        A measure that there is not, or a head out of range.
    """
    from gemrender.engines import check_head
    from gemrender.measures import chosen_measures

    chosen = None if of.measures is None else chosen_measures(of.measures)
    return {"measures": chosen, "head": check_head(of.head)}


def view_and_model(stone: Stone, options: dict[str, Any]) -> tuple[View, Model]:
    """Return the view and the model that the options make of a stone."""
    from gemrender.request import ShortForms, resolve

    short: Any = {key: options[key] for key in ShortForms.__annotations__ if key in options}
    return resolve(stone, None, None, short)


def prepare_engine(
    options: dict[str, Any], stones: Sequence[Stone], out: str | Path | None = None, engine: str | None = None
) -> None:
    """Check that the engine can trace the stones, and make it ready; say so if that takes a while.

    Parameters
    ----------
    options : dict
        As of `trace_options`.
    stones : sequence of Stone
        What is to be traced.
    out : str or Path, optional
        The folder that results go to: whether it can be written is checked before anything is compiled.
    engine : str, optional
        Another engine than that of the options.
    """
    from gemrender.engines import require_engine

    if out is not None:
        from gemrender.report.files import check_folder

        check_folder(out)
    used = engine or options["engine"]
    limits = {key: options[key] for key in ("bound", "time_limit", "memory_limit")}
    with _patience_with_compiling(used):
        require_engine(used, options["variant"], stones=stones, **limits)


def _patience_with_compiling(engine: str) -> AbstractContextManager[None]:
    """Say that the exact engine is compiled, where it is and that takes a while."""
    if engine in ("auto", "exact"):
        with suppress(ImportError):  # no numba here: told by who needs it
            from gemrender.beam import is_compiled

            if not is_compiled():
                return patience("the exact engine is compiled for this machine, once: about ten seconds")
    return nullcontext()

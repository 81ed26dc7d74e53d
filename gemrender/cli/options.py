"""Arguments and options that commands share, and how they are read."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.output import patience, progress_bar
from gemrender.engines import DEFAULT_BOUND, DEFAULT_RESOLUTION, ENGINES
from gemrender.errors import InputError
from gemrender.reading import did_you_mean

if TYPE_CHECKING:
    from gemrender.observation import Model, View
    from gemrender.stone import Stone

# Numbers come as text and are parsed below, so that a slip in any of them is told in the same form.
_STONES_HELP = "Stone files, or names of bundled stones (see: gemrender stones)."
Stones = Annotated[list[str], typer.Argument(metavar="STONE", help=_STONES_HELP)]
AnyStones = Annotated[list[str] | None, typer.Argument(metavar="STONE", help=_STONES_HELP)]
Engine = Annotated[
    str,
    typer.Option(
        metavar="|".join(ENGINES), help="Tracer; auto is exact for convex stones, mitsuba for others."
    ),
]
Variant = Annotated[str, typer.Option(metavar="NAME", help="Mitsuba variant.")]
Resolution = Annotated[str, typer.Option(metavar="PIXELS", help="Pixels a side of the map.")]
Fresnel = Annotated[
    str | None,
    typer.Option(
        metavar="gubelin|exact",
        help="Transmittance: the paper's table (diamond only), or Fresnel's equations. "
        "By default the table for diamond, and the equations for other stones.",
    ),
]
Rear = Annotated[
    str,
    typer.Option(
        metavar="position|direction",
        help="Rear light: what came in below the girdle, or what came from below the horizon.",
    ),
]
Intensity = Annotated[
    str, typer.Option(metavar="primary|radiance", help="The paper's measure of intensity, or radiance.")
]
Tilt = Annotated[
    str, typer.Option(metavar="DEGREES", help="Tilt of the eye from the stone's axis, 0 to below 90.")
]
TiltAzimuth = Annotated[str, typer.Option(metavar="DEGREES", help="Azimuth that the eye is tilted to.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON array.")]
Out = Annotated[
    str | None, typer.Option(metavar="FOLDER", help="Where to write each stone's maps, as EXR and PNG.")
]

Bound = Annotated[
    str, typer.Option(metavar="PERCENT", help="Error bound of exact scores, in per cent of the light.")
]

RESOLUTION, BOUND = str(DEFAULT_RESOLUTION), str(DEFAULT_BOUND)

#: How the command line calls what errors call by the names of Python's arguments.
ARGUMENTS = {
    "stone": "STONE",
    **{
        key: f"--{key.replace('_', '-')}"
        for key in (
            "engine", "variant", "resolution", "fresnel", "rear", "intensity", "tilt", "tilt_azimuth",
            "random", "seed", "out", "draws", "bound", "jitter", "what", "at", "azimuth", "rays", "colour",
            "format", "setup", "size", "spp", "noise", "time", "material", "carat", "diameter", "exposure",
            "curve", "bins", "range", "frames", "fps", "turn",
        )
    },
}  # fmt: skip


def trace_options(
    resolution: str,
    fresnel: str | None,
    rear: str,
    intensity: str,
    tilt: str,
    tilt_azimuth: str,
    bound: str = BOUND,
) -> dict[str, Any]:
    """Name the options of model and view as `observe` does."""
    return {
        "resolution": whole("resolution", resolution, "such as 1024"),
        "fresnel": fresnel,
        "rear": rear,
        "intensity": intensity,
        "tilt_deg": number("tilt", tilt),
        "tilt_azimuth_deg": number("tilt_azimuth", tilt_azimuth),
        "bound": number("bound", bound, "per cent"),
    }


def prepare_engine(engine: str, variant: str, stones: Iterable[Stone], bound: float = DEFAULT_BOUND) -> None:
    """Check that the engine can trace the stones, before any work begins; say so if that takes a while."""
    from gemrender.engines import require_engine

    with patience("the exact engine is compiled for this machine, once: about ten seconds"):
        require_engine(engine, variant, stones=stones, bound=bound)


def whole(key: str, text: str, hint: str = "") -> int:
    """Read a whole number."""
    try:
        return int(text)
    except ValueError as error:
        allowed = f"must be a whole number{', ' if hint else ''}{hint}"
        raise InputError(allowed, key=key, value=text) from error


def number(key: str, text: str, unit: str = "degrees") -> float:
    """Read a finite number."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError(f"must be a finite number of {unit}", key=key, value=text)
    return number


def load(names: list[str], options: dict[str, Any]) -> list[Stone]:
    """Load all stones, and check the options for each, before any work begins."""
    from gemrender.stone import load_stone

    loaded = []
    with progress_bar(len(names)) as step:
        for i, name in enumerate(names):
            loaded.append(load_stone(name))
            view_and_model(loaded[-1], options)
            step(i, "loading")(1.0)
    return loaded


def view_and_model(stone: Stone, options: dict[str, Any]) -> tuple[View, Model]:
    """Return the view and the model that the options make of a stone."""
    from gemrender.observation import Model, View

    model = Model.of(stone, **{key: options[key] for key in ("fresnel", "rear", "intensity")})
    view = View.of(stone, **{key: options[key] for key in ("resolution", "tilt_deg", "tilt_azimuth_deg")})
    return view, model


def listed(word: str, allowed: Iterable[str]) -> str:
    """List what is allowed, with a guess at what was meant."""
    names = list(allowed)
    return ", ".join(names) + did_you_mean(word, names)

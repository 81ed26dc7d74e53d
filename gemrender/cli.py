"""The command line: parse, call, print. Everything else is imported when a command needs it."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.engines import DEFAULT_ENGINE, DEFAULT_RESOLUTION, DEFAULT_VARIANT, ENGINES
from gemrender.errors import GemrenderError, InputError

if TYPE_CHECKING:
    from rich.console import Console

    from gemrender.stone import Stone

__all__ = ["app", "main"]

#: click's ClickException, wherever this version of typer keeps it.
_USAGE_ERROR: Any = next(c for c in typer.BadParameter.__mro__ if c.__name__ == "ClickException")

#: Progress is shown of work that takes longer [s].
_PATIENCE = 1.0

app = typer.Typer(
    help="See, measure and improve how a cut stone handles light.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

Stones = Annotated[
    list[str], typer.Argument(metavar="STONE...", help="Stone files, or names of bundled stones.")
]
Resolution = Annotated[int, typer.Option(help="Pixels a side of the map.")]
Variant = Annotated[str, typer.Option(help="Mitsuba variant.")]
Fresnel = Annotated[
    str | None,
    typer.Option(help="Transmittance: gubelin (the paper's table, diamond only) or exact. "
                      "By default gubelin for diamond, exact for other stones."),
]  # fmt: skip
Rear = Annotated[
    str,
    typer.Option(help="Rear light: by position (came in below the girdle) or direction (from below)."),
]
Intensity = Annotated[str, typer.Option(help="primary (the paper's measure) or radiance.")]
Tilt = Annotated[float, typer.Option(help="Tilt of the eye from the stone's axis [deg].")]
TiltAzimuth = Annotated[float, typer.Option(help="Azimuth that the eye is tilted to [deg].")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON array.")]
Out = Annotated[Path | None, typer.Option(help="Folder for the maps of each stone, as EXR and PNG.")]


@app.command()
def score(
    stones: Stones,
    engine: Annotated[str, typer.Option(help=f"Tracer: {' or '.join(ENGINES)}.")] = DEFAULT_ENGINE,
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = DEFAULT_RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = 0.0,
    tilt_azimuth: TiltAzimuth = 0.0,
    as_json: Json = False,
    out: Out = None,
) -> None:
    """Score stones: Average, Rear and the bands of the top view."""
    from gemrender.engines import observe
    from gemrender.score import score_observation

    options = _options(variant, resolution, fresnel, rear, intensity, tilt, tilt_azimuth)
    loaded = _load(stones, options)
    if out is not None:
        from gemrender.report.files import file_stems, prepare_folder, write_observation

        prepare_folder(out)
        stems = file_stems(stone.name for stone in loaded)
    scores = []
    with _progress(len(loaded)) as step:
        for i, stone in enumerate(loaded):
            observation = observe(stone, engine=engine, progress=step(i, stone.name), **options)
            scores.append(score_observation(observation))
            if out is not None:
                write_observation(observation, out, stems[i])
    if as_json:
        _print_json([s.to_dict() for s in scores])
    else:
        from gemrender.report.tables import print_scores

        print_scores(scores, _stdout())
    if out is not None:
        _say(f"maps written to {out}")


@app.command()
def crosscheck(
    stones: Annotated[list[str] | None, typer.Argument(metavar="[STONE...]")] = None,
    random: Annotated[int, typer.Option(help="Random stones to check besides.")] = 0,
    seed: Annotated[int, typer.Option(help="Seed of the random stones.")] = 1,
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = DEFAULT_RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = 0.0,
    tilt_azimuth: TiltAzimuth = 0.0,
    as_json: Json = False,
) -> None:
    """Trace the same rays with Mitsuba and with the reference; exit status 1 if they differ."""
    from gemrender.crosscheck import crosscheck as compare
    from gemrender.engines import observe

    options = _options(variant, resolution, fresnel, rear, intensity, tilt, tilt_azimuth)
    loaded = _load(stones or [], options) + _random_stones(random, seed)
    if not loaded:
        raise InputError("name at least one stone, or ask for some by --random", source="crosscheck")
    checks = []
    with _progress(len(loaded)) as step:
        for i, stone in enumerate(loaded):
            by_mitsuba = observe(stone, engine="mitsuba", **options)
            # Nearly all of the time is the reference's.
            by_reference = observe(stone, engine="reference", progress=step(i, stone.name), **options)
            checks.append(compare(by_mitsuba, by_reference))
    if as_json:
        _print_json([c.to_dict() for c in checks])
    else:
        from gemrender.report.tables import print_crosschecks

        print_crosschecks(checks, _stdout())
    if any(c.failures for c in checks):
        raise typer.Exit(1)


@app.command()
def scene(
    stones: Stones,
    out: Annotated[Path, typer.Option(help="Folder for the XML and PLY files.")],
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = DEFAULT_RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
) -> None:
    """Write the scored scene of each stone as Mitsuba XML, its mesh beside it."""
    from gemrender.observation import Model, View
    from gemrender.render.backend import ensure_variant
    from gemrender.report.files import file_stems, prepare_folder
    from gemrender.scene.xml import write_scene

    loaded = _load(stones, _options(variant, resolution, fresnel, rear, intensity, 0.0, 0.0))
    prepare_folder(out)
    ensure_variant(variant)
    stems = file_stems(Path(given).stem for given in stones)
    for stone, stem in zip(loaded, stems, strict=True):
        model = Model.of(stone, fresnel=fresnel, rear=rear, intensity=intensity)
        _say(f"written: {write_scene(out, stem, stone, View.of(stone, resolution), model)}")


@app.command()
def stones() -> None:
    """List the bundled stones."""
    from gemrender.stone import bundled_stones, load_stone

    for name in bundled_stones():
        typer.echo(f"{name:<16} {load_stone(name).name}")


@app.command()
def doctor() -> None:
    """Say what of Mitsuba, Dr.Jit and LLVM was found, and whether gemrender can run here."""
    from gemrender.render.diagnosis import diagnose
    from gemrender.report.doctor import print_doctor

    if not print_doctor(diagnose(), _stdout()):
        raise typer.Exit(1)


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; errors are one line on stderr, and the exit status is theirs."""
    raise SystemExit(_run(arguments))


def _run(arguments: list[str] | None) -> int:
    try:
        return int(app(arguments, standalone_mode=False) or 0)
    except InputError as error:
        if error.source is None and error.key is not None:  # an option of this command
            error = InputError(error.allowed, key=f"--{error.key.replace('_', '-')}", value=error.value)
        _say(f"gemrender: {error}")
        return error.exit_status
    except GemrenderError as error:
        _say(f"gemrender: {' '.join(str(error).split())}")
        return error.exit_status
    except _USAGE_ERROR as error:
        _say(f"gemrender: {' '.join(error.format_message().split())}")
        return 2
    except (KeyboardInterrupt, typer.Abort):
        _say("gemrender: interrupted")
        return 130
    except BrokenPipeError:
        return 1


@app.callback(invoke_without_command=True)
def _version(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    if version:
        import gemrender

        typer.echo(gemrender.__version__)
        raise typer.Exit


def _options(
    variant: str,
    resolution: int,
    fresnel: str | None,
    rear: str,
    intensity: str,
    tilt: float,
    tilt_azimuth: float,
) -> dict[str, Any]:
    """Name the options as `observe` does."""
    return {
        "variant": variant,
        "resolution": resolution,
        "fresnel": fresnel,
        "rear": rear,
        "intensity": intensity,
        "tilt_deg": tilt,
        "tilt_azimuth_deg": tilt_azimuth,
    }


def _load(names: list[str], options: dict[str, Any]) -> list[Stone]:
    """Load all stones, and check the options for each, before any work begins."""
    from gemrender.observation import Model, View
    from gemrender.stone import load_stone

    loaded = [load_stone(name) for name in names]
    for stone in loaded:
        Model.of(stone, **{key: options[key] for key in ("fresnel", "rear", "intensity")})
        View.of(stone, **{key: options[key] for key in ("resolution", "tilt_deg", "tilt_azimuth_deg")})
    return loaded


def _random_stones(number: int, seed: int) -> list[Stone]:
    import numpy as np

    from gemrender.stone import Stone
    from gemrender.stone.random import random_brilliant

    if not 0 <= number <= 100_000:
        raise InputError("must be from 0 to 100000", key="random", value=number)
    if seed < 0:
        raise InputError("must not be negative", key="seed", value=seed)
    rng = np.random.default_rng(seed)
    return [
        Stone.from_proportions(random_brilliant(rng), name=f"random {seed}.{i + 1}") for i in range(number)
    ]


@contextmanager
def _progress(total: int) -> Iterator[Callable[[int, str], Callable[[float], None]]]:
    """Show a bar on stderr once the work has taken a second; yields a callback for each of its steps."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    task = bar.add_task("", total=total)
    started = time.monotonic()

    def step(number: int, description: str) -> Callable[[float], None]:
        def advance(share: float) -> None:
            bar.update(task, completed=number + share, description=description)
            if not bar.live.is_started and time.monotonic() - started > _PATIENCE:
                bar.start()

        return advance

    try:
        yield step
    finally:
        bar.stop()


def _stdout() -> Console:
    from rich.console import Console

    console = Console()
    return console if console.is_terminal else Console(width=120)


def _print_json(value: Any) -> None:
    import json

    typer.echo(json.dumps(value, indent=2, ensure_ascii=False))


def _say(message: str) -> None:
    print(message, file=sys.stderr)

"""The command line: parse, call, print. Everything else is imported when a command needs it."""

from __future__ import annotations

import difflib
import math
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from gemrender.engines import DEFAULT_ENGINE, DEFAULT_RESOLUTION, DEFAULT_VARIANT, ENGINES
from gemrender.errors import GemrenderError, InputError

if TYPE_CHECKING:
    from rich.console import Console

    from gemrender.observation import Model, View
    from gemrender.stone import Stone

__all__ = ["app", "main"]

#: click's errors, wherever this version of typer keeps them.
_click: Any = sys.modules[typer.BadParameter.__module__]

#: Progress is shown of work that takes longer [s].
_PATIENCE = 1.0
#: Least width of a table [characters]: that of a terminal of old.
_LEAST_WIDTH = 80
#: Most random stones of a cross-check: days of work.
_MOST_RANDOM = 100_000


class _Commands(TyperGroup):
    """The commands; an unknown one is refused in gemrender's form."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if args[0] not in self.commands:
            raise InputError(
                f"must be one of {_listed(args[0], self.commands)}", key="COMMAND", value=args[0]
            )
        return super().resolve_command(ctx, args)


app = typer.Typer(
    cls=_Commands,
    help="See, measure and improve how a cut stone handles light.",
    context_settings={"help_option_names": ["-h", "--help"]},
    add_completion=False,
    pretty_exceptions_enable=False,
)

# Numbers come as text and are parsed below, so that a slip in any of them is told in the same form.
_STONES_HELP = "Stone files, or names of bundled stones (see: gemrender stones)."
Stones = Annotated[list[str], typer.Argument(metavar="STONE", help=_STONES_HELP)]
AnyStones = Annotated[list[str] | None, typer.Argument(metavar="STONE", help=_STONES_HELP)]
Engine = Annotated[str, typer.Option(metavar="|".join(ENGINES), help="Tracer.")]
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

_RESOLUTION = str(DEFAULT_RESOLUTION)

#: How the command line calls what errors call by the names of Python's arguments.
_ARGUMENTS = {
    "stone": "STONE",
    **{
        key: f"--{key.replace('_', '-')}"
        for key in (
            "engine", "variant", "resolution", "fresnel", "rear", "intensity", "tilt", "tilt_azimuth",
            "random", "seed", "out",
        )
    },
}  # fmt: skip


@app.command()
def score(
    stones: Stones,
    engine: Engine = DEFAULT_ENGINE,
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = _RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = "0",
    tilt_azimuth: TiltAzimuth = "0",
    as_json: Json = False,
    out: Out = None,
) -> None:
    """Score stones: Average, Rear and the bands of the top view."""
    from gemrender.engines import observe, require_engine
    from gemrender.score import score_observation

    options = _options(resolution, fresnel, rear, intensity, tilt, tilt_azimuth)
    loaded = _load(stones, options)
    require_engine(engine, variant)
    if out is not None:
        from gemrender.report.files import file_stems, prepare_folder, write_observation

        folder, stems = prepare_folder(out), file_stems(stones)
    scores = []
    with _progress(len(loaded)) as step:
        for i, stone in enumerate(loaded):
            progress = step(i, stone.name)
            observation = observe(stone, engine=engine, variant=variant, progress=progress, **options)
            scores.append(score_observation(observation))
            if out is not None:
                write_observation(observation, folder, stems[i])
            del observation  # before the next one is made: at 4096 x 4096 its maps take 0.8 GB
    if as_json:
        _print_json([s.to_dict() for s in scores])
    else:
        from gemrender.report.tables import print_scores

        print_scores(scores, _stdout())
    if out is not None:
        _say(f"maps written to {folder}")


@app.command()
def crosscheck(
    stones: AnyStones = None,
    random: Annotated[str, typer.Option(metavar="NUMBER", help="Random stones to check besides.")] = "0",
    seed: Annotated[str, typer.Option(metavar="NUMBER", help="Seed of the random stones.")] = "1",
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = _RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = "0",
    tilt_azimuth: TiltAzimuth = "0",
    as_json: Json = False,
) -> None:
    """Trace the same rays with Mitsuba and with the reference; exit status 1 if they differ."""
    from gemrender.crosscheck import crosscheck as compare
    from gemrender.engines import observe, require_engine

    options = _options(resolution, fresnel, rear, intensity, tilt, tilt_azimuth)
    loaded = _load(stones or [], options) + _random_stones(random, seed)
    if not loaded:
        raise InputError("missing: name stones, or ask for some by --random", key="STONE")
    require_engine("mitsuba", variant)
    checks = []
    with _progress(len(loaded)) as step:
        for i, stone in enumerate(loaded):
            by_mitsuba = observe(stone, engine="mitsuba", variant=variant, **options)
            # Nearly all of the time is the reference's.
            by_reference = observe(stone, engine="reference", progress=step(i, stone.name), **options)
            checks.append(compare(by_mitsuba, by_reference))
            del by_mitsuba, by_reference
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
    out: Annotated[str, typer.Option(metavar="FOLDER", help="Where to write the XML and PLY files.")],
    variant: Variant = DEFAULT_VARIANT,
    resolution: Resolution = _RESOLUTION,
    fresnel: Fresnel = None,
    rear: Rear = "position",
    intensity: Intensity = "primary",
    tilt: Tilt = "0",
    tilt_azimuth: TiltAzimuth = "0",
) -> None:
    """Write the scored scene of each stone as Mitsuba XML, its mesh beside it."""
    from gemrender.engines import require_engine
    from gemrender.report.files import file_stems, prepare_folder
    from gemrender.scene.xml import write_scene

    options = _options(resolution, fresnel, rear, intensity, tilt, tilt_azimuth)
    loaded = _load(stones, options)
    require_engine("mitsuba", variant)
    folder = prepare_folder(out)
    for stone, stem in zip(loaded, file_stems(stones), strict=True):
        _say(f"written: {write_scene(folder, stem, stone, *_view_and_model(stone, options))}")


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


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run the command line; errors are one line on stderr, and the exit status is theirs."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a terminal that lacks a letter shows a question mark
            stream.reconfigure(errors="replace")
    raise SystemExit(_run(arguments))


def _run(arguments: list[str] | None) -> int:
    try:
        status = int(app(arguments, standalone_mode=False) or 0)
    except InputError as error:
        return _fail(_as_argument(error))
    except GemrenderError as error:
        return _fail(error)
    except _click.UsageError as error:
        return _fail(_usage_error(error))
    except (KeyboardInterrupt, typer.Abort):
        status = 130
    except BrokenPipeError:  # the reader has seen enough
        return 1
    except OSError as error:  # a full disk behind stdout, for one
        return _fail(GemrenderError(f"input or output failed: {error.strerror or error}"))
    except MemoryError:
        return _fail(GemrenderError("out of memory; a smaller --resolution needs less"))
    if status == 130:  # typer makes an exit of an interruption
        _say("gemrender: interrupted")
    return status


def _fail(error: GemrenderError) -> int:
    _say(f"gemrender: {' '.join(str(error).split())}")
    return error.exit_status


def _as_argument(error: InputError) -> InputError:
    """Tell an error that came from no file as one of the command line's arguments and options."""
    if error.source is not None or error.key not in _ARGUMENTS:
        return error
    return InputError(error.allowed, key=_ARGUMENTS[error.key], value=error.value)


def _usage_error(error: Any) -> InputError:
    """Tell one of click's errors as: option or argument, what is wrong, what is allowed."""
    context = error.ctx
    if isinstance(error, _click.NoSuchOption):
        options = [name for param in context.command.get_params(context) for name in param.opts]
        allowed = _listed(error.option_name, (name for name in options if name.startswith("--")))
        return InputError(f"unknown option; must be one of {allowed}", key=error.option_name)
    if isinstance(error, _click.MissingParameter):
        param = error.param
        name = param.metavar if param.param_type_name == "argument" else param.opts[0]
        return InputError(f"missing: {_as_clause(param.help or 'is required')}", key=name)
    if isinstance(error, _click.BadOptionUsage):
        # click says: Option '--name' requires an argument.
        said = error.message.partition("' ")[2] or error.message
        return InputError(_as_clause(said), key=error.option_name)
    return InputError(_as_clause(error.format_message()), key=context.command.name if context else None)


def _as_clause(sentence: str) -> str:
    return sentence[:1].lower() + sentence[1:].rstrip(".")


def _listed(word: str, allowed: Iterable[str]) -> str:
    """List what is allowed, with a guess at what was meant."""
    names = list(allowed)
    close = difflib.get_close_matches(word, names, n=1)
    return ", ".join(names) + (f"; did you mean {close[0]}?" if close else "")


@app.callback(invoke_without_command=True)
def _start(
    ctx: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    if version:
        import gemrender

        typer.echo(gemrender.__version__)
        raise typer.Exit
    if ctx.invoked_subcommand is None:
        typer.echo(ctx.get_help())
        group: Any = ctx.command
        raise InputError(f"missing: one of {', '.join(group.commands)}", key="COMMAND")


def _options(
    resolution: str, fresnel: str | None, rear: str, intensity: str, tilt: str, tilt_azimuth: str
) -> dict[str, Any]:
    """Name the options of model and view as `observe` does."""
    return {
        "resolution": _whole("resolution", resolution, "such as 1024"),
        "fresnel": fresnel,
        "rear": rear,
        "intensity": intensity,
        "tilt_deg": _number("tilt", tilt),
        "tilt_azimuth_deg": _number("tilt_azimuth", tilt_azimuth),
    }


def _whole(key: str, text: str, hint: str = "") -> int:
    try:
        return int(text)
    except ValueError as error:
        allowed = f"must be a whole number{', ' if hint else ''}{hint}"
        raise InputError(allowed, key=key, value=text) from error


def _number(key: str, text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise InputError("must be a finite number of degrees", key=key, value=text)
    return number


def _load(names: list[str], options: dict[str, Any]) -> list[Stone]:
    """Load all stones, and check the options for each, before any work begins."""
    from gemrender.stone import load_stone

    loaded = []
    with _progress(len(names)) as step:
        for i, name in enumerate(names):
            loaded.append(load_stone(name))
            _view_and_model(loaded[-1], options)
            step(i, "loading")(1.0)
    return loaded


def _view_and_model(stone: Stone, options: dict[str, Any]) -> tuple[View, Model]:
    from gemrender.observation import Model, View

    model = Model.of(stone, **{key: options[key] for key in ("fresnel", "rear", "intensity")})
    view = View.of(stone, **{key: options[key] for key in ("resolution", "tilt_deg", "tilt_azimuth_deg")})
    return view, model


def _random_stones(number: str, seed: str) -> list[Stone]:
    import numpy as np

    from gemrender.stone import Stone
    from gemrender.stone.random import random_brilliant

    n, start = _whole("random", number), _whole("seed", seed)
    if not 0 <= n <= _MOST_RANDOM:
        raise InputError(f"must be from 0 to {_MOST_RANDOM}", key="random", value=n)
    if start < 0:
        raise InputError("must not be negative", key="seed", value=start)
    rng = np.random.default_rng(start)
    stones = []
    with _progress(n) as step:
        for i in range(n):
            name = f"random {start}.{i + 1}"
            stones.append(Stone.from_proportions(random_brilliant(rng), name=name))
            step(i, "drawing")(1.0)
    return stones


@contextmanager
def _progress(total: int) -> Iterator[Callable[[int, str], Callable[[float], None]]]:
    """Show a bar on a terminal once the work has taken a second; yields a callback for each of its steps."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    bar = Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeRemainingColumn(),
        console=console,
        transient=True,
    )
    task = bar.add_task("", total=total)
    started = time.monotonic()

    def step(number: int, description: str) -> Callable[[float], None]:
        def advance(share: float) -> None:
            bar.update(task, completed=number + share, description=description)
            waited = time.monotonic() - started > _PATIENCE
            if waited and console.is_terminal and not bar.live.is_started:
                bar.start()

        return advance

    try:
        yield step
    finally:
        if bar.live.is_started:
            bar.stop()


def _stdout() -> Console:
    """Return a console whose tables lose no digit on a narrow terminal, and are never wrapped in a file."""
    from rich.console import Console

    console = Console()
    return Console(width=max(console.width, _LEAST_WIDTH) if console.is_terminal else 1000)


def _print_json(value: Any) -> None:
    import json

    typer.echo(json.dumps(value, indent=2))  # ASCII, for any encoding that stdout may have


def _say(message: str) -> None:
    if sys.stderr is not None:  # closed; print would turn to stdout
        print(message, file=sys.stderr)

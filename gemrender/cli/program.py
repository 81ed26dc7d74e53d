"""The commands put together; errors told in one line."""

from __future__ import annotations

import contextlib
import errno
import io
import logging
import os
import sys
import warnings
from collections.abc import Iterator
from functools import cache
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from gemrender.cli.about import doctor, materials, setups, stones
from gemrender.cli.atlas import atlas
from gemrender.cli.compare import compare
from gemrender.cli.convert import convert
from gemrender.cli.crosscheck import crosscheck
from gemrender.cli.improve import improve
from gemrender.cli.inspect import inspect
from gemrender.cli.measures import measures
from gemrender.cli.output import say
from gemrender.cli.render import render
from gemrender.cli.report import report
from gemrender.cli.scene import scene
from gemrender.cli.score import score
from gemrender.cli.sensitivity import sensitivity
from gemrender.cli.show import show
from gemrender.cli.studio import studio
from gemrender.cli.symmetry import symmetry
from gemrender.cli.tilt import tilt
from gemrender.cli.tolerance import tolerance
from gemrender.cli.values import OptionError, listed
from gemrender.errors import GemrenderError, GemrenderWarning, InputError
from gemrender.interruption import interrupted_by_signals

__all__ = ["app", "main", "run"]

#: Exit status after Ctrl-C, by the shells' convention.
_INTERRUPTED = 130

#: click's errors, wherever this version of typer keeps them.
_click: Any = sys.modules[typer.BadParameter.__module__]


class _Commands(TyperGroup):
    """The commands; an unknown one is refused in gemrender's form."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if args[0] not in self.commands and not ctx.resilient_parsing:  # where a shell completes
            raise InputError(f"must be one of {listed(args[0], self.commands)}", key="COMMAND", value=args[0])
        return super().resolve_command(ctx, args)


app = typer.Typer(
    cls=_Commands,
    help="See, measure and improve how a cut stone handles light.",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
)

for _command in (
    score, compare, sensitivity, show, report, render, symmetry, tilt, tolerance, improve, atlas, studio,
    crosscheck, scene, convert, inspect, stones, setups, materials, measures, doctor,
):  # fmt: skip
    app.command()(_command)


class _ClosedOutput(io.TextIOBase):
    """A standard output that was closed: who prints to it fails, and is told."""

    def write(self, text: str) -> int:
        raise OSError(errno.EBADF, "standard output is closed")


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run the command line; errors are one line on stderr, and the exit status is theirs."""
    if sys.stdout is None:
        # Its number is taken, else the next file to be opened would have it, and get what libraries print.
        while os.open(os.devnull, os.O_WRONLY) < 1:
            pass
        sys.stdout = _ClosedOutput()
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # a terminal that lacks a letter shows a question mark
            stream.reconfigure(errors="replace")
    raise SystemExit(run(arguments))


def run(arguments: list[str] | None) -> int:
    """Run the command line and return its exit status."""
    with interrupted_by_signals() as status_of_interruption, _warnings_on_stderr():
        status = _run(arguments)
    if status != _INTERRUPTED:  # typer makes an exit of an interruption, too
        return status
    say("gemrender: interrupted")
    return status_of_interruption()


@contextlib.contextmanager
def _warnings_on_stderr() -> Iterator[None]:
    """Show what parts of gemrender log and warn of as the commands' own messages."""

    def show(message: Warning | str, kind: type[Warning], *where: Any, **more: Any) -> None:
        if issubclass(kind, GemrenderWarning):
            say(f"gemrender: {message}")
        else:
            shown_before(message, kind, *where, **more)

    handler = logging.Handler(logging.WARNING)
    handler.emit = lambda record: say(f"gemrender: {record.getMessage()}")  # type: ignore[method-assign]
    log = logging.getLogger("gemrender")
    log.addHandler(handler)
    with warnings.catch_warnings():
        warnings.simplefilter("always", GemrenderWarning)
        shown_before = warnings.showwarning
        warnings.showwarning = show  # type: ignore[assignment]
        try:
            yield
        finally:
            log.removeHandler(handler)


@cache  # a tenth of a second: all parameters of all commands
def _commands() -> Any:
    return typer.main.get_command(app)


def _run(arguments: list[str] | None) -> int:
    try:
        return int(_commands()(arguments, standalone_mode=False) or 0)
    except OptionError as refused:
        return _fail(refused.error)
    except InputError as error:
        return _fail(_as_argument(error))
    except GemrenderError as error:
        return _fail(error)
    except _click.UsageError as error:
        return _fail(_usage_error(error))
    except (KeyboardInterrupt, typer.Abort):
        return _INTERRUPTED
    except BrokenPipeError:  # the reader has seen enough
        return 1
    except OSError as error:  # a full disk behind stdout, for one
        return _fail(GemrenderError(f"input or output failed: {error.strerror or error}"))
    except MemoryError:
        return _fail(GemrenderError("out of memory; a smaller --resolution needs less"))


def _fail(error: GemrenderError) -> int:
    say(f"gemrender: {' '.join(str(error).split())}")
    return error.exit_status


def _as_argument(error: InputError) -> InputError:
    """Tell an error that came from no file as one of the command line's arguments and options."""
    if error.source is not None or error.key is None:
        return error
    commands = _commands().commands.values()
    given = {name for command in commands for param in command.params for name in param.opts}
    option = f"--{error.key.replace('_', '-')}"
    if error.key == "stone":
        return InputError(error.allowed, key="STONE", value=error.value)
    return InputError(error.allowed, key=option, value=error.value) if option in given else error


def _usage_error(error: Any) -> InputError:
    """Tell one of click's errors as: option or argument, what is wrong, what is allowed."""
    context = error.ctx
    if isinstance(error, _click.NoSuchOption):
        options = [name for param in context.command.get_params(context) for name in param.opts]
        options.sort(key=lambda name: name.endswith("-completion"))
        allowed = listed(error.option_name, (name for name in options if name.startswith("--")))
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

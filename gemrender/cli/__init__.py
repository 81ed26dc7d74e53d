"""The command line: parse, call, print. Everything else is imported when a command needs it.

A command has a module of its own name, or shares one with its next of kin; `program` puts them together.
"""

from __future__ import annotations

import sys
from typing import Any, NoReturn

__all__ = ["app", "main"]


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run the command line, and end the process with its exit status."""
    try:
        from gemrender.cli.program import main as run
    except KeyboardInterrupt:  # Ctrl-C before anything has begun
        print("gemrender: interrupted", file=sys.stderr)
        raise SystemExit(130) from None
    run(arguments)


def __getattr__(name: str) -> Any:
    """Import the commands when they are asked for."""
    if name == "app":
        from gemrender.cli.program import app

        return app
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

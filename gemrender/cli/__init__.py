"""The command line: parse, call, print. Everything else is imported when a command needs it.

A command has a module of its own name, or shares one with its next of kin; `program` puts them together.
"""

from __future__ import annotations

from gemrender.cli.program import app, main

__all__ = ["app", "main"]

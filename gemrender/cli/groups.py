"""Groups of options that commands share: what a group is, and how a command takes one.

A group is a dataclass whose fields are options. A command that names one in its signature,

    @command
    def score(stones: Stones, view: ViewOptions, model: ModelOptions) -> None: ...

has all of its options, with the same names, meanings and help as every other command.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, get_type_hints

__all__ = ["command"]


def command(function: Callable[..., None]) -> Callable[..., None]:
    """Return what typer takes of a command: its groups opened into their options.

    Parameters
    ----------
    function : callable
        The command. Parameters whose type is a dataclass are groups; the others are arguments and options.
    """
    hints = get_type_hints(function, include_extras=True)
    groups: dict[str, Any] = {}
    opened: list[inspect.Parameter] = []
    for parameter in inspect.signature(function).parameters.values():
        hint = hints[parameter.name]
        if not dataclasses.is_dataclass(hint):
            opened.append(_parameter(parameter.name, parameter.default, hint))
            continue
        groups[parameter.name] = hint
        options = get_type_hints(hint, include_extras=True)
        for field in dataclasses.fields(hint):
            default = inspect.Parameter.empty if field.default is dataclasses.MISSING else field.default
            opened.append(_parameter(field.name, default, options[field.name]))

    @wraps(function)
    def call(**values: Any) -> None:
        for name, group in groups.items():
            values[name] = group(
                **{field.name: values.pop(field.name) for field in dataclasses.fields(group)}
            )
        function(**values)

    del call.__wrapped__  # its signature is another
    call.__signature__ = inspect.Signature(opened)  # type: ignore[attr-defined]
    call.__annotations__ = {parameter.name: parameter.annotation for parameter in opened}
    return call


def _parameter(name: str, default: Any, hint: Any) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hint)

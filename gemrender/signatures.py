"""Options that several functions take, told once: as a TypedDict, and spelt out in each function's help.

Type checkers read `**options: Unpack[Options]` (PEP 692). `help`, tab completion and notebooks read the
signature and the docstring, where the same options stand one by one, with types and defaults: as fastcore's
`delegates` and pandas' and seaborn's shared docstrings do.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

__all__ = ["parameter_texts", "spelt_out", "types_of"]

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: A heading of a numpydoc docstring.
_HEADING = re.compile(r"^[A-Z][A-Za-z ]+\n-{3,}\n", re.MULTILINE)
#: An entry beneath one: names, perhaps a type, and what is said, indented.
_ENTRY = re.compile(r"^(?P<names>\*{0,2}\w[\w, ]*?)(?: : [^\n]+)?\n(?:[ ]{4}[^\n]+\n)*", re.MULTILINE)


def spelt_out(
    *, defaults: Mapping[str, Any], texts: Mapping[str, str], types: Mapping[str, str]
) -> Callable[[_Function], _Function]:
    """Spell out a function's `**options` in its signature and in its docstring.

    The function stays what it is. Its docstring tells all parameters in the order of the signature: those of
    which it says nothing itself, `**options` among them, by the texts.

    Parameters
    ----------
    defaults : mapping of str to object
        The options that `**options` stands for, with their defaults; parameters of the function's own are
        left out.
    texts : mapping of str to str
        What is said of parameters (`parameter_texts`), of others too.
    types : mapping of str to str
        The types of the options.
    """

    def spell_out(function: _Function) -> _Function:
        signature = inspect.signature(function)
        own = [each for each in signature.parameters.values() if each.kind is not each.VAR_KEYWORD]
        further = [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=value, annotation=types[name])
            for name, value in defaults.items()
            if name not in signature.parameters
        ]
        function.__signature__ = signature.replace(parameters=[*own, *further])  # type: ignore[attr-defined]
        before, section, after = _parted(function.__doc__)
        known = {**texts, **_entries(section)}
        told = dict.fromkeys(known[each.name] for each in (*own, *further))
        function.__doc__ = f"{before}{''.join(told)}\n{after}"
        return function

    return spell_out


def parameter_texts(docstring: str | None) -> dict[str, str]:
    """Return the entries of a docstring's first section, by each of their names.

    Several parameters that are told together have one entry, the same text.
    """
    return _entries(_parted(docstring)[1])


def types_of(options: type) -> dict[str, str]:
    """Return the types of a TypedDict's keys, as they are written in its module, with those of its bases."""
    return {name: getattr(of, "__forward_arg__", str(of)) for name, of in options.__annotations__.items()}


def _entries(section: str) -> dict[str, str]:
    return {
        name.strip(): entry[0] for entry in re.finditer(_ENTRY, section) for name in entry["names"].split(",")
    }


def _parted(docstring: str | None) -> tuple[str, str, str]:
    """Return a docstring up to its first section's entries, those, and what comes after them."""
    text = inspect.cleandoc(docstring or "") + "\n"
    first = re.search(_HEADING, text)
    if first is None:
        return text, "", ""
    second = re.search(_HEADING, text[first.end() :])
    end = len(text) if second is None else first.end() + second.start()
    return text[: first.end()], text[first.end() : end], text[end:]

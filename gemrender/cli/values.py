"""How values of options are read: typed, refused in gemrender's one form, and completed by the shell.

A parser takes what stands on the command line and returns the value; `OptionError` brings its error past
typer, which would make a message of its own of any ValueError.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import typer

from gemrender.errors import InputError
from gemrender.reading import did_you_mean

__all__ = [
    "OptionError",
    "c_axis_option",
    "choice_option",
    "complete_files",
    "complete_materials",
    "complete_words",
    "listed",
    "material_option",
    "number_option",
    "whole_option",
]

#: Completes a word: what may stand there, given what was typed of it.
Completion = Callable[[str], Iterable[str]]


class OptionError(Exception):
    """A value that an option refuses; its `error` is what the user is told."""

    def __init__(self, error: InputError) -> None:
        super().__init__(str(error))
        self.error = error


def choice_option(name: str, choices: Iterable[str], words: str, *, metavar: str, **settings: Any) -> Any:
    """Return an option whose value is one of some words.

    Parameters
    ----------
    name : str
        The option, such as "--engine".
    choices : iterable of str
        What is allowed; shown in the help, and completed by the shell.
    words, metavar : str
        Its line in the help, without the choices, and what stands for the value there.
    **settings
        Further settings of `typer.Option`.
    """
    allowed = tuple(choices)

    def parse(text: str) -> str:
        if text not in allowed:
            raise OptionError(InputError(f"must be one of {listed(text, allowed)}", key=name, value=text))
        return text

    return typer.Option(
        name,
        parser=parse,
        metavar=metavar,
        help=f"{words} One of: {', '.join(allowed)}.",
        autocompletion=complete_words(lambda: allowed),
        **settings,
    )


def number_option(name: str, unit: str, words: str, *, metavar: str, **settings: Any) -> Any:
    """Return an option whose value is a finite number of some unit; what it is for knows its range.

    Parameters
    ----------
    name, unit : str
        The option, and what its number counts, in the plural.
    words, metavar : str
        Its line in the help, and what stands for the value there.
    **settings
        Further settings of `typer.Option`.
    """

    def parse(text: str | float) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise OptionError(InputError(f"must be a finite number of {unit}", key=name, value=text))
        return value

    return typer.Option(name, parser=parse, metavar=metavar, help=words, **settings)


def whole_option(
    name: str, words: str, *, metavar: str = "NUMBER", low: float = -math.inf, high: float = math.inf,
    example: str = "", **settings: Any,
) -> Any:  # fmt: skip
    """Return an option whose value is a whole number within a range; `example` is one for the error."""

    def parse(text: str | int) -> int:
        try:
            value = int(text)
        except ValueError as error:
            allowed = "must be a whole number" + (f", such as {example}" if example else "")
            raise OptionError(InputError(allowed, key=name, value=text)) from error
        if not low <= value <= high:
            negative = low == 0 and math.isinf(high)
            allowed = "must not be negative" if negative else f"must be {_range(low, high)}"
            raise OptionError(InputError(allowed, key=name, value=value))
        return value

    shown = words if math.isinf(low) else f"{words.removesuffix('.')}; {_range(low, high)}."
    return typer.Option(name, parser=parse, metavar=metavar, help=shown, **settings)


def _range(low: float, high: float) -> str:
    return f"{low:.15g} or more" if math.isinf(high) else f"from {low:.15g} to {high:.15g}"


def complete_words(words: Callable[[], Iterable[str]]) -> Completion:
    """Return a completion of words that are looked up when it is asked for."""

    def complete(incomplete: str) -> list[str]:
        return [word for word in words() if word.startswith(incomplete)]

    return complete


def complete_files(words: Callable[[], Iterable[str]], suffixes: tuple[str, ...]) -> Completion:
    """Return a completion of words, of files with one of the suffixes, and of folders that may hold some."""

    def complete(incomplete: str) -> list[str]:
        return [word for word in words() if word.startswith(incomplete)] + sorted(
            _files(incomplete, suffixes)
        )

    return complete


def _files(incomplete: str, suffixes: tuple[str, ...]) -> Iterator[str]:
    folder, _, start = incomplete.rpartition("/")
    shown = f"{folder}/" if "/" in incomplete else ""
    try:
        entries = list(Path(shown or ".").expanduser().iterdir())
    except OSError:
        return
    for entry in entries:
        if not entry.name.startswith(start) or (entry.name.startswith(".") and not start):
            continue
        if entry.is_dir():
            yield f"{shown}{entry.name}/"
        elif entry.suffix.lower() in suffixes:
            yield f"{shown}{entry.name}"


def _materials() -> list[str]:
    from gemrender.optics import material_names

    return material_names()


#: Completes a material's name, or its file.
complete_materials: Completion = complete_files(_materials, (".toml",))


def material_option(words: str, **settings: Any) -> Any:
    """Return the option --material: a material's name or file, or a refractive index."""

    def parse(text: str | float) -> str | float:
        try:
            return float(text)
        except ValueError:
            return text

    return typer.Option(
        "--material",
        parser=parse,
        metavar="NAME|FILE|INDEX",
        help=words,
        autocompletion=complete_materials,
        **settings,
    )


def c_axis_option(**settings: Any) -> Any:
    """Return the option --c-axis: three numbers, or "table"."""

    def parse(text: Any) -> Any:
        from gemrender.cuts.crystal_axes import parse_c_axis

        if not isinstance(text, str):
            return text
        try:
            return parse_c_axis(text)
        except InputError as error:
            raise OptionError(InputError(error.allowed, key="--c-axis", value=text)) from error

    return typer.Option(
        "--c-axis",
        parser=parse,
        metavar="X,Y,Z|table",
        help="Optic axis of birefringent stones, in the stone's frame; of biaxial ones the axis gamma. By "
        "default what each file says, else table: along the stone's axis.",
        **settings,
    )


def listed(word: str, allowed: Iterable[str]) -> str:
    """List what is allowed, with a guess at what was meant."""
    names = list(allowed)
    return ", ".join(names) + did_you_mean(word, names)

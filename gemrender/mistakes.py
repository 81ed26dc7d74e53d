"""The mistakes of an input, all told in one line, not the first alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, ParamSpec, Self, TypeVar

from gemrender.errors import InputError

__all__ = ["LONGEST_LISTED", "MOST_LISTED", "Mistakes", "MistakesError"]

P = ParamSpec("P")
R = TypeVar("R")

#: So many are told in the line, and so long it may be [characters]; of the others their number.
MOST_LISTED, LONGEST_LISTED = 8, 1500


class MistakesError(InputError):
    """Several mistakes of one file, told in one line; its key, value and what is allowed are the first's.

    Parameters
    ----------
    errors : sequence of InputError
        The mistakes, at least one.
    """

    def __init__(self, errors: Sequence[InputError]) -> None:
        first = errors[0]
        super().__init__(first.allowed, source=first.source, key=first.key, value=first.value)
        self.errors = tuple(errors)

    def __str__(self) -> str:
        first, *others = self.errors
        told = [str(first.at(self.source or ""))]
        for error in others[: MOST_LISTED - 1]:
            # Of another file, as one that this names, it says which.
            told.append(str(error if error.source not in (None, self.source) else error.at("")))
            if sum(map(len, told)) > LONGEST_LISTED:
                told.pop()
                break
        left = len(self.errors) - len(told)
        return "; ".join([*told, f"and {left} more"] if left else told)

    def __reduce__(self) -> tuple[Any, ...]:
        return MistakesError, (self.errors,), {"source": self.source}

    def at(self, source: str, section: str | None = None) -> MistakesError:
        """Return the same errors, told as coming from `source` (and the section of it)."""
        told = MistakesError([_within(error, section) for error in self.errors])
        told.source = source
        return told


def _within(error: InputError, section: str | None) -> InputError:
    """Return an error as of a section, unless it knows its own source."""
    if error.source is not None:
        return error
    told = error.at("", section)
    told.source = None
    return told


class Mistakes:
    """Gathers the mistakes of a file, so that all are told, not the first.

    ::

        with Mistakes() as mistakes:
            mistakes.of(check_name, top)
            values = mistakes.of(section, top, "sky", keys)

    raises them at its end, if there are any: one as it is, several as `MistakesError`.
    """

    def __init__(self) -> None:
        self.errors: list[InputError] = []

    def of(self, check: Callable[P, R], *arguments: P.args, **options: P.kwargs) -> R | None:
        """Return what a check returns; None where it finds mistakes, which are kept."""
        try:
            return check(*arguments, **options)
        except InputError as error:
            self.add(error)
            return None

    def add(self, error: InputError) -> None:
        """Keep a mistake, or several."""
        self.errors += error.errors if isinstance(error, MistakesError) else [error]

    def refuse(self) -> None:
        """Raise what was found, if anything was."""
        found, self.errors = self.errors, []  # told once, should this be called within the block
        if found:
            raise found[0] if len(found) == 1 else MistakesError(found)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, InputError):  # one that ends the checks
            self.add(error)
        if error is None or isinstance(error, InputError):
            self.refuse()

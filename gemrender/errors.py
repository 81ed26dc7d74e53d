"""What can go wrong, and the exit status each error has on the command line.

::

    GemrenderError          exit status 1
    ├── InputError          exit status 2: the user's input; one line says what is allowed
    └── BackendError        exit status 1: Mitsuba, Dr.Jit or LLVM cannot run here; says the cure

    GemrenderWarning        no error: something was mended or left out, and one line says what
"""

from __future__ import annotations

__all__ = ["BackendError", "GemrenderError", "GemrenderWarning", "InputError"]


class GemrenderError(Exception):
    """Base of every error that gemrender raises on purpose."""

    exit_status = 1


class InputError(GemrenderError, ValueError):
    """Bad input, told in one line: where it came from, the key, the value, what is allowed.

    Parameters
    ----------
    allowed : str
        What is allowed, or what is wrong.
    source : str, optional
        File, option or argument that the input came from.
    key : str, optional
        Key within the source.
    value : object, optional
        The refused value, shown by its repr and cut after 60 characters.
    """

    exit_status = 2

    def __init__(
        self, allowed: str, *, source: str | None = None, key: str | None = None, value: object = ...
    ) -> None:
        self.allowed, self.source, self.key, self.value = allowed, source, key, value
        super().__init__(allowed)

    def __str__(self) -> str:
        what = self.key or ""
        if self.value is not ...:
            shown = _one_line(repr(self.value))
            what = f"{what} = {shown}" if what else shown
        return ": ".join(_one_line(part, 2000) for part in (self.source, what, self.allowed) if part)

    def at(self, source: str, section: str | None = None) -> InputError:
        """Return the same error, told as coming from `source` (and the section of it)."""
        key = f"{section}.{self.key}" if section and self.key else (self.key or section)
        return InputError(self.allowed, source=source, key=key, value=self.value)


class BackendError(GemrenderError, RuntimeError):
    """Mitsuba, Dr.Jit or LLVM cannot run on this machine; the message ends with the cure."""


class GemrenderWarning(UserWarning):
    """Something was mended or left out, told in one line; what comes of it is right as far as that says."""


def _one_line(text: str, most: int = 60) -> str:
    # A file's name may hold anything, commands to the terminal included.
    text = " ".join("".join(c if c.isprintable() or c.isspace() else "\ufffd" for c in text).split())
    return text if len(text) <= most else text[: most - 1] + "…"

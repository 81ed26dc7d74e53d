"""What `gemrender doctor` prints: the checks of this machine, what cures them, and a verdict."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from gemrender.render.diagnosis import EXACT_ENGINE, Check

__all__ = ["print_doctor"]

_MARKS = {True: "✓", False: "✗", None: "–"}
_PLAIN_MARKS = {True: "ok", False: "FAIL", None: "-"}
_STYLES = {True: "green", False: "bold red", None: "dim"}


def print_doctor(checks: Sequence[Check], console: Console) -> bool:
    """Print the checks as a table, then the cures, then one line with the verdict.

    Parameters
    ----------
    checks : sequence of Check
        As `gemrender.render.diagnosis.diagnose` returns them.
    console : rich.console.Console
        Where to print; marks and frame are plain ASCII where its encoding is not UTF-8.

    Returns
    -------
    bool
        True where no check failed: gemrender can run here.
    """
    plain = console.options.ascii_only

    def text(words: str, style: str = "") -> Text:
        """Text that the console can encode, whatever a path contains."""
        return Text(words.encode(console.encoding, "replace").decode(console.encoding), style=style)

    table = Table("", "check", "found")
    table.columns[1].no_wrap = True
    table.columns[2].overflow = "fold"
    for check in checks:
        mark = (_PLAIN_MARKS if plain else _MARKS)[check.ok]
        table.add_row(text(mark, _STYLES[check.ok]), text(check.name), text(check.detail))
    console.print(table)

    # A command to copy stays on one line, whatever the terminal's width.
    for check in checks:
        if check.cure:
            console.print(text(f"{check.name}: {check.cure}"), soft_wrap=True)
    failed = next((check for check in checks if check.ok is False), None)
    if failed is None:
        passed = sum(check.ok is True for check in checks)
        verdict = text(f"gemrender is ready: all {passed} checks passed", _STYLES[True])
    else:
        cure = failed.cure or failed.detail
        verdict = text(f"gemrender cannot run here: {failed.name}: {cure}", _STYLES[False])
    console.print(verdict, soft_wrap=True)
    if failed is not None and any(check.ok and check.name == EXACT_ENGINE for check in checks):
        words = "Scores and maps of convex stones need no Mitsuba: gemrender score --engine exact"
        console.print(text(words), soft_wrap=True)
    return failed is None

"""The stones that a command was given: files, bundled names, tables of many, and settings to vary one by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from gemrender.cli.options import view_and_model
from gemrender.cli.output import progress_bar

if TYPE_CHECKING:
    from gemrender.stone import Stone

__all__ = ["LoadedStones", "load"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadedStones:
    """The stones of a command, in order.

    Attributes
    ----------
    stones : sequence of Stone
        All of them.
    names : list of str
        What the user named each by; files are named after it.
    settings : list of dict
        Of each stone what was set for it, by name; empty where nothing was.
    notes : list of str
        What the user should know of how the input was read.
    """

    stones: Sequence[Stone]
    names: list[str]
    settings: list[dict[str, Any]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.stones)

    def setting(self, i: int) -> dict[str, Any]:
        """Return what was set for a stone."""
        return self.settings[i] if self.settings else {}

    @property
    def samples(self) -> Sequence[Stone]:
        """Stones that stand for all where an engine is checked."""
        return self.stones


def load(names: list[str], options: dict[str, Any]) -> LoadedStones:
    """Load all stones, and check the options for each, before any work begins."""
    from gemrender.stone import load_stone

    loaded = []
    with progress_bar(len(names)) as step:
        for i, name in enumerate(names):
            loaded.append(load_stone(name))
            view_and_model(loaded[-1], options)
            step(i, "loading")(1.0)
    return LoadedStones(stones=loaded, names=list(names))

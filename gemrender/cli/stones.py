"""The stones that a command was given: files, bundled names, tables of many, and settings to vary one by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.options import Stones, view_and_model
from gemrender.cli.output import progress_bar, say
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.cuts.stones import Stones as StonesOfSource
    from gemrender.stone import Stone

__all__ = ["LoadedStones", "StoneOptions", "assumptions", "load"]


def _complete_setting(incomplete: str) -> list[str]:
    from gemrender.cuts.variations import all_settings

    return [f"{key}=" for key in all_settings() if key.startswith(incomplete)]


@dataclass(frozen=True, slots=True, kw_only=True)
class StoneOptions:
    """What stones a command is for."""

    stones: Stones
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUES",
            help="Vary one stone: a value, values with commas between them, or first:last:step, as "
            "pavilion_angle=39:42:0.1; may be given several times, for a grid.",
            autocompletion=_complete_setting,
        ),
    ] = None


def assumptions(source: str, stone: Stone) -> list[str]:
    """Return what was assumed of a stone, as its file left it out, in lines."""
    from gemrender.cuts.stones import taken_lines

    return [f"{source}: taken: {words}" for words in taken_lines(stone.assumed)]


class LoadedStones:
    """The stones of a command, in order; those of tables and grids are made when they are asked for.

    Parameters
    ----------
    sources : sequence of str
        What the user named.
    parts : sequence of Stones
        The stones of each source.
    """

    def __init__(self, sources: Sequence[str], parts: Sequence[StonesOfSource]) -> None:
        from gemrender.cuts.stones import Lazy

        self._sources, self._parts = sources, parts
        self._places = [(k, i) for k, part in enumerate(parts) for i in range(len(part))]
        self.stones: Sequence[Stone] = Lazy(len(self._places), self._stone)

    def __len__(self) -> int:
        return len(self._places)

    def _stone(self, number: int) -> Stone:
        k, i = self._places[number]
        return self._parts[k][i]

    @property
    def names(self) -> list[str]:
        """What files of each stone are named after: what the user named it by, or its name in a table."""
        many = [len(part) > 1 for part in self._parts]
        return [self._parts[k][i].name if many[k] else self._sources[k] for k, i in self._places]

    def setting(self, number: int) -> dict[str, Any]:
        """Return what was set for a stone, by key."""
        k, i = self._places[number]
        return dict(self._parts[k].settings[i])

    @property
    def settings(self) -> list[dict[str, Any]]:
        """What was set for each stone; empty where nothing was."""
        return [self.setting(i) for i in range(len(self))] if self.setting(0) else []

    @property
    def notes(self) -> list[str]:
        """What the user should know of how the input was read."""
        notes = []
        for source, part in zip(self._sources, self._parts, strict=True):
            notes += [f"{source}: {words}" for words in part.notes]
            if len(part) == 1 and not part.notes:
                notes += [f"{source}: {words}" for words in part[0].notes]  # what was mended
                notes += assumptions(source, part[0])
        return notes

    def tell(self) -> None:
        """Tell the notes on stderr, where no table does."""
        for words in self.notes:
            say(f"gemrender: {words}")

    @property
    def samples(self) -> list[Stone]:
        """One stone of each source: those of a table, or of a grid, are all made of proportions."""
        return [part[0] for part in self._parts]

    def check(self, options: dict[str, Any]) -> None:
        """Check the options for all stones, by one of each material."""
        for part in self._parts:
            view_and_model(part[0], options)
            for material, source in list(part.materials.items())[1:]:
                view_and_model(replace(part[0], material=material, source=source), options)


def load(
    names: Sequence[str],
    options: dict[str, Any],
    settings: Sequence[str] | None = None,
    material: str | float | None = None,
) -> LoadedStones:
    """Load all stones, and check the options for each, before any work begins.

    Parameters
    ----------
    names : sequence of str
        Stone files, tables of stones and bundled names.
    options : dict
        As of `trace_options`.
    settings : sequence of str, optional
        Settings that one stone is varied by, as "pavilion_angle=39:42:0.1".
    material : str or float, optional
        Material of all stones, or its refractive index, in place of what their files say.
    """
    from gemrender.cuts import load_stones, vary
    from gemrender.reading import located_at

    if settings:
        if len(names) != 1:
            raise InputError("varies one stone; name only one", key="--set", value=settings[0])
        stones = load_stones(names[0])
        if len(stones) != 1:
            raise InputError("varies one stone, not a table of them", key="--set", value=settings[0])
        with located_at("--set"):
            parts: list[StonesOfSource] = [vary(stones[0], settings)]
    else:
        parts = []
        with progress_bar(len(names)) as step:
            for i, name in enumerate(names):
                parts.append(load_stones(name))
                step(i, "loading")(1.0)
    if material is not None:
        from gemrender.cuts.stones import OfMaterial
        from gemrender.optics.material_files import refractive_index

        try:
            refractive_index(material)
        except InputError as error:
            if error.source is not None:
                raise
            raise InputError(error.allowed, key="material", value=material) from error
        parts = [OfMaterial(part, material) for part in parts]
    loaded = LoadedStones(names, parts)
    loaded.check(options)
    return loaded

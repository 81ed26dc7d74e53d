"""The command `convert`."""

from __future__ import annotations

from typing import Annotated

from gemrender.cli.groups import command
from gemrender.cli.options import MaterialOptions, OneStone, output_option
from gemrender.cli.output import say
from gemrender.cli.stones import load
from gemrender.cli.values import choice_option
from gemrender.errors import InputError

__all__ = ["convert"]

#: What can be written; `gemrender.cuts.convert` writes it, which is heavier to import.
_KINDS = ("asc", "gem", "gcs", "stl", "obj", "ply", "glb", "csv")


@command
def convert(
    stone: OneStone,
    of: MaterialOptions,
    out: Annotated[str, output_option("The file to write; its ending says the format.", "FILE")],
    form: Annotated[
        str | None,
        choice_option("--format", _KINDS, "Its format, where the name does not say it.", metavar="FORMAT"),
    ] = None,
) -> None:
    """Write a stone in another format: designs (GemCad, Gem Cut Studio), meshes, vertices."""
    from gemrender.cuts.convert import save_stone

    loaded = load([stone], {}, material=of.material)
    if len(loaded) != 1:
        raise InputError(f"is a table of {len(loaded)} stones; one stone is converted", source=stone)
    loaded.tell()
    for words in save_stone(loaded.stones[0], out, kind=form):
        say(f"gemrender: {out}: {words}")
    say(f"written: {out}")

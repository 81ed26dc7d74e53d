"""Options of pictured stones, which `render` and `scene` share: material, weight, size, set-up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.output import say
from gemrender.cli.stones import assumptions
from gemrender.cli.values import c_axis_option, choice_option, complete_files, material_option, number_option

if TYPE_CHECKING:
    from gemrender.scene.photoreal import Gem

__all__ = [
    "SIZE",
    "GemOptions",
    "SettingOptions",
    "Setup",
    "Size",
    "complete_setups",
    "load_gems",
    "picture_size",
    "tell_assumptions",
]

GEMS = "Stones"

#: Width and height [pixels].
SIZE = "1024"


def _setups() -> list[str]:
    from gemrender.scene.setup import bundled_setups

    return bundled_setups()


complete_setups = complete_files(_setups, (".toml",))

Setup = typer.Option(
    "--setup",
    metavar="NAME",
    help="Set-up: a bundled one (see: gemrender setups) or a file.",
    autocompletion=complete_setups,
)


def picture_size(text: str, aspect: str | None = None) -> tuple[int, int]:
    """Read the size of a picture: its side, or width and height [pixels], and its aspect."""
    from gemrender.render.shots import picture_size as sides

    return sides(text, aspect)


Size = Annotated[str, typer.Option(metavar="N|WxH", help="Size of the picture, in pixels.")]


@dataclass(frozen=True, slots=True, kw_only=True)
class GemOptions:
    """What pictured stones are made of, and how large they are."""

    material: Annotated[
        Any,
        material_option(
            "Material of all stones (see: gemrender materials), a material file, or a refractive index.",
            rich_help_panel=GEMS,
        ),
    ] = None
    carat: Annotated[
        float | None,
        number_option(
            "--carat", "carats", "Weight of each pictured stone.", metavar="CARAT", rich_help_panel=GEMS
        ),
    ] = None
    diameter: Annotated[
        float | None,
        number_option(
            "--diameter",
            "millimetres",
            "Girdle diameter, or longer side, of each pictured stone; by default what its file says, else "
            "6.5.",
            metavar="MM",
            rich_help_panel=GEMS,
        ),
    ] = None
    c_axis: Annotated[Any, c_axis_option(rich_help_panel=GEMS)] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SettingOptions:
    """What holds pictured stones, and the finish of their girdles."""

    setting: Annotated[
        str | None,
        choice_option(
            "--setting",
            ("none", "solitaire", "bezel", "pendant"),
            "What holds each stone; by default what the set-up says.",
            metavar="WORD",
            rich_help_panel=GEMS,
        ),
    ] = None
    metal: Annotated[
        str | None,
        choice_option(
            "--metal",
            ("platinum", "gold", "silver"),
            "Metal of the setting.",
            metavar="WORD",
            rich_help_panel=GEMS,
        ),
    ] = None
    girdle: Annotated[
        str | None,
        choice_option(
            "--girdle",
            ("polished", "faceted", "bruted"),
            "Finish of the stones' girdles.",
            metavar="WORD",
            rich_help_panel=GEMS,
        ),
    ] = None


def load_gems(names: list[str], options: GemOptions) -> list[Gem]:
    """Load stones, with their material and size."""
    from gemrender.cuts import load_stone
    from gemrender.render.photoreal import make_gems

    stones = [load_stone(name) for name in names]
    gems = make_gems(
        stones,
        material=options.material,
        carat=options.carat,
        diameter_mm=options.diameter,
        c_axis=options.c_axis,
    )
    tell_assumptions(names, gems)
    return gems


def tell_assumptions(names: Sequence[str], gems: Sequence[Gem]) -> None:
    """Say what was taken of stones, since their files do not say it."""
    for name, gem in zip(names, gems, strict=True):
        for words in assumptions(name, gem.stone):
            say(f"gemrender: {words}")

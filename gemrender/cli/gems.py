"""Options of pictured stones, which `render` and `scene` share: material, weight or diameter, size."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gemrender.cli.options import number
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.scene.photoreal import Gem

__all__ = ["SIZE", "Carat", "Diameter", "Material", "Size", "load_gems", "picture_size"]

Material = Annotated[
    str | None,
    typer.Option(
        metavar="NAME",
        help="Material of all pictured stones (see: gemrender materials), or a material file.",
    ),
]
Carat = Annotated[str | None, typer.Option(metavar="CARAT", help="Weight of each pictured stone.")]
Diameter = Annotated[
    str | None, typer.Option(metavar="MM", help="Girdle diameter of each pictured stone; by default 6.5.")
]
Size = Annotated[str, typer.Option(metavar="PIXELS|WxH", help="Size of the picture.")]
SIZE = "1024"


def load_gems(names: list[str], material: str | None, carat: str | None, diameter: str | None) -> list[Gem]:
    """Load stones, with their material and size."""
    from gemrender.render.photoreal import make_gems
    from gemrender.stone import load_stone

    return make_gems(
        [load_stone(name) for name in names],
        material=material,
        carat=None if carat is None else number("carat", carat, "carats"),
        diameter_mm=None if diameter is None else number("diameter", diameter, "millimetres"),
    )


def picture_size(text: str) -> tuple[int, int]:
    """Read the size of a picture: its side, or width and height [pixels]."""
    from gemrender.scene.photoreal import MOST_PIXELS

    parts = text.lower().split("x")
    try:
        sides = [int(part) for part in parts]
    except ValueError:
        sides = []
    if len(sides) not in (1, 2) or not all(1 <= side <= MOST_PIXELS for side in sides):
        raise InputError(
            f"must be a number of pixels or two, as 1024 or 1600x900, from 1 to {MOST_PIXELS}",
            key="size",
            value=text,
        )
    return sides[0], sides[-1]

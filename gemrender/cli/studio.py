"""The command `studio`: stones in the browser, answering while their sliders are dragged."""

from __future__ import annotations

from typing import Annotated

import typer

from gemrender.cli.groups import command
from gemrender.cli.options import AnyStones, MaterialOptions
from gemrender.cli.output import say
from gemrender.cli.stones import load
from gemrender.cli.values import whole_option

__all__ = ["studio"]

#: The stone that the studio begins with where none is named.
_FIRST = "inoue-3"


@command
def studio(
    of: MaterialOptions,
    stones: AnyStones = None,
    host: Annotated[
        str,
        typer.Option(
            "--host",
            metavar="ADDRESS",
            help="Address to listen at; anything but loopback lets others reach the studio.",
        ),
    ] = "127.0.0.1",
    port: Annotated[
        int, whole_option("--port", "Port; 0 takes a free one.", metavar="NUMBER", example="8080")
    ] = 0,
    browser: Annotated[
        bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")
    ] = True,
) -> None:
    """Open the studio in the browser: drag sliders, and see the exact map and scores of the stone."""
    from gemrender.studio.serve import check_installed, serve

    check_installed()
    from gemrender.studio.cuttings import check_convex

    loaded = load(stones or [_FIRST], {}, material=of.material)
    begun = list(loaded.stones)
    for stone in begun:
        check_convex(stone)
    loaded.tell()

    def tell(address: str) -> None:
        typer.echo(address)
        say("gemrender: the studio runs at this address until Ctrl-C")

    serve(begun, host=host, port=port, open_browser=browser, tell=tell)

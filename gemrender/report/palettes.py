"""Colours of facets by kind: fixed ones of a round brilliant's, and as many as needed for other cuts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "BRILLIANT_TINTS",
    "EXIT_COLOURS",
    "OTHER_KINDS",
    "TIER_COLOURS",
    "KindColours",
    "draw_swatch",
    "exit_colours",
    "kind_tints",
]

#: A round brilliant's facets by kind: pale tints, apart from each other for eyes with and without colour
#: blindness; numbers and names tell them apart as well.
BRILLIANT_TINTS = {
    "table": "#fdf3c7",
    "star": "#cfe6f5",
    "bezel": "#fbdcc4",
    "upper_girdle": "#d6ecdf",
    "lower_girdle": "#d3dcf2",
    "pavilion_main": "#f6d5e3",
    "girdle": "#e2e2e2",
}
#: The same for tiers of other cuts, one after the other, and again from the first: their facets have names.
_TINTS = (
    *list(BRILLIANT_TINTS.values())[:-1], "#e9e3b4", "#e3d2ef", "#c9e9e8", "#efcfc9", "#dfe9c4", "#d9d3c6",
)  # fmt: skip

#: Facets through which light comes in, by kind, and darker where it is rear light. The hues are those of the
#: pale tints; all of them differ by 10 and more (CIEDE2000) for eyes with and without colour blindness, as
#: Machado et al. (2009) simulate it.
EXIT_COLOURS = {
    "table": ("#ecd356", "#635108"),
    "star": ("#64bdf8", "#123650"),
    "bezel": ("#de5f26", "#4d2414"),
    "upper_girdle": ("#2f8f74", "#0f5f4a"),
    "lower_girdle": ("#6a6ad9", "#0a0a4d"),
    "pavilion_main": ("#a868a2", "#96208c"),
    "girdle": ("#9bba8b", "#0e0512"),
}
_KIND_NAMES = {
    "table": "Table",
    "star": "Stars",
    "bezel": "Bezel mains",
    "upper_girdle": "Upper girdle",
    "lower_girdle": "Lower girdle",
    "pavilion_main": "Pavilion mains",
    "girdle": "Girdle",
}
#: Those of tiers of other cuts, the tier with most of the view first; lighter ones differ by 9 and more.
TIER_COLOURS = (
    *list(EXIT_COLOURS.values())[:-1],
    ("#9bba8b", "#2b4520"),
    ("#9deda5", "#0c5a1d"),
    ("#6290fb", "#0f2f7a"),
    ("#c5ad07", "#4a3f00"),
    ("#a98997", "#43303a"),
)
#: What has no colour of its own.
OTHER_KINDS = ("#b4b4b4", "#3c3c3c")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KindColours:
    """Facets in groups of one colour.

    Attributes
    ----------
    group : (n_facets,) int64
        Group of each facet.
    names : tuple of str
        What each group is called.
    colours : tuple of (str, str)
        Its colour, and that of its rear light.
    """

    group: np.ndarray
    names: tuple[str, ...]
    colours: tuple[tuple[str, str], ...]


def exit_colours(stone: Stone, weight: np.ndarray) -> KindColours:
    """Return the colours of the facets through which light comes in.

    Parameters
    ----------
    stone : Stone
        The stone.
    weight : (n_facets,) float64
        How much of the view has its light through each: of many kinds those with most have colours.
    """
    kinds = list(dict.fromkeys(stone.facet_kinds))
    if set(kinds) <= EXIT_COLOURS.keys():
        known = list(EXIT_COLOURS)
        return KindColours(
            group=np.array([known.index(kind) for kind in stone.facet_kinds]),
            names=tuple(_KIND_NAMES.values()),
            colours=tuple(EXIT_COLOURS.values()),
        )
    number = np.array([kinds.index(kind) for kind in stone.facet_kinds])
    order = np.argsort(-np.bincount(number, weight), kind="stable")
    shown = order[: len(TIER_COLOURS)] if len(order) > len(TIER_COLOURS) + 1 else order
    place = np.full(len(kinds), len(shown))
    place[shown] = np.arange(len(shown))
    rest = len(kinds) - len(shown)
    return KindColours(
        group=place[number],
        names=(*(kinds[k] for k in shown), *([f"{rest} other tiers"] if rest else [])),
        colours=(*TIER_COLOURS, OTHER_KINDS)[: len(shown) + (rest > 0)],
    )


def kind_tints(stone: Stone) -> dict[tuple[str, str], str]:
    """Return a pale tint for each kind of facets on each side of a stone."""
    kinds = dict.fromkeys((facet.side, facet.kind) for facet in stone.facets)
    level = BRILLIANT_TINTS["girdle"]
    inclined = [pair for pair in kinds if pair[0] != "girdle"]
    return {pair: level for pair in kinds if pair[0] == "girdle"} | {
        pair: _TINTS[i % len(_TINTS)] for i, pair in enumerate(inclined)
    }


def draw_swatch(axes: Axes, x: float, y: float, colour: str, *, height: float = 0.22) -> None:
    """Draw a small field of a colour, its lower left corner there [inch]."""
    from matplotlib.patches import Rectangle

    axes.add_patch(Rectangle((x, y), 0.32, height, facecolor=colour, edgecolor="#5b6874", linewidth=0.7))

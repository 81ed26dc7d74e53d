"""Virtual facets as polygons, crisp at any size: by intensity, reflections, or where their light comes in."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from gemrender.engines import DEFAULT_BOUND, DEFAULT_TIME_LIMIT, require_engine
from gemrender.errors import InputError
from gemrender.observation import Model, View, bound_text
from gemrender.report.dimensions import length_unit
from gemrender.report.displays.page import PAPER, Page
from gemrender.report.displays.projection import Projection, look_at
from gemrender.report.figures import (
    BAND_COLOURS,
    REAR_COLOUR,
    UNSOLVED_COLOUR,
    colour_numbers,
    draw_scales,
)
from gemrender.report.palettes import exit_colours
from gemrender.report.tables import LEAST_SHOWN, band_names, how_text, model_text
from gemrender.scoring import BAND_EDGES, FacetSizes, Score, score_measurement
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from gemrender.beam import VirtualFacets

__all__ = [
    "COLOURS",
    "GIRDLE_COLOUR",
    "REFLECTION_COLOURS",
    "FacetClasses",
    "check_colour",
    "draw_facets",
    "edge_colours",
    "facet_classes",
    "facets_figure",
    "silhouette",
]

#: What the colours may tell.
COLOURS = ("intensity", "reflections", "facet")

#: Lowest numbers of reflections of the groups that are told apart.
_GROUPS = (0, 1, 2, 3, 4, 5, 6, 11, 21)
#: Their colours, fewest first: from magma, the lightness falling evenly.
REFLECTION_COLOURS = (
    "#fcfdbf", "#feca8d", "#fd9467", "#f05f5e", "#ca3e72", "#9c2e7f", "#6e1e81", "#400f74", "#140e36",
)  # fmt: skip
#: Light near the curved girdle, which no polygon tells: a tint that no scale has, hatched.
GIRDLE_COLOUR = "#d4d4d4"
_HATCHED = {"facecolor": GIRDLE_COLOUR, "edgecolor": "#9a9a9a", "hatch": "//////", "linewidth": 0.0}

#: Edges are darker than their facets by this share, and lighter where the luminance is below that. They are
#: opaque: between two facets the ground must not shine through.
_SHADE, _TINT, _DARK = 0.65, 0.4, 0.06
#: Width of the edges [points]; those of narrow facets have so much of the facet's own width, so that a
#: closer look finds its colour.
_EDGE, _EDGE_SHARE = 0.28, 0.06

# The page [inch]: the picture with room for its axes, and the panel.
_MAP, _LEFT, _BOTTOM, _GAP, _PANEL, _PANEL_BOTTOM = 6.4, 0.95, 0.85, 0.55, 4.05, 0.38
# In the panel, from top to bottom: the scores, rows of the legend, the table of sizes, the rules.
_SCORES, _ROW, _SIZES, _RULES = 1.27, 0.27, 2.15, 0.95
#: Where the bars of the legend begin, and the longest one's length.
_BARS, _LONGEST = 2.02, 1.35
#: Resolution of PNG files [pixels per inch]: edges are thinner than other displays' lines.
_DPI = 240

#: Memory for the polygons [GiB]: what it does not hold, beyond some hundred thousand, is hatched.
_MEMORY = 0.25

_TITLES = {
    "intensity": "Virtual facets by intensity",
    "reflections": "Virtual facets by reflections",
    "facet": "Virtual facets by where the light comes in",
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FacetClasses:
    """The virtual facets that are drawn, in classes of one colour.

    Attributes
    ----------
    drawn : (n,) int64
        Their numbers among all.
    of : (n,) int64
        The class of each.
    colours, names : tuple of str
        Of all classes, in the legend's order; the last one is trapped light.
    always : int
        The first so many are in the legend even if nothing is in them.
    """

    drawn: np.ndarray
    of: np.ndarray
    colours: tuple[str, ...]
    names: tuple[str, ...]
    always: int


def check_colour(colour: str) -> str:
    """Return what the colours shall tell, if it is one of `COLOURS`.

    Raises
    ------
    InputError
        It is not.
    """
    if colour not in COLOURS:
        raise InputError(f"must be one of {', '.join(COLOURS)}", key="colour", value=colour)
    return colour


def facets_figure(
    stone: Stone, *, colour: str = "intensity", view: View | None = None, model: Model | None = None
) -> Figure:
    """Draw the virtual facets of a convex stone, with its scores, a legend and the facets' sizes beside them.

    Each is drawn as the polygon that it is. What no polygon tells, the light near the girdle, is hatched.

    Parameters
    ----------
    stone : Stone
        The stone.
    colour : str
        What the colours tell, one of `COLOURS`: the band of intensity; the number of total reflections; or
        the kind of facet through which the light comes in, darker for rear light.
    view : View, optional
        Where the eye is; by default straight above. Its resolution does not matter.
    model : Model, optional
        The optical model; by default that of the stone's material.

    Returns
    -------
    matplotlib.figure.Figure
        To be saved at its own resolution, or as SVG or PDF.

    Raises
    ------
    InputError
        The stone is not convex, or `colour` is none of those.
    BackendError
        The exact engine cannot run here.
    """
    check_colour(colour)
    require_engine("exact", stones=[stone])
    from gemrender.beam import Budget, trace_facets
    from gemrender.beam.measure import measure_facets

    budget = Budget(DEFAULT_TIME_LIMIT, _MEMORY)
    view, model = view or View.of(stone, 1), model or Model.of(stone)
    measured, facets = measure_facets(
        stone, view=view, model=model, bound=DEFAULT_BOUND, seed=1, progress=None, budget=budget
    )
    result = score_measurement(measured, stone, view, model)
    if facets.parts > 1:
        facets = trace_facets(stone, view=view, model=model, budget=budget.anew())
    classes = facet_classes(facets, colour)

    page = Page(
        stone,
        _TITLES[colour],
        width=_LEFT + _MAP + _GAP + _PANEL + Page.MARGIN,
        height=_BOTTOM + _MAP + Page.TITLE + 0.1,
    )
    page.figure.set_dpi(_DPI)
    scale = _MAP / (2 * view.half_width)
    axes = page.view(_LEFT, _BOTTOM, _MAP, _MAP, scale=scale, centre=(0.0, 0.0))
    draw_facets(axes, facets, classes, scale)
    draw_scales(axes, length_unit(stone), tilted=view.tilt_deg != 0, font_size=12)
    panel = page.axes(_LEFT + _MAP + _GAP, _PANEL_BOTTOM, _PANEL, _BOTTOM + _MAP - _PANEL_BOTTOM)
    shares = 100.0 * facets.area[classes.drawn] / measured.area
    _draw_panel(
        panel, result, _quantity(colour, model), _rows(classes, shares, result, bool(facets.left_over))
    )
    return page.figure


# ---- What the colours tell -----------------------------------------------------------------------------


def facet_classes(facets: VirtualFacets, colour: str) -> FacetClasses:
    """Sort the virtual facets that count as such: neither girdle cells nor slivers of rounding.

    Parameters
    ----------
    facets : VirtualFacets
        The virtual facets.
    colour : str
        What the colours tell, one of `COLOURS`.
    """
    from gemrender.beam.facets import FacetStatus

    drawn = np.flatnonzero(facets.is_counted)
    rear = facets.rear_mask[drawn]
    colours: tuple[str, ...]
    if colour == "intensity":
        names = [f"{name} %" for name in band_names(typeset=True)]
        of = np.digitize(facets.primary_intensity[drawn], BAND_EDGES[:-1])  # decreasing: 0 is brightest
        of[rear] = len(names)
        names.append("Rear")
        colours = (*BAND_COLOURS, REAR_COLOUR)
    elif colour == "reflections":
        names = [f"{low}" if high == low + 1 else f"{low}–{high - 1}" for low, high in pairwise(_GROUPS)]
        names.append(f"> {_GROUPS[-1] - 1}")
        of = np.searchsorted(_GROUPS, facets.reflections[drawn], side="right") - 1
        colours = REFLECTION_COLOURS
    else:
        facet = facets.nodes[facets.node[drawn], 1]
        weight = np.bincount(facet, facets.area[drawn], len(facets.stone.facets))
        kinds = exit_colours(facets.stone, weight)
        of = kinds.group[facet] + len(kinds.names) * rear
        names = [f"{name}{ending}" for ending in ("", ", rear") for name in kinds.names]
        colours = tuple(pair[dark] for dark in (0, 1) for pair in kinds.colours)
    of = np.where(facets.status[drawn] == FacetStatus.TRAPPED, len(names), of)
    return FacetClasses(
        drawn=drawn,
        of=of,
        colours=(*colours, UNSOLVED_COLOUR),
        names=(*names, "Trapped"),
        always=len(names) if colour == "intensity" else 0,
    )


def _quantity(colour: str, model: Model) -> str:
    """Say what the colours tell."""
    measure = {"primary": "primary intensity", "radiance": "radiance"}[model.intensity]
    return {"reflections": "total reflections", "facet": "where its light comes in"}.get(colour, measure)


def _rows(
    classes: FacetClasses, shares: np.ndarray, result: Score, some_left_over: bool
) -> list[tuple[str, str, float]]:
    """Return the legend: colours, names and shares of the view [%]; what no polygon tells comes last."""
    n = len(classes.names)
    number = np.bincount(classes.of, minlength=n)
    share = np.bincount(classes.of, weights=shares, minlength=n)
    rows = [
        (classes.colours[i], classes.names[i], float(share[i]))
        for i in range(n)
        if number[i] or i < classes.always
    ]
    assert result.facets is not None
    if some_left_over:
        rows.append((GIRDLE_COLOUR, "By single rays", 100.0 - float(share.sum())))
    elif result.facets.near_girdle >= LEAST_SHOWN:
        rows.append((GIRDLE_COLOUR, "Near the girdle", result.facets.near_girdle))
    return rows


# ---- The picture ---------------------------------------------------------------------------------------


def draw_facets(
    axes: Axes, facets: VirtualFacets, classes: FacetClasses, scale: float, *, clips: bool = False
) -> None:
    """Draw the stone's outline, hatched within, and the virtual facets onto it.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to, in the stone's units.
    facets, classes : VirtualFacets, FacetClasses
        What to draw.
    scale : float
        Inches a unit, which the edges of narrow facets go by.
    clips : bool
        Whether what lies beyond the axes is cut off, as where one may zoom in.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Polygon

    outline = silhouette(facets.stone, facets.view)
    axes.add_patch(Polygon(outline, gid="near-the-girdle", clip_on=clips, zorder=1, **_HATCHED))

    colours = colour_numbers(*classes.colours) / 255.0
    edges = colour_numbers(*edge_colours(classes.colours)) / 255.0
    dark = _luminance(classes.colours) < _DARK
    # Dark ones first: between a light and a dark one, it is the dark edge that is seen.
    order = np.argsort(~dark[classes.of], kind="stable")
    drawn, of = classes.drawn[order], classes.of[order]
    polygons = [facets.polygon(i) for i in drawn]
    around = np.array([np.hypot(*(np.roll(corners, -1, axis=0) - corners).T).sum() for corners in polygons])
    across = 72.0 * scale * 2.0 * facets.area[drawn] / around  # about the radius of the largest circle within
    collection = PolyCollection(
        polygons,
        facecolors=colours[of],
        edgecolors=edges[of],
        linewidths=np.minimum(_EDGE, _EDGE_SHARE * across),
        joinstyle="bevel",  # miters of slivers would reach far
        clip_on=clips,
        gid="virtual-facets",
        zorder=2,
    )
    axes.add_collection(collection, autolim=False)
    axes.add_patch(Polygon(outline, fill=False, edgecolor=PAPER.ink, linewidth=0.9, clip_on=clips, zorder=3))


def silhouette(stone: Stone, view: View) -> np.ndarray:
    """Return the outline of a convex stone in the view, (n, 2) [stone's unit]."""
    right, up, _ = view.basis()
    lines = look_at(stone, Projection(name="", right=right, up=up)).outline
    points = np.unique(np.concatenate(lines), axis=0)
    around = points - points.mean(axis=0)
    return np.asarray(points[np.argsort(np.arctan2(around[:, 1], around[:, 0]))])


def edge_colours(colours: Sequence[str]) -> list[str]:
    """Return the colours of the edges of facets of each colour: darker ones, of dark facets lighter ones."""
    from matplotlib.colors import to_hex

    numbers = colour_numbers(*colours) / 255.0
    dark = (_luminance(colours) < _DARK)[:, None]
    edges = np.where(dark, numbers + _TINT * (1.0 - numbers), (1.0 - _SHADE) * numbers)
    return [to_hex(edge) for edge in edges]


def _luminance(colours: Sequence[str]) -> np.ndarray:
    """Return the relative luminance of sRGB colours, (n,) from 0 to 1 (IEC 61966-2-1)."""
    numbers = colour_numbers(*colours) / 255.0
    linear = np.where(numbers <= 0.04045, numbers / 12.92, ((numbers + 0.055) / 1.055) ** 2.4)
    return np.asarray(linear @ np.array([0.2126, 0.7152, 0.0722]))


# ---- The panel -----------------------------------------------------------------------------------------


def _draw_panel(axes: Axes, result: Score, quantity: str, rows: list[tuple[str, str, float]]) -> None:
    """Draw the scores, the legend with its shares, the facets by size, and the rules."""
    y = axes.get_ylim()[1]
    assert result.bound is not None
    assert result.facets is not None
    for x, name, value in ((0.0, "Average", result.average), (2.15, "Rear", result.rear)):
        number, bound = _bounded(value, result.bound)
        axes.text(x, y - 0.22, name, fontsize=12.5, color=PAPER.soft)
        axes.text(x, y - 0.60, f"{number} %", fontsize=21, fontweight="bold", color=PAPER.ink)
        axes.text(x, y - 0.84, f"± {bound} %", fontsize=11, color=PAPER.soft)

    axes.text(0, y - _SCORES, f"Share of the view by {quantity}", fontsize=11.5, color=PAPER.soft)
    step = min(_ROW, (y - _SCORES - _SIZES - _RULES) / len(rows))
    widest = max(share for _, _, share in rows)
    for i, (colour, name, share) in enumerate(rows, start=1):
        _draw_row(axes, y - _SCORES - i * step, step / _ROW, colour, name, share, share / widest)

    _draw_sizes(axes, y - _SCORES - len(rows) * step - 0.45, result.facets)
    axes.text(0, 0, _rules(result), fontsize=9, color=PAPER.soft, va="bottom", linespacing=1.3)


def _draw_row(axes: Axes, y: float, size: float, colour: str, name: str, share: float, length: float) -> None:
    """Draw a row of the legend, reduced by a factor if there are many."""
    from matplotlib.patches import Rectangle

    filled = _HATCHED if colour == GIRDLE_COLOUR else {"facecolor": colour, "linewidth": 0.0}
    height, font = 0.17 * size, 11.5 * size
    bottom, length = y - 0.035 * size, _LONGEST * length
    axes.add_patch(Rectangle((0, bottom), 0.17, height, **filled))
    axes.add_patch(Rectangle((0, bottom), 0.17, height, fill=False, edgecolor="#888888", linewidth=0.7))
    axes.text(0.27, y, name, fontsize=font, color=PAPER.ink)
    if share:
        axes.add_patch(Rectangle((_BARS, bottom), length, height, **filled))
    axes.text(_BARS + length + 0.07, y, f"{_short(share)} %", fontsize=font, color=PAPER.ink)


def _draw_sizes(axes: Axes, y: float, sizes: FacetSizes) -> None:
    """Draw a table of the virtual facets by size: how many there are, and their share of the view."""
    columns = (0.0, 2.1, 3.1)
    axes.text(0, y, f"{sizes.number} virtual facets", fontsize=12.5, fontweight="bold", color=PAPER.ink)
    y -= 0.26

    def write(texts: tuple[str, str, str], size: float, colour: str) -> None:
        for x, text, align in zip(columns, texts, ("left", "right", "right"), strict=True):
            axes.text(x, y, text, fontsize=size, color=colour, ha=align)

    write(("Size [% of the view]", "Number", "Share"), 10, PAPER.soft)
    edges = [low for low, _, _ in sizes.classes]
    for (low, number, share), high in zip(sizes.classes, (None, *edges[:-1]), strict=True):
        y -= 0.215
        name = f"≥ {low:g}" if high is None else f"< {high:g}" if low == 0 else f"{low:g} – {high:g}"
        write((name, f"{number}", f"{_short(share)} %"), 10.5, PAPER.ink)
    if sum(share for _, _, share in sizes.classes) >= 50:
        axes.text(
            0, y - 0.25, f"The {sizes.half} largest make half of the view.", fontsize=10, color=PAPER.soft
        )


def _short(share: float) -> str:
    """Return a share with one decimal, or with one digit if it is small."""
    digits = 1 if share >= 0.05 or share <= 0 else min(-math.floor(math.log10(share)), 9)
    return f"{share:.{digits}f}"


def _bounded(value: float, bound: float) -> tuple[str, str]:
    """Return a score and its bound as every table states it; the score has as many decimals, two or more."""
    text = bound_text(bound)
    return f"{value:.{max(2, len(text.partition('.')[2]))}f}", text


def _rules(result: Score) -> str:
    """Say how the figure was made, in short lines."""
    words = model_text(result)
    for together in ("(index ", "rear light by "):  # not to be torn apart
        words = words.replace(together, together.replace(" ", "\u00a0"))
    lines = [words]
    if result.tilt_deg:
        lines.append(f"eye tilted by {result.tilt_deg:g}° towards azimuth {result.tilt_azimuth_deg:g}°")
    lines.append(how_text(result))
    if result.facets is not None and result.facets.near_girdle >= LEAST_SHOWN:
        lines.append("Average and Rear near the girdle are by single rays")
    return "\n".join(part for line in lines for part in textwrap.wrap(line, 56))

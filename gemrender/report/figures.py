"""Pictures of scored maps."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import gemrender
from gemrender.observation import Observation, RayStatus, View
from gemrender.report.dimensions import length_unit
from gemrender.report.lettering import boxes_for_letters, name_fonts, save_png
from gemrender.report.tables import LEAST_SHOWN, band_name, how_text, model_text
from gemrender.scoring import BAND_EDGES, Score, score_observation
from gemrender.stone import Stone

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "BAND_COLOURS",
    "OUTSIDE_COLOUR",
    "REAR_COLOUR",
    "UNSOLVED_COLOUR",
    "colour_numbers",
    "draw_scales",
    "map_figure",
    "map_page",
    "map_picture",
    "picture_of_rows",
    "write_map_figure",
]

#: Colours of the bands, brightest first: from viridis, at the places where all colours of the picture are
#: furthest apart for eyes with and without colour blindness.
BAND_COLOURS = ("#fde725", "#67cc5c", "#1e9c89", "#2b748e", "#3f4889", "#440154")
#: Rear light, and rays that are trapped or lost: apart from the scale.
REAR_COLOUR = "#141414"
UNSOLVED_COLOUR = "#f781bf"
OUTSIDE_COLOUR = "#ffffff"

#: Least and most pixels a side of the map in the picture: smaller maps are enlarged, larger ones reduced,
#: both by whole numbers.
MAP_PIXELS = (800, 1600)

# The page: a square map with margins for axes and title, and a panel with the shares [inch].
_MAP, _LEFT, _BOTTOM, _TOP, _GAP, _PANEL, _RIGHT = 6.0, 0.95, 0.85, 0.8, 0.45, 3.9, 0.3
_GREY = "#666666"


def map_figure(observation: Observation) -> Figure:
    """Draw the intensity map in its bands, with Average, Rear and the share of each band beside it.

    Each pixel of the picture shows one ray, or the same whole number of rays as every other: facets keep
    their edges.

    Parameters
    ----------
    observation : Observation
        The maps.

    Returns
    -------
    matplotlib.figure.Figure
        To be saved at its own resolution (`write_map_figure`).
    """
    figure, panel = map_page([map_picture(observation)], observation.view, observation.stone)
    _draw_panel(panel, score_observation(observation))
    return figure


def map_page(
    images: Sequence[np.ndarray], view: View, stone: Stone, captions: Sequence[str] = ()
) -> tuple[Figure, Axes]:
    """Lay out maps of a view side by side, with scales and the stone's name, and room for numbers.

    Parameters
    ----------
    images : sequence of (n, n, 3) uint8
        The maps, pixel by pixel, all of one size (`picture_of_rows`).
    view, stone : View, Stone
        What they are maps of.
    captions : sequence of str
        What to write above each; by default nothing.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The page.
    panel : matplotlib.axes.Axes
        What is to the right of the maps, still empty.
    """
    from matplotlib.figure import Figure

    side = images[0].shape[0]
    dpi = side / _MAP
    maps = len(images) * (_LEFT + _MAP)
    width, height = (round(inches * dpi) for inches in (maps + _GAP + _PANEL + _RIGHT, _BOTTOM + _MAP + _TOP))
    bottom = round(_BOTTOM * dpi)
    figure = Figure(figsize=((width + 0.5) / dpi, (height + 0.5) / dpi), dpi=dpi)  # truncated to pixels
    for k, image in enumerate(images):
        left = round((k * (_LEFT + _MAP) + _LEFT) * dpi)
        figure.figimage(image, left, bottom, origin="upper")  # pixel by pixel: an axes would resample
        box = left / width, bottom / height, side / width, side / height
        axes = figure.add_axes(box, facecolor="none")
        _draw_axes(axes, view, stone)
        if captions:
            axes.set_title(captions[k], loc="right", fontsize=11, pad=4, color=_GREY)
    box = (maps + _GAP) * dpi / width, bottom / height, _PANEL * dpi / width, side / height
    above = (0.3 if captions else 0.22) * dpi
    _draw_title(figure, stone.name, round(_LEFT * dpi) / width, (bottom + side + above) / height)
    return figure, figure.add_axes(box)


def write_map_figure(observation: Observation, path: Path) -> None:
    """Write the map's figure as PNG."""
    save_png(map_figure(observation), path, metadata={"Title": observation.stone.name})


# ---- The parts of the page -----------------------------------------------------------------------------


def _draw_axes(axes: Axes, view: View, stone: Stone) -> None:
    """Draw a scale to the left of and below the map."""
    half, resolution = view.half_width, view.resolution
    tilted = view.tilt_deg != 0
    reduction = _reduction(resolution)
    width = 2 * half * -(-resolution // reduction) * reduction / resolution  # with the last pixel's part
    axes.set(xlim=(-half, width - half), ylim=(half - width, half))
    draw_scales(axes, length_unit(stone), tilted=tilted, font_size=13)


def draw_scales(axes: Axes, unit: str, *, tilted: bool, font_size: float) -> None:
    """Draw a scale to the left of and below a map, from -1 to 1 of a unit, such as "girdle radius"."""
    axes.set_axis_on()
    axes.patch.set_visible(False)
    axes.spines[["top", "right"]].set_visible(False)
    for side, label, axis in (("bottom", "x", axes.xaxis), ("left", "y", axes.yaxis)):
        axes.spines[side].set_position(("outward", 7))
        axes.spines[side].set_bounds(-1, 1)
        axis.set_ticks(np.linspace(-1, 1, 5), ["−1", "−0.5", "0", "0.5", "1"], fontsize=font_size)
        axis.set_label_text(f"{label}{' in the view' if tilted else ''} [{unit}]", fontsize=font_size)


def _draw_panel(axes: Axes, result: Score) -> None:
    """Draw the numbers: the two scores, the shares as bars in the map's colours, and the rules."""
    rows = [
        (colour, f"{band_name(band, typeset=True)} %", band.share)
        for colour, band in zip(BAND_COLOURS, result.bands, strict=True)
    ]
    rows.append((REAR_COLOUR, "Rear", result.rear))
    unsolved = {"Trapped": result.trapped, "Lost": result.lost}
    if any(share >= LEAST_SHOWN for share in unsolved.values()):
        name = " + ".join(name for name, share in unsolved.items() if share >= LEAST_SHOWN)
        rows.append((UNSOLVED_COLOUR, name, sum(unsolved.values())))

    # One unit down is one row; across, 0 to 1.
    axes.set(xlim=(0, 1), ylim=(14.5, 0))
    axes.set_axis_off()
    for x, name, value in ((0.0, "Average", result.average), (0.52, "Rear", result.rear)):
        axes.text(x, 0.75, name, fontsize=15, color=_GREY)
        axes.text(x, 1.75, f"{value:.2f} %", fontsize=25, fontweight="bold")
    measure = "primary intensity" if result.intensity == "primary" else "radiance"
    axes.text(0, 3.35, f"Share of the top view by {measure}", fontsize=13, color=_GREY)
    widest = max(share for _, _, share in rows)
    for y, (colour, name, share) in enumerate(rows, start=4):
        digits = 1 if share >= 0.05 or share == 0 else -math.floor(math.log10(share))
        axes.scatter(0.035, y, s=190, marker="s", facecolor=colour, edgecolor="#888888", linewidth=0.8)
        axes.text(0.095, y, name, fontsize=14, va="center_baseline")
        length = 0.42 * share / widest
        axes.barh(y, length, left=0.35, height=0.62, color=colour)
        axes.text(0.365 + length, y, f"{share:.{digits}f} %", fontsize=14, va="center_baseline")
    axes.text(0, 14.5, _rules(result), fontsize=11, color=_GREY, va="bottom", linespacing=1.35)


def _rules(result: Score) -> str:
    """Say how the map was made, in short lines."""
    lines = [model_text(result).replace("(index ", "(index\u00a0")]  # not to be torn apart
    if result.tilt_deg:
        lines.append(f"eye tilted by {result.tilt_deg:g}° towards azimuth {result.tilt_azimuth_deg:g}°")
    lines += [
        how_text(result),
        f"gemrender {gemrender.__version__}",
    ]
    return "\n".join(part for line in lines for part in textwrap.wrap(line, 47))


def _draw_title(figure: Figure, name: str, x: float, y: float) -> None:
    """Write the stone's name, long ones smaller and on two lines."""
    lines = textwrap.wrap(name, 56)
    size = 20.0 if len(lines) == 1 else 15.0
    title = figure.text(
        x, y, "\n".join(lines), fontsize=size, fontweight="bold", family=name_fonts(), parse_math=False
    )
    with boxes_for_letters():
        wanted = title.get_window_extent().width
    title.set_fontsize(min(size, size * 0.98 * (1 - x) * figure.bbox.width / wanted))


# ---- The map as a picture ------------------------------------------------------------------------------


def map_picture(observation: Observation) -> np.ndarray:
    """Return the map in its colours, as `picture_of_rows` does."""
    colours = _palette()
    return picture_of_rows(
        lambda rows: colours[_colour_index(observation, rows)], observation.view.resolution
    )


def picture_of_rows(colours: Callable[[slice], np.ndarray], resolution: int) -> np.ndarray:
    """Return a map as a picture, (n, n, 3) uint8, n within `MAP_PIXELS`.

    A pixel shows one ray, or the mean colour of a whole number of rays a side.

    Parameters
    ----------
    colours : callable
        Returns the colours of some rows of the map, (m, resolution, 3), 0 to 255.
    resolution : int
        Rays a side.
    """
    reduction = _reduction(resolution)
    side = -(-resolution // reduction)
    image = np.empty((side, side, 3), dtype=np.uint8)
    outside = int(colour_numbers(OUTSIDE_COLOUR)[0, 0])  # a grey
    for row in range(side):  # row by row: colours take ten times the room of the map
        rows = colours(slice(row * reduction, (row + 1) * reduction))
        if reduction > 1:
            missing = (0, side * reduction - resolution)
            rows = np.pad(rows, ((0, reduction - len(rows)), missing, (0, 0)), constant_values=outside)
            rows = rows.reshape(reduction, side, reduction, 3).mean(axis=(0, 2))
        image[row] = np.rint(rows)
    enlargement = -(-MAP_PIXELS[0] // side)
    return image.repeat(enlargement, axis=0).repeat(enlargement, axis=1)


def _reduction(resolution: int) -> int:
    """Return how many rays a side make one pixel of the picture."""
    return -(-resolution // MAP_PIXELS[1])


def _palette() -> np.ndarray:
    """Return the colours of bands, rear light, unsolved rays and what lies outside, (9, 3) uint8."""
    return colour_numbers(*BAND_COLOURS, REAR_COLOUR, UNSOLVED_COLOUR, OUTSIDE_COLOUR)


def colour_numbers(*colours: str) -> np.ndarray:
    """Return colours such as "#fde725" as numbers, (n, 3) uint8."""
    return np.array([list(bytes.fromhex(colour[1:])) for colour in colours], dtype=np.uint8)


def _colour_index(observation: Observation, rows: slice) -> np.ndarray:
    """Return the place of each pixel's colour in the palette."""
    status = observation.status[rows]
    index: Any = np.digitize(
        observation.primary_intensity[rows], BAND_EDGES[:-1]
    )  # decreasing: 0 is brightest
    rear = len(BAND_COLOURS)
    index[observation.rear_mask[rows] > 0] = rear
    index[(status == RayStatus.TRAPPED) | (status == RayStatus.LOST)] = rear + 1
    index[status == RayStatus.MISSED] = rear + 2
    return np.asarray(index)

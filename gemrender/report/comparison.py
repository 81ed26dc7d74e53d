"""Stones side by side: tables in several formats, maps on one colour scale, differences of two stones."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gemrender.errors import InputError
from gemrender.observation import Observation, RayStatus
from gemrender.report.figures import BAND_COLOURS, REAR_COLOUR, UNSOLVED_COLOUR, map_picture
from gemrender.report.formats import format_csv, format_json, format_markdown
from gemrender.report.lettering import name_fonts, save_png
from gemrender.report.tables import band_name, how_text, model_text, score_record, score_tables, value_text
from gemrender.scoring import Score, score_observation
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "Panel",
    "comparison_figure",
    "difference_figure",
    "format_scores",
    "panel",
    "write_comparison",
]

#: Most maps in one figure; of more stones it shows the bars only.
MOST_MAPS = 60
#: Longest side of the figure [pixels]; matplotlib draws none of 2^16 and more.
MOST_PIXELS = 60_000
#: Pixels a side that a map is kept at for the figure.
PANEL_PIXELS = 400

#: Most values of further measures beside the bars, and the width of each [inches].
MOST_VALUES, VALUE_WIDTH = 4, 0.8

_INK, _GREY = "#222222", "#666666"

#: A stone in a comparison: its scores and its map, small, (n, n, 3) uint8.
Panel = tuple[Score, np.ndarray]


def panel(observation: Observation, result: Score | None = None) -> Panel:
    """Return what a comparison keeps of an observation, so that many need little memory.

    Parameters
    ----------
    observation : Observation
        The maps.
    result : Score, optional
        The stone's score, such as one with further measures; by default that of the observation.
    """
    picture = map_picture(observation)
    step = max(1, len(picture) // PANEL_PIXELS)
    side = len(picture) // step
    blocks = picture[: side * step, : side * step].reshape(side, step, side, step, 3)
    # The mean, by adding whole pictures: over axes as short as these numpy's takes eight times as long.
    added = np.zeros((side, side, 3), dtype=np.uint32)
    for i, j in np.ndindex(step, step):
        added += blocks[:, i, :, j]
    return result or score_observation(observation), (added // step**2).astype(np.uint8)


def format_scores(scores: Sequence[Score], form: str) -> str:
    """Return a table of the scores as "csv", "json" or "markdown"; all in per cent.

    Raises
    ------
    InputError
        Another format.
    """
    if form == "json":
        return format_json([s.to_dict() for s in scores])
    if form == "csv":
        return format_csv([score_record(s) for s in scores])
    if form == "markdown":
        return format_markdown(score_tables(scores))
    raise InputError("must be one of csv, json, markdown", key="format", value=form)


def comparison_figure(panels: Sequence[Panel]) -> Figure:
    """Draw maps side by side on one colour scale, and the bands of all stones as bars.

    Parameters
    ----------
    panels : sequence of Panel
        The stones, in order; of more than 60 the bars only.
    """
    from matplotlib.figure import Figure

    n = len(panels)
    columns = min(n, 3 if n <= 3 else 4 if n <= 12 else 6)
    rows = 0 if n > MOST_MAPS else math.ceil(n / columns)
    width = max(7.6, 2.7 * columns) if rows else 10.0
    width = max(width, 7.6 + VALUE_WIDTH * len(_further(panels[0][0])))
    map_height, bar_height = (width / columns) + 0.62 if rows else 0.0, 0.34 * n + 1.4
    height = rows * map_height + bar_height
    # No picture may be longer than 2^16 pixels: of very many stones it is a little coarser.
    dpi = min(130 if n <= 12 else 100, MOST_PIXELS / height)
    figure = Figure(figsize=(width, height), dpi=dpi)
    for i, (result, picture) in enumerate(panels[: rows * columns]):
        row, column = divmod(i, columns)
        left, bottom = column * width / columns + 0.12, height - (row + 1) * map_height + 0.08
        side = width / columns - 0.24
        axes = figure.add_axes((left / width, bottom / height, side / width, side / height))
        axes.imshow(picture, interpolation="antialiased")
        axes.set_axis_off()
        _caption(figure, left / width, (bottom + side) / height, height, result)
    _draw_bars(figure, [result for result, _ in panels], width, height, bar_height)
    return figure


def _caption(figure: Figure, x: float, y: float, height: float, result: Score) -> None:
    name = textwrap.shorten(result.name, 30, placeholder=" …")
    figure.text(
        x,
        y + 0.33 / height,
        name,
        fontsize=12,
        fontweight="bold",
        color=_INK,
        family=name_fonts(),
        parse_math=False,
    )
    text = f"Average {result.average:.2f} %    Rear {result.rear:.2f} %"
    figure.text(x, y + 0.1 / height, text, fontsize=10, color=_GREY)


def _draw_bars(
    figure: Figure, scores: Sequence[Score], width: float, height: float, bar_height: float
) -> None:
    """Draw a bar a stone: the shares of its bands, then Rear; the legend beneath."""
    from matplotlib.patches import Patch

    further = [_further(score) for score in scores]
    name_width, value_width = min(2.6, 0.3 * width), 1.05 + VALUE_WIDTH * len(further[0])
    axes = figure.add_axes(
        (
            name_width / width,
            0.86 / height,
            (width - name_width - value_width) / width,
            (bar_height - 1.25) / height,
        )
    )
    colours = (*BAND_COLOURS, REAR_COLOUR, UNSOLVED_COLOUR)
    rows = np.arange(len(scores))
    shares = np.array([[*(b.share for b in s.bands), s.rear, s.trapped + s.lost] for s in scores])
    starts = np.cumsum(shares, axis=1) - shares
    for colour, share, start in zip(colours, shares.T, starts.T, strict=True):
        axes.barh(rows, share, left=start, height=0.72, color=colour, edgecolor="white", linewidth=0.4)
    per_inch = 100.0 / (width - name_width - value_width)
    places = [101 + per_inch * VALUE_WIDTH * (k + 1) for k in range(len(further[0]))]
    for y, s in enumerate(scores):
        axes.text(101, y, f"{s.average:.2f}", va="center", fontsize=10.5, fontweight="bold", color=_INK)
        for x, (_, value) in zip(places, further[y], strict=True):
            axes.text(x, y, value, va="center", fontsize=10.5, color=_INK)
    axes.set(xlim=(0, 100), ylim=(len(scores) - 0.5, -0.5))
    axes.set_yticks(
        range(len(scores)),
        [textwrap.shorten(s.name, 26, placeholder=" …") for s in scores],
        fontsize=10.5,
        family=name_fonts(),
        parse_math=False,
    )
    axes.set_xticks(range(0, 101, 20), [f"{x} %" for x in range(0, 101, 20)], fontsize=9.5, color=_GREY)
    axes.tick_params(length=0)
    axes.spines[["top", "right", "left", "bottom"]].set_visible(False)
    for x, name in zip([101, *places], ["Average", *(name for name, _ in further[0])], strict=True):
        axes.text(x, -0.62, name, fontsize=9.5, color=_GREY, va="bottom")
    names = [f"{band_name(b, typeset=True)} %" for b in scores[0].bands]
    handles = [Patch(facecolor=c, label=t) for c, t in zip(colours, [*names, "Rear"], strict=False)]
    figure.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.1 / width, 0.24 / height),
        ncols=len(handles),
        frameon=False,
        fontsize=9.5,
        handlelength=1.0,
        handleheight=1.0,
        handletextpad=0.4,
        columnspacing=1.0,
        borderpad=0.0,
    )
    models = {model_text(s) for s in scores}
    rules = models.pop() if len(models) == 1 else "by the rules of each stone's material"
    ways = {how_text(s) if s.bound is None else s.engine for s in scores}
    text = f"{ways.pop() if len(ways) == 1 else 'by several engines'}, {rules}"
    figure.text(0.14 / width, 0.1 / height, text, fontsize=8.5, color=_GREY)


def _further(score: Score) -> list[tuple[str, str]]:
    """Return the first values of further measures, with names: of each its one, or all of them."""
    found = []
    for of in score.measures or ():
        if of.name == "inoue":
            continue
        keys = ["value"] if "value" in of.values else list(of.values)
        names = [of.name if key == "value" else f"{of.name}\n{key.replace('_', ' ')}" for key in keys]
        found += [(name, value_text(of.values[key], of.bound)) for name, key in zip(names, keys, strict=True)]
    return found[:MOST_VALUES]


def difference_figure(first: Observation, second: Observation) -> Figure:
    """Draw where the first stone sends more light to the eye than the second, and where less.

    The maps lie on each other by their middles, half a length on a half length or a girdle radius. One that
    is of another width is sampled at the nearest pixels of the other.

    Raises
    ------
    ValueError
        The maps are of different directions of the eye.
    """
    from matplotlib.figure import Figure

    if _direction(first) != _direction(second):
        raise ValueError("the maps are of different views")
    a, b = score_observation(first), score_observation(second)
    intensities, statuses = _on_one_grid(first, second)
    difference = intensities[0].astype(np.float64) - intensities[1]
    outside = (statuses[0] == RayStatus.MISSED) | (statuses[1] == RayStatus.MISSED)
    figure = Figure(figsize=(8.2, 6.6), dpi=130)
    axes: Axes = figure.add_axes((0.03, 0.04, 0.76, 0.82))
    image = axes.imshow(
        np.ma.masked_array(difference, outside),
        cmap="PuOr_r",
        vmin=-100,
        vmax=100,
        interpolation="antialiased",
        interpolation_stage="rgba",
    )
    axes.set_axis_off()
    scale = figure.add_axes((0.83, 0.12, 0.028, 0.62))
    bar = figure.colorbar(image, cax=scale)
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=10, length=0)
    bar.set_ticks([-100, -50, 0, 50, 100], labels=["−100", "−50", "0", "+50", "+100"])
    scale.set_title("Δ intensity\n[%]", fontsize=10, color=_GREY, loc="left", pad=10)
    one, other = (textwrap.shorten(s.name, 34, placeholder=" …") for s in (a, b))
    title = f"{one} minus {other}"
    figure.text(
        0.035, 0.945, title, fontsize=15, fontweight="bold", color=_INK, family=name_fonts(), parse_math=False
    )
    text = f"Average {a.average - b.average:+.2f} %    Rear {a.rear - b.rear:+.2f} %".replace("-", "−")
    figure.text(0.035, 0.895, text, fontsize=11.5, color=_GREY)
    return figure


def _direction(observation: Observation) -> tuple[float, float]:
    """Return the eye's tilt and its azimuth [deg]; straight above there is no azimuth."""
    view = observation.view
    return view.tilt_deg, view.tilt_azimuth_deg % 360.0 if view.tilt_deg else 0.0


def _on_one_grid(
    first: Observation, second: Observation
) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """Return the intensities and the statuses of two maps, pixel by pixel of the wider of both views."""
    maps = [(o.primary_intensity, o.status) for o in (first, second)]
    views = [first.view, second.view]
    wide = max(views, key=lambda view: (view.half_width, view.resolution))
    x, y = wide.cell_centres()
    for k, view in enumerate(views):
        if (view.half_width, view.resolution) == (wide.half_width, wide.resolution):
            continue
        column, row = (
            np.floor((along + view.half_width) / (2 * view.half_width) * view.resolution).astype(np.int64)
            for along in (x, -y)
        )
        inside = [(index >= 0) & (index < view.resolution) for index in (row, column)]
        row, column = (np.clip(index, 0, view.resolution - 1) for index in (row, column))
        intensity, status = (array[np.ix_(row, column)] for array in maps[k])
        maps[k] = intensity, np.where(np.logical_and.outer(*inside), status, RayStatus.MISSED)
    (a, a_status), (b, b_status) = maps
    return (a, b), (a_status, b_status)


def write_comparison(panels: Sequence[Panel], pair: Sequence[Observation], folder: Path) -> list[Path]:
    """Write comparison.png, .csv and .json, and difference.png of a pair; all of them or none."""
    scores = [result for result, _ in panels]
    wanted: dict[str, Callable[[Path], object]] = {
        "comparison.png": lambda path: save_png(comparison_figure(panels), path),
        "comparison.csv": lambda path: path.write_text(format_scores(scores, "csv") + "\n", encoding="utf-8"),
        "comparison.json": lambda path: path.write_text(format_scores(scores, "json"), encoding="utf-8"),
    }
    if len(pair) == 2:
        wanted["difference.png"] = lambda path: save_png(difference_figure(*pair), path)
    return write_whole(folder, wanted)

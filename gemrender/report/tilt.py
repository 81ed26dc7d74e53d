"""What a tilt study found: as a table, as records, and as a figure of curves or polar maps."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.measures import Measure
from gemrender.observation import bound_text
from gemrender.report.formats import Column, TextTable
from gemrender.report.lettering import name_fonts, save_png
from gemrender.report.measure_maps import ZONE_COLOURS
from gemrender.report.tables import measure_columns
from gemrender.sweep import TiltStudy
from gemrender.sweep.tilt import Tie, TiltedValues
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "axis_name",
    "draw_curves",
    "shown_keys",
    "tilt_figure",
    "tilt_records",
    "tilt_table",
    "write_tilt_figure",
]

#: What is shown of measures that have more than one value to show; machines get all.
_SHOWN = {
    "inoue": ("average", "rear"),
    "aset": ("green", "red", "blue", "leak"),
    "extinction": ("head", "late_leak"),
    "facets": ("number", "half"),
}
#: Colours of a measure's curves; zones of an ASET have those of their maps.
_COLOURS = ("#1e9c89", "#3f4889", "#c2571a", "#8a5aa8", "#6b7a2b", "#444444")
_INK, _GREY = "#222222", "#666666"
#: From so many panels about one axis on they stand in two columns.
_TALL = 4
#: The least that is tied where people are told: what is seen in two decimals [%].
_LEAST_TIED = 0.005
#: Poses that a note names; of more it says how many there are.
_MOST_NAMED = 8


def shown_keys(measure: Measure) -> tuple[str, ...]:
    """Return the names of the values that people are shown of a measure."""
    if measure.name in _SHOWN:
        return _SHOWN[measure.name]
    if "value" in measure.keys:
        return ("value",)
    return measure.keys or measure.detail_keys


def axis_name(axis_deg: float) -> str:
    """Return the name of an axis by its azimuth [deg]."""
    return {0.0: "x", 90.0: "y"}.get(axis_deg, f"azimuth {axis_deg:g} deg")


# ---- In words and numbers ------------------------------------------------------------------------------


def tilt_table(studies: Sequence[TiltStudy]) -> TextTable:
    """Return a row for each value of each measure about each axis: upright, lowest, highest, mean."""
    numbers = ["Upright", "Lowest", "at", "Highest", "at", "Mean", "Bound"]
    ranks = [0, 0, 1, 0, 1, 2, 3]
    table = TextTable([
        Column("Stone", is_text=True),
        Column("About", is_text=True),
        Column("Measure", is_text=True),
        *map(Column, numbers, ranks),
    ])  # fmt: skip
    for study in studies:
        groups = {"all axes": study.found} if study.is_surface else _by_name(study)
        rows = [
            (about, found, of, key)
            for about, found in groups.items()
            for of in study.measures
            for key in shown_keys(of)
        ]
        for number, (about, found, of, key) in enumerate(rows):
            is_first = number == 0 or rows[number - 1][0] != about
            table.rows.append(
                [
                    "" if number else study.name,
                    about if is_first else "",
                    _label(of, key),
                    *_row(found, of, key),
                ]
            )
    first = studies[0]
    where = "tilt and azimuth of the eye" if first.is_surface else "turn"
    table.note(f"{rule_text(first)}. At: {where} [deg].")
    table.note(f"{_units_in_words(first)}.")
    for study in studies:
        for words in (*_ties_in_words(study), *_notes(study)):
            table.note(f"{study.name}: {words}.", "yellow")
    return table


def _units_in_words(study: TiltStudy) -> str:
    others = {
        f"{_label(of, key)} in {of.unit}" if _unit(of, key) else f"{_label(of, key)} a number"
        for of in study.measures
        for key in shown_keys(of)
        if _unit(of, key) != "%"
    }
    return f"In per cent; {', '.join(sorted(others))}" if others else "All in per cent"


def _by_name(study: TiltStudy) -> dict[str, tuple[TiltedValues, ...]]:
    return {axis_name(axis): found for axis, found in study.curves().items()}


def _row(found: Sequence[TiltedValues], of: Measure, key: str) -> list[str]:
    values = np.array([each.value(of.name, key) for each in found])
    if not np.isfinite(values).any():
        return ["–"] * 7
    # Of equal ones the last: the right-handed turn.
    low, high = (int(np.flatnonzero(values == extreme(values))[-1]) for extreme in (np.nanmin, np.nanmax))
    upright = next(value for value, each in zip(values, found, strict=True) if each.pose.turn_deg == 0)
    is_surface = len({each.pose.axis_deg for each in found}) > 1
    bound = np.array([each.bound(of.name) for each in found])
    has_bound = key in of.keys and np.isfinite(bound).all()
    return [
        _number(upright),
        _number(values[low]),
        _place(found[low], is_surface),
        _number(values[high]),
        _place(found[high], is_surface),
        _number(float(np.average(values, weights=_weights(found, is_surface)))),
        f"±{bound_text(float(bound.max()))}" if has_bound else "–",
    ]


def _weights(found: Sequence[TiltedValues], is_surface: bool) -> np.ndarray | None:
    """Return what each pose of a surface stands for, its solid angle but for a factor; None of curves."""
    if not is_surface:
        return None
    tilts = np.array([each.pose.eye[0] for each in found])
    around = np.array([np.count_nonzero(tilts == tilt) for tilt in tilts])
    return np.where(tilts > 0, np.sin(np.radians(tilts)) / around, 0.0)


def _number(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.2f}"


def _place(found: TiltedValues, is_surface: bool) -> str:
    tilt, azimuth = found.pose.eye
    return f"{tilt:g}, {azimuth:g}" if is_surface else f"{found.pose.turn_deg:g}"


def _label(of: Measure, key: str) -> str:
    return of.name if key == "value" else f"{of.name} {key.replace('_', ' ')}"


def _unit(of: Measure, key: str) -> str:
    return of.unit if key in of.keys else ""


def rule_text(study: TiltStudy) -> str:
    """Say in words what was turned, how far, and what traced it."""
    turns = [found.pose.turn_deg for found in study.found]
    if study.is_surface:
        how = f"All tilts up to {max(turns):g} deg, {len(turns)} poses"
    else:
        axes = " and ".join(map(axis_name, study.curves()))
        how = f"Turned about {axes} from {min(turns):g} to {max(turns):g} deg, {len(turns)} poses"
    return f"{how}, head {study.head_deg:g} deg, {study.engine}"


def _ties_in_words(study: TiltStudy) -> list[str]:
    """Name the poses where light is tied, and how much."""
    ties: dict[tuple[str, str], list[Tie]] = {}
    for tie in study.ties():
        if tie.amount >= _LEAST_TIED:
            ties.setdefault((tie.measure, tie.key), []).append(tie)
    words = []
    for (measure, key), of in ties.items():
        shown = [
            f"{tie.amount:.2g} about {axis_name(tie.pose.axis_deg)} by {tie.pose.turn_deg:g}" for tie in of
        ]
        more = len(shown) - _MOST_NAMED
        what = measure if key == "tied" else f"{measure} ({key.replace('_', ' ')})"
        rest = f" and at {more} more poses" if more > 0 else ""
        words.append(f"{what}: exactly at a limit {', '.join(shown[:_MOST_NAMED])}{rest}")
    return words


def _notes(study: TiltStudy) -> list[str]:
    """Say what was asked for and not reached, and at how many poses."""
    by_words: dict[str, list[TiltedValues]] = {}
    for found in study.found:
        for words in found.notes:
            by_words.setdefault(words, []).append(found)
    return [
        f"{words} (about {axis_name(of[0].pose.axis_deg)} by {of[0].pose.turn_deg:g}"
        + (f" and at {len(of) - 1} more poses)" if len(of) > 1 else ")")
        for words, of in by_words.items()
    ]


def tilt_records(study: TiltStudy) -> list[dict[str, Any]]:
    """Return a flat record for each pose, with all values of its measures, bounds and versions."""
    values = study.to_dict()
    return [
        {
            "name": study.name,
            **{key: pose[key] for key in ("axis_deg", "turn_deg", "tilt_deg", "tilt_azimuth_deg")},
            **measure_columns(pose["measures"]),
            "notes": pose["notes"],
        }
        for pose in values["poses"]
    ]


# ---- As a figure ---------------------------------------------------------------------------------------


def tilt_figure(study: TiltStudy) -> Figure:
    """Draw curves with their bounds, a panel for each measure; or a polar map for each value of a surface."""
    return _surface_figure(study) if study.is_surface else _curve_figure(study)


def write_tilt_figure(study: TiltStudy, path: Path) -> Path:
    """Write the figure as PNG, whole or not at all; return its path."""
    figure = tilt_figure(study)
    return write_whole(path.parent, {path.name: lambda part: save_png(figure, part)})[0]


def _page(study: TiltStudy, rows: int, columns: int, width: float, height: float) -> Figure:
    """Return a figure for panels of a size [inch], with the stone's name and the rule on it."""
    from matplotlib.figure import Figure

    whole = rows * height + 1.0
    figure = Figure(figsize=(columns * width, whole), dpi=140)
    left = 0.35 / (columns * width)
    figure.text(left, 1 - 0.38 / whole, study.name, fontsize=16, fontweight="bold", color=_INK,
                family=name_fonts(), parse_math=False)  # fmt: skip
    how = "\nOutwards the tilt, around the azimuth that the eye is tilted to" if study.is_surface else ""
    figure.text(left, 1 - 0.55 / whole, rule_text(study) + how, fontsize=10, color=_GREY, va="top")
    return figure


def _curve_figure(study: TiltStudy) -> Figure:
    curves = study.curves()
    columns = 2 if len(curves) == 1 and len(study.measures) >= _TALL else len(curves)
    panels = [(axis, of) for of in study.measures for axis in curves]
    rows = math.ceil(len(panels) / columns)
    width, height = (7.6, 3.0) if columns == 1 else (5.6, 2.7)
    figure = _page(study, rows, columns, width, height)
    page_width, page_height = columns * width, rows * height + 1.0
    for number, (axis, of) in enumerate(panels):
        row, column = divmod(number, columns)
        place = (
            (column * width + 0.75) / page_width,
            (page_height - 1.0 - (row + 1) * height + 0.62) / page_height,
            (width - 1.75) / page_width,
            (height - 1.0) / page_height,
        )
        axes = figure.add_axes(place)
        draw_curves(axes, of, curves[axis])
        axes.set_xlabel(f"turned about {axis_name(axis).replace(' deg', '°')} by [°]", fontsize=10)
    return figure


def draw_curves(axes: Axes, of: Measure, along: Sequence[TiltedValues]) -> None:
    """Draw the values of a measure about one axis, each with its bound, and rings where light is tied."""
    turns = np.array([found.pose.turn_deg for found in along])
    bounds = np.array([found.bound(of.name) for found in along])
    ends: list[tuple[float, str, str]] = []
    for number, key in enumerate(shown_keys(of)):
        values = np.array([found.value(of.name, key) for found in along])
        colour = ZONE_COLOURS[key] if of.name == "aset" else _COLOURS[number % len(_COLOURS)]
        axes.plot(turns, values, color=colour, linewidth=1.8)
        if key in of.keys:
            axes.fill_between(turns, values - bounds, values + bounds, color=colour, alpha=0.25, linewidth=0)
            tied = _is_tied(of, along)
            axes.plot(turns[tied], values[tied], "o", markersize=6, mfc="white", mec=colour, mew=1.4)
        if np.isfinite(values[-1]):
            ends.append((float(values[-1]), key, colour))
    axes.set_xlim(turns[0], turns[-1])
    axes.axvline(0.0, color="#bbbbbb", linewidth=0.8, zorder=0)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=9.5, length=3)
    axes.set_ylabel(_unit(of, shown_keys(of)[0]), fontsize=10)
    axes.set_title(of.name, loc="left", fontsize=11.5, fontweight="bold", color=_INK)
    if of.keys and np.isfinite(bounds).all():
        axes.set_title(f"within ±{bound_text(float(bounds.max()))}", loc="right", fontsize=9, color=_GREY)
    if not ends:
        axes.text(0.5, 0.5, "not defined for this stone", transform=axes.transAxes, ha="center", color=_GREY)
        axes.set_yticks([])
    _name_curves(axes, ends if len(ends) > 1 else [])


def _is_tied(of: Measure, along: Sequence[TiltedValues]) -> np.ndarray:
    """Tell at which poses light is tied, (n,) bool."""
    keys = [key for key in of.keys if key == "tied" or key.endswith("_tied")]
    return np.array(
        [any(found.value(of.name, key) >= _LEAST_TIED for key in keys) for found in along], dtype=bool
    )


def _name_curves(axes: Axes, ends: Sequence[tuple[float, str, str]]) -> None:
    """Write each curve's name at its end, names apart from each other."""
    low, high = axes.get_ylim()
    height = 0.105 * (high - low)  # of a line of text
    places: list[float] = []
    for value, key, colour in sorted(ends):
        places.append(max(value, places[-1] + height) if places else value)
        axes.annotate(
            key.replace("_", " "), (1.01, places[-1]), xycoords=("axes fraction", "data"), fontsize=9.5,
            color=colour, va="center", annotation_clip=False,
        )  # fmt: skip


def _surface_figure(study: TiltStudy) -> Figure:
    maps = [(of, key) for of in study.measures for key in shown_keys(of)]
    columns = min(len(maps), 2 if len(maps) < 5 else 3)
    rows = math.ceil(len(maps) / columns)
    width, height = 5.0, 4.7
    figure = _page(study, rows, columns, max(width, 7.6 if columns == 1 else 0.0), height)
    page_width, page_height = figure.get_size_inches()
    for number, (of, key) in enumerate(maps):
        row, column = divmod(number, columns)
        place = (
            (column * page_width / columns + 0.55) / page_width,
            (page_height - 1.0 - (row + 1) * height + 0.45) / page_height,
            (page_width / columns - 0.9) / page_width,
            (height - 1.05) / page_height,
        )
        axes = figure.add_axes(place, projection="polar")
        _draw_polar_map(axes, study, of, key)
    return figure


def _draw_polar_map(axes: Axes, study: TiltStudy, of: Measure, key: str) -> None:
    """Draw a value over all tilts: outwards the tilt, around the azimuth that the eye is tilted to."""
    from matplotlib.ticker import MaxNLocator

    values, tilts = study.values(of.name, key), np.array([found.pose.eye[0] for found in study.found])
    rings = np.unique(tilts[tilts > 0])
    grid = values[1:].reshape(len(rings), -1)
    # The azimuths of a ring's poses begin at 90 degrees, those of the axes at 0.
    start = np.radians([found.pose.eye[1] for found in study.found[1 : 1 + grid.shape[1]]])
    order = np.argsort(start)
    grid, azimuths = grid[:, order], start[order]
    grid = np.concatenate([np.full((1, grid.shape[1]), values[0]), grid])
    grid = np.concatenate([grid, grid[:, :1]], axis=1)
    azimuths = np.append(azimuths, azimuths[0] + 2 * np.pi)
    shown = axes.pcolormesh(
        azimuths, np.concatenate([[0.0], rings]), grid, shading="gouraud", cmap="viridis", rasterized=True
    )
    tied = _is_tied(of, study.found)
    if tied.any():
        around = np.radians([found.pose.eye[1] for found in study.found])
        axes.plot(around[tied], tilts[tied], ".", markersize=3, color="white", mec=_INK, mew=0.3)
    axes.set_ylim(0, rings[-1])
    round_tilts = MaxNLocator(3, steps=[1, 2, 5, 10]).tick_values(0, rings[-1])
    ticks = [tick for tick in round_tilts if 0 < tick <= rings[-1]]
    axes.set_yticks(ticks, [f"{tick:g}°" for tick in ticks], fontsize=8.5)
    axes.tick_params(labelsize=9)
    axes.grid(color="white", alpha=0.35, linewidth=0.6)
    axes.set_title(_label(of, key), loc="left", fontsize=11.5, fontweight="bold", color=_INK, pad=14)
    bar = axes.figure.colorbar(shown, ax=axes, shrink=0.75, pad=0.11)
    bar.ax.tick_params(labelsize=9)
    bar.set_label(_unit(of, key), fontsize=10)

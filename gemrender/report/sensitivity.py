"""The derivatives of a stone's scores, as a table and a figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.beam.sensitivity import Derivative, Sensitivity
from gemrender.report.formats import Column, TextTable
from gemrender.report.lettering import name_fonts, save_png
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from gemrender.sweep.cliffs import Cliff

__all__ = [
    "cliff_cells",
    "cliffs_table",
    "measure_slopes_table",
    "parameter_name",
    "sensitivity_figure",
    "sensitivity_records",
    "sensitivity_table",
    "write_sensitivity",
]

_COLOURS = {"average": "#1e9c89", "rear": "#3f4889"}
_INK, _GREY = "#222222", "#666666"
_SIGNS = {"deg": "°", "%": "%", "": ""}
_NAMES = {
    "table": "Table",
    "star": "Star length",
    "lower_girdle_contact": "Lower-girdle contact",
    "crown_height": "Crown height",
    "pavilion_depth": "Pavilion depth",
    "girdle_thickness": "Girdle thickness",
    "crown_angle": "Crown angle",
    "pavilion_angle": "Pavilion angle",
    "lower_half": "Lower-half length",
}


def parameter_name(derivative: Derivative | Cliff) -> str:
    """Return the parameter in words, with what is kept where that matters."""
    name = _NAMES.get(derivative.parameter)
    if name is None:
        is_tier = derivative.kept in ("tiers", "middles", "meets")
        name = derivative.parameter if is_tier else derivative.parameter.replace("_", " ").capitalize()
    if derivative.parameter in ("table", "culet"):
        name += ", heights kept" if derivative.kept == "proportions" else ", angles kept"
    return name


def sensitivity_table(sensitivities: Sequence[Sensitivity]) -> TextTable:
    """Return the derivatives, a row each: by a per cent of a proportion, and by a degree of an angle."""
    columns = [Column("Stone", is_text=True), Column("by", is_text=True), Column("unit", is_text=True)]
    for name, rank in (("d Average", 0), ("±", 2), ("d Rear", 0), ("±", 1)):
        columns.append(Column(name, rank, style="" if rank else "bold"))
    table = TextTable(columns, ruled=True)
    for s in sensitivities:
        for number, d in enumerate(s.derivatives):
            table.rows.append([
                "" if number else s.name,
                parameter_name(d),
                f"1 {_SIGNS[d.unit]}".strip(),
                f"{d.average:+.3f}",
                _digits(d.average_bound),
                f"{d.rear:+.3f}",
                _digits(d.rear_bound),
            ])  # fmt: skip
    table.note("d Average, d Rear: per cent of the light or of the top view, by one unit of the parameter.")
    table.note("±: error of the part near the girdle, a difference quotient of rays; the rest is exact.")
    if any(d.average_bound or d.rear_bound for s in sensitivities if not s.girdle for d in s.derivatives):
        table.note("Without a round girdle ± is half of what the slopes on both sides differ by: a kink.")
    for s in sensitivities:
        table.note(
            f"{s.name}: Average {s.average:.2f}, Rear {s.rear:.2f}; "
            f"{s.girdle:.2g} % of the view lies near the girdle."
        )
    return table


def measure_slopes_table(sensitivities: Sequence[Sensitivity]) -> TextTable:
    """Return the derivatives of measures: a row for each value of each, by each parameter."""
    texts = [Column(name, is_text=True) for name in ("Stone", "Measure", "Value", "by", "unit")]
    table = TextTable([*texts, Column("slope", style="bold"), Column("±", rank=1)], ruled=True)
    for s in sensitivities:
        for number, values in enumerate(zip(*(d.measures for d in s.derivatives), strict=True)):
            for by, (d, value) in enumerate(zip(s.derivatives, values, strict=True)):
                first = "" if by else value.measure
                key = "" if by or value.key == "value" else value.key
                slope = ("-", "-") if np.isnan(value.slope) else (f"{value.slope:+.3f}", _digits(value.bound))
                unit = f"{value.unit} by 1 {_SIGNS[d.unit]}".strip()
                table.rows.append(
                    ["" if number or by else s.name, first, key, parameter_name(d), unit, *slope]
                )
    table.note(
        "Where the slopes on both sides differ their mean is told, and half of the difference is in ±."
    )
    table.note(
        "Else ± is the error (99.9 %) of what rays tell: light near a round girdle, light that has been "
        "reflected in part so often that polygons follow it no further, and measures over all views."
    )
    return table


def cliffs_table(names: Sequence[str], cliffs: Sequence[Sequence[Cliff]]) -> TextTable:
    """Return the next jump below and above each parameter, a row each, of stones of these names."""
    texts = [Column(name, is_text=True) for name in ("Stone", "Parameter", "unit")]
    sides = [Column("next jump below"), Column("jumps", 1, is_text=True), Column("above"),
             Column("jumps", 1, is_text=True)]  # fmt: skip
    table = TextTable([*texts, Column("is", 2), *sides], ruled=True)
    for name, of_stone in zip(names, cliffs, strict=True):
        pairs = zip(of_stone[::2], of_stone[1::2], strict=True)
        for number, (below, above) in enumerate(pairs):
            cells = [cell for cliff in (below, above) for cell in cliff_cells(cliff)]
            words = parameter_name(below)
            first = "" if number else name
            table.rows.append([first, words, _SIGNS[below.unit], f"{below.value:.3f}", *cells])
    table.note("jumps: what of the light or of the view jumps most when the parameter grows past that place.")
    table.note("none to: no such jump as far as that value.")
    return table


def cliff_cells(cliff: Cliff) -> tuple[str, str]:
    """Return where the next jump is, and what jumps most there, as cells of a table."""
    largest = cliff.largest
    if cliff.at is None or largest is None:
        end = cliff.value + (-1 if cliff.side == "below" else 1) * cliff.searched
        return f"none to {end:.2f}", ""
    key = "" if largest.key == "value" else f" {largest.key}"
    return f"{cliff.at:.4f}", f"{largest.measure}{key} {largest.size:+.2f}"


def sensitivity_records(
    sensitivity: Sensitivity, cliffs: Sequence[Cliff] | None = None
) -> list[dict[str, Any]]:
    """Return the derivatives as flat records, one each; with the cliffs of each parameter if given."""
    by_parameter = {(of.parameter, of.kept, of.side): of for of in cliffs or ()}
    out = []
    for d in sensitivity.derivatives:
        record = {"name": sensitivity.name, **d.to_dict()}
        for measure, of in record.pop("measures", {}).items():
            for key, told in of.items():
                name = measure if key == "value" else f"{measure}_{key}"
                record |= {name: told["slope"], f"{name}_bound": told["bound"]}
        for side in ("below", "above") if cliffs is not None else ():
            cliff = by_parameter.get((d.parameter, d.kept, side))
            largest = None if cliff is None else cliff.largest
            record[f"cliff_{side}"] = None if cliff is None else cliff.at
            record[f"cliff_{side}_of"] = None if largest is None else f"{largest.measure} {largest.key}"
            record[f"cliff_{side}_jump"] = None if largest is None else largest.size
        out.append(record)
    return out


def _digits(bound: float) -> str:
    return f"{bound:.3f}" if bound >= 5e-4 else "0"


def sensitivity_figure(sensitivity: Sensitivity) -> Figure:
    """Draw the derivatives as bars, their errors as whiskers: Average on the left, Rear on the right."""
    from matplotlib.figure import Figure

    n = len(sensitivity.derivatives)
    height = 1.5 + 0.42 * n
    figure = Figure(figsize=(10.4, height), dpi=140)
    figure.text(
        0.03, 1 - 0.42 / height, sensitivity.name, fontsize=16, fontweight="bold", color=_INK,
        family=name_fonts(), parse_math=False,
    )  # fmt: skip
    words = f"Average {sensitivity.average:.2f} %, Rear {sensitivity.rear:.2f} %. Change by one unit of:"
    figure.text(0.03, 1 - 0.72 / height, words, fontsize=10.5, color=_GREY)
    bottom, top = 0.62 / height, 1 - 1.12 / height
    for column, name in enumerate(("average", "rear")):
        axes = figure.add_axes((0.25 + 0.38 * column, bottom, 0.345, top - bottom))
        _draw_bars(axes, sensitivity.derivatives, name)
        axes.set_title(f"d {name.capitalize()} [%]", loc="left", fontsize=12, fontweight="bold", color=_INK)
        if column == 0:
            axes.set_yticks(range(n), [_label(d) for d in sensitivity.derivatives], fontsize=10.5)
        else:
            axes.set_yticks([])
    return figure


def _label(derivative: Derivative) -> str:
    sign = _SIGNS[derivative.unit]
    return f"{parameter_name(derivative)} [{sign}]" if sign else parameter_name(derivative)


def _draw_bars(axes: Axes, derivatives: Sequence[Derivative], name: str) -> None:
    values = np.array([getattr(d, name) for d in derivatives])
    bounds = np.array([getattr(d, f"{name}_bound") for d in derivatives])
    rows = np.arange(len(values))
    axes.barh(rows, values, height=0.62, color=_COLOURS[name])
    shown = bounds > 0.004 * np.abs(values).max(initial=1e-9)
    axes.errorbar(
        values[shown], rows[shown], xerr=bounds[shown], fmt="none", ecolor=_INK, elinewidth=1.0, capsize=2.5
    )
    widest = float((np.abs(values) + bounds).max(initial=1e-9))
    room = 0.42 * widest
    low, high = min(0.0, float((values - bounds).min())), max(0.0, float((values + bounds).max()))
    axes.set(xlim=(low - room * (low < 0), high + room * (high > 0)), ylim=(len(values) - 0.4, -0.6))
    for row, value, bound in zip(rows, values, bounds, strict=True):
        side = 1 if value >= 0 else -1
        end = value + side * bound
        axes.annotate(
            f"{value:+.2f}".replace("-", "−"), (end, row), xytext=(5 * side, 0), textcoords="offset points",
            ha="left" if side > 0 else "right", va="center_baseline", fontsize=9.5, color=_INK,
        )  # fmt: skip
    axes.axvline(0, color=_INK, linewidth=0.9)
    kinds = [d.kept for d in derivatives]
    if "angles" in kinds:
        axes.axhline(kinds.index("angles") - 0.5, color="#cccccc", linewidth=0.8)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelsize=9.5, length=3, colors=_GREY)


def write_sensitivity(sensitivity: Sensitivity, folder: Path, stem: str) -> Path:
    """Write the figure as `stem`-sensitivity.png, whole or not at all; return its path."""
    figure = sensitivity_figure(sensitivity)
    return write_whole(folder, {f"{stem}-sensitivity.png": lambda path: save_png(figure, path)})[0]

"""What a tolerance study found, as a table and a figure."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.observation import bound_text
from gemrender.report.formats import Column, TextTable
from gemrender.report.lettering import name_fonts, save_png
from gemrender.sweep.tolerance import Spread, ToleranceStudy
from gemrender.sweep.unknown import Cutting, Rounding
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "rounding_text",
    "rounding_values",
    "tolerance_figure",
    "tolerance_records",
    "tolerance_table",
    "unknown_text",
    "write_tolerance_figure",
]

_COLOUR, _INK, _GREY = "#1e9c89", "#222222", "#666666"
#: Values that are the same in all draws but for rounding [%].
_SAME = 1e-9
#: Histograms in a row of the figure.
_COLUMNS = 3


def tolerance_table(studies: Sequence[ToleranceStudy]) -> TextTable:
    """Return the values that spread, a row each, of each stone's measures."""
    numbers = ["Stated", "±", "Mean", "Deviation", "2.5 %", "Median", "97.5 %", "Least", "Most"]
    ranks = [0, 3, 3, 1, 0, 2, 0, 4, 4]
    columns = [Column("Stone", is_text=True), Column("Value", is_text=True), *map(Column, numbers, ranks)]
    table = TextTable(columns, ruled=True)
    for study in studies:
        for number, of in enumerate(_spreading(study)):
            table.rows.append([
                "" if number else study.name,
                f"{of.measure} {of.key}",
                f"{of.stated:.2f}",
                "" if of.bound is None else bound_text(of.bound),
                *(f"{x:.2f}" for x in (of.mean, of.deviation, of.low, of.median, of.high, of.least, of.most)),
            ])  # fmt: skip
    for words in dict.fromkeys(unknown_text(study) for study in studies):
        table.note(f"{words}.")
    table.note("±: bound of the stated value alone; the rest: over the draws.")
    table.note("Values that are the same in all draws are left out.")
    return table


def _spreading(study: ToleranceStudy) -> list[Spread]:
    return [of for of in study.spreads() if not of.most - of.least <= _SAME]


def tolerance_records(study: ToleranceStudy) -> list[dict[str, Any]]:
    """Return a study as flat records, one a value."""
    how = {"draws": len(study.drawn), "seed": study.seed, **_flat(study.unknown.to_dict())}
    names = ("stated", "bound", "mean", "deviation", "low", "median", "high", "least", "most")
    return [
        {
            "name": study.name,
            "measure": of.measure,
            "key": of.key,
            **{name: getattr(of, name) for name in names},
            **how,
        }
        for of in study.spreads()
    ]


def _flat(unknown: dict[str, Any]) -> dict[str, Any]:
    steps = {f"step_{key}": step for key, step in unknown.get("steps", {}).items()}
    return {
        "unknown": unknown["of"],
        **{k: v for k, v in unknown.items() if k not in ("of", "steps")},
        **steps,
    }


def unknown_text(study: ToleranceStudy) -> str:
    """Say in words what was drawn."""
    unknown, draws = study.unknown, f"{len(study.drawn)} draws, seed {study.seed}"
    if isinstance(unknown, Rounding):
        steps = ", ".join(f"{key.replace('_', ' ')} {step:g}" for key, step in unknown.steps.items() if step)
        return f"Rounded to steps of {steps}: anywhere within half a step of what is stated; {draws}"
    if isinstance(unknown, Cutting):
        deep = (
            f", and {unknown.depth:g} % of half the length too deep or not deep enough"
            if unknown.depth
            else ""
        )
        return f"Facets tilted by {unknown.tilt_deg:g} deg{deep} (standard deviations); {draws}"
    return f"Vertices off by {unknown.to_dict()['jitter']:g} girdle radii (standard deviation); {draws}"


def rounding_text(study: ToleranceStudy) -> str:
    """Say what a report's rounding does to the paper's scores, for a note."""
    average, rear = _of_scores(study)
    return (
        f"{study.name}: within the report's rounding Average {average.low:.1f} to {average.high:.1f}, Rear "
        f"{rear.low:.1f} to {rear.high:.1f} (central 95 % of {len(study.drawn)} draws; gemrender tolerance)"
    )


def rounding_values(study: ToleranceStudy) -> dict[str, Any]:
    """Return the same as JSON has it: limits of the central 95 % [%]."""
    spreads = {of.key: {"low": of.low, "high": of.high} for of in _of_scores(study)}
    return {"rounding": {"draws": len(study.drawn), **spreads}}


def _of_scores(study: ToleranceStudy) -> tuple[Spread, Spread]:
    found = {of.key: of for of in study.spreads() if of.measure == "inoue"}
    return found["average"], found["rear"]


def tolerance_figure(study: ToleranceStudy) -> Figure:
    """Draw the distribution of each value that spreads, the stated value marked."""
    from matplotlib.figure import Figure

    shown = _spreading(study)
    rows = max(1, -(-len(shown) // _COLUMNS))
    height = 1.2 + 2.35 * rows
    figure = Figure(figsize=(11.0, height), dpi=140)
    figure.text(
        0.04, 1 - 0.36 / height, study.name, fontsize=16, fontweight="bold", color=_INK,
        family=name_fonts(), parse_math=False,
    )  # fmt: skip
    words = textwrap.fill(unknown_text(study), 130)
    figure.text(0.04, 1 - 0.52 / height, words, fontsize=9.5, color=_GREY, va="top", linespacing=1.3)
    for number, of in enumerate(shown):
        row, column = divmod(number, _COLUMNS)
        values = study.drawn[:, _place(study, of)]
        bottom = 1 - (1.2 + 2.35 * (row + 1) - 0.5) / height
        axes = figure.add_axes((0.04 + 0.325 * column, bottom, 0.275, 1.2 / height))
        axes.hist(values[np.isfinite(values)], bins="auto", color=_COLOUR, edgecolor="white", linewidth=0.5)
        axes.axvspan(of.low, of.high, color=_COLOUR, alpha=0.13, linewidth=0)
        axes.axvline(of.stated, color=_INK, linewidth=1.3, linestyle=(0, (4, 3)))
        axes.set_yticks([])
        axes.spines[["top", "right", "left"]].set_visible(False)
        axes.tick_params(labelsize=9, length=3)
        axes.set_title(
            f"{of.measure} {of.key}", loc="left", fontsize=11, fontweight="bold", color=_INK, pad=16
        )
        text = f"95 %: {of.low:.2f} to {of.high:.2f};  dashed: stated, {of.stated:.2f}"
        axes.text(0, 1.05, text, transform=axes.transAxes, fontsize=8.5, color=_GREY)
    return figure


def _place(study: ToleranceStudy, spread: Spread) -> int:
    keys = [(of.name, key) for of in study.measures for key in of.keys]
    return keys.index((spread.measure, spread.key))


def write_tolerance_figure(study: ToleranceStudy, path: Path) -> Path:
    """Write the figure as PNG, whole or not at all; return its path."""
    figure = tolerance_figure(study)
    return write_whole(path.parent, {path.name: lambda part: save_png(figure, part)})[0]

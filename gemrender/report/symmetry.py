"""What a symmetry study found, as a table and a figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.report.formats import Column, TextTable
from gemrender.report.lettering import name_fonts, save_png
from gemrender.sweep import SymmetryStudy
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["study_records", "study_table", "symmetry_figure", "write_symmetry_figure"]

_COLOURS = {"average": "#1e9c89", "rear": "#3f4889"}
_INK, _GREY = "#222222", "#666666"


def study_table(studies: Sequence[SymmetryStudy]) -> TextTable:
    """Return two rows a stone: Average and Rear of the perfect stone, and of its draws [%]."""
    numbers = ["Perfect", "Mean", "Deviation", "Median", "2.5 %", "97.5 %"]
    ranks = [0, 0, 0, 3, 2, 1]
    table = TextTable([Column("Stone", is_text=True), Column("", is_text=True), *map(Column, numbers, ranks)])
    for study in studies:
        summary = study.summary()
        for number, key in enumerate(("average", "rear")):
            values = (summary[key][name] for name in ("mean", "deviation", "median", "low", "high"))
            table.rows.append([
                "" if number else study.name,
                key.capitalize(),
                f"{study.perfect[number]:.2f}",
                *(f"{value:.2f}" for value in values),
            ])  # fmt: skip
    table.note(f"{rule_text(studies[0])}. All in per cent; central 95 % of draws.")
    return table


def study_records(study: SymmetryStudy) -> list[dict[str, Any]]:
    """Return a study as two flat records: of Average, and of Rear [%]."""
    how = {
        "deviation_deg": study.tilt_deg,
        "jitter": study.jitter,
        "draws": len(study.average),
        "seed": study.seed,
        "resolution": study.resolution,
    }
    return [
        {"name": study.name, "score": key, "perfect": perfect, **study.summary()[key], **how}
        for key, perfect in zip(("average", "rear"), study.perfect, strict=True)
    ]


def rule_text(study: SymmetryStudy) -> str:
    """Say in words how the draws were made."""
    how = f"{study.resolution} x {study.resolution} rays" if study.resolution else "exact scores"
    draws = f"{len(study.average)} draws, seed {study.seed}, {how}"
    if study.jitter:
        return f"Vertices jittered by {study.jitter:g} girdle radii (standard deviation), {draws}"
    return f"Facets tilted by {study.tilt_deg:g} deg (standard deviation), {draws}"


def symmetry_figure(study: SymmetryStudy) -> Figure:
    """Draw the distributions of Average and Rear, the perfect stone's marked."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.2, 4.6), dpi=140)
    figure.text(
        0.06,
        0.915,
        study.name,
        fontsize=16,
        fontweight="bold",
        color=_INK,
        family=name_fonts(),
        parse_math=False,
    )
    figure.text(0.06, 0.855, rule_text(study).replace(" x ", " × "), fontsize=10, color=_GREY)
    summary = study.summary()
    for column, (name, title) in enumerate((("average", "Average"), ("rear", "Rear"))):
        values = np.array(getattr(study, name))
        axes = figure.add_axes((0.06 + 0.48 * column, 0.15, 0.42, 0.52))
        axes.hist(values, bins="auto", color=_COLOURS[name], edgecolor="white", linewidth=0.6)
        s = summary[name]
        axes.axvspan(s["low"], s["high"], color=_COLOURS[name], alpha=0.13, linewidth=0)
        axes.axvline(study.perfect[column], color=_INK, linewidth=1.4, linestyle=(0, (4, 3)))
        axes.set_xlabel(f"{title} [%]", fontsize=11.5, color=_INK)
        axes.set_yticks([])
        axes.spines[["top", "right", "left"]].set_visible(False)
        axes.tick_params(labelsize=10.5, length=3)
        text = f"{s['mean']:.2f} ± {s['deviation']:.2f} %"
        axes.set_title(f"{title}  {text}", loc="left", fontsize=12.5, fontweight="bold", color=_INK, pad=26)
        below = (
            f"central 95 %: {s['low']:.2f} to {s['high']:.2f};  dashed: perfect, {study.perfect[column]:.2f}"
        )
        axes.text(0, 1.06, below, transform=axes.transAxes, fontsize=9.5, color=_GREY)
    return figure


def write_symmetry_figure(study: SymmetryStudy, path: Path) -> Path:
    """Write the figure as PNG, whole or not at all; return its path."""
    figure = symmetry_figure(study)
    return write_whole(path.parent, {path.name: lambda part: save_png(figure, part)})[0]

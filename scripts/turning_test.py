"""The turning test: how far each tool's numbers move when a symmetric stone is turned under a fixed eye.

    python scripts/turning_test.py [--step 5] [--stones NAME ...] [--tools exact mitsuba-256 mitsuba-512
                                   reference-128] [--bound 0.05] [--others FILE] [--out FOLDER]

Seen along its axis, a stone is the same stone however it is turned: what a tool's number moves by is its own
error. gemrender's engines are run here; what other tools say is read from a file (`docs/turning-test.md` has
its format). Prints a table of spreads, largest less smallest value, and writes a figure and all numbers.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import gemrender
from gemrender.cuts import load_stone
from gemrender.errors import InputError
from gemrender.reading import parse_toml, read_lines
from gemrender.report.lettering import save_png
from gemrender.stone import Stone
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DESIGNS = Path(__file__).parents[1] / "tests" / "cases" / "stones"
#: Bundled round brilliants, and a square and a step-cut design of the cases.
STONES = ("tolkowsky", "gia-excellent", "inoue-3", "square-barion.asc", "emerald.asc")
TOOLS = ("exact", "mitsuba-256", "mitsuba-512", "reference-128")
#: Angles that each stone is turned by [deg].
FROM, TO = 0.0, 45.0
#: Sums of the same areas in another order differ by rounding [%].
ROUNDING = 1e-9
MEASURES = "inoue,iso,cos,sc2,aset,window,extinction"
#: What is told of them: what the table calls it, the measure, and its value.
NUMBERS = {
    "Average": ("inoue", "average"),
    "Rear": ("inoue", "rear"),
    "iso": ("iso", "value"),
    "cos": ("cos", "value"),
    "sc2": ("sc2", "value"),
    "aset green": ("aset", "green"),
    "aset red": ("aset", "red"),
    "aset blue": ("aset", "blue"),
    "aset leak": ("aset", "leak"),
    "weighted green": ("aset", "weighted_green"),
    "weighted red": ("aset", "weighted_red"),
    "weighted blue": ("aset", "weighted_blue"),
    "window": ("window", "value"),
    "head": ("extinction", "head"),
}

_INK, _GREY, _FAINT = "#222222", "#666666", "#e4e4e4"
_COLOURS = ("#1e9c89", "#8fb8de", "#3f4889", "#d1703c", "#a23b72", "#8a8a3c")


@dataclass(frozen=True, slots=True, kw_only=True)
class Turned:
    """One number of one tool as a stone is turned.

    Attributes
    ----------
    tool, stone, number : str
        Whose, of what, and what.
    angles, values : (n,) float64
        Angles [deg], and the number at each [%], or as the tool has it.
    bound : float or None
        Largest error bound that the tool states.
    """

    tool: str
    stone: str
    number: str
    angles: np.ndarray
    values: np.ndarray
    bound: float | None = None

    @property
    def spread(self) -> float:
        """Largest less smallest value."""
        return float(np.ptp(self.values))


def turn(stone: Stone, tool: str, angles: np.ndarray, bound: float) -> list[Turned]:
    """Measure a stone turned by angles (n,) [deg] with one of gemrender's engines."""
    engine, _, resolution = tool.partition("-")
    options: dict[str, Any] = {"engine": engine, "measures": MEASURES}
    options |= {"bound": bound} if engine == "exact" else {"resolution": int(resolution)}
    found: list[dict[str, Any]] = []
    for seed, angle in enumerate(angles, start=1):  # what is random is so anew at each angle
        score = gemrender.score(stone.rotated(float(angle)), seed=seed, **options)
        found.append({of.name: of for of in score.measures or ()})
    out = []
    for number, (measure, key) in NUMBERS.items():
        bounds = [of[measure].bound for of in found]
        out.append(
            Turned(
                tool=tool,
                stone=stone.name,
                number=number,
                angles=angles,
                values=np.array([of[measure].values[key] for of in found]),
                bound=None if None in bounds else max(bounds),
            )
        )
    return out


def others(path: Path) -> list[Turned]:
    """Read what other tools say.

    Raises
    ------
    InputError
        The file is not as `docs/turning-test.md` has it.
    """
    out = []
    what = "file of results"
    for tool in parse_toml(read_lines(path, kind=what), kind=what).get("tool", []):
        for key in ("name", "version", "source"):
            if not isinstance(tool.get(key), str) or not tool[key]:
                raise InputError("must say who measured what, a text", source=str(path), key=f"tool.{key}")
        for series in tool.get("series", []):
            angles, values = (_numbers(series, key, path) for key in ("angles", "values"))
            if len(angles) != len(values):
                raise InputError(
                    "must be as many as values", source=str(path), key="angles", value=len(angles)
                )
            for key in ("stone", "number"):
                if not isinstance(series.get(key), str):
                    raise InputError("must be a text", source=str(path), key=f"tool.series.{key}")
            name = f"{tool['name']} {tool['version']}"
            out.append(
                Turned(
                    tool=name, stone=series["stone"], number=series["number"], angles=angles, values=values
                )
            )
    return out


def _numbers(series: dict[str, Any], key: str, path: Path) -> np.ndarray:
    values = series.get(key)
    is_list = isinstance(values, list) and len(values) > 1
    if not is_list or not all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values or ()):
        raise InputError(
            "must be a list of two or more numbers", source=str(path), key=f"tool.series.{key}", value=values
        )
    return np.array(values, dtype=np.float64)


def print_table(found: Sequence[Turned]) -> None:
    """Print as Markdown the largest spread of each number among all stones, a column for each tool.

    Of a tool that states bounds, also the largest ratio of a spread to its bound.
    """
    tools, numbers = _names(found, lambda of: of.tool), _names(found, lambda of: of.number)
    stated = {of.tool for of in found if of.bound is not None}
    header = [
        "number",
        *(name for tool in tools for name in (tool, "over its bound")[: 1 + (tool in stated)]),
    ]
    print(f"| {' | '.join(header)} |\n|{' --- |' * len(header)}")
    for number in numbers:
        cells = [number]
        for tool in tools:
            of_both = [of for of in found if (of.number, of.tool) == (number, tool)]
            cells.append(f"{max(of.spread for of in of_both):.4f}" if of_both else "")
            if tool in stated:
                ratios = [of.spread / (of.bound + ROUNDING) for of in of_both if of.bound is not None]
                cells.append(f"{max(ratios):.2f}" if ratios else "")
        print(f"| {' | '.join(cells)} |")
    for tool in tools:
        largest = max((of for of in found if of.tool == tool), key=lambda of: of.spread)
        print(f"largest of {tool}: {largest.spread:.4f}, {largest.number} of {largest.stone}")


def _names(found: Sequence[Turned], name: Callable[[Turned], Any]) -> list[Any]:
    """Return names in the order in which they come first."""
    return list(dict.fromkeys(name(of) for of in found))


def draw(found: Sequence[Turned], floor: float = 1e-4) -> Figure:
    """Draw spreads, a panel for each stone; smaller ones than a floor are drawn at it."""
    from matplotlib.figure import Figure

    stones, tools = _names(found, lambda of: of.stone), _names(found, lambda of: of.tool)
    numbers = _names(found, lambda of: of.number)
    figure = Figure(figsize=(3.0 + 2.0 * len(stones), 2.0 + 0.28 * len(numbers)), dpi=140)
    figure.text(
        0.02, 0.955, "What turning a symmetric stone does to its numbers", fontsize=15, fontweight="bold",
        color=_INK, va="top",
    )  # fmt: skip
    angles = found[0].angles
    words = (
        f"Largest less smallest value while it is turned by {angles.min():g} to {angles.max():g} degrees: "
        "it should be 0"
    )
    figure.text(0.02, 0.895, words, fontsize=9.5, color=_GREY, va="top")
    axes = figure.subplots(1, len(stones), sharey=True, sharex=True, squeeze=False)[0]
    figure.subplots_adjust(left=0.115, right=0.985, top=0.745, bottom=0.1, wspace=0.08)
    for place, stone in zip(axes, stones, strict=True):
        for tool, colour in zip(tools, _COLOURS * len(tools), strict=False):
            of_tool = [of for of in found if (of.stone, of.tool) == (stone, tool)]
            place.plot(
                [max(of.spread, floor) for of in of_tool],
                [numbers.index(of.number) for of in of_tool],
                "o", color=colour, markersize=5, alpha=0.9, label=tool, clip_on=False,
            )  # fmt: skip
            for of in of_tool:
                if of.bound:
                    y = numbers.index(of.number)
                    place.plot([max(of.bound, floor)] * 2, [y - 0.3, y + 0.3], color=colour, lw=1.4)
        place.set_xscale("log")
        place.set_xlim(floor, 2.0 * max(of.spread for of in found))
        place.set_title(stone, loc="left", fontsize=10.5, fontweight="bold", color=_INK)
        place.tick_params(labelsize=8.5, colors=_GREY, length=2)
        place.spines[["top", "right", "left"]].set_visible(False)
        place.grid(color=_FAINT, lw=0.7)
        place.set_axisbelow(True)
    axes[0].set_yticks(range(len(numbers)), numbers, fontsize=9, color=_INK)
    axes[0].invert_yaxis()
    figure.text(
        0.55, 0.015, f"spread [%]; at the left edge {floor:g} and less; bars: the bound that a tool states",
        fontsize=9, color=_GREY, ha="center",
    )  # fmt: skip
    figure.legend(
        *axes[0].get_legend_handles_labels(), ncols=len(tools), frameon=False, fontsize=9, labelcolor=_INK,
        loc="upper left", bbox_to_anchor=(0.01, 0.865), handletextpad=0.1, columnspacing=1.4,
    )  # fmt: skip
    return figure


def write_numbers(found: Sequence[Turned], path: Path) -> None:
    """Write all numbers as CSV."""
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["tool", "stone", "number", "angle_deg", "value", "bound"])
        for of in found:
            bound = "" if of.bound is None else f"{of.bound:.6g}"
            for angle, value in zip(of.angles, of.values, strict=True):
                rows.writerow([of.tool, of.stone, of.number, f"{angle:g}", f"{value:.6f}", bound])


def main() -> None:
    """Turn, measure, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--step", type=float, default=5.0, help="step of the angles [deg]")
    parser.add_argument("--stones", nargs="+", default=STONES, metavar="STONE")
    parser.add_argument(
        "--tools", nargs="+", default=TOOLS, metavar="TOOL", help="exact, or an engine and its resolution"
    )
    parser.add_argument("--bound", type=float, default=0.05, help="bound of the exact engine [%%]")
    parser.add_argument("--others", type=Path, metavar="FILE", help="what other tools say")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="where to put the figure and all numbers")
    options = parser.parse_args()

    angles = np.arange(FROM, TO + 0.5 * options.step, options.step)
    found: list[Turned] = []
    for name in options.stones:
        stone = load_stone(DESIGNS / name if (DESIGNS / name).is_file() else name)
        for tool in options.tools:
            print(f"\r{stone.name}, {tool:<40}", end="", file=sys.stderr, flush=True)
            found += turn(stone, tool, angles, options.bound)
    print(file=sys.stderr)
    if options.others:
        found += others(options.others)
    print_table(found)
    if options.out is not None:
        options.out.mkdir(parents=True, exist_ok=True)
        figure = draw(found)
        written = write_whole(
            options.out,
            {
                "turning-test.png": lambda part: save_png(figure, part),
                "turning-test.csv": lambda part: write_numbers(found, part),
            },
        )
        print(f"written: {', '.join(map(str, written))}", file=sys.stderr)


if __name__ == "__main__":
    main()

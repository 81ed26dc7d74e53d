"""Write the page of cuts, docs/cuts.md, and draw its figures.

    python scripts/draw_cuts.py [--out docs] [--no-figures]

The text comes from the families themselves: their docstrings, the ranges, units and defaults of their
parameters, the facets of the stone that a family alone makes, and the bundled stones with their sources.
"""

from __future__ import annotations

import argparse
import inspect
import re
import sys
import textwrap
from collections.abc import Iterator
from dataclasses import MISSING, fields
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gemrender.cuts import bundled_stones, girdle_words, load_stone, size
from gemrender.cuts.families import families
from gemrender.cuts.families.family import Family
from gemrender.cuts.families.parameters import unit_of
from gemrender.cuts.measurements import SIZE_KEYS
from gemrender.report.displays.page import PAPER, draw_lines
from gemrender.report.displays.projection import CROWN, PAVILION, corners_of, look_at, side
from gemrender.stone import Stone
from gemrender.writing import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCENES = Path(__file__).parents[1] / "scenes"
#: Size of a view [inch], resolution [pixels per inch], and room between the views [stone's unit].
VIEW, DPI, GAP = 2.4, 90, 0.25

INTRODUCTION = """\
# Cuts

What gemrender can cut by name. A stone file names the family and states what it knows, in the words of
laboratory reports; all else is the family's own, and `gemrender inspect` says what was taken:

```toml
[cut]
family = "oval"
length_to_width = 1.45
table = 57
depth = 62.5                     # crown, girdle and pavilion: gives the one that is not stated
girdle = "medium"
```

`family` alone is a whole stone: that of the figures here, seen from above, from below, and from the side with
its width to the right. `gemrender show STONE --what outline` draws any stone with its dimensions, and
`gemrender sensitivity STONE` tells how its scores change with each parameter.

Lengths are in per cent of the width, the shorter side of the outline, unless it says otherwise; angles are to
the girdle plane. What stands *in place of* a parameter, such as an angle in place of a height, may be stated
instead of it, or beside it if both agree. A range is what is accepted; within it some combinations make no
convex stone, and one line says so.

This page is written by `python scripts/draw_cuts.py`."""


def page() -> str:
    """Return the text of the page."""
    kinds = families()
    parts = [INTRODUCTION, _contents(kinds), _words(), _size()]
    examples = _examples(kinds)
    parts += [_section(name, kind, examples[name]) for name, kind in kinds.items()]
    return "\n\n".join(parts) + "\n"


def _contents(kinds: dict[str, Any]) -> str:
    links = [f"[{name}](#{_stem(name)})" for name in kinds]
    return (
        "Families: "
        + ", ".join(links)
        + "; and what all have: [girdle and culet](#girdle-and-culet), [size](#size)."
    )


def _words() -> str:
    """Return the section of what words mean."""
    said = _markdown(inspect.getdoc(girdle_words) or "")
    tables = []
    for name, words in (("Girdle", girdle_words.GIRDLE_WORDS), ("Culet", girdle_words.CULET_WORDS)):
        rows = [
            ("", *words),
            ("width [%]" if name == "Culet" else "thickness [%]", *(f"{n:g}" for n in words.values())),
        ]
        tables.append(f"{name}:\n\n{_table(rows)}")
    return "\n\n".join(["## Girdle and culet", said, *tables])


def _size() -> str:
    keys = ", ".join(f"`{key}`" for key in SIZE_KEYS)
    said = _markdown(inspect.getdoc(size) or "")
    return f"## Size\n\n{said} Section `[size]` of a stone file takes {keys}."


def _section(name: str, kind: Any, examples: list[str]) -> str:
    """Return the section of a family."""
    cut = kind()
    stone = cut.stone(name=name)
    title = f"{name[:1].upper()}{name[1:]}"
    parts = [f"## {title}", f"![{title}](cuts/{_stem(name)}.png)", *_told(kind)]
    parts.append(_facets(stone))
    parts.append(_table([("Parameter", "Range", "Default", "What it is"), *_parameters(cut)]))
    if isinstance(cut, Family) and cut.ALTERNATIVES:
        parts.append(_table([("In place of", "may be stated", "Range", "Here"), *_alternatives(cut)]))
    if examples:
        parts.append("Bundled:\n\n" + "\n".join(examples))
    return "\n\n".join(parts)


# ---- What a family says of itself ----------------------------------------------------------------------


def _bases(kind: Any) -> list[Any]:
    """Return a family's class and those that it shares parameters with."""
    return [base for base in kind.__mro__ if base not in (Family, object)]


def _told(kind: Any) -> Iterator[str]:
    """Yield the paragraphs of the docstrings of a family and of what it shares with others."""
    for number, base in enumerate(_bases(kind)):
        of_file = inspect.getdoc(sys.modules[base.__module__]) or ""
        of_class = re.split(r"\n\w+\n---+\n", inspect.getdoc(base) or "")[0]
        # The first line of a class says again what the file's says.
        rest = of_class.partition("\n\n")[2]
        words = "\n\n".join(filter(None, (_markdown(of_file), _markdown(rest))))
        if number:
            name = getattr(sys.modules[base.__module__], "FAMILY", "")
            words = f"Shared with the {name}: {words}" if name else f"Shared: {words}"
        yield words


def _described(kind: Any) -> dict[str, str]:
    """Return what the docstrings say of each parameter."""
    found: dict[str, str] = {}
    for base in _bases(kind):
        parts = re.split(r"\n(\w+)\n---+\n", "\n" + (inspect.getdoc(base) or ""))
        sections = dict(zip(parts[1::2], parts[2::2], strict=True))
        for entry in re.split(r"\n(?=\S)", sections.get("Parameters", "").strip("\n")):
            names, _, text = entry.partition("\n")
            for name in names.partition(" : ")[0].split(", "):
                found.setdefault(name, " ".join(textwrap.dedent(text).split()))
    return found


def _parameters(cut: Any) -> Iterator[tuple[str, ...]]:
    """Yield name, range, default and meaning of each parameter."""
    described, said = _described(type(cut)), dict[str, str]()
    for part in fields(cut):
        default = "must be stated" if part.default is MISSING else _valued(cut, part.name, part.default)
        why = part.metadata["why"]
        words = described[part.name]
        first = said.setdefault(words, part.name)
        meaning = words if first == part.name else f"see `{first}`"
        yield f"`{part.name}`", _range(cut, part), f"{default} ({why})" if why else default, meaning


def _alternatives(cut: Family) -> Iterator[tuple[str, ...]]:
    values = cut.alternatives()
    for other in cut.ALTERNATIVES:
        unit = _unit(cut, other.name)
        here = f"{float(values[other.name]):.1f}{unit}"
        yield f"`{other.stands_for}`", f"`{other.name}`", f"{other.low:g} to {other.high:g}{unit}", here


def _range(cut: Any, part: Any) -> str:
    if "allowed" in part.metadata:
        return ", ".join(map(str, part.metadata["allowed"]))
    low, high = part.metadata["range"]
    words = f"{low:g} to {high:g}{_unit(cut, part.name)}"
    words = f"0, or {words}" if part.metadata["or_zero"] else words
    words = f"several of {words}" if part.metadata["many"] else words
    return f"{words}, or words" if part.metadata["words"] is not None else words


def _valued(cut: Any, name: str, value: Any) -> str:
    if isinstance(value, tuple):
        return ", ".join(_valued(cut, name, one) for one in value)
    return f"{value:g}{_unit(cut, name)}" if isinstance(value, float) else f"{value}"


def _unit(cut: Any, name: str) -> str:
    unit = unit_of(cut, name)
    return {"deg": "°", "": ""}.get(unit, f" {unit}")


def _facets(stone: Stone) -> str:
    """Return the facets' kinds and numbers, by side."""
    sides: dict[str, list[str]] = {"crown": [], "pavilion": [], "girdle": []}
    for facet in stone.facets:
        sides[facet.side].append(facet.kind)
    told = []
    for side_of, kinds in sides.items():
        counts = {kind: kinds.count(kind) for kind in kinds}
        names = ", ".join(f"{count} `{kind}`" if count > 1 else f"`{kind}`" for kind, count in counts.items())
        told.append(f"{side_of} {len(kinds)}: {names}")
    girdle = "a round girdle" if stone.is_round else f"{len(sides['girdle'])} of the girdle"
    count = len(sides["crown"] + sides["pavilion"])
    return f"{count} facets, and {girdle}. {'; '.join(told[:2]).capitalize()}."


def _examples(kinds: dict[str, Any]) -> dict[str, list[str]]:
    """Return the bundled stones of each family: file, name, and what its file says of their source."""
    found: dict[str, list[str]] = {name: [] for name in kinds}
    of_class = {kind: name for name, kind in kinds.items()}
    for file in bundled_stones():
        stone = load_stone(file)
        if type(stone.cut) not in of_class:
            continue
        path = SCENES / f"{file}.toml"
        comments = []
        for line in path.read_text(encoding="utf-8").splitlines():
            if not line.startswith("#"):
                break
            comments.append(line.lstrip("# "))
        source = " ".join(comments).replace("*", "\\*")
        found[of_class[type(stone.cut)]].append(f"- `{file}`: {stone.name}. {source}".rstrip())
    return found


def _markdown(text: str) -> str:
    """Return paragraphs of a docstring, each in one line."""
    return "\n\n".join(" ".join(part.split()) for part in text.split("\n\n"))


def _table(rows: list[tuple[str, ...]]) -> str:
    head, *body = (" | ".join(cell.replace("|", "\\|") for cell in row) for row in rows)
    rule = " | ".join(["---"] * len(rows[0]))
    return "\n".join(f"| {row} |" for row in (head, rule, *body))


def _stem(name: str) -> str:
    return name.replace(" ", "-")


# ---- Figures -------------------------------------------------------------------------------------------


def figure(stone: Stone) -> Figure:
    """Draw a stone from above, from below and from the side, in one row to one scale."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    views = (CROWN, PAVILION, side())
    boxes = []
    for view in views:
        flat = view.flat(corners_of(stone))
        low, high = flat.min(axis=0), flat.max(axis=0)
        if stone.is_round:
            low[0], high[0] = -1.0, 1.0
            if view is not views[-1]:
                low[1], high[1] = -1.0, 1.0
        boxes.append((low, high))
    widths = [float(high[0] - low[0]) + GAP for low, high in boxes]
    height = max(float(high[1] - low[1]) for low, high in boxes) + GAP
    scale = VIEW / 2.0
    drawn = Figure(figsize=(sum(widths) * scale, height * scale), dpi=DPI, facecolor=PAPER.ground)
    FigureCanvasAgg(drawn)
    left = 0.0
    for view, (low, high), width in zip(views, boxes, widths, strict=True):
        axes = drawn.add_axes((left / sum(widths), 0.0, width / sum(widths), 1.0))
        middle = (low + high) / 2
        axes.set(
            xlim=(middle[0] - width / 2, middle[0] + width / 2),
            ylim=(middle[1] - height / 2, middle[1] + height / 2),
        )
        axes.set_axis_off()
        draw_lines(axes, look_at(stone, view), PAPER)
        left += width
    return drawn


def _save(drawn: Figure, path: Path) -> None:
    """Save a figure of black lines in few greys: small files."""
    from PIL import Image

    drawn.canvas.draw()
    pixels = np.asarray(drawn.canvas.buffer_rgba())
    Image.fromarray(pixels).convert("L").quantize(12).save(path, format="PNG", optimize=True)


def main() -> None:
    """Write the page, and its figures."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("docs"), help="folder to write to")
    parser.add_argument("--no-figures", action="store_true", help="write the text only")
    options = parser.parse_args()
    folder = options.out / "cuts"
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(options.out, {"cuts.md": lambda path: path.write_text(page(), encoding="utf-8")})
    if not options.no_figures:
        drawn = {f"{_stem(name)}.png": figure(kind().stone(name=name)) for name, kind in families().items()}
        write_whole(folder, {name: partial(_save, one) for name, one in drawn.items()})


if __name__ == "__main__":
    main()

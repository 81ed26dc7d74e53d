"""Pieces of HTML: all text is escaped, styles stand in the elements, colours are those of the notebook."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape

import numpy as np

__all__ = ["bar", "beside", "box", "cell", "image", "notes", "svg", "swatch", "table"]

#: Lines between rows: a grey that is seen on white and on black.
_LINE = "1px solid rgba(128,128,128,0.35)"
_FAINT = "opacity:0.75"
_CELL = "padding:0.15em 0.9em 0.15em 0;border:0;vertical-align:top;background:none;white-space:nowrap"


def box(title: str, *parts: str, below: str = "") -> str:
    """Return a block with a heading, a faint line beneath it, and parts."""
    faint = f'<div style="{_FAINT}">{escape(below)}</div>' if below else ""
    return (
        '<div style="font-size:13px;line-height:1.45;color:inherit;max-width:84em;overflow-x:auto">'
        f'<div style="font-weight:600;font-size:115%">{escape(title)}</div>{faint}{"".join(parts)}</div>'
    )


def beside(*parts: str) -> str:
    """Return parts side by side, or one below the other where there is no room."""
    return (
        '<div style="display:flex;flex-wrap:wrap;gap:1.2em;align-items:flex-start;margin:0.5em 0">'
        + "".join(f"<div>{part}</div>" for part in parts)
        + "</div>"
    )


def cell(text: str) -> str:
    """Return a text as a cell's content."""
    return escape(text)


def swatch(colour: str, text: str) -> str:
    """Return a text with a field of a colour before it."""
    field = f"display:inline-block;width:0.8em;height:0.8em;background:{escape(colour)};border:{_LINE}"
    return f'<span style="{field}"></span>&#160; {escape(text)}'


def bar(share: float, colour: str) -> str:
    """Return a bar, of so much of its cell's width, 0 to 1."""
    style = f"width:{8.0 * min(max(share, 0.0), 1.0):.2f}em;height:0.8em;background:{escape(colour)}"
    return f'<div style="{style};border:{_LINE};box-sizing:border-box;margin-top:0.3em"></div>'


def table(rows: Iterable[Sequence[str]], heads: Sequence[str] = (), *, numbers: Sequence[int] = ()) -> str:
    """Return a table.

    Parameters
    ----------
    rows : iterable of sequence of str
        Cells of HTML (`cell`, `swatch`, `bar`).
    heads : sequence of str
        Headings, as text.
    numbers : sequence of int
        The columns that hold numbers, and stand to the right.
    """

    def line(cells: Sequence[str], kind: str, below: str) -> str:
        made = (
            f'<{kind} style="{_CELL};text-align:{"right" if k in numbers else "left"};font-variant-numeric:'
            f'tabular-nums;font-weight:{"600" if kind == "th" else "400"}">{each}</{kind}>'
            for k, each in enumerate(cells)
        )
        return f'<tr style="background:none;border-bottom:{below}">{"".join(made)}</tr>'

    head = line([escape(each) for each in heads], "th", _LINE) if heads else ""
    body = "".join(line(row, "td", "0") for row in rows)
    return f'<table style="border-collapse:collapse;margin:0;color:inherit">{head}{body}</table>'


def notes(lines: Iterable[str]) -> str:
    """Return lines of text, faint."""
    return "".join(f'<div style="{_FAINT}">{escape(line)}</div>' for line in lines)


def svg(width: int, box_of: tuple[float, float, float, float], label: str, *shapes: str) -> str:
    """Return a drawing so many pixels wide: its box (left, top, width, height), what it shows, and shapes."""
    height = max(round(width * box_of[3] / box_of[2]), 1)
    view = " ".join(f"{number:.0f}" for number in box_of)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="{view}" '
        f'role="img" aria-label="{escape(label)}" style="max-width:100%;height:auto;overflow:visible">'
        f"<title>{escape(label)}</title>{''.join(shapes)}</svg>"
    )


def image(pixels: np.ndarray, width: int, label: str) -> str:
    """Return a picture (h, w, 4) uint8, within the page."""
    from gemrender.render.picture_files import png_bytes

    data = base64.b64encode(png_bytes(pixels)).decode("ascii")
    return (
        f'<img src="data:image/png;base64,{data}" width="{width}" alt="{escape(label)}" '
        'style="max-width:100%;height:auto"/>'
    )

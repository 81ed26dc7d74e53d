"""Tables and figures as sections of the page, beneath its stones."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable
from pathlib import Path

from gemrender.report.formats import Cell, TextTable

__all__ = ["figure_section", "tables_section"]


def tables_section(title: str, tables: Iterable[TextTable]) -> str:
    """Return tables, with their notes, as a section of a page (HTML)."""
    return _section(title, "\n".join(_table(title, table) for table in tables))


def figure_section(title: str, picture: Path, words: str) -> str:
    """Return a PNG as a section of a page (HTML); the words tell what it shows to who does not see it."""
    data = base64.b64encode(picture.read_bytes()).decode()
    image = f'<img src="data:image/png;base64,{data}" alt="{html.escape(words)}" style="max-width: 100%">'
    return _section(title, f"<figure>{image}</figure>")


def _section(title: str, content: str) -> str:
    name = html.escape(title)
    return (
        f'<section class="tables many" aria-label="{name}"><div><h2>{name}</h2>\n{content}</div></section>\n'
    )


def _table(title: str, table: TextTable) -> str:
    head = "".join(_cell("th", of.name, of.is_text, ' scope="col"') for of in table.columns)
    rows = "\n".join(
        "<tr>"
        + "".join(
            _cell(
                "td" if place else "th",
                cell.text if isinstance(cell, Cell) else cell,
                of.is_text,
                "" if place else ' scope="row"',
            )
            for place, (of, cell) in enumerate(zip(table.columns, row, strict=True))
        )
        + "</tr>"
        for row in table.rows
    )
    notes = "\n".join(f'<p class="note">{html.escape(note.text)}</p>' for note in table.notes)
    return (
        f'<div class="scroll" style="margin-top: 1rem" tabindex="0" role="region" '
        f'aria-label="{html.escape(title)}"><table>'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody></table></div>\n{notes}\n"
    )


def _cell(tag: str, text: str, is_text: bool, more: str = "") -> str:
    left = ' style="text-align: left"' if is_text else ""
    return f"<{tag}{more}{left}>{html.escape(text)}</{tag}>"

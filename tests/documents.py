"""The blocks of code of the readme and of the pages, and the command lines in them."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass

from markdown_it import MarkdownIt
from observations import ROOT

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]

_PROGRAMS = (
    r"(?:\.venv/bin/|\./)?(?:gemrender|python3?|pip|pytest|ruff|mypy|sphinx-build|jupyter|mitsuba|eval)\b"
)


@dataclass(frozen=True)
class Block:
    """A block of code: its page, its language as it is written, its text, and the line that it begins at."""

    page: str
    language: str
    text: str
    line: int

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def blocks() -> Iterator[Block]:
    """Yield all blocks but directives, such as the cells of notebooks, which are run as the site is built."""
    for path in PAGES:
        for token in MarkdownIt("commonmark").parse(path.read_text(encoding="utf-8")):
            if token.type in ("fence", "code_block") and not token.info.startswith("{"):
                page = path.relative_to(ROOT).as_posix()
                yield Block(page, token.info.strip(), token.content, token.map[0] + 1)


def blocks_in(language: str) -> list[Block]:
    return [block for block in blocks() if block.language == language]


def command_lines(block: Block) -> list[list[str]]:
    """Return the words of each command in a block of the shell; what a command prints is left out."""
    found = []
    lines = iter(block.text.splitlines())
    for line in lines:
        if not re.match(rf"(?:\$ )?{_PROGRAMS}", line):
            continue
        while line.endswith("\\"):
            line = line[:-1] + next(lines).strip()
        line = re.split(r" {3,}", line.removeprefix("$ "))[0]  # remarks without a sign
        words = shlex.split(line, comments=True)
        command: list[str] = []
        for word in [*words, "&&"]:
            if word == "&&" or word.endswith(";"):
                command += [word[:-1]] if word != "&&" else []
                found.append(command)
                command = []
            else:
                command.append(word)
    return found

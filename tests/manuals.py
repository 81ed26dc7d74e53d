"""The examples in the plugins' docstrings, as text."""

from __future__ import annotations

import inspect
import itertools
import textwrap


def code_tab(manual: str, language: str) -> str:
    """Return the text of a code tab: what stands below its directive, further to the right."""
    lines = inspect.cleandoc(manual).splitlines()
    start = next(i for i, line in enumerate(lines) if line.strip() == f".. code-tab:: {language}")
    margin = lines[start].index(".")
    tab = itertools.takewhile(lambda line: not line[: margin + 1].strip(), lines[start + 1 :])
    return textwrap.dedent("\n".join(line for line in tab if not line.strip().startswith(":")))

"""What a search for better stones found, as a table."""

from __future__ import annotations

import math
from typing import Any

from gemrender.report.formats import Column, TextTable
from gemrender.sweep.improve import Answer, Improvement

__all__ = ["improvement_records", "improvement_table", "improvement_values"]


def improvement_table(found: Improvement) -> TextTable:
    """Return the first stone and the answers, a row each: the goal, and what was varied."""
    names = list(found.start.values)
    table = TextTable([
        Column("Stone", is_text=True),
        Column("Goal", style="bold"),
        *(Column(name.replace("_", " ")) for name in names),
    ])  # fmt: skip
    for label, answer in _rows(found):
        goal = f"{answer.goal:.3f}" if math.isfinite(answer.goal) else "–"
        table.rows.append([label, goal, *(f"{answer.values[name]:.6g}" for name in names)])
    table.note(f"Goal: {found.goal.text}; {found.tried} different stones tried, seed {found.seed}.")
    return table


def _rows(found: Improvement) -> list[tuple[str, Answer]]:
    answers = [(f"improved {number}", answer) for number, answer in enumerate(found.answers, start=1)]
    return [(found.start.stone.name, found.start), *answers]


def improvement_records(found: Improvement) -> list[dict[str, Any]]:
    """Return the first stone and the answers as flat records."""
    return [{"name": label, "goal": answer.goal, **answer.values} for label, answer in _rows(found)]


def improvement_values(found: Improvement) -> dict[str, Any]:
    """Return what was found as JSON has it; null for a goal that cannot be."""

    def values(answer: Answer) -> dict[str, Any]:
        goal = answer.goal if math.isfinite(answer.goal) else None
        return {"goal": goal, "values": answer.values}

    return {
        "name": found.start.stone.name,
        "goal": found.goal.text,
        "start": values(found.start),
        "answers": [values(answer) for answer in found.answers],
        "tried": found.tried,
        "seed": found.seed,
    }

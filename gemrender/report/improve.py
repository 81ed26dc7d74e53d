"""What a search for better stones found, as tables, records and JSON; of one goal, or a front of several."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from gemrender.report.formats import Column, TextTable
from gemrender.report.page_sections import figure_section, tables_section
from gemrender.report.pareto import front_words
from gemrender.report.sensitivity import cliff_cells
from gemrender.sweep.improve import Answer, Front, Improvement
from gemrender.sweep.improve.answers import Details
from gemrender.sweep.improve.checks import is_better
from gemrender.sweep.improve.goal_slopes import GoalSlope

__all__ = [
    "goal_names",
    "improvement_records",
    "improvement_sections",
    "improvement_tables",
    "improvement_values",
]

_SIGNS = {"deg": "°", "%": "%", "": ""}
#: Values of a measure in the table; the page and JSON have them all.
_MOST_VALUES = 4


def goal_names(found: Improvement | Front) -> list[str]:
    """Return what the goals are called in tables."""
    goals = found.goals
    return ["Goal"] if len(goals) == 1 else [f"Goal {number}" for number in range(1, len(goals) + 1)]


def _rows(found: Improvement | Front) -> list[tuple[str, Answer]]:
    answers = [(f"improved {number}", answer) for number, answer in enumerate(found.answers, start=1)]
    return [(found.start.stone.name, found.start), *answers]


def improvement_tables(found: Improvement | Front) -> list[TextTable]:
    """Return the first stone and the answers, what is told of each of their parameters, and their check."""
    tables = [_answers_table(found)]
    if found.start.details is not None:
        tables.append(_parameters_table(found))
    if found.start.checks:
        tables.append(_checks_table(found))
    return tables


# ---- Tables --------------------------------------------------------------------------------------------


def _answers_table(found: Improvement | Front) -> TextTable:
    """Return a row for each stone: its goals, what was varied, and its measures."""
    names, details = list(found.start.values), found.start.details
    table = TextTable([
        Column("Stone", is_text=True),
        *(Column(name, style="bold") for name in goal_names(found)),
        *(Column(name.replace("_", " ")) for name in names),
        *(Column(name, rank=1) for name, _ in ([] if details is None else _measured(details))),
    ])  # fmt: skip
    for label, answer in _rows(found):
        measured = [] if answer.details is None else _measured(answer.details)
        table.rows.append([
            label,
            *map(_goal_text, answer.goals),
            *(f"{answer.values[name]:.6g}" for name in names),
            *(f"{value:.2f}" for _, value in measured),
        ])  # fmt: skip
    for name, goal in zip(goal_names(found), found.goals, strict=True):
        table.note(f"{name}: {goal.text}.")
    words = f"{found.tried} different stones tried, seed {found.seed}"
    if isinstance(found, Front):
        words += f"; {len(found.front)} of them are on the front: none is better by all goals"
    table.note(f"{words}.")
    return table


def _goal_text(goal: float) -> str:
    return f"{goal:.3f}" if math.isfinite(goal) else "–"


def _measured(details: Details) -> list[tuple[str, float]]:
    """Return the paper's scores, and the first values of every other measure, by name."""
    out = [("Average", details.average), ("Rear", details.rear)]
    for of in details.measures:
        if of.name != "inoue":
            shown = list(of.values.items())[:_MOST_VALUES]
            out += [(of.name if key == "value" else f"{of.name} {key}", value) for key, value in shown]
    return out


def _parameters_table(found: Improvement | Front) -> TextTable:
    """Return a row for each parameter of each stone: as reported, slopes of the goals, and cliffs."""
    slopes = [
        column
        for name in goal_names(found)
        for column in (Column(f"{name} by 1", style="bold"), Column("±", rank=3))
    ]
    table = TextTable([
        Column("Stone", is_text=True),
        Column("Parameter", is_text=True),
        Column("is"),
        Column("reported", rank=2),
        *slopes,
        Column("cliff below"),
        Column("jumps", rank=1, is_text=True),
        Column("above"),
        Column("jumps", rank=1, is_text=True),
    ], ruled=True)  # fmt: skip
    for label, answer in _rows(found):
        details = answer.details
        assert details is not None
        for number, (name, value) in enumerate(answer.values.items()):
            of_goals = [of_goal[number] for of_goal in details.slopes]
            sign = _SIGNS[of_goals[0].unit]
            reported = details.report.get(name)
            table.rows.append([
                "" if number else label,
                name.replace("_", " "),
                f"{value:.6g}{sign}",
                "" if reported is None else f"{reported:g}{sign}",
                *(cell for of in of_goals for cell in _slope_cells(of)),
                *(cell for cliff in details.nearest(name) for cell in cliff_cells(cliff)),
            ])  # fmt: skip
    table.note("reported: what a laboratory's report would round it to.")
    table.note("by 1: how much the goal changes with one unit of the parameter, exact to ±.")
    slopes_of = (of for _, answer in _rows(found) if answer.details for of in answer.details.slopes)
    if any(slope.between is not None for of_goal in slopes_of for slope in of_goal):
        table.note("Where ± is two values, the slope is a difference: of the goal at these values.")
    table.note(
        "cliff: the next place where what is measured jumps, and by how much on the way up; "
        "none to: no such jump as far as that value."
    )
    return table


def _slope_cells(of: GoalSlope) -> tuple[str, str]:
    if not math.isfinite(of.slope):
        return "–", ""
    return f"{of.slope:+.3f}", _exactness(of)


def _exactness(of: GoalSlope) -> str:
    if of.between is None:
        return f"{of.bound:.3f}"
    low, high = of.between
    return f"{low:.5g} to {high:.5g}"


def _checks_table(found: Improvement | Front) -> TextTable:
    """Return a row for each stone and engine: the goals, what they differ by, and how its rays compare."""
    names = goal_names(found)
    table = TextTable([
        Column("Stone", is_text=True),
        Column("Engine", is_text=True),
        *(column for name in names for column in (Column(name, style="bold"), Column("difference"))),
        Column("Average", rank=2),
        Column("Rear", rank=2),
        Column("Rays", rank=1, is_text=True),
    ], ruled=True)  # fmt: skip
    for label, answer in _rows(found):
        cells = [cell for goal in answer.goals for cell in (_goal_text(goal), "")]
        scores = ["", ""] if answer.details is None else [
            f"{value:.2f}" for value in (answer.details.average, answer.details.rear)]  # fmt: skip
        table.rows.append([label, "exact", *cells, *scores, ""])
        for of in answer.checks:
            pairs = zip(of.goals, answer.goals, strict=True)
            cells = [cell for a, b in pairs for cell in (_goal_text(a), f"{a - b:+.3f}")]
            rays = "; ".join(of.failures) or "alike"
            table.rows.append(["", of.engine, *cells, f"{of.average:.2f}", f"{of.rear:.2f}", rays])
    pixels = found.start.checks[0].resolution
    table.note(
        f"difference: from the exact engine's; Mitsuba's and the reference's are of {pixels} pixels a side. "
        "Rays: whether Mitsuba's, and in the reference's row the exact engine's, end as the reference's do."
    )
    better = [label for label, answer in _rows(found)[1:] if _is_better_by_all(answer, found.start)]
    by = "the goal" if len(names) == 1 else "no goal worse and one better"
    table.note(f"Better than the start, by {by}, by all three engines: {', '.join(better) or 'none'}.")
    return table


def _is_better_by_all(answer: Answer, start: Answer) -> bool:
    """Whether an answer is better than the start by the exact engine, by Mitsuba and by the reference."""
    checks = zip(answer.checks, start.checks, strict=True)
    return is_better(answer.goals, start.goals) and all(is_better(a.goals, b.goals) for a, b in checks)


def improvement_sections(found: Improvement | Front, figure: Path | None = None) -> str:
    """Return the tables, and the figure of a front, as sections of a page (HTML)."""
    drawn = ""
    if figure is not None and isinstance(found, Front):
        drawn = figure_section("Front", figure, front_words(found))
    return drawn + tables_section("What was found", improvement_tables(found))


# ---- For machines --------------------------------------------------------------------------------------


def improvement_records(found: Improvement | Front) -> list[dict[str, Any]]:
    """Return the first stone and the answers as flat records."""
    keys = [name.lower().replace(" ", "_") for name in goal_names(found)]
    out = []
    for label, answer in _rows(found):
        record = {"name": label, **dict(zip(keys, answer.goals, strict=True)), **answer.values}
        if answer.details is not None:
            record |= _details_record(answer.details, keys)
        for of in answer.checks:
            record |= {f"{of.engine}_{key}": goal for key, goal in zip(keys, of.goals, strict=True)}
            record |= {f"{of.engine}_average": of.average, f"{of.engine}_rear": of.rear}
        out.append(record)
    return out


def _details_record(details: Details, keys: list[str]) -> dict[str, Any]:
    record: dict[str, Any] = {"average": details.average, "rear": details.rear}
    for of in details.measures:
        record |= {
            of.name if key == "value" else f"{of.name}_{key}": value for key, value in of.values.items()
        }
    record |= {f"reported_{key}": value for key, value in details.report.items()}
    for key, slopes in zip(keys, details.slopes, strict=True):
        for by in slopes:
            record |= {f"{key}_by_{by.parameter}": by.slope, f"{key}_by_{by.parameter}_bound": by.bound}
    for cliff in details.cliffs:
        record[f"{cliff.parameter}_cliff_{cliff.side}"] = cliff.at
    return record


def improvement_values(found: Improvement | Front) -> dict[str, Any]:
    """Return what was found as JSON has it; null for a goal that cannot be."""
    start, *answers = (answer for _, answer in _rows(found))
    out: dict[str, Any] = {"name": start.stone.name}
    if isinstance(found, Front):
        out["goals"] = [goal.text for goal in found.goals]
    else:
        out["goal"] = found.goal.text
    out |= {
        "start": _answer_values(found, start),
        "answers": [_answer_values(found, answer) for answer in answers],
        "tried": found.tried,
        "seed": found.seed,
    }
    if isinstance(found, Front):
        out["front"] = [{"goals": list(of.goals), "values": of.values} for of in found.front]
    return out


def _answer_values(found: Improvement | Front, answer: Answer) -> dict[str, Any]:
    goals = [goal if math.isfinite(goal) else None for goal in answer.goals]
    out: dict[str, Any] = {"goals": goals} if isinstance(found, Front) else {"goal": goals[0]}
    out["values"] = answer.values
    details = answer.details
    if details is not None:
        slopes = [[of.to_dict() for of in of_goal] for of_goal in details.slopes]
        out |= {
            "average": details.average,
            "rear": details.rear,
            "measures": {of.name: of.to_dict() for of in details.measures},
            "report": details.report,
            "slopes": slopes if isinstance(found, Front) else slopes[0],
            "cliffs": [of.to_dict() for of in details.cliffs],
        }
    if answer.checks:
        out["checks"] = [of.to_dict() for of in answer.checks]
        if answer is not found.start:
            out["better_by_all"] = _is_better_by_all(answer, found.start)
    return out

"""The page's table: what measures say of each stone, straight above and turned, with definitions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from gemrender.errors import InputError
from gemrender.measures import Measure, measure_named
from gemrender.observation import MeasureValues, View
from gemrender.report.formats import csv_lines
from gemrender.report.studied import Study
from gemrender.report.tables import LEAST_SHOWN, band_key, band_name, score_record
from gemrender.scoring import Score

__all__ = ["page_table"]

#: A measure that is known this exactly is shown with one more decimal [its unit].
_EXACT = 1e-3


def page_table(stones: Sequence[Study]) -> dict[str, Any]:
    """Return the page's table.

    Parameters
    ----------
    stones : sequence of Study
        At least one, all of the same measures and turns.

    Returns
    -------
    dict
        `groups`: measures, with name, definition, source, version, unit; `columns`: key, label, group,
        decimals, and of bands their number; `turns` [deg], the one straight above among them, `bases` of
        their views and the `axis` in words; `values` and `bounds`, by stone, turn, and column or group;
        `csv`, a head, and lines by stone and turn.

    Raises
    ------
    InputError
        The stones have not the same measures or turns.
    """
    first = stones[0]
    turns = sorted([0.0, *(of.turn_deg for of in first.turned)])
    found = [_by_turn(stone) for stone in stones]
    names = [of.name for of in first.measures]
    for stone, by_turn in zip(stones, found, strict=True):
        alike = all([of.name for of in measures] == names for measures in by_turn)
        if not alike or sorted([0.0, *(of.turn_deg for of in stone.turned)]) != turns:
            raise InputError("must have the measures and turns of the first stone", key="stone")
    every = [measures for by_turn in found for measures in by_turn]
    columns = _columns(first.score, every)
    bases = [(0.0, first.view), *((of.turn_deg, of.view) for of in first.turned)]
    return {
        "groups": _groups(first),
        "columns": [{key: column[key] for key in column if key != "of"} for column in columns],
        "turns": turns,
        "bases": [view.basis().tolist() for _, view in sorted(bases, key=lambda base: base[0])],
        "axis": None if first.axis is None else _axis_name(first.axis),
        "halfWidths": [max((of.view.half_width for of in stone.turned), default=0.0) for stone in stones],
        "values": [
            [[_number(measures[c["group"]], c["of"]) for c in columns] for measures in by_turn]
            for by_turn in found
        ],
        "bounds": [[[of.bound for of in measures] for measures in by_turn] for by_turn in found],
        "csv": _csv(stones),
    }


def _by_turn(stone: Study) -> list[tuple[MeasureValues, ...]]:
    """Return what measures say at each turn, ascending."""
    all_turns = [(0.0, stone.measures), *((of.turn_deg, of.measures) for of in stone.turned)]
    return [measures for _, measures in sorted(all_turns, key=lambda of: of[0])]


def _groups(first: Study) -> list[dict[str, Any]]:
    known: dict[str, Measure] = {of.name: of for of in first.definitions}
    out = []
    for values in first.measures:
        of = known.get(values.name) or measure_named(values.name)
        out.append(
            {"name": of.name, "definition": of.definition, "source": of.source, "version": values.version,
             "unit": of.unit}
        )  # fmt: skip
    return out


def _columns(score: Score, every: Sequence[tuple[MeasureValues, ...]]) -> list[dict[str, Any]]:
    """Return a column for each value: Average and Rear, those of measures, and the bands, brightest first."""
    bands = {band_key(band): k for k, band in enumerate(score.bands)}
    names = {band_key(band): band_name(band, typeset=True) for band in score.bands}
    own = ["average", "rear"]
    own += [key for key in ("trapped", "lost") if any(of[0].values[key] >= LEAST_SHOWN for of in every)]

    def of_score(key: str) -> dict[str, Any]:
        label = names.get(key, key.capitalize())
        return {"key": key, "label": label, "group": 0, "decimals": 2, "of": key, "band": bands.get(key)}

    out = [of_score(key) for key in own]
    for group, of in list(enumerate(every[0]))[1:]:
        bounds = [measures[group].bound for measures in every]
        decimals = 3 if all(bound is not None and bound <= _EXACT for bound in bounds) else 2
        for key, value in (of.values | of.details).items():
            out.append({
                "key": of.name if key == "value" else f"{of.name}_{key}",
                "label": key.replace("_", " "),
                "group": group,
                "decimals": 0 if isinstance(value, int) else decimals,
                "of": key,
                "band": None,
            })  # fmt: skip
    return out + [of_score(key) for key in bands]


def _number(of: MeasureValues, key: str) -> float | None:
    value = (of.values | of.details)[key]
    return None if isinstance(value, float) and math.isnan(value) else value


def _axis_name(axis: float) -> str:
    return {0.0: "x", 90.0: "y"}.get(axis, f"the level axis at {axis:g}°")


def _csv(stones: Sequence[Study]) -> dict[str, Any]:
    """Return the lines of the table as the command line prints them."""
    records = []
    for stone in stones:
        turned = [(of.turn_deg, _turned_score(stone.score, of.measures, of.view)) for of in stone.turned]
        of_turns = sorted([(0.0, stone.score), *turned], key=lambda of: of[0])
        records += [score_record(of) for _, of in of_turns]
    head, *lines = csv_lines(records)
    each = [1 + len(stone.turned) for stone in stones]
    starts = [sum(each[:k]) for k in range(len(each))]
    return {"head": head, "rows": [lines[start : start + n] for start, n in zip(starts, each, strict=True)]}


def _turned_score(upright: Score, measures: Sequence[MeasureValues], view: View) -> Score:
    """Return the score of a turned stone, as far as it is known."""
    own, known = measures[0].values, {of.name: of for of in measures}
    return replace(
        upright,
        average=own["average"],
        rear=own["rear"],
        trapped=own["trapped"],
        lost=own["lost"],
        bands=tuple(replace(band, share=own[band_key(band)]) for band in upright.bands),
        bound=measures[0].bound,
        facets=None,
        seconds=math.nan,
        notes=(),
        tilt_deg=view.tilt_deg,
        tilt_azimuth_deg=view.tilt_azimuth_deg,
        measures=None if upright.measures is None else tuple(known[of.name] for of in upright.measures),
    )

"""Scores and cross-checks as tables for people, and as records for machines."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from gemrender.crosscheck import CrossCheck, ScoreCheck
from gemrender.observation import bound_text
from gemrender.report.formats import Cell, Column, TextTable
from gemrender.scoring import BAND_EDGES, Band, Score
from gemrender.stereo import StereoScore

#: Smallest share that is told of what should be nothing at all [%].
LEAST_SHOWN = 1e-6

__all__ = [
    "LEAST_SHOWN",
    "band_key",
    "band_name",
    "band_names",
    "crosscheck_record",
    "crosscheck_tables",
    "how_text",
    "measure_columns",
    "model_text",
    "score_check_table",
    "score_record",
    "score_table",
    "score_tables",
    "score_values",
    "stereo_record",
    "stereo_table",
    "value_text",
]


def band_name(band: Band, *, typeset: bool = False) -> str:
    """Return a band's name [%], such as ">= 75" or "60-75"; typeset with the signs that print has for it."""
    name = f">= {band.low:g}" if band.high is None else f"{band.low:g}-{band.high:g}"
    return name.replace(">=", "≥").replace("-", "–") if typeset else name


def band_names(*, typeset: bool = False) -> list[str]:
    """Return the names of all bands, brightest first."""
    above = (None, *BAND_EDGES[:-1])
    return [
        band_name(Band(low=low, high=high, share=0.0), typeset=typeset)
        for low, high in zip(BAND_EDGES, above, strict=True)
    ]


def band_key(band: Band) -> str:
    """Return the name of a band's column for machines, such as "band_75": by its lower edge [%]."""
    return f"band_{band.low:g}"


def model_text(score: Score) -> str:
    """Say in words by what rules a stone was scored."""
    intensity = {"primary": "primary intensity", "radiance": "radiance"}[score.intensity]
    law = {"gubelin": "Gübelin's table", "exact": "Fresnel's equations"}[score.fresnel]
    return f"{intensity}, {law} (index {score.index:g}), rear light by {score.rear_rule}"


def how_text(score: Score) -> str:
    """Say in words how a stone was scored: by how many rays and what, or exactly and how exactly."""
    within = f", every figure within ±{bound_text(score.bound or 0.0)}"
    if score.resolution is None:
        return score.engine + within
    engine = f"{score.engine} ({score.variant})" if score.variant else score.engine
    rays = f"{score.resolution} × {score.resolution} rays, {engine}"
    return rays if score.bound is None else rays + within


# ---- Scores --------------------------------------------------------------------------------------------


def score_table(
    scores: Sequence[Score], settings: Sequence[dict[str, Any]] = (), notes: Sequence[str] = ()
) -> TextTable:
    """Return a row a stone: Average, Rear and the bands [%].

    Parameters
    ----------
    scores : sequence of Score
        At least one.
    settings : sequence of dict, optional
        Of each stone what was set for it, by name: columns before the scores.
    notes : sequence of str, optional
        What is to be said of the stones, such as what was assumed of them.
    """
    exact = any(s.facets is not None for s in scores)
    varied = list(settings[0]) if settings else []
    bands = scores[0].bands
    # Dark bands are the first to go: what is left of 100 tells their sum.
    table = TextTable([
        Column("Stone", is_text=True),
        *(Column(name.replace("_", " ")) for name in varied),
        Column("Average", style="bold"),
        Column("Rear", style="bold"),
        *(Column(band_name(b), rank=1 + k) for k, b in enumerate(bands)),
        Column("Trapped", rank=len(bands) + 1),
        *([Column("Facets", rank=len(bands) + 2)] if exact else []),
    ])  # fmt: skip
    for number, s in enumerate(scores):
        table.rows.append([
            _without(s.name, varied),
            *(_shown(settings[number][name]) for name in varied),
            f"{s.average:.2f}",
            f"{s.rear:.2f}",
            *(f"{b.share:.1f}" for b in s.bands),
            _small(s.trapped),
            *([str(s.facets.number) if s.facets else "–"] if exact else []),
        ])  # fmt: skip
    _explain(table, scores, exact)
    for words in notes:
        table.note(f"{words}.", "yellow")
    return table


def score_tables(
    scores: Sequence[Score], settings: Sequence[dict[str, Any]] = (), notes: Sequence[str] = ()
) -> list[TextTable]:
    """Return the table of scores, and one of further measures if there are any; parameters as before."""
    tables = [score_table(scores, settings, notes)]
    if any(score.measures for score in scores):
        tables.append(measures_table(scores))
    return tables


def measures_table(scores: Sequence[Score]) -> TextTable:
    """Return a row for each value of each measure, a column a stone.

    Parameters
    ----------
    scores : sequence of Score
        At least one, all of the same measures.
    """
    table = TextTable([
        Column("Measure", is_text=True),
        Column("Value", is_text=True),
        *(Column(score.name, rank=k) for k, score in enumerate(scores)),
    ])  # fmt: skip
    for found in zip(*(score.measures or () for score in scores), strict=True):
        rows = [of.values | of.details for of in found]
        for k, key in enumerate(rows[0]):
            cells = [value_text(row[key], of.bound) for row, of in zip(rows, found, strict=True)]
            table.rows.append([found[0].name if k == 0 else "", "" if key == "value" else key, *cells])
        if found[0].bound is not None and found[0].values:
            cells = [f"±{bound_text(of.bound or 0.0)}" for of in found]
            table.rows.append(["", "bound", *cells])
    table.note("Definitions and sources: gemrender measures.")
    return table


def stereo_table(found: Sequence[StereoScore]) -> TextTable:
    """Return a row a stone: what each eye sees, and the share of the view on which they disagree [%]."""
    measures = [of.name for of in found[0].left.measures or () if "value" in of.values]
    eyes = ("left", "right")
    table = TextTable([
        Column("Stone", is_text=True),
        *(Column(f"{name}, {eye}") for name in ("Average", "Rear", *measures) for eye in eyes),
        Column("Disagree", style="bold"),
        Column("Bound"),
    ])  # fmt: skip
    for each in found:
        by_eye = [each.left, each.right]
        values = [[score.average for score in by_eye], [score.rear for score in by_eye]]
        for name in measures:
            values.append([of.values["value"] for s in by_eye for of in s.measures or () if of.name == name])
        table.rows.append([
            each.middle.name,
            *(f"{value:.2f}" for pair in values for value in pair),
            f"{each.disagreement:.2f}",
            f"±{bound_text(each.bound)}",
        ])  # fmt: skip
    first = found[0]
    table.note(
        f"Eyes {first.eye_separation:g} mm apart, {first.eye_distance:g} mm from the stone; above, the score "
        "from between them."
    )
    table.note(
        "Disagree: share of the view that the eyes see lit from different zones of aset, or one the head."
    )
    return table


def stereo_record(found: StereoScore, settings: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return what two eyes see as one flat record: the score from between them, and each eye's after it."""
    stereo = found.to_dict()["stereo"]
    out = score_record(found.middle, settings)
    for eye, score in (("left", found.left), ("right", found.right)):
        del stereo[eye]
        same = ("name", "engine", "index", "rear_rule", "variant", "resolution", "fresnel", "intensity")
        record = {key: value for key, value in score_record(score).items() if key not in same}
        out |= {f"{eye}_{key}": value for key, value in record.items()}
    return out | {f"stereo_{key}" if key == "bound" else key: value for key, value in stereo.items()}


def value_text(value: Any, bound: float | None) -> str:
    """Return a value in words, with as many decimals as its bound is worth."""
    if isinstance(value, int):
        return str(value)
    return "–" if math.isnan(value) else f"{value:.{2 if bound is None or bound > 1e-3 else 3}f}"


def _explain(table: TextTable, scores: Sequence[Score], exact: bool) -> None:
    first = scores[0]
    table.note("Average: mean intensity; the rest: shares of the top view; all in per cent.")
    if exact:
        table.note("Facets: number of virtual facets, those near the girdle left out.", of="Facets")
    if first.tilt_deg:
        eye = f"{first.tilt_deg:g} deg towards azimuth {first.tilt_azimuth_deg:g} deg"
        table.note(f"The eye is tilted by {eye}.")
    bound = max((s.bound for s in scores if s.bound is not None), default=None)
    for say in (lambda s: how_text(s if s.bound is None else replace(s, bound=bound)), model_text):
        names: dict[str, list[str]] = {}
        for s in scores:
            names.setdefault(say(s), []).append(s.name)
        for words, of in names.items():
            table.note(f"{words}{'' if len(names) == 1 else ': ' + _names(of)}.")
    for s in scores:
        for words in s.notes:
            table.note(f"{s.name}: {words}.", "yellow")
        if s.lost:
            table.note(f"{s.name}: {s.lost:.2g} % of the rays were lost to rounding.", "yellow")


def _without(name: str, keys: Sequence[str]) -> str:
    """Return a stone's name without the settings at its end, which have columns of their own."""
    for key in reversed(keys):
        name = re.sub(rf" {re.escape(key)}=\S+$", "", name)
    return name


def _names(names: Sequence[str], most: int = 6) -> str:
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")


def _small(share: float) -> str:
    return f"{share:.3g}" if share >= LEAST_SHOWN else "0"


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def score_values(score: Score, settings: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return a score as JSON has it, with what was set for its stone, if anything was."""
    return score.to_dict() | ({"settings": settings} if settings else {})


def score_record(score: Score, settings: dict[str, Any] | None = None) -> dict[str, Any]:
    """Return a score as one flat record, shares and scores in per cent.

    Parameters
    ----------
    score : Score
        The score.
    settings : dict, optional
        What was set for its stone, by name: columns after the stone's name.
    """
    values = score.to_dict()
    facets = values.pop("facets")
    last = {key: values.pop(key) for key in ("assumed", "notes")}
    measures = values.pop("measures", {})
    values.pop("bands")
    first = {"name": values.pop("name"), **(settings or {})}
    main = {key: values.pop(key) for key in ("average", "rear")}
    bands = {band_key(b): b.share for b in score.bands}
    how = {key: values.pop(key) for key in ("trapped", "lost", "bound", "engine", "index", "rear_rule")}
    number = None if facets is None else facets["number"]
    measured = measure_columns(measures)
    return {**first, **main, **bands, **how, **values, "facets": number, **last, **measured}


def measure_columns(measures: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Return measures as JSON has them as one flat record: `iso` for its value, `iso_bound` ..."""
    return {
        name if key == "value" else f"{name}_{key}": value
        for name, of in measures.items()
        for key, value in of.items()
    }


# ---- Cross-checks --------------------------------------------------------------------------------------


def crosscheck_tables(checks: Sequence[CrossCheck]) -> list[TextTable]:
    """Return two tables, a row a stone: how rays agree and how scores agree; then what disagrees."""
    name, engine = Column("Stone", is_text=True), Column("Engine")
    numbers = ["Rays", "Same exit", "Same path", "ΔI mean", "ΔI max", "Lost", ""]
    ranks = [4, 0, 5, 3, 2, 1, 0]
    rays = TextTable([name, engine, *map(Column, numbers, ranks)])
    bands = [Column(f"Δ {band_name(b)}", rank=1 + k) for k, b in enumerate(checks[0].bands)]
    scores = TextTable([name, engine, Column("ΔAverage"), Column("ΔRear"), *bands])
    for c in checks:
        rays.rows.append([
            c.name,
            c.engines[0],
            f"{c.rays}",
            f"{c.same_exit:.4f}",
            f"{c.same_path:.4f}",
            f"{c.mean_intensity:.1e}",
            f"{c.largest_intensity:.1e}",
            f"{c.lost:.4f}",
            Cell("differs", "red") if c.failures else Cell("agrees", "green"),
        ])  # fmt: skip
        differences = (c.average, c.rear, *(b.share for b in c.bands))
        scores.rows.append([c.name, c.engines[0], *(f"{x:+.4f}" for x in differences)])
    scores.note("Differences are the engine minus the reference; all but Rays in per cent.")
    scores.note("Same exit: rays with the same status and exit facet; same path: and facet sequence.")
    scores.note("Rays that are reflected more than 100 times may part; of the others 99.9 % must end alike.")
    scores.note("ΔI: difference in intensity among rays with the same path.")
    for c in checks:
        for failure in c.failures:
            scores.note(f"{c.name}, {c.engines[0]}: {failure}", "red")
    return [rays, scores]


def score_check_table(checks: Sequence[ScoreCheck]) -> TextTable:
    """Return a table, a row a stone: how means over random rays agree with exact scores."""
    bands = [Column(f"Δ {band_name(b)}", rank=1 + k) for k, b in enumerate(checks[0].bands)]
    numbers = [*map(Column, ("Rays", "ΔAverage", "±", "ΔRear", "±")), *bands]
    table = TextTable([Column("Stone", is_text=True), *numbers, Column("Lost", rank=1), Column("")])
    for c in checks:
        table.rows.append([
            c.name,
            f"{c.rays}",
            f"{c.average:+.4f}",
            f"{c.average_allowed:.4f}",
            f"{c.rear:+.4f}",
            f"{c.rear_allowed:.4f}",
            *(f"{b.share:+.4f}" for b in c.bands),
            f"{c.lost:.4f}",
            Cell("differs", "red") if c.failures else Cell("agrees", "green"),
        ])  # fmt: skip
    table.note("Differences are Mitsuba's mean over random rays minus the exact score, in per cent.")
    table.note("±: what its bound, and scatter and number of the rays, allow with a confidence of 99.9 %.")
    for c in checks:
        for failure in c.failures:
            table.note(f"{c.name}: {failure}", "red")
    return table


def crosscheck_record(check: CrossCheck | ScoreCheck) -> dict[str, Any]:
    """Return a cross-check as one flat record."""
    values = check.to_dict()
    bands = values.pop("bands")
    engine, reference = values.pop("engines")
    failures = values.pop("failures")
    values["seconds"], values["reference_seconds"] = values["seconds"]
    shares = {f"band_{band['from']:g}": band["difference"] for band in bands}
    shares |= {f"band_{band['from']:g}_allowed": band["allowed"] for band in bands if "allowed" in band}
    first = {"name": values.pop("name"), "engine": engine, "reference": reference}
    return {**first, **values, **shares, "failures": list(failures)}

"""Scores and cross-checks as tables for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from gemrender.crosscheck import CrossCheck
from gemrender.observation import bound_text
from gemrender.score import Band, Score

#: Smallest share that is told of what should be nothing at all [%].
LEAST_SHOWN = 1e-6

__all__ = [
    "LEAST_SHOWN",
    "band_name",
    "how_text",
    "model_text",
    "note",
    "print_crosschecks",
    "print_scores",
    "table",
]


def band_name(band: Band, *, typeset: bool = False) -> str:
    """Return a band's name [%], such as ">= 75" or "60-75"; typeset with the signs that print has for it."""
    name = f">= {band.low:g}" if band.high is None else f"{band.low:g}-{band.high:g}"
    return name.replace(">=", "≥").replace("-", "–") if typeset else name


def model_text(score: Score) -> str:
    """Say in words by what rules a stone was scored."""
    intensity = {"primary": "primary intensity", "radiance": "radiance"}[score.intensity]
    law = {"gubelin": "Gübelin's table", "exact": "Fresnel's equations"}[score.fresnel]
    return f"{intensity}, {law} (index {score.index:g}), rear light by {score.rear_rule}"


def how_text(score: Score) -> str:
    """Say in words how a stone was scored: by how many rays and what, or exactly and how exactly."""
    if score.resolution is None:
        return f"{score.engine}, every figure within ±{bound_text(score.bound or 0.0)}"
    engine = f"{score.engine} ({score.variant})" if score.variant else score.engine
    return f"{score.resolution} × {score.resolution} rays, {engine}"


def print_scores(scores: Sequence[Score], console: Console) -> None:
    """Print a row a stone: Average, Rear and the bands [%]."""
    exact = any(s.facets is not None for s in scores)
    columns = ["Trapped", "Facets"] if exact else ["Trapped"]
    rows = table("Average", "Rear", *(band_name(b) for b in scores[0].bands), *columns)
    for s in scores:
        rows.add_row(
            Text(s.name),
            Text(f"{s.average:.2f}", style="bold"),
            Text(f"{s.rear:.2f}", style="bold"),
            *(f"{b.share:.1f}" for b in s.bands),
            f"{s.trapped:.3g}" if s.trapped >= LEAST_SHOWN else "0",
            *([str(s.facets.number) if s.facets else "–"] if exact else []),
        )
    console.print(rows)
    first = scores[0]
    note(console, "Average: mean intensity; the rest: shares of the top view; all in per cent.")
    if exact:
        note(console, "Facets: number of virtual facets, those near the girdle left out.")
    if first.tilt_deg:
        note(
            console,
            f"The eye is tilted by {first.tilt_deg:g} deg towards azimuth {first.tilt_azimuth_deg:g} deg.",
        )
    bound = max((s.bound for s in scores if s.bound is not None), default=None)
    for say in (lambda s: how_text(s if s.bound is None else replace(s, bound=bound)), model_text):
        names: dict[str, list[str]] = {}
        for s in scores:
            names.setdefault(say(s), []).append(s.name)
        for words, of in names.items():
            note(console, f"{words}{'' if len(names) == 1 else ': ' + ', '.join(of)}.")
    for s in scores:
        for words in s.notes:
            note(console, f"{s.name}: {words}.", style="yellow")
        if s.lost:
            note(console, f"{s.name}: {s.lost:.2g} % of the rays were lost to rounding.", style="yellow")


def print_crosschecks(checks: Sequence[CrossCheck], console: Console) -> None:
    """Print two tables, a row a stone: how rays agree and how scores agree; then what disagrees."""
    rays = table("Engine", "Rays", "Same exit", "Same path", "ΔI mean", "ΔI max", "Lost", "")
    scores = table("Engine", "ΔAverage", "ΔRear", *(f"Δ {band_name(b)}" for b in checks[0].bands))
    for c in checks:
        rays.add_row(
            Text(c.name),
            c.engines[0],
            f"{c.rays}",
            f"{c.same_exit:.4f}",
            f"{c.same_path:.4f}",
            f"{c.mean_intensity:.1e}",
            f"{c.largest_intensity:.1e}",
            f"{c.lost:.4f}",
            Text("differs", style="red") if c.failures else Text("agrees", style="green"),
        )
        differences = (c.average, c.rear, *(b.share for b in c.bands))
        scores.add_row(Text(c.name), c.engines[0], *(f"{x:+.4f}" for x in differences))
    console.print(rays)
    console.print(scores)
    note(console, "Differences are the engine minus the reference; all but Rays in per cent.")
    note(console, "Same exit: rays with the same status and exit facet; same path: and facet sequence.")
    note(
        console, "Rays that are reflected more than 100 times may part; of the others 99.9 % must end alike."
    )
    note(console, "ΔI: difference in intensity among rays with the same path.")
    for c in checks:
        for failure in c.failures:
            note(console, f"{c.name}, {c.engines[0]}: {failure}", style="red")


def table(*columns: str) -> Table:
    """Return a table with a column for the stone, which gives way where it is narrow, and for numbers."""
    made = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    made.add_column("Stone", overflow="fold")
    for name in columns:
        made.add_column(Text(name), justify="right", no_wrap=True)
    return made


def note(console: Console, words: str, style: str = "dim") -> None:
    """Print a line beneath a table."""
    # As Text: a stone's name may hold what would be markup.
    console.print(Text(words, style=style), soft_wrap=True)

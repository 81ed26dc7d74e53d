"""Scores and cross-checks as tables for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from gemrender.crosscheck import CrossCheck
from gemrender.score import Band, Score

__all__ = ["band_name", "model_text", "note", "print_crosschecks", "print_scores", "table"]


def band_name(band: Band, *, typeset: bool = False) -> str:
    """Return a band's name [%], such as ">= 75" or "60-75"; typeset with the signs that print has for it."""
    name = f">= {band.low:g}" if band.high is None else f"{band.low:g}-{band.high:g}"
    return name.replace(">=", "≥").replace("-", "–") if typeset else name


def model_text(score: Score) -> str:
    """Say in words by what rules a stone was scored."""
    intensity = {"primary": "primary intensity", "radiance": "radiance"}[score.intensity]
    law = {"gubelin": "Gübelin's table", "exact": "Fresnel's equations"}[score.fresnel]
    return f"{intensity}, {law} (index {score.index:g}), rear light by {score.rear_rule}"


def print_scores(scores: Sequence[Score], console: Console) -> None:
    """Print a row a stone: Average, Rear and the bands [%]."""
    rows = table("Average", "Rear", *(band_name(b) for b in scores[0].bands), "Trapped")
    for s in scores:
        rows.add_row(
            Text(s.name),
            Text(f"{s.average:.2f}", style="bold"),
            Text(f"{s.rear:.2f}", style="bold"),
            *(f"{b.share:.1f}" for b in s.bands),
            f"{s.trapped:.3g}",
        )
    console.print(rows)
    first = scores[0]
    engine = f"{first.engine} ({first.variant})" if first.variant else first.engine
    view = f"{first.resolution} x {first.resolution} rays"
    if first.tilt_deg:
        view += f", the eye tilted by {first.tilt_deg:g} deg towards azimuth {first.tilt_azimuth_deg:g} deg"
    note(console, "Average: mean intensity; the rest: shares of the top view; all in per cent.")
    note(console, f"{engine}, {view}.")
    models: dict[str, list[str]] = {}
    for s in scores:
        models.setdefault(model_text(s), []).append(s.name)
    for model, names in models.items():
        note(console, f"{model}{'' if len(models) == 1 else ': ' + ', '.join(names)}.")
    for s in scores:
        if s.lost:
            note(console, f"{s.name}: {s.lost:.2g} % of the rays were lost to rounding.", style="yellow")


def print_crosschecks(checks: Sequence[CrossCheck], console: Console) -> None:
    """Print two tables, a row a stone: how rays agree and how scores agree; then what disagrees."""
    rays = table("Rays", "Same exit", "Same path", "ΔI mean", "ΔI max", "Lost", "")
    scores = table("ΔAverage", "ΔRear", *(f"Δ {band_name(b)}" for b in checks[0].bands))
    for c in checks:
        rays.add_row(
            Text(c.name),
            f"{c.rays}",
            f"{c.same_exit:.4f}",
            f"{c.same_path:.4f}",
            f"{c.mean_intensity:.1e}",
            f"{c.largest_intensity:.1e}",
            f"{c.lost:.4f}",
            Text("differs", style="red") if c.failures else Text("agrees", style="green"),
        )
        scores.add_row(Text(c.name), *(f"{x:+.4f}" for x in (c.average, c.rear, *(b.share for b in c.bands))))
    console.print(rays)
    console.print(scores)
    note(console, "Differences are Mitsuba minus reference; all but Rays in per cent.")
    note(console, "Same exit: rays with the same status and exit facet; same path: and facet sequence.")
    note(console, "ΔI: difference in intensity among rays with the same path.")
    for c in checks:
        for failure in c.failures:
            note(console, f"{c.name}: {failure}", style="red")


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

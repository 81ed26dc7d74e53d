"""Scores and cross-checks as tables for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from gemrender.crosscheck import CrossCheck
from gemrender.score import Band, Score

__all__ = ["band_name", "print_crosschecks", "print_scores"]


def band_name(band: Band) -> str:
    """Return a band's name, such as ">= 75" or "60-75" [%]."""
    return f">= {band.low:g}" if band.high is None else f"{band.low:g}-{band.high:g}"


def print_scores(scores: Sequence[Score], console: Console) -> None:
    """Print a row a stone: Average, Rear and the bands [%]."""
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("Stone", no_wrap=True, overflow="ellipsis")
    for name in ("Average", "Rear", *(band_name(b) for b in scores[0].bands), "Trapped"):
        table.add_column(name, justify="right", no_wrap=True)
    for s in scores:
        table.add_row(
            s.name,
            f"[bold]{s.average:.2f}[/]",
            f"[bold]{s.rear:.2f}[/]",
            *(f"{b.share:.1f}" for b in s.bands),
            f"{s.trapped:.3g}",
        )
    console.print(table)
    first = scores[0]
    engine = f"{first.engine} ({first.variant})" if first.variant else first.engine
    console.print(
        "Average: mean intensity; the rest: shares of the top view; all in per cent.\n"
        f"{engine}, {first.resolution} x {first.resolution}, {first.fresnel} transmittance, "
        f"{'primary intensity' if first.intensity == 'primary' else 'radiance'}, rear by {first.rear_rule}",
        style="dim",
        highlight=False,
    )
    for s in scores:
        if s.lost:
            console.print(f"{s.name}: {s.lost:.2g} % of the rays were lost to rounding", style="yellow")


def print_crosschecks(checks: Sequence[CrossCheck], console: Console) -> None:
    """Print a row a stone: agreement of the two tracers, and the verdict."""
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for name in ("Stone", "Rays", "Exit %", "Path %", "ΔI mean", "ΔI max", "ΔAverage", "ΔRear", "ΔBand",
                 "Lost %", ""):  # fmt: skip
        table.add_column(name, justify="left" if name in ("Stone", "") else "right", no_wrap=True)
    for c in checks:
        table.add_row(
            c.name,
            f"{c.rays}",
            f"{c.same_exit:.4f}",
            f"{c.same_path:.4f}",
            f"{c.mean_intensity:.1e}",
            f"{c.largest_intensity:.1e}",
            f"{c.average:+.4f}",
            f"{c.rear:+.4f}",
            f"{max(abs(b.share) for b in c.bands):.4f}",
            f"{c.lost:.4f}",
            "[red]differs[/]" if c.failures else "[green]agrees[/]",
        )
    console.print(table)
    console.print(
        "Exit, Path: rays with the same status and exit facet, and with the same facet sequence.\n"
        "ΔI: difference in intensity among the latter. All but Rays in per cent.",
        style="dim",
        highlight=False,
    )
    for c in checks:
        for failure in c.failures:
            console.print(f"{c.name}: {failure}", style="red", highlight=False)

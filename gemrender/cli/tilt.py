"""The command `tilt`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.groups import command
from gemrender.cli.options import (
    OUTPUT,
    VIEW,
    Bound,
    EngineOptions,
    MaterialOptions,
    MeasureOptions,
    ModelOptions,
    Resolution,
    TableOptions,
    output_option,
    prepare_engine,
    trace_options,
)
from gemrender.cli.output import print_records
from gemrender.cli.stones import LoadedStones, StoneOptions, load
from gemrender.cli.studies import study_each
from gemrender.cli.values import OptionError, complete_words, number_option
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.sweep.tilted import TiltStudy

__all__ = ["tilt"]

#: Its words are those of `gemrender.sweep.poses`, which is heavier to import.
_AXES = ("x", "y", "both", "surface")


def _axis(text: str | float) -> str | float:
    if text in _AXES:
        return text
    try:
        return float(text)
    except ValueError:
        allowed = f"must be one of {', '.join(_AXES)}, or the azimuth of an axis in degrees"
        raise OptionError(InputError(allowed, key="--axis", value=text)) from None


@dataclass(frozen=True, slots=True, kw_only=True)
class TiltEngineOptions(EngineOptions):
    """What traces the poses: many, so less finely than a single score."""

    bound: Bound = 0.1
    resolution: Resolution = 256


@command
def tilt(
    given: StoneOptions,
    engine: TiltEngineOptions,
    of: MaterialOptions,
    model: ModelOptions,
    measured: MeasureOptions,
    table: TableOptions,
    to: Annotated[
        float,
        number_option(
            "--to", "degrees", "Largest tilt, above 0 and below 90.", metavar="DEGREES", rich_help_panel=VIEW
        ),
    ] = 30.0,
    step: Annotated[
        float,
        number_option(
            "--step", "degrees", "Step from tilt to tilt.", metavar="DEGREES", rich_help_panel=VIEW
        ),
    ] = 1.0,
    axis: Annotated[
        Any,
        typer.Option(
            "--axis",
            parser=_axis,
            metavar="AXIS",
            help="What the stone is turned about, both ways: x, y, both, the azimuth of an axis, or "
            "surface, for all of them.",
            autocompletion=complete_words(lambda: _AXES),
            rich_help_panel=VIEW,
        ),
    ] = "x",
    film: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="Write a film of one stone about one axis: the map of the first measure, and curves; "
            ".mp4, .gif or .webp.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    out: Annotated[
        str | None,
        output_option("Where to write the figure and every pose; a study that was stopped goes on there."),
    ] = None,
) -> None:
    """Tilt stones: measures as curves over the tilt, with bounds, or as a surface over all tilts."""
    from gemrender.engines import check_head
    from gemrender.report.tilt import tilt_records, tilt_table, write_tilt_figure
    from gemrender.sweep import study_tilt
    from gemrender.sweep.poses import tilt_poses
    from gemrender.sweep.tilt import tilt_measures

    form = table.chosen
    study: dict[str, Any] = {
        "measures": tilt_measures(measured.measures or "inoue"),
        "head": check_head(measured.head),
        "axis": axis,
        "to_deg": to,
        "step_deg": step,
    }
    options = trace_options(engine, model)
    del options["tilt"], options["tilt_azimuth"]
    loaded = load(given.stones, options, given.settings, of.material)
    for stone in loaded.samples:
        poses = tilt_poses(axis, to, step, stone.symmetry)
    if film is not None:
        _check_film(film, loaded, poses, len(study["measures"]))
    prepare_engine(options, loaded.samples, out)
    loaded.tell()

    def write_film(studied: TiltStudy, progress: Callable[[float], None]) -> Path:
        from gemrender.report.tilt_film import write_tilt_film

        return write_tilt_film(
            studied, loaded.stones[0], Path(film or ""), options=options, progress=progress
        )

    studies = study_each(
        loaded, "tilt", out,
        lambda stone, journal, progress: study_tilt(
            stone, **study, **options, journal=journal, progress=progress
        ),
        write_tilt_figure,
        write_film if film is not None else None,
    )  # fmt: skip
    print_records(
        form,
        tables=lambda: [tilt_table(studies)],
        values=lambda: [s.to_dict() for s in studies],
        records=lambda: [record for s in studies for record in tilt_records(s)],
    )


def _check_film(film: str, loaded: LoadedStones, poses: Any, measures: int) -> None:
    from gemrender.report.tilt_film import check_tilt_film

    if len(loaded) > 1:
        raise InputError("shows one stone; name only one", key="--film", value=film)
    check_tilt_film(Path(film), poses, measures)

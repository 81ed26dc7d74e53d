"""The command `symmetry`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from gemrender.cli.groups import command
from gemrender.cli.options import (
    TILT,
    EngineOptions,
    MaterialOptions,
    ModelOptions,
    Resolution,
    TableOptions,
    TiltAzimuth,
    ViewOptions,
    output_option,
    prepare_engine,
    trace_options,
)
from gemrender.cli.output import print_records, say
from gemrender.cli.stones import StoneOptions, load
from gemrender.cli.studies import study_each
from gemrender.cli.values import number_option, whole_option
from gemrender.engines import DEFAULT_MEMORY_LIMIT, DEFAULT_TIME_LIMIT

__all__ = ["symmetry"]

#: Standard deviation that facets are tilted by unless another is asked for [deg].
_DEFAULT_DEVIATION = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyEngineOptions(EngineOptions):
    """What traces the draws: hundreds of stones, so with fewer pixels, where an engine has pixels."""

    resolution: Resolution = 256


@command
def symmetry(
    given: StoneOptions,
    engine: StudyEngineOptions,
    of: MaterialOptions,
    model: ModelOptions,
    table: TableOptions,
    deviation: Annotated[
        float | None,
        number_option(
            "--deviation",
            "degrees",
            "Standard deviation of the angles that facets are tilted by, 0 to 5; "
            f"{_DEFAULT_DEVIATION:g} by default.",
            metavar="DEGREES",
        ),
    ] = None,
    jitter: Annotated[
        float,
        number_option(
            "--jitter",
            "girdle radii",
            "Jitter the 57 vertices instead: standard deviation of each coordinate, in girdle radii.",
            metavar="RADII",
        ),
    ] = 0.0,
    draws: Annotated[int, whole_option("--draws", "Number of draws.")] = 200,
    seed: Annotated[int, whole_option("--seed", "Seed of the draws.")] = 1,
    tilt: Annotated[float | None, TILT] = None,
    tilt_azimuth: TiltAzimuth = 0.0,
    out: Annotated[
        str | None,
        output_option(
            "Where to write the figure and each draw's scores; a study that was stopped goes on there."
        ),
    ] = None,
) -> None:
    """Study what poor symmetry does to the scores: facets tilted at random, many times."""
    from gemrender.report.symmetry import study_records, study_table, write_symmetry_figure
    from gemrender.sweep import check_study, study_symmetry

    form = table.chosen
    notes = []
    if tilt is not None and deviation is None:  # what --tilt meant here once
        notes.append(
            f"gemrender: --tilt {tilt:g} is taken as --deviation {tilt:g}, its new name in this command; "
            "with --deviation, --tilt is the eye's, as everywhere"
        )
        deviation, tilt = tilt, None
    options = trace_options(engine, model, ViewOptions(tilt=tilt or 0.0, tilt_azimuth=tilt_azimuth))
    loaded = load(given.stones, options, given.settings, of.material)
    study: dict[str, Any] = {
        "tilt_deg": _DEFAULT_DEVIATION if deviation is None else deviation,
        "jitter": jitter,
        "draws": draws,
        "seed": seed,
    }
    check_study(loaded.stones, **study)
    prepare_engine(options, loaded.samples, out)
    for words in notes:
        say(words)
    loaded.tell()
    _leave_out_defaults(options)
    studies = study_each(
        loaded, "symmetry", out,
        lambda stone, journal, progress: study_symmetry(
            stone, **study, **options, journal=journal, progress=progress
        ),
        write_symmetry_figure,
    )  # fmt: skip
    print_records(
        form,
        tables=lambda: [study_table(studies)],
        values=lambda: [s.to_dict() for s in studies],
        records=lambda: [record for s in studies for record in study_records(s)],
    )


def _leave_out_defaults(options: dict[str, Any]) -> None:
    """Leave out options that journals of earlier versions do not have, where they ask for nothing."""
    if not options["tilt"]:
        del options["tilt"], options["tilt_azimuth"]
    for key, default in (("time_limit", DEFAULT_TIME_LIMIT), ("memory_limit", DEFAULT_MEMORY_LIMIT)):
        if options[key] == default:
            del options[key]

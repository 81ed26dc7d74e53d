"""The command `score`."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gemrender.cli.groups import command
from gemrender.cli.options import (
    MODEL,
    VIEW,
    EngineOptions,
    MaterialOptions,
    MeasureOptions,
    ModelOptions,
    TableOptions,
    ViewOptions,
    measure_options,
    output_option,
    prepare_engine,
    trace_options,
    view_and_model,
)
from gemrender.cli.output import patience, print_csv, print_records, progress_bar, say
from gemrender.cli.stones import StoneOptions, load
from gemrender.cli.values import choice_option, number_option
from gemrender.errors import InputError
from gemrender.stereo import EYE_DISTANCE, EYE_SEPARATION

if TYPE_CHECKING:
    from gemrender.cli.stones import LoadedStones
    from gemrender.scoring import Score
    from gemrender.sweep.tolerance import ToleranceStudy

__all__ = ["score"]

#: From so many stones on, the time that they took is told.
_MANY = 100
#: Of up to so many stones of reports it is told what their rounding does, by so many draws.
_FEW, _ROUNDED = 3, 64


@command
def score(
    given: StoneOptions,
    engine: EngineOptions,
    of: MaterialOptions,
    model: ModelOptions,
    view: ViewOptions,
    measured: MeasureOptions,
    table: TableOptions,
    observer: Annotated[
        str,
        choice_option(
            "--observer",
            ("mono", "stereo"),
            "A viewer of one eye, or of two: each eye's score, and what of the view they see differently.",
            metavar="EYES",
            rich_help_panel=VIEW,
        ),
    ] = "mono",
    eye_separation: Annotated[
        float,
        number_option(
            "--eye-separation",
            "millimetres",
            "How far apart two eyes are, 0 to 200.",
            metavar="MM",
            rich_help_panel=VIEW,
        ),
    ] = EYE_SEPARATION,
    eye_distance: Annotated[
        float,
        number_option(
            "--eye-distance",
            "millimetres",
            "How far two eyes are from the stone, 50 to 10000.",
            metavar="MM",
            rich_help_panel=VIEW,
        ),
    ] = EYE_DISTANCE,
    birefringence: Annotated[
        bool,
        typer.Option(
            help="Whether birefringent stones split light, or have their ordinary index.",
            rich_help_panel=MODEL,
        ),
    ] = False,
    out: Annotated[
        str | None,
        output_option("Where to write each stone's maps, and those of the measures, as EXR and PNG."),
    ] = None,
) -> None:
    """Score stones: Average, Rear and the bands of the top view, and further measures."""
    from gemrender.report.tables import score_record, score_tables, score_values
    from gemrender.report.tolerance import rounding_text, rounding_values

    form = table.chosen
    options, measures = trace_options(engine, model, view), measure_options(measured)
    if birefringence:
        for key, is_given in (("--observer", observer == "stereo"), ("--out", out is not None)):
            if is_given:
                raise InputError(f"is not for scores with {key} yet", key="--birefringence", value=True)
        measures = {**measures, "birefringence": True}
    loaded = load(given.stones, options, given.settings, of.material)
    prepare_engine(options, loaded.samples, out)
    if birefringence:
        from gemrender.engines import engine_for, split_crystal

        with patience(
            "the kernels of birefringent stones are compiled for this machine, once: half a minute"
        ):
            for stone in loaded.samples:
                if engine_for(options["engine"], stone) == "exact":
                    split_crystal(stone, view_and_model(stone, options)[1])
    started = time.monotonic()
    if observer == "stereo":
        if out is not None:
            raise InputError("is not for two eyes: maps are what one sees", key="--out", value=out)
        eyes = {"eye_separation": eye_separation, "eye_distance": eye_distance}
        _print_stereo(loaded, {**options, **measures, **eyes}, form)
        return
    scored = _scores(loaded, options, measures, out)
    if form == "csv":  # line by line: what is done is not lost when the rest is interrupted
        print_csv(score_record(s, loaded.setting(i)) for i, s in enumerate(scored))
    else:
        scores = list(scored)
        rounded = _within_rounding(loaded, options)
        print_records(
            form,
            tables=lambda: score_tables(
                scores, loaded.settings, [*loaded.notes, *map(rounding_text, rounded.values())]
            ),
            values=lambda: [
                score_values(s, loaded.setting(i)) | (rounding_values(rounded[i]) if i in rounded else {})
                for i, s in enumerate(scores)
            ],
            records=list,
        )
    if form in ("csv", "json"):
        loaded.tell()
    if len(loaded) >= _MANY:
        say(f"{len(loaded)} stones in {time.monotonic() - started:.1f} s")
    if out is not None:
        say(f"maps written to {out}")


def _within_rounding(loaded: LoadedStones, options: dict[str, Any]) -> dict[int, ToleranceStudy]:
    """Return how the scores of a few stones of reports spread within these reports' rounding, by number."""
    from gemrender.engines import engine_for
    from gemrender.sweep.tolerance import study_tolerance
    from gemrender.sweep.unknown import Rounding

    if len(loaded) > _FEW:
        return {}
    return {
        i: study_tolerance(stone, Rounding.of(stone), draws=_ROUNDED, **{**options, "bound": 0.1})
        for i, stone in enumerate(loaded.stones)
        if stone.description == "report" and engine_for(options["engine"], stone) == "exact"
    }


def _print_stereo(loaded: LoadedStones, options: dict[str, Any], form: str) -> None:
    """Score the stones as two eyes see them, and print what they see."""
    from gemrender.report.tables import score_tables, stereo_record, stereo_table
    from gemrender.stereo import score_stereo

    found = []
    with progress_bar(len(loaded)) as step:
        for i, stone in enumerate(loaded.stones):
            found.append(score_stereo(stone, **{"progress": step(i, stone.name), **options}))
    print_records(
        form,
        tables=lambda: [
            *score_tables([each.middle for each in found], loaded.settings, loaded.notes),
            stereo_table(found),
        ],
        values=lambda: [
            each.to_dict() | ({"settings": s} if (s := loaded.setting(i)) else {})
            for i, each in enumerate(found)
        ],
        records=lambda: [stereo_record(each, loaded.setting(i)) for i, each in enumerate(found)],
    )
    if form in ("csv", "json"):
        loaded.tell()


def _scores(
    loaded: LoadedStones, options: dict[str, Any], measures: dict[str, Any], out: str | None
) -> Iterator[Score]:
    """Score the stones one after the other; with `out`, write their maps."""
    from gemrender.mapping import score_with_maps
    from gemrender.report.files import file_stems, prepare_folder, write_observation
    from gemrender.report.measure_maps import write_measure_maps
    from gemrender.scoring import score as score_stone

    folder = None if out is None else prepare_folder(out)
    stems = file_stems(loaded.names) if folder is not None else []
    with progress_bar(len(loaded)) as step:
        for i, stone in enumerate(loaded.stones):
            traced = {"progress": step(i, stone.name), **options}
            if folder is None:
                yield score_stone(stone, **measures, **traced)
                continue
            of_maps, observation, maps = score_with_maps(stone, **measures, **traced)
            yield of_maps
            write_observation(observation, folder, stems[i])
            if maps is not None:
                write_measure_maps(maps, folder, stems[i])
            del observation, maps  # before the next ones are made: at 4096 x 4096 the former takes 0.8 GB

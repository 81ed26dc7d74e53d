"""The command `compare`."""

from __future__ import annotations

from typing import Annotated

from gemrender.cli.groups import command
from gemrender.cli.options import (
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
)
from gemrender.cli.output import print_records, progress_bar, say
from gemrender.cli.stones import StoneOptions, load

__all__ = ["compare"]


@command
def compare(
    given: StoneOptions,
    engine: EngineOptions,
    of: MaterialOptions,
    model: ModelOptions,
    view: ViewOptions,
    measured: MeasureOptions,
    table: TableOptions,
    out: Annotated[
        str | None, output_option("Where to write the figures, and the table as CSV and JSON.")
    ] = None,
) -> None:
    """Compare stones: a table, the maps side by side, the bands; of two stones their difference too."""
    from gemrender.mapping import score_and_observation
    from gemrender.report.comparison import panel, write_comparison
    from gemrender.report.files import prepare_folder
    from gemrender.report.tables import score_record, score_tables, score_values
    from gemrender.scoring import score

    form = table.chosen
    options, measures = trace_options(engine, model, view), measure_options(measured)
    loaded = load(given.stones, options, given.settings, of.material)
    prepare_engine(options, loaded.samples, out)
    folder = None if out is None else prepare_folder(out)
    scores, panels, pair = [], [], []
    with progress_bar(len(loaded)) as step:
        for i, stone in enumerate(loaded.stones):
            traced = {"progress": step(i, stone.name), **options}
            if folder is None:
                scores.append(score(stone, **measures, **traced))
                continue
            found, observation = score_and_observation(stone, **measures, **traced)
            panels.append(panel(observation, found))
            scores.append(found)
            if len(loaded) == 2:
                pair.append(observation)
            del observation
    print_records(
        form,
        tables=lambda: score_tables(scores, loaded.settings, loaded.notes),
        values=lambda: [score_values(s, loaded.setting(i)) for i, s in enumerate(scores)],
        records=lambda: [score_record(s, loaded.setting(i)) for i, s in enumerate(scores)],
    )
    if form in ("csv", "json"):
        loaded.tell()
    if folder is not None:
        for path in write_comparison(panels, pair, folder):
            say(f"written: {path}")

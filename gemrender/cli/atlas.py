"""The command `atlas`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gemrender.cli.groups import command
from gemrender.cli.options import output_option
from gemrender.cli.output import progress_bar, say
from gemrender.cli.values import complete_files, whole_option
from gemrender.errors import InputError

if TYPE_CHECKING:
    from gemrender.sweep.atlas import AtlasMade
    from gemrender.sweep.atlas.plan import AtlasPlan

__all__ = ["MapOptions", "atlas", "show_atlas"]

#: The word that makes a file of an atlas.
_EXPORT = "export"
_WORK, MAP = "Work", "Atlas"


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkerOptions:
    """What measures the stones."""

    threads: Annotated[
        int | None,
        whole_option(
            "--threads",
            "So many threads of one process, in place of processes.",
            low=1,
            rich_help_panel=_WORK,
        ),
    ] = None
    processes: Annotated[
        int | None,
        whole_option(
            "--processes",
            "Processes of this machine; by default one a processor, where there is work for more than a few "
            "seconds.",
            low=1,
            rich_help_panel=_WORK,
        ),
    ] = None
    dask: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS",
            help="Dask scheduler whose workers do it, such as tcp://host:8786; or local, or local:N, for N "
            "processes on this machine.",
            rich_help_panel=_WORK,
        ),
    ] = None
    dry_run: Annotated[
        bool,
        typer.Option(
            "--dry-run",
            help="Measure a few dozen stones, print what all will cost, and write nothing.",
            rich_help_panel=_WORK,
        ),
    ] = False


@dataclass(frozen=True, slots=True, kw_only=True)
class MapOptions:
    """What is shown of an atlas."""

    x: Annotated[
        str | None,
        typer.Option("--x", metavar="PARAMETER", help="Of an atlas: to the right.", rich_help_panel=MAP),
    ] = None
    y: Annotated[
        str | None,
        typer.Option("--y", metavar="PARAMETER", help="Of an atlas: upwards.", rich_help_panel=MAP),
    ] = None
    mark: Annotated[
        list[str] | None,
        typer.Option(
            "--mark",
            metavar="STONE",
            help="Of an atlas: a stone whose place is marked; may be given several times.",
            rich_help_panel=MAP,
        ),
    ] = None


@command
def atlas(
    what: Annotated[
        list[str],
        typer.Argument(
            metavar="PLAN | export STORE",
            help="The plan, a TOML file (docs/atlas.md); or the word export and an atlas, to write it as one "
            "netCDF file.",
            autocompletion=complete_files(lambda: [_EXPORT], (".toml",)),
        ),
    ],
    by: WorkerOptions,
    out: Annotated[
        str | None,
        output_option(
            "The store: a folder, or an address that fsspec knows, such as s3://bucket/atlas.zarr; by "
            "default the plan's name, .zarr. Of export the file, .nc.",
            metavar="STORE",
        ),
    ] = None,
) -> None:
    """Score a grid or a Sobol design of parameters into a zarr store; stopped, it goes on where it was."""
    if what[0] == _EXPORT:
        _export(what[1:], out)
        return
    if len(what) > 1:
        raise InputError("is one plan too many; name one", key="PLAN", value=what[1])
    from gemrender.sweep.atlas.plan_file import read_plan
    from gemrender.sweep.atlas.store import check_room
    from gemrender.sweep.atlas.work import check_workers

    check_workers(by.threads, by.processes, by.dask)
    plan = read_plan(what[0])
    where = out or f"{Path(what[0]).stem}.zarr"
    if by.dry_run:
        check_room(plan, where)
        _print_cost(plan, by.threads, by.processes)
        return
    from gemrender.engines import require_engine
    from gemrender.sweep.atlas import make_atlas

    if by.dask is None:
        require_engine("exact", stones=[plan.stone], bound=plan.bound)
    with progress_bar(1) as steps:
        made = make_atlas(
            plan, where, threads=by.threads, processes=by.processes, dask=by.dask,
            progress=steps(0, plan.name),
        )  # fmt: skip
    _tell(made, where)


def show_atlas(
    names: list[str],
    options: MapOptions,
    measures: list[str] | None,
    at: list[str] | None,
    formats: tuple[str, ...],
    out: str,
) -> None:
    """Draw a map of an atlas for each measure."""
    from gemrender.cuts import load_stone
    from gemrender.report.atlas import write_atlas_figure
    from gemrender.report.files import prepare_folder
    from gemrender.sweep.atlas.map import atlas_map
    from gemrender.sweep.atlas.store import open_atlas

    if len(names) > 1:
        raise InputError("is one too many; of an atlas, name it alone", key="STONE", value=names[1])
    fixed = {}
    for text in at or []:
        for part in text.replace(";", " ").split():
            key, equals, value = part.partition("=")
            if not equals:
                raise InputError(
                    "of an atlas it must be PARAMETER=VALUE, such as table=57", key="--at", value=part
                )
            fixed[key.replace("-", "_")] = value
    marks = [load_stone(name) for name in options.mark or []]
    x, y = (None if name is None else name.replace("-", "_") for name in (options.x, options.y))
    with open_atlas(names[0]) as found:
        maps = [atlas_map(found, x, y, measure, fixed) for measure in (measures or (None,))]
    folder = prepare_folder(out)
    stem = Path(names[0].rstrip("/")).stem
    for shown in maps:
        name = f"{stem}-{shown.measure}-{shown.x}-{shown.y}"
        for path in write_atlas_figure(shown, folder, name, marks, formats):
            say(f"written: {path}")


def _export(names: list[str], out: str | None) -> None:
    from gemrender.sweep.atlas.export import export_atlas

    if len(names) != 1:
        raise InputError("must be one atlas: gemrender atlas export STORE -o FILE.nc", key="STORE")
    with progress_bar(1) as steps:
        file = out or f"{Path(names[0].rstrip('/')).stem}.nc"
        path, to_do = export_atlas(names[0], file, progress=steps(0, "export"))
    if to_do:
        say(f"gemrender: {names[0]}: {to_do} stones are still to do, and NaN in the file")
    say(f"written: {path}")


def _print_cost(plan: AtlasPlan, threads: int | None, processes: int | None) -> None:
    from gemrender.progress import duration_words
    from gemrender.sweep.atlas import atlas_cost

    cost = atlas_cost(plan, threads=threads, processes=processes)
    views = f" x {cost.views} views" if cost.views > 1 else ""
    typer.echo(f"stones    {cost.stones}{views}")
    typer.echo(f"chunks    {cost.chunks}, of at most {plan.chunk} stones")
    typer.echo(f"values    {len(plan.variables)} a stone and view, their bounds included")
    typer.echo(f"size      at most {_bytes(cost.bytes)}, before compression")
    typer.echo(
        f"time      about {duration_words(cost.seconds)}: {cost.rate:.3g} stones a second by "
        f"{cost.workers}, measured on {cost.tried} of them"
    )
    if cost.made < cost.tried:
        typer.echo(f"no stone  {cost.tried - cost.made} of these {cost.tried}")


def _bytes(number: float) -> str:
    for unit in ("bytes", "kB", "MB", "GB"):
        if number < 1000:
            return f"{number:.3g} {unit}"
        number /= 1000
    return f"{number:.3g} TB"


def _tell(made: AtlasMade, where: str) -> None:
    """Say what has become of the atlas, and which stones have no values."""
    from gemrender.sweep.atlas.store import FAILED, NO_STONE

    for number, words in (
        (made.no_stone, f"make no stone (status {NO_STONE} in the atlas)"),
        (made.failed, f"failed (status {FAILED} in the atlas)"),
    ):
        if number:
            say(f"gemrender: {number} of {made.stones} {words}")
    for setting, why in made.refused:
        say(f"gemrender: {setting}: {why}")
    rate = f", {made.measured / made.seconds:.3g} a second" if made.measured else ""
    say(f"written: {where} ({made.done} stones, {made.measured} of them now{rate})")

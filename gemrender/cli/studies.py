"""What commands that study stones have in common: one after the other, each with a journal and a figure."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from gemrender.cli.output import progress_bar, say
from gemrender.cli.stones import LoadedStones

if TYPE_CHECKING:
    from gemrender.stone import Stone

__all__ = ["study_each"]

_Study = TypeVar("_Study")
#: Takes a stone, the file of its journal, and what to tell of the progress; returns the study.
_StudyOne = Callable[["Stone", Path | None, Callable[[float], None]], _Study]


def study_each(
    loaded: LoadedStones,
    kind: str,
    out: str | None,
    study: _StudyOne[_Study],
    write_figure: Callable[[_Study, Path], Path],
    film: Callable[[_Study, Callable[[float], None]], Path] | None = None,
) -> list[_Study]:
    """Study each of the stones, under one progress bar; with a folder, write journals and figures there.

    Parameters
    ----------
    loaded : LoadedStones
        The stones.
    kind : str
        What files' names end on, such as `tilt`.
    out : str, optional
        The folder.
    study, write_figure
        What studies a stone, and what writes the figure of a study to a file.
    film : callable, optional
        What writes a film of the first study.
    """
    from gemrender.report.files import file_stems, prepare_folder

    folder = None if out is None else prepare_folder(out)
    studies = []
    with progress_bar(len(loaded) + (film is not None)) as step:
        for number, (stone, stem) in enumerate(zip(loaded.stones, file_stems(loaded.names), strict=True)):
            journal = None if folder is None else folder / f"{stem}-{kind}.jsonl"
            studies.append(study(stone, journal, step(number, stone.name)))
            if folder is not None:
                say(f"written: {write_figure(studies[-1], folder / f'{stem}-{kind}.png')}")
        if film is not None:
            say(f"written: {film(studies[0], step(len(loaded), 'film'))}")
    return studies

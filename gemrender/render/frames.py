"""Films: frames that are kept as they are done, and a film of them in the end."""

from __future__ import annotations

import contextlib
import hashlib
import shutil
from collections.abc import Callable, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

import gemrender
from gemrender.errors import InputError
from gemrender.journal import Journal, OtherWorkError
from gemrender.reading import open_file, reason
from gemrender.render.film_files import check_film, encode_film
from gemrender.render.finish import denoised, developed, exposure_of
from gemrender.render.photoreal import render
from gemrender.render.picture_files import write_png
from gemrender.scene.moves import Move
from gemrender.scene.photoreal import Gem, title_of
from gemrender.scene.setup import Setup
from gemrender.writing import TEMPORARY_PREFIX, write_whole

__all__ = ["check_film", "render_film"]

_JOURNAL = "journal.jsonl"


def render_film(
    path: Path,
    gems: Sequence[Gem],
    setup: Setup,
    *,
    frames: int,
    fps: float,
    move: Move,
    ev: float,
    curve: str,
    denoise: bool,
    progress: Callable[[int], Callable[[float], None]],
    **options: Any,
) -> Path:
    """Render stones that move as a film, a loop without a seam.

    All frames have one seed, and random numbers belong to the place in the picture: what stands still in it
    is the same in all of them, noise included, and the noise of a stone does not run over it from frame to
    frame.

    Frames are kept in a folder beside the film, named after it, until the film is written. Where that folder
    holds frames of the same film, only the missing ones are rendered, and those that are no longer what its
    journal says was written.

    Parameters
    ----------
    path : Path
        The film, ending as in `FILM_SUFFIXES`.
    gems, setup : sequence of Gem, Setup
        What it shows.
    frames, fps : int, float
        Number of frames of the whole loop, and how many a second shows.
    move : Move
        How the stones move.
    ev, curve, denoise : float, str, bool
        As for still pictures. The exposure of the first frame is that of all.
    progress : callable
        Given a frame's number, returns what is called with the share of it that is done.
    options
        As for `render`.

    Raises
    ------
    InputError
        The folder holds frames of something else, or is in use, or a file cannot be written.
    KeyboardInterrupt
        Interrupted; the frames that are done are kept.
    """
    check_film(path, options["width"], options["height"], frames, fps)
    folder = path.with_name(f"{path.name}.frames")
    head = {"film": _fingerprint(gems, setup, frames, move, ev, curve, denoise, options)}
    files = [folder / f"{k:05d}.png" for k in range(frames)]
    about = {"title": title_of(gems)}
    moved = "one turn" if move.type == "turntable" else f"{move.type} by {move.to_deg:g} degrees"
    about["description"] = f"set-up {setup.name}, {moved} in {frames} frames"
    with _journal(folder, head, frames) as journal:
        exposure = _exposure(journal)
        for k, file in enumerate(files):
            if journal.known.get(k) == (exposure, _digest(file)):
                continue
            picture = render(gems, setup, move=move, share=k / frames, progress=progress(k), **options)
            if picture.stopped == "interrupted":  # a frame that is not done is none
                raise KeyboardInterrupt
            if denoise:
                picture = denoised(picture, clamp=True)
            if exposure is None:
                exposure = exposure_of(picture, setup, ev=ev, curve=curve)
            write_png(file, developed(picture, setup, exposure=exposure, curve=curve))
            journal.add(k, exposure, _digest(file))
        # Encoded in there first, where what a killed process leaves is found and removed.
        (film,) = write_whole(folder, {path.name: lambda made: encode_film(made, files, fps, **about)})
        write_whole(path.parent, {path.name: lambda made: shutil.move(film, made)})
        for file in files:
            file.unlink()
        journal.remove()
    with contextlib.suppress(OSError):  # somebody keeps something of his own there
        folder.rmdir()
    return path


def _fingerprint(*of: Any) -> str:
    """Return a digest of all that a frame depends on, what is in the set-up's files too."""
    gems, setup, *others = of
    files = [thing.mesh for thing in setup.things] + [setup.sky.image] * (setup.sky.type == "image")
    held = [_digest(Path(file)) for file in files]
    digest = hashlib.sha256(repr((gemrender.__version__, setup, held, others)).encode())
    for gem in gems:
        solid = gem.stone.solid
        for part in (solid.planes, solid.facet, *([] if gem.stone.is_convex else [solid.vertices])):
            digest.update(np.ascontiguousarray(part).tobytes())
        digest.update(repr((gem.material, gem.diameter_mm, solid.is_round)).encode())
    return digest.hexdigest()


def _journal(folder: Path, head: dict[str, Any], frames: int) -> Journal:
    """Make the folder of frames, or take up the one that is there; return its journal."""

    def entry(line: Any) -> tuple[int, tuple[float, str]]:
        k, exposure, digest = line
        if type(k) is not int or not 0 <= k < frames:
            raise ValueError("is no number of a frame")
        if type(exposure) not in (int, float) or not isfinite(exposure) or exposure <= 0:
            raise ValueError("is no exposure")
        if not isinstance(digest, str):
            raise TypeError("is no digest")
        return k, (float(exposure), digest)

    try:
        folder.mkdir(parents=True, exist_ok=True)
        names = {file.name for file in folder.iterdir() if not file.name.startswith(TEMPORARY_PREFIX)}
        if names and _JOURNAL not in names:
            raise _foreign(folder)
    except OSError as error:
        raise InputError(f"cannot be used for frames: {reason(error)}", source=str(folder)) from error
    try:
        journal = Journal(folder / _JOURNAL, head, entry, work="film")
    except OtherWorkError as error:
        raise _foreign(folder) from error
    for left in folder.glob(f"{TEMPORARY_PREFIX}*"):  # by a process that was killed: no other one is at it
        shutil.rmtree(left, ignore_errors=True)
    return journal


def _foreign(folder: Path) -> InputError:
    return InputError(
        "holds frames of another film; remove it, or give the film another name", source=str(folder)
    )


def _exposure(journal: Journal) -> float | None:
    """Return the exposure of the frames that are done: that of the first of them."""
    return journal.known[min(journal.known)][0] if journal.known else None


def _digest(file: Path) -> str | None:
    """Return a digest of what is in a file; None where it cannot be read."""
    try:
        with open_file(file) as opened:
            return hashlib.file_digest(opened, "sha256").hexdigest()
    except (OSError, InputError):
        return None

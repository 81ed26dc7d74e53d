"""Turntables: frames that are kept as they are done, and a film of them in the end."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.render.film_files import check_film, encode_film
from gemrender.render.finish import denoised, developed, exposure_of
from gemrender.render.photoreal import render
from gemrender.render.picture_files import write_png
from gemrender.scene.photoreal import Gem
from gemrender.scene.setup import Setup
from gemrender.writing import write_whole

__all__ = ["check_film", "render_film"]

_SETTINGS = "settings.json"


def render_film(
    path: Path,
    gems: Sequence[Gem],
    setup: Setup,
    *,
    frames: int,
    fps: float,
    ev: float,
    curve: str,
    denoise: bool,
    progress: Callable[[int], Callable[[float], None]],
    **options: Any,
) -> Path:
    """Render one turn of the stones about the vertical as a film.

    Frames are kept in a folder beside the film, named after it, until the film is written. Where that folder
    holds frames of the same film, only the missing ones are rendered.

    Parameters
    ----------
    path : Path
        The film, ending as in `FILM_SUFFIXES`.
    gems, setup : sequence of Gem, Setup
        What it shows.
    frames, fps : int, float
        Number of frames of the whole turn, and how many a second shows.
    ev, curve, denoise : float, str, bool
        As for still pictures. The exposure of the first frame is that of all.
    progress : callable
        Given a frame's number, returns what is called with the share of it that is done.
    options
        As for `render`.

    Raises
    ------
    InputError
        The folder holds frames of something else, or a file that cannot be written.
    KeyboardInterrupt
        Interrupted; the frames that are done are kept.
    """
    check_film(path, options["width"], options["height"], frames, fps)
    folder = path.with_name(f"{path.name}.frames")
    settings = _prepare(folder, _fingerprint(gems, setup, frames, ev, curve, denoise, options))
    files = [folder / f"{k:05d}.png" for k in range(frames)]
    for k, file in enumerate(files):
        if file.is_file():
            continue
        picture = render(
            gems, setup, turn_deg=360.0 * k / frames, turntable=True, progress=progress(k), **options
        )
        if picture.stopped == "interrupted":  # a frame that is not done is none
            raise KeyboardInterrupt
        if denoise:
            picture = denoised(picture)
        if "exposure" not in settings:
            settings["exposure"] = exposure_of(picture, setup, ev=ev)
            _write_settings(folder, settings)
        write_png(file, developed(picture, setup, exposure=settings["exposure"], curve=curve))
    about = {"title": ", ".join(f"{gem.stone.name} ({gem.material.name})" for gem in gems)}
    about["description"] = f"set-up {setup.name}, one turn in {frames} frames"
    write_whole(path.parent, {path.name: lambda made: encode_film(made, files, fps, **about)})
    for file in (*files, folder / _SETTINGS):
        file.unlink()
    folder.rmdir()
    return path


def _fingerprint(*of: Any) -> str:
    """Return a digest of all that a frame depends on."""
    gems, setup, *others = of
    digest = hashlib.sha256(repr((setup, others)).encode())
    for gem in gems:
        digest.update(np.ascontiguousarray(gem.stone.vertices).tobytes())
        digest.update(repr((gem.material, gem.diameter_mm, gem.stone.tilted_planes)).encode())
    return digest.hexdigest()


def _prepare(folder: Path, fingerprint: str) -> dict[str, Any]:
    """Make the folder of frames, or take up the one that is there; return its settings."""
    file = folder / _SETTINGS
    try:
        if file.is_file():
            settings = json.loads(file.read_text(encoding="utf-8"))
            if isinstance(settings, dict) and settings.get("fingerprint") == fingerprint:
                return settings
        elif not folder.exists():
            folder.mkdir(parents=True)
            _write_settings(folder, {"fingerprint": fingerprint})
            return {"fingerprint": fingerprint}
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be used for frames: {reason}", source=str(folder)) from error
    raise InputError(
        "holds frames of another film; remove it, or give the film another name", source=str(folder)
    )


def _write_settings(folder: Path, settings: dict[str, Any]) -> None:
    write_whole(folder, {_SETTINGS: lambda made: made.write_text(json.dumps(settings), encoding="utf-8")})

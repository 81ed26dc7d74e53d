"""What kinds of picture files there are, told by their endings: stills and films."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path
from typing import Literal

from gemrender.errors import InputError

__all__ = ["FILM_SUFFIXES", "STILL_SUFFIXES", "WEBP_MOST_PIXELS", "Background", "OutputKind", "output_kind"]


class Background(StrEnum):
    """What is seen beside the stones."""

    SETUP = "setup"
    TRANSPARENT = "transparent"


OutputKind = Literal["still", "film"]

#: How the names of still pictures end. A `.gif` of 256 colours is no way to keep a picture.
STILL_SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".exr")
#: How the names of films end; `.webp` is both, and a number of frames makes it a film.
FILM_SUFFIXES = (".mp4", ".gif", ".webp")
#: Longest side of a WebP picture [pixels]; that of all others is beyond what is rendered.
WEBP_MOST_PIXELS = 16383
#: Kinds of files without an alpha channel.
_OPAQUE_SUFFIXES = (".jpg", ".jpeg", ".mp4")


def output_kind(
    path: str | os.PathLike[str],
    *,
    frames: int | None = None,
    transparent: bool = False,
    size: tuple[int, int] = (1, 1),
) -> OutputKind:
    """Return whether a file is to be a still picture or a film, by its ending and the number of frames.

    Parameters
    ----------
    path : path
        The file, which need not be there.
    frames : int, optional
        Number of frames; None for a still picture.
    transparent : bool
        Whether the background is to be transparent.
    size : (int, int)
        Width and height [pixels].

    Raises
    ------
    InputError
        An ending that nothing is written by, a film without a number of frames, a number of frames without
        a film, a transparent background in a file that has no place for it, or a larger picture than it has.
    """
    suffix = Path(path).suffix.lower()
    shown = os.fspath(path)
    if suffix not in (*STILL_SUFFIXES, *FILM_SUFFIXES):
        kinds = ", ".join(dict.fromkeys((*STILL_SUFFIXES, *FILM_SUFFIXES)))
        raise InputError(f"must end in {kinds}", key="out", value=shown)
    if frames is None and suffix not in STILL_SUFFIXES:
        also = "; still pictures end in .png or .webp" if suffix == ".gif" else ""
        raise InputError(f"missing: a film needs a number of frames{also}", key="frames")
    if frames is not None and suffix not in FILM_SUFFIXES:
        raise InputError(
            f"go with a film, a file that ends in {', '.join(FILM_SUFFIXES)}", key="frames", value=frames
        )
    if transparent and suffix in _OPAQUE_SUFFIXES:
        raise InputError(
            f"has no place in a {suffix} file; take .png, .webp, .exr or .gif",
            key="background",
            value="transparent",
        )
    if suffix == ".webp" and max(size) > WEBP_MOST_PIXELS:
        shown = f"{size[0]}x{size[1]}"
        raise InputError(f"must be up to {WEBP_MOST_PIXELS} for a .webp file", key="size", value=shown)
    return "still" if frames is None else "film"

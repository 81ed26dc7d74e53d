"""Files written whole or not at all."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

from gemrender.errors import InputError

__all__ = ["write_whole"]


def write_whole(folder: Path, writers: Mapping[str, Callable[[Path], object]]) -> list[Path]:
    """Write files by their writers, all of them or none; return their paths.

    Parameters
    ----------
    folder : Path
        A folder that is there.
    writers : mapping of str to callable
        For each file's name, what writes it to the path it is given.

    Raises
    ------
    InputError
        They cannot be written; what was there is as it was.
    """
    written, name = [], ""
    try:
        # Beside their place first, then moved there.
        with tempfile.TemporaryDirectory(dir=folder, prefix=".gemrender-") as made:
            for name, write in writers.items():
                write(Path(made, name))
            for name in writers:
                written.append(Path(made, name).replace(folder / name))
    # A full disk is a RuntimeError of OpenEXR's and Mitsuba's; a null character in a path a ValueError.
    except (OSError, RuntimeError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be written: {reason}", source=str(folder / name)) from error
    return written

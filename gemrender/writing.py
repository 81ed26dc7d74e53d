"""Files written whole or not at all."""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from gemrender.errors import InputError

__all__ = ["TEMPORARY_PREFIX", "check_place", "write_whole"]

#: What the names of temporary folders begin with; only a process that is killed leaves one.
TEMPORARY_PREFIX = ".gemrender-"


def write_whole(folder: Path, writers: Mapping[str, Callable[[Path], object]]) -> list[Path]:
    """Write files by their writers, all of them or none; return their paths.

    All are written to temporary folders beside their places, then moved there; where one cannot be moved, or
    at an interruption, those that were are put back as they were. As for `open`, symbolic links are followed:
    they stay, and the file that they name is written, be it there or not. New files have the permissions
    that `open` gives, others keep theirs, and a file that is write-protected is refused.

    Parameters
    ----------
    folder : Path
        A folder that is there.
    writers : mapping of str to callable
        For each file's name, what writes it to the path it is given, of the same name.

    Raises
    ------
    InputError
        They cannot be written; what was there is as it was.
    """
    where = folder
    try:
        with contextlib.ExitStack() as stack:
            made: dict[Path, Path] = {}  # temporary folder by the folder that it is in
            moves = []
            for number, name in enumerate(writers):
                where = folder / name
                target = _target(where)
                if target.parent not in made:
                    where = folder if target.parent == folder.resolve() else target.parent
                    path = tempfile.TemporaryDirectory(dir=target.parent, prefix=TEMPORARY_PREFIX)
                    made[target.parent] = Path(stack.enter_context(path))
                moves.append(_Move(made[target.parent], name, target, number))
            for (name, write), move in zip(writers.items(), moves, strict=True):
                where = folder / name
                write(move.made)
                move.prepare()
            try:
                for name, move in zip(writers, moves, strict=True):
                    where = folder / name
                    move.do(keep=len(moves) > 1)  # one alone is moved or not
            except BaseException:
                for move in reversed(moves):
                    move.undo()
                raise
    # A full disk is a RuntimeError of OpenEXR's and Mitsuba's; a null character in a path a ValueError.
    except (OSError, RuntimeError, ValueError) as error:
        if isinstance(error, InputError) and error.source is not None:
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be written: {reason}", source=str(where)) from error
    return [folder / name for name in writers]


def check_place(path: Path) -> None:
    """See that a file can be written there, before any work is done for it; nothing is left.

    Parameters
    ----------
    path : Path
        The file, there or not, in a folder that is there.

    Raises
    ------
    InputError
        As `write_whole` would at the end: no such folder, one that cannot be written, or what no file can
        replace.
    """
    try:
        with tempfile.TemporaryFile(dir=_target(path).parent, prefix=TEMPORARY_PREFIX):
            pass
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be written: {reason}", source=str(path)) from error


@dataclass(slots=True)
class _Move:
    """A file that has been written, and where it is to go."""

    folder: Path
    name: str
    target: Path
    number: int
    is_new: bool = True
    is_begun: bool = False

    @property
    def made(self) -> Path:
        """Where it has been written."""
        return self.folder / self.name

    @property
    def _kept(self) -> Path:
        """Where the file that was there is kept until all are moved."""
        return self.folder / f"{TEMPORARY_PREFIX}{self.number}"

    def prepare(self) -> None:
        """Give the new file the old one's permissions."""
        with contextlib.suppress(FileNotFoundError):
            mode = stat.S_IMODE(self.target.stat().st_mode)
            if mode != stat.S_IMODE(self.made.stat().st_mode):
                self.made.chmod(mode)

    def do(self, *, keep: bool) -> None:
        self.is_new = not self.target.exists()
        if keep and not self.is_new:
            try:
                self._kept.hardlink_to(self.target)
            except (OSError, NotImplementedError):  # a file system without links
                self.is_begun = True
                self.target.replace(self._kept)
        self.is_begun = True
        self.made.replace(self.target)

    def undo(self) -> None:
        if not self.is_begun:
            return
        with contextlib.suppress(OSError):
            if self._kept.exists():
                self._kept.replace(self.target)
            elif self.is_new and not self.made.exists():
                self.target.unlink()


def _target(path: Path) -> Path:
    """Return the file that a path leads to, which need not be there; refuse what no file can replace."""
    target = Path(os.path.realpath(path))
    try:
        mode = target.lstat().st_mode
    except FileNotFoundError:
        return target
    if stat.S_ISLNK(mode):
        raise OSError("a link that leads to itself")
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(21, "Is a directory")
    if not stat.S_ISREG(mode):
        raise OSError("is no file, but a pipe, a socket or a device")
    if not os.access(target, os.W_OK):
        raise PermissionError(13, "Permission denied")
    return target

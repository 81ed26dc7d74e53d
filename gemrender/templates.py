"""Files to start from: the text of what comes with gemrender, as `--show` prints it."""

from __future__ import annotations

from gemrender.errors import InputError
from gemrender.optics.material_text import material_template
from gemrender.reading import bundled_files, did_you_mean

__all__ = ["material_template", "setup_template", "stone_template"]


def stone_template(name: str) -> str:
    """Return the text of a bundled stone's file.

    Parameters
    ----------
    name : str
        One of `gemrender.stone.bundled_stones`.

    Raises
    ------
    InputError
        No such stone.
    """
    files = bundled_files("")
    if name not in files:
        guess = did_you_mean(name, files)
        raise InputError(f"must be a bundled stone (see: gemrender stones){guess}", key="name", value=name)
    return files[name].read_text(encoding="utf-8")


def setup_template(name: str) -> str:
    """Return the text of a bundled set-up's file.

    Parameters
    ----------
    name : str
        One of `gemrender.scene.setup.bundled_setups`.

    Raises
    ------
    InputError
        No such set-up.
    """
    files = bundled_files("setups")
    if name not in files:
        raise InputError(
            f"must be one of {', '.join(files)}{did_you_mean(name, files)}", key="name", value=name
        )
    return files[name].read_text(encoding="utf-8")

"""Materials by name, by index, or from TOML files.

Whatever is wrong with a file is told in one line: the file, the key, the value, and what is allowed.
"""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import Any

from gemrender.errors import GemrenderWarning, InputError
from gemrender.mistakes import Mistakes
from gemrender.optics.dispersion import Dispersion, Formula
from gemrender.optics.material import Material, checked_density, checked_range
from gemrender.optics.materials import find_material, material_names, normal_name
from gemrender.optics.tabulated import Table
from gemrender.reading import (
    located_at,
    parse_toml,
    read_lines,
    refuse_missing,
    refuse_unknown,
    section,
    stem,
    text_line,
)

__all__ = ["load_material"]

#: Longest line of a material file [characters], enough for 400 rows in one. It also keeps numbers printable:
#: Python refuses to print integers of more than 4300 digits, and TOML's hexadecimal ones may have any number.
LONGEST_LINE = 3500
#: Longest name, and longest source and note [characters].
LONGEST_NAME, LONGEST_TEXT = 100, 1000

#: What was already said of files in this process: a command loads a file more than once.
_SAID: set[str] = set()

_TOP = ("name", "density", "source", "note", "index", "absorption")
_FORMULA = ("formula", "coefficients", "range_nm")
_TABLE = ("wavelength_nm", "n")
_ABSORPTION = ("wavelength_nm", "per_mm")
_FORMS = f"{', '.join(_FORMULA)}; or {' and '.join(_TABLE)}"


def load_material(material: str | os.PathLike[str] | float | None, *, warn: bool = True) -> Material:
    """Load a material by its name, from a file, or make one of an index.

    A file is TOML::

        name = "My glass"                # optional; else the file's name
        density = 3.2                    # [g/cm^3], optional
        source = "catalogue"             # optional, as is note
        [index]
        formula = "sellmeier"            # one of `dispersion.FORMULAE`, wavelengths in micrometres
        coefficients = [[1.0, 0.1], [0.2, 0.2]]     # B and C [um]; C in um^2 is "sellmeier-2"
        range_nm = [360, 1000]
        # or: wavelength_nm = [...], n = [...]      linear between the rows
        [absorption]                     # optional; coefficient to the base e
        wavelength_nm = [380, 500, 760]
        per_mm = [0.3, 0.1, 0.0]

    Parameters
    ----------
    material : str, path-like, float or None
        One of `material_names` (case, hyphens and underscores do not count), a TOML file, the index of a
        material without dispersion, or None for diamond. A name wins over a file that is called like it.
    warn : bool
        Whether to warn of what `Material.cautions` says of a file.

    Raises
    ------
    InputError
        No such material, a file that cannot be read, or one that makes no material.

    Warns
    -----
    GemrenderWarning
        Of each of the `Material.cautions` of a file, as where its index is continued; once in a process.
    """
    if material is None:
        return find_material("diamond")
    if not isinstance(material, (str, os.PathLike)):
        return Material.constant(material)
    name = os.fspath(material)
    if normal_name(name) in material_names() or not _is_path(name):
        return find_material(name, hint="; or a TOML file of a material")
    made = _from_toml(Path(name))
    if warn:
        _warn(name, made)
    return made


def _warn(name: str, material: Material) -> None:
    for line in (f"{name}: {words}" for words in material.cautions):
        if line not in _SAID:
            _SAID.add(line)
            warnings.warn_explicit(line, GemrenderWarning, name, 0)


def _is_path(name: str) -> bool:
    if name.lower().endswith(".toml") or any(sep in name for sep in (os.sep, os.altsep) if sep):
        return True
    try:
        return Path(name).is_file()
    except (OSError, ValueError):  # too long, or with a null character
        return False


# ---- Files ---------------------------------------------------------------------------------------------


def _from_toml(path: Path) -> Material:
    with located_at(str(path)):
        lines = read_lines(path, kind="material", longest_line=LONGEST_LINE)
        return _made(parse_toml(lines, kind="material"), path)


def _made(top: dict[str, Any], path: Path) -> Material:
    with Mistakes() as mistakes:
        mistakes.of(refuse_unknown, top, _TOP)
        name = mistakes.of(text_line, top, "name", stem(path, "material"), LONGEST_NAME, empty=True)
        if name == "":
            allowed = f"must be one line of 1 to {LONGEST_NAME} characters"
            mistakes.add(InputError(allowed, key="name", value=name))
        texts = {
            "source": mistakes.of(text_line, top, "source", str(path), LONGEST_TEXT, empty=True),
            "note": mistakes.of(text_line, top, "note", "", LONGEST_TEXT, empty=True),
        }
        mistakes.of(checked_density, top.get("density"))
        absorption = mistakes.of(_absorption, top, mistakes)
        index = mistakes.of(_index, top, mistakes)
    assert name is not None
    assert index is not None
    dispersion, range_nm = index
    return Material(
        name=name,
        dispersion=dispersion,
        range_nm=range_nm,
        density=top.get("density"),
        absorption=absorption,
        **{key: str(text) for key, text in texts.items()},
    )


def _index(top: dict[str, Any], mistakes: Mistakes) -> tuple[Dispersion, tuple[float, float]] | None:
    """Return the dispersion and its range; None where there are mistakes, which are kept."""
    if "index" not in top:
        raise InputError(f"missing; needs {_FORMS}", key="[index]")
    before = len(mistakes.errors)
    index = section(top, "index", (*_FORMULA, *_TABLE), mistakes=mistakes)
    if len(mistakes.errors) > before:
        return None
    return _dispersion(index)


def _dispersion(index: dict[str, Any]) -> tuple[Dispersion, tuple[float, float]]:
    by_formula, by_table = (any(key in index for key in keys) for keys in (_FORMULA, _TABLE))
    if by_formula == by_table:
        has = "has keys of both" if by_formula else "has none of them"
        raise InputError(f"needs exactly one of: {_FORMS}; {has}", key="[index]")
    refuse_missing(index, _FORMULA if by_formula else _TABLE, "index")
    with located_at(None, "index"), Mistakes() as mistakes:
        if by_formula:
            made: Dispersion | None = mistakes.of(
                Formula, formula=index["formula"], coefficients=index["coefficients"]
            )
            ends = index["range_nm"]
        else:
            made = Table(wavelength_nm=index["wavelength_nm"], values=index["n"], key="n")
            ends = (made.wavelength_nm[0], made.wavelength_nm[-1])
        range_nm = mistakes.of(checked_range, ends)
    assert made is not None
    assert range_nm is not None
    return made, range_nm


def _absorption(top: dict[str, Any], mistakes: Mistakes) -> Table | None:
    if "absorption" not in top:
        return None
    before = len(mistakes.errors)
    absorption = section(top, "absorption", _ABSORPTION, mistakes=mistakes)
    if len(mistakes.errors) > before and len(absorption) < len(_ABSORPTION):
        return None
    refuse_missing(absorption, _ABSORPTION, "absorption")
    with located_at(None, "absorption"):
        return Table(wavelength_nm=absorption["wavelength_nm"], values=absorption["per_mm"], key="per_mm")

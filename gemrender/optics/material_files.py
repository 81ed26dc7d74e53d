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
from gemrender.optics.crystals.crystal import Crystal
from gemrender.optics.dispersion import SODIUM_NM, Dispersion, Formula
from gemrender.optics.index_checks import check_index
from gemrender.optics.material import Material, checked_density, checked_range
from gemrender.optics.materials import find_material, material_names, named_index, normal_name
from gemrender.optics.principal import ENDS
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

__all__ = ["load_material", "refractive_index"]

#: Longest line of a material file [characters], enough for 400 rows in one. It also keeps numbers printable:
#: Python refuses to print integers of more than 4300 digits, and TOML's hexadecimal ones may have any number.
LONGEST_LINE = 3500
#: Longest name, and longest source and note [characters].
LONGEST_NAME, LONGEST_TEXT = 100, 1000

#: What was already said of files in this process: a command loads a file more than once.
_SAID: set[str] = set()

#: What sections of index and absorption end in: an isotropic or ordinary one in nothing.
_ENDS = (*ENDS[2], *ENDS[3])
_TOP = (
    "name", "density", "source", "note",
    *(f"index{end}" for end in _ENDS), *(f"absorption{end}" for end in _ENDS),
)  # fmt: skip
_FORMULA = ("formula", "coefficients", "range_nm")
_TABLE = ("wavelength_nm", "n")
_ABSORPTION = ("wavelength_nm", "per_mm")
_FORMS = f"{', '.join(_FORMULA)}; or {' and '.join(_TABLE)}"
#: Which sections go together: of a birefringent material two or three.
_TOGETHER = "[{0}] and [{0}_e]; or [{0}_alpha], [{0}_beta] and [{0}_gamma]"


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

    A uniaxial crystal has [index] for its ordinary ray and [index_e] for its extraordinary one, a biaxial one
    has [index_alpha], [index_beta] and [index_gamma] in place of [index]. Where absorption depends on the
    direction, it has [absorption] and [absorption_e], or [absorption_alpha], [absorption_beta] and
    [absorption_gamma]; else [absorption] alone.

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


def refractive_index(material: str | os.PathLike[str] | float | None) -> float:
    """Return the refractive index of a material at 589.3 nm, which scores are computed at.

    Of a birefringent one it is that of the ordinary ray, or the middle one. Diamond, of whatever colour, has
    the paper's 2.4173 (Peter's formula gives 2.41726).

    Parameters
    ----------
    material : str, path-like, float or None
        As of `load_material`.

    Raises
    ------
    InputError
        As for `load_material`, or an index outside `INDEX_RANGE`.
    """
    if isinstance(material, (str, os.PathLike)):
        name = os.fspath(material)
        if normal_name(name) not in material_names() and _is_path(name):
            return float(load_material(name, warn=False).index(SODIUM_NM))
        material = name
    return named_index(material)


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
        absorption = mistakes.of(_absorptions, top, mistakes)
        index = mistakes.of(_indices, top, mistakes)
    assert name is not None
    assert index is not None
    dispersions, range_nm = index
    facts: dict[str, Any] = {key: str(text) for key, text in texts.items()}
    facts |= {"name": name, "range_nm": range_nm, "density": top.get("density")}
    tables = tuple(absorption or ())
    alike = len(tables) == 1
    if len(dispersions) == 1:
        return Material(dispersion=dispersions[0], absorption=tables[0] if tables else None, **facts)
    crystal = Crystal(dispersions=dispersions, absorptions=() if alike else tables)
    return Material.of_crystal(crystal, absorption=tables[0] if alike else None, **facts)


def _sections(top: dict[str, Any], kind: str) -> tuple[str, ...]:
    """Return the sections of index or absorption that a file has, if they go together: one, two or three."""
    given = [f"{kind}{end}" for end in _ENDS if f"{kind}{end}" in top]
    uniaxial, biaxial = (tuple(f"{kind}{end}" for end in ENDS[k]) for k in (2, 3))
    if given in ([], [kind]) or tuple(given) in (uniaxial, biaxial):
        return tuple(given)
    wanted = biaxial if any(key in given for key in biaxial) else uniaxial
    wrong = [key for key in given if key not in wanted]
    missing = [key for key in wanted if key not in given]
    told = f"does not go with [{wrong[0]}]" if wrong else f"needs [{'] and ['.join(missing)}], too"
    first = next(key for key in given if key in wanted and key != kind)
    raise InputError(f"{told}; a crystal has {_TOGETHER.format(kind)}", key=f"[{first}]")


def _indices(
    top: dict[str, Any], mistakes: Mistakes
) -> tuple[tuple[Dispersion, ...], tuple[float, float]] | None:
    """Return the principal indices and the range of all; None where there are mistakes, which are kept."""
    keys = _sections(top, "index")
    if not keys:
        raise InputError(f"missing; needs {_FORMS}", key="[index]")
    before = len(mistakes.errors)
    made = [mistakes.of(_index, top, key, mistakes) for key in keys]
    if len(mistakes.errors) > before:
        return None
    known = [one for one in made if one is not None]
    low, high = max(range_nm[0] for _, range_nm in known), min(range_nm[1] for _, range_nm in known)
    range_nm = checked_range((low, high))
    if len(keys) > 1:  # before a crystal is made of them, whose errors have no keys of files
        for key, (dispersion, _) in zip(keys, known, strict=True):
            mistakes.of(check_index, dispersion, range_nm, key)
    return tuple(dispersion for dispersion, _ in known), range_nm


def _index(
    top: dict[str, Any], key: str, mistakes: Mistakes
) -> tuple[Dispersion, tuple[float, float]] | None:
    before = len(mistakes.errors)
    index = section(top, key, (*_FORMULA, *_TABLE), mistakes=mistakes)
    if len(mistakes.errors) > before:
        return None
    return _dispersion(index, key)


def _dispersion(index: dict[str, Any], key: str) -> tuple[Dispersion, tuple[float, float]]:
    by_formula, by_table = (any(key in index for key in keys) for keys in (_FORMULA, _TABLE))
    if by_formula == by_table:
        has = "has keys of both" if by_formula else "has none of them"
        raise InputError(f"needs exactly one of: {_FORMS}; {has}", key=f"[{key}]")
    refuse_missing(index, _FORMULA if by_formula else _TABLE, key)
    with located_at(None, key), Mistakes() as mistakes:
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


def _absorptions(top: dict[str, Any], mistakes: Mistakes) -> tuple[Table, ...] | None:
    """Return the absorption in all directions, or in each; None where there are mistakes, which are kept."""
    keys, of_index = _sections(top, "absorption"), [key for key in top if key.startswith("index")]
    if len(keys) > 1 and sorted(of_index) != sorted(key.replace("absorption", "index") for key in keys):
        own = "] and [".join(key.replace("absorption", "index") for key in keys)
        raise InputError(f"goes with [{own}]", key=f"[{keys[-1]}]")
    before = len(mistakes.errors)
    made = [mistakes.of(_absorption, top, key, mistakes) for key in keys]
    if len(mistakes.errors) > before:
        return None
    return tuple(one for one in made if one is not None)


def _absorption(top: dict[str, Any], key: str, mistakes: Mistakes) -> Table | None:
    before = len(mistakes.errors)
    absorption = section(top, key, _ABSORPTION, mistakes=mistakes)
    if len(mistakes.errors) > before and len(absorption) < len(_ABSORPTION):
        return None
    refuse_missing(absorption, _ABSORPTION, key)
    with located_at(None, key):
        return Table(wavelength_nm=absorption["wavelength_nm"], values=absorption["per_mm"], key="per_mm")

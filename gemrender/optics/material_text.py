"""A material as the text of a file, to start from: what `gemrender materials --show` prints."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator

from gemrender.optics.dispersion import FORMULAE, VISIBLE_NM, Dispersion, Formula
from gemrender.optics.material import Material
from gemrender.optics.material_files import load_material
from gemrender.optics.tabulated import Table

__all__ = ["material_template"]

#: Numbers in a line; with all their digits they stay below 110 characters.
_IN_A_LINE = 5


def material_template(material: Material | str) -> str:
    """Return a material file (TOML) that loads to the same index and absorption, to the last bit.

    Parameters
    ----------
    material : Material or str
        A material, or the name of one that comes with gemrender.

    Returns
    -------
    str
        The text, with a line end at its end.

    Raises
    ------
    InputError
        No such name.
    """
    made = material if isinstance(material, Material) else load_material(material)
    return "\n".join(_lines(made)) + "\n"


def _lines(material: Material) -> Iterator[str]:
    yield "# A material: change it, then use it as in: gemrender render STONE --material FILE"
    yield f"name = {_text(material.name)}"
    if material.density is not None:
        yield f"density = {material.density!r}  # g/cm^3"
    for key in ("source", "note"):
        if text := getattr(material, key):
            yield f"{key} = {_text(text)}"
    yield ""
    words = "relative to air; wavelengths L in micrometres in a formula, in nanometres elsewhere"
    for k, (key, dispersion) in enumerate(material.dispersions):
        if k:
            yield ""
        yield f"[{key}]" if k else f"[{key}]  # {words}"
        yield from _dispersion(dispersion, material.range_nm, with_formulae=not k)
    for key, absorption in material.absorptions:
        yield ""
        yield from _absorption(key, absorption, alone=len(material.absorptions) == 1)


def _dispersion(
    dispersion: Dispersion, range_nm: tuple[float, float], *, with_formulae: bool
) -> Iterator[str]:
    if isinstance(dispersion, Formula):
        if with_formulae:
            for name, words in FORMULAE.items():
                yield f"# {name}: {words}"
        yield f"formula = {_text(dispersion.formula)}"
        parts = [list(c) if isinstance(c, tuple) else c for c in dispersion.coefficients]
        yield f"coefficients = {parts!r}"
        yield f"range_nm = {list(range_nm)!r}"
        if with_formulae:
            yield "# or instead of these three: wavelength_nm = [...] and n = [...], linear between the rows"
    else:
        yield from _list("wavelength_nm", dispersion.wavelength_nm)
        yield from _list("n", dispersion.values)


def _absorption(key: str, absorption: Table | None, *, alone: bool) -> Iterator[str]:
    if absorption is None and not alone:  # one direction that has none where others have some
        absorption = Table(wavelength_nm=VISIBLE_NM, values=(0.0, 0.0), key="per_mm")
    if absorption is None:
        yield f"# [{key}]  # coefficient to the base e [1/mm]; without it the material is colourless"
        yield "# wavelength_nm = [380, 500, 760]"
        yield "# per_mm = [0.3, 0.1, 0.0]"
        return
    yield f"[{key}]  # coefficient to the base e [1/mm]"
    yield from _list("wavelength_nm", absorption.wavelength_nm)
    yield from _list("per_mm", absorption.values)


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)  # for a printable text, TOML's basic string is JSON's


def _list(key: str, values: Iterable[float]) -> Iterator[str]:
    numbers = [repr(value) for value in values]
    yield f"{key} = ["
    for i in range(0, len(numbers), _IN_A_LINE):
        yield f"  {', '.join(numbers[i : i + _IN_A_LINE])},"
    yield "]"

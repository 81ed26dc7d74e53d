"""What a material's numbers give reason to say: what is continued beyond its rows, and what no gem has."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from gemrender.optics.abbe import ABBE_RANGE, FRAUNHOFER_B_NM, FRAUNHOFER_G_NM, SODIUM_NM, other_form
from gemrender.optics.dispersion import VISIBLE_NM
from gemrender.optics.tabulated import Table

if TYPE_CHECKING:
    from gemrender.optics.material import Material

__all__ = ["beyond", "cautions"]

#: Wavelengths that differ by rounding are the same [relative].
_SAME = 1e-9


def beyond(range_nm: tuple[float, float]) -> tuple[tuple[float, float], ...]:
    """Return the stretches of visible light that are beyond a range of wavelengths [nm]: none, one or two."""
    pairs = (VISIBLE_NM[0], range_nm[0]), (range_nm[1], VISIBLE_NM[1])
    return tuple((low, high) for low, high in pairs if high - low > _SAME * high)


def cautions(material: Material) -> tuple[str, ...]:
    """Return what there is to say of a material, each a line."""
    return (*_of_index(material), *_of_abbe_number(material), *_of_absorption(material))


def _of_index(material: Material) -> Iterator[str]:
    stretches, (low, high) = material.continued_nm, material.range_nm
    if not stretches:
        return
    if isinstance(material.dispersion, Table):
        to = " and ".join(f"{end:g}" for stretch in stretches for end in stretch if end in VISIBLE_NM)
        lines = (FRAUNHOFER_G_NM, SODIUM_NM, FRAUNHOFER_B_NM)
        index = zip(lines, material.index(lines), strict=True)
        values = ", ".join(f"{n:.4f} at {line:g}" for line, n in index)
        rows = f"index table of {low:g} to {high:g} nm"
        yield f"{rows}, continued to {to} nm as its end rows run: n is {values} nm"
        return
    if low in stretches[0]:
        yield f"formula of {low:g} nm and above, continued to {VISIBLE_NM[0]:g} nm"
    if high in stretches[-1]:
        yield f"formula of {high:g} nm and below, continued to {VISIBLE_NM[1]:g} nm"


def _of_abbe_number(material: Material) -> Iterator[str]:
    abbe, (least, most) = material.abbe_number, ABBE_RANGE
    if abbe is not None and not least <= abbe <= most:
        other = other_form(material.dispersion)
        hint = f"; {other[0]}" if other else ""
        yield f"Abbe number {abbe:.3g}, where transparent solids have {least:g} to {most:g}{hint}"


def _of_absorption(material: Material) -> Iterator[str]:
    if material.absorption is not None:
        low, high = material.absorption.wavelength_nm[0], material.absorption.wavelength_nm[-1]
        if beyond((low, high)):
            yield f"absorption of {low:g} to {high:g} nm, beyond which its end values hold"

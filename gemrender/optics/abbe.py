"""Fraunhofer's lines, Abbe's number, and what they tell of coefficients given in the wrong unit."""

from __future__ import annotations

import numpy as np

from gemrender.errors import InputError
from gemrender.optics.dispersion import INDEX_RANGE, SODIUM_NM, VISIBLE_NM, Dispersion, Formula

__all__ = [
    "ABBE_LINES_NM",
    "ABBE_RANGE",
    "FRAUNHOFER_B_NM",
    "FRAUNHOFER_C_NM",
    "FRAUNHOFER_F_NM",
    "FRAUNHOFER_G_NM",
    "SODIUM_NM",
    "abbe_number",
    "other_form",
    "refuse_other_form",
]

#: Fraunhofer's G and B lines, whose indices differ by what gemmologists call dispersion [nm].
FRAUNHOFER_G_NM, FRAUNHOFER_B_NM = 430.8, 686.7
#: Fraunhofer's F and C lines [nm].
FRAUNHOFER_F_NM, FRAUNHOFER_C_NM = 486.1, 656.3
#: The lines of Abbe's number, in the order that `abbe_number` takes their indices in [nm].
ABBE_LINES_NM = (FRAUNHOFER_F_NM, SODIUM_NM, FRAUNHOFER_C_NM)

#: Abbe numbers of transparent solids: rutile has 9.9, diamond 55, fluorite 95, magnesium fluoride 106.
ABBE_RANGE = (6.0, 150.0)
#: Above this Abbe number "sellmeier" is refused where "sellmeier-2" makes a gem of the same numbers. Of the
#: database refractiveindex.info, catalogues' glasses have 440 and more in the wrong form, and lithium's
#: halides, the highest but for one, up to 215 in the right one.
_REFUSED_ABOVE = 250.0
#: Difference of two indices that is none but for rounding.
_NO_DISPERSION = 1e-12

#: Unit of C in each of Sellmeier's forms.
_C_UNIT = {"sellmeier": "um", "sellmeier-2": "um^2"}


def abbe_number(n_f: float, n_d: float, n_c: float) -> float | None:
    """Return Abbe's number (n_D - 1) / (n_F - n_C) of three indices, at `ABBE_LINES_NM`.

    It is V_D, by the sodium line; catalogues of glass have V_d too, by helium's line at 587.6 nm. None where
    n_F and n_C are equal, or an index is none.
    """
    if not np.isfinite([n_f, n_d, n_c]).all() or abs(n_f - n_c) < _NO_DISPERSION:
        return None
    return float((n_d - 1) / (n_f - n_c))


def other_form(dispersion: Dispersion) -> tuple[str, float] | None:
    """Tell whether coefficients make a gem's dispersion in the other of Sellmeier's two forms.

    Parameters
    ----------
    dispersion : Formula or Table
        The dispersion as it was given.

    Returns
    -------
    (str, float) or None
        Words for the end of a message, and Abbe's number in the other form. None where there is no other
        form, or it makes no gem either.
    """
    other = dispersion.other_sellmeier() if isinstance(dispersion, Formula) else None
    if other is None:
        return None
    index = other.index(np.linspace(*VISIBLE_NM, 1000))
    abbe = abbe_number(*other.index(ABBE_LINES_NM))
    if abbe is None or not ABBE_RANGE[0] <= abbe <= ABBE_RANGE[1]:
        return None
    if not ((index >= INDEX_RANGE[0]) & (index <= INDEX_RANGE[1])).all():
        return None
    return f'with C in {_C_UNIT[other.formula]} it is formula = "{other.formula}"', abbe


def refuse_other_form(dispersion: Dispersion, key: str = "index") -> None:
    """Refuse C in um^2 that is given as C in um: it makes an index with next to no dispersion.

    Parameters
    ----------
    dispersion : Formula or Table
        The dispersion as it was given.
    key : str
        What errors call it.

    Raises
    ------
    InputError
        "sellmeier" makes an Abbe number that no solid has, and "sellmeier-2" makes one that solids have.
    """
    if not isinstance(dispersion, Formula) or dispersion.formula != "sellmeier":
        return
    abbe = abbe_number(*dispersion.index(ABBE_LINES_NM))
    if abbe is None or 0 < abbe <= _REFUSED_ABOVE:
        return
    if other := other_form(dispersion):
        words, meant = other
        raise InputError(
            f"Abbe number {abbe:.0f}, and solids have {ABBE_RANGE[0]:g} to {ABBE_RANGE[1]:g}; {words} (Abbe "
            f"number {meant:.1f}), and if C is indeed in um, that form takes C^2",
            key=f"{key}.coefficients",
        )

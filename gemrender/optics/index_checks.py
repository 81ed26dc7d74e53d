"""Whether an index is one that materials have, at every wavelength of its range and of visible light."""

from __future__ import annotations

import numpy as np

from gemrender.errors import InputError
from gemrender.optics.abbe import SODIUM_NM, other_form, refuse_other_form
from gemrender.optics.dispersion import INDEX_RANGE, VISIBLE_NM, Dispersion, Formula, index_of
from gemrender.optics.tabulated import Table

__all__ = ["check_index", "visible_and"]

#: Wavelengths at which an index is checked: between its poles a formula is smooth.
_N_CHECKED = 2000


def visible_and(range_nm: tuple[float, float]) -> tuple[float, float]:
    """Return the lowest and the highest wavelength of a range and of visible light [nm]."""
    return min(range_nm[0], VISIBLE_NM[0]), max(range_nm[1], VISIBLE_NM[1])


def check_index(dispersion: Dispersion, range_nm: tuple[float, float], key: str = "index") -> None:
    """Refuse an index that leaves `INDEX_RANGE`, and coefficients of the other of Sellmeier's forms.

    Parameters
    ----------
    dispersion : Formula or Table
        The index.
    range_nm : pair of float
        Its range [nm]; visible light is checked, too.
    key : str
        What errors call it.

    Raises
    ------
    InputError
        It is refused.
    """
    first, last = visible_and(range_nm)
    poles = dispersion.poles_nm() if isinstance(dispersion, Formula) else ()
    tried = np.concatenate([np.linspace(first, last, _N_CHECKED), VISIBLE_NM, range_nm, poles])
    if isinstance(dispersion, Table):
        tried = np.concatenate([tried, dispersion.wavelength_nm])
    tried = np.sort(tried[(tried >= first) & (tried <= last)])
    with np.errstate(all="ignore"):
        index = index_of(dispersion, tried)
    low, high = INDEX_RANGE
    wrong = ~((index >= low) & (index <= high))  # true for NaN too
    if wrong.any():
        at = int(np.argmax(wrong))
        raise InputError(
            f"must be from {low:g} to {high:g} at every wavelength from {first:g} to {last:g} nm"
            + _hint(dispersion, tried[at]),
            key=f"{key} at {tried[at]:.6g} nm",
            value=float(index[at]),
        )
    refuse_other_form(dispersion, key)


def _hint(dispersion: Dispersion, wavelength_nm: float) -> str:
    """Say what may be wrong where the index is out of range."""
    if isinstance(dispersion, Table):
        low, high = dispersion.wavelength_nm[0], dispersion.wavelength_nm[-1]
        inside = low <= wavelength_nm <= high
        return (
            "" if inside else f"; the table of {low:g} to {high:g} nm is continued there as its end rows run"
        )
    if other := other_form(dispersion):
        return f"; {other[0]}"
    if not INDEX_RANGE[0] <= dispersion.index(SODIUM_NM) <= INDEX_RANGE[1]:
        return "; coefficients are for wavelengths in micrometres"
    return "" if VISIBLE_NM[0] <= wavelength_nm <= VISIBLE_NM[1] else "; range_nm may be narrower"

"""Refractive indices of gem materials at the sodium D line, 589.3 nm."""

from __future__ import annotations

from gemrender.errors import InputError
from gemrender.optics.fresnel import GUBELIN_INDEX

__all__ = ["INDEX_RANGE", "INDICES", "refractive_index"]

#: Index at 589.3 nm relative to air; of birefringent stones the ordinary one. Diamond is the paper's value.
#: Sources: diamond, Inoue's paper (Peter 1923 gives 2.41726); sapphire, Malitson & Dodge 1972; cubic
#: zirconia with 12 % Y2O3, Wood & Nassau 1982; moissanite 6H, Wang et al. 2013; spinel, Tropf; quartz,
#: Ghosh 1999; YAG, Zelmon et al.; strontium titanate, Bond/Dodge; rutile, Devore.
INDICES: dict[str, float] = {
    "diamond": GUBELIN_INDEX,
    "cubic zirconia": 2.15846,
    "moissanite": 2.64743,
    "quartz": 1.5442,
    "rutile": 2.6129,
    "sapphire": 1.76808,
    "spinel": 1.7161,
    "strontium titanate": 2.4080,
    "yag": 1.8326,
}

#: Allowed range of a refractive index given as a number.
INDEX_RANGE = (1.05, 4.0)


def refractive_index(material: str | float | None) -> float:
    """Return the refractive index of a material at 589.3 nm.

    Parameters
    ----------
    material : str, float or None
        A name of `INDICES` (case and hyphens do not count), an index, or None for diamond.

    Raises
    ------
    InputError
        Unknown name, or an index outside `INDEX_RANGE`.
    """
    if material is None:
        return GUBELIN_INDEX
    if isinstance(material, str):
        name = " ".join(material.lower().replace("-", " ").replace("_", " ").split())
        if name not in INDICES:
            raise InputError(f"must be one of {', '.join(sorted(INDICES))}", key="name", value=material)
        return INDICES[name]
    low, high = INDEX_RANGE
    if isinstance(material, bool) or not isinstance(material, (int, float)) or not low <= material <= high:
        raise InputError(f"must be a number from {low:g} to {high:g}", key="index", value=material)
    return float(material)

"""What materials make of a crystal's principal directions: their names in files, and an isotropic twin."""

from __future__ import annotations

from typing import Any

import numpy as np

from gemrender.optics.crystals.crystal import Crystal
from gemrender.optics.dispersion import Dispersion
from gemrender.optics.tabulated import Table

__all__ = [
    "ENDS",
    "along_axes",
    "is_pleochroic",
    "isotropic_absorption",
    "ordinary",
    "section_keys",
]

#: What the sections of a material file end in, by how many principal directions there are.
ENDS: dict[int, tuple[str, ...]] = {1: ("",), 2: ("", "_e"), 3: ("_alpha", "_beta", "_gamma")}


def section_keys(crystal: Crystal, section: str) -> tuple[str, ...]:
    """Return what the sections of a file are called; those of the ordinary ray have no ending."""
    return tuple(f"{section}{end}" for end in ENDS[len(crystal.dispersions)])


def ordinary(crystal: Crystal) -> Dispersion:
    """Return what an isotropic twin has: the ordinary index, of a biaxial crystal the middle one."""
    return crystal.dispersions[1 if len(crystal.dispersions) == 3 else 0]


def is_pleochroic(crystal: Crystal) -> bool:
    """Whether absorption depends on the direction."""
    return any(table != crystal.absorptions[0] for table in crystal.absorptions)


def isotropic_absorption(crystal: Crystal) -> Table | None:
    """Return what an isotropic twin absorbs: as the ordinary ray does, or the mean of a biaxial crystal's.

    Of a biaxial crystal no direction stands for the others.
    """
    tables = crystal.absorptions
    if len(tables) < 3:
        return tables[0] if tables else None
    rows = sorted({nm for table in tables if table is not None for nm in table.wavelength_nm})
    if not rows:
        return None
    mean = crystal.principal_absorption_per_mm(rows).mean(axis=-1)
    return Table(wavelength_nm=tuple(rows), values=tuple(mean.tolist()), key="per_mm")


def along_axes(crystal: Crystal, wavelength_nm: Any) -> np.ndarray:
    """Return the index along each axis of the optic frame, (3, ...); of a uniaxial crystal o, o, e.

    Parameters
    ----------
    crystal : Crystal
        The crystal.
    wavelength_nm : array_like
        Wavelengths [nm].
    """
    indices = np.moveaxis(crystal.principal_indices(wavelength_nm), -1, 0)
    return indices if len(indices) == 3 else indices[[0, 0, -1]]

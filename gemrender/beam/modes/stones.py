"""The crystal of a stone, by its material and how it lies in the stone."""

from __future__ import annotations

from gemrender.beam.modes.crystal import Biaxial, Uniaxial, optical_crystal
from gemrender.observation import Model, indicatrix_of
from gemrender.stone import Stone

__all__ = ["crystal_of"]


def crystal_of(stone: Stone, model: Model) -> Uniaxial | Biaxial | None:
    """Return the crystal of a birefringent stone as kernels take it; None as of `indicatrix_of`.

    Raises
    ------
    InputError
        A material that there is not.
    """
    of = indicatrix_of(stone, model)
    return None if of is None else optical_crystal(of.indices, of.frame)

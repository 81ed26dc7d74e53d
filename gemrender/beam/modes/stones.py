"""The crystal of a stone, by its material and how it lies in the stone."""

from __future__ import annotations

from gemrender.beam.modes.crystal import Biaxial, Uniaxial, optical_crystal
from gemrender.observation import Model
from gemrender.optics.dispersion import SODIUM_NM
from gemrender.optics.material_files import load_material, refractive_index
from gemrender.stone import Stone

__all__ = ["crystal_of"]


def crystal_of(stone: Stone, model: Model) -> Uniaxial | Biaxial | None:
    """Return the crystal of a birefringent stone at 589.3 nm, as it lies in the stone.

    None of an isotropic material, and where the model has another index than the material's ordinary one: who
    gives an index asks for an isotropic stone.

    Raises
    ------
    InputError
        A material that there is not.
    """
    crystal = load_material(stone.material, warn=False).crystal
    if crystal is None or model.index != refractive_index(stone.material):
        return None
    of = crystal.indicatrix(SODIUM_NM, stone.crystal_axes)
    return optical_crystal(of.indices, of.frame)

"""The kernels for birefringent stones made ready: compiled when they are first needed on a machine."""

from __future__ import annotations

from functools import cache

import numpy as np

from gemrender.beam.modes.crystal import Biaxial, Uniaxial, optical_crystal
from gemrender.beam.modes.measure import measure_modes
from gemrender.beam.prepare import PREPARING, sample_stone

__all__ = ["prepare_modes"]

#: Principal indices of crystals that kernels are compiled by.
_UNIAXIAL, _BIAXIAL = (1.7, 1.7, 1.701), (1.7, 1.7005, 1.701)
#: Polygons as large are left to rays [share of the view]: they need not be many.
_LEAST = 1e-3


def prepare_modes(crystal: Uniaxial | Biaxial) -> None:
    """Compile or load the kernels that scores with modes need: half a minute once, then a second a process.

    Parameters
    ----------
    crystal : Uniaxial or Biaxial
        Kernels for its kind; those for the other one are apart.
    """
    with PREPARING:
        _prepare(isinstance(crystal, Uniaxial))


@cache
def _prepare(is_uniaxial: bool) -> None:
    crystal = optical_crystal(_UNIAXIAL if is_uniaxial else _BIAXIAL, np.eye(3))
    measure_modes(sample_stone(), crystal, bound=10.0, least=_LEAST)

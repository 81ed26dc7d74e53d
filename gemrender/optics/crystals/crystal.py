"""A crystal as a substance: principal indices and absorption by wavelength, optic class and sign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.errors import InputError
from gemrender.optics.abbe import SODIUM_NM
from gemrender.optics.crystals.indicatrix import Indicatrix, optic_axial_angle_deg
from gemrender.optics.crystals.modes import Modes
from gemrender.optics.dispersion import INDEX_RANGE, VISIBLE_NM, Dispersion
from gemrender.optics.tabulated import Table

__all__ = ["AXES", "Crystal", "absorption_per_mm"]

#: What the principal directions are called, by how many there are.
AXES: dict[int, tuple[str, ...]] = {
    1: ("index",),
    2: ("ordinary", "extraordinary"),
    3: ("alpha", "beta", "gamma"),
}
#: Wavelengths at which indices are checked.
_N_CHECKED = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class Crystal:
    """Principal indices and absorption of a crystal; how it lies in a stone is the stone's.

    Parameters
    ----------
    dispersions : sequence of Formula or Table
        One dispersion (isotropic), two (uniaxial: ordinary, extraordinary), or three (biaxial: alpha, beta,
        gamma, in increasing order of the index at 589.3 nm).
    absorptions : sequence of Table or None
        As many: absorption coefficients of light whose field is along each principal direction, to the base
        e [1/mm]; None is none. Empty: colourless.

    Raises
    ------
    InputError
        Another number of dispersions or absorptions, an index outside `INDEX_RANGE` in visible light, biaxial
        indices that do not increase.
    """

    dispersions: tuple[Dispersion, ...]
    absorptions: tuple[Table | None, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "dispersions", tuple(self.dispersions))
        object.__setattr__(self, "absorptions", tuple(self.absorptions))
        number = len(self.dispersions)
        if number not in AXES:
            raise InputError("must be 1, 2 or 3 dispersions", key="dispersions", value=number)
        if self.absorptions and len(self.absorptions) != number:
            raise InputError(
                f"must be none, or as many as dispersions: {number}",
                key="absorptions",
                value=len(self.absorptions),
            )
        wavelengths = np.append(np.linspace(*VISIBLE_NM, _N_CHECKED), SODIUM_NM)
        low, high = INDEX_RANGE
        with np.errstate(all="ignore"):
            for name, index in zip(AXES[number], self.principal_indices(wavelengths).T, strict=True):
                wrong = ~((index >= low) & (index <= high))  # true for NaN too
                if wrong.any():
                    at = int(np.argmax(wrong))
                    raise InputError(
                        f"must be from {low:g} to {high:g} in visible light",
                        key=f"{name} index at {wavelengths[at]:.6g} nm",
                        value=float(index[at]),
                    )
        if number == 3 and not (np.diff(self._at_sodium) >= 0).all():
            raise InputError(
                f"must be alpha, beta, gamma in increasing order at {SODIUM_NM:g} nm",
                key="indices",
                value=[round(float(index), 6) for index in self._at_sodium],
            )

    @property
    def _at_sodium(self) -> np.ndarray:
        return self.principal_indices(SODIUM_NM)

    def principal_indices(self, wavelength_nm: Any) -> np.ndarray:
        """Return the indices along the principal directions (..., 1 to 3) at some wavelengths [nm]."""
        return np.stack([_index(dispersion, wavelength_nm) for dispersion in self.dispersions], axis=-1)

    def indicatrix(self, wavelength_nm: Any, frame: np.ndarray) -> Indicatrix:
        """Return the indicatrix at some wavelengths [nm] of the crystal as it lies in a stone.

        Parameters
        ----------
        wavelength_nm : array_like
            Wavelengths [nm].
        frame : (3, 3) array
            The optic frame (`frame`); of no meaning to an isotropic crystal.
        """
        indices = self.principal_indices(wavelength_nm)
        if len(self.dispersions) == 3:
            return Indicatrix.biaxial(indices[..., 0], indices[..., 1], indices[..., 2], frame)
        return Indicatrix.uniaxial(indices[..., 0], indices[..., -1], frame)

    def principal_absorption_per_mm(self, wavelength_nm: Any) -> np.ndarray:
        """Return the absorption along the indicatrix's axes (..., 3) at some wavelengths [nm], in 1/mm."""
        wavelengths = np.asarray(wavelength_nm, float)
        given: Sequence[Table | None] = self.absorptions or [None] * len(self.dispersions)
        each = [np.zeros_like(wavelengths) if table is None else table.at(wavelengths) for table in given]
        if len(each) < 3:  # the indicatrix's axes: ordinary, ordinary, extraordinary
            each = [each[0], each[0], each[-1]]
        return np.stack(each, axis=-1)

    @property
    def birefringence(self) -> float:
        """Difference of the greatest and the least index at 589.3 nm."""
        return float(np.ptp(self._at_sodium))

    @property
    def optic_axial_angle_deg(self) -> float | None:
        """The acute angle 2V of a biaxial crystal at 589.3 nm [deg]; None for others."""
        if len(self.dispersions) < 3:
            return None
        return float(optic_axial_angle_deg(*self._at_sodium)[1])

    @property
    def optic_sign(self) -> str:
        """Plus, minus or nothing at 589.3 nm, the last where indices or 2V make neither.

        Uniaxial: whether the extraordinary index is the greater. Biaxial: whether gamma is in the middle of
        the acute angle of the optic axes.
        """
        indices = self._at_sodium
        if len(indices) == 3:
            about_gamma = float(optic_axial_angle_deg(*indices)[0]) if np.ptp(indices) else 90.0
            difference = 90.0 - about_gamma
        else:
            difference = float(indices[-1] - indices[0])
        return "+" if difference > 0 else "-" if difference < 0 else ""

    @property
    def optic_class(self) -> str:
        """What gemmologists call it: "isotropic", "uniaxial +", "biaxial -" and so on."""
        name = {1: "isotropic", 2: "uniaxial", 3: "biaxial"}[len(self.dispersions)]
        return f"{name} {self.optic_sign}".strip()


def absorption_per_mm(modes: Modes, indicatrix: Indicatrix, principal: np.ndarray) -> np.ndarray:
    """Return the absorption of both modes along their rays.

    To first order in the absorption fields are those of the transparent crystal. By Poynting's theorem light
    of field E loses omega eps_0 sum eps''_i |E_i|^2 / 2 in a volume (Born & Wolf, Principles of Optics, 7th
    ed., section 15.6.1), with eps''_i = n_i alpha_i c / omega of light along an axis; its flux is
    |E x H| / (2 Z_0). So the share lost on a length of ray is

        alpha = sum_i alpha_i n_i |E_i|^2 / |E x H|,

    and on a length of the wave normal it is that over the cosine of the walk-off, of which a tracer that adds
    up lengths of rays need not know. The ordinary mode has alpha_o in all directions, the extraordinary one
    alpha_e across the optic axis.

    Parameters
    ----------
    modes : Modes
        The modes, as `modes_along` makes them.
    indicatrix : Indicatrix
        The crystal whose they are.
    principal : (..., 3) array
        Absorption of light with its field along each axis of the indicatrix [1/mm].

    Returns
    -------
    (..., 2)
        Absorption coefficients on a length of each mode's ray [1/mm].
    """
    along = np.einsum("...ij,...mj->...mi", indicatrix.frame, modes.e)
    lost = np.sum((indicatrix.indices * principal)[..., None, :] * along**2, axis=-1)
    return np.asarray(lost / np.linalg.norm(np.cross(modes.e, modes.h), axis=-1))


def _index(dispersion: Dispersion, wavelength_nm: Any) -> np.ndarray:
    if isinstance(dispersion, Table):
        return dispersion.at(wavelength_nm, continued=True)
    return dispersion.index(wavelength_nm)

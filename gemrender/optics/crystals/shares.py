"""Where a ray's energy goes at a stone's boundary: what tracers of energies need, in the stone's frame.

In a stone the phases of a ray's modes part within micrometres, so their energies add, and a ray is in one
mode at a time. All of this is `boundary` with the polarisation outside summed over (inside) or averaged over
(entering); shares are real and add up to 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.optics.crystals.boundary import enter, leave
from gemrender.optics.crystals.indicatrix import Indicatrix
from gemrender.optics.crystals.waves import Waves

__all__ = ["SharesEntering", "SharesInside", "shares_entering", "shares_inside"]


@dataclass(frozen=True, slots=True)
class SharesInside:
    """What becomes of a ray inside that meets the boundary in one mode.

    Attributes
    ----------
    reflected : (..., 2)
        Shares of the two reflected modes, in the order of `Waves`; zero of one that dies away.
    transmitted : (..., 2)
        Shares outside, polarised s and p; zero beyond the critical angle.
    k : (..., 2, 3)
        Wave vectors of the reflected modes [omega / c]; of one that dies away the real part.
    ray : (..., 2, 3)
        Directions of the reflected modes' energy, unit vectors.
    outside : (..., 3)
        Direction of the light outside, a unit vector; beyond the critical angle along the boundary.
    """

    reflected: np.ndarray
    transmitted: np.ndarray
    k: np.ndarray
    ray: np.ndarray
    outside: np.ndarray


@dataclass(frozen=True, slots=True)
class SharesEntering:
    """What becomes of an unpolarised ray outside that meets the boundary.

    Attributes
    ----------
    reflected : (...)
        Share that is reflected.
    transmitted : (..., 2)
        Shares of the crystal's two modes, in the order of `Waves`.
    k : (..., 2, 3)
        Wave vectors of these modes [omega / c]; of one that dies away the real part.
    ray : (..., 2, 3)
        Directions of these modes' energy, unit vectors.
    outside : (..., 3)
        Direction of the reflected light, a unit vector.
    """

    reflected: np.ndarray
    transmitted: np.ndarray
    k: np.ndarray
    ray: np.ndarray
    outside: np.ndarray


def shares_inside(
    normal: np.ndarray, wave_vector: np.ndarray, mode: Any, indicatrix: Indicatrix, outside: Any = 1.0
) -> SharesInside:
    """Return where the energy of a ray inside goes.

    Parameters
    ----------
    normal : (..., 3) array
        Unit normals out of the crystal.
    wave_vector : (..., 3) array
        Wave vectors of the ray's mode [omega / c], of which the part along the boundary counts.
    mode : array_like of int
        The ray's mode: 0 is ordinary or fast, 1 extraordinary or slow (`Waves`).
    indicatrix : Indicatrix
        The crystal.
    outside : array_like
        Refractive index outside.
    """
    left = leave(normal, wave_vector, indicatrix, outside)
    shape = left.reflected.shape[:-2]
    column = np.broadcast_to(np.asarray(mode), shape)[..., None, None]
    reflected, transmitted = (
        np.take_along_axis(of, column, axis=-1)[..., 0] for of in (left.reflected, left.transmitted)
    )
    k, ray = _in_stone(left.waves, left.axes)
    return SharesInside(reflected, transmitted, k, ray, _outside(left.waves, left.axes, outside))


def shares_entering(
    normal: np.ndarray, direction: np.ndarray, indicatrix: Indicatrix, outside: Any = 1.0
) -> SharesEntering:
    """Return where the energy of an unpolarised ray outside goes.

    Parameters
    ----------
    normal : (..., 3) array
        Unit normals out of the crystal.
    direction : (..., 3) array
        Directions in which the light goes, unit vectors against the normal.
    indicatrix : Indicatrix
        The crystal.
    outside : array_like
        Refractive index outside.
    """
    index = np.asarray(outside, float)
    entered = enter(normal, index[..., None] * np.asarray(direction, float), indicatrix, outside)
    k, ray = _in_stone(entered.waves, entered.axes)
    return SharesEntering(
        np.sum(entered.reflected, axis=(-2, -1)) / 2,
        np.sum(entered.transmitted, axis=-1) / 2,
        k,
        ray,
        _outside(entered.waves, entered.axes, outside),
    )


def _in_stone(waves: Waves, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return waves.k.real @ axes, waves.ray @ axes


def _outside(waves: Waves, axes: np.ndarray, index: Any) -> np.ndarray:
    """Return the direction of light outside that goes along the normal."""
    sine = waves.k[..., 0, 0].real / np.asarray(index, float)
    cosine = np.sqrt(np.maximum(1 - sine**2, 0.0))
    local = np.stack([np.minimum(sine, 1.0), np.zeros_like(sine), cosine], axis=-1)
    return np.asarray((local[..., None, :] @ axes)[..., 0, :])

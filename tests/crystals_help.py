"""Random crystals, boundaries and light for the tests of birefringent crystals."""

from __future__ import annotations

import numpy as np

from gemrender.optics.crystals import Indicatrix, modes_along

#: Indices of the random crystals, far apart: no mineral is so birefringent.
LEAST, MOST = 1.3, 3.0
KINDS = ("uniaxial", "biaxial")


def directions(rng, n):
    made = rng.normal(size=(n, 3))
    return made / np.linalg.norm(made, axis=-1, keepdims=True)


def frames(rng, n):
    made = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    return made * np.sign(np.linalg.det(made))[:, None, None]


def crystals(rng, n, kind):
    indices = rng.uniform(LEAST, MOST, (3, n))
    if kind == "uniaxial":
        return Indicatrix.uniaxial(indices[0], indices[1], frames(rng, n))
    return Indicatrix.biaxial(*indices, frames(rng, n))


def at_right_angles(rng, vectors):
    made = rng.normal(size=vectors.shape)
    made -= np.sum(made * vectors, axis=-1, keepdims=True) * vectors
    return made / np.linalg.norm(made, axis=-1, keepdims=True)


def coming(wave_normal, normal, crystal, mode):
    """Return wave vectors of a mode, and the normals on the side that its energy goes to."""
    modes = modes_along(wave_normal, crystal)
    towards = np.sum(modes.ray[..., mode, :] * normal, axis=-1)
    return modes.index[..., mode, None] * wave_normal, np.where(towards < 0, -1.0, 1.0)[..., None] * normal


def not_lost(left):
    """Return the share of both waves' energy (..., 2) that amplitudes and fluxes alone account for."""
    inside = np.abs(left.r) ** 2 * np.abs(left.waves.flux)[..., :, None]
    outside = left.transmitted * left.incident.flux[..., None, :]
    coming = np.where(left.incident.flux > 0, left.incident.flux, 1.0)
    return np.where(left.incident.flux > 0, (inside + outside).sum(axis=-2) / coming, 1.0)

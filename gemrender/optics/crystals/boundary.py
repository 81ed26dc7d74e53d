"""Light at a boundary between a crystal and an isotropic medium: amplitudes and energies of all waves.

The normal always points out of the crystal. Fields are along the boundary's own axes (`boundary_axes`): x
along the tangential wave vector, y = n cross x, n. The isotropic medium's waves, of unit |E|, are s, with
E = y, and p, with H = (index) y on both sides, E = (k_n, 0, -k_t) / index for k = (k_t, 0, k_n). So at normal
incidence on a denser medium r_s is negative and r_p positive; beyond the critical angle k_n = i |k_n|.

Continuity of E_x, E_y, H_x and H_y is four equations. The isotropic medium is taken out by what its outgoing
waves have between their fields, H_x + k_n E_y = 0 of s and k_n H_y - index^2 E_x = 0 of p. Each crystal wave
has two numbers, u_s and u_p, by which it misses these, and what is left are two equations of two amplitudes:
with those waves that go against the normal as columns of U,

    entering:  U a = (2 k_n i_s, 2 index k_n i_p)       leaving:  U a = -u of the wave that comes

which Cramer's rule solves. It is the closed form of Lekner (J. Phys.: Condens. Matter 3, 6121 (1991)), whose
coefficients are these determinants written out, and of Weidlich & Wilkie (ACM Trans. Graph. 27, 11 (2008)),
and holds for every crystal. No equation is divided by k_n, so grazing and critical angles are ordinary cases.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gemrender.optics.crystals.indicatrix import Indicatrix
from gemrender.optics.crystals.waves import Waves, boundary_axes, boundary_waves

__all__ = ["MOST_LOST", "Entering", "Leaving", "enter", "leave", "normal_outside"]


#: Share of a wave's energy that rounding may lose. More is lost, or found, only where rounding cannot tell
#: which side a wave's energy goes to: along the boundary, where all of it is reflected into itself in the
#: limit, and within 1e-10 of a biaxial crystal's optic axis where the cone of rays there meets the boundary.
#: Such a wave is given the former's shares; its amplitudes are left as they are.
MOST_LOST = 1e-6


@dataclass(frozen=True, slots=True)
class Entering:
    """What becomes of light that comes from outside.

    Attributes
    ----------
    r : (..., 2, 2) complex
        Amplitudes outside: of the reflected s and p (rows) for incident s and p (columns).
    t : (..., 2, 2) complex
        Amplitudes of the crystal's two waves (rows) for incident s and p (columns).
    reflected, transmitted : (..., 2, 2) float
        The same as shares of the incident energy flux: each column of both together adds up to 1.
    waves : Waves
        The crystal's two waves, which go against the normal.
    axes : (..., 3, 3)
        The boundary's own axes x, y, n as rows, in the stone's frame.
    """

    r: np.ndarray
    t: np.ndarray
    reflected: np.ndarray
    transmitted: np.ndarray
    waves: Waves
    axes: np.ndarray


@dataclass(frozen=True, slots=True)
class Leaving:
    """What becomes of light that comes from inside, in each of the crystal's two waves.

    Attributes
    ----------
    r : (..., 2, 2) complex
        Amplitudes of the two reflected waves (rows) for either incident one (columns).
    t : (..., 2, 2) complex
        Amplitudes outside, of s and p (rows) for either incident wave (columns).
    reflected, transmitted : (..., 2, 2) float
        The same as shares of the incident energy flux: each column of both together adds up to 1. Of a wave
        that goes along the boundary all is reflected into itself; an evanescent one carries nothing, and its
        columns are zero.
    incident, waves : Waves
        The crystal's waves: those that come, along the normal, and those that are reflected.
    axes : (..., 3, 3)
        The boundary's own axes x, y, n as rows, in the stone's frame.
    """

    r: np.ndarray
    t: np.ndarray
    reflected: np.ndarray
    transmitted: np.ndarray
    incident: Waves
    waves: Waves
    axes: np.ndarray


def normal_outside(length: np.ndarray, index: Any) -> np.ndarray:
    """Return the wave vector's normal component outside (...), complex: i |k_n| where light dies away."""
    return np.asarray(np.sqrt(np.asarray(index, float) ** 2 - np.asarray(length) ** 2 + 0j))


def enter(normal: np.ndarray, tangential: np.ndarray, indicatrix: Indicatrix, outside: Any = 1.0) -> Entering:
    """Return amplitudes and energies of light that comes from outside.

    Parameters
    ----------
    normal : (..., 3) array
        Unit normals out of the crystal.
    tangential : (..., 3) array
        Wave vectors of the light [omega / c], of which the part along the boundary counts: the index outside
        times the light's direction. Those longer than the index outside are of no light that comes, and their
        shares mean nothing.
    indicatrix : Indicatrix
        The crystal.
    outside : array_like
        Refractive index outside.
    """
    axes, length = boundary_axes(normal, tangential)
    _, waves = boundary_waves(axes, length, indicatrix)
    index = np.asarray(outside, float)
    k_n = normal_outside(length, index)
    source = np.zeros((*np.broadcast_shapes(k_n.shape, index.shape), 2, 2), complex)
    source[..., 0, 0] = 2 * k_n
    source[..., 1, 1] = 2 * index * k_n
    t = _solved(_missed(waves, k_n, index), source)
    r = _outside(waves, index) @ t - np.eye(2)
    real = k_n.real
    reflected = np.abs(r) ** 2
    transmitted = np.abs(t) ** 2 * _ratio(np.abs(waves.flux)[..., :, None], real[..., None, None])
    return Entering(r, t, reflected, transmitted, waves, axes)


def leave(normal: np.ndarray, tangential: np.ndarray, indicatrix: Indicatrix, outside: Any = 1.0) -> Leaving:
    """Return amplitudes and energies of light that comes from inside.

    Parameters
    ----------
    normal : (..., 3) array
        Unit normals out of the crystal.
    tangential : (..., 3) array
        Wave vectors of the light [omega / c], of which the part along the boundary counts.
    indicatrix : Indicatrix
        The crystal.
    outside : array_like
        Refractive index outside.
    """
    axes, length = boundary_axes(normal, tangential)
    incident, waves = boundary_waves(axes, length, indicatrix)
    index = np.asarray(outside, float)
    k_n = normal_outside(length, index)
    r = _solved(_missed(waves, k_n, index), -_missed(incident, k_n, index))
    t = _outside(incident, index) + _outside(waves, index) @ r
    coming = incident.flux[..., None, :]
    reflected = np.abs(r) ** 2 * _ratio(np.abs(waves.flux)[..., :, None], coming)
    transmitted = np.abs(t) ** 2 * _ratio(np.broadcast_to(k_n.real[..., None, None], t.shape), coming)
    lost = ~(np.abs(np.sum(reflected + transmitted, axis=-2, keepdims=True) - 1) <= MOST_LOST)
    along = lost & incident.propagating[..., None, :]
    reflected = np.where(along, np.eye(2), reflected)
    transmitted = np.where(along, 0.0, transmitted)
    return Leaving(r, t, reflected, transmitted, incident, waves, axes)


def _missed(waves: Waves, k_n: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Return u_s and u_p (rows) of two waves (columns)."""
    e, h, k_n = waves.e, waves.h, k_n[..., None]
    u_s = h[..., 0] + k_n * e[..., 1]
    u_p = k_n * h[..., 1] - np.asarray(index)[..., None] ** 2 * e[..., 0]
    return np.stack([u_s, u_p], axis=-2)


def _outside(waves: Waves, index: np.ndarray) -> np.ndarray:
    """Return what s and p (rows) have the tangential fields of two waves (columns)."""
    return np.stack(
        np.broadcast_arrays(waves.e[..., 1], waves.h[..., 1] / np.asarray(index)[..., None]), axis=-2
    )


def _solved(u: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solve two equations by Cramer's rule; all zero where both waves are one (see `boundary_waves`)."""
    determinant = u[..., 0, 0] * u[..., 1, 1] - u[..., 0, 1] * u[..., 1, 0]
    determinant = np.where(determinant == 0, np.inf, determinant)[..., None]
    first = u[..., 1, 1, None] * right[..., 0, :] - u[..., 0, 1, None] * right[..., 1, :]
    second = u[..., 0, 0, None] * right[..., 1, :] - u[..., 1, 0, None] * right[..., 0, :]
    return np.stack([first / determinant, second / determinant], axis=-2)


def _ratio(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return one / other, and zero where the other is: nothing comes."""
    return np.where(other == 0, 0.0, one / np.where(other == 0, 1.0, other))

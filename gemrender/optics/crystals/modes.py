"""The two modes of light in a crystal for a given wave normal.

Units: wave vectors in omega / c, so that their length is the index; fields with H in E divided by the
impedance of vacuum, so that k x E = H and k x H = -D = -eps E (time as exp(-i omega t)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gemrender.optics.crystals.indicatrix import Indicatrix

__all__ = ["ON_AXIS", "Modes", "modes_along", "principal_directions"]

#: Sine of the angle to the optic axis from which on rounding alone tells the plane of both.
ON_AXIS = 1e-14


@dataclass(frozen=True, slots=True)
class Modes:
    """The two eigenmodes of light for a wave normal, real and of unit |E|.

    Uniaxial crystals: first the ordinary mode, then the extraordinary one. Biaxial: first the fast one, of
    the smaller index, then the slow one.

    Attributes
    ----------
    index : (..., 2)
        Phase indices.
    d, e, h : (..., 2, 3)
        Displacement, electric and magnetic field in the stone's frame; |e| is 1.
    ray : (..., 2, 3)
        Directions in which the energy goes, unit vectors.
    walk_off_deg : (..., 2)
        Angle between the wave normal and the ray [deg].
    """

    index: np.ndarray
    d: np.ndarray
    e: np.ndarray
    h: np.ndarray
    ray: np.ndarray
    walk_off_deg: np.ndarray


def modes_along(wave_normal: np.ndarray, indicatrix: Indicatrix) -> Modes:
    """Return the two modes for a wave normal.

    Born & Wolf, Principles of Optics, 7th ed., section 15.2.2: D is along the axes of the indicatrix's
    section across the wave normal, whose half-lengths are the indices.

    Where both modes have one index, any two D at right angles will do, and these are taken: along the optic
    axis of a uniaxial crystal the extraordinary D is along the first axis of the frame; in an isotropic
    material the two are told apart by the last axis of the frame as in a uniaxial one; along an optic axis of
    a biaxial crystal D is along the axis beta and across it. Indices, and whatever is a sum over both
    modes, are continuous there; single modes cannot be.

    Parameters
    ----------
    wave_normal : (..., 3) array
        Unit vectors in the stone's frame.
    indicatrix : Indicatrix
        The crystal.
    """
    s = np.asarray(wave_normal, float)
    eps = indicatrix.permittivities
    if indicatrix.has_optic_axis:
        n2, first, second = _uniaxial(s, indicatrix)
    else:
        n2, first, second = _biaxial(s, indicatrix)
    d = np.stack(np.broadcast_arrays(first, second), axis=-2)
    in_frame = np.einsum("...ij,...mj->...mi", indicatrix.frame, d) / eps[..., None, :]
    e = np.einsum("...ij,...mi->...mj", indicatrix.frame, in_frame)
    length = np.linalg.norm(e, axis=-1, keepdims=True)
    e, d = e / length, d / length
    index = np.sqrt(n2)
    h = index[..., None] * np.cross(s[..., None, :], e)
    flow = np.cross(e, h)
    ray = flow / np.linalg.norm(flow, axis=-1, keepdims=True)
    across = np.linalg.norm(np.cross(s[..., None, :], ray), axis=-1)
    along = np.einsum("...j,...mj->...m", s, ray)
    return Modes(index, d, e, h, ray, np.degrees(np.arctan2(across, along)))


def _uniaxial(s: np.ndarray, indicatrix: Indicatrix) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return squared indices (..., 2), the ordinary and the extraordinary D, unit vectors."""
    c = indicatrix.frame[..., 2, :]
    eo, ee = indicatrix.permittivities[..., 0], indicatrix.permittivities[..., 2]
    along = np.sum(s * c, axis=-1)
    across = s - along[..., None] * c
    across = across - np.sum(across * c, axis=-1, keepdims=True) * c  # what rounding left
    sine = np.linalg.norm(across, axis=-1)
    on_axis = (sine < ON_AXIS)[..., None]
    to_side = np.where(on_axis, indicatrix.frame[..., 0, :], across / np.where(on_axis, 1.0, sine[..., None]))
    extraordinary = eo * ee / (eo * sine**2 + ee * along**2)
    n2 = np.stack(np.broadcast_arrays(eo, extraordinary), axis=-1)
    return n2, np.cross(c, to_side), along[..., None] * to_side - sine[..., None] * c


def _biaxial(s: np.ndarray, indicatrix: Indicatrix) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return squared indices (..., 2), the fast and the slow D, unit vectors."""
    frame = indicatrix.in_order().frame
    least, middle = frame[..., 0, :], frame[..., 1, :]
    first = middle - np.sum(middle * s, axis=-1, keepdims=True) * s
    length = np.linalg.norm(first, axis=-1, keepdims=True)
    along_beta = length < ON_AXIS
    first = np.where(along_beta, least, first / np.where(along_beta, 1.0, length))
    first, s = np.broadcast_arrays(first, s)
    second = np.cross(s, first)
    eta = 1 / indicatrix.permittivities
    one = np.einsum("...ij,...j->...i", indicatrix.frame, first)
    two = np.einsum("...ij,...j->...i", indicatrix.frame, second)
    # Differences from the first eta: what birefringence there is stays exact however small it is.
    base = eta[..., :1]
    a, b, d = (np.sum(u * (eta - base) * v, axis=-1) for u, v in ((one, one), (one, two), (two, two)))
    mean, cos, sin = principal_directions(a, b, d)
    spread = np.hypot((a - d) / 2, b)
    n2 = 1 / (base + np.stack([mean + spread, mean - spread], axis=-1))
    cos, sin = cos[..., None], sin[..., None]
    return n2, cos * first + sin * second, cos * second - sin * first


def principal_directions(a: np.ndarray, b: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return mean eigenvalue of symmetric ((a, b), (b, d)) and the larger one's eigenvector (cos, sin).

    Of a multiple of the unit matrix it is (1, 0).
    """
    half = (a - d) / 2
    scale = np.abs(a) + np.abs(d)
    nothing = np.hypot(half, b) <= ON_AXIS * scale
    angle = np.where(nothing, 0.0, 0.5 * np.arctan2(b, half))
    return (a + d) / 2, np.cos(angle), np.sin(angle)

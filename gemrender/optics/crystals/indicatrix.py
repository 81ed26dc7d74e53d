"""The optical indicatrix: a crystal's principal indices at one wavelength, and its axes in the stone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["Indicatrix", "optic_axes", "optic_axial_angle_deg"]


@dataclass(frozen=True, slots=True)
class Indicatrix:
    """Principal indices and axes of one crystal, or of as many as its arrays have.

    Make it by `isotropic`, `uniaxial` or `biaxial`. Ordinary light, however oriented the crystal, has its
    modes in closed form; a biaxial one's need the roots of a quartic.

    Attributes
    ----------
    indices : (..., 3) float64
        Principal indices, for light whose field is along each axis. Uniaxial: ordinary, ordinary,
        extraordinary. Biaxial: of the axes alpha, beta, gamma.
    frame : (..., 3, 3) float64
        Rows are the principal axes, unit vectors, right-handed; a uniaxial crystal's last is the optic axis.
    has_optic_axis : bool
        Whether the first two indices are equal, as of isotropic and uniaxial crystals: the closed form.
    """

    indices: np.ndarray
    frame: np.ndarray
    has_optic_axis: bool

    @classmethod
    def isotropic(cls, index: Any) -> Indicatrix:
        """Make the sphere of an isotropic material."""
        return cls.uniaxial(index, index, np.eye(3))

    @classmethod
    def uniaxial(cls, ordinary: Any, extraordinary: Any, frame: np.ndarray) -> Indicatrix:
        """Make the indicatrix of a uniaxial crystal: a spheroid about the last axis of the frame."""
        o, e = np.broadcast_arrays(np.asarray(ordinary, float), np.asarray(extraordinary, float))
        return cls(np.stack([o, o, e], axis=-1), np.asarray(frame, float), True)

    @classmethod
    def biaxial(cls, alpha: Any, beta: Any, gamma: Any, frame: np.ndarray) -> Indicatrix:
        """Make the indicatrix of a biaxial crystal: an ellipsoid. Its indices may be in any order."""
        arrays = np.broadcast_arrays(*(np.asarray(index, float) for index in (alpha, beta, gamma)))
        return cls(np.stack(arrays, axis=-1), np.asarray(frame, float), False)

    @property
    def permittivities(self) -> np.ndarray:
        """Principal relative permittivities (..., 3), the squares of the indices."""
        return np.asarray(self.indices**2)

    def in_order(self) -> Indicatrix:
        """Return the same with its axes in increasing order of the index."""
        shape = np.broadcast_shapes(self.indices.shape[:-1], self.frame.shape[:-2])
        indices, frame = (
            np.broadcast_to(self.indices, (*shape, 3)),
            np.broadcast_to(self.frame, (*shape, 3, 3)),
        )
        order = np.argsort(indices, axis=-1, kind="stable")
        return Indicatrix(
            np.take_along_axis(indices, order, axis=-1),
            np.take_along_axis(frame, order[..., None], axis=-2),
            False,
        )


def optic_axial_angle_deg(alpha: Any, beta: Any, gamma: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the angle between a biaxial crystal's optic axes.

    Born & Wolf, Principles of Optics, 7th ed., section 15.3.1: an optic axis is the normal of a circular
    section of the indicatrix, at an angle V to the axis gamma with
    tan^2 V = (1/n_alpha^2 - 1/n_beta^2) / (1/n_beta^2 - 1/n_gamma^2).

    Parameters
    ----------
    alpha, beta, gamma : array_like
        Least, middle and greatest index.

    Returns
    -------
    about_gamma : array
        2 V about the axis gamma, 0 to 180 degrees [deg].
    acute : array
        2V as gemmologists tell it, 0 to 90 degrees [deg]. The crystal is optically positive where it is about
        gamma, negative where it is about alpha.
    """
    a, b, c = (np.asarray(index, float) for index in (alpha, beta, gamma))
    # The differences as products: equal indices make exact zeros.
    low = (b - a) * (b + a) * c**2
    high = (c - b) * (c + b) * a**2
    about_gamma = np.asarray(2 * np.degrees(np.arctan2(np.sqrt(low), np.sqrt(high))))
    return about_gamma, np.asarray(np.minimum(about_gamma, 180.0 - about_gamma))


def optic_axes(indicatrix: Indicatrix) -> np.ndarray:
    """Return the directions in which both modes have one index, in the stone's frame.

    Returns
    -------
    (..., 2, 3) float64
        Unit vectors; their senses have no meaning. A uniaxial crystal's are the same one twice.
    """
    if indicatrix.has_optic_axis:
        axis = np.broadcast_to(indicatrix.frame[..., 2, :], (*indicatrix.in_order().indices.shape[:-1], 3))
        return np.stack([axis, axis], axis=-2)
    ordered = indicatrix.in_order()
    half = np.radians(optic_axial_angle_deg(*np.moveaxis(ordered.indices, -1, 0))[0] / 2)[..., None]
    along, across = np.cos(half) * ordered.frame[..., 2, :], np.sin(half) * ordered.frame[..., 0, :]
    return np.stack([along + across, along - across], axis=-2)

"""A birefringent crystal as the compiled kernels take it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gemrender.errors import InputError

__all__ = ["Biaxial", "Uniaxial", "indices_text", "optical_crystal"]

#: Principal indices closer than this are one [relative]: rounding of a dispersion formula.
_ONE_INDEX = 1e-12
#: What rounding leaves between axes that are at right angles.
_ORTHOGONAL = 1e-9


class Uniaxial(NamedTuple):
    """A crystal with one optic axis, or none: its modes are known in closed form.

    ordinary, extraordinary : float
        Permittivities across the optic axis and along it, squares of the principal indices.
    axis, first : (3,) float64
        The optic axis, and an axis across it, which fields lie along where nothing else tells.
    """

    ordinary: float
    extraordinary: float
    axis: Any
    first: Any


class Biaxial(NamedTuple):
    """A crystal with two optic axes.

    permittivity, inverse : (3, 3) float64
        Its tensor in the stone's frame, and the inverse of that.
    """

    permittivity: Any
    inverse: Any


def optical_crystal(principal: Any, axes: Any) -> Uniaxial | Biaxial:
    """Return a crystal from its principal indices.

    Parameters
    ----------
    principal : (3,) array_like
        Principal indices relative to air, in any order.
    axes : (3, 3) array_like
        Rows are the axis of each index in the stone's frame, unit vectors at right angles.

    Raises
    ------
    InputError
        Indices that are no numbers above 1, or axes not at right angles.
    """
    indices, frame = np.asarray(principal, float), np.array(axes, float)
    if indices.shape != (3,) or not np.all(indices > 1.0) or not np.all(np.isfinite(indices)):
        raise InputError("must be three numbers above 1", key="principal", value=principal)
    if frame.shape != (3, 3) or not np.all(np.abs(frame @ frame.T - np.eye(3)) < _ORTHOGONAL):
        raise InputError("must be three unit vectors at right angles, a row each", key="axes", value=axes)
    for third in (2, 1, 0):
        one, other = indices[(third + 1) % 3], indices[(third + 2) % 3]
        if abs(one - other) <= _ONE_INDEX * one:
            return Uniaxial(
                float(one) ** 2,
                float(indices[third]) ** 2,
                frame[third].copy(),
                frame[(third + 1) % 3].copy(),
            )
    tensor, inverse = (
        np.einsum("ai,a,aj->ij", frame, weights, frame) for weights in (indices**2, indices**-2.0)
    )
    return Biaxial(np.ascontiguousarray(tensor), np.ascontiguousarray(inverse))


def indices_text(crystal: Uniaxial | Biaxial) -> str:
    """Return a crystal's principal indices in words: ordinary and extraordinary, or in rising order."""
    squares = (
        [crystal.ordinary, crystal.extraordinary]
        if isinstance(crystal, Uniaxial)
        else np.linalg.eigvalsh(crystal.permittivity)
    )
    return ", ".join(f"{np.sqrt(square):.5f}" for square in squares)

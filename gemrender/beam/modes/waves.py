"""The waves of a birefringent stone at a facet, compiled: their record, and what all crystals share.

Wave vectors are in units of that in air, so that a wave's is as long as its index is. At a facet all waves
have the same part along it, of length kappa. Components are along the facet's own axes: x along the
tangential wave vector, y = n x x, and the outward normal n. Fields go as exp(i (k . r - omega t)) and H = k x
E.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from gemrender.beam.compiled import jit_inner

__all__ = ["BACK", "OUT", "Waves", "empty_waves", "norm2", "root_of", "write_axes", "write_field"]

#: The first of the two waves that carry energy outwards, and of those that carry it back.
OUT, BACK = 0, 2
#: Tangential wave vectors shorter than this point nowhere.
_NOTHING = 1e-100


class Waves(NamedTuple):
    """The four waves at a facet: two outwards, two back; of each pair first the ordinary or the fast one.

    axes : (3, 3) float64
        The facet's own axes x, y and n, as rows, in the stone's frame.
    k : (4,) complex128
        Wave vectors' parts along the normal.
    e, h : (4, 3) complex128
        Fields, of unit |e|.
    flux : (4,) float64
        Energy flux along the normal; 0 of an evanescent wave.
    roots : (4,) complex128, tensors : (2, 3, 3) float64
        Room to find a biaxial crystal's in.
    """

    axes: Any
    k: Any
    e: Any
    h: Any
    flux: Any
    roots: Any
    tensors: Any


def empty_waves() -> Waves:
    """Return room for the waves at a facet."""
    return Waves(
        axes=np.zeros((3, 3)),
        k=np.zeros(4, complex),
        e=np.zeros((4, 3), complex),
        h=np.zeros((4, 3), complex),
        flux=np.zeros(4),
        roots=np.zeros(4, complex),
        tensors=np.zeros((2, 3, 3)),
    )


@jit_inner
def write_axes(nx: float, ny: float, nz: float, kx: float, ky: float, kz: float, axes: Any) -> float:
    """Write a facet's own axes, from its outward unit normal and a wave vector; return kappa."""
    along = kx * nx + ky * ny + kz * nz
    x, y, z = kx - along * nx, ky - along * ny, kz - along * nz
    kappa = math.sqrt(x * x + y * y + z * z)
    if kappa < _NOTHING:  # any axis will do
        kappa = 0.0
        ax, ay, az = abs(nx), abs(ny), abs(nz)
        x, y, z = 0.0, 0.0, 0.0
        if ax <= ay and ax <= az:
            x = 1.0
        elif ay <= az:
            y = 1.0
        else:
            z = 1.0
    for _ in range(2):  # the part may have been next to nothing beside the normal one
        along = x * nx + y * ny + z * nz
        x, y, z = x - along * nx, y - along * ny, z - along * nz
        length = 1.0 / math.sqrt(x * x + y * y + z * z)
        x, y, z = x * length, y * length, z * length
    axes[0, 0], axes[0, 1], axes[0, 2] = x, y, z
    axes[1, 0], axes[1, 1], axes[1, 2] = ny * z - nz * y, nz * x - nx * z, nx * y - ny * x
    axes[2, 0], axes[2, 1], axes[2, 2] = nx, ny, nz
    return kappa


@jit_inner
def root_of(x: float) -> complex:
    """Return the square root of a real number: positive, or positive times i."""
    return complex(math.sqrt(x), 0.0) if x >= 0.0 else complex(0.0, math.sqrt(-x))


@jit_inner
def write_field(kappa: float, i: int, ex: complex, ey: complex, en: complex, waves: Any) -> None:
    """Write E and H = k x E of a wave whose wave vector is known."""
    e, h, k = waves.e[i], waves.h[i], waves.k[i]
    e[0], e[1], e[2] = ex, ey, en
    h[0], h[1], h[2] = -k * ey, k * ex - kappa * en, kappa * ey


@jit_inner
def norm2(x: complex, y: complex, z: complex) -> float:
    """Return the squared length of a complex vector."""
    return (
        x.real * x.real
        + x.imag * x.imag
        + y.real * y.real
        + y.imag * y.imag
        + z.real * z.real
        + z.imag * z.imag
    )

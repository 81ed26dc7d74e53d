"""How a facet of a birefringent stone shares light among waves, compiled.

In air, fields that only go away from the stone have H_x + k_z E_y = 0 and k_z H_y - E_x = 0, with k_z the
wave vector's part along the normal there: of the wave that comes to the facet and the two that go back from
it together both hold, which are two equations for the amplitudes of these. So say Lekner, J. Phys.: Condens.
Matter 3, 6121 (1991), written out, and Weidlich & Wilkie, ACM Trans. Graph. 27, 11 (2008).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba.core import types
from numba.extending import overload

from gemrender.beam.compiled import jit, jit_inner
from gemrender.beam.modes.biaxial import write_biaxial
from gemrender.beam.modes.crystal import Biaxial
from gemrender.beam.modes.uniaxial import write_uniaxial
from gemrender.beam.modes.waves import BACK, OUT, Waves, empty_waves, root_of, write_axes
from gemrender.optics.fresnel import LEAST_TOTAL

__all__ = ["Facet", "empty_facet", "into_air", "meet", "ray_of", "wave_vector_of", "write_entering"]

#: Waves of a biaxial crystal whose wave vectors differ by less along the normal are told apart by their
#: number.
_ONE_WAVE = 1e-9


class Facet(NamedTuple):
    """A facet as light meets it.

    waves : Waves
        The four waves there.
    reflected : (2,) float64
        Shares that go back in each.
    entering : (2,) float64
        Shares of unpolarised light that enter in each.
    """

    waves: Waves
    reflected: Any
    entering: Any


def empty_facet() -> Facet:
    """Return room for a facet."""
    return Facet(empty_waves(), np.zeros(2), np.zeros(2))


def write_waves(crystal: Any, kappa: float, waves: Any) -> None:
    """Write the waves of a crystal at a facet, where the tangential wave vector has a length kappa."""


@overload(write_waves)
def _write_waves(crystal: Any, kappa: Any, waves: Any) -> Any:
    def uniaxial(crystal: Any, kappa: Any, waves: Any) -> None:
        write_uniaxial(crystal, kappa, waves)

    def biaxial(crystal: Any, kappa: Any, waves: Any) -> None:
        write_biaxial(crystal, kappa, waves)

    is_biaxial = isinstance(crystal, types.BaseNamedTuple) and crystal.instance_class is Biaxial
    return biaxial if is_biaxial else uniaxial


@jit_inner
def _missed(waves: Any, i: int, k_z: complex) -> Any:
    """Return by how much a wave misses both conditions."""
    e, h = waves.e[i], waves.h[i]
    return h[0] + k_z * e[1], k_z * h[1] - e[0]


@jit_inner
def _determinant(one: complex, other: complex) -> complex:
    """Return a determinant, infinite where it is 0: both waves are one, and carry nothing."""
    out = one - other
    return out if out != 0.0 else complex(math.inf, 0.0)


@jit
def write_entering(
    crystal: Any, nx: float, ny: float, nz: float, dx: float, dy: float, dz: float, facet: Any
) -> None:
    """Let unpolarised light of a direction d come from outside to a facet of an outward normal n."""
    waves = facet.waves
    kappa = write_axes(nx, ny, nz, dx, dy, dz, waves.axes)
    write_waves(crystal, kappa, waves)
    k_z = root_of(1.0 - kappa * kappa)
    s0, p0 = _missed(waves, BACK, k_z)
    s1, p1 = _missed(waves, BACK + 1, k_z)
    determinant = abs(_determinant(s0 * p1, s1 * p0)) ** 2
    # Of incident s and p of unit |E| the sources are 2 k_z in either equation, and half of the light each
    by = 2.0 * k_z.real / determinant
    facet.entering[0] = by * abs(waves.flux[BACK]) * (abs(s1) ** 2 + abs(p1) ** 2)
    facet.entering[1] = by * abs(waves.flux[BACK + 1]) * (abs(s0) ** 2 + abs(p0) ** 2)


@jit
def meet(
    crystal: Any, nx: float, ny: float, nz: float, kx: float, ky: float, kz: float, mode: int, facet: Any
) -> float:
    """Let a wave come to a facet from inside; return the share that leaves, 0 of total reflection.

    Parameters
    ----------
    crystal : Uniaxial or Biaxial
        The crystal.
    nx, ny, nz : float
        Outward unit normal.
    kx, ky, kz : float
        Wave vector.
    mode : int
        Number of the wave's mode.
    facet : Facet
        Is written: waves, and shares that go back.
    """
    waves, reflected = facet.waves, facet.reflected
    kappa = write_axes(nx, ny, nz, kx, ky, kz, waves.axes)
    write_waves(crystal, kappa, waves)
    i = OUT + _coming(crystal, kx * nx + ky * ny + kz * nz, mode, waves)
    is_total = kappa * kappa >= LEAST_TOTAL
    k_z = root_of(1.0 - kappa * kappa)
    s0, p0 = _missed(waves, BACK, k_z)
    s1, p1 = _missed(waves, BACK + 1, k_z)
    s, p = _missed(waves, i, k_z)
    determinant = _determinant(s0 * p1, s1 * p0)
    r0, r1 = (s1 * p - p1 * s) / determinant, (p0 * s - s0 * p) / determinant
    flux = waves.flux[i]
    if flux <= 0.0:  # it goes along the facet
        reflected[0], reflected[1] = 1.0 if i == OUT else 0.0, 0.0 if i == OUT else 1.0
        return 0.0
    reflected[0] = abs(r0) ** 2 * abs(waves.flux[BACK]) / flux
    reflected[1] = abs(r1) ** 2 * abs(waves.flux[BACK + 1]) / flux
    if is_total:
        unit = 1.0 / (reflected[0] + reflected[1])
        reflected[0], reflected[1] = reflected[0] * unit, reflected[1] * unit
        return 0.0
    e, h = waves.e, waves.h
    t_s = e[i, 1] + r0 * e[BACK, 1] + r1 * e[BACK + 1, 1]
    t_p = h[i, 1] + r0 * h[BACK, 1] + r1 * h[BACK + 1, 1]
    return float((abs(t_s) ** 2 + abs(t_p) ** 2) * k_z.real / flux)


def _coming(crystal: Any, k_n: float, mode: int, waves: Any) -> int:
    """Return which of the two waves outwards comes."""
    return mode


@overload(_coming)
def _coming_of(crystal: Any, k_n: Any, mode: Any, waves: Any) -> Any:
    def by_number(crystal: Any, k_n: Any, mode: Any, waves: Any) -> Any:
        return mode

    def by_wave(crystal: Any, k_n: Any, mode: Any, waves: Any) -> Any:
        # A line may cut the outer sheet four times, next to an optic axis: then both are of it
        first, second = abs(waves.k[OUT] - k_n), abs(waves.k[OUT + 1] - k_n)
        if abs(first - second) < _ONE_WAVE:
            return mode
        return np.int64(0) if first < second else np.int64(1)

    is_biaxial = isinstance(crystal, types.BaseNamedTuple) and crystal.instance_class is Biaxial
    return by_wave if is_biaxial else by_number


@jit_inner
def wave_vector_of(i: int, kx: float, ky: float, kz: float, facet: Any) -> Any:
    """Return the wave vector of one of a facet's waves, beside the one that came, or the light outside."""
    axes, waves = facet.waves.axes, facet.waves
    nx, ny, nz = axes[2, 0], axes[2, 1], axes[2, 2]
    by = waves.k[i].real - (kx * nx + ky * ny + kz * nz)
    return kx + by * nx, ky + by * ny, kz + by * nz


@jit_inner
def ray_of(i: int, facet: Any) -> Any:
    """Return the direction in which the energy of one of a facet's waves goes, a unit vector."""
    axes, waves = facet.waves.axes, facet.waves
    e, h = waves.e[i], waves.h[i]
    x = (e[1] * h[2].conjugate() - e[2] * h[1].conjugate()).real
    y = (e[2] * h[0].conjugate() - e[0] * h[2].conjugate()).real
    n = waves.flux[i]
    by = 1.0 / math.sqrt(x * x + y * y + n * n)
    x, y, n = x * by, y * by, n * by
    return (
        x * axes[0, 0] + y * axes[1, 0] + n * axes[2, 0],
        x * axes[0, 1] + y * axes[1, 1] + n * axes[2, 1],
        x * axes[0, 2] + y * axes[1, 2] + n * axes[2, 2],
    )


@jit_inner
def into_air(nx: float, ny: float, nz: float, kx: float, ky: float, kz: float) -> Any:
    """Return the direction of light that leaves, and its cosine in air: 0 of light that just leaves."""
    along = kx * nx + ky * ny + kz * nz
    x, y, z = kx - along * nx, ky - along * ny, kz - along * nz
    cos = math.sqrt(max(1.0 - x * x - y * y - z * z, 0.0))
    return x + cos * nx, y + cos * ny, z + cos * nz, cos

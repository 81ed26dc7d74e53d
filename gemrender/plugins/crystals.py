"""Crystals as kernels see them: indices along their axes, and waves at a facet.

Those of a scene's stones, of many wavelengths and in single precision; and that of the one stone that
`gem_primary` follows, at one wavelength and in double.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from gemrender.plugins.spectra import N_ROWS, row_of, tabulated
from gemrender.plugins.waves import Facet, Shares, shares, uniaxial
from gemrender.plugins.waves_biaxial import biaxial

__all__ = ["Crystal", "Crystals"]

#: Principal indices closer than this are one [relative]: rounding of a dispersion formula.
_ONE_INDEX = 1e-12
#: Waves of a biaxial crystal whose wave vectors differ by less along the normal are told apart by their
#: number.
_ONE_WAVE = 1e-9


class Crystals:
    """Crystals of stones, numbered from 1 as the stones are; those of one index are left out.

    Parameters
    ----------
    surfaces : sequence of GemDielectric
        Surface of each stone.

    Attributes
    ----------
    any : bool
        Whether any stone is birefringent.
    """

    def __init__(self, surfaces: Sequence[Any]) -> None:
        flags = [bool(s.birefringent) for s in surfaces]
        self.any = any(flags)
        if not self.any:
            return
        self._birefringent = mi.Bool([False, *flags])
        # Row 0 stands for no stone
        none = np.ones((3, N_ROWS), dtype=np.float32)
        tables = [none, *(s.principal_tables for s in surfaces)]
        self._principal = [mi.Float(np.concatenate([table[k] for table in tables])) for k in range(3)]
        one_axis = [bool(np.array_equal(s.principal_tables[0], s.principal_tables[1])) for s in surfaces]
        self._any_uniaxial = any(one for one, two in zip(one_axis, flags, strict=True) if two)
        self._any_biaxial = any(not one for one, two in zip(one_axis, flags, strict=True) if two)
        self._uniaxial = mi.Bool([True, *one_axis])
        self.any_absorbs = any(np.any(s.absorption_tables) for s in surfaces)
        tables = [0 * none, *(s.absorption_tables for s in surfaces)]
        self._absorption = [mi.Float(np.concatenate([table[k] for table in tables])) for k in range(3)]
        frames = np.stack([np.eye(3), *(np.asarray(s.crystal_axes) for s in surfaces)])
        self._axes = [[mi.Float(frames[:, i, j].astype(np.float32)) for j in range(3)] for i in range(3)]

    def among(self, stone: mi.UInt32, active: mi.Bool) -> mi.Bool:
        """Return whether stones are birefringent."""
        return active & dr.gather(mi.Bool, self._birefringent, stone, active)

    def principal(self, stone: mi.UInt32, nm: mi.Float, active: mi.Bool) -> mi.Vector3f:
        """Return the relative indices along the optic frame's axes at a wavelength [nm]."""
        row = row_of(nm)
        return mi.Vector3f(*(tabulated(table, stone * N_ROWS, row, active) for table in self._principal))

    def transmittance(
        self,
        stone: mi.UInt32,
        wavelengths: Sequence[mi.Float],
        counts: mi.Vector3f,
        distance: mi.Float,
        active: mi.Bool,
    ) -> list[mi.Float]:
        """Return the share that a way inside leaves, by Beer and Lambert, at each wavelength [nm].

        Parameters
        ----------
        counts : Vector3f
            What the coefficients along the axes count for, as `Wave.absorbs`.
        """
        out = []
        for nm in wavelengths:
            row = row_of(nm)
            along = [tabulated(table, stone * N_ROWS, row, active) for table in self._absorption]
            out.append(dr.exp(-dr.dot(mi.Vector3f(*along), counts) * dr.maximum(distance, 0)))
        return out

    def at_facet(
        self, stone: mi.UInt32, principal: mi.Vector3f, kt: mi.Vector3f, n: mi.Vector3f, active: mi.Bool
    ) -> Shares:
        """Return how a facet of an outward normal shares light whose wave vectors' part along it is `kt`."""
        facet = Facet.of(kt, n)
        axes = [
            mi.Vector3f(*(dr.gather(mi.Float, table, stone, active) for table in row)) for row in self._axes
        ]
        made = []
        if self._any_uniaxial:
            made.append(shares(facet, *uniaxial(facet, axes[2], principal.x, principal.z)))
        if self._any_biaxial:
            made.append(shares(facet, *biaxial(facet, axes, principal)))
        if len(made) == 1:
            return made[0]
        one = dr.gather(mi.Bool, self._uniaxial, stone, active)
        either: Shares = dr.select(one, *made)
        return either


class Crystal:
    """The crystal of one stone, in double precision.

    Parameters
    ----------
    indices : (3,) float64
        Principal indices relative to what surrounds the stone, in any order.
    axes : (3, 3) float64
        Rows are the axis of each in the world, unit vectors at right angles.

    Attributes
    ----------
    is_uniaxial : bool
        Whether two indices are one.
    """

    def __init__(self, indices: np.ndarray, axes: np.ndarray) -> None:
        # The optic axis comes last
        turns = [k for k in (0, 1, 2) if abs(indices[k] - indices[k - 1]) <= _ONE_INDEX * indices[k]]
        order = [(turns[0] + k) % 3 for k in (-1, 0, 1)] if turns else [0, 1, 2]
        self.is_uniaxial = bool(turns)
        # Held outside kernels: another crystal needs no other one
        self._indices = dr.opaque(mi.Vector3d, [float(x) for x in indices[order]])
        self._axes = [dr.opaque(mi.Vector3d, [float(x) for x in axes[k]]) for k in order]

    def at_facet(self, kt: mi.Vector3d, n: mi.Vector3d) -> Shares:
        """Return how a facet of an outward normal shares light whose wave vectors' part along it is `kt`."""
        facet = Facet.of(kt, n)
        if self.is_uniaxial:
            return shares(facet, *uniaxial(facet, self._axes[2], self._indices.x, self._indices.z))
        return shares(facet, *biaxial(facet, self._axes, self._indices))

    def is_second(self, at: Shares, k: mi.Vector3d, n: mi.Vector3d, second: mi.Bool) -> mi.Bool:
        """Return which of a facet's two waves outwards a wave vector belongs to, of a mode by its number."""
        if self.is_uniaxial:
            return second
        # A line may cut the outer sheet four times, next to an optic axis: then both are of it
        apart = [dr.abs(dr.dot(wave.k - k, n)) for wave in at.out]
        return dr.select(dr.abs(apart[0] - apart[1]) < _ONE_WAVE, second, apart[1] < apart[0])
